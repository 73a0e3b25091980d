//! Work with the text of a model: plans, renders, findings.
//!
//! A page asks by a JSON object and receives one, in some cases with bytes behind it: a plan, or a WAV file.

use crate::engine::Facts;
use ca_compile::{Options, analysis};
use ca_core::Scene;
use ca_core::internal::kind::cloud::Unread;
use ca_fit::tune::{self, Scale};
use ca_io::level_and_fade::fade_end;
use ca_io::sound::wav_bytes;
use ca_lab::catalog;
use ca_lab::facts::certificate::stability;
use ca_lab::facts::modes::value;
use ca_lab::{Failure, load};
use ca_model::diag::{Diags, Severity};
use ca_model::{Model, render};
use cordis_anima::{Compiled, Loaded};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A model as a page sends it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Source {
    /// Name of its file.
    pub file: String,
    /// Text.
    pub text: String,
    /// Texts of the files from which it takes parts, by name.
    pub files: BTreeMap<String, String>,
    /// Changed values, by name, in order.
    pub changes: Vec<(String, String)>,
    /// Limit on the number of modules; none if 0. Pages set it for models from a link.
    pub limit: usize,
}

/// A request of a page.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Ask {
    /// Compiles a model. The answer has the plan as bytes.
    Compile(Source),
    /// Reports the findings about a model, and its stability.
    Check(Source),
    /// Computes the modes of the linear part of a model.
    Modes(Source),
    /// Tunes parts of a model.
    Tune {
        #[serde(flatten)]
        source: Source,
        #[serde(flatten)]
        to: Tuning,
    },
    /// Plays a model with its own gesture. The answer has a WAV file as bytes.
    Render {
        #[serde(flatten)]
        source: Source,
        /// Duration \[s\]; the duration in the model if `None`.
        seconds: Option<f64>,
    },
    /// Makes a WAV file of samples, which are behind the request: `f32`, interleaved.
    Wav { file: String, rate: f64, channels: usize },
}

/// Parts to tune, and their pitches.
#[derive(Clone, Debug, Deserialize)]
#[serde(default)]
struct Tuning {
    /// Parts with their pitches, such as `low=A2`; only the parts if there is a scale.
    parts: Vec<String>,
    /// Name of a scale.
    scale: Option<String>,
    /// Pitch of the first degree of the scale.
    root: Option<String>,
    /// Pitch of the note A4 \[Hz\].
    a4: f64,
    /// Number of the mode, from 1.
    mode: u32,
}

impl Default for Tuning {
    fn default() -> Tuning {
        Tuning { parts: Vec::new(), scale: None, root: None, a4: 440.0, mode: 1 }
    }
}

/// Longest sound of a render \[s\].
const LONGEST: f64 = 600.0;

/// Answers a request, a JSON text, in some cases with bytes: an object, and bytes.
pub fn answer(request: &[u8], bytes: &[u8]) -> (Value, Vec<u8>) {
    finished(match serde_json::from_slice(request) {
        Ok(Ask::Compile(source)) => compile(&source),
        Ok(Ask::Check(source)) => check(&source),
        Ok(Ask::Modes(source)) => modes(&source),
        Ok(Ask::Tune { source, to }) => tuned(&source, &to),
        Ok(Ask::Render { source, seconds }) => sound(&source, seconds),
        Ok(Ask::Wav { file, rate, channels }) => wav(&file, rate, channels, bytes),
        Err(why) => Err(refused(format!("the request cannot be read: {why}"))),
    })
}

/// Marks an answer with `ok`.
pub(crate) fn finished(done: Answer) -> (Value, Vec<u8>) {
    match done {
        Ok((mut object, bytes)) => {
            object["ok"] = true.into();
            (object, bytes)
        }
        Err(mut object) => {
            object["ok"] = false.into();
            (object, Vec::new())
        }
    }
}

/// An object and bytes, or an object with the reason as `text`.
pub(crate) type Answer = Result<(Value, Vec<u8>), Value>;

/// An object with the reason of a refusal.
pub(crate) fn refused(text: impl Into<String>) -> Value {
    json!({"text": text.into()})
}

fn compile(source: &Source) -> Answer {
    let (loaded, compiled) = compiled(source)?;
    let Compiled { scene, findings, .. } = compiled;
    let facts = Facts {
        name: loaded.name.clone(),
        stability: stability(&scene.certificate),
        warnings: warnings(&findings, &loaded.model),
    };
    let object = json!({"facts": facts, "findings": render::json(&findings, &loaded.model), "rate": scene.rate});
    Ok((object, scene.to_bytes()))
}

fn check(source: &Source) -> Answer {
    let (loaded, Compiled { scene, findings, .. }) = compiled(source)?;
    let text = render::text(&findings, &loaded.model, false);
    let object = json!({
        "text": text,
        "findings": render::json(&findings, &loaded.model),
        "stability": stability(&scene.certificate),
        "masses": scene.mats(),
        "links": scene.lias(),
    });
    Ok((object, Vec::new()))
}

fn modes(source: &Source) -> Answer {
    let (loaded, _) = compiled(source)?;
    let network = ca_compile::linear(&loaded.model, &catalog(), &Options::default());
    let network = network.map_err(|diags| refused(render::text(&diags, &loaded.model, false)))?;
    if network.linear.dofs.is_empty() {
        return Err(refused("nothing in the linear part of this model moves"));
    }
    let found = analysis::modes::modes(&network);
    let many = format!("more than {} places move, which is too many for a table of modes", analysis::modes::LARGEST);
    let found = found.ok_or_else(|| refused(many))?;
    let mut object = value(&loaded.name, &network, &found);
    object["parts"] = tune::parts(&loaded.model, &network).into();
    Ok((object, Vec::new()))
}

fn tuned(source: &Source, to: &Tuning) -> Answer {
    let Tuning { parts, scale, root, a4, mode } = to;
    if parts.is_empty() {
        return Err(refused("name a part and its pitch, such as `low=A2`"));
    }
    if !source.changes.is_empty() {
        return Err(refused("tuning changes the text of the model; write `changes` into the text first"));
    }
    if !(1.0..=20_000.0).contains(a4) || !(1..=1000).contains(mode) {
        return Err(refused("`a4` must be between 1 and 20000 Hz, and `mode` between 1 and 1000"));
    }
    let scale = match (scale, root) {
        (None, None) => None,
        (Some(name), Some(root)) => {
            let names = || Scale::ALL.iter().map(|s| s.0);
            let unknown = || refused(format!("`{name}` is not a scale; the scales are {}", load::ticked(names())));
            Some((Scale::named(name).ok_or_else(unknown)?, root.as_str()))
        }
        _ => return Err(refused("a scale needs the pitch of its root, and a root needs a scale")),
    };
    let (mut loaded, _) = compiled(source)?;
    let targets = tune::targets(&loaded.model, parts, scale, *a4).map_err(failed)?;
    let (text, done) = tune::tune(&mut loaded, &targets, *mode).map_err(failed)?;
    let compiled = loaded.compile(&Options::default()).map_err(|found| failed(Failure::Found(found)))?;
    tune::stable(&compiled.scene).map_err(failed)?;
    let mut object = tune::value(&loaded.name, &done);
    object["text"] = text.into();
    Ok((object, Vec::new()))
}

fn sound(source: &Source, seconds: Option<f64>) -> Answer {
    let (loaded, Compiled { scene, .. }) = compiled(source)?;
    let seconds = seconds.map(|s| if s <= LONGEST { Ok(s) } else { Err(s) }).transpose();
    let seconds = seconds.map_err(|s| refused(format!("{s} s is too long; at most {LONGEST} s are rendered here")))?;
    let mut sound = cordis_anima::render(&scene, seconds).map_err(|why| refused(why.to_string()))?;
    if sound.diverged.is_none() {
        fade_end(&mut sound.sound, sound.rate, sound.channels);
    }
    let name = format!("{}.wav", loaded.name);
    let bytes = wav_bytes(&name, sound.rate, sound.channels, &sound.sound).map_err(|why| refused(why.to_string()))?;
    let object = json!({
        "file": name,
        "rate": sound.rate,
        "channels": sound.channels,
        "frames": sound.frames(),
        "diverged": sound.diverged,
    });
    Ok((object, bytes))
}

fn wav(file: &str, rate: f64, channels: usize, bytes: &[u8]) -> Answer {
    let samples: Vec<f64> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b).into()).collect();
    let bytes = wav_bytes(file, rate, channels, &samples).map_err(|why| refused(why.to_string()))?;
    Ok((json!({"file": file}), bytes))
}

/// Reads and compiles a model with its changes.
pub(crate) fn compiled(source: &Source) -> Result<(Loaded, Compiled), Value> {
    let mut loaded = Loaded::read_with(&source.text, &source.file, &mut |name| {
        let missing = || Unread { what: format!("`{name}` is not here"), help: "add the file to the page".into() };
        source.files.get(name).cloned().ok_or_else(missing)
    });
    for (name, value) in &source.changes {
        load::set_typed(&mut loaded, name, value).map_err(failed)?;
    }
    let compiled = loaded.compile(&Options::default()).map_err(|found| failed(Failure::Found(found)))?;
    let modules = modules(&compiled.scene);
    if source.limit > 0 && modules > source.limit {
        let text = format!(
            "the model has {modules} modules; a page plays at most {} from a link; `ca play` plays any number",
            source.limit
        );
        return Err(refused(text));
    }
    Ok((loaded, compiled))
}

fn modules(scene: &Scene) -> usize {
    scene.mats() + scene.lias()
}

fn warnings(findings: &Diags, model: &Model) -> String {
    let mut warnings = findings.clone();
    warnings.list.retain(|d| d.severity == Severity::Warning);
    if warnings.list.is_empty() { String::new() } else { render::text(&warnings, model, false) }
}

pub(crate) fn failed(failure: Failure) -> Value {
    match failure {
        Failure::Found(found) => json!({
            "text": render::text(&found.diags, &found.model, false),
            "findings": render::json(&found.diags, &found.model),
        }),
        other => refused(other.line()),
    }
}
