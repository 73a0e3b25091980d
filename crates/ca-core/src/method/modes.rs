//! Links that count on the motion to come, at masses that go by their modes (docs/numerics.md §3.3).
//!
//! Such a mass is a sum over modes, x = Σ φ q, and has no inertia of its own. A force F on it moves mode j by c_j φ_j F and the mass
//! by C F with C = Σ c_j φ_j², its mobility: a number of the scene. So it is to a contact what a MAT of that mobility is, if it moves as the modes
//! do by themselves: by the force u/C, where u = Σ φ_j u_j and u_j is the change of motion of mode j by itself and by explicit
//! forces. One pass puts that force on its place before the links are solved; another takes it off again and hands what the
//! links added to the modes. No kernel of a link knows of modes, and a scene without has neither pass.
//!
//! Two masses of one group are coupled: a force on p moves r by C_pr = Σ c_j φ_pj φ_rj. Links at them are solved together, by
//! conjugate gradients ([`super::quadratised`]), which keeps the energy whatever their number; the matrix is computed at load, as
//! modes do not change. Decides against elimination one after the other, which is right for linear springs alone.

use super::free_motion;
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::{Layout, SolvedModal};
use crate::state::State;

/// Before the links: puts the force on each mass that moves it as its modes would move by themselves.
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

/// Behind them: hands what they added to the modes, and leaves the whole force on each mass for whoever hears it.
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

/// Of pushes on masses of one group, makes those that would move each as much, were it alone.
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

/// Leaves no push on such masses.
pub(super) fn clear<R: Real>(layout: &Layout<R>, push: &mut [R]) {
    for h in &layout.places.solved_modal {
        push[h.mat as usize] = R::ZERO;
    }
}

fn response(h: &SolvedModal) -> usize {
    h.tap as usize + 2
}
