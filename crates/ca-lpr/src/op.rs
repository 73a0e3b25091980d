//! Op of an LPR: measures two ports, applies one law to the sum and adds the force at both.
//!
//! The law gets the sum of two elongations, not four positions, as in any other link, so energy and stability need no
//! code here. With one port held, a quadripole is the plain link. Each law has a kernel for each pair of worlds: space
//! and a line, space and space, a line and a line. An open contact is measured too, unlike a contact of two ends in
//! space: the sign of a sum needs its square roots.
//!
//! At zero length a port in space has force 0, since its direction is undefined; the law and the other port continue
//! (docs/numerics.md §4.4). `soften` keeps the direction where ends pass through each other.

use ca_core::internal::op::layout::Layout;
use ca_core::internal::op::links::measure::{Line, Measure, Radial};
use ca_core::internal::op::{Form, Kernel, MeasureKind, Op};
use ca_core::{Phi, Real, State};

fn nowhere<R: Real>() -> [R; 4] {
    [R::ZERO; 4]
}

/// Applies the law of `op` to each of its quadripoles, whose ports are measured by `A` and `B`.
pub fn lpr<R: Real, P: Phi<C, M>, A: Measure, B: Measure, const C: usize, const M: usize, const TAP: bool>(
    op: &Op<R>,
    layout: &Layout<R>,
    s: &mut State<R>,
) {
    let n = op.n;
    let Some((_, onto, far)) = op.ports.onto else { return };
    let (between, onto) = (&layout.links.ends[op.first..][..n], &layout.links.onto[onto..][..n]);
    let (near_length, far_length, lengths) = (op.ports.reach, far, &mut s.links.lengths[..]);
    let (near, far) = (reach::<R, A>(layout, op.ports.reach, n), reach::<R, B>(layout, far, n));
    let e0 = &layout.links.e0[op.first..][..n];
    let columns: [&[R]; C] = core::array::from_fn(|k| &s.coef[op.coef + k * n..][..n]);
    let (x, d, f) = (&s.x[..], &s.d[..], &mut s.f[..]);
    let mem = &mut s.links.mem[op.mem..][..n * M];
    let nowhere = nowhere();
    for i in 0..n {
        let (first, second) = (between[i].map(|m| m as usize), onto[i].map(|m| m as usize));
        let mut none = R::ZERO;
        let last = if A::SPACE { &mut lengths[near_length + i] } else { &mut none };
        let a = A::follow(x, d, first, if A::SPACE { &near[i] } else { &nowhere }, last);
        let last = if B::SPACE { &mut lengths[far_length + i] } else { &mut none };
        let b = B::follow(x, d, second, if B::SPACE { &far[i] } else { &nowhere }, last);
        let c = core::array::from_fn(|k| columns[k][i]);
        let Some(m) = mem[i * M..].first_chunk_mut::<M>() else { continue };
        let force = P::force(&c, m, &layout.tables, a.e + b.e + e0[i], a.w + b.w);
        A::pull(f, first, &a, force);
        B::pull(f, second, &b, force);
        if TAP {
            s.links.tap[op.tap + i] = force;
        }
    }
}

fn reach<R: Real, G: Measure>(layout: &Layout<R>, first: usize, n: usize) -> &[[R; 4]] {
    if G::SPACE { &layout.links.reach[first..][..n] } else { &[] }
}

/// Returns the kernel of a law for one form of a quadripole. The compiler puts a port in space first, and LPR lacks the
/// parameter `along`, so that a fixed direction does not occur.
pub fn kernel<R: Real, P: Phi<C, M> + 'static, const C: usize, const M: usize>(form: Form) -> Kernel<R> {
    match (form.measure, form.onto, form.tap) {
        (MeasureKind::Line, _, false) => lpr::<R, P, Line, Line, C, M, false>,
        (MeasureKind::Line, _, true) => lpr::<R, P, Line, Line, C, M, true>,
        (_, Some(MeasureKind::Radial), false) => lpr::<R, P, Radial, Radial, C, M, false>,
        (_, Some(MeasureKind::Radial), true) => lpr::<R, P, Radial, Radial, C, M, true>,
        (_, _, false) => lpr::<R, P, Radial, Line, C, M, false>,
        (_, _, true) => lpr::<R, P, Radial, Line, C, M, true>,
    }
}
