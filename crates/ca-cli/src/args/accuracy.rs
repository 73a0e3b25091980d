//! How wrong a model is, and what it costs to be less wrong.

use super::{Source, seconds};
use clap::Args;
use std::path::PathBuf;

/// Measures the error of a model against its run time, over methods and rates
///
/// Plays the model as it is, by every other method its modules know, in single precision, and at multiples of its rate, and
/// compares what its outputs hear (before gains and filters) with the best reference there is: the closed form of its modes
/// where all of it is linear and nothing drives it, else the same model at a far higher rate, carried on by Richardson; how
/// well that is known is said. Each way has its error, the pitch, the decay, the energy that the scheme makes, and its time
/// per sample, measured here. Those that nothing beats in both error and time are marked, and with `--error` the cheapest
/// that is good enough is named.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca accuracy plucked_string --seconds 0.3 --times 1,2 --reference 8
  ca accuracy hammered_string --seconds 0.2 --times 1,2 --reference 8 --error 0.9
  ca accuracy glass --seconds 0.3 --times 1,2 --reference 8 --json
  ca accuracy marimba --seconds 0.2 --times 1 --reference 4 -o marimba.html")]
pub struct AccuracyArgs {
    /// the model
    #[command(flatten)]
    pub source: Source,
    /// How long it is played; `seconds` of the model, but no more than one, if left out
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Multiples of the sound rate to try
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "1,2,4,8", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub times: Vec<u32>,
    /// The multiple of the rate of the reference, where there is no closed form
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(4..=4096))]
    pub reference: u32,
    /// Listens to these instead of the outputs: `low[3]`, `strike`; repeatable
    #[arg(long, value_name = "NAME")]
    pub probe: Vec<String>,
    /// Names the cheapest way with at most this error, relative
    #[arg(long, value_name = "E", value_parser = share)]
    pub error: Option<f64>,
    /// Writes a page with the plot and the table
    #[arg(short, long, value_name = "FILE.html")]
    pub output: Option<PathBuf>,
    /// Prints the table as JSON
    #[arg(long)]
    pub json: bool,
}

fn share(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err("a number above 0 is wanted, e.g. 1e-3".into()),
    }
}
