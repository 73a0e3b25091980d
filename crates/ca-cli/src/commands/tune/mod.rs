//! `ca tune`: parts of a model brought to a pitch.
//!
//! Decides to ask the modes of the whole model, not a formula of one generator: what hangs on a string pulls its pitch,
//! and it is heard through the scheme. A generator that knows `f` is right at once; what is left is found by the secant
//! of two logarithms, since a frequency is a power of a stiffness. What is written is found again by reading it.

mod instance;
mod pitch;

use crate::args::{Source, TuneArgs};
use crate::load::{self, Loaded};
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_compile::Options;
use ca_compile::analysis::{Mode, Network, modes};
use ca_core::scene::certificate::Level;
use ca_lab::catalog;
use ca_model::{Model, Value, quantity};
use pitch::pitch;
use serde_json::{Value as Json, json};
use std::io::Write as _;
use std::path::Path;
use toml_edit::{DocumentMut, Item};

/// A pitch is met where it is nearer than this \[cents\].
const MET: f64 = 1e-6;
/// What is further away was not tuned \[cents\].
const NEAR: f64 = 0.01;
/// Digits of a number that is written: what [`MET`] needs.
const DIGITS: usize = 11;
/// Rounds over all parts, where there are several.
const SWEEPS: usize = 2;
/// Steps of the secant.
const STEPS: usize = 16;

/// What of the text is changed for a part, and by what it is measured.
struct Variable {
    /// the part
    part: String,
    /// of a bank, the cell
    cell: Option<usize>,
    /// keys from the root of the file to the number
    path: Vec<String>,
    /// where the number stands in a list, if in one
    place: Option<usize>,
    /// unit it is written in
    unit: &'static str,
    /// pitch over number, as powers
    slope: f64,
}

/// A part as it became.
struct Tuned {
    part: String,
    wanted: f64,
    before: f64,
    heard: f64,
    number: String,
}

impl Tuned {
    fn off(&self) -> f64 {
        1200.0 * (self.heard / self.wanted).log2()
    }
}

/// Runs the command.
pub fn run(args: &TuneArgs) -> Outcome {
    let mut loaded = load::load(&Source::of(&args.model))?;
    if loaded.is_imported() {
        return Err(Failure::Usage("a MIMS file cannot be tuned; `ca import` makes a model file of it".into()));
    }
    load::scene(&loaded, &Options::default())?;
    let mut doc: DocumentMut = loaded.model.text.parse().map_err(|e: toml_edit::TomlError| {
        Failure::Failed(format!("`{}`: it cannot be edited: {}", loaded.model.file, e.message()))
    })?;
    let mut wishes = Vec::new();
    for (part, cell, wanted) in self::wishes(args, &loaded.model)? {
        wishes.push((variable(&loaded.model, &part, cell)?, wanted));
    }
    let mut done: Vec<Tuned> = Vec::new();
    for (variable, wanted) in &wishes {
        done.push(tune(&mut loaded, &mut doc, variable, *wanted, args.mode)?);
    }
    // what hangs together moves each other
    for _ in 0..if wishes.len() > 1 { SWEEPS } else { 0 } {
        for (t, (variable, wanted)) in done.iter_mut().zip(&wishes) {
            let before = t.before;
            *t = Tuned { before, ..tune(&mut loaded, &mut doc, variable, *wanted, args.mode)? };
        }
    }
    for (t, (variable, _)) in done.iter_mut().zip(&wishes) {
        t.heard = heard(&loaded, &t.part, variable, args.mode)?;
        if t.off().abs() > NEAR {
            let what = format!("`{}` cannot be {} Hz beside the others: it is {} Hz", t.part, t.wanted, t.heard);
            return Err(Failure::Failed(format!("{what}; do they follow one parameter?")));
        }
    }
    let scene = load::scene(&loaded, &Options::default())?;
    if scene.certificate.level == Level::Unstable {
        term::findings(&scene.findings, &loaded.model);
        return Err(Failure::Failed("so tuned, the model would diverge: a lower pitch, or a higher sound rate".into()));
    }
    let text = doc.to_string();
    if args.to.in_place {
        ca_io::atomic_file::write(load::own_file(&args.model)?, text.as_bytes())?;
    } else if let Some(path) = &args.to.write {
        super::new::write(path, &text, args.to.force)?;
    }
    print(&loaded, &done, args.json)?;
    if let Some(path) = args.to.write.as_deref().or(args.to.in_place.then_some(Path::new(&args.model))) {
        term::note(&format!("written to `{}`", path.display()));
    }
    Ok(Ended::Well)
}

/// Parts, the cells of banks one by one, and the pitches they shall have.
fn wishes(args: &TuneArgs, model: &Model) -> Result<Vec<(String, Option<usize>, f64)>, Failure> {
    let usage = Failure::Usage;
    let Some((scale, root)) = args.scale.zip(args.root.as_deref()) else {
        let wish = |text: &String| {
            let (part, to) = text.split_once('=').ok_or_else(|| format!("`{text}`: write it like `low=A2`"))?;
            Ok((part.trim().to_owned(), None, pitch(to, args.a4)?))
        };
        return args.parts.iter().map(wish).collect::<Result<_, String>>().map_err(usage);
    };
    let root = pitch(root, args.a4).map_err(usage)?;
    let mut all = Vec::new();
    for part in &args.parts {
        if part.contains('=') {
            return Err(usage(format!("`{part}`: with `--scale` the scale gives the pitch; name the part alone")));
        }
        let cells = model.items.iter().find(|i| i.name == *part).and_then(|i| i.args.iter().find(|e| e.key == "f"));
        match cells.map(|e| &e.value) {
            Some(Value::List(list)) => (0..list.len()).for_each(|k| all.push((part.clone(), Some(k), 0.0))),
            _ => all.push((part.clone(), None, 0.0)),
        }
    }
    all.iter_mut().enumerate().for_each(|(n, w)| w.2 = root * scale.degree(n));
    Ok(all)
}

/// Which number of the text tunes a part.
fn variable(model: &Model, part: &str, cell: Option<usize>) -> Result<Variable, Failure> {
    let Some(item) = model.items.iter().find(|i| i.name == part) else {
        let names = || model.items.iter().map(|i| i.name.as_str());
        let near = ca_model::suggest::nearest(part, names());
        let hint =
            near.map_or_else(|| format!("there is {}", load::ticked(names())), |n| format!("did you mean `{n}`?"));
        return Err(Failure::Usage(format!("the model has no `{part}`; {hint}")));
    };
    let of = |key: &str| item.args.iter().find(|e| e.key == key);
    let (key, unit, slope) = match (of("f"), of("k")) {
        (Some(_), _) => ("f", "Hz", 1.0),
        (None, Some(_)) => ("k", "N/m", 0.5),
        (None, None) => {
            return Err(Failure::Usage(format!("`{part}` has neither `f` nor `k`, so nothing of it can be tuned")));
        }
    };
    let entry = of(key).map(|e| &e.value);
    if let Some(found) = instance::variable(model, item, entry, (key, unit, slope)) {
        return found;
    }
    if let (Some(Value::List(list)), None) = (entry, cell) {
        let n = list.len();
        return Err(Failure::Usage(format!(
            "`{part}` has {n} pitches: give it a scale, `--scale equal --root A4 {part}`"
        )));
    }
    let mut path: Vec<String> = part.split('.').map(str::to_owned).collect();
    let leaf = path.pop().unwrap_or_default();
    path.extend([item.kind.clone(), leaf, key.to_owned()]);
    // what follows a parameter is tuned by it
    if let Some(Value::Text(name)) = entry {
        if let Some(p) = model.params.iter().find(|p| p.key == *name) {
            path = vec!["param".into(), name.clone()];
            path.extend(matches!(p.value, Value::Table(_)).then(|| "value".to_owned()));
        }
    }
    Ok(Variable { part: part.into(), cell, path, place: cell, unit, slope })
}

/// The value of a variable, in SI or in the model's own.
fn number(doc: &DocumentMut, variable: &Variable) -> Option<(f64, bool)> {
    let mut at = doc.as_item();
    for key in &variable.path {
        at = at.get(key.as_str())?;
    }
    let value = match variable.place {
        Some(k) => at.as_array()?.get(k)?,
        None => at.as_value()?,
    };
    if let Some(text) = value.as_str() {
        if let Some(f) = quantity::note(text) {
            return Some((f, true));
        }
        let q = quantity::parse(text).ok()?;
        return Some((q.value, q.has_unit));
    }
    value.as_float().or(value.as_integer().map(|i| i as f64)).map(|v| (v, false))
}

/// Writes the value of a variable into the text.
fn turn(doc: &mut DocumentMut, variable: &Variable, v: f64, units: bool) -> Option<String> {
    // more would be nothing but the rounding of the search, and less could be heard by an instrument
    let v = quantity::rounded(v, DIGITS);
    let mut at: &mut Item = doc.as_item_mut();
    for key in &variable.path {
        at = at.get_mut(key.as_str())?;
    }
    let place = match variable.place {
        Some(k) => at.as_array_mut()?.get_mut(k)?,
        None => at.as_value_mut()?,
    };
    // a note stays one, since it may be that of a MIDI key too
    let note = place.as_str().filter(|t| quantity::note(t).is_some()).and_then(|_| quantity::note_of(v));
    let written = match note {
        Some(note) => format!("\"{note}\""),
        None if units => format!("\"{v:?} {}\"", variable.unit),
        None => format!("{v:?}"),
    };
    let decor = place.decor().clone();
    *place = written.parse().ok()?;
    *place.decor_mut() = decor;
    Some(written.trim_matches('"').to_owned())
}

/// Brings a part to its pitch.
fn tune(
    loaded: &mut Loaded,
    doc: &mut DocumentMut,
    variable: &Variable,
    wanted: f64,
    mode: u32,
) -> Result<Tuned, Failure> {
    let name = variable.cell.map_or(variable.part.clone(), |k| format!("{}[{k}]", variable.part));
    let Some((mut v, units)) = number(doc, variable) else {
        return Err(Failure::Failed(format!(
            "`{name}`: `{}` is not a number that can be tuned",
            variable.path.join(".")
        )));
    };
    let before = heard(loaded, &name, variable, mode)?;
    let (mut slope, mut now, mut written) = (variable.slope, before, format!("{v:?}"));
    for step in 0..STEPS {
        let off = (wanted / now).log2();
        if off.abs() * 1200.0 < MET {
            break;
        }
        // a number that is the pitch itself is right at once, whatever it was before
        let next = if step == 0 && variable.slope == 1.0 && units { wanted } else { v * (off / slope).exp2() };
        let outside = || {
            Failure::Failed(format!(
                "`{name}` cannot sound at {wanted} Hz: `{}` would leave its range",
                variable.path.join(".")
            ))
        };
        if !(next.is_finite() && next > 0.0) {
            return Err(outside());
        }
        written = turn(doc, variable, next, units).ok_or_else(outside)?;
        *loaded = ca_lab::load::reread(loaded, &doc.to_string());
        let f = heard(loaded, &name, variable, mode)?;
        let (moved, turned) = ((f / now).log2(), (next / v).log2());
        if turned.abs() > 1e-9 && (0.05..5.0).contains(&(moved / turned)) {
            slope = moved / turned;
        }
        (v, now) = (next, f);
    }
    let left = 1200.0 * (wanted / now).log2();
    if left.abs() > NEAR {
        let what = format!("`{name}` comes no nearer to {wanted} Hz than {now} Hz ({left:+.3} cents)");
        return Err(Failure::Failed(format!(
            "{what}: what hangs on it holds its pitch, or it is near half the sound rate"
        )));
    }
    Ok(Tuned { part: name, wanted, before, heard: now, number: written })
}

/// The pitch of a part: of the modes that are mostly it, number `mode` from below.
fn heard(loaded: &Loaded, name: &str, variable: &Variable, mode: u32) -> Result<f64, Failure> {
    let options = Options { clouds: loaded.clouds.clone(), ..Options::default() };
    let network = ca_compile::linear(&loaded.model, &catalog(), &options).map_err(|diags| {
        term::findings(&diags, &loaded.model);
        Failure::Reported
    })?;
    if let Some((_, code)) = network.left_out.iter().find(|(n, _)| n == name) {
        return Err(Failure::Usage(format!(
            "`{name}` is a {code}: it sounds at its `f` as written; `--set {name}.f=…`"
        )));
    }
    let Some(found) = modes::modes(&network) else {
        let n = network.names.len();
        return Err(Failure::Failed(format!(
            "{n} places move, which is too much for modes: at most {}",
            modes::LARGEST
        )));
    };
    let own: Vec<usize> = (0..network.names.len()).filter(|i| is_of(&network.names[*i], name, variable)).collect();
    if own.is_empty() && network.unheard.iter().any(|u| u == name || (*u == variable.part && variable.cell.is_some())) {
        let from = if variable.cell.is_some() { format!("{}[*]", variable.part) } else { name.into() };
        return Err(Failure::Failed(format!(
            "nothing hears `{name}`, so it is left out of the scene; hear it with an output, such as `[SOX]` with \
             `from = \"{from}\"`"
        )));
    }
    let most = found.list.iter().filter(|m| m.heard > 0.0 && share(&network, m, &own) > 0.5);
    let Some(m) = most.clone().nth(mode as usize - 1) else {
        let n = most.count();
        return Err(Failure::Failed(format!(
            "`{name}` has {n} modes that are mostly its own; number {mode} is asked for"
        )));
    };
    Ok(m.heard)
}

/// Whether a place belongs to a part.
fn is_of(place: &str, name: &str, variable: &Variable) -> bool {
    let rest = place.strip_prefix(name);
    rest.is_some_and(|r| r.is_empty() || r.starts_with('.') || (variable.cell.is_none() && r.starts_with('[')))
}

/// How much of a mode's kinetic energy is in these places.
fn share(network: &Network, m: &Mode, places: &[usize]) -> f64 {
    let tick_dt = network.tick_dt;
    places.iter().map(|i| m.shape[*i] * m.shape[*i] * tick_dt * tick_dt / network.linear.dofs[*i].c).sum()
}

fn print(loaded: &Loaded, done: &[Tuned], as_json: bool) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    if as_json {
        let list: Vec<Json> = done
            .iter()
            .map(|t| {
                json!({ "part": t.part, "wanted_hz": t.wanted, "before_hz": t.before, "heard_hz": t.heard, "off_cents": t.off(),
                    "number": t.number })
            })
            .collect();
        writeln!(out, "{:#}", json!({ "name": loaded.name, "tuned": list }))?;
        return Ok(());
    }
    writeln!(out, "{}", loaded.name)?;
    for t in done {
        let off = t.off();
        let (from, to) = (quantity::Plain(t.before), quantity::Plain(t.heard));
        writeln!(out, "  {}: {from:.4} Hz → {to:.4} Hz, {off:+.6} cents off, by {}", t.part, t.number)?;
    }
    Ok(())
}
