//! Candidates: the methods that the modules of a model know, and single precision, at multiples of its rate.
//!
//! A method is set as an author would, by a word in the model. A method that the compiler refuses is not a candidate,
//! nor is one that leads to the same scene as another.

use super::Steps;
use super::play::{self, Columns};
use super::single::{self, SINGLE};
use ca_compile::Options;
use ca_core::{Scene, Type};
use ca_lab::Failure;
use ca_lab::catalog;
use ca_lab::load::{self, Loaded};
use ca_model::diag::Severity;

/// Name of the method of an unchanged model.
pub const AS_WRITTEN: &str = "as written";

/// Method for the whole model.
struct Method {
    name: &'static str,
    /// Method and θ of the model.
    linear: Option<(&'static str, Option<&'static str>)>,
    /// Method of all modules that know this word.
    word: Option<&'static str>,
}

/// All methods, the unchanged model first.
const METHODS: [Method; 12] = [
    Method { name: AS_WRITTEN, linear: None, word: None },
    Method { name: "ca", linear: Some(("ca", None)), word: None },
    Method { name: "centred", linear: Some(("centred", None)), word: None },
    Method { name: "implicit 1/12", linear: Some(("implicit", Some("0.08333333333333333"))), word: None },
    Method { name: "implicit 1/4", linear: Some(("implicit", Some("0.25"))), word: None },
    Method { name: "implicit 1/2", linear: Some(("implicit", Some("0.5"))), word: None },
    Method { name: "modal", linear: Some(("modal", None)), word: None },
    Method { name: "pefrl", linear: Some(("pefrl", None)), word: None },
    Method { name: "stable", linear: None, word: Some("stable") },
    Method { name: "secant", linear: None, word: Some("secant") },
    Method { name: "newton", linear: None, word: Some("newton") },
    Method { name: "auto", linear: Some(("auto", None)), word: None },
];

/// Method of a second reference: all links explicit, also those that name another method.
const EXPLICIT: Method = Method { name: "explicit", linear: Some(("ca", None)), word: Some("ca") };

pub struct Candidate {
    pub method: &'static str,
    pub times: u32,
    pub scene: Scene,
    /// The scene with the energy ledger.
    pub audited: Option<Scene>,
    /// The scene in single precision, played instead if present.
    pub single: Option<Scene<f32>>,
}

impl Candidate {
    /// Plays it and returns what its probes read, and the time per sample \[ns\].
    pub fn play(&self, frames: usize, steps: &mut Steps) -> Result<(Columns, f64), Failure> {
        match &self.single {
            Some(scene) => single::columns(scene, &self.scene, (frames, self.times), steps),
            None => play::columns(&self.scene, frames, self.times, steps),
        }
    }
}

/// Returns the changes to a model for a method, as names and values of `--set`; `None` if no module knows its word.
fn words_of(loaded: &Loaded, name: &str) -> Option<Vec<(String, String)>> {
    let method = METHODS.iter().chain([&EXPLICIT]).find(|m| m.name == name)?;
    let mut all = Vec::new();
    if let Some((name, theta)) = method.linear {
        all.push(("model.method".into(), name.into()));
        all.extend(theta.map(|theta| ("model.theta".into(), theta.into())));
    }
    if let Some(word) = method.word {
        let knows = |kind: &str| {
            let kinds = catalog();
            let param = kinds.get(kind).and_then(|k| k.params.iter().find(|p| p.name == "method"));
            param.is_some_and(|p| matches!(p.ty, Type::Choice(words) if words.contains(&word)))
        };
        let items = loaded.model.items.iter().filter(|i| knows(&i.kind));
        let words: Vec<_> = items.map(|i| (format!("{}.method", i.name), word.into())).collect();
        if words.is_empty() {
            return None;
        }
        all.extend(words);
    }
    Some(all)
}

/// Returns the changes for a method at a multiple of the rate: the sound rate stays, and each sample has more ticks.
pub fn changes(loaded: &Loaded, name: &str, times: u32) -> Option<Vec<(String, String)>> {
    let mut all = words_of(loaded, name)?;
    if times > 1 {
        let written = loaded.model.rate.iter().find(|e| e.key == "oversample").and_then(|e| e.value.number());
        let ticks = written.unwrap_or(1.0) * f64::from(times);
        all.push(("rate.oversample".into(), ticks.to_string()));
    }
    Some(all)
}

/// Returns the model with a method of this name; `None` if no module knows its word.
pub fn with_method(loaded: &Loaded, name: &str) -> Option<Loaded> {
    let mut model = loaded.model.clone();
    for (name, value) in words_of(loaded, name)? {
        model.set(&name, &value);
    }
    Some(Loaded {
        model,
        diags: loaded.diags.clone(),
        name: loaded.name.clone(),
        clouds: loaded.clouds.clone(),
        format: loaded.format,
    })
}

/// All candidates of a model.
#[derive(Default)]
pub struct Candidates {
    /// Candidates that compile.
    pub all: Vec<Candidate>,
    /// Methods that the model cannot use, with the reason.
    pub refused: Vec<(&'static str, String)>,
    /// Warnings that the compiler gives only with a method.
    pub warned: Vec<(&'static str, String)>,
}

/// Returns all methods at all multiples of the rate.
pub fn candidates(loaded: &Loaded, probes: &[String], rate: f64, times: &[u32]) -> Candidates {
    let Candidates { mut all, mut refused, mut warned } = Candidates::default();
    let mut known: Vec<&'static str> = Vec::new();
    for method in &METHODS {
        let Some(variant) = with_method(loaded, method.name) else { continue };
        for times in times {
            let options =
                Options { rate: Some(rate * f64::from(*times)), probes: probes.to_vec(), ..Options::default() };
            let (scene, diags) = load::compiled(&variant, &options);
            let Some(scene) = scene else {
                let first = diags.list.iter().find(|d| d.severity == Severity::Error);
                refused.push((method.name, first.map(|d| d.title.clone()).unwrap_or_default()));
                break;
            };
            if all.iter().any(|w: &Candidate| w.times == *times && same(&w.scene, &scene)) {
                break;
            }
            for d in diags.list.iter().filter(|d| d.severity == Severity::Warning) {
                if method.name == AS_WRITTEN {
                    known.push(d.code);
                } else if !known.contains(&d.code) && !warned.iter().any(|(m, t)| *m == method.name && *t == d.title) {
                    warned.push((method.name, d.title.clone()));
                }
            }
            let audited = load::compiled(&variant, &Options { energy: true, ..options }).0;
            all.push(Candidate { method: method.name, times: *times, scene, audited, single: None });
        }
    }
    for times in times {
        let options = Options { rate: Some(rate * f64::from(*times)), probes: probes.to_vec(), ..Options::default() };
        match (single::compiled(loaded, &options), load::compiled(loaded, &options).0) {
            (Ok(scene), Some(double)) => {
                all.push(Candidate {
                    method: SINGLE,
                    times: *times,
                    scene: double,
                    audited: None,
                    single: Some(scene),
                });
            }
            (Err(why), _) => {
                refused.push((SINGLE, why));
                break;
            }
            _ => break,
        }
    }
    Candidates { all, refused, warned }
}

/// Returns whether two scenes run the same passes on the same numbers.
pub fn same(a: &Scene, b: &Scene) -> bool {
    let names = |s: &Scene| {
        s.passes.forces.iter().chain(&s.passes.moves).map(ca_core::internal::op::Op::name).collect::<Vec<_>>()
    };
    a.state() == b.state() && names(a) == names(b)
}
