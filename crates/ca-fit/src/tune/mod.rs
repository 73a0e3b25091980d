//! Tunes parts of a model to a pitch.
//!
//! The pitch of a part comes from the modes of the whole model, not from a formula: a body on a string shifts its
//! pitch, and the scheme warps it. A generator with `f` is right at once. Other numbers are found by the secant method
//! on logarithms, since a frequency is a power of a stiffness. Each step reads the changed text.

mod instance;
mod pitch;

pub use pitch::{Scale, targets};

use ca_compile::Options;
use ca_compile::analysis::{Mode, Network, modes};
use ca_core::{Level, Scene};
use ca_edit::number::{self, Number};
use ca_edit::{Document, Place};
use ca_lab::load::{self, Loaded};
use ca_lab::{Failure, Found, catalog};
use ca_model::{Item, Model, Value};
use serde_json::{Value as Json, json};

/// Distance at which a pitch is reached \[cents\].
const MET: f64 = 1e-6;
/// Distance above which tuning has failed \[cents\].
const NEAR: f64 = 0.01;
/// Digits of a written number, enough for [`MET`].
const DIGITS: usize = 11;
/// Extra rounds over all parts, if there are several.
const SWEEPS: usize = 2;
/// Maximum number of secant steps.
const STEPS: usize = 16;

/// Part and its target pitch.
#[derive(Clone, Debug, PartialEq)]
pub struct PitchTarget {
    /// Module.
    pub part: String,
    /// Cell of a bank.
    pub cell: Option<usize>,
    /// Target pitch \[Hz\].
    pub hz: f64,
}

/// Number of the text that tunes a part.
struct Variable {
    part: String,
    /// Cell of a bank.
    cell: Option<usize>,
    place: Place,
    /// Unit of the number in SI.
    unit: &'static str,
    /// Exponent of the number in the pitch.
    slope: f64,
}

/// Result for one part.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// Module, with the cell of a bank.
    pub part: String,
    /// Target pitch \[Hz\].
    pub target: f64,
    /// Pitch before \[Hz\].
    pub before: f64,
    /// Pitch now \[Hz\].
    pub reached: f64,
    /// Number that was written.
    pub number: String,
}

impl Tuned {
    /// Distance from the target pitch \[cents\].
    pub fn off(&self) -> f64 {
        1200.0 * (self.reached / self.target).log2()
    }
}

/// Returns the result as JSON. `name` is the name of the model.
pub fn value(name: &str, done: &[Tuned]) -> Json {
    let list: Vec<Json> = done
        .iter()
        .map(|t| {
            json!({ "part": t.part, "wanted_hz": t.target, "before_hz": t.before, "heard_hz": t.reached, "off_cents": t.off(),
                "number": t.number })
        })
        .collect();
    json!({ "name": name, "tuned": list })
}

/// Checks the scene of a tuned model.
///
/// # Errors
/// [`Failure::Failed`] if it is unstable.
pub fn stable(scene: &Scene) -> Result<(), Failure> {
    if scene.certificate.level == Level::Unstable {
        return Err(Failure::Failed(
            "the tuned model would diverge; choose a lower pitch, or a higher sound rate".into(),
        ));
    }
    Ok(())
}

/// Returns the names of the parts that can be tuned: they have a pitch or a stiffness, and places of the network.
pub fn parts(model: &Model, network: &Network) -> Vec<String> {
    let has_places = |item: &&Item| network.names.iter().any(|place| is_of(place, &item.name, None));
    let tunable = model.items.iter().filter(|i| tuned_by(i).is_some()).filter(has_places);
    tunable.map(|i| i.name.clone()).collect()
}

/// Returns the parameter that tunes a module, its unit, and its exponent in the pitch.
fn tuned_by(item: &Item) -> Option<(&'static str, &'static str, f64)> {
    let has = |key: &str| item.args.iter().any(|e| e.key == key);
    match (has("f"), has("k")) {
        (true, _) => Some(("f", "Hz", 1.0)),
        (false, true) => Some(("k", "N/m", 0.5)),
        (false, false) => None,
    }
}

/// Tunes parts and returns the new text with the result for each part; `loaded` becomes the tuned model. The pitch of a
/// part is its mode number `mode` (1 is the lowest), among modes that belong mostly to it.
///
/// # Errors
/// [`Failure::Usage`] where a part is not in the model or shares its number with others; [`Failure::Failed`] where a
/// pitch is not reached or the text cannot be edited; [`Failure::Found`] where the model has errors.
pub fn tune(loaded: &mut Loaded, targets: &[PitchTarget], mode: u32) -> Result<(String, Vec<Tuned>), Failure> {
    let mut text =
        Document::read(&loaded.model.text).map_err(|e| Failure::Failed(format!("`{}`: {e}", loaded.model.file)))?;
    let mut variables = Vec::new();
    for target in targets {
        variables.push((variable(&loaded.model, &target.part, target.cell)?, target.hz));
    }
    let mut done: Vec<Tuned> = Vec::new();
    for (variable, wanted) in &variables {
        done.push(one(loaded, &mut text, variable, *wanted, mode)?);
    }
    // connected parts change each other's pitch
    for _ in 0..if variables.len() > 1 { SWEEPS } else { 0 } {
        for (t, (variable, wanted)) in done.iter_mut().zip(&variables) {
            let before = t.before;
            *t = Tuned { before, ..one(loaded, &mut text, variable, *wanted, mode)? };
        }
    }
    for (t, (variable, _)) in done.iter_mut().zip(&variables) {
        t.reached = sounding_pitch(loaded, &t.part, variable, mode)?;
        if t.off().abs() > NEAR {
            let what =
                format!("`{}` cannot be {} Hz together with the others: it is {} Hz", t.part, t.target, t.reached);
            return Err(Failure::Failed(format!("{what}; check whether they follow the same parameter")));
        }
    }
    Ok((text.to_string(), done))
}

/// Returns the number of the text that tunes a part.
fn variable(model: &Model, part: &str, cell: Option<usize>) -> Result<Variable, Failure> {
    let Some(item) = model.items.iter().find(|i| i.name == part) else {
        let names = || model.items.iter().map(|i| i.name.as_str());
        let near = ca_model::suggest::nearest(part, names());
        let hint = near.map_or_else(|| format!("it has {}", load::ticked(names())), |n| format!("did you mean `{n}`?"));
        return Err(Failure::Usage(format!("the model has no `{part}`; {hint}")));
    };
    let Some((key, unit, slope)) = tuned_by(item) else {
        return Err(Failure::Usage(format!("`{part}` has neither `f` nor `k`, so it cannot be tuned")));
    };
    let entry = item.args.iter().find(|e| e.key == key).map(|e| &e.value);
    if let Some(found) = instance::variable(model, item, entry, (key, unit, slope)) {
        return found;
    }
    if let (Some(Value::List(list)), None) = (entry, cell) {
        let n = list.len();
        return Err(Failure::Usage(format!(
            "`{part}` has {n} pitches; tune it to a scale, e.g. `--scale equal --root A4 {part}`"
        )));
    }
    // a part that follows a parameter is tuned by it
    let followed = match entry {
        Some(Value::Text(name)) => model.params.iter().find(|p| p.key == *name),
        _ => None,
    };
    let place = match followed {
        Some(p) => Place::param(Place::default(), &p.key, &p.value),
        None => Place::module(part, &item.kind, key),
    };
    let place = Place { index: cell, ..place };
    Ok(Variable { part: part.into(), cell, place, unit, slope })
}

fn one(
    loaded: &mut Loaded,
    text: &mut Document,
    variable: &Variable,
    wanted: f64,
    mode: u32,
) -> Result<Tuned, Failure> {
    let name = variable.cell.map_or(variable.part.clone(), |k| format!("{}[{k}]", variable.part));
    let Some(Number { value: mut v, has_unit }) = number::read(text, &variable.place) else {
        return Err(Failure::Failed(format!("`{name}` cannot be tuned: `{}` is not a number", variable.place)));
    };
    let before = sounding_pitch(loaded, &name, variable, mode)?;
    let (mut slope, mut now, mut written) = (variable.slope, before, format!("{v:?}"));
    for step in 0..STEPS {
        let off = (wanted / now).log2();
        if off.abs() * 1200.0 < MET {
            break;
        }
        // a number that is itself the pitch is right at once
        let next = if step == 0 && variable.slope == 1.0 && has_unit { wanted } else { v * (off / slope).exp2() };
        let outside = || {
            Failure::Failed(format!(
                "`{name}` cannot be tuned to {wanted} Hz: `{}` would leave its range",
                variable.place
            ))
        };
        if !(next.is_finite() && next > 0.0) {
            return Err(outside());
        }
        written = number::write(text, &variable.place, next, variable.unit, DIGITS).ok_or_else(outside)?;
        *loaded = load::reread(loaded, &text.to_string());
        let f = sounding_pitch(loaded, &name, variable, mode)?;
        let (moved, turned) = ((f / now).log2(), (next / v).log2());
        if turned.abs() > 1e-9 && (0.05..5.0).contains(&(moved / turned)) {
            slope = moved / turned;
        }
        (v, now) = (next, f);
    }
    let left = 1200.0 * (wanted / now).log2();
    if left.abs() > NEAR {
        let what = format!("`{name}` cannot be tuned to {wanted} Hz: the search ended at {now} Hz ({left:+.3} cents)");
        return Err(Failure::Failed(format!(
            "{what}; modules connected to it fix its pitch, or it is near half the sound rate"
        )));
    }
    Ok(Tuned { part: name, target: wanted, before, reached: now, number: written })
}

/// Pitch of a part: mode number `mode` from below, of the modes that are mostly its.
fn sounding_pitch(loaded: &Loaded, name: &str, variable: &Variable, mode: u32) -> Result<f64, Failure> {
    let options = Options { clouds: loaded.clouds.clone(), ..Options::default() };
    let network = ca_compile::linear(&loaded.model, &catalog(), &options)
        .map_err(|diags| Failure::Found(Box::new(Found { diags, model: loaded.model.clone() })))?;
    if let Some((_, code)) = network.left_out.iter().find(|(n, _)| n == name) {
        return Err(Failure::Usage(format!(
            "`{name}` is a {code}, which sounds at its `f` as written; set it with `--set {name}.f=…`"
        )));
    }
    let Some(found) = modes::modes(&network) else {
        let n = network.names.len();
        return Err(Failure::Failed(format!(
            "{n} moving places are too many to compute modes; the limit is {}",
            modes::LARGEST
        )));
    };
    let own: Vec<usize> = (0..network.names.len()).filter(|i| is_of(&network.names[*i], name, variable.cell)).collect();
    if own.is_empty() && network.unheard.iter().any(|u| u == name || (*u == variable.part && variable.cell.is_some())) {
        let from = if variable.cell.is_some() { format!("{}[*]", variable.part) } else { name.into() };
        return Err(Failure::Failed(format!(
            "no output depends on `{name}`, so it is left out of the scene; add an output, such as `[SOX]` with \
             `from = \"{from}\"`"
        )));
    }
    let most = found.list.iter().filter(|m| m.heard > 0.0 && share(&network, m, &own) > 0.5);
    let Some(m) = most.clone().nth(mode as usize - 1) else {
        let n = most.count();
        return Err(Failure::Failed(format!(
            "`{name}` has only {n} modes that belong mostly to it, so mode {mode} does not exist"
        )));
    };
    Ok(m.heard)
}

/// Returns whether a place belongs to a part.
fn is_of(place: &str, name: &str, cell: Option<usize>) -> bool {
    let rest = place.strip_prefix(name);
    rest.is_some_and(|r| r.is_empty() || r.starts_with('.') || (cell.is_none() && r.starts_with('[')))
}

/// Share of the kinetic energy of a mode in these places.
fn share(network: &Network, m: &Mode, places: &[usize]) -> f64 {
    let tick_dt = network.tick_dt;
    places.iter().map(|i| m.shape[*i] * m.shape[*i] * tick_dt * tick_dt / network.linear.dofs[*i].c).sum()
}
