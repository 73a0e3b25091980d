//! Error of a model, and the run time of less error.

use super::Source;
use super::common::seconds;
use clap::Args;
use std::path::PathBuf;

/// Measures the error of a model against its run time, over methods and rates
///
/// Plays the model as it is, by every other method its modules know, in single precision, and at multiples of its rate, and
/// compares the signals at its outputs (before gains and filters) with a reference: the closed form of its modes where the
/// model is linear and nothing drives it, else the same model at a far higher rate, by Richardson extrapolation. The
/// uncertainty of the reference is printed. A row gives the relative RMS error of the signal and of its spectrum, the error
/// of pitch in cents and of decay in dB, the relative error of energy, and the run time in ns per sample on this machine.
/// Rows on the Pareto front of error and time are marked; with `--error` the fastest row within that error is named.
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
    /// Seconds to play; `seconds` of the model, but at most 1 s, if left out
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Multiples of the sound rate to try
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "1,2,4,8", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub times: Vec<u32>,
    /// Multiple of the sound rate at which the reference is computed, where there is no closed form
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(4..=4096))]
    pub reference: u32,
    /// Listens to these instead of the outputs: `low[3]`, `strike`; repeatable
    #[arg(long, value_name = "NAME")]
    pub probe: Vec<String>,
    /// Names the fastest row with at most this relative RMS error, e.g. 1e-3
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
