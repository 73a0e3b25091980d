//! Arguments of `ca render`.

use crate::args::common::dbfs;
use crate::args::{Playing, Source};
use crate::commands::error_target::ErrorTarget;
use clap::builder::{EnumValueParser, PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, Args, Command, ValueEnum};
use std::ffi::OsStr;
use std::path::PathBuf;

/// Renders a model to a WAV or FLAC file
///
/// The model is played by its built-in gesture, or by files: CSV, NPY, WAV or MIDI, with tracks named after the ports
/// and live parameters that they drive. The same model, gesture and options give the same bits on every machine.
///
/// The length is `--seconds`. Without it, a MIDI file plays until the sound has decayed (60 dB below its peak for half
/// a second), at most 10 s after the last event. In other cases the length is `seconds` of the model, or else the
/// length of the gesture plus 2 s, at least 3 s.
///
/// Floats store all samples, also those beyond full scale. In 24 and 16 bits these are clipped and counted. If the
/// model diverges, it is silenced, and the module at fault is named. Exit code 3 if samples were clipped or the model
/// diverged. A pipe gets the same bytes as a file, once the sound is complete; the summary then goes to standard error.
#[allow(clippy::struct_excessive_bools)]
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca render hammered_string
  ca render hammered_string -o slow.wav --seconds 6 --set hammer.m='30 g'
  ca render hammered_string -o take.wav --gesture key.csv --format 24
  ca render hammered_string -o small.flac --format 16
  ca render hammered_string -o - | cat > piped.wav
  ca render hammered_string --normalize -1dBFS --no-fade
  ca render hammered_string --probe 'low[3]' --probe strike=blow.csv --seconds '500 ms'
  ca render hammered_string --energy --json
  ca render marimba --error 2e-2 --seconds 0.5
  ca render piano_key --latency 30 --no-feedback
  ca render piano_key --border hold --set rate.filter='18 kHz'")]
pub struct RenderArgs {
    /// the model
    #[command(flatten)]
    pub source: Source,
    /// File to write, `.wav` or `.flac`, or `-` for standard output (default: the name of the model in the current
    /// directory)
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
    /// how it is played
    #[command(flatten)]
    pub playing: Playing,
    /// Sample format: 32-bit float (lossless, the default for WAV), 24 bits (the default for FLAC) or 16 bits; `flac`
    /// and `flac16` write FLAC without the extension `.flac` too, e.g. to a pipe
    #[arg(long, value_parser = FormatParser, help_heading = "Output")]
    pub format: Option<SampleFormat>,
    /// Clips 32-bit floats at full scale, as is always done in 24 and 16 bits
    #[arg(long, help_heading = "Output")]
    pub ceiling: bool,
    /// Scales the sound so that its peak is at this level, e.g. -1dBFS
    #[arg(long, value_name = "DBFS", value_parser = dbfs, allow_hyphen_values = true, help_heading = "Output")]
    pub normalize: Option<f64>,
    /// Does not fade out the end; without this option, the last 20 ms are faded out if they are above -60 dBFS
    #[arg(long, help_heading = "Output")]
    pub no_fade: bool,
    /// Writes a quantity to a file, `.npy` (default) or `.csv`: `low[3]`, `strike`, `low@0.3`; repeatable. For a mass
    /// or a port, it is the displacement from rest (a gesture file has positions instead); for a link, its force
    #[arg(long, value_name = "NAME[=FILE]", help_heading = "Output")]
    pub probe: Vec<String>,
    /// the error
    #[command(flatten)]
    pub error_target: ErrorTarget,
    /// Computes the energy ledger for the whole length (slower)
    #[arg(long, help_heading = "Computation")]
    pub energy: bool,
    /// Has no effect: one thread plays a scene. Accepted for scripts written for earlier versions
    #[arg(long, value_name = "N", default_value_t = 1, hide = true)]
    pub threads: u8,
    /// Computation of the links; `reference` is slower, link by link, and may sum forces in another order: samples then
    /// agree up to rounding, but collisions may amplify the difference until the sound differs
    #[arg(long, value_enum, default_value_t = Kernel::Fast, help_heading = "Computation")]
    pub kernel: Kernel,
    /// Prints only warnings and errors
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,
    /// Prints the summary as JSON
    #[arg(long, conflicts_with = "quiet", help_heading = "Output")]
    pub json: bool,
}

/// The format of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SampleFormat {
    /// 32-bit floats
    F32,
    /// 24-bit integers
    #[value(name = "24")]
    I24,
    /// 16-bit integers
    #[value(name = "16")]
    I16,
    /// FLAC of 24 bits
    Flac,
    /// FLAC of 16 bits
    Flac16,
}

/// Parser of [`SampleFormat`] that answers `32` with `f32`, which is too short for the suggestions of clap.
#[derive(Clone)]
struct FormatParser;

impl TypedValueParser for FormatParser {
    type Value = SampleFormat;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<SampleFormat, clap::Error> {
        EnumValueParser::<SampleFormat>::new().parse_ref(command, arg, value).map_err(|mut e| {
            if value == "32" {
                e.insert(ContextKind::SuggestedValue, ContextValue::String("f32".into()));
            }
            e
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(SampleFormat::value_variants().iter().filter_map(ValueEnum::to_possible_value)))
    }
}

impl SampleFormat {
    /// Returns true for FLAC, independent of the file name.
    pub fn is_flac(self) -> bool {
        matches!(self, SampleFormat::Flac | SampleFormat::Flac16)
    }
}

/// Which passes run the links.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kernel {
    /// link by link in document order
    Reference,
    /// batches and runs
    Fast,
}
