//! Arguments of `ca fit`.

use crate::args::common::{pair, quantity_of};
use crate::args::completions;
use crate::commands::equiv::WriteTo;
use ca_core::Unit;
use clap::Args;
use clap_complete::ArgValueCompleter;
use std::path::PathBuf;

/// Finds numbers of a model by a recorded sound
///
/// The numbers named by `--vary` are changed until the model sounds like the recording: first its modes are brought to the
/// partials of the recording, which takes no render, then levels in windows of several lengths are compared, then, as far as
/// phases agree, the samples. The model is compiled at the rate of the recording; its gain and its delay there are found too.
/// Each number is printed with two standard deviations, or as not determined. A number stays within the range of its kind or
/// `[param]`, and within `--range`. What of the recording is not fitted (`--seconds`) is predicted, by the model and by as many
/// numbers of damped sinusoids. Nothing is written unless `--write` or `--in-place` says where; the rest of the file, its
/// comments too, stays as it is. Exit code 3, and nothing written, where the model comes no nearer, does not explain
/// the sound or ends at another pitch. A start more than a semitone from the pitch of the recording is reported.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca render hammered_string -o target.wav --seconds 0.7 --set low.f='112 Hz' --set hammer.m='5 g'
  ca fit hammered_string --to target.wav --vary low.f,hammer.m --write fitted.ca.toml
  ca fit hammered_string --to target.wav --vary low.f --range low.f='90 Hz..130 Hz' --json
  ca fit fitted.ca.toml --to target.wav --vary low.f,low.t60 --seconds '400 ms' --report fit.html")]
pub struct FitArgs {
    /// `*.ca.toml` file, name of a bundled model, or `-` for standard input
    #[arg(add = ArgValueCompleter::new(completions::models))]
    pub model: String,
    /// The recording, a WAV or FLAC file
    #[arg(long, value_name = "FILE")]
    pub to: PathBuf,
    /// Numbers to be found, as `--set` knows them, e.g. low.f,hammer.m
    #[arg(long, value_name = "NAME,…", required = true, value_delimiter = ',')]
    pub vary: Vec<String>,
    /// Changes a parameter before the fit, as of `ca render`; repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = pair)]
    pub set: Vec<(String, String)>,
    /// How far a number may go, e.g. low.f='80 Hz..160 Hz'; repeatable
    #[arg(long, value_name = "NAME=FROM..TO", value_parser = pair)]
    pub range: Vec<(String, String)>,
    /// How much of the recording is fitted, from its onset on; up to 4 s unless given
    #[arg(long, value_name = "S", value_parser = fitted)]
    pub seconds: Option<f64>,
    /// Gain of the model in the recording; found unless given
    #[arg(long, value_parser = gain)]
    pub gain: Option<f64>,
    /// Most renders of the model, those for derivatives too
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub renders: u32,
    /// A gesture that plays the model, as of `ca render`; repeatable
    #[arg(long, value_name = "[PORT=]FILE")]
    pub gesture: Vec<String>,
    /// Writes a page: the recording, the model before and after, what is left
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// where the model is written
    #[command(flatten)]
    pub to_file: WriteTo,
    /// Prints what was found as JSON
    #[arg(long)]
    pub json: bool,
}

fn fitted(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::SECOND, (0.05, 600.0))
}

fn gain(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::NONE, (-1e12, 1e12))
}
