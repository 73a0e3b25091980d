//! Options shared by several commands, and parsers of their values.

use super::completions;
use ca_core::Unit;
use ca_core::internal::scene::PRESET;
use ca_import::Format;
use ca_model::quantity;
use clap::{Args, ValueEnum};
use clap_complete::ArgValueCompleter;

/// Which model, and what to change in it.
#[derive(Args, Clone)]
pub struct Source {
    /// the model
    #[arg(help = model_help(), add = ArgValueCompleter::new(completions::models))]
    pub model: String,
    /// Changes a parameter: of a module (`hammer.m="30 g"`), a `[param]`, or `rate.gesture`; repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = pair)]
    pub set: Vec<(String, String)>,
    /// Chooses a preset of the model, as `--set preset=NAME`; `--set` changes it further
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// Sound rate, e.g. "96 kHz" or 96k; the model's own, or 48 kHz
    #[arg(long, value_name = "HZ", value_parser = hertz)]
    pub rate: Option<f64>,
    /// Position of devices within a gesture frame, as `--set rate.border=hold`
    #[arg(long, value_enum)]
    pub border: Option<Border>,
    /// Gesture frames added to the position of each device, as `--set rate.latency=5`
    #[arg(long, value_name = "FRAMES")]
    pub latency: Option<u32>,
    /// Gives the hand no force, as `--set rate.feedback=false`
    #[arg(long)]
    pub no_feedback: bool,
}

impl Source {
    /// Names a model without changes.
    pub fn of(model: &str) -> Source {
        let model = model.to_owned();
        Source { model, set: Vec::new(), preset: None, rate: None, border: None, latency: None, no_feedback: false }
    }

    /// Returns the changes of the rate boundary, as names and values of `--set`.
    pub fn crossing(&self) -> impl Iterator<Item = (String, String)> {
        let border =
            self.border.map(|b| ("rate.border", if b == Border::Hold { "hold" } else { "linear" }.to_string()));
        let latency = self.latency.map(|n| ("rate.latency", n.to_string()));
        let mute = self.no_feedback.then(|| ("rate.feedback", "false".to_string()));
        [border, latency, mute].into_iter().flatten().map(|(name, value)| (name.to_string(), value))
    }

    /// Returns all changes, as names and values of `--set`.
    pub fn changes(&self) -> impl Iterator<Item = (String, String)> {
        let preset = self.preset.iter().map(|name| (PRESET.to_string(), name.clone()));
        preset.chain(self.set.iter().cloned()).chain(self.crossing())
    }
}

/// Help text of the argument that names a model.
pub(crate) fn model_help() -> String {
    let formats = imported(|f| format!("{} `.{}` file, ", f.name, f.extension));
    format!("`*.ca.toml` file, {formats}name of a bundled model, or `-` for standard input")
}

/// Joins `words` about each foreign file format.
pub(crate) fn imported(words: impl Fn(&Format) -> String) -> String {
    ca_import::FORMATS.iter().map(words).collect()
}

/// How long a model is played, and by what.
#[derive(Args)]
pub struct Playing {
    /// How long, e.g. 4 or "4 s"
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// A gesture that plays it (csv, npy, wav, mid, kar, rmi, or a take, mcap); its tracks take the place of built-in ones;
    /// repeatable. The one nameless track of an array or a sound is given to a port by `key=FILE`
    #[arg(long, value_name = "[PORT=]FILE")]
    pub gesture: Vec<String>,
    /// Rate of an NPY gesture without a time of its own
    #[arg(long, value_name = "HZ", value_parser = hertz, requires = "gesture")]
    pub gesture_rate: Option<f64>,
}

/// Position of a device within a gesture frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Border {
    /// on a straight line
    Linear,
    /// where it was read
    Hold,
}

pub(crate) fn pair(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().into(), value.trim().into()))
        }
        _ => Err("write it like `hammer.m=30 g`".into()),
    }
}

pub(crate) fn quantity_of(text: &str, unit: Unit, range: (f64, f64)) -> Result<f64, String> {
    let q = quantity::parse(text.trim()).map_err(|e| e.to_string())?;
    if q.has_unit && !q.dim.same(unit.dim) {
        return Err(format!("a quantity in {} is wanted", unit.symbol));
    }
    if q.value < range.0 || q.value > range.1 {
        return Err(format!("it lies between {} and {} {}", range.0, range.1, unit.symbol));
    }
    Ok(q.value)
}

pub(crate) fn count(text: &str) -> Result<usize, String> {
    text.trim().parse().map_err(|_| "a whole number from 0 on is wanted".into())
}

/// Parses a rate. `96k` is short for "96 kHz", as in other audio programs.
pub(crate) fn hertz(text: &str) -> Result<f64, String> {
    let short = text.trim().strip_suffix(['k', 'K']).filter(|n| n.trim().parse::<f64>().is_ok());
    quantity_of(&short.map_or_else(|| text.to_owned(), |n| format!("{n} kHz")), Unit::HERTZ, (1.0, 1e6))
}

/// Parses a level and returns its amplitude relative to full scale.
pub(crate) fn dbfs(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches("FS").trim_end_matches("dB").trim();
    match number.parse::<f64>() {
        Ok(v) if (-200.0..=0.0).contains(&v) => Ok(10.0_f64.powf(v / 20.0)),
        _ => Err(format!("`{text}` is no level from -200 to 0 dBFS, such as -1dBFS")),
    }
}

pub(crate) fn metres(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::METRE, (-1.0, 1.0))
}

pub(crate) fn speed(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::SPEED, (1e-4, 10.0))
}

/// Parses a time. Unlike in models, minutes are allowed.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let minutes = text.trim().strip_suffix("min").and_then(|n| n.trim().parse::<f64>().ok());
    let text = minutes.map_or_else(|| text.to_owned(), |n| format!("{} s", n * 60.0));
    quantity_of(&text, Unit::SECOND, (1e-6, 86_400.0))
}
