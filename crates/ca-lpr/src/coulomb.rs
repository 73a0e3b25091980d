//! Set-valued Coulomb friction across two worlds (docs/numerics.md §3.5, §4.1).
//!
//! While a link sticks, the sum of its two motions is zero. [`coulomb`] of the core acts on the gradient of both ports,
//! b = (−u, u, −1, 1): r is the next change of b·x by all other forces, c = Σ b² T²/m the mobility of all four ends,
//! and F = r/c cancels r. A port in space has its direction at the tick; if it turns, a motion of second order remains
//! after the tick, and heat of that order. No method solves links of four ends together with others, so the compiler
//! refuses a mass that two such links share.

use ca_core::internal::method::coulomb::{self, MEM, hold};
use ca_core::internal::method::{free_motion, mobility};
use ca_core::internal::op::layout::Layout;
use ca_core::internal::op::links::measure::{Elongation, Line, Measure, Radial};
use ca_core::internal::op::{Form, Kernel, LawEntry, LawFns, MeasureKind, Op, SolveStage, Together};
use ca_core::internal::phi;
use ca_core::{Law, Real, State};

/// Law for `curve = "coulomb"` with `method = "set-valued"`.
pub static LAW: Law = Law {
    code: "LPR_BOW set-valued",
    stage: SolveStage::Single(Together::same(&LAW)),
    fns: LawFns { kernel, ..phi::bow::SET_VALUED.fns },
    ..phi::bow::SET_VALUED
};

/// Returns the functions of [`LAW`] over `R`.
pub fn laws<R: Real>() -> [LawEntry<R>; 1] {
    [(LAW.code, LawFns { kernel, ..coulomb::fns(LawFns::of::<phi::bow::SetValued, 3, 0>()) })]
}

fn kernel<R: Real>(form: Form) -> Kernel<R> {
    match (form.measure, form.onto) {
        (MeasureKind::Line, _) => rub::<R, Line, Line>,
        (_, Some(MeasureKind::Radial)) => rub::<R, Radial, Radial>,
        _ => rub::<R, Radial, Line>,
    }
}

fn rub<R: Real, A: Measure, B: Measure>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some((_, onto, far)) = op.ports.onto else { return };
    for i in 0..op.n {
        let [most, sliding]: [R; 2] = core::array::from_fn(|k| s.coef[op.coef + k * op.n + i]);
        let (first, second) = (layout.links.ends[op.first + i], layout.links.onto[onto + i]);
        let (first, second) = (first.map(|m| m as usize), second.map(|m| m as usize));
        let a = Port::of::<A>(layout, s, first, op.ports.reach + i);
        let b = Port::of::<B>(layout, s, second, far + i);
        let mem = op.mem + MEM * i;
        let stuck = s.links.mem[mem] != R::of(0.0);
        let (w, r, c) = (a.moves + b.moves, a.free + b.free, a.mobility + b.mobility);
        // a stuck sum moves only by rounding and by a port that turns
        let (force, sticks) = hold([most, sliding], [if stuck { R::ZERO } else { w }, r], c, stuck);
        A::pull(&mut s.f, first, &a.measured, force);
        B::pull(&mut s.f, second, &b.measured, force);
        s.links.mem[mem] = if sticks { R::of(1.0) } else { R::ZERO };
        s.links.mem[mem + 1] = force * R::of(0.5) * (w + (r - c * force));
        if op.form.tap {
            s.links.tap[op.tap + i] = force;
        }
    }
}

/// Contribution of one port to the motion of the sum.
struct Port<R: Real> {
    measured: Elongation<R>,
    /// Change of its elongation in the last tick, along its gradient \[m/tick\].
    moves: R,
    /// Change in the next tick by all other forces \[m/tick\].
    free: R,
    /// Mobility of both ends \[m/N\].
    mobility: R,
}

impl<R: Real> Port<R> {
    fn of<G: Measure>(layout: &Layout<R>, s: &State<R>, ends: [usize; 2], reach: usize) -> Port<R> {
        let reach = if G::SPACE { &layout.links.reach[reach] } else { &[R::ZERO; 4] };
        let measured = G::measure(&s.x, &s.d, ends, reach);
        let gradient: [R; 3] = measured.gradient().into();
        let [mut moves, mut free, mut c] = [R::ZERO; 3];
        for (k, g) in gradient[..if G::SPACE { 3 } else { 1 }].iter().enumerate() {
            let [p, q] = ends.map(|m| m + k);
            moves += *g * (s.d[q] - s.d[p]);
            free += *g * (free_motion(layout, s, q) - free_motion(layout, s, p));
            c += *g * *g * (mobility(layout, s, p) + mobility(layout, s, q));
        }
        Port { measured, moves, free, mobility: c }
    }
}
