//! Links between any two MATs, one by one, in order. This is the reference kernel: forces are summed in the order of
//! the links, so the bits equal a plain loop over modules.

use crate::law::Phi;
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

/// Applies the law of `op` to each of its links.
pub fn gather<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool, const TAP: bool>(
    op: &Op<R>,
    layout: &Layout<R>,
    s: &mut State<R>,
) {
    let n = op.n;
    let ends = &layout.links.ends[op.first..][..n];
    let e0 = if OFFSET { &layout.links.e0[op.first..][..n] } else { &[] };
    let columns: [&[R]; C] = core::array::from_fn(|k| &s.coef[op.coef + k * n..][..n]);
    // of equal length, so that each end needs only one bounds check
    let x = &s.x[..];
    let (d, f) = (&s.d[..x.len()], &mut s.f[..x.len()]);
    let mem = &mut s.links.mem[op.mem..][..n * M];
    for i in 0..n {
        let [a, b] = [ends[i][0] as usize, ends[i][1] as usize];
        let mut e = x[b] - x[a];
        if OFFSET {
            e += e0[i];
        }
        let c = core::array::from_fn(|k| columns[k][i]);
        // skip contacts that are open, as most are; omitting a force of 0 does not change a sum that starts at 0
        if P::CONTACT && M == 0 {
            let (from, to) = P::idle(&c);
            if e >= from && e <= to {
                if TAP {
                    s.links.tap[op.tap + i] = R::ZERO;
                }
                continue;
            }
        }
        let w = d[b] - d[a];
        // laws without memory must avoid a bounds check
        let mut none = [R::ZERO; M];
        let m = if M == 0 { &mut none } else { mem[i * M..].first_chunk_mut::<M>().unwrap_or(&mut none) };
        let force = P::force(&c, m, &layout.tables, e, w);
        f[a] += force;
        f[b] -= force;
        if TAP {
            s.links.tap[op.tap + i] = force;
        }
    }
}
