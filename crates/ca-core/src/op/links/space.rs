//! Links between points in space, one by one, in order: contacts, links along a direction, and the remainder of
//! [`Blocks`](super::radial::Blocks), with the same bits. The force of the law acts along the measured direction. An
//! open contact costs a squared distance and no square root.

use super::measure::Measure;
use crate::law::Phi;
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;
use core::ops::Range;

/// Applies the law of `op` to each of its links.
pub fn space<R: Real, P: Phi<C, M>, G: Measure, const C: usize, const M: usize, const TAP: bool>(
    op: &Op<R>,
    layout: &Layout<R>,
    s: &mut State<R>,
) {
    links::<R, P, G, C, M, TAP>(op, layout, s, 0..op.n);
}

/// Applies the law to the links in the range `some`.
#[inline(always)]
pub fn links<R: Real, P: Phi<C, M>, G: Measure, const C: usize, const M: usize, const TAP: bool>(
    op: &Op<R>,
    layout: &Layout<R>,
    s: &mut State<R>,
    some: Range<usize>,
) {
    let n = op.n;
    let ends = &layout.links.ends[op.first..][..n];
    let e0 = &layout.links.e0[op.first..][..n];
    let reach = &layout.links.reach[op.ports.reach..][..n];
    let lengths = &mut s.links.lengths[op.ports.reach..][..n];
    let columns: [&[R]; C] = core::array::from_fn(|k| &s.coef[op.coef + k * n..][..n]);
    let (x, d, f) = (&s.x[..], &s.d[..], &mut s.f[..]);
    let mem = &mut s.links.mem[op.mem..][..n * M];
    for i in some {
        let at = ends[i].map(|m| m as usize);
        let c = core::array::from_fn(|k| columns[k][i]);
        // a law with memory must be called when it is released
        let passes = P::CONTACT && M == 0;
        if passes {
            let (from, to) = P::idle(&c);
            let (from, to) = (from.max(R::ZERO), to.max(R::ZERO));
            if G::square(x, at, &reach[i]).is_some_and(|l| l >= from * from && l <= to * to) {
                if TAP {
                    s.links.tap[op.tap + i] = R::ZERO;
                }
                continue;
            }
        }
        let measured =
            if passes { G::measure(x, d, at, &reach[i]) } else { G::follow(x, d, at, &reach[i], &mut lengths[i]) };
        let Some(m) = mem[i * M..].first_chunk_mut::<M>() else { continue };
        let force = P::force(&c, m, &layout.tables, measured.e + e0[i], measured.w);
        G::pull(f, at, &measured, force);
        if TAP {
            s.links.tap[op.tap + i] = force;
        }
    }
}
