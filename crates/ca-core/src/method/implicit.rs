//! Linear links by `centred` and `implicit`: the theta scheme for those links only (docs/numerics.md §1.3, eq. 1′).
//!
//! Let u be the change of motion in a tick, d₊ = d + u, and F the sum of all explicit forces at the tick, including
//! these links and the springs of the masses:
//! ```text
//! (M/T² + Σ (θk + z/2T) b bᵀ) u = F
//! ```
//! The matrix is an inertia. It contains only what such links join, and it changes with parameters but not with time.
//! The pass replaces the forces there by M u/T², the true forces, which give u; integration follows as usual.
//!
//! A link that shares no mass with another implicit link needs no matrix. Let w be the change of its elongation by all
//! explicit forces, γ = θk + z/2T, and c the mobility of its ends; then it changes by w/(1 + γc). The links store ½k e
//! e₊ + ½θk(e₊ − e)² and lose the heat of a centred damper, and the ledgers balance to rounding.
//!
//! The whole scene has one sparse factorisation ([`crate::numeric::ldl`]). It is computed where coefficients are: at
//! load, and by [`Controls`](crate::live::Controls) outside the tick when a parameter changes. All coefficients of such
//! a change step together in one tick, since halfway between two factors is not a factor of either matrix. Ports at
//! such links run a tick late, so that their motion is known.

use crate::numeric::Real;
use crate::numeric::ldl::Pattern;
use crate::op::Op;
use crate::op::layout::{ImplicitLinks, Layout, LinkForce};
use crate::state::State;
use alloc::vec::Vec;

/// Returns the inertia that a link with these coefficients adds \[N per m/tick²\].
pub fn inertia(&[k, z, theta]: &[f64; 3]) -> f64 {
    theta * k + 0.5 * z
}

/// Replaces the explicit forces by the true ones, through the matrix of inertia.
pub fn solve<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some(a) = &layout.implicit else { return };
    let n = layout.counts.n_mat;
    let (factor, inertia) = s.coef[a.coef..].split_at(a.pattern.numbers());
    let (u, own) = s.links.implicit.split_at_mut(a.places.len());
    for (((u, own), p), inertia) in u.iter_mut().zip(&mut *own).zip(&a.places).zip(inertia) {
        let p = *p as usize;
        // motion that the spring and damper of a MAT add, as a force
        *own = ((s.coef[p] - R::of(1.0)) * s.d[p] + s.coef[n + p] * s.x[p]) * *inertia;
        *u = s.f[p] + *own;
    }
    if !s.ports.turns.is_empty() {
        for l in &a.forces {
            let turned = turned(l, &s.ports.turns);
            if turned != R::ZERO {
                let more = R::of(self::inertia(&l.coef.map(|c| s.coef[c as usize].wide()))) * turned;
                l.moving.iter().for_each(|(i, w)| u[*i as usize] -= *w * more);
            }
        }
    }
    a.pattern.solve(factor, u);
    for (((u, own), p), inertia) in u.iter().zip(&*own).zip(&a.places).zip(inertia) {
        s.f[*p as usize] = *u * *inertia - *own;
    }
    feel(a, s);
}

/// Returns the contribution of ports to the change of motion of a link.
fn turned<R: Real>(l: &LinkForce<R>, turns: &[R]) -> R {
    l.fixed.iter().map(|(p, w)| *w * turns[*p as usize]).sum()
}

/// Completes the forces of links that outputs read, and the forces on MATs that forces do not move.
fn feel<R: Real>(a: &ImplicitLinks<R>, s: &mut State<R>) {
    for l in &a.forces {
        let mut turned: R = l.moving.iter().map(|(i, w)| *w * s.links.implicit[*i as usize]).sum();
        if !s.ports.turns.is_empty() {
            turned += self::turned(l, &s.ports.turns);
        }
        let more = R::of(inertia(&l.coef.map(|c| s.coef[c as usize].wide()))) * turned;
        if let Some(t) = l.tap {
            s.links.tap[t as usize] += more;
        }
        for (p, w) in &l.fixed {
            s.f[*p as usize] -= *w * more;
        }
    }
}

/// Does the same for links that share no mass with another implicit link.
///
/// The motion of each end is a common part plus 1/(1 + γc) of its free motion, never a force and its opposite. The
/// force from before the tick may be 10⁶ times the resulting one, and its last digit would stretch the link.
pub fn pairs<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some(implicit) = &layout.implicit else { return };
    let n = layout.counts.n_mat;
    let (p, q, c, turns) = (&s.coef[..n], &s.coef[n..2 * n], &s.coef[2 * n..3 * n], &s.ports.turns[..]);
    let numbers = s.coef[op.coef..].chunks_exact(OF_PAIR);
    for (pair, numbers) in implicit.pairs.iter().zip(numbers) {
        let [a, b] = pair.ends.map(|i| i as usize);
        let &[g, left, inertia_a, inertia_b] = numbers else { continue };
        let own = |i: usize| {
            let own = (p[i] - R::of(1.0)) * s.d[i] + q[i] * s.x[i];
            turns.get(i).map_or(own, |turns| own + *turns)
        };
        let (own_a, own_b) = (own(a), own(b));
        let (free_a, free_b) = (c[a] * s.f[a] + own_a, c[b] * s.f[b] + own_b);
        let common = g * left * (c[b] * free_a + c[a] * free_b);
        let more = g * left * (free_b - free_a);
        let acts = |i: usize, free: R, own: R, inertia: R, more: R| {
            // an end that forces do not move gets the full force
            if inertia == R::ZERO { s.f[i] + more } else { (common + left * free - own) * inertia }
        };
        let acting = (acts(a, free_a, own_a, inertia_a, more), acts(b, free_b, own_b, inertia_b, -more));
        (s.f[a], s.f[b]) = acting;
        if let Some(t) = pair.tap {
            s.links.tap[t as usize] += more;
        }
    }
}

/// Numbers per pair: γ, 1/(1 + γc), and the inertia of both ends, 0 for an end that forces do not move.
const OF_PAIR: usize = 4;

/// Structure of the matrix, from which it is factorised. The resulting numbers are coefficients.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Inertia {
    /// pattern of the factor
    pub pattern: Pattern,
    /// index of the mobility coefficient of each row, in elimination order
    pub mobility: Vec<u32>,
    /// links: indices of the coefficients k, z and θ, first entry and number of entries
    pub links: Vec<([u32; 3], [u32; 2])>,
    /// entries of the links: row and weight
    pub entries: Vec<(u32, f64)>,
    /// pairs: indices of the coefficients k, z and θ, and of the mobility of both ends
    pub pairs: Vec<([u32; 3], [u32; 2])>,
}

impl Inertia {
    /// Replaces `out` by the coefficients of the factor, the inertia of each row and the numbers of each pair. Returns
    /// false, with `out` useless, if a number is not finite or the matrix not positive definite.
    ///
    /// `around` is working memory. Nothing is allocated once both have their capacity.
    pub fn factor(&self, coef: impl Fn(u32) -> f64, out: &mut Vec<f64>, around: &mut Vec<f64>) -> bool {
        let ends = |first: u32, n: u32| &self.entries[first as usize..(first + n) as usize];
        out.clear();
        out.extend(self.mobility.iter().map(|c| 1.0 / coef(*c)));
        for (c, [first, n]) in &self.links {
            let (g, ends) = (inertia(&c.map(&coef)), ends(*first, *n));
            let whole: f64 = ends.iter().map(|e| e.1).sum();
            for (i, a) in ends {
                out[*i as usize] += g * a * whole;
            }
        }
        let beside = self.links.iter().flat_map(|(c, [first, n])| {
            let (g, ends) = (inertia(&c.map(&coef)), ends(*first, *n));
            let before = move |k: usize, (i, a): (u32, f64)| ends[..k].iter().map(move |(j, b)| (i, *j, g * a * b));
            ends.iter().enumerate().flat_map(move |(k, e)| before(k, *e))
        });
        if !self.pattern.factor(out, around, beside) {
            return false;
        }
        out.extend(self.mobility.iter().map(|c| 1.0 / coef(*c)));
        for (c, ends) in &self.pairs {
            let (g, c) = (inertia(&c.map(&coef)), ends.map(&coef));
            let stiff = 1.0 + g * (c[0] + c[1]);
            if !stiff.is_finite() {
                return false;
            }
            let [a, b] = c.map(|c| if c == 0.0 { 0.0 } else { 1.0 / c });
            out.extend([g, 1.0 / stiff, a, b]);
        }
        out.iter().all(|v| v.is_finite())
    }

    /// Returns the number of these coefficients.
    pub fn numbers(&self) -> usize {
        self.pattern.numbers() + self.pattern.size() + OF_PAIR * self.pairs.len()
    }

    /// Returns the indices of all coefficients that they depend on, rising.
    pub fn inputs(&self) -> Vec<u32> {
        let pairs = self.pairs.iter().flat_map(|(c, ends)| c.iter().chain(ends).copied());
        let mut all: Vec<u32> =
            self.mobility.iter().copied().chain(self.links.iter().flat_map(|l| l.0)).chain(pairs).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}
