//! The exact answer, where the cheap bounds leave it open: one sparse factorisation of 4 − H (numerics 1.3).
//!
//! Decides with the slopes of all links that are always there, at the worst corner of what may change and at the pose of
//! load. Where that is not enough and some slopes are only bounds, the linear links alone say whether the scene is
//! certainly unstable. A link at a moving point is judged at every node under it.

use super::blame::{round_down, span};
use super::worst::Row;
use crate::analysis::{Factor, Linear, Pencil};
use crate::certificate::{Certificate, Verdict};
use crate::compile::linear::{Numbers, Points, Pull, links, places, rows};
use crate::compile::net::{LiaNode, Net};
use crate::compile::slopes::Own;
use crate::kind::{Role, Unit};
use crate::law::Bound;
use crate::model::diag::Diag;
use crate::model::{Model, quantity};
use alloc::format;
use alloc::vec::Vec;

/// Rounding of the factorisation, as a share of the limit.
const ROUNDING: f64 = 1e-12;
/// Products that looking for the worst place of a moving point, or at many contacts, may take.
const WORK: usize = 2_000_000;
/// How far the largest eigenvalue is narrowed for a message, and where it was asked for.
const TOLD: f64 = 1e-5;
const ASKED: f64 = 1e-13;

/// The network as a matrix, and its factorisation.
pub struct Exact {
    linear: Linear,
    numbers: Numbers,
    pencil: Pencil,
    factor: Option<Factor>,
    whole: bool,
}

impl Exact {
    /// The matrix of a network; `None` where nothing moves.
    pub fn new(net: &Net, worst: &[Row], bounds: &[Bound]) -> Option<Exact> {
        let own: Vec<Own> = worst.iter().map(|r| Own { c: r.c, k: r.k, z: r.z }).collect();
        let (mut linear, numbers) = places(net, &own);
        let whole = links(net, bounds, &numbers, Points::Anywhere, &mut linear, |l, b| {
            !l.law.is_late() && (b.linear || !b.contact)
        });
        let pencil = Pencil::new(&linear, |_| 1.0)?;
        let factor = pencil.below(4.0 * (1.0 - ROUNDING));
        Some(Exact { linear, numbers, pencil, factor, whole })
    }

    /// Whether the scene is stable.
    pub fn verdict(&self, bounds: &[Bound]) -> Verdict {
        let Some(factor) = &self.factor else {
            // slopes that are only bounds say nothing against it
            let certain = |lia: u32| if bounds[lia as usize].linear { 1.0 } else { 0.0 };
            let linear = Pencil::new(&self.linear, |r| certain(r.lia));
            let above = linear.is_some_and(|p| p.below(4.0 * (1.0 + ROUNDING)).is_none());
            return if above { Verdict::Unstable } else { Verdict::Open };
        };
        if !self.whole {
            return Verdict::Open;
        }
        let solves: usize = self.linear.loose.iter().map(|l| l.at.len()).sum();
        if solves * self.linear.places.len() > WORK {
            return Verdict::Open;
        }
        // 4 − H − Σ h b bᵀ is definite where Σ h bᵀ(4 − H)⁻¹b is below 1; of a single link, only there
        let mut used = 0.0;
        for l in &self.linear.loose {
            used += (l.k + 2.0 * l.z) * l.at.iter().map(|b| factor.gives(b)).fold(0.0, f64::max);
        }
        match used {
            u if u < 1.0 - ROUNDING => Verdict::Stable,
            _ if self.linear.loose.len() == 1 && bounds[self.linear.loose[0].lia as usize].linear => Verdict::Unstable,
            _ => Verdict::Open,
        }
    }

    /// How easily a contact moves its two ends apart \[m/N per tick²\], with the other links that hold them: T² bᵀS⁻¹b,
    /// which is T²/m of a mass that hangs on nothing. `None` where it was not looked at.
    pub fn mobility(&self, net: &Net, l: &LiaNode, own: &Bound, contacts: usize) -> Option<f64> {
        let factor = self.factor.as_ref()?;
        if l.sets.is_some() || contacts * self.linear.places.len() > WORK {
            return None;
        }
        // what is always there is in the matrix itself, and taken out of it again
        let h = if own.contact { 0.0 } else { own.k + 2.0 * own.z };
        let of = |b: &[(u32, f64)]| {
            let g = factor.gives(b);
            4.0 * g / (1.0 + h * g)
        };
        rows(net, l, &Bound::default(), &self.numbers, Points::Anywhere)
            .iter()
            .map(|row| match row {
                Pull::At(_, b) => of(b),
                Pull::Anywhere(at) => at.iter().map(|b| 4.0 * factor.gives(b)).fold(0.0, f64::max),
            })
            .reduce(f64::max)
    }

    /// Bounds of the largest eigenvalue; `None` where points wander or sets are tied, so that it depends.
    pub fn largest(&self, cert: &Certificate, asked: bool) -> Option<(f64, f64)> {
        let fixed = self.whole && self.linear.loose.is_empty();
        fixed.then(|| self.pencil.largest(cert.lower, cert.bound, if asked { ASKED } else { TOLD }))
    }

    /// What makes the whole unstable though no module is by itself, and the numbers that would mend it.
    pub fn blame(&self, model: &Model, net: &Net, bounds: &[Bound], mat: usize, cert: &Certificate) -> Diag {
        let m = &net.mats[mat];
        let (_, largest) = self.pencil.largest(cert.lower, cert.bound, TOLD);
        let title = format!(
            "too stiff for the masses at this sound rate, all together: {:.4}, the limit is 4",
            quantity::Plain(largest)
        );
        let d = Diag::warning("W103", title).at(span(model, net, m.item), "nearest to the limit by itself");
        let viscous = bounds.iter().any(|b| b.z > 0.0) || self.linear.places.iter().any(|p| p.z > 0.0);
        let faster = if viscous { largest / 4.0 } else { libm::sqrt(largest / 4.0) };
        let rate = format!("raise the sound rate above {:.0} Hz", quantity::Plain(net.rate * faster));
        // the link there that weighs most is the one to change
        let touches = |l: &LiaNode| l.all_ends().any(|e| net.under(e).contains(&(mat as u32)));
        let most = net.lias.iter().zip(bounds).filter(|(l, b)| b.linear && l.sets.is_none() && touches(l));
        let Some((l, b)) = most.max_by(|a, b| (a.1.k + 2.0 * a.1.z).total_cmp(&(b.1.k + 2.0 * b.1.z))) else {
            return d.help(rate);
        };
        let d = if l.item == m.item { d } else { d.at(span(model, net, l.item), "its stiffest link") };
        let name = &net.items[l.item as usize].name;
        let single = matches!(net.items[l.item as usize].kind.role, Role::Lia(_));
        let fix = match self.share(net, l.item) {
            Some(s) if single && b.k >= 2.0 * b.z => {
                format!("keep `k` of `{name}` below {}", quantity::show(round_down(b.k * s), Unit::STIFFNESS))
            }
            Some(s) => {
                let and = if b.z > 0.0 { " and viscous" } else { "" };
                format!("make `{name}` at most {:.1} % as stiff{and}", libm::floor(1000.0 * s) / 10.0)
            }
            None => format!("soften `{name}` and what else holds `{}`", m.name),
        };
        d.help(format!("{fix}, or {rate}"))
    }

    /// The largest share of the slopes of one item's links that would be stable.
    fn share(&self, net: &Net, item: u32) -> Option<f64> {
        let stable = |s: f64| {
            let weigh = |lia: u32| if net.lias[lia as usize].item == item { s } else { 1.0 };
            Pencil::new(&self.linear, |r| weigh(r.lia)).is_some_and(|p| p.below(4.0).is_some())
        };
        if !stable(0.0) {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..14 {
            let middle = 0.5 * (low + high);
            if stable(middle) { low = middle } else { high = middle }
        }
        (low > 0.0).then_some(low)
    }
}
