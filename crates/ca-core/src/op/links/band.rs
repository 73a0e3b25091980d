//! The links of a mesh, along and across its rows, and the integration of its masses, in one pass.
//!
//! Masses are folded ([`Folded`](super::folded::Folded)) in the order of the rows of the mesh. The neighbour along a
//! row is the next vector, and the neighbour across is `width` vectors further. For the last `width` vectors it is in
//! the next lane, at the beginning. Those forces are computed before anything moves, and every force is computed once:
//! its reaction is read `width` vectors later from where it was stored.
//!
//! The sum has the order of separate passes: (Fᵢ − Fᵢ₋₁) along, −F before and +F after across, then all other forces.

use super::folded::{Lanes, coefs, eights, eights_mut, force, rotated};
use crate::law::Phi;
use crate::op::layout::Layout;
use crate::op::wide::{Body, Simd};
use crate::op::{Band, Op};
use crate::state::{Fold, State};
use core::marker::PhantomData;

const LANES: usize = Fold::LANES;

/// The pass of `op.n` masses, a multiple of 8, from `op.mat` on, and of as many links along and across. The
/// coefficients of the links across follow those along.
///
/// The width is at least 2 and below `op.n / 8`. Forces across are stored at the beginning of [`LinkState::tap`].
pub struct Banded<P, const C: usize, const M: usize, const OFFSET: bool, const OWN: bool>(PhantomData<P>);

impl<P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool, const OWN: bool> Body<f64>
    for Banded<P, C, M, OFFSET, OWN>
{
    #[inline(always)]
    fn run<S: Simd>(simd: S, op: &Op, layout: &Layout, s: &mut State) {
        match S::F64_LANES {
            LANES => band::<S, P, C, M, 1, OFFSET, OWN>(simd, op, layout, s),
            4 => band::<S, P, C, M, 2, OFFSET, OWN>(simd, op, layout, s),
            2 => band::<S, P, C, M, 4, OFFSET, OWN>(simd, op, layout, s),
            _ => band::<S, P, C, M, LANES, OFFSET, OWN>(simd, op, layout, s),
        }
    }
}

#[inline(always)]
fn band<S: Simd, P: Phi<C, M>, const C: usize, const M: usize, const U: usize, const OFFSET: bool, const OWN: bool>(
    simd: S,
    op: &Op,
    layout: &Layout,
    s: &mut State,
) {
    let Band::Along(width) = op.form.band else { return };
    let (n, steps) = (op.n, op.n / LANES);
    let (last, wrap) = (steps - 1, steps - width);
    let along = coefs::<S, C, U>(&s.coef[op.coef..], n);
    let across = coefs::<S, C, U>(&s.coef[op.coef + C * n..], n);
    let [e_along, e_across]: [&[[S::f64s; U]]; 2] = if OFFSET {
        [0, n].map(|first| &eights::<S, U>(&layout.links.e0[op.first + first..][..n])[..steps])
    } else {
        [&[], &[]]
    };
    let [p, q, c] = [0, 1, 2].map(|k| &s.coef[k * layout.counts.n_mat + op.mat..][..n]);
    let (p, q, c) = (&eights::<S, U>(p)[..steps], &eights::<S, U>(q)[..steps], &eights::<S, U>(c)[..steps]);
    let (x, d, f) = (&mut s.x[op.mat..][..n], &mut s.d[op.mat..][..n], &mut s.f[op.mat..][..n]);
    let kept = &mut eights_mut::<S, U>(&mut s.links.tap[..n])[..steps];
    // neighbours in the next lane are one number further; the link after the very last mass has zero force
    for i in wrap..steps {
        let at = (i - wrap) * LANES;
        let [x, d, x_next, d_next] =
            [&x[i * LANES..], &d[i * LANES..], &x[at + 1..], &d[at + 1..]].map(|v| eights::<S, U>(&v[..LANES])[0]);
        let e = if OFFSET { Some(&e_across[i]) } else { None };
        kept[i] = force::<S, P, C, M, U>(simd, &across, e, i, [&x, &x_next, &d, &d_next]);
    }
    let (x_next, d_next) = (eights::<S, U>(&x[1..=LANES])[0], eights::<S, U>(&d[1..=LANES])[0]);
    let (x, d, f) = (eights_mut::<S, U>(x), eights_mut::<S, U>(d), eights_mut::<S, U>(f));
    let (x, d, f) = (&mut x[..steps], &mut d[..steps], &mut f[..steps]);
    let e = if OFFSET { Some(&e_along[last]) } else { None };
    let ends = force::<S, P, C, M, U>(simd, &along, e, last, [&x[last], &x_next, &d[last], &d_next]);
    let mut before = rotated::<S, U>(simd, &ends);
    let (mut x_now, mut d_now) = (x[0], d[0]);
    for i in 0..steps {
        let (x_next, d_next, behind) = if i < last {
            let (x_next, d_next) = (x[i + 1], d[i + 1]);
            let e = if OFFSET { Some(&e_along[i]) } else { None };
            (x_next, d_next, force::<S, P, C, M, U>(simd, &along, e, i, [&x_now, &x_next, &d_now, &d_next]))
        } else {
            (x_now, d_now, ends)
        };
        let above = if i < width { rotated::<S, U>(simd, &kept[i + wrap]) } else { kept[i - width] };
        if i < wrap {
            let e = if OFFSET { Some(&e_across[i]) } else { None };
            let ends = [&x_now, &x[i + width], &d_now, &d[i + width]];
            kept[i] = force::<S, P, C, M, U>(simd, &across, e, i, ends);
        }
        let below = kept[i];
        for u in 0..U {
            let v = |v| Lanes(simd, v);
            let sum = (((v(behind[u]) - v(before[u])) - v(above[u])) + v(below[u])) + v(f[i][u]);
            let moved = if OWN {
                v(p[i][u]) * v(d_now[u]) + v(q[i][u]) * v(x_now[u]) + v(c[i][u]) * sum
            } else {
                v(d_now[u]) + v(c[i][u]) * sum
            };
            d[i][u] = moved.1;
            x[i][u] = (v(x_now[u]) + moved).1;
            f[i][u] = simd.splat_f64s(0.0);
        }
        (x_now, d_now, before) = (x_next, d_next, behind);
    }
}
