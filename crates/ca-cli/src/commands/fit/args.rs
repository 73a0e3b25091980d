//! Arguments of `ca fit`.

use crate::args::common::{pair, quantity_of};
use crate::args::completions;
use crate::commands::equiv::WriteTo;
use ca_core::Unit;
use clap::Args;
use clap_complete::ArgValueCompleter;
use std::path::PathBuf;

/// Fits numbers of a model to a recorded sound
///
/// Changes the numbers named by `--vary` until the model sounds like the recording. It first fits the modes of the
/// model to the partials of the recording, which needs no render. It then compares levels in windows of several
/// lengths, and finally the samples, as far as phases agree. The model is compiled at the rate of the recording; its
/// gain and its delay in the recording are found too.
///
/// Each number is printed with two standard deviations, or as not determined. A number stays within the range of its
/// kind or `[param]`, and within `--range`. The part of the recording that is not fitted (`--seconds`) is predicted by
/// the model and, for comparison, by damped sinusoids with as many numbers.
///
/// Nothing is written without `--write` or `--in-place`. The rest of the file, including comments, does not change.
/// Exit code 3, and nothing is written, if the model comes no nearer to the sound, does not explain it, or ends at
/// another pitch. A start more than a semitone from the pitch of the recording is reported.
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
    #[arg(long, value_name = "FILE", help_heading = "Fit")]
    pub to: PathBuf,
    /// Numbers to find, named as in `--set`, e.g. low.f,hammer.m
    #[arg(long, value_name = "NAME,…", required = true, value_delimiter = ',', help_heading = "Fit")]
    pub vary: Vec<String>,
    /// Changes a parameter before the fit, as in `ca render`; repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = pair, help_heading = "Model")]
    pub set: Vec<(String, String)>,
    /// Range of a number, e.g. low.f='80 Hz..160 Hz'; repeatable
    #[arg(long, value_name = "NAME=FROM..TO", value_parser = pair, help_heading = "Fit")]
    pub range: Vec<(String, String)>,
    /// Length of the fitted part of the recording, from its onset (default: up to 4 s)
    #[arg(long, value_name = "S", value_parser = fitted, help_heading = "Fit")]
    pub seconds: Option<f64>,
    /// Gain of the model in the recording (default: found by the fit)
    #[arg(long, value_parser = gain, help_heading = "Fit")]
    pub gain: Option<f64>,
    /// Largest number of renders of the model, including those for derivatives
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    #[arg(help_heading = "Fit")]
    pub renders: u32,
    /// Gesture file that plays the model, as in `ca render`; repeatable
    #[arg(long, value_name = "[PORT=]FILE", help_heading = "Model")]
    pub gesture: Vec<String>,
    /// Writes an HTML page: the recording, the model before and after, and the remaining difference
    #[arg(long, value_name = "FILE.html", help_heading = "Output")]
    pub report: Option<PathBuf>,
    /// where the model is written
    #[command(flatten)]
    pub to_file: WriteTo,
    /// Prints the result as JSON
    #[arg(long, help_heading = "Output")]
    pub json: bool,
}

fn fitted(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::SECOND, (0.05, 600.0))
}

fn gain(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::NONE, (-1e12, 1e12))
}
