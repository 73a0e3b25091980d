//! The exact decision where the bounds leave it open: a sparse factorisation of 4 − H (docs/numerics.md §1.3).
//!
//! H has all links that are always present, with their worst slopes over live parameters, at the pose of load. A link
//! at a moving point counts at every node under it. If this is not stable, the linear links alone, with points at their
//! positions at load, show whether the scene is certainly unstable.

use super::bound::explicit;
use crate::analysis::{Factor, Linear, MovingLink, StabilityMatrix};
use crate::certify::accumulate::{Accumulated, Sums};
use crate::certify::cause::{any, faster, span};
use crate::findings::round_down;
use crate::net::linear::{Numbers, Points, Pull, dofs, links, rows};
use crate::net::linearisation::Own;
use crate::net::{LiaNode, Pruned};
use alloc::format;
use alloc::vec::Vec;
use ca_core::internal::scene::certificate::FactorVerdict;
use ca_core::{Bound, Certificate, Role, Unit};
use ca_model::diag::Diag;
use ca_model::{Model, quantity};

/// Rounding of the factorisation, as a share of the limit.
const ROUNDING: f64 = 1e-12;
/// Largest number of products spent on the worst position of a moving point, or on many contacts.
pub const WORK: usize = 2_000_000;
/// Relative accuracies of the largest eigenvalue: for a message, and if it was requested.
const MESSAGE_TOLERANCE: f64 = 1e-5;
const TOLERANCE: f64 = 1e-13;

/// The network as a matrix, and its factorisation.
pub struct Exact {
    linear: Linear,
    numbers: Numbers,
    matrix: StabilityMatrix,
    factor: Option<Factor>,
    whole: bool,
}

impl Exact {
    /// Builds the matrix of a network; `None` if nothing moves.
    pub fn new(net: &Pruned, sums: &[Sums], bounds: &[Bound]) -> Option<Exact> {
        let bounds: Vec<Bound> = bounds.iter().map(explicit).collect();
        let bounds = &bounds[..];
        let own: Vec<Own> = sums.iter().map(|s| Own { c: s.scaled_mobility, k: s.k, z: s.z, implicit: 0.0 }).collect();
        let (mut linear, numbers) = dofs(net, &own);
        let whole = links(net, bounds, &numbers, Points::Anywhere, &mut linear, |l, b| {
            l.law.stage.is_explicit() && (b.linear || !b.contact)
        });
        let matrix = StabilityMatrix::new(&linear, |_| 1.0)?;
        let factor = matrix.below(4.0 * (1.0 - ROUNDING));
        Some(Exact { linear, numbers, matrix, factor, whole })
    }

    /// Returns whether the scene is stable for all positions of points and the steepest slopes, or unstable with the
    /// linear links alone and points at their positions at load.
    pub fn verdict(&self, net: &Pruned, sums: &Accumulated) -> FactorVerdict {
        if self.is_stable() {
            return FactorVerdict::Stable;
        }
        let above = |p: StabilityMatrix| p.below(4.0 * (1.0 + ROUNDING)).is_none();
        if StabilityMatrix::new(&self.certain(net, sums), |_| 1.0).is_some_and(above) {
            FactorVerdict::Unstable
        } else {
            FactorVerdict::Open
        }
    }

    fn is_stable(&self) -> bool {
        let Some(factor) = self.factor.as_ref().filter(|_| self.whole) else { return false };
        let solves: usize = self.linear.moving_links.iter().map(|l| l.at.len()).sum();
        if solves.saturating_mul(self.linear.dofs.len()) > WORK {
            return false;
        }
        // 4 − H − Σ h b bᵀ is definite if Σ h bᵀ(4 − H)⁻¹b is below 1.
        let most = |l: &MovingLink| l.at.iter().map(|b| factor.quadratic_form(b)).fold(0.0, f64::max);
        let used: f64 = self.linear.moving_links.iter().map(|l| (l.k + 2.0 * l.z) * most(l)).sum();
        used < 1.0 - ROUNDING
    }

    /// Returns the linear links, with points at their positions at load. Masses whose sums are unsure stand still.
    fn certain(&self, net: &Pruned, sums: &Accumulated) -> Linear {
        let mut linear = Linear::default();
        linear.dofs.clone_from(&self.linear.dofs);
        linear.dofs.iter_mut().filter(|d| sums.mats[d.mat as usize].unsure).for_each(|d| d.c = 0.0);
        let counts = |l: &LiaNode, b: &Bound| b.linear && l.law.stage.is_explicit();
        let bounds: Vec<Bound> = sums.links.iter().map(explicit).collect();
        links(net, &bounds, &self.numbers, Points::AtLoad, &mut linear, counts);
        linear
    }

    /// Returns the effective mobility of a contact between its ends, held by all other links: T² bᵀS⁻¹b \[m/N\], which
    /// is T²/m for a free mass. `None` if it was not computed.
    pub fn mobility(&self, net: &Pruned, l: &LiaNode, own: &Bound) -> Option<f64> {
        let factor = self.factor.as_ref().filter(|_| l.sets.is_none())?;
        // The matrix contains permanent links, whose own part is removed again.
        let h = if own.contact { 0.0 } else { own.h() };
        let of = |b: &[(u32, f64)]| {
            let g = factor.quadratic_form(b);
            4.0 * g / (1.0 + h * g) / net.limit_ratio()
        };
        rows(net, l, &Bound::default(), &self.numbers, Points::Anywhere)
            .iter()
            .map(|row| match row {
                Pull::At(_, _, b) => of(b),
                Pull::Anywhere(at) => {
                    at.iter().map(|b| 4.0 * factor.quadratic_form(b) / net.limit_ratio()).fold(0.0, f64::max)
                }
            })
            .reduce(f64::max)
    }

    /// Returns [`Certificate::headroom`]: 4 − H − h e eᵀ is definite if h eᵀ(4 − H)⁻¹e is below 1, here for the mass with
    /// the least margin. `None` if it depends on the positions of points or takes too long.
    pub fn headroom(&self) -> Option<f64> {
        let factor = self.factor.as_ref().filter(|_| self.whole && self.linear.moving_links.is_empty())?;
        let dofs = &self.linear.dofs;
        if dofs.len().saturating_mul(dofs.len()) > WORK {
            return None;
        }
        let of = |i: usize| dofs[i].c / factor.quadratic_form(&[(i as u32, 1.0)]);
        let least = (0..dofs.len()).filter(|i| dofs[*i].c > 0.0).map(of).reduce(f64::min)?;
        (least > 0.0).then(|| libm::exp2(libm::floor(libm::log2(least))))
    }

    /// Returns bounds of the largest eigenvalue; `None` if moving points or sets make it vary.
    pub fn largest(&self, cert: &Certificate, asked: bool) -> Option<(f64, f64)> {
        let fixed = self.whole && self.linear.moving_links.is_empty();
        fixed.then(|| self.matrix.largest(cert.lower, cert.bound, if asked { TOLERANCE } else { MESSAGE_TOLERANCE }))
    }

    /// Returns the warning for a network that is unstable as a whole, with numbers that fix it.
    pub fn blame(&self, model: &Model, net: &Pruned, sums: &Accumulated, mat: usize, cert: &Certificate) -> Diag {
        let m = &net.mats[mat];
        let (linear, bounds) = (self.certain(net, sums), &sums.links);
        let largest = StabilityMatrix::new(&linear, |_| 1.0)
            .map_or(4.0, |p| p.largest(cert.lower, cert.bound, MESSAGE_TOLERANCE).1);
        let title = format!(
            "together, the links are too stiff for the masses at this {} rate (largest eigenvalue {:.4}, the limit is \
             4)",
            net.clock(),
            quantity::Plain(largest)
        );
        let d = Diag::warning("W103", title).at(span(model, net, m.item), "nearest to the limit by itself");
        let viscous = bounds.iter().any(|b| b.z > 0.0) || linear.dofs.iter().any(|p| p.z > 0.0);
        let rate = faster(net, largest, (!viscous).then_some(0.0));
        // The fix changes the link with the largest share.
        let touches = |l: &LiaNode| l.all_ends().any(|e| net.under(e).contains(&(mat as u32)));
        let most = net.lias.iter().zip(bounds).filter(|(l, b)| b.linear && l.sets.is_none() && touches(l));
        let Some((l, b)) = most.max_by(|a, b| a.1.h().total_cmp(&b.1.h())) else {
            return d.help(any(&["make the masses heavier, or soften their links", &rate]));
        };
        let d = if l.item == m.item { d } else { d.at(span(model, net, l.item), "its stiffest link") };
        let name = &net.items[l.item as usize].name;
        let single = matches!(net.items[l.item as usize].kind.role, Role::Lia(_));
        let fix = match share(net, &linear, l.item) {
            Some(s) if single && b.z == 0.0 => {
                format!("keep `k` of `{name}` below {}", quantity::show(round_down(b.k * s), Unit::STIFFNESS))
            }
            Some(s) => {
                let and = if b.z > 0.0 { " and viscous" } else { "" };
                format!("make `{name}` at most {:.1} % as stiff{and}", libm::floor(1000.0 * s) / 10.0)
            }
            None => format!("soften `{name}` and the other links of `{}`", m.name),
        };
        d.help(any(&[&fix, &rate]))
    }
}

/// Returns the largest stable share of the slopes of an item, by bisection; `None` if it is below 1 %.
fn share(net: &Pruned, linear: &Linear, item: u32) -> Option<f64> {
    let stable = |s: f64| {
        let weigh = |lia: u32| if net.lias[lia as usize].item == item { s } else { 1.0 };
        StabilityMatrix::new(linear, |r| weigh(r.lia)).is_some_and(|p| p.below(4.0).is_some())
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..14 {
        let middle = 0.5 * (low + high);
        if stable(middle) { low = middle } else { high = middle }
    }
    (low > 0.01).then_some(low)
}
