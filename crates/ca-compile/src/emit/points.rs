//! Moving points and modal masses as the tick reads them, and the mobility of modal masses.
//!
//! The mobility of a modal mass, and the coupling of several in a group, are computed once, since modes do not follow
//! live parameters. Only masses with a link that is solved with the coming motion have them.

use crate::emit::layout_builder::LayoutBuilder;
use crate::net::{Coordinate, End};
use alloc::collections::BTreeSet;
use alloc::vec::Vec;
use ca_core::internal::op::layout::{CoordinateSource, Modal, ModalCoupling, MovingPoint, SolvedModal};

/// Moving points and modal masses, laid out.
#[derive(Default)]
pub struct Points {
    /// Slots of the MATs under moving points.
    pub nodes: Vec<u32>,
    /// Moving points.
    pub moving: Vec<MovingPoint>,
    /// Modal masses.
    pub modal: Vec<Modal>,
    /// Shares of modal masses in the modes.
    pub shares: Vec<f64>,
    /// True if a moving point moves.
    pub aimed: bool,
}

/// Lays out moving points and modal masses.
pub fn points(builder: &mut LayoutBuilder) -> Points {
    let net = builder.net;
    let mut all = Points::default();
    for (i, p) in net.points.iter().enumerate() {
        let mat = builder.point[i];
        if mat == u32::MAX {
            continue;
        }
        let family = net.families.of(&p.family);
        if let Some((weights, _)) = &p.shape {
            // Modes are not linked, so their slots are consecutive.
            let first = family.nodes.first().map_or(0, |mode| builder.slot[*mode as usize]);
            let (share, n) = (all.shares.len() as u32, weights.len() as u32);
            all.shares.extend(weights);
            all.modal.push(Modal { mat, first, share, n });
            continue;
        }
        let first = all.nodes.len() as u32;
        all.nodes.extend(family.nodes.iter().map(|m| builder.slot[*m as usize]));
        let mut at = [CoordinateSource::Coef(0); 2];
        for (k, c) in p.at.iter().enumerate() {
            at[k] = match c {
                Coordinate::Port(m) => CoordinateSource::Mat(builder.slot[*m as usize]),
                Coordinate::At(v) => builder.coordinate(*v, None),
                Coordinate::Live(q) => builder.coordinate(net.params[*q as usize].value, Some(*q)),
            };
            all.aimed |= !matches!(c, Coordinate::At(_));
        }
        all.moving.push(MovingPoint { mat, first, size: family.size, at });
    }
    all
}

/// Modal masses with links that are solved with the coming motion.
#[derive(Default)]
pub struct Solved {
    /// Masses, group by group.
    pub list: Vec<SolvedModal>,
    /// Groups with several such masses.
    pub groups: Vec<ModalCoupling>,
    /// Coupling matrices of these groups.
    pub couplings: Vec<f64>,
}

/// Finds these masses and sets the mobility of their slots; `tap` is the first free temporary number.
pub fn solved(builder: &mut LayoutBuilder, n_mat: usize, tap: usize, (modal, shares): (&[Modal], &[f64])) -> Solved {
    let staged = builder.net.lias.iter().filter(|l| !l.law.stage.is_explicit()).flat_map(|l| l.ends);
    let held: BTreeSet<u32> = staged.filter(|e| matches!(e, End::Point(_))).map(|e| builder.at(e)).collect();
    let mut list: Vec<usize> = (0..modal.len()).filter(|i| held.contains(&modal[*i].mat)).collect();
    list.sort_by_key(|i| modal[*i].first);
    let mut all = Solved::default();
    for group in list.chunk_by(|a, b| modal[*a].first == modal[*b].first) {
        let moves = |p: usize, r: usize, coef: &[f64]| -> f64 {
            let [p, r] = [p, r].map(|i| &modal[i]);
            let of = |m: &Modal| &shares[m.share as usize..][..m.n as usize];
            let mobility = &coef[2 * n_mat + p.first as usize..];
            of(p).iter().zip(of(r)).zip(mobility).map(|((p, r), c)| p * r * c).sum()
        };
        let (first, numbers) = (all.list.len() as u32, all.couplings.len() as u32);
        for p in group {
            let mat = modal[*p].mat;
            let tap = (tap + all.list.len() * SolvedModal::TAPS) as u32;
            all.list.push(SolvedModal { modal: *p as u32, mat, tap });
            let own = moves(*p, *p, &builder.coef);
            (builder.coef[mat as usize], builder.coef[2 * n_mat + mat as usize]) = (1.0, own);
            if group.len() > 1 {
                // At a node of all modes nothing moves.
                let part = |r: &usize| if own > 0.0 { moves(*p, *r, &builder.coef) / own } else { 0.0 };
                all.couplings.extend(group.iter().map(part));
            }
        }
        if group.len() > 1 {
            all.groups.push(ModalCoupling { first, n: group.len() as u32, numbers });
        }
    }
    all
}
