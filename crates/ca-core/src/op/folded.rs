//! Folded: a long row that is summed and integrated in one pass, eight stretches of it side by side.
//!
//! The row is cut into eight stretches of equal length, one in each lane of a vector of eight ([`Fold`]), so that the
//! neighbour of a vector is the next vector: one loop sums and integrates without an array of forces, without shifting lanes
//! and without what is left over at the end of a vector. Only the force between the end of one stretch and the beginning
//! of the next crosses lanes, once a tick. Decides for eight lanes on every processor, as one vector of eight, two of
//! four, four of two or eight numbers: where masses stand does not depend on the machine, and no bit of the result does.
//! What is left of the row, up to eight masses, stands behind it in order.
//!
//! The sum is that of [`Fused`](super::fused::Fused), (Fᵢ − Fᵢ₋₁) + f.

use super::Op;
use super::wide::{Body, Simd};
use crate::law::Phi;
use crate::layout::Layout;
use crate::state::{Fold, State};
use core::marker::PhantomData;
use core::ops::{Add, Mul, Sub};

const LANES: usize = Fold::LANES;

/// The pass of `op.n` ≥ 8 links and of `op.n + 1` masses from `op.mat` on, which have springs and dampers of their own where
/// `OWN`.
pub struct Folded<P, const C: usize, const M: usize, const OFFSET: bool, const OWN: bool>(PhantomData<P>);

impl<P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool, const OWN: bool> Body
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

/// A vector with the operations of numbers.
#[derive(Clone, Copy)]
struct Lanes<S: Simd>(S, S::f64s);

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

/// Numbers eight by eight, in `U` vectors each.
#[inline(always)]
fn eights<S: Simd, const U: usize>(all: &[f64]) -> &[[S::f64s; U]] {
    S::as_simd_f64s(all).0.as_chunks::<U>().0
}

/// The same, to be changed.
#[inline(always)]
fn eights_mut<S: Simd, const U: usize>(all: &mut [f64]) -> &mut [[S::f64s; U]] {
    S::as_mut_simd_f64s(all).0.as_chunks_mut::<U>().0
}

/// The forces of links whose ends are `x` and `x_next` apart, by coefficients `c`. Loops rather than closures: what is not
/// inlined here stays narrow.
#[inline(always)]
fn force<S: Simd, P: Phi<C, M>, const C: usize, const M: usize, const U: usize>(
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

#[inline(always)]
fn row<S: Simd, P: Phi<C, M>, const C: usize, const M: usize, const U: usize, const OFFSET: bool, const OWN: bool>(
    simd: S,
    op: &Op,
    layout: &Layout,
    s: &mut State,
) {
    let (n, steps) = (op.n, op.n / LANES);
    let (folded, last) = (LANES * steps, steps - 1);
    let e0: &[f64] = if OFFSET { &layout.e0[op.first..][..n] } else { &[] };
    let columns = &s.coef[op.coef..][..C * n];
    let [p, q, c] = [0, 1, 2].map(|k| &s.coef[k * layout.n_mat + op.mat..][..n + 1]);
    let (x, x_left) = s.x[op.mat..][..n + 1].split_at_mut(folded);
    let (d, d_left) = s.d[op.mat..][..n + 1].split_at_mut(folded);
    let (f, f_left) = s.f[op.mat..][..n + 1].split_at_mut(folded);
    // what follows the last mass of each stretch: the first of the next, and what is left
    let (mut x_next, mut d_next) = ([0.0; LANES], [0.0; LANES]);
    x_next[..LANES - 1].copy_from_slice(&x[1..LANES]);
    d_next[..LANES - 1].copy_from_slice(&d[1..LANES]);
    (x_next[LANES - 1], d_next[LANES - 1]) = (x_left[0], d_left[0]);
    // the force behind the last mass of each stretch, and therefore before the first of the next
    let mut behind = [0.0; LANES + 1];
    {
        let mut k8: [&[[S::f64s; U]]; C] = [&[]; C];
        for k in 0..C {
            k8[k] = &eights::<S, U>(&columns[k * n..][..folded])[..steps];
        }
        let e8 = if OFFSET { &eights::<S, U>(&e0[..folded])[..steps] } else { &[] };
        let [p, q, c] = [&p[..folded], &q[..folded], &c[..folded]];
        let (p, q, c) = (&eights::<S, U>(p)[..steps], &eights::<S, U>(q)[..steps], &eights::<S, U>(c)[..steps]);
        let (x, d, f) = (eights_mut::<S, U>(x), eights_mut::<S, U>(d), eights_mut::<S, U>(f));
        let (x, d, f) = (&mut x[..steps], &mut d[..steps], &mut f[..steps]);
        let (x_next, d_next) = (&eights::<S, U>(&x_next)[0], &eights::<S, U>(&d_next)[0]);
        let e = if OFFSET { Some(&e8[last]) } else { None };
        let ends = force::<S, P, C, M, U>(simd, &k8, e, last, [&x[last], x_next, &d[last], d_next]);
        eights_mut::<S, U>(&mut behind[1..])[0] = ends;
        let mut before = eights::<S, U>(&behind[..LANES])[0];
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
    let mut before = behind[LANES];
    for i in 0..x_left.len() {
        let at = folded + i;
        let behind = if at < n {
            let e = x_left[i + 1] - x_left[i];
            let e = if OFFSET { e + e0[at] } else { e };
            let mut c = [0.0; C];
            for k in 0..C {
                c[k] = columns[k * n + at];
            }
            P::linear(&c, e, d_left[i + 1] - d_left[i])
        } else {
            0.0
        };
        let sum = (behind - before) + f_left[i];
        let d = &mut d_left[i];
        *d = if OWN { p[at] * *d + q[at] * x_left[i] + c[at] * sum } else { *d + c[at] * sum };
        x_left[i] += *d;
        f_left[i] = 0.0;
        before = behind;
    }
}
