//! Links from one MAT, the hub, to consecutive MATs, such as the dampers between a frame and twelve hammers, or the
//! links of twelve notes to a bridge. The row needs no indices, so its loops vectorise.
//!
//! The hub adds its forces one by one, in the order of the links. The gather kernel has the same order, so the bits are
//! the same. The sum stays in a register; in memory each addition would wait for the last write.

use crate::law::Phi;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::op::wide::{Body, Simd};
use crate::op::{Hub, Op};
use crate::state::State;
use core::marker::PhantomData;

/// Number of links side by side. Rows are short, and vectors of a whole loop would leave most of them over.
const SIDE_BY_SIDE: usize = 4;

/// Applies the law of `op` to its links.
pub struct Fan<P, const C: usize, const M: usize, const OFFSET: bool>(PhantomData<P>);

impl<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool> Body<R> for Fan<P, C, M, OFFSET> {
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
        let [first, second] = layout.links.ends[op.first].map(|m| m as usize);
        if op.form.hub == Hub::First {
            links::<R, P, C, M, OFFSET, true>(op, layout, s, first, second);
        } else {
            links::<R, P, C, M, OFFSET, false>(op, layout, s, second, first);
        }
    }
}

/// Applies the law to the links between `hub`, which is their first end if `FIRST`, and the MATs from `row` on.
#[inline(always)]
fn links<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool, const FIRST: bool>(
    op: &Op<R>,
    layout: &Layout<R>,
    s: &mut State<R>,
    hub: usize,
    row: usize,
) {
    let n = op.n;
    let e0 = if OFFSET { &layout.links.e0[op.first..][..n] } else { &[] };
    let coef = &s.coef[op.coef..][..C * n];
    let columns: [&[R]; C] = core::array::from_fn(|k| &coef[k * n..][..n]);
    let (at, sum) = ([s.x[hub], s.d[hub]], s.f[hub]);
    let (x, d, f) = (&s.x[row..][..n], &s.d[row..][..n], &mut s.f[row..][..n]);
    s.f[hub] = each::<R, P, C, M, OFFSET, FIRST>([x, d], f, e0, &columns, (at, sum));
}

/// Loops over a row and returns the sum on the hub. A separate function, so that slices are known not to overlap.
#[inline(always)]
fn each<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool, const FIRST: bool>(
    [x, d]: [&[R]; 2],
    f: &mut [R],
    e0: &[R],
    columns: &[&[R]; C],
    (hub, mut sum): ([R; 2], R),
) -> R {
    let ((xs, x), (ds, d)) = (x.as_chunks::<SIDE_BY_SIDE>(), d.as_chunks::<SIDE_BY_SIDE>());
    let ((e0s, e0), (fs, f)) = (e0.as_chunks::<SIDE_BY_SIDE>(), f.as_chunks_mut::<SIDE_BY_SIDE>());
    let chunks: [&[[R; SIDE_BY_SIDE]]; C] = columns.map(|c| &c.as_chunks::<SIDE_BY_SIDE>().0[..fs.len()]);
    let from = fs.len() * SIDE_BY_SIDE;
    for (i, ((f, x), d)) in fs.iter_mut().zip(xs).zip(ds).enumerate() {
        let e0 = if OFFSET { e0s[i] } else { [R::ZERO; SIDE_BY_SIDE] };
        let mut force = [R::ZERO; SIDE_BY_SIDE];
        for k in 0..SIDE_BY_SIDE {
            let mut c = [R::ZERO; C];
            for column in 0..C {
                c[column] = chunks[column][i][k];
            }
            force[k] = one::<R, P, C, M, OFFSET, FIRST>(&c, hub, [x[k], d[k]], e0[k]);
        }
        for k in 0..SIDE_BY_SIDE {
            f[k] = if FIRST { f[k] - force[k] } else { f[k] + force[k] };
        }
        for force in force {
            sum = if FIRST { sum + force } else { sum - force };
        }
    }
    for (i, ((f, x), d)) in f.iter_mut().zip(x).zip(d).enumerate() {
        let c = core::array::from_fn(|column| columns[column][from + i]);
        let force = one::<R, P, C, M, OFFSET, FIRST>(&c, hub, [*x, *d], if OFFSET { e0[i] } else { R::ZERO });
        if FIRST {
            *f -= force;
            sum += force;
        } else {
            *f += force;
            sum -= force;
        }
    }
    sum
}

#[inline(always)]
fn one<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool, const FIRST: bool>(
    c: &[R; C],
    hub: [R; 2],
    place: [R; 2],
    e0: R,
) -> R {
    let (mut e, w) =
        if FIRST { (place[0] - hub[0], place[1] - hub[1]) } else { (hub[0] - place[0], hub[1] - place[1]) };
    if OFFSET {
        e += e0;
    }
    P::linear(c, e, w)
}
