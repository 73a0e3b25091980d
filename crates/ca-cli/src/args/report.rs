//! A page about a model or a take.

use super::common::quantity_of;
use super::{Playing, Source};
use ca_core::Unit;
use clap::Args;
use std::path::PathBuf;

/// Writes a page about a model or a take
///
/// One HTML file that opens anywhere and asks nobody for anything: the sound with its waveform, spectrogram and spectrum,
/// the modes of the linear part, the motion of modules, the energy ledger, error against run time of its beginning, what is
/// proven of stability, and the model itself.
/// A model is played as by `ca render`, with the energy ledger kept. A take (`*.mcap`) is shown as it was: gestures, forces,
/// faults, and how the real-time loop did; it is played again for the ledger. Exit code 3 as of `ca render` and
/// `ca replay`: the page is written all the same, and says what is wrong.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca report hammered_string
  ca report hammered_string -o soft.html --set hammer.m='10 g' --seconds 2
  ca report hammered_string --probe hammer --probe 'low[3]' --gesture key.csv
  ca report take.mcap -o take.html")]
pub struct ReportArgs {
    /// the model, or a take
    #[command(flatten)]
    pub source: Source,
    /// The page; the name of the model in the current directory if left out
    #[arg(short, long, value_name = "FILE.html")]
    pub output: Option<PathBuf>,
    /// how it is played
    #[command(flatten)]
    pub playing: Playing,
    /// Shows the motion of a module, or the force of a link: `low[3]`, `strike`, `low@0.3`; repeatable. What the outputs
    /// hear and the device keys if left out
    #[arg(long, value_name = "NAME")]
    pub probe: Vec<String>,
    /// Seconds of sound for which other methods and rates are compared, as by `ca accuracy`; 0 leaves the comparison out;
    /// 0.2 unless given
    #[arg(long, value_name = "S", value_parser = tried)]
    pub accuracy: Option<f64>,
    /// Prints nothing but warnings and errors
    #[arg(short, long)]
    pub quiet: bool,
}

fn tried(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::SECOND, (0.0, 3600.0))
}
