//! `start = "mi.lib"`: the first two samples as in mi.lib, so that an imported model begins exactly like the original.
//!
//! `dx0` is then the displacement one sample before the first, and `v` the change in that sample. In mi.lib
//! - the step to the first sample includes only the own spring and the weight of a module, no link;
//! - in the first sample, links take the sum of the positions now and two samples before as the speed of an end (the
//!   initial delayed position is added instead of subtracted), which is twice the position for a fixed point.
//!
//! The first step is computed at load. The second effect is a force in the first tick that depends on positions only.
//! It is stored in the sum of forces, to which the first tick adds, and the ledger counts its work as a change. A start
//! speed with the same effect does not always exist: where viscosity ends all motion within a tick, no speed is left.
//!
//! One difference remains: for a contact that touches in the first sample, mi.lib takes the threshold as part of the
//! speed. The importer reports such contacts.

use crate::net::Pruned;
use alloc::vec::Vec;
use ca_core::State;
use ca_core::internal::op::Op;
use ca_core::internal::op::layout::Layout;
use ca_core::internal::scene::{Order, Start, start};
use ca_core::internal::state::set_kick;
use ca_model::Model;
use ca_model::diag::{Diag, Diags};

/// Refuses this start if the first tick is not a plain step of the explicit scheme, since mi.lib has only such steps.
pub fn check(model: &Model, net: &Pruned, layout: &Layout, forces: &[Op], diags: &mut Diags) {
    let Some(e) = model.meta("start").filter(|_| net.as_milib) else { return };
    let what = if net.is_composed()
        || layout.implicit.is_some()
        || forces.iter().any(|op| op.law.is_some_and(|l| l.implicit || !l.stage.is_explicit()))
    {
        "a method other than `ca`"
    } else if net.oversample > 1 {
        "`oversample`"
    } else if !layout.waves.delays.is_empty() || !layout.places.modal.is_empty() {
        "a waveguide or a set of modes"
    } else {
        return;
    };
    let d = Diag::error("E010", alloc::format!("`start = \"mi.lib\"` and {what} exclude each other"));
    diags.push(
        d.at(e.span, "mi.lib does not support this")
            .help("leave out `start`: `dx0` and `v` are then position and speed at the start"),
    );
}

/// Returns the state at the first sample from the written values for the two samples before.
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
