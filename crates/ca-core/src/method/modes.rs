//! Links that are solved with the coming motion, at modal masses (docs/numerics.md §3.3).
//!
//! A modal mass is a sum over modes, x = Σ φ q, without inertia. A force F on it moves mode j by c_j φ_j F and the mass
//! by C F, where the mobility C = Σ c_j φ_j² is a constant of the scene. To a contact it thus acts like a MAT of this
//! mobility under the force u/C. Here u = Σ φ_j u_j, and u_j is the change of motion of mode j by itself and by
//! explicit forces. One pass sets that force before the links are solved. Another removes it and passes the forces of
//! the links on to the modes. Kernels of links are unaware of modes, and a scene without modal masses has neither pass.
//!
//! Two masses of one group are coupled: a force on p moves r by C_pr = Σ c_j φ_pj φ_rj. Links at them are solved
//! together by conjugate gradients ([`super::quadratised`]), which conserves energy for any number of links. The matrix
//! is computed at load, as modes do not change. Elimination one after the other is correct only for linear springs.

use super::free_motion;
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::{Layout, SolvedModal};
use crate::state::State;

/// Sets, before the links, the force on each mass that represents the motion of its modes by themselves.
pub fn ahead<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for h in &layout.places.solved_modal[..op.n] {
        let (m, tap, p) = (h.mat as usize, h.tap as usize, layout.places.modal[h.modal as usize]);
        let shares = &layout.places.shares[p.share as usize..][..p.n as usize];
        let change = |mode: usize| free_motion(layout, s, mode) - s.d[mode];
        let more: R = (p.first as usize..).zip(shares).map(|(mode, w)| *w * change(mode)).sum();
        let mobility = s.coef[2 * layout.counts.n_mat + m];
        // at a node of all modes nothing moves
        let force = if mobility > R::ZERO { more / mobility } else { R::ZERO };
        (s.links.tap[tap], s.links.tap[tap + 1], s.f[m]) = (s.f[m], force, force);
    }
}

/// Passes, after the links, their forces on to the modes, and leaves the whole force on each mass for outputs.
pub fn back<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for h in &layout.places.solved_modal[..op.n] {
        let (m, tap, p) = (h.mat as usize, h.tap as usize, layout.places.modal[h.modal as usize]);
        let added = s.f[m] - s.links.tap[tap + 1];
        s.f[m] = s.links.tap[tap] + added;
        let (first, n) = (p.first as usize, p.n as usize);
        let shares = &layout.places.shares[p.share as usize..][..n];
        s.f[first..][..n].iter_mut().zip(shares).for_each(|(f, w)| *f += *w * added);
    }
}

/// Converts pushes on masses of one group to the equivalent pushes on uncoupled masses.
pub(super) fn couple<R: Real>(layout: &Layout<R>, push: &mut [R], tap: &mut [R]) {
    for g in &layout.places.modal_couplings {
        let n = g.n as usize;
        let held = &layout.places.solved_modal[g.first as usize..][..n];
        let rows = layout.places.couplings[g.numbers as usize..][..n * n].chunks_exact(n);
        for (h, row) in held.iter().zip(rows) {
            tap[response(h)] = held.iter().zip(row).map(|(of, c)| *c * push[of.mat as usize]).sum();
        }
        for h in held {
            push[h.mat as usize] = tap[response(h)];
        }
    }
}

pub(super) fn clear<R: Real>(layout: &Layout<R>, push: &mut [R]) {
    for h in &layout.places.solved_modal {
        push[h.mat as usize] = R::ZERO;
    }
}

fn response(h: &SolvedModal) -> usize {
    h.tap as usize + 2
}
