//! Arguments of `ca serve`.

use crate::args::Source;
use crate::args::common::{count, seconds};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Plays a model in real time with device processes
///
/// The engine computes gesture frames (3000 per second, unless the model sets another rate) on a separate thread. It
/// reads positions from the devices named in the model and sends forces back, through shared memory. `ca device sim` is
/// such a device. Forces stay off until a device is armed (`--arm`, or `ca arm`) and nothing pushes.
///
/// Priority, memory lock and core are requested, checked and reported; the engine runs without them too. It ends with
/// Ctrl-C, `--seconds` or, if the model has devices or live parameters, `ca stop`, and then prints a summary of times,
/// losses and faults. Exit code 3 if something was lost or cut.
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
    /// Duration, e.g. 60 or "1 min" (default: until stopped)
    #[arg(long, value_name = "S", value_parser = seconds, help_heading = "Playing")]
    pub seconds: Option<f64>,
    /// Writes the sound to a WAV file
    #[arg(short, long, value_name = "FILE.wav", help_heading = "Output")]
    pub output: Option<PathBuf>,
    /// Plays the sound on a server or a sound device, whose clock the gesture frames follow: `jack`, `pulse`, or with
    /// the feature `audio` a device by name or the default one. `ca play` uses a running JACK server, or else a
    /// PulseAudio server; `page` leaves the sound to the page
    #[arg(long, value_name = "DEVICE", num_args = 0..=1, default_missing_value = "", conflicts_with = "clock")]
    #[arg(help_heading = "Sound")]
    pub audio: Option<String>,
    /// Buffer of the sound device in frames (default: 256, or the choice of its server)
    #[arg(long, value_name = "FRAMES", requires = "audio", value_parser = clap::value_parser!(u32).range(1..=65536))]
    #[arg(help_heading = "Sound")]
    pub audio_buffer: Option<u32>,
    /// Writes a take: every frame, event and sample, for `ca replay`
    #[arg(long, value_name = "FILE.mcap", help_heading = "Output")]
    pub log: Option<PathBuf>,
    /// Reads MIDI from a device of this machine, a pipe or a file of raw bytes; without a path, from all devices
    /// (/dev/snd/midiC*D*). A JACK server that plays the sound also sends MIDI to a port `midi_in`, without this option
    #[arg(long, value_name = "PATH", num_args = 0..=1, default_missing_value = "", help_heading = "Playing")]
    pub midi: Option<PathBuf>,
    /// Receives OSC from this machine at this UDP port; 0 uses a free one. A model with device keys (TGR) accepts
    /// only messages whose address begins with the token of `--osc-token`
    #[arg(long, value_name = "PORT", help_heading = "Playing")]
    pub osc: Option<u16>,
    /// File with the token at the start of OSC addresses, `/TOKEN/param`. Only you can read it; it is created if it
    /// does not exist (default: `osc-token` beside your profiles)
    #[arg(long, value_name = "FILE", requires = "osc", help_heading = "Playing")]
    pub osc_token: Option<PathBuf>,
    /// Plays the built-in gesture of the model from the start
    #[arg(long, help_heading = "Playing")]
    pub gesture: bool,
    /// Profile of a device, by name (`ca device list`) or file; without `DEVICE=`, of all devices; repeatable
    #[arg(long, value_name = "[DEVICE=]PROFILE", help_heading = "Devices")]
    pub profile: Vec<String>,
    /// Calibration of a device, instead of the one from `ca device calibrate`; repeatable
    #[arg(long, value_name = "DEVICE=FILE", help_heading = "Devices")]
    pub calibration: Vec<String>,
    /// Arms every device at the start
    #[arg(long, help_heading = "Devices")]
    pub arm: bool,
    /// Clock of the gesture frames
    #[arg(long, value_enum, default_value_t = ClockKind::Monotonic, help_heading = "Devices")]
    pub clock: ClockKind,
    /// Priority of the engine (SCHED_FIFO); 0 requests none
    #[arg(long, value_name = "0-99", default_value_t = 70, value_parser = clap::value_parser!(u8).range(0..=99))]
    #[arg(help_heading = "Process")]
    pub priority: u8,
    /// Core that runs the engine
    #[arg(long, value_name = "N", value_parser = count, help_heading = "Process")]
    pub cpu: Option<usize>,
    /// Does not request a memory lock, which keeps memory in RAM
    #[arg(long, help_heading = "Process")]
    pub no_lock: bool,
    /// Computes the energy ledger (slower)
    #[arg(long, help_heading = "Process")]
    pub energy: bool,
    /// Prints only warnings and errors
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,
    /// Prints the summary as JSON
    #[arg(long, conflicts_with = "quiet", help_heading = "Output")]
    pub json: bool,
}

/// Clock of gesture frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClockKind {
    /// the clock of this machine
    Monotonic,
    /// each frame of the first device
    Device,
}
