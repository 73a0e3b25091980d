//! Links in a row between MATs a constant stride apart, as along a string (1) or across the rows of a mesh (its width).
//! No indices are read, so the loops vectorise. Each MAT receives the force of the link before it, then of the link
//! after it, as in the gather kernel, so the bits are the same.

use crate::law::Phi;
use crate::numeric::{Real, Table};
use crate::op::Op;
use crate::op::layout::Layout;
use crate::op::wide::{Body, Simd};
use crate::state::State;
use core::marker::PhantomData;

/// Computes the forces of a row and stores them in [`LinkState::tap`] from `op.tap` on.
#[inline(always)]
pub fn links<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool>(
    op: &Op<R>,
    layout: &Layout<R>,
    s: &mut State<R>,
) {
    let n = op.n;
    let e0 = if OFFSET { &layout.links.e0[op.first..][..n] } else { &[] };
    let columns: [&[R]; C] = core::array::from_fn(|k| &s.coef[op.coef + k * n..][..n]);
    let (a, b) = (op.mat, op.mat + op.form.stride);
    let (xa, xb) = (&s.x[a..][..n], &s.x[b..][..n]);
    let (da, db) = (&s.d[a..][..n], &s.d[b..][..n]);
    let (mem, force) = (&mut s.links.mem[op.mem..][..n * M], &mut s.links.tap[op.tap..][..n]);
    each::<R, P, C, M, OFFSET>([xa, xb, da, db], e0, &columns, &layout.tables, mem, force);
}

/// Loops over a row. A separate function, so that slices are known not to overlap.
#[inline(always)]
fn each<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool>(
    [xa, xb, da, db]: [&[R]; 4],
    e0: &[R],
    columns: &[&[R]; C],
    tables: &[Table<R>],
    mem: &mut [R],
    force: &mut [R],
) {
    for i in 0..force.len() {
        let mut e = xb[i] - xa[i];
        if OFFSET {
            e += e0[i];
        }
        let w = db[i] - da[i];
        let c = core::array::from_fn(|k| columns[k][i]);
        // laws without memory must avoid a bounds check, which would prevent vectorisation
        let mut none = [R::ZERO; M];
        let m = if M == 0 { &mut none } else { mem[i * M..].first_chunk_mut::<M>().unwrap_or(&mut none) };
        force[i] = P::force(&c, m, tables, e, w);
    }
}

/// Applies the law of `op` to its row.
pub struct Run<P, const C: usize, const M: usize, const OFFSET: bool>(PhantomData<P>);

impl<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool> Body<R> for Run<P, C, M, OFFSET> {
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
        links::<R, P, C, M, OFFSET>(op, layout, s);
        let (n, a, b) = (op.n, op.mat, op.mat + op.form.stride);
        let force = &s.links.tap[op.tap..][..n];
        for (f, force) in s.f[b..][..n].iter_mut().zip(force) {
            *f -= *force;
        }
        for (f, force) in s.f[a..][..n].iter_mut().zip(force) {
            *f += *force;
        }
    }
}
