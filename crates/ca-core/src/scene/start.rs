//! The start: computes the state at load.

use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::op::links::measure;
use crate::op::{Op, Pass, pass};
use crate::state::State;
use alloc::vec::Vec;

/// Order of accuracy of the first tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Order {
    /// d₀ = v T − ½ (T²/m) F(x₀), docs/numerics.md §1.1: error of third order in one tick, of second order in speed
    Second,
    /// adds ⅙ of the change of (T²/m) F over the motion v T, the third derivative; for ticks of fourth order
    Fourth,
    /// d is the motion itself: d₀ = v T
    Exact,
}

/// Rules of a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Start {
    /// order of the first tick
    pub order: Order,
    /// true if set-valued friction holds ends that are at rest at load; before arithmetic 5 it began sliding
    pub sticks: bool,
}

/// Computes the start: x stays, and d, given as v T, becomes x₀ − x₋₁ of a motion with this position and speed at load.
///
/// The forces include implicit parts, so that from rest the tick before mirrors the tick after, at any order.
pub fn start<R: Real>(
    layout: &Layout<R>,
    forces: &[Op<R>],
    Start { order, sticks }: Start,
    mut s: State<R>,
) -> State<R> {
    let n = layout.counts.n_mat;
    let exact = order == Order::Exact;
    let memory = |s: &mut State<R>| {
        for op in forces {
            let Some((law, fns)) = op.law.zip(op.fns).filter(|(l, _)| l.mem > 0) else { continue };
            for i in 0..op.n {
                // friction that began sliding is given a motion
                let (mut e, mut w) = (layout.links.e0[op.first + i], R::of(if sticks { 0.0 } else { 1.0 }));
                for (measure, ends, reach) in measure::ports(layout, &op.ports, op.first, i) {
                    let measured = measure::measure(measure, &s.x, &s.d, ends, &reach);
                    (e, w) = (e + measured.e, w + measured.w);
                }
                let c: Vec<R> = (0..law.coefs).map(|k| s.coef[op.coef + k * op.n + i]).collect();
                (fns.start)(&c, [e, w], &mut s.links.mem[op.mem + i * law.mem..][..law.mem]);
            }
        }
    };
    for (k, p) in layout.places.moving_points.iter().enumerate() {
        s.links.cells[k] = pass::cell(layout, &s, p);
    }
    pass::sum(&Op::new(Pass::ModalPorts, pass::sum, layout.places.modal.len()), layout, &mut s);
    let project = Op::new(Pass::Points, pass::project, layout.places.moving_points.len());
    pass::project(&project, layout, &mut s);
    memory(&mut s);
    let counts = |op: &&Op<R>| !exact && !matches!(op.name(), "TGR out" | "ledger of the border" | "TGR mute" | "ENF");
    // the change of motion that a tick makes of a state
    let change = |s: &State<R>| -> Vec<R> {
        let mut trial = s.clone();
        for op in forces.iter().filter(counts) {
            (op.kernel)(op, layout, &mut trial);
        }
        let of = |i: usize| {
            let (p, q, c) = (s.coef[i], s.coef[n + i], s.coef[2 * n + i]);
            c * trial.f[i] + q * s.x[i] - (R::of(1.0) - p) * s.d[i]
        };
        (0..n).map(of).collect()
    };
    let more = (order == Order::Fourth).then(|| {
        // half a tick of the motion each way, without motion that dampers would resist
        let [ahead, behind] = [R::of(0.5), -R::of(0.5)].map(|share| {
            let mut at = s.clone();
            for (x, d) in at.x.iter_mut().zip(&mut at.d) {
                *x += share * *d;
                *d = R::ZERO;
            }
            change(&at)
        });
        ahead.into_iter().zip(behind).map(|(a, b)| (a - b) / R::of(6.0)).collect::<Vec<R>>()
    });
    let second = change(&s);
    let moved = |i: usize| layout.ports.enx.iter().any(|p| p.implicit && p.mat as usize == i);
    for i in 0..n {
        if s.coef[2 * n + i] == R::ZERO {
            s.d[i] = if moved(i) { s.d[i] } else { R::ZERO };
        } else if !exact {
            s.d[i] -= R::of(0.5) * second[i];
            s.d[i] += more.as_ref().map_or(R::ZERO, |m| m[i]);
        }
    }
    pass::sum(&Op::new(Pass::ModalPorts, pass::sum, layout.places.modal.len()), layout, &mut s);
    pass::project(&project, layout, &mut s);
    s
}
