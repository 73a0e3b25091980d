//! Arguments of `ca tune`.

use crate::args::common::quantity_of;
use crate::args::completions;
use crate::commands::equiv::WriteTo;
use ca_core::Unit;
use clap::{Args, ValueEnum};
use clap_complete::ArgValueCompleter;

/// Tunes strings, meshes, cells and banks
///
/// A part is named with its pitch: in hertz, or as a note with octave and cents (A3, C#4, Bb2+14.5). The command changes
/// its `f`, or its stiffness `k` where it has no `f`, until the mode in which the part moves most has that pitch in the whole
/// model: frequency warping and all modules that are connected to it are counted. Where the part follows a `[param]`, that
/// is changed. With `--scale`, the parts (or the
/// cells of a bank) take the degrees of a scale from `--root` on. Nothing is written unless `--write` or `--in-place`
/// says where; the rest of the file, its comments too, stays as it is.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca tune hammered_string low=B2
  ca tune membrane skin='180 Hz' --write higher.ca.toml
  ca tune glass --scale just --root C5 rim --write bowl.ca.toml
  ca tune higher.ca.toml skin=F3+10 --a4 '442 Hz' --in-place --json")]
pub struct TuneArgs {
    /// `*.ca.toml` file, name of a bundled model, or `-` for standard input
    #[arg(add = ArgValueCompleter::new(completions::models))]
    pub model: String,
    /// Part and pitch, e.g. low=A2; with `--scale` the parts alone
    #[arg(value_name = "PART=PITCH", required = true)]
    pub parts: Vec<String>,
    /// Gives the parts, or the cells of a bank, the degrees of a scale
    #[arg(long, value_enum, requires = "root")]
    pub scale: Option<Scale>,
    /// The first degree of the scale: a pitch
    #[arg(long, value_name = "PITCH", requires = "scale")]
    pub root: Option<String>,
    /// Pitch of the note A4
    #[arg(long, value_name = "HZ", default_value = "440 Hz", value_parser = concert)]
    pub a4: f64,
    /// Which of the part's own modes is tuned, lowest first
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub mode: u32,
    /// where it is written
    #[command(flatten)]
    pub to: WriteTo,
    /// Prints what was done as JSON
    #[arg(long)]
    pub json: bool,
}

/// Seven degrees in an octave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scale {
    /// major, of twelve equal steps
    Equal,
    /// major, of small whole numbers
    Just,
    /// major, of pure fifths
    Pythagorean,
    /// the overtones of the root: 1, 2, 3 …
    Harmonic,
}

fn concert(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::HERTZ, (1.0, 20_000.0))
}
