//! Run: links that join consecutive MATs, as in a string. Two passes without indices: forces, then their differences.
//! Each MAT receives the force of the link before it and then of the link after it, which is the order of the gather
//! kernel, so the bits are the same.

use super::Op;
use super::wide::Body;
use crate::phi::Phi;
use crate::scene::Scene;
use crate::state::State;
use core::marker::PhantomData;

/// Applies the law of `op` to its chain; forces are left in [`State::tap`] from `op.tap` on.
pub struct Run<P, const C: usize, const M: usize, const OFFSET: bool>(PhantomData<P>);

impl<P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool> Body for Run<P, C, M, OFFSET> {
    #[inline(always)]
    fn run(op: &Op, scene: &Scene, s: &mut State) {
        let n = op.n;
        let e0 = if OFFSET { &scene.e0[op.first..][..n] } else { &[] };
        let columns: [&[f64]; C] = core::array::from_fn(|k| &s.coef[op.coef + k * n..][..n]);
        let (xa, xb) = (&s.x[op.mat..][..n], &s.x[op.mat + 1..][..n]);
        let (da, db) = (&s.d[op.mat..][..n], &s.d[op.mat + 1..][..n]);
        let mem = &mut s.mem[op.mem..][..n * M];
        let force = &mut s.tap[op.tap..][..n];
        for i in 0..n {
            let mut e = xb[i] - xa[i];
            if OFFSET {
                e += e0[i];
            }
            let w = db[i] - da[i];
            let c = core::array::from_fn(|k| columns[k][i]);
            // laws without memory must not carry a bounds check that keeps the loop from being vectorised
            let mut none = [0.0; M];
            let m = if M == 0 { &mut none } else { mem[i * M..].first_chunk_mut::<M>().unwrap_or(&mut none) };
            force[i] = P::force(&c, m, &scene.tables, e, w);
        }
        let f = &mut s.f[op.mat..][..n + 1];
        f[0] += force[0];
        for (f, pair) in f[1..n].iter_mut().zip(force.windows(2)) {
            *f = *f - pair[0] + pair[1];
        }
        f[n] -= force[n - 1];
    }
}
