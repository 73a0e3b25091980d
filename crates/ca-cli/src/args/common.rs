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
    /// Changes a parameter of a module (`hammer.m="30 g"`), a `[param]`, or a setting such as `rate.gesture`;
    /// repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = pair, help_heading = "Model")]
    pub set: Vec<(String, String)>,
    /// Applies a preset of the model, like `--set preset=NAME`; `--set` is applied after it
    #[arg(long, value_name = "NAME", help_heading = "Model")]
    pub preset: Option<String>,
    /// Sound rate, e.g. "96 kHz" or 96k (default: the rate in the model, or 48 kHz)
    #[arg(long, value_name = "HZ", value_parser = hertz, help_heading = "Model")]
    pub rate: Option<f64>,
    /// Interpolation of device positions within a gesture frame, like `--set rate.border=hold`
    #[arg(long, value_enum, help_heading = "Model")]
    pub border: Option<Border>,
    /// Delays the position of each device by this number of gesture frames, like `--set rate.latency=5`
    #[arg(long, value_name = "FRAMES", help_heading = "Model")]
    pub latency: Option<u32>,
    /// Sends no forces to devices, like `--set rate.feedback=false`
    #[arg(long, help_heading = "Model")]
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

/// Duration and gestures of a performance.
#[derive(Args)]
pub struct Playing {
    /// Duration, e.g. 4 or "4 s"
    #[arg(long, value_name = "S", value_parser = seconds, help_heading = "Playing")]
    pub seconds: Option<f64>,
    /// Gesture file to play (csv, npy, wav, mid, kar, rmi, or a take, mcap); its tracks replace built-in ones;
    /// repeatable. If the file has one track without a name, as an array or a sound may, name its port: `key=FILE`
    #[arg(long, value_name = "[PORT=]FILE", help_heading = "Playing")]
    pub gesture: Vec<String>,
    /// Sampling rate of an NPY gesture without a field `time`
    #[arg(long, value_name = "HZ", value_parser = hertz, requires = "gesture", help_heading = "Playing")]
    pub gesture_rate: Option<f64>,
}

/// Position of a device within a gesture frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Border {
    /// straight line from frame to frame
    Linear,
    /// jump to the new position, then constant
    Hold,
}

pub(crate) fn pair(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().into(), value.trim().into()))
        }
        _ => Err("expected NAME=VALUE, e.g. `hammer.m=30 g`".into()),
    }
}

pub(crate) fn quantity_of(text: &str, unit: Unit, range: (f64, f64)) -> Result<f64, String> {
    let q = quantity::parse(text.trim()).map_err(|e| e.to_string())?;
    if q.has_unit && !q.dim.same(unit.dim) {
        return Err(format!("expected a quantity in {}", unit.symbol));
    }
    if q.value < range.0 || q.value > range.1 {
        return Err(format!("must be between {} and {} {}", range.0, range.1, unit.symbol));
    }
    Ok(q.value)
}

pub(crate) fn count(text: &str) -> Result<usize, String> {
    text.trim().parse().map_err(|_| "expected a whole number, 0 or more".into())
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
        _ => Err(format!("`{text}` is not a level from -200 to 0 dBFS; write e.g. `-1dBFS`")),
    }
}

pub(crate) fn metres(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::METRE, (-1.0, 1.0))
}

pub(crate) fn speed(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::SPEED, (1e-4, 10.0))
}

/// Parses the address of a site. The result ends with a slash, so that its pages are found below it.
pub(crate) fn site_address(text: &str) -> Result<String, String> {
    let has_scheme = ["https://", "http://"].iter().any(|s| text.len() > s.len() && text.starts_with(s));
    if !has_scheme || text.contains(char::is_whitespace) {
        return Err("an address begins with `https://` or `http://`".into());
    }
    let folder = text.strip_suffix("index.html").unwrap_or(text);
    Ok(format!("{}/", folder.trim_end_matches('/')))
}

/// Parses a time. Unlike in models, minutes are allowed.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let minutes = text.trim().strip_suffix("min").and_then(|n| n.trim().parse::<f64>().ok());
    let text = minutes.map_or_else(|| text.to_owned(), |n| format!("{} s", n * 60.0));
    quantity_of(&text, Unit::SECOND, (1e-6, 86_400.0))
}
