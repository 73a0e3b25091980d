//! Verifies groups at the gesture rate: their passes, and the MATs that they share with the sound side.

use super::links::Work;
use super::passes::{counts, passes};
use super::{Verified, block, each, ensure};
use crate::op::Pass;
use crate::op::layout::{Copied, Layout, SlowGroup};
use crate::scene::bind::listed;

/// Verifies a group. Its layout, and `layout`, have been verified; its state has `inputs` inputs.
pub(in super::super) fn group(group: &SlowGroup, layout: &Layout, inputs: usize) -> Verified {
    let own = &group.layout;
    let mut work = Work::of(own);
    let lists = [&group.reads, &group.forces, &group.after, &group.moves];
    for list in [&group.reads, &group.forces, &group.after] {
        passes(list, listed, own, &mut work)?;
    }
    passes(&group.moves, |form| form, own, &mut work)?;
    let alone = |pass: Pass| !counts(pass) && pass != Pass::Inputs;
    ensure(lists.into_iter().flatten().all(|op| alone(op.pass)), "a frame of a group has several ticks")?;
    let copied = |p: &Copied| (p.own as usize) < own.counts.n_mat && (p.at as usize) < layout.counts.n_mat;
    let ports = group.ports.iter().chain(&group.shown).all(copied);
    ensure(ports, "a place of a group is beyond the masses")?;
    let coupled = group.coupled;
    ensure(coupled <= group.ports.len() && coupled <= inputs, "links use more places of a group than there are")?;
    let response = &group.response;
    let width = response.places.len().checked_mul(2).and_then(|n| n.checked_add(1));
    let known = width.is_some_and(|width| block(0, coupled, width, response.known.len()));
    let answer = block(0, coupled, coupled, response.answer.len());
    let places = each(&response.places, layout.counts.n_mat);
    ensure(known && answer && places, "the response of the sound to a group uses numbers that do not exist")
}
