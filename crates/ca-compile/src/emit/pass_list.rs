//! Pass list: the passes of a tick, in order. A pass exists only if the scene needs it. `schedule` computes the places of
//! links in the list of [`forces`] from the same order.

use crate::emit::cost;
use crate::emit::layout_builder::LayoutBuilder;
use crate::net::MatRole;
use alloc::collections::BTreeSet;
use alloc::vec::Vec;
use ca_core::internal::op::layout::{Layout, Output, OutputRow, Tap};
use ca_core::internal::op::{Op, Pass, SolveStage, pass};

/// Returns the passes before the forces: ports, ledger of the previous tick, changes, moving points.
pub fn reads(layout: &Layout, live: usize, aimed: bool) -> Vec<Op> {
    let kept = layout.ledger.is_some();
    let points = layout.places.moving_points.len();
    let modules = layout.counts.n_mat + layout.counts.n_lia;
    let modal = layout.places.modal.len();
    let list: [(bool, Pass, usize); 11] = [
        (!layout.ports.enx.is_empty(), Pass::Enx, layout.ports.enx.len()),
        (
            !layout.ports.tgr.is_empty(),
            Pass::DevicesIn(layout.border_method(), layout.ports.crossing.latency > 0),
            layout.ports.tgr.len(),
        ),
        (!layout.ports.ahead.is_empty(), Pass::Ahead, layout.ports.ahead.len()),
        (modal > 0, Pass::ModalPorts, modal),
        // The ledger checks for pending changes.
        (!layout.ports.driven.is_empty(), Pass::Driven, layout.ports.driven.iter().map(|d| d.places.len()).sum()),
        // The ledger needs the points of the previous tick.
        (kept && points > 0, Pass::Points, points),
        (kept, Pass::Ledger, modules),
        (live > 0, Pass::Changes, live),
        (aimed, Pass::Aim, points),
        (points > 0 && (!kept || aimed), Pass::Points, points),
        (kept && (live > 0 || aimed), Pass::LedgerOfChanges, modules),
    ];
    list.into_iter().filter(|p| p.0).map(|(_, pass, n)| Op::pass(pass, n)).collect()
}

/// Returns the passes that sum forces: external forces in space, weight, waves, links, external forces on a line, and
/// transfers of forces. Links from `late` on need all of these.
///
/// External forces on a line follow the links, so that a row of links that integrates its masses can add them. The
/// first `in_space` of `layout.enf` are in space, where no row does so. With `sweeps`, curves that are solved together are
/// first solved one by one.
pub fn forces(
    layout: &Layout,
    mut links: Vec<Op>,
    late: usize,
    weight: usize,
    in_space: usize,
    sweeps: bool,
) -> Vec<Op> {
    let mut list = Vec::new();
    let enf = |first: usize, n: usize| Op { first, ..Op::pass(Pass::Enf { counted: true }, n) };
    if in_space > 0 {
        list.push(enf(0, in_space));
    }
    if !layout.weighed.is_empty() {
        list.push(Op { coef: weight, ..Op::pass(Pass::Weight, layout.weighed.len()) });
    }
    if !layout.waves.delays.is_empty() {
        list.push(Op::pass(Pass::WavesIn, layout.waves.delays.len()));
    }
    let late = links.split_off(late);
    list.extend(links);
    if in_space < layout.ports.enf.len() {
        list.push(enf(in_space, layout.ports.enf.len() - in_space));
    }
    if !layout.places.moving_points.is_empty() {
        list.push(Op::pass(Pass::PointsBack, layout.places.moving_points.len()));
    }
    if !layout.places.modal.is_empty() {
        list.push(Op::pass(Pass::Modes, layout.places.modal.len()));
    }
    if let Some(a) = &layout.implicit {
        let (places, pairs) = (a.places.len(), a.pairs.len());
        if places > 0 {
            list.push(Op::pass(Pass::Implicit, places));
        }
        if pairs > 0 {
            let coef = a.coef + a.pattern.numbers() + places;
            list.push(Op { coef, ..Op::pass(Pass::ImplicitPairs, pairs) });
        }
    }
    let stages = || late.iter().filter_map(|o| Some(o.law?.stage));
    let together = stages().any(|stage| matches!(stage, SolveStage::Coupled(_)));
    let sweeps = sweeps && stages().any(|stage| matches!(stage, SolveStage::Coupled(c) if c.curve));
    let solved = layout.places.solved_modal.len();
    if solved > 0 {
        list.push(Op::pass(Pass::ModesAhead, solved));
    }
    list.extend(late);
    let modes = !layout.places.modal_couplings.is_empty();
    list.extend(together.then(|| Op::pass(Pass::Contacts { modes, sweeps }, layout.counts.n_touch)));
    if solved > 0 {
        list.push(Op::pass(Pass::ModesAgain, solved));
    }
    let (keys, kept, feedback) = (layout.ports.tgr.len(), layout.ledger.is_some(), layout.ports.crossing.feedback);
    let aside = keys > 0 && kept && !feedback;
    if aside {
        list.push(Op::pass(Pass::Mute, keys));
    }
    if keys > 0 && (feedback || kept) {
        list.push(Op::pass(Pass::DevicesOut(layout.border_method()), keys));
    }
    if keys > 0 && kept {
        list.push(Op::pass(Pass::LedgerOfBorder(layout.border_method()), keys));
    }
    if aside {
        list.push(Op::pass(Pass::Mute, keys));
    }
    if layout.ledger.is_some() {
        list.push(Op::pass(Pass::LedgerOfForces, layout.counts.n_mat));
    }
    list
}

/// Returns the rows of channels with many outputs, see [`OutputArrays::output_rows`].
pub fn output_rows(layout: &Layout) -> Vec<OutputRow> {
    let plain = &layout.out.outputs[..layout.out.outputs.len() - layout.out.blockers.len() - layout.out.of_motion[0]];
    let channels = || plain.chunk_by(|a, b| a.channel == b.channel);
    if channels().all(|of_channel| of_channel.len() < pass::MANY) {
        return Vec::new();
    }
    let row = |of_channel: &[Output]| {
        let Tap::Position(first) = of_channel[0].tap else { return None };
        let follows = |(i, o): (usize, &Output)| o.tap == Tap::Position(first + i as u32);
        (of_channel.len() >= pass::MANY && of_channel.iter().enumerate().all(follows)).then_some(first)
    };
    let outputs = |of_channel: &[Output]| OutputRow {
        channel: of_channel[0].channel,
        n: of_channel.len() as u32,
        first: row(of_channel),
    };
    channels().map(outputs).collect()
}

/// Returns the passes of outputs; `gains` is the first coefficient.
pub fn writes(layout: &Layout, gains: usize) -> Vec<Op> {
    let high = layout.out.blockers.len();
    let [motion, passed] = layout.out.of_motion;
    let plain = layout.out.outputs.len() - high - motion;
    let again = layout.out.links.len();
    let position = |(i, o): (usize, &Output)| o.channel as usize == i && matches!(o.tap, Tap::Position(_));
    let each = layout.out.outputs.len() == layout.counts.n_out && layout.out.outputs.iter().enumerate().all(position);
    let outputs = match () {
        () if each && high + motion == 0 => Pass::Positions,
        () if layout.out.output_rows.is_empty() => Pass::Outputs,
        () => Pass::ManyOutputs,
    };
    let list = [
        (again > 0, Pass::OutputLinks, again, 0),
        // It clears the channels to which the other passes add.
        (plain + motion + high > 0, outputs, plain, 0),
        (motion > 0, Pass::Motions, motion, plain),
        (high > passed, Pass::HighPass, high - passed, plain + motion),
        (passed > 0, Pass::HighPassOfMotion, passed, layout.out.outputs.len() - passed),
        (!layout.out.lowpass.is_empty(), Pass::LowPass, layout.counts.channels, 0),
    ];
    let op = |(_, pass, n, first)| Op { first, coef: gains + first, ..Op::pass(pass, n) };
    list.into_iter().filter(|p| p.0).map(op).collect()
}

/// Integration of the number in a slot.
#[derive(PartialEq, Clone, Copy)]
pub enum Class {
    /// By forces only.
    Free,
    /// By its own spring and damper too.
    Full,
    /// Set by a port.
    Held,
}

impl LayoutBuilder<'_> {
    /// Returns the class of each slot for MATs in this order; `None` for slots that do not move.
    pub fn classes(&self, order: &[u32], n_mat: usize) -> Vec<Option<Class>> {
        let live: BTreeSet<u32> = self.live.iter().copied().collect();
        let mut classes: Vec<Option<Class>> = Vec::new();
        for m in order {
            let m = &self.net.mats[*m as usize];
            for k in 0..m.slots() as usize {
                let at = classes.len();
                classes.push(match m.role {
                    MatRole::Port(_, inputs) if inputs[k].is_some() => Some(Class::Held),
                    MatRole::Slow => Some(Class::Held),
                    MatRole::Mat(s) if !s.fixed && k < m.axes as usize => {
                        let own = self.coef[at] != 1.0 || self.coef[n_mat + at] != 0.0 || live.contains(&(at as u32));
                        Some(if own { Class::Full } else { Class::Free })
                    }
                    // A fixed point or a frozen axis.
                    _ => None,
                });
            }
        }
        classes
    }
}

/// Merges stretches of MAS into the pass of adjacent CELs where that costs less ([`cost`]). With P = 1 and Q = 0 the
/// bits are the same.
pub fn merged(moves: Vec<Op>) -> Vec<Op> {
    let full = |op: &Op| op.pass == Pass::IntegrateFull;
    let short = |op: &Op| op.pass == Pass::IntegrateFree && cost::merges(op.n);
    let mut all: Vec<Op> = Vec::with_capacity(moves.len());
    for op in moves {
        match all.last_mut() {
            Some(before) if before.mat + before.n == op.mat => {
                let both = [&*before, &op];
                if both.iter().all(|o| full(o) || short(o)) && both.iter().any(|o| full(o)) {
                    *before = Op { mat: before.mat, n: before.n + op.n, ..if full(before) { *before } else { op } };
                } else {
                    all.push(op);
                }
            }
            _ => all.push(op),
        }
    }
    all
}

/// Gives slots that do not move the class of a neighbour: an unneeded integration costs less than two stretches.
pub fn fill_classes(classes: &mut [Option<Class>]) {
    for i in 1..classes.len() {
        classes[i] = classes[i].or(classes[i - 1].filter(|c| *c != Class::Held));
    }
    for i in (1..classes.len()).rev() {
        classes[i - 1] = classes[i - 1].or(classes[i].filter(|c| *c != Class::Held));
    }
}

/// Returns the integration passes: stretches of one class, except for ports, then the waves that leave on `ways`. Also
/// returns whether some MAT has its own spring or damper.
pub fn moves(classes: &[Option<Class>], n_mat: usize, ways: usize) -> (Vec<Op>, bool) {
    let mut ops = Vec::new();
    let mut at = 0;
    for stretch in classes.chunk_by(|a, b| a == b) {
        let first = at;
        at += stretch.len();
        let pass = match stretch[0] {
            Some(Class::Held) => continue,
            Some(Class::Full) => Pass::IntegrateFull,
            // An isolated fixed point does not move, but the force on it is reset in each tick.
            Some(Class::Free) | None => Pass::IntegrateFree,
        };
        ops.push(Op { mat: first, ..Op::pass(pass, stretch.len()) });
    }
    if ways > 0 {
        ops.push(Op::pass(Pass::WavesOut, ways));
    }
    if !classes.is_empty() {
        ops.push(Op::pass(Pass::Flush, n_mat));
    }
    (ops, classes.contains(&Some(Class::Full)))
}
