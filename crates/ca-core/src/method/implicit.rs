//! Linear links by the methods `centred` and `implicit`: the theta scheme on those links only (numerics 1.3, eq. 1′).
//!
//! With u the change of motion of a tick, d₊ = d + u, and F the sum of all explicit forces at the tick, those of these
//! links and of springs of the masses included,
//! ```text
//! (M/T² + Σ (θk + z/2T) b bᵀ) u = F
//! ```
//! so the matrix is inertia: only what such links join is in it, and it changes with parameters, not with time. The pass
//! replaces the forces there by those that give u, M u/T², which are the true ones; advance goes on as ever. The energy
//! of the links is ½k e e₊ + ½θk(e₊ − e)², their heat that of a centred damper, and the books close to rounding.
//!
//! Decides for one sparse factorisation for the whole scene ([`crate::ldl`]), made where coefficients are made: at load,
//! and by [`Controls`](crate::live::Controls) off the tick when a parameter changes; with it all coefficients of the
//! change step together in one tick, since half-way between two factors is the factor of neither. Between whom a port
//! goes is not known yet: it goes on as it went.

use crate::layout::{Ahead, Layout};
use crate::ldl::Pattern;
use crate::op::Op;
use crate::phi::implicit::inertia;
use crate::real::{Real, real, wide};
use crate::state::State;
use alloc::vec::Vec;

/// Replaces forces by those that the matrix of inertia lets act.
pub fn solve(_op: &Op, layout: &Layout, s: &mut State) {
    let Some(a) = &layout.ahead else { return };
    let n = layout.n_mat;
    let (factor, inertia) = s.coef[a.coef..].split_at(a.pattern.numbers());
    let (u, own) = s.ahead.split_at_mut(a.places.len());
    for (((u, own), p), inertia) in u.iter_mut().zip(&mut *own).zip(&a.places).zip(inertia) {
        let p = *p as usize;
        // what the spring and damper of a MAT of its own add to its motion, as a force
        *own = ((s.coef[p] - 1.0) * s.d[p] + s.coef[n + p] * s.x[p]) * inertia;
        *u = s.f[p] + *own;
    }
    a.pattern.solve(factor, u);
    for (((u, own), p), inertia) in u.iter().zip(&*own).zip(&a.places).zip(inertia) {
        s.f[*p as usize] = u * inertia - own;
    }
    feel(a, s);
}

/// Completes the force of links that are heard, and of what they hold.
fn feel(a: &Ahead, s: &mut State) {
    for l in &a.felt {
        let turned: Real = l.moves.iter().map(|(i, w)| w * s.ahead[*i as usize]).sum();
        let more = real(inertia(&l.coef.map(|c| wide(s.coef[c as usize])))) * turned;
        if let Some(t) = l.tap {
            s.tap[t as usize] += more;
        }
        for (p, w) in &l.held {
            s.f[*p as usize] -= w * more;
        }
    }
}

/// What the matrix is made of, for whoever factorises it: the numbers are coefficients.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inertia {
    pub(crate) pattern: Pattern,
    /// place of the mobility of each row, in the order of elimination
    pub(crate) mobility: Vec<u32>,
    /// links: places of k, z and θ, first entry and number of entries
    pub(crate) links: Vec<([u32; 3], [u32; 2])>,
    /// their entries: row and weight
    pub(crate) entries: Vec<(u32, f64)>,
}

impl Inertia {
    /// The coefficients of the factor and the inertia of each row, from those they depend on; `None` where they are beyond computing.
    pub fn factor(&self, coef: impl Fn(u32) -> f64) -> Option<Vec<f64>> {
        let own: Vec<f64> = self.mobility.iter().map(|c| 1.0 / coef(*c)).collect();
        let mut sums = own.clone();
        let mut beside = Vec::with_capacity(self.links.len());
        for (c, [first, n]) in &self.links {
            let g = inertia(&c.map(&coef));
            let ends = &self.entries[*first as usize..(first + n) as usize];
            let whole: f64 = ends.iter().map(|e| e.1).sum();
            for (k, (i, a)) in ends.iter().enumerate() {
                sums[*i as usize] += g * a * whole;
                beside.extend(ends[..k].iter().map(|(j, b)| (*i, *j, g * a * b)));
            }
        }
        let mut numbers = self.pattern.factor(sums, beside.into_iter())?;
        numbers.extend(own);
        Some(numbers)
    }

    /// How many coefficients these are.
    pub fn numbers(&self) -> usize {
        self.pattern.numbers() + self.pattern.size()
    }

    /// The places of all coefficients it depends on, rising.
    pub fn inputs(&self) -> Vec<u32> {
        let mut all: Vec<u32> = self.mobility.iter().copied().chain(self.links.iter().flat_map(|l| l.0)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}
