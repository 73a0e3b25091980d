//! `start = "mi.lib"`: the first two samples as mi.lib has them, so that an imported model begins exactly as its peer.
//!
//! `dx0` is then where a module is one sample before the first, `v` how far it came in that sample. What mi.lib does:
//! - in the step to the first sample only a module's own spring and its weight act, no link;
//! - in the first sample a link takes for the speed of an end the sum of its position now and two samples before (the
//!   initial delayed position is added where it should be taken away), a fixed point's being twice its position.
//!
//! The first is done here, at load. The second is a force in the first tick that hangs on positions alone, so it is
//! left in the sum of forces that the first tick adds to; the energy ledger counts its work as a change. A start speed
//! that had the same effect does not always exist: where viscosity ends all motion within a tick, no speed is left.
//!
//! One thing stays different: the threshold of a contact that touches in the first sample, which mi.lib takes for a
//! part of the speed. The import says where that is so.

use crate::net::Pruned;
use alloc::vec::Vec;
use ca_core::State;
use ca_core::internal::op::Op;
use ca_core::internal::op::layout::Layout;
use ca_core::internal::scene::{Order, Start, start};
use ca_core::internal::state::set_kick;
use ca_model::Model;
use ca_model::diag::{Diag, Diags};

/// Refuses the start where the first tick is not the explicit scheme's: there is nothing to compare it with.
pub fn check(model: &Model, net: &Pruned, layout: &Layout, forces: &[Op], diags: &mut Diags) {
    let Some(e) = model.meta("start").filter(|_| net.as_milib) else { return };
    let what = if net.is_composed()
        || layout.implicit.is_some()
        || forces.iter().any(|op| op.law.is_some_and(|l| l.implicit || !l.stage.is_explicit()))
    {
        "another method than `ca`"
    } else if net.oversample > 1 {
        "`oversample`"
    } else if !layout.waves.delays.is_empty() || !layout.places.modal.is_empty() {
        "a waveguide or a set of modes"
    } else {
        return;
    };
    let d = Diag::error("E010", alloc::format!("`start = \"mi.lib\"` and {what} exclude each other"));
    diags.push(
        d.at(e.span, "mi.lib has no such thing").help("leave `start` out: `dx0` and `v` are then those at the start"),
    );
}

/// The state at the first sample, from what is written for the two before.
pub fn first(layout: &Layout, forces: &[Op], begin: Start, written: State) -> State {
    let n = layout.counts.n_mat;
    let mut s = written;
    let delayed: Vec<f64> =
        (0..n).map(|i| layout.places.rest[i] + s.x[i] - if s.coef[2 * n + i] == 0.0 { 0.0 } else { s.d[i] }).collect();
    for op in forces.iter().filter(|op| op.name() == "weight") {
        (op.kernel)(op, layout, &mut s);
    }
    for i in 0..n {
        let (p, q, c) = (s.coef[i], s.coef[n + i], s.coef[2 * n + i]);
        if c != 0.0 {
            s.d[i] = p * s.d[i] + q * s.x[i] + c * s.f[i];
            s.x[i] += s.d[i];
        }
        s.f[i] = 0.0;
    }
    let mut s = start(layout, forces, Start { order: Order::Exact, ..begin }, s);
    let forces_at = |speed: &dyn Fn(usize) -> f64| {
        let mut trial = s.clone();
        for i in 0..n {
            trial.d[i] = speed(i);
        }
        for op in forces.iter().filter(|op| op.law.is_some() || matches!(op.name(), "points back" | "modes")) {
            (op.kernel)(op, layout, &mut trial);
        }
        trial.f
    };
    let (right, theirs) = (forces_at(&|i| s.d[i]), forces_at(&|i| layout.places.rest[i] + s.x[i] + delayed[i]));
    for i in (0..n).filter(|i| s.coef[2 * n + i] != 0.0) {
        s.f[i] = theirs[i] - right[i];
    }
    if let Some(l) = &mut s.ledger {
        set_kick(l, s.f.to_vec());
    }
    s
}
