//! Heard: forces of links that a fused pass sums and keeps nowhere, computed once more for the outputs that hear them.
//!
//! Decides so because a mesh of a thousand links is heard at a few: to keep all of its forces for these would cost more than
//! these do. The bits are those of the pass, which has not moved anything yet.

use super::Op;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::state::State;

/// Most coefficients of a link that may be fused.
pub const COEFS: usize = 8;

/// Leaves the forces of the first `op.n` of [`OutputArrays::heard`](crate::op::layout::OutputArrays::heard) in [`LinkState::tap`](crate::state::LinkState::tap).
pub fn heard<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let (x, d) = (&s.x[..], &s.d[..]);
    for h in &layout.out.heard[..op.n] {
        let [a, b] = h.ends.map(|m| m as usize);
        let mut c: [R; COEFS] = [R::ZERO; COEFS];
        for (k, c) in c.iter_mut().enumerate().take(h.coefs as usize) {
            *c = s.coef[h.coef as usize + k * h.step as usize];
        }
        s.links.tap[h.tap as usize] = (h.force)(&c, &mut [], &layout.tables, (x[b] - x[a]) + h.e0, d[b] - d[a]);
    }
}
