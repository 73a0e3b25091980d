//! Discrete gradient of laws that act on both sides: CUB, POW, tables, ATT and PLK (docs/numerics.md §3.7).
//!
//! The force is the slope of the potential between the tick before and the tick after, as in [`super::gradient`]. Let a
//! be the elongation before, s after, e* after the tick without this link, and c the mobility of both ends:
//! ```text
//! F = (U(s) − U(a)) / (s − a) + (z/2)(s − a)        s = e* − c F
//! ```
//! The work F(s − a)/2 is half of U(s) − U(a) plus the heat (z/4)(s − a)². With (U(e) + U(e₊))/2 as the stored energy
//! the ledger therefore balances for any law and stiffness. A force that rises with e has one root. A force that falls
//! may have several, and each conserves energy. The root is within c·|F| of e*, where [`super::newton`] searches.
//! [`super::cluster`] solves links that share masses.

use super::newton::root;
use super::system::{enter, reach};
use super::{free_motion, mobility};
use crate::numeric::{Real, Table};
use crate::op::account::numbers;
use crate::op::layout::{Layout, MeasureKind};
use crate::op::links::measure::{Along, Line, Measure};
use crate::op::{Cheaper, Coupled, Energies, Form, Kernel, Law, LawFns, Op, SolveStage, Together};
use crate::state::State;
use crate::state::active_contacts::{COEFS, Curve, Part};

/// Numbers that determine the potential of a link.
pub type Numbers<R> = [R; COEFS];

/// A law given by its potential, with `C` coefficients and `M` numbers of memory per link.
pub trait Potential<const C: usize, const M: usize>: 'static {
    /// Returns the memory at load, at elongation `e`.
    fn at_load<R: Real>(_c: &[R; C], _e: R) -> [R; M] {
        [R::ZERO; M]
    }

    /// Updates the memory at the beginning of a tick, at elongation `e` that changed by `w`. Returns the energy lost
    /// \[J\].
    fn begin<R: Real>(_c: &[R; C], _mem: &mut [R; M], _e: R, _w: R) -> R {
        R::ZERO
    }

    /// Returns the numbers that determine the potential of a link.
    fn numbers<R: Real>(c: &[R; C], _mem: &[R; M]) -> Numbers<R> {
        core::array::from_fn(|k| c.get(k).copied().unwrap_or(R::ZERO))
    }

    /// Returns the potential energy \[J\] at an elongation.
    fn energy<R: Real>(n: &Numbers<R>, tables: &[Table<R>], e: R) -> R;

    /// Returns the mean force (U(s) − U(a)) / (s − a) \[N\], and its derivative by `s` \[N/m\].
    fn mean<R: Real>(n: &Numbers<R>, tables: &[Table<R>], a: R, s: R) -> [R; 2];

    /// Returns the viscosity \[N per m/tick\] ≥ 0 at the elongation `e` that changed by `w`.
    fn viscosity<R: Real>(c: &[R; C], mem: &[R; M], tables: &[Table<R>], e: R, w: R) -> R;

    /// Returns an upper bound \[N\] of the mean force from `a` to any `s` between `to` and the root.
    fn most<R: Real>(n: &Numbers<R>, tables: &[Table<R>], a: R, to: R) -> R {
        Self::mean(n, tables, a, to)[0].abs()
    }
}

/// Makes the law from its potential; `shared` runs on shared masses. Memory: of the potential, heat of the tick \[J\].
pub const fn alone<P: Potential<C, M>, const C: usize, const M: usize>(
    code: &'static str,
    law: Law,
    shared: Option<&'static Law>,
) -> Law {
    Law {
        code,
        mem: M + 1,
        contact: false,
        stage: SolveStage::Single(Together { line: shared, space: None }),
        cheaper: Cheaper::NONE,
        fns: alone_fns::<f64, P, C, M>(law.fns),
        ..law
    }
}

/// Makes its functions.
pub const fn alone_fns<R: Real, P: Potential<C, M>, const C: usize, const M: usize>(law: LawFns<R>) -> LawFns<R> {
    LawFns {
        start: |c, [e, _], mem| {
            mem.fill(R::ZERO);
            mem[..M].copy_from_slice(&P::at_load(&numbers(c), e));
        },
        energies: Energies::kept(
            |c, mem, tables, before, after| {
                let n = P::numbers(&numbers(c), &numbers(mem));
                R::of(0.5) * (P::energy(&n, tables, before) + P::energy(&n, tables, after))
            },
            |_, mem, _, _| mem[M],
        ),
        kernel: |_| pull::<R, P, C, M>,
        ..law
    }
}

/// Makes the law from its potential, solved together with all links that share masses. Memory as in [`alone`].
pub const fn shared<P: Potential<C, M>, const C: usize, const M: usize>(code: &'static str, law: Law) -> Law {
    Law {
        stage: SolveStage::Coupled(Coupled { curve: true, at_modes: None }),
        fns: shared_fns::<f64, P, C, M>(law.fns),
        ..alone::<P, C, M>(code, law, None)
    }
}

/// Makes its functions.
pub const fn shared_fns<R: Real, P: Potential<C, M>, const C: usize, const M: usize>(law: LawFns<R>) -> LawFns<R> {
    LawFns { kernel: kernel::<R, P, C, M>, ..alone_fns::<R, P, C, M>(law) }
}

fn kernel<R: Real, P: Potential<C, M>, const C: usize, const M: usize>(form: Form) -> Kernel<R> {
    match form.measure {
        MeasureKind::Line => gather::<R, P, Line, C, M>,
        // the compiler refuses distances in space
        MeasureKind::Along | MeasureKind::Radial => gather::<R, P, Along, C, M>,
    }
}

/// Link `i` of an op at the beginning of a tick.
struct Begun<R: Real, const C: usize, const M: usize> {
    c: [R; C],
    mem: [R; M],
    numbers: Numbers<R>,
    given_up: R,
}

impl<R: Real, const C: usize, const M: usize> Begun<R, C, M> {
    fn of<P: Potential<C, M>>(op: &Op<R>, s: &State<R>, i: usize, e: R, w: R) -> Begun<R, C, M> {
        let c = core::array::from_fn(|k| s.coef[op.coef + k * op.n + i]);
        let mut mem = numbers(&s.links.mem[op.mem + (M + 1) * i..]);
        let given_up = P::begin(&c, &mut mem, e, w);
        Begun { c, mem, numbers: P::numbers(&c, &mem), given_up }
    }

    fn keep(&self, op: &Op<R>, s: &mut State<R>, i: usize, heat: R) {
        let at = op.mem + (M + 1) * i;
        s.links.mem[at..at + M].copy_from_slice(&self.mem);
        s.links.mem[at + M] = self.given_up + heat;
    }
}

fn pull<R: Real, P: Potential<C, M>, const C: usize, const M: usize>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let tables = &layout.tables;
    let [one, half] = [1.0, 0.5].map(R::of);
    for i in 0..op.n {
        let [p, q] = layout.links.ends[op.first + i].map(|m| m as usize);
        let (e, w) = (s.x[q] - s.x[p] + layout.links.e0[op.first + i], s.d[q] - s.d[p]);
        let link = Begun::<R, C, M>::of::<P>(op, s, i, e, w);
        let a = e - w;
        let free = e + (free_motion(layout, s, q) - free_motion(layout, s, p));
        let c = mobility(layout, s, p) + mobility(layout, s, q);
        let z = P::viscosity(&link.c, &link.mem, tables, e, w);
        let beta = half * c * z;
        let (goal, h) = ((free + beta * a) / (one + beta), c / (one + beta));
        let most = h * P::most(&link.numbers, tables, a, goal);
        let (low, high) = (goal - most, goal + most);
        let to = root((e + w).max(low).min(high), [low, high], a.abs().max(e.abs()), |s| {
            let [force, rise] = P::mean(&link.numbers, tables, a, s);
            (s - goal + h * force, one + h * rise)
        });
        // the last step may have crossed a kink
        let [mean, rise] = P::mean(&link.numbers, tables, a, to);
        let more = (goal - h * mean - to) / (one + h * rise);
        // for a stiff link the position has more correct digits than the force
        let elastic = if h * rise > one { (goal - to - more) / h } else { mean + rise * more };
        let moved = (free - a - c * elastic) / (one + beta);
        let force = elastic + half * z * moved;
        s.f[p] += force;
        s.f[q] -= force;
        link.keep(op, s, i, half * half * z * moved * moved);
        if op.form.tap {
            s.links.tap[op.tap + i] = force;
        }
    }
}

/// Collects the links of `op`. The penetration of a link is its negative elongation.
fn gather<R: Real, P: Potential<C, M>, G: Measure, const C: usize, const M: usize>(
    op: &Op<R>,
    layout: &Layout<R>,
    s: &mut State<R>,
) {
    for i in 0..op.n {
        let ends = layout.links.ends[op.first + i].map(|m| m as usize);
        let at = if G::SPACE { layout.links.reach[op.ports.reach + i] } else { [R::ZERO; 4] };
        let measured = G::measure(&s.x, &s.d, ends, &at);
        let (e, w) = (measured.e + layout.links.e0[op.first + i], measured.w);
        let link = Begun::<R, C, M>::of::<P>(op, s, i, e, w);
        let z = P::viscosity(&link.c, &link.mem, &layout.tables, e, w);
        link.keep(op, s, i, R::ZERO);
        if op.form.tap {
            s.links.tap[op.tap + i] = R::ZERO;
        }
        let to = reach::<R, G>(op, layout, s, i, R::of(1.0), measured.gradient());
        let (curve, coef) = (Some(OfPotential::<R, P, C, M>::CURVE), link.numbers);
        let mem = op.mem + (M + 1) * i + M;
        if let Some(t) = enter(s, mem, to) {
            (t.curve, t.part, t.clip, t.coef) = (curve, Part::Acts, false, coef);
            (t.from, t.z, t.went) = (w - e, z, R::of(-2.0) * w);
        }
    }
}

struct OfPotential<R, P, const C: usize, const M: usize>(core::marker::PhantomData<(R, P)>);

impl<R: Real, P: Potential<C, M>, const C: usize, const M: usize> OfPotential<R, P, C, M> {
    const CURVE: &'static Curve<R> = &Curve {
        push: |n, tables, from, change| {
            let [force, rise] = P::mean(n, tables, -from, -(from + change));
            [-force, rise]
        },
        released: |n, tables, from, change| P::energy(n, tables, -from) - P::energy(n, tables, -(from + change)),
        begin: |t| t.went,
    };
}
