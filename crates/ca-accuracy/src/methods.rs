//! The candidates, ways to compute a model: methods its modules know, and single precision, at multiples of its rate.
//!
//! Decides that a method is asked for as an author would, by a word in the model: what the compiler refuses is no way, and
//! what it would do anyway is no second one.

use super::Steps;
use super::play::{self, Columns};
use super::single::{self, SINGLE};
use ca_compile::Options;
use ca_core::{Scene, Type};
use ca_lab::Failure;
use ca_lab::catalog;
use ca_lab::load::{self, Loaded};
use ca_model::diag::Severity;

/// The method of a model that nothing is asked of.
pub const AS_WRITTEN: &str = "as written";

/// A method for the whole model.
struct Method {
    /// as people call it
    name: &'static str,
    /// of the model: method and θ
    linear: Option<(&'static str, Option<&'static str>)>,
    /// of all modules that know this word
    word: Option<&'static str>,
}

/// All there are, the model as it is first.
const METHODS: [Method; 10] = [
    Method { name: AS_WRITTEN, linear: None, word: None },
    Method { name: "centred", linear: Some(("centred", None)), word: None },
    Method { name: "implicit 1/12", linear: Some(("implicit", Some("0.08333333333333333"))), word: None },
    Method { name: "implicit 1/4", linear: Some(("implicit", Some("0.25"))), word: None },
    Method { name: "implicit 1/2", linear: Some(("implicit", Some("0.5"))), word: None },
    Method { name: "modal", linear: Some(("modal", None)), word: None },
    Method { name: "pefrl", linear: Some(("pefrl", None)), word: None },
    Method { name: "stable", linear: None, word: Some("stable") },
    Method { name: "secant", linear: None, word: Some("secant") },
    Method { name: "newton", linear: None, word: Some("newton") },
];

/// A way to compute a model.
pub struct Candidate {
    /// its name
    pub method: &'static str,
    /// multiple of the rate
    pub times: u32,
    /// what runs
    pub scene: Scene,
    /// the same with the energy ledger
    pub audited: Option<Scene>,
    /// the same in single precision, which runs in its place
    pub single: Option<Scene<f32>>,
}

impl Candidate {
    /// Plays it: what its probes read, and the nanoseconds of a sample.
    pub fn play(&self, frames: usize, steps: &mut Steps) -> Result<(Columns, f64), Failure> {
        match &self.single {
            Some(scene) => single::columns(scene, &self.scene, (frames, self.times), steps),
            None => play::columns(&self.scene, frames, self.times, steps),
        }
    }
}

/// The model by the method of this name; `None` where no module knows its word.
pub fn with_method(loaded: &Loaded, name: &str) -> Option<Loaded> {
    let method = METHODS.iter().find(|m| m.name == name)?;
    let mut model = loaded.model.clone();
    if let Some((name, theta)) = method.linear {
        model.set("model.method", name);
        if let Some(theta) = theta {
            model.set("model.theta", theta);
        }
    }
    if let Some(word) = method.word {
        let knows = |kind: &str| {
            let kinds = catalog();
            let param = kinds.get(kind).and_then(|k| k.params.iter().find(|p| p.name == "method"));
            param.is_some_and(|p| matches!(p.ty, Type::Choice(words) if words.contains(&word)))
        };
        let names: Vec<String> = model.items.iter().filter(|i| knows(&i.kind)).map(|i| i.name.clone()).collect();
        if names.is_empty() {
            return None;
        }
        for name in names {
            model.set(&format!("{name}.method"), word);
        }
    }
    Some(Loaded {
        model,
        diags: loaded.diags.clone(),
        name: loaded.name.clone(),
        clouds: loaded.clouds.clone(),
        format: loaded.format,
    })
}

/// All there are.
#[derive(Default)]
pub struct Candidates {
    /// those that compile
    pub all: Vec<Candidate>,
    /// methods that the model cannot take, and why
    pub refused: Vec<(&'static str, String)>,
    /// what the compiler warns of with a method, and not without it
    pub warned: Vec<(&'static str, String)>,
}

/// All methods at all multiples of the rate.
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

/// True where two scenes run the same passes on the same numbers.
fn same(a: &Scene, b: &Scene) -> bool {
    let names = |s: &Scene| {
        s.passes.forces.iter().chain(&s.passes.moves).map(ca_core::internal::op::Op::name).collect::<Vec<_>>()
    };
    a.state() == b.state() && names(a) == names(b)
}
