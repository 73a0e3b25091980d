//! Links between points in space that are measured in every tick, many at a time.
//!
//! Links are processed in blocks, in three loops: the vectors between their ends, on the stack; lengths, forces and
//! forces on the ends, one link per lane, with one square root and one division for all lanes; the sums. Only the first
//! and the last use the ends of a link, looked up one by one, or for a row ([`LinkArrays::rows`]) read as consecutive
//! numbers, so a row of a cloth needs no indices.
//!
//! Forces are summed in the order of the links. In a row every mass is the second end of an earlier link before it is
//! the first end of a later one, so all second ends are summed before all first ends, as in [`Run`](super::run::Run).
//! The remainder of a batch, and batches that are too short, are processed one by one, with the same bits.
//!
//! A point is three numbers, as everywhere. With a fourth, passes that move masses would take a third longer.

use super::folded::{LANES, Lanes};
use super::measure::{LEAST, Radial};
use super::space::links;
use crate::law::Phi;
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::op::wide::{Body, Simd};
use crate::state::State;
use core::marker::PhantomData;

const BLOCK: usize = 64;
/// Smaller batches are processed one by one, since a block must clear its working memory first.
const FEWEST: usize = 16;

/// Applies a law with a vector form of its force to each link of `op`.
pub struct Blocks<P, const C: usize, const M: usize, const TAP: bool>(PhantomData<P>);

impl<P: Phi<C, M>, const C: usize, const M: usize, const TAP: bool> Body<f64> for Blocks<P, C, M, TAP> {
    #[inline(always)]
    fn run<S: Simd>(simd: S, op: &Op, layout: &Layout, s: &mut State) {
        if op.n < FEWEST {
            links::<f64, P, Radial, C, M, TAP>(op, layout, s, 0..op.n);
            return;
        }
        let whole = op.n - op.n % S::F64_LANES;
        // one more number, so that the last vector can be written as four
        let mut scratch = [0.0; 3 * BLOCK + 1];
        let mut first = 0;
        while first < whole {
            let n = BLOCK.min(whole - first);
            vectors(simd, op, layout, s, first, &mut scratch[..=3 * n]);
            let v = &mut scratch[..3 * n];
            if s.links.lengths[op.ports.reach + first] < 0.0 {
                recall(op, layout, s, first, v);
            }
            pulls::<S, P, C, M, TAP>(simd, op, layout, s, first, v);
            sums(simd, op, layout, s, first, v);
            first += n;
        }
        links::<f64, P, Radial, C, M, TAP>(op, layout, s, whole..op.n);
    }
}

/// Working memory of a block, for laws that are called link by link.
struct Scratch {
    /// vectors between ends, then forces, and one more number
    v: [f64; 3 * BLOCK + 1],
    /// lengths
    l: [f64; BLOCK],
    /// elongations, then forces of the law \[N\]
    e: [f64; BLOCK],
    /// changes of length
    w: [f64; BLOCK],
}

/// A block of links whose law is called link by link. The code around the law is compiled once for all laws.
struct Around<'a> {
    op: &'a Op,
    layout: &'a Layout,
    s: &'a mut State,
    first: usize,
    n: usize,
    scratch: &'a mut Scratch,
}

/// Computes lengths, elongations and their changes, before the law is called.
struct Before<'a>(Around<'a>);

impl pulp::WithSimd for Before<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Around { op, layout, s, first, n, scratch } = self.0;
        let Scratch { v, l, e, w } = scratch;
        vectors(simd, op, layout, s, first, &mut v[..=3 * n]);
        if s.links.lengths[op.ports.reach + first] < 0.0 {
            recall(op, layout, s, first, &v[..3 * n]);
        }
        let mut soft = [0.0; BLOCK];
        let soft = softened::<S>(op, layout, first, &mut soft[..n]);
        let lengths = &mut s.links.lengths[op.ports.reach + first..][..n];
        let (vectors, e0, last) = block::<S>(&mut v[..3 * n], &layout.links.e0[op.first + first..][..n], lengths);
        let steps = vectors.len();
        let [l, e, w] = [l, e, w].map(|all| &mut S::as_mut_simd_f64s(&mut all[..n]).0[..steps]);
        for i in 0..steps {
            let now = length(simd, simd.deinterleave_shfl_f64s(vectors[i]), soft.map(|soft| &soft[i]));
            (l[i], e[i], w[i]) = (now.1, (now + Lanes(simd, e0[i])).1, (now - Lanes(simd, last[i])).1);
            last[i] = now.1;
        }
    }
}

/// Applies the forces of the law along the vectors, after the law was called.
struct Behind<'a>(Around<'a>);

impl pulp::WithSimd for Behind<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Around { op, layout, s, first, n, scratch } = self.0;
        let Scratch { v, l, e, .. } = scratch;
        let vectors = S::as_mut_simd_f64s(&mut v[..3 * n]).0.as_chunks_mut::<3>().0;
        let steps = vectors.len();
        let [l, force] = [l, e].map(|all| &S::as_simd_f64s(&all[..n]).0[..steps]);
        for i in 0..steps {
            vectors[i] = along(simd, simd.deinterleave_shfl_f64s(vectors[i]), force[i], l[i]);
        }
        sums(simd, op, layout, s, first, &v[..3 * n]);
    }
}

/// Applies a law that is called link by link to each link of `op`.
pub fn by_law<P: Phi<C, M>, const C: usize, const M: usize, const TAP: bool>(op: &Op, layout: &Layout, s: &mut State) {
    // a multiple of 8 at any vector width, so that the same links are processed one by one on all machines
    let whole = if op.n < FEWEST { 0 } else { op.n - op.n % LANES };
    let mut scratch = Scratch { v: [0.0; 3 * BLOCK + 1], l: [0.0; BLOCK], e: [0.0; BLOCK], w: [0.0; BLOCK] };
    let mut first = 0;
    while first < whole {
        let n = BLOCK.min(whole - first);
        layout.vectors.widest(Before(Around { op, layout, s: &mut *s, first, n, scratch: &mut scratch }));
        let mut columns: [&[f64]; C] = [&[]; C];
        for (k, column) in columns.iter_mut().enumerate() {
            *column = &s.coef[op.coef + k * op.n + first..][..n];
        }
        let mem = &mut s.links.mem[op.mem + first * M..][..n * M];
        let (e, w) = (&mut scratch.e[..n], &scratch.w[..n]);
        for i in 0..n {
            let c = core::array::from_fn(|k| columns[k][i]);
            let mut none = [0.0; M];
            let m = if M == 0 { &mut none } else { mem[i * M..].first_chunk_mut::<M>().unwrap_or(&mut none) };
            e[i] = P::force(&c, m, &layout.tables, e[i], w[i]);
        }
        if TAP {
            s.links.tap[op.tap + first..][..n].copy_from_slice(e);
        }
        layout.vectors.widest(Behind(Around { op, layout, s: &mut *s, first, n, scratch: &mut scratch }));
        first += n;
    }
    links::<f64, P, Radial, C, M, TAP>(op, layout, s, whole..op.n);
}

#[inline(always)]
fn four(all: &[f64], i: u32) -> Option<&[f64; 4]> {
    match all.get(i as usize..i as usize + 4) {
        Some(four) => four.first_chunk(),
        None => None,
    }
}

#[inline(always)]
fn three(all: &[f64], i: u32) -> [f64; 3] {
    match all.get(i as usize..i as usize + 3) {
        Some(&[x, y, z]) => [x, y, z],
        _ => [0.0; 3],
    }
}

/// Returns the number of links from `i` on that form a row, or that form none, and whether they form a row.
#[inline(always)]
fn stretch(rows: &[i32], i: usize) -> (usize, bool) {
    ((rows[i].unsigned_abs() as usize).clamp(1, rows.len() - i), rows[i] > 0)
}

/// Computes the vectors between the ends of the links from `first` on; one extra number in `v` is overwritten.
#[inline(always)]
fn vectors<S: Simd>(simd: S, op: &Op, layout: &Layout, s: &State, first: usize, v: &mut [f64]) {
    let n = v.len() / 3;
    let ends = &layout.links.ends[op.first + first..][..n];
    let reach = &layout.links.reach[op.ports.reach + first..][..n];
    let rows = &layout.links.rows[op.ports.reach + first..][..n];
    let (x, rest) = (&s.x[..], &layout.places.rest[..]);
    let mut i = 0;
    while i < n {
        let (links, row) = stretch(rows, i);
        if row {
            let [a, b] = ends[i].map(|m| m as usize);
            let m = 3 * links;
            let (v, v_left) = S::as_mut_simd_f64s(&mut v[3 * i..][..m]);
            let ((xa, xa_left), (xb, xb_left)) = (S::as_simd_f64s(&x[a..][..m]), S::as_simd_f64s(&x[b..][..m]));
            let ((ra, ra_left), (rb, rb_left)) = (S::as_simd_f64s(&rest[a..][..m]), S::as_simd_f64s(&rest[b..][..m]));
            let steps = v.len();
            let (xa, xb, ra, rb) = (&xa[..steps], &xb[..steps], &ra[..steps], &rb[..steps]);
            for k in 0..steps {
                v[k] = simd.add_f64s(simd.sub_f64s(rb[k], ra[k]), simd.sub_f64s(xb[k], xa[k]));
            }
            for k in 0..v_left.len() {
                v_left[k] = (rb_left[k] - ra_left[k]) + (xb_left[k] - xa_left[k]);
            }
        } else {
            let mut at = 3 * i as u32;
            for ([a, b], r) in ends[i..][..links].iter().zip(&reach[i..]) {
                let to = v.get_mut(at as usize..at as usize + 4).and_then(|to| to.first_chunk_mut::<4>());
                // writes four numbers at once; the next link overwrites the last
                if let (Some(p), Some(q), Some(to)) = (four(x, *a), four(x, *b), to) {
                    let d = [q[0] - p[0], q[1] - p[1], q[2] - p[2], q[3] - p[3]];
                    let d = [r[0] + d[0], r[1] + d[1], r[2] + d[2], r[3] + d[3]];
                    *to = d;
                } else if let Some(to) = v.get_mut(at as usize..at as usize + 3) {
                    let (p, q) = (three(x, *a), three(x, *b));
                    for k in 0..3 {
                        to[k] = r[k] + (q[k] - p[k]);
                    }
                }
                at += 3;
            }
        }
        i += links;
    }
}

/// Computes the lengths of the tick before from the motion, if they are unknown.
#[cold]
#[inline(never)]
fn recall(op: &Op, layout: &Layout, s: &mut State, first: usize, v: &[f64]) {
    for (i, now) in v.as_chunks::<3>().0.iter().enumerate() {
        let [p, q] = layout.links.ends[op.first + first + i].map(|m| three(&s.d, m));
        let before: [f64; 3] = core::array::from_fn(|k| now[k] - (q[k] - p[k]));
        let at = op.ports.reach + first + i;
        let square = before[0] * before[0] + before[1] * before[1] + before[2] * before[2];
        s.links.lengths[at] = Real::sqrt(square + layout.links.reach[at][3]);
    }
}

#[inline(always)]
fn length<S: Simd>(simd: S, v: [S::f64s; 3], soft: Option<&S::f64s>) -> Lanes<S> {
    let [x, y, z] = [Lanes(simd, v[0]), Lanes(simd, v[1]), Lanes(simd, v[2])];
    let mut square = x * x + y * y + z * z;
    if let Some(soft) = soft {
        square = square + Lanes(simd, *soft);
    }
    Lanes(simd, simd.sqrt_f64s(square.1))
}

#[inline(always)]
fn along<S: Simd>(simd: S, v: [S::f64s; 3], force: S::f64s, l: S::f64s) -> [S::f64s; 3] {
    let [zero, least] = [0.0, LEAST].map(|v| simd.splat_f64s(v));
    let density = simd.select_f64s(simd.less_than_f64s(l, least), zero, simd.div_f64s(force, l));
    let g = [simd.mul_f64s(v[0], density), simd.mul_f64s(v[1], density), simd.mul_f64s(v[2], density)];
    simd.interleave_shfl_f64s(g)
}

/// A block as vectors: vectors between ends, elongations at rest, and lengths of the tick before.
type Vectors<'a, S> = (&'a mut [[<S as Simd>::f64s; 3]], &'a [<S as Simd>::f64s], &'a mut [<S as Simd>::f64s]);

#[inline(always)]
fn block<'a, S: Simd>(v: &'a mut [f64], e0: &'a [f64], last: &'a mut [f64]) -> Vectors<'a, S> {
    let steps = e0.len() / S::F64_LANES;
    let v = &mut S::as_mut_simd_f64s(v).0.as_chunks_mut::<3>().0[..steps];
    (v, &S::as_simd_f64s(e0).0[..steps], &mut S::as_mut_simd_f64s(last).0[..steps])
}

/// Returns the squared softening lengths of a block in `scratch`, if it has any.
#[inline(always)]
fn softened<'a, S: Simd>(op: &Op, layout: &Layout, first: usize, scratch: &'a mut [f64]) -> Option<&'a [S::f64s]> {
    if !op.form.soften {
        return None;
    }
    for (soft, reach) in scratch.iter_mut().zip(&layout.links.reach[op.ports.reach + first..]) {
        *soft = reach[3];
    }
    Some(S::as_simd_f64s(scratch).0)
}

/// Turns vectors into the forces on the first ends of their links, for a law with a vector form of its force.
#[inline(always)]
fn pulls<S: Simd, P: Phi<C, M>, const C: usize, const M: usize, const TAP: bool>(
    simd: S,
    op: &Op,
    layout: &Layout,
    s: &mut State,
    first: usize,
    v: &mut [f64],
) {
    let n = v.len() / 3;
    let mut columns: [&[S::f64s]; C] = [&[]; C];
    for (k, column) in columns.iter_mut().enumerate() {
        *column = &S::as_simd_f64s(&s.coef[op.coef + k * op.n + first..][..n]).0[..n / S::F64_LANES];
    }
    let lengths = &mut s.links.lengths[op.ports.reach + first..][..n];
    let (vectors, e0, last) = block::<S>(v, &layout.links.e0[op.first + first..][..n], lengths);
    let tap = S::as_mut_simd_f64s(if TAP { &mut s.links.tap[op.tap + first..][..n] } else { &mut [] }).0;
    let mut scratch = [0.0; BLOCK];
    let soft = softened::<S>(op, layout, first, &mut scratch[..n]);
    for i in 0..vectors.len() {
        let v = simd.deinterleave_shfl_f64s(vectors[i]);
        let l = length(simd, v, soft.map(|soft| &soft[i]));
        let (e, w) = (l + Lanes(simd, e0[i]), l - Lanes(simd, last[i]));
        last[i] = l.1;
        let mut c = [e; C];
        for k in 0..C {
            c[k] = Lanes(simd, columns[k][i]);
        }
        let force = P::linear(&c, e, w).1;
        if TAP {
            tap[i] = force;
        }
        vectors[i] = along(simd, v, force, l.1);
    }
}

/// Adds `g` to the forces, or subtracts it. A row takes two passes: one would read at unaligned addresses just written.
#[inline(always)]
fn added<S: Simd, const LESS: bool>(simd: S, f: &mut [f64], g: &[f64]) {
    let ((f, f_left), (g, g_left)) = (S::as_mut_simd_f64s(f), S::as_simd_f64s(g));
    for (f, g) in f.iter_mut().zip(g) {
        *f = if LESS { simd.sub_f64s(*f, *g) } else { simd.add_f64s(*f, *g) };
    }
    for (f, g) in f_left.iter_mut().zip(g_left) {
        *f = if LESS { *f - g } else { *f + g };
    }
}

#[inline(always)]
fn sums<S: Simd>(simd: S, op: &Op, layout: &Layout, s: &mut State, first: usize, g: &[f64]) {
    let n = g.len() / 3;
    let ends = &layout.links.ends[op.first + first..][..n];
    let rows = &layout.links.rows[op.ports.reach + first..][..n];
    let f = &mut s.f[..];
    let mut i = 0;
    while i < n {
        let (links, row) = stretch(rows, i);
        let g = &g[3 * i..][..3 * links];
        if row {
            let [a, b] = ends[i].map(|m| m as usize);
            added::<S, true>(simd, &mut f[b..][..3 * links], g);
            added::<S, false>(simd, &mut f[a..][..3 * links], g);
        } else {
            for ([a, b], g) in ends[i..][..links].iter().zip(g.as_chunks::<3>().0) {
                let (a, b) = (*a as usize, *b as usize);
                if let Some(f) = f.get_mut(a..a + 3) {
                    for k in 0..3 {
                        f[k] += g[k];
                    }
                }
                if let Some(f) = f.get_mut(b..b + 3) {
                    for k in 0..3 {
                        f[k] -= g[k];
                    }
                }
            }
        }
        i += links;
    }
}
