//! Computes the largest elongation of a hardening link, and its slope there.
//!
//! A scene without ports holds at most its energy at load E, which bounds the potential U(e) of each link on both sides
//! of the elongation at load. A tick adds one step. At an elongation e the speed is at most √(2(E − U)/m), so the reach
//! is the largest e + T√(2(E − U)/m). A spring at a port with a built-in gesture is judged at the stroke of the port,
//! as if its other end stood still. A contact at a port is not, because the other end yields. The reach of all other
//! links is unknown.

use crate::net::worst::WorstMat;
use crate::net::{LiaNode, MatNode, MatRole, Measure, Pruned, elongation, linearisation};
use alloc::vec::Vec;
use ca_core::Bound;
use ca_core::internal::op::{loaded, started};

/// Steps of each search.
const STEPS: usize = 60;
/// Elongation beyond any that occurs \[m\].
const FAR: f64 = 1e6;

/// Rounding of a potential \[J\].
const ROUNDING: f64 = 1e-12;

/// Cause of the largest elongation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Energy at load.
    Energy,
    /// Stroke of a port.
    Stroke,
}

/// The steepest point within reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaxElongation {
    /// Slope against elongation \[N/m\].
    pub k: f64,
    /// Slope against change of elongation \[N per m/tick\].
    pub z: f64,
    /// Largest elongation, or depth of a contact \[m\].
    pub far: f64,
    /// Cause of that elongation.
    pub cause: Cause,
}

/// Returns the steepest point of each link within reach; `None` for links with one slope or an unknown reach.
pub fn max_elongations(net: &Pruned, mats: &[WorstMat], bounds: &[Bound]) -> Vec<Option<MaxElongation>> {
    let grows = |b: &Bound| b.hardens || b.varying > 0.0 || b.power.0 > 0.0;
    let any = net.lias.iter().zip(bounds).any(|(l, b)| grows(b) && l.law.stage.is_explicit());
    let energy = if any { at_load(net, bounds) } else { None };
    let one = |(l, b): (&LiaNode, &Bound)| {
        if !grows(b) || !l.law.stage.is_explicit() || net.is_live(l.item) {
            return None;
        }
        let start = elongation::at_load(net, l)?;
        let law = Link::new(net, l);
        // The other end of a contact yields to a port.
        let stroke = if b.contact { None } else { stroke(net, l) };
        let (between, cause) = match (energy, stroke) {
            (Some(energy), _) => {
                let c: f64 = l.all_ends().flat_map(|e| net.under(e)).map(|m| mats[m as usize].c).sum();
                let [from, to] = [-1.0, 1.0].map(|side| start + side * law.farthest(start, side, energy, c));
                let from = if matches!(l.measure, Measure::Radial) { from.max(0.0) } else { from };
                ([from, to], Cause::Energy)
            }
            (None, Some(s)) => ([start - s, start + s], Cause::Stroke),
            (None, None) => return None,
        };
        let [k, z] = (l.law.at_load.steepest)(&law.coefs, &net.tables, between);
        let far = if b.contact { law.depth(between) } else { between[1].max(-between[0]) };
        Some(MaxElongation { k, z, far, cause }).filter(|r| r.k.is_finite() && r.z.is_finite())
    };
    net.lias.iter().zip(bounds).map(one).collect()
}

struct Link<'n> {
    net: &'n Pruned,
    l: &'n LiaNode,
    coefs: Vec<f64>,
}

impl<'n> Link<'n> {
    fn new(net: &'n Pruned, l: &'n LiaNode) -> Link<'n> {
        let coefs = loaded(l.law, &net.values(l.item, &l.values), net.tick_dt);
        Link { net, l, coefs }
    }

    /// Returns the potential at elongation `e` \[J\].
    fn stored(&self, e: f64) -> f64 {
        let c = &self.coefs[..];
        (self.l.law.fns.energies.stored)(c, &started(self.l.law, c, e), &self.net.tables, e, e)
    }

    /// Returns the largest change of elongation from `start` to one side, for an energy \[J\] and a mobility T²/m
    /// \[m/N\].
    fn farthest(&self, start: f64, side: f64, energy: f64, c: f64) -> f64 {
        let stored = |change: f64| self.stored(start + side * change);
        let mut high = 1e-12;
        while stored(high) < energy && high < FAR {
            high *= 2.0;
        }
        let mut low = 0.0;
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            if stored(middle) < energy { low = middle } else { high = middle }
        }
        // Including the step of the next tick, which is a concave function of the position.
        let end = high;
        let after = |e: f64| e + libm::sqrt(2.0 * c * (energy - stored(e)).max(0.0));
        let (mut low, mut high) = (0.0, end);
        for _ in 0..STEPS {
            let third = (high - low) / 3.0;
            if after(low + third) < after(high - third) { low += third } else { high -= third }
        }
        after(0.5 * (low + high)).max(end)
    }

    /// Returns the depth of a contact between these elongations.
    fn depth(&self, [from, to]: [f64; 2]) -> f64 {
        let (idle, beyond) = (self.l.law.fns.idle)(&self.coefs);
        if idle.is_finite() { (idle - from).max(0.0) } else { (to - beyond).max(0.0) }
    }
}

/// Returns whether a contact is known to have a gap at load.
pub fn is_open(net: &Pruned, l: &LiaNode) -> bool {
    let Some(e) = elongation::at_load(net, l).filter(|_| !net.is_live(l.item)) else { return false };
    let (idle, beyond) = (l.law.fns.idle)(&Link::new(net, l).coefs);
    if idle.is_finite() { e > idle } else { e < beyond }
}

/// Returns the stroke of the ports at a link \[m\], if all that move have built-in gestures.
fn stroke(net: &Pruned, l: &LiaNode) -> Option<f64> {
    let mut all = None;
    for m in l.all_ends().flat_map(|e| net.under(e)) {
        let MatRole::Port(_, inputs) = net.mats[m as usize].role else { continue };
        for input in inputs.into_iter().flatten().map(|i| &net.inputs[i as usize]) {
            let (_, points) = net.gestures.iter().find(|(name, _)| *name == input.name)?;
            let far = points.iter().map(|p| libm::fabs(p[1] - input.rest)).fold(0.0, f64::max);
            all = Some(all.unwrap_or(0.0) + far);
        }
    }
    all
}

/// Returns the energy of the scene at load \[J\]. Returns `None` if more may be added, by ports, weight, live
/// parameters, active links or negative potentials.
fn at_load(net: &Pruned, bounds: &[Bound]) -> Option<f64> {
    let alive = || net.mats.iter().zip(&net.alive).filter(|(_, alive)| **alive).map(|(m, _)| m);
    let moved =
        |m: &MatNode| net.is_live(m.item) || matches!(m.role, MatRole::Slow) || net.medium(m).gravity != [0.0; 3];
    if !net.inputs.is_empty() || net.slow || net.as_milib || alive().any(moved) {
        return None;
    }
    let mut energy = 0.0;
    for m in alive().filter(|m| !m.is_fixed()) {
        let own = linearisation::stored(net, m);
        if own.c > 0.0 {
            let square = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>();
            energy += 0.5 * (net.tick_dt * net.tick_dt / own.c * square(m.v) + own.k * square(m.dx0));
        }
    }
    for (l, b) in net.lias.iter().zip(bounds) {
        if net.is_live(l.item) || b.k < 0.0 || b.active {
            return None;
        }
        let link = Link::new(net, l);
        let held = link.stored(elongation::at_load(net, l)?);
        // A detent stores less than 0 at rest, and so can release more than it holds.
        if held.min(link.stored(0.0)) < -ROUNDING {
            return None;
        }
        energy += held.max(0.0);
    }
    Some(energy).filter(|e| e.is_finite())
}
