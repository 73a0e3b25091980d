//! Verifies passes: the range of each over its array, and how they count time.

use super::links::{self, Work};
use super::{Verified, Wrong, each, ensure, in_bounds};
use crate::method::pefrl::{DRIFTS, KICKS};
use crate::op::layout::{Layout, Substeps};
use crate::op::{Form, Op, Pass};
use crate::scene::Scene;
use crate::scene::bind::listed;

/// Largest number of ticks per sample that is accepted.
const TICKS: u32 = 1 << 12;

/// Verifies all passes of a scene except those of its group.
pub(super) fn scene(scene: &Scene) -> Verified {
    let l = &scene.layout;
    let mut work = Work::of(l);
    ensure(scene.passes.fused <= scene.passes.forces.len(), "more passes are left to integration than there are")?;
    for list in [&scene.passes.reads, &scene.passes.forces, &scene.passes.writes] {
        passes(list, listed, l, &mut work)?;
    }
    passes(&scene.passes.moves, |form| form, l, &mut work)?;
    if let Some(before) = &scene.before {
        passes(&before.forces, listed, l, &mut work)?;
    }
    if let Some(Substeps { times, tick, inputs }) = &l.rates.substeps {
        ensure((1..=TICKS).contains(times), "a sample has 0 ticks, or too many")?;
        ensure(super::each(inputs, scene.inputs.len()), "a sample uses an input that does not exist")?;
        passes(tick, |form| form, l, &mut work)?;
        ensure(!tick.iter().any(|op| counts(op.pass)), "a tick between samples counts samples")?;
    }
    if let Some(ledger) = &l.ledger {
        let accounts = ledger.accounts.iter().all(|a| a.op < scene.passes.forces.len());
        ensure(accounts, "an account belongs to a pass that does not exist")?;
    }
    let tick = [&scene.passes.reads[..], scene.passes.summed(), &scene.passes.writes, &scene.passes.moves]
        .into_iter()
        .flatten();
    let listed =
        scene.passes.forces[scene.passes.summed().len()..].iter().chain(scene.before.iter().flat_map(|b| &b.forces));
    ensure(!listed.into_iter().any(|op| counts(op.pass)), "a sum of forces counts time")?;
    time(tick)
}

pub(super) fn passes(list: &[Op], form: fn(Form) -> Form, l: &Layout, work: &mut Work) -> Verified {
    list.iter().try_for_each(|op| match op.law {
        Some(law) => links::pass(op, law, form(op.form), l, work),
        None => other(op, l),
    })
}

/// Returns true for passes that change how a state counts.
pub(super) fn counts(pass: Pass) -> bool {
    matches!(pass, Pass::Between | Pass::ToTicks | Pass::ToSamples)
}

/// Verifies that a tick begins and ends in samples; otherwise the count would be multiplied at each.
fn time<'a>(tick: impl Iterator<Item = &'a Op>) -> Verified {
    let mut in_ticks = false;
    for op in tick.filter(|op| counts(op.pass)) {
        let to_ticks = op.pass != Pass::ToSamples;
        ensure(in_ticks != to_ticks, "samples are counted as ticks")?;
        in_ticks = to_ticks;
    }
    ensure(!in_ticks, "samples are counted as ticks")
}

fn other(op: &Op, l: &Layout) -> Verified {
    let &Op { pass, n, first, mat, coef, .. } = op;
    let all = |len: usize| n <= len;
    let numbers = |n: usize| in_bounds(coef, n, l.counts.n_coef);
    let outputs = |n: usize| in_bounds(first, n, l.out.outputs.len());
    let fits = match pass {
        Pass::Links => return Err(Wrong("the law of a pass of links is missing")),
        Pass::Enx => all(l.ports.enx.len()),
        Pass::DevicesIn(_, late) => all(l.ports.tgr.len()) && (!late || l.ports.crossing.latency > 0),
        Pass::DevicesOut(_) | Pass::LedgerOfBorder(_) | Pass::Mute => all(l.ports.tgr.len()),
        Pass::Ahead => all(l.ports.ahead.len()) && each(&l.ports.ahead, l.counts.n_mat),
        Pass::ModalPorts | Pass::Modes => all(l.places.modal.len()),
        Pass::Points | Pass::Aim | Pass::PointsBack => all(l.places.moving_points.len()),
        Pass::Enf { .. } => in_bounds(first, n, l.ports.enf.len()),
        Pass::Weight => all(l.weighed.len()) && numbers(n),
        Pass::ImplicitPairs | Pass::Positions => numbers(0),
        Pass::ModesAhead | Pass::ModesAgain => all(l.places.solved_modal.len()),
        // a state without contacts has no array of pushes
        Pass::Contacts { modes: true, .. } => {
            l.counts.n_touch > 0 || (l.places.modal_couplings.is_empty() && l.places.solved_modal.is_empty())
        }
        Pass::Group { compensated } | Pass::GroupOut { compensated } => {
            l.rates.slow.as_ref().is_none_or(|group| group.compensated == compensated)
        }
        Pass::OutputLinks => all(l.out.links.len()),
        Pass::Outputs => all(l.out.outputs.len()) && numbers(n),
        Pass::ManyOutputs => {
            let of_rows: u64 = l.out.output_rows.iter().map(|row| u64::from(row.n)).sum();
            all(l.out.outputs.len()) && numbers(n) && of_rows <= n as u64
        }
        Pass::Motions => outputs(n) && numbers(0),
        Pass::HighPass | Pass::HighPassOfMotion => all(l.out.blockers.len()) && outputs(0) && numbers(n),
        Pass::LowPass | Pass::Remember => all(l.counts.channels),
        Pass::IntegrateFree | Pass::IntegrateFull => in_bounds(mat, n, l.counts.n_mat),
        Pass::Flush => all(l.counts.n_mat),
        Pass::Drift => all(l.counts.n_mat) && first < DRIFTS.len(),
        Pass::Kick { .. } => all(l.counts.n_mat) && first < KICKS.len(),
        Pass::Inputs => l.rates.substeps.as_ref().is_none_or(|substeps| all(substeps.inputs.len())),
        Pass::Driven
        | Pass::Ledger
        | Pass::Changes
        | Pass::LedgerOfChanges
        | Pass::WavesIn
        | Pass::WavesOut
        | Pass::Implicit
        | Pass::Contacts { modes: false, .. }
        | Pass::LedgerOfForces
        | Pass::Between
        | Pass::ToTicks
        | Pass::ToSamples => true,
    };
    ensure(fits, "a pass runs beyond an array")
}
