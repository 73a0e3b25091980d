//! Reference for a model: the closed form of its modes, or the model itself at a far higher rate.
//!
//! The closed form is used only where it covers everything: linear modules on lines, damping that does not couple
//! modes, no inputs and no weight. Otherwise three rates, each twice the last, show the order p at which the model
//! converges. If that order is possible for its scheme ([`highest`]), the last two are extrapolated to infinite rate by
//! (A − B)/(2^p − 1), and this step is also the error of the reference. A model that does not converge (chaos, a jump
//! at every tick) is reported: its reference is the finest run, with the difference of the last two as error.
//!
//! A second method computes the model at half of that rate, in the same way. If both agree within their errors, the
//! reference is known; otherwise the difference of the two is its error.
//!
//! A method of higher order replaces the model as written if its error at an eighth of that rate is smaller and both
//! agree.

use super::Steps;
use super::methods::{AS_WRITTEN, same, with_method};
use super::play::{Columns, columns};
use super::score::apart;
use ca_compile::Options;
use ca_compile::analysis::{Modes, Network, modes};
use ca_core::Scene;
use ca_lab::Failure;
use ca_lab::catalog;
use ca_lab::load::{self, Loaded};
use ca_model::{Entry, Value};

/// Origin of a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// Modes in closed form.
    Modes,
    /// The model at this multiple of the rate, and its order of convergence.
    Rate(u32, f64),
    /// The model at this multiple of the rate, which does not converge like its scheme.
    Open(u32),
}

/// Values to compare with, and how well they are known.
pub struct Reference {
    /// Values of the probes at the samples of the model's rate.
    pub columns: Columns,
    /// Probe of each column.
    pub of: Vec<usize>,
    /// Origin of the values.
    pub origin: Origin,
    /// Method of the model, if the origin is a higher rate.
    pub method: &'static str,
    /// Relative error.
    pub known: f64,
    /// Comparison with a second method; none for a closed form, and if no other method is good enough.
    pub second: Option<Second>,
}

/// A second reference beside the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Second {
    /// Its method.
    pub method: &'static str,
    /// Its relative distance from the first.
    pub apart: f64,
    /// True if the distance is within the errors of both.
    pub agrees: bool,
}

/// Damping below this does not couple modes.
const COUPLED: f64 = 1e-9;

/// Links whose force has a bend or a jump.
const BENDS: [&str; 6] = ["BUT", "HRZ", "PLK", "ATT", "LNL", "BOW"];

/// Methods that leave nothing out and may converge faster than the others.
const FINE: [&str; 3] = ["newton", "centred", "pefrl"];

/// Methods for the second reference. The first that computes the model in another way, and well enough, is used.
const OTHERS: [&str; 6] = ["auto", "explicit", "centred", "newton", "secant", "implicit 1/4"];

/// Largest relative error of a second reference.
const COARSE: f64 = 0.05;

/// Returns the best reference available.
pub fn reference(
    loaded: &Loaded,
    probes: &[String],
    plain: &Scene,
    (frames, times): (usize, u32),
    steps: &mut Steps,
) -> Result<Reference, Failure> {
    let of = &super::bodies(plain)[..];
    if let Some(columns) = closed(loaded, probes, plain, frames) {
        let origin = Origin::Modes;
        let of = of.to_vec();
        return Ok(Reference { columns, of, origin, method: AS_WRITTEN, known: 1e-12, second: None });
    }
    let mut by = |loaded: &Loaded, method, times| {
        carried(loaded, method, (probes, of), plain.rate, (frames, times), &mut *steps)
    };
    let few = times / 8;
    let mut best: Option<(Loaded, &'static str, f64)> = None;
    if few >= 4 {
        let pilot = by(loaded, AS_WRITTEN, few)?;
        for method in FINE {
            let Some(variant) = with_method(loaded, method) else { continue };
            let options = Options { rate: Some(plain.rate), probes: probes.to_vec(), ..Options::default() };
            if load::compiled(&variant, &options).0.is_none() {
                continue;
            }
            let found = by(&variant, method, few)?;
            let agree = apart(&found.columns, &pilot.columns, of) <= 2.0 * (found.known + pilot.known);
            if agree && found.known < 0.5 * best.as_ref().map_or(pilot.known, |b| b.2) {
                best = Some((variant, method, found.known));
            }
        }
    }
    let (model, method) = best.as_ref().map_or((loaded, AS_WRITTEN), |(variant, method, _)| (variant, method));
    let first = by(model, method, times)?;
    let options = Options { rate: Some(plain.rate), probes: probes.to_vec(), ..Options::default() };
    let used = load::compiled(model, &options).0;
    for other in OTHERS {
        let Some(variant) = with_method(loaded, other) else { continue };
        let scene = load::compiled(&variant, &options).0;
        if scene.is_none_or(|scene| used.as_ref().is_some_and(|used| same(used, &scene))) {
            continue;
        }
        let second = by(&variant, other, (times / 2).max(4))?;
        if second.known <= COARSE {
            return Ok(first.beside(other, &second));
        }
    }
    Ok(first)
}

impl Reference {
    /// Compares with a second reference by another method.
    fn beside(self, method: &'static str, second: &Reference) -> Reference {
        let apart = apart(&second.columns, &self.columns, &self.of);
        let agrees = apart <= 2.0 * (self.known + second.known);
        let known = self.known.max(if agrees { apart - 2.0 * second.known } else { apart });
        Reference { known, second: Some(Second { method, apart, agrees }), ..self }
    }
}

/// Plays a model at `times` its rate and extrapolates to infinite rate if it converges like its scheme.
fn carried(
    loaded: &Loaded,
    method: &'static str,
    (probes, of): (&[String], &[usize]),
    rate: f64,
    (frames, times): (usize, u32),
    steps: &mut Steps,
) -> Result<Reference, Failure> {
    let mut at = |times: u32| -> Result<Columns, Failure> {
        let rate = Some(rate * f64::from(times));
        let options = Options { rate, probes: probes.to_vec(), ..Options::default() };
        Ok(columns(&loaded.compile(&options)?.scene, frames, times, steps)?.0)
    };
    let (coarse, middle, fine) = (at(times / 4)?, at(times / 2)?, at(times)?);
    let (first, last) = (apart(&coarse, &middle, of), apart(&middle, &fine, of));
    let order = (first / last).log2();
    if !(0.7..=highest(loaded) + 0.5).contains(&order) {
        return Ok(Reference {
            columns: fine,
            of: of.to_vec(),
            origin: Origin::Open(times),
            method,
            known: last,
            second: None,
        });
    }
    let step = 1.0 / (order.exp2() - 1.0);
    let carry = |(f, m): (&Vec<f64>, &Vec<f64>)| f.iter().zip(m).map(|(f, m)| f + (f - m) * step).collect();
    let columns = fine.iter().zip(&middle).map(carry).collect();
    let (of, origin) = (of.to_vec(), Origin::Rate(times, order));
    Ok(Reference { columns, of, origin, method, known: last * step, second: None })
}

/// Returns the highest order that the method of a model can have. A higher measured order is chance, since contacts
/// close at other phases of a tick at each rate.
fn highest(loaded: &Loaded) -> f64 {
    let model = &loaded.model;
    // with a bent force, no method reaches fourth order
    if model.items.iter().any(|i| BENDS.contains(&i.kind.as_str())) {
        return 2.0;
    }
    let number = |v: &Value| match v {
        Value::Num(v) => Some(*v),
        Value::Text(t) => t.parse().ok(),
        _ => None,
    };
    let fourth = |e: &Entry| match e.key.as_str() {
        "method" => e.value == Value::Text("pefrl".into()),
        "theta" => number(&e.value).is_some_and(|v| (v - 1.0 / 12.0).abs() < 1e-3),
        _ => false,
    };
    let mut all = model.groups.iter().flat_map(|g| &g.props).chain(model.items.iter().flat_map(|i| &i.args));
    if model.meta.iter().any(fourth) || all.any(fourth) { 4.0 } else { 2.0 }
}

/// Returns the motion of the modes at the probes; `None` where they do not cover the model.
fn closed(loaded: &Loaded, probes: &[String], scene: &Scene, frames: usize) -> Option<Columns> {
    let still = scene.inputs.is_empty() && scene.about.gestures.is_empty() && scene.layout.weighed.is_empty();
    let flat = scene.symbols.iter().all(|s| s.axes == 1);
    let n = scene.counts.n_out - scene.counts.channels;
    if !still || !flat || n == 0 {
        return None;
    }
    let options = Options {
        rate: Some(scene.rate),
        probes: probes.to_vec(),
        clouds: loaded.clouds.clone(),
        ..Options::default()
    };
    // a module given by a pitch has exactly that pitch, without the stiffness by which a scheme corrects its warping
    let mut model = loaded.model.clone();
    model.set("model.method", "modal");
    for props in std::iter::once(&mut model.meta).chain(model.groups.iter_mut().map(|g| &mut g.props)) {
        props.retain(|e| e.key != "theta" && (e.key != "method" || e.value == Value::Text("modal".into())));
    }
    let network = ca_compile::linear(&model, &catalog(), &options).ok()?;
    let whole =
        network.left_out.is_empty() && network.force_outputs.is_empty() && network.linear.moving_links.is_empty();
    if !whole || network.ports.len() < n {
        return None;
    }
    let found = modes::modes(&network)?;
    if found.list.iter().any(|m| m.coupled > COUPLED) {
        return None;
    }
    let ports = &network.ports[network.ports.len() - n..];
    let mut columns = vec![vec![0.0; frames]; n];
    for (j, (x, v)) in start(&network, &found).into_iter().enumerate() {
        let mode = &found.list[j];
        let shares: Vec<f64> = ports.iter().map(|p| mode.at(&p.at)).collect();
        for t in 0..frames {
            let q = mode.free(x, v, t as f64 * f64::from(scene.oversample()));
            columns.iter_mut().zip(&shares).for_each(|(c, s)| c[t] += s * q);
        }
    }
    Some(columns)
}

/// Displacement, and motion per tick, of each mode at load.
fn start(network: &Network, found: &Modes) -> Vec<(f64, f64)> {
    let tick_dt = network.tick_dt;
    let along = |of: &[f64], shape: &[f64]| -> f64 {
        let places = network.linear.dofs.iter();
        places.zip(shape).zip(of).map(|((p, u), x)| u * tick_dt * tick_dt / p.c * x).sum()
    };
    found.list.iter().map(|m| (along(&network.x, &m.shape), tick_dt * along(&network.v, &m.shape))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(value: f64, known: f64) -> Reference {
        Reference {
            columns: vec![vec![value; 10]],
            of: vec![0],
            origin: Origin::Rate(64, 2.0),
            method: AS_WRITTEN,
            known,
            second: None,
        }
    }

    #[test]
    fn a_second_method_confirms_or_contradicts() {
        let same = reference(1.0, 1e-4).beside("auto", &reference(1.0 + 1e-4, 1e-3));
        let agrees = |r: &Reference| r.second.is_some_and(|second| second.agrees);
        assert!(agrees(&same) && same.known == 1e-4, "{}", same.known);
        // an error of the first that the second sees counts
        let off = reference(1.0, 1e-4).beside("auto", &reference(1.0 + 2.1e-4, 1e-5));
        assert!(agrees(&off) && (off.known - 1.9e-4).abs() < 1e-9, "{}", off.known);
        let other = reference(1.0, 1e-4).beside("auto", &reference(1.1, 1e-3));
        assert!(!agrees(&other) && (other.known - 0.1).abs() < 1e-9, "{}", other.known);
        assert!(other.second.is_some_and(|s| s.method == "auto" && (s.apart - 0.1).abs() < 1e-9));
    }
}
