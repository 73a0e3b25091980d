//! Forces of links in fused passes, computed again for the outputs that read them.
//!
//! Outputs read only a few links of a mesh of a thousand, and storing all forces would cost more than computing these
//! again. The bits are those of the fused pass, since nothing has moved yet.

use super::Op;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::state::State;

/// Largest number of coefficients of a link that may be fused.
pub const COEFS: usize = 8;

/// Writes the forces of the first `op.n` of `OutputArrays::links` to [`LinkState::tap`](crate::state::LinkState::tap).
pub fn output_links<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let (x, d) = (&s.x[..], &s.d[..]);
    for h in &layout.out.links[..op.n] {
        let [a, b] = h.ends.map(|m| m as usize);
        let mut c: [R; COEFS] = [R::ZERO; COEFS];
        for (k, c) in c.iter_mut().enumerate().take(h.coefs as usize) {
            *c = s.coef[h.coef as usize + k * h.step as usize];
        }
        s.links.tap[h.tap as usize] = (h.force)(&c, &mut [], &layout.tables, (x[b] - x[a]) + h.e0, d[b] - d[a]);
    }
}
