//! High-passes of outputs: which outputs have one, and its coefficients. Only this module decides on cut-offs.

use crate::net::{OutNode, Pruned};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::vec::Vec;
use ca_core::Unit;
use ca_core::internal::io::Hear;
use ca_core::internal::op::layout::DcBlocker;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::show;
use ca_model::{Model, Span};
use core::f64::consts::PI;

/// Default cut-off \[Hz\]: the stretch of a spinning body is far larger than its sound, and as slow as a gesture
/// (docs/numerics.md §4.3).
const FED: f64 = 7.0;

/// Returns the cut-off \[Hz\] of an output: as written, unless 0. The default is none, except for outputs that a body
/// in space feeds through a quadripole.
fn cutoff(net: &Pruned, o: &OutNode) -> Option<f64> {
    let item = &net.items[o.item? as usize];
    let written = item.kind.param("dc").and_then(|i| item.args[i].num());
    let own = || Some(FED).filter(|f| net.reads_lpr(o) && f * net.tick_dt < 0.5);
    written.or_else(own).filter(|f| *f > 0.0)
}

/// Returns whether an output has a filter.
fn is_passed(net: &Pruned, o: &OutNode) -> bool {
    o.quantity == Hear::Acceleration || cutoff(net, o).is_some()
}

fn moves(o: &OutNode) -> bool {
    matches!(o.quantity, Hear::Speed | Hear::Acceleration)
}

/// Returns the outputs in the order of [`OutputArrays::outputs`](ca_core::internal::op::layout::OutputArrays::outputs):
/// without a high-pass, by channel; of motion; then both with a high-pass.
pub fn plain_first(net: &Pruned) -> impl Iterator<Item = &OutNode> {
    let (plain, passed): (Vec<&OutNode>, Vec<_>) = net.outs.iter().partition(|o| !is_passed(net, o));
    let (motion, mut plain): (Vec<&OutNode>, Vec<_>) = plain.into_iter().partition(|o| moves(o));
    plain.sort_by_key(|o| o.channel);
    plain.into_iter().chain(motion).chain(still_first(passed))
}

fn still_first(passed: Vec<&OutNode>) -> impl Iterator<Item = &OutNode> {
    let (motion, still): (Vec<&OutNode>, Vec<_>) = passed.into_iter().partition(|o| moves(o));
    still.into_iter().chain(motion)
}

/// Returns the number of outputs of motion, without and with a high-pass.
pub fn of_motion(net: &Pruned) -> [usize; 2] {
    let all = net.outs.iter().filter(|o| moves(o));
    let passed = all.clone().filter(|o| is_passed(net, o)).count();
    [all.count() - passed, passed]
}

/// Returns the high-passes in that order. They are bilinear, so −3 dB exactly at the cut-off. For an acceleration the
/// filter is the difference of the motion itself.
pub fn blockers(model: &Model, net: &Pruned, diags: &mut Diags) -> Vec<DcBlocker> {
    let mut reported = BTreeSet::new();
    let mut all = Vec::new();
    for o in still_first(net.outs.iter().filter(|o| is_passed(net, o)).collect()) {
        let Some(f) = cutoff(net, o).filter(|_| o.quantity != Hear::Acceleration) else {
            all.push(DcBlocker { r: 0.0, g: 1.0 });
            continue;
        };
        if f * net.tick_dt >= 0.5 && o.item.is_some_and(|i| reported.insert(i)) {
            diags.push(too_high(model, net, o, f));
        }
        let t = libm::tan(PI * f * net.tick_dt);
        all.push(DcBlocker { r: (1.0 - t) / (1.0 + t), g: 1.0 / (1.0 + t) });
    }
    all
}

fn too_high(model: &Model, net: &Pruned, o: &OutNode, f: f64) -> Diag {
    let item = o.item.map(|i| &model.items[net.items[i as usize].model]);
    let span = item.and_then(|i| i.args.iter().find(|e| e.key == "dc")).map_or(Span::NONE, |e| e.span);
    let name = item.map_or(&o.name, |i| &i.name);
    let title = format!("`dc` of `{name}`: {} is not below half the sound rate", show(f, Unit::HERTZ));
    Diag::error("E023", title)
        .at(span, "too high")
        .help("use a lower value: `\"7 Hz\"` or less removes the steady part")
}
