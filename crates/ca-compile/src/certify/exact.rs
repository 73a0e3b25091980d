//! The exact answer, where the cheap bounds leave it open: one sparse factorisation of 4 − H (docs/numerics.md §1.3).
//!
//! Decides with the slopes of all links that are always there, at the worst corner of what may change and at the pose of
//! load; a link at a moving point counts at every node under it. Where that is not enough, the linear links alone, with
//! the points where they are at load, say whether the scene is certainly unstable.

use super::bound::explicit;
use crate::analysis::{Factor, Linear, MovingLink, StabilityMatrix};
use crate::certify::accumulate::Sums;
use crate::certify::blame::{any, faster, span};
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
/// Products that looking for the worst place of a moving point, or at many contacts, may take.
pub const WORK: usize = 2_000_000;
/// How far the largest eigenvalue is narrowed for a message, and where it was asked for.
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
    /// The matrix of a network; `None` where nothing moves.
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

    /// Whether the scene is stable: surely wherever points stand and whatever is the steepest, or surely not with the
    /// linear links alone and the points where they are at load.
    pub fn verdict(&self, net: &Pruned, bounds: &[Bound]) -> FactorVerdict {
        if self.is_stable() {
            return FactorVerdict::Stable;
        }
        let above = |p: StabilityMatrix| p.below(4.0 * (1.0 + ROUNDING)).is_none();
        if StabilityMatrix::new(&self.certain(net, bounds), |_| 1.0).is_some_and(above) {
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
        // 4 − H − Σ h b bᵀ is definite where Σ h bᵀ(4 − H)⁻¹b is below 1
        let most = |l: &MovingLink| l.at.iter().map(|b| factor.quadratic_form(b)).fold(0.0, f64::max);
        let used: f64 = self.linear.moving_links.iter().map(|l| (l.k + 2.0 * l.z) * most(l)).sum();
        used < 1.0 - ROUNDING
    }

    /// What is there for certain: the linear links, with the points where they are at load.
    fn certain(&self, net: &Pruned, bounds: &[Bound]) -> Linear {
        let mut linear = Linear::default();
        linear.dofs.clone_from(&self.linear.dofs);
        let counts = |l: &LiaNode, b: &Bound| b.linear && l.law.stage.is_explicit();
        let bounds: Vec<Bound> = bounds.iter().map(explicit).collect();
        links(net, &bounds, &self.numbers, Points::AtLoad, &mut linear, counts);
        linear
    }

    /// How easily a contact moves its two ends apart \[m/N per tick²\], with the other links that hold them: T² bᵀS⁻¹b,
    /// which is T²/m of a mass that hangs on nothing. `None` where it was not looked at.
    pub fn mobility(&self, net: &Pruned, l: &LiaNode, own: &Bound) -> Option<f64> {
        let factor = self.factor.as_ref().filter(|_| l.sets.is_none())?;
        // what is always there is in the matrix itself, and taken out of it again
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

    /// What [`Certificate::room`] says: 4 − H − h e eᵀ is definite where h eᵀ(4 − H)⁻¹e is below 1, for the mass that leaves
    /// least. `None` where that depends on where points are, or would take long.
    pub fn room(&self) -> Option<f64> {
        let factor = self.factor.as_ref().filter(|_| self.whole && self.linear.moving_links.is_empty())?;
        let dofs = &self.linear.dofs;
        if dofs.len().saturating_mul(dofs.len()) > WORK {
            return None;
        }
        let of = |i: usize| dofs[i].c / factor.quadratic_form(&[(i as u32, 1.0)]);
        let least = (0..dofs.len()).filter(|i| dofs[*i].c > 0.0).map(of).reduce(f64::min)?;
        (least > 0.0).then(|| libm::exp2(libm::floor(libm::log2(least))))
    }

    /// Bounds of the largest eigenvalue; `None` where points wander or sets are tied, so that it depends.
    pub fn largest(&self, cert: &Certificate, asked: bool) -> Option<(f64, f64)> {
        let fixed = self.whole && self.linear.moving_links.is_empty();
        fixed.then(|| self.matrix.largest(cert.lower, cert.bound, if asked { TOLERANCE } else { MESSAGE_TOLERANCE }))
    }

    /// What makes the whole unstable though no module is by itself, and the numbers that would mend it.
    pub fn blame(&self, model: &Model, net: &Pruned, bounds: &[Bound], mat: usize, cert: &Certificate) -> Diag {
        let m = &net.mats[mat];
        let linear = self.certain(net, bounds);
        let largest = StabilityMatrix::new(&linear, |_| 1.0)
            .map_or(4.0, |p| p.largest(cert.lower, cert.bound, MESSAGE_TOLERANCE).1);
        let title = format!(
            "too stiff for the masses at this {} rate, all together: {:.4}, the limit is 4",
            net.clock(),
            quantity::Plain(largest)
        );
        let d = Diag::warning("W103", title).at(span(model, net, m.item), "nearest to the limit by itself");
        let viscous = bounds.iter().any(|b| b.z > 0.0) || linear.dofs.iter().any(|p| p.z > 0.0);
        let rate = faster(net, largest, viscous);
        // the link there that weighs most is the one to change
        let touches = |l: &LiaNode| l.all_ends().any(|e| net.under(e).contains(&(mat as u32)));
        let most = net.lias.iter().zip(bounds).filter(|(l, b)| b.linear && l.sets.is_none() && touches(l));
        let Some((l, b)) = most.max_by(|a, b| a.1.h().total_cmp(&b.1.h())) else {
            return d.help(any(&["make the masses heavier, or soften what holds them", &rate]));
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
            None => format!("soften `{name}` and what else holds `{}`", m.name),
        };
        d.help(any(&[&fix, &rate]))
    }
}

/// The largest share of the slopes of one item's links that would be stable; `None` where it is next to nothing.
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
