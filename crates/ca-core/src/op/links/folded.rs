//! A long row that is summed and integrated in one pass, as eight stretches side by side.
//!
//! The row is cut into eight stretches of equal length, one per lane of a vector of eight ([`Fold`]), so the neighbour
//! of a vector is the next vector. One loop sums and integrates, without an array of forces, shifted lanes, or a
//! remainder. Only the force between the end of one stretch and the start of the next crosses lanes, once per tick.
//!
//! There are eight lanes on every processor (vectors of eight, four or two, or plain numbers), so the order of masses
//! and all bits are the same on every machine. Rows are padded to whole vectors with fixed masses and links without
//! force, which is cheaper than a loop for the remainder and aligns every vector to a cache line.
//!
//! The sum has the order of [`Fused`](super::fused::Fused), (Fᵢ − Fᵢ₋₁) + f.

use crate::law::Phi;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::op::wide::{Body, Simd};
use crate::state::{Fold, State};
use core::marker::PhantomData;
use core::ops::{Add, Mul, Sub};

pub(super) const LANES: usize = Fold::LANES;

/// The pass of `op.n` ≥ 16 masses, a multiple of 8, and as many links. The last link exerts a force of zero. Masses
/// start at `op.mat`. With `OWN` they have their own springs and dampers.
pub struct Folded<P, const C: usize, const M: usize, const OFFSET: bool, const OWN: bool>(PhantomData<P>);

impl<P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool, const OWN: bool> Body<f64>
    for Folded<P, C, M, OFFSET, OWN>
{
    #[inline(always)]
    fn run<S: Simd>(simd: S, op: &Op, layout: &Layout, s: &mut State) {
        match S::F64_LANES {
            LANES => row::<S, P, C, M, 1, OFFSET, OWN>(simd, op, layout, s),
            4 => row::<S, P, C, M, 2, OFFSET, OWN>(simd, op, layout, s),
            2 => row::<S, P, C, M, 4, OFFSET, OWN>(simd, op, layout, s),
            _ => row::<S, P, C, M, LANES, OFFSET, OWN>(simd, op, layout, s),
        }
    }
}

#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd>(pub(super) S, pub(super) S::f64s);

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Lanes(self.0, self.0.add_f64s(self.1, other.1))
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Lanes(self.0, self.0.sub_f64s(self.1, other.1))
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Lanes(self.0, self.0.mul_f64s(self.1, other.1))
    }
}

/// Groups numbers by eight, in `U` vectors each.
#[inline(always)]
pub(super) fn eights<S: Simd, const U: usize>(all: &[f64]) -> &[[S::f64s; U]] {
    S::as_simd_f64s(all).0.as_chunks::<U>().0
}

#[inline(always)]
pub(super) fn eights_mut<S: Simd, const U: usize>(all: &mut [f64]) -> &mut [[S::f64s; U]] {
    S::as_mut_simd_f64s(all).0.as_chunks_mut::<U>().0
}

/// Returns the coefficients of `n` links, one column each, at the beginning of `all`.
#[inline(always)]
pub(super) fn coefs<S: Simd, const C: usize, const U: usize>(all: &[f64], n: usize) -> [&[[S::f64s; U]]; C] {
    let mut columns: [&[[S::f64s; U]]; C] = [&[]; C];
    for k in 0..C {
        columns[k] = &eights::<S, U>(&all[k * n..][..n])[..n / LANES];
    }
    columns
}

/// Returns the forces of links between `x` and `x_next`, from their coefficients. It uses loops instead of closures,
/// which are not inlined here and so not vectorised at full width.
#[inline(always)]
pub(super) fn force<S: Simd, P: Phi<C, M>, const C: usize, const M: usize, const U: usize>(
    simd: S,
    columns: &[&[[S::f64s; U]]; C],
    e0: Option<&[S::f64s; U]>,
    i: usize,
    [x, x_next, d, d_next]: [&[S::f64s; U]; 4],
) -> [S::f64s; U] {
    let mut all = *x;
    for u in 0..U {
        let v = |v| Lanes(simd, v);
        let mut e = v(x_next[u]) - v(x[u]);
        if let Some(e0) = e0 {
            e = e + v(e0[u]);
        }
        let mut c = [e; C];
        for k in 0..C {
            c[k] = v(columns[k][i][u]);
        }
        all[u] = P::linear(&c, e, v(d_next[u]) - v(d[u])).1;
    }
    all
}

/// Moves all lanes up by one across the eight; the last comes round to the first.
#[inline(always)]
pub(super) fn rotated<S: Simd, const U: usize>(simd: S, all: &[S::f64s; U]) -> [S::f64s; U] {
    let first = simd.mask_between_m64s(0, 1).mask();
    let mut to = *all;
    for u in 0..U {
        let (from, before) = (all[u], all[(u + U - 1) % U]);
        to[u] = simd.select_f64s(first, simd.rotate_right_f64s(before, 1), simd.rotate_right_f64s(from, 1));
    }
    to
}

#[inline(always)]
fn row<S: Simd, P: Phi<C, M>, const C: usize, const M: usize, const U: usize, const OFFSET: bool, const OWN: bool>(
    simd: S,
    op: &Op,
    layout: &Layout,
    s: &mut State,
) {
    let (n, steps) = (op.n, op.n / LANES);
    let last = steps - 1;
    let k8 = coefs::<S, C, U>(&s.coef[op.coef..], n);
    let e8 = if OFFSET { &eights::<S, U>(&layout.links.e0[op.first..][..n])[..steps] } else { &[] };
    let [p, q, c] = [0, 1, 2].map(|k| &s.coef[k * layout.counts.n_mat + op.mat..][..n]);
    let (p, q, c) = (&eights::<S, U>(p)[..steps], &eights::<S, U>(q)[..steps], &eights::<S, U>(c)[..steps]);
    let (x, d, f) = (&mut s.x[op.mat..][..n], &mut s.d[op.mat..][..n], &mut s.f[op.mat..][..n]);
    // the neighbour of the last mass of a stretch is the first mass of the next stretch, one number further; after the
    // very last mass the force is zero, whatever is stored there
    let (x_next, d_next) = (eights::<S, U>(&x[1..=LANES])[0], eights::<S, U>(&d[1..=LANES])[0]);
    let (x, d, f) = (eights_mut::<S, U>(x), eights_mut::<S, U>(d), eights_mut::<S, U>(f));
    let (x, d, f) = (&mut x[..steps], &mut d[..steps], &mut f[..steps]);
    let e = if OFFSET { Some(&e8[last]) } else { None };
    // the force after the last mass of each stretch is the force before the first mass of the next; the one after the
    // very last mass is zero and comes round to the very first
    let ends = force::<S, P, C, M, U>(simd, &k8, e, last, [&x[last], &x_next, &d[last], &d_next]);
    let mut before = rotated::<S, U>(simd, &ends);
    let (mut x_now, mut d_now) = (x[0], d[0]);
    for i in 0..steps {
        let (x_next, d_next, behind) = if i < last {
            let (x_next, d_next) = (x[i + 1], d[i + 1]);
            let e = if OFFSET { Some(&e8[i]) } else { None };
            (x_next, d_next, force::<S, P, C, M, U>(simd, &k8, e, i, [&x_now, &x_next, &d_now, &d_next]))
        } else {
            (x_now, d_now, ends)
        };
        for u in 0..U {
            let v = |v| Lanes(simd, v);
            let sum = (v(behind[u]) - v(before[u])) + v(f[i][u]);
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
