//! Arguments of `ca serve`.

use crate::args::Source;
use crate::args::common::{count, seconds};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Plays a model in real time, by device processes
///
/// The engine computes gesture frames (3000 a second, unless the model says otherwise) on a thread of its own, takes
/// positions from the devices the model names and gives forces back, over shared memory; `ca device sim` is such a
/// device. Forces stay off until a device is armed (`--arm`, or `ca arm`) and nothing pushes. Priority, memory
/// lock and core are asked for, read back and said; without them it runs all the same. Ends with Ctrl-C,
/// `--seconds` or, where the model has devices or live parameters, `ca stop`, and tells how it went: times, losses, faults. Exit code 3 where something was lost or cut.
///
/// Software cannot replace a switch that cuts the power of the motors: keep one within reach.
#[allow(clippy::struct_excessive_bools)]
#[derive(Args, Clone)]
#[command(after_long_help = "Examples:
  ca serve piano_key --seconds 2
  ca serve piano_key --seconds 1 --arm -o played.wav --log played.mcap
  ca serve piano_key --seconds 1 --profile tgr12=falcon --priority 0 --no-lock --json")]
pub struct ServeArgs {
    /// the model
    #[command(flatten)]
    pub source: Source,
    /// How long, e.g. 60 or "1 min"; until stopped if left out
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Writes the sound to a WAV file
    #[arg(short, long, value_name = "FILE.wav")]
    pub output: Option<PathBuf>,
    /// Plays the sound on a server or a sound device, whose clock the gesture frames follow: `jack`, `pulse`, or with the feature
    /// `audio` a device by name or the default one. `ca play` takes a JACK server that is there, or else a PulseAudio server;
    /// `page` leaves the sound to the page
    #[arg(long, value_name = "DEVICE", num_args = 0..=1, default_missing_value = "", conflicts_with = "clock")]
    pub audio: Option<String>,
    /// Frames the sound device is given at once; 256, or what its server decides
    #[arg(long, value_name = "FRAMES", requires = "audio", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub audio_buffer: Option<u32>,
    /// Writes a take: every frame, event and sample, to be played again by `ca replay`
    #[arg(long, value_name = "FILE.mcap")]
    pub log: Option<PathBuf>,
    /// Plays by MIDI: a device of this machine, a pipe or a file of raw bytes; all devices (/dev/snd/midiC*D*) without a path.
    /// A JACK server that plays the sound brings MIDI by a port `midi_in`, unasked
    #[arg(long, value_name = "PATH", num_args = 0..=1, default_missing_value = "")]
    pub midi: Option<PathBuf>,
    /// Plays by OSC, from this machine: a UDP port; 0 takes a free one. A model with devices takes only messages with the
    /// token of `--osc-token` in front of their address
    #[arg(long, value_name = "PORT")]
    pub osc: Option<u16>,
    /// The file with the token that addresses of OSC begin with, `/TOKEN/param`: readable by you alone, made if it is not there;
    /// `osc-token` beside your profiles if left out
    #[arg(long, value_name = "FILE", requires = "osc")]
    pub osc_token: Option<PathBuf>,
    /// Plays the model's own gesture from the start
    #[arg(long)]
    pub gesture: bool,
    /// What a device is: a profile by name (`ca device list`) or file; for all of them without `DEVICE=`; repeatable
    #[arg(long, value_name = "[DEVICE=]PROFILE")]
    pub profile: Vec<String>,
    /// The calibration of a device, if not the one `ca device calibrate` keeps; repeatable
    #[arg(long, value_name = "DEVICE=FILE")]
    pub calibration: Vec<String>,
    /// Arms every device at the start
    #[arg(long)]
    pub arm: bool,
    /// What gesture frames follow: a clock of ours, or each frame of the first device
    #[arg(long, value_enum, default_value_t = ClockKind::Monotonic)]
    pub clock: ClockKind,
    /// Priority of the engine (SCHED_FIFO); 0 asks for none
    #[arg(long, value_name = "0-99", default_value_t = 70, value_parser = clap::value_parser!(u8).range(0..=99))]
    pub priority: u8,
    /// The core the engine stays on
    #[arg(long, value_name = "N", value_parser = count)]
    pub cpu: Option<usize>,
    /// Does not ask to keep memory in RAM
    #[arg(long)]
    pub no_lock: bool,
    /// Keeps the energy ledger (slower)
    #[arg(long)]
    pub energy: bool,
    /// Prints nothing but warnings and errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Prints the summary as JSON
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
}

/// What gesture frames follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClockKind {
    /// the clock of this machine
    Monotonic,
    /// each frame of the first device
    Device,
}
