//! Run: links that join consecutive MATs, as in a string. Two passes without indices: forces, then their differences.
//! Each MAT receives the force of the link before it and then of the link after it, which is the order of the gather
//! kernel, so the bits are the same.

use super::Op;
use crate::phi::Phi;
use crate::scene::Scene;
use crate::state::State;

/// Applies the law of `op` to its chain; forces are left in [`State::tap`] from `op.tap` on.
pub fn run<P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool>(op: &Op, scene: &Scene, s: &mut State) {
    let n = op.n;
    let e0 = if OFFSET { &scene.e0[op.first..][..n] } else { &[] };
    let columns: [&[f64]; C] = core::array::from_fn(|k| &s.coef[op.coef + k * n..][..n]);
    let (x, d) = (&s.x[op.mat..][..n + 1], &s.d[op.mat..][..n + 1]);
    let mem = &mut s.mem[op.mem..][..n * M];
    let force = &mut s.tap[op.tap..][..n];
    for i in 0..n {
        let mut e = x[i + 1] - x[i];
        if OFFSET {
            e += e0[i];
        }
        let w = d[i + 1] - d[i];
        let c = core::array::from_fn(|k| columns[k][i]);
        let Some(m) = mem[i * M..].first_chunk_mut::<M>() else { continue };
        force[i] = P::force(&c, m, &scene.tables, e, w);
    }
    let f = &mut s.f[op.mat..][..n + 1];
    f[0] += force[0];
    for i in 1..n {
        f[i] = f[i] - force[i - 1] + force[i];
    }
    f[n] -= force[n - 1];
}
