//! Modes of a model.

use super::Source;
use super::common::count;
use clap::Args;
use std::path::PathBuf;

/// Computes the modes of the linear part of a model
///
/// For each mode: its frequency without the scheme and as the scheme plays it at this sound rate, the difference in cents,
/// the time to fall by 60 dB, and how strongly each output hears it, each input pushes it, and each link that is not
/// linear acts on it, in dB below the mode that is strongest there. Links that are not linear are not part of it, and
/// named. Parameters have the values of load, moving points stand where they stand at load.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca modes hammered_string
  ca modes iron_bar --modes 8 --rate '96 kHz'
  ca modes membrane --shapes shapes.csv
  ca modes hammered_string --set low.f='220 Hz' --json")]
pub struct ModesArgs {
    /// the model
    #[command(flatten)]
    pub source: Source,
    /// How many modes are shown, lowest first
    #[arg(short = 'n', long, default_value_t = 24, value_name = "N", value_parser = count)]
    pub modes: usize,
    /// Writes the shapes as CSV: a row for each place, a column for each mode
    #[arg(long, value_name = "FILE.csv")]
    pub shapes: Option<PathBuf>,
    /// Prints all modes as JSON
    #[arg(long)]
    pub json: bool,
}
