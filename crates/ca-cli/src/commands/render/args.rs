//! Arguments of `ca render`.

use crate::args::common::dbfs;
use crate::args::{Playing, Source};
use crate::commands::aim::Aim;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Plays a model into a WAV or FLAC file
///
/// The model is played by its built-in gesture, or by files: CSV, NPY, WAV or MIDI, whose tracks are named like the
/// ports and live parameters they drive. The same model, gesture and options give the same bits on every machine. The
/// length is `--seconds`. Without it a MIDI file is played until the sound has died away (60 dB below its peak for half a second), 10 s
/// after the last event at most; else it is `seconds` of the model, else the gesture and 2 s more, at least 3 s. Floats hold what the
/// model makes, beyond full scale too; in 24 and 16 bits that is cut off and counted. A model that diverges is silenced, and the
/// guilty module named: what is cut off or diverged finishes with exit code 3. A pipe gets the same bytes as a file, when the
/// sound is whole; the summary then goes to standard error.
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
    /// The file, `.wav` or `.flac`, or `-` for standard output; the name of the model in the current directory if left out
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// how it is played
    #[command(flatten)]
    pub playing: Playing,
    /// Samples: 32-bit float (lossless, the default of WAV), 24 bits (the default of FLAC) or 16 bits; `flac` and `flac16` are
    /// FLAC whatever the file is called
    #[arg(long, value_enum)]
    pub format: Option<SampleFormat>,
    /// Cuts off what is beyond full scale in 32-bit floats too, as 24 and 16 bits always do
    #[arg(long)]
    pub ceiling: bool,
    /// Makes the loudest sample just so loud, e.g. -1dBFS
    #[arg(long, value_name = "DBFS", value_parser = dbfs, allow_hyphen_values = true)]
    pub normalize: Option<f64>,
    /// Leaves the end of a sound that goes on as it is; else its last 20 ms are faded where they are above -60 dBFS
    #[arg(long)]
    pub no_fade: bool,
    /// Writes any quantity to a file, `.npy` (default) or `.csv`: `low[3]`, `strike`, `low@0.3`; repeatable. Of a mass or a port
    /// it is how far that is from where it rests (a gesture says where it is), of a link its force
    #[arg(long, value_name = "NAME[=FILE]")]
    pub probe: Vec<String>,
    /// the error
    #[command(flatten)]
    pub aim: Aim,
    /// Keeps the energy ledger for the whole length (slower)
    #[arg(long)]
    pub energy: bool,
    /// Has no effect: one thread plays a scene. Accepted for scripts that were written for earlier versions
    #[arg(long, value_name = "N", default_value_t = 1, hide = true)]
    pub threads: u8,
    /// Which passes run the links; `reference` is slower, link by link, and may sum forces in another order: samples are then
    /// the same to rounding, which collisions may amplify to another course of the sound
    #[arg(long, value_enum, default_value_t = Kernel::Fast)]
    pub kernel: Kernel,
    /// Prints nothing but warnings and errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Prints the summary as JSON
    #[arg(long, conflicts_with = "quiet")]
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
