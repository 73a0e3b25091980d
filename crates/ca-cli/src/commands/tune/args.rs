//! Arguments of `ca tune`.

use crate::args::common::quantity_of;
use crate::args::completions;
use crate::commands::equiv::WriteTo;
use ca_core::Unit;
use ca_fit::tune::Scale;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap_complete::ArgValueCompleter;

/// Tunes strings, meshes, cells and banks
///
/// Each part is given with its pitch, in hertz or as a note with octave and cents (A3, C#4, Bb2+14.5). The command
/// changes its `f`, or its stiffness `k` if it has no `f`, until the mode in which the part moves most has that pitch
/// in the whole model. This includes frequency warping and all connected modules. If the part follows a `[param]`, the
/// `[param]` is changed. With `--scale`, the parts (or the cells of a bank) get the degrees of a scale, starting at
/// `--root`.
///
/// Nothing is written without `--write` or `--in-place`. The rest of the file, including comments, does not change.
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
    /// Part and pitch, e.g. low=A2; with `--scale`, only the part
    #[arg(value_name = "PART=PITCH", required = true)]
    pub parts: Vec<String>,
    /// Tunes the parts, or the cells of a bank, to the degrees of a scale
    #[arg(long, value_parser = scale(), requires = "root", help_heading = "Pitch")]
    pub scale: Option<Scale>,
    /// Pitch of the first degree of the scale
    #[arg(long, value_name = "PITCH", requires = "scale", help_heading = "Pitch")]
    pub root: Option<String>,
    /// Pitch of the note A4
    #[arg(long, value_name = "HZ", default_value = "440 Hz", value_parser = concert, help_heading = "Pitch")]
    pub a4: f64,
    /// Mode of the part to tune, counted from the lowest
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    #[arg(help_heading = "Pitch")]
    pub mode: u32,
    /// where it is written
    #[command(flatten)]
    pub to: WriteTo,
    /// Prints the result as JSON
    #[arg(long, help_heading = "Output")]
    pub json: bool,
}

fn concert(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::HERTZ, (1.0, 20_000.0))
}

fn scale() -> impl TypedValueParser<Value = Scale> {
    let names = Scale::ALL.map(|(name, words, _)| PossibleValue::new(name).help(words));
    PossibleValuesParser::new(names).try_map(|name| Scale::named(&name).ok_or("unknown"))
}
