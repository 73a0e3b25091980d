//! Arguments of `ca device`.

use crate::args::common::{hertz, metres, seconds, speed};
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Simulates a device, finds devices, and tests and calibrates them
///
/// A device is a process of its own that says where the hand is and is told what force to give; `sim` is one without
/// hardware, whose hand plays a script. `conformance` is for those who write one: it asks of a running device all that
/// the engine relies on. `doctor` says what this machine lacks. Nothing here works while `ca serve` has the device, and
/// only `conformance` gives forces.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca device list
  ca device doctor
  ca device sim --seconds 1
  ca device sim --rest '-8 mm' --depth '7.4 mm' --speed '0.4 m/s' --seconds 1
  ca device sim --dof 0,4 --rest='0,0,0,0,-8 mm' --seconds 1
  ca device sim --profile falcon --script shake --rate 500 --seconds 1 --force-log felt.csv
  ca device calibrate tgr12 --low 0 --high 4095 -o tgr12.toml
  ca device sim --profile falcon --script hold --seconds 20 & ca device conformance falcon; kill $!")]
pub struct DeviceArgs {
    /// what to do
    #[command(subcommand)]
    pub what: DeviceCommand,
}

/// What is done about devices.
#[derive(Subcommand)]
pub enum DeviceCommand {
    /// Is a device without hardware: a body in a hand that plays a script
    Sim(Box<SimArgs>),
    /// Lists the devices that speak here, and the profiles there are
    List {
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Says whether this machine can play, and what helps
    Doctor {
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Writes down what a device says at its two stops, so that its positions are metres
    Calibrate(CalibrateArgs),
    /// Tests a running device process, with forces
    ///
    /// It asks of the device all that the engine relies on, and some of its phases move the device by forces: take your hands off, and
    /// keep a switch that cuts the power of the motors within reach; software does not replace it (docs/safety.md). `--force 0` leaves
    /// these phases out. Exit code 1 where something is not as it must be.
    Conformance(ConformanceArgs),
}

/// A simulated device.
#[derive(Args)]
pub struct SimArgs {
    /// What it is: a profile by name (`ca device list`) or file
    #[arg(long, value_name = "NAME|FILE", default_value = "tgr12")]
    pub profile: String,
    /// What its hand does
    #[arg(long, value_enum, default_value_t = ScriptKind::Strike)]
    pub script: ScriptKind,
    /// Where its hand rests: one place, or one for each degree of freedom in order, of which the last is that of all others; the
    /// middle of its travel if left out
    #[arg(long, value_name = "M,...", value_parser = metres, allow_hyphen_values = true, value_delimiter = ',')]
    pub rest: Vec<f64>,
    /// Degrees of freedom that move, counted from 0; all others rest. All move if left out
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    pub dof: Vec<usize>,
    /// How far its hand goes from there, down where negative
    #[arg(long, value_name = "M", value_parser = metres, allow_hyphen_values = true)]
    pub depth: Option<f64>,
    /// How fast its hand is at most; half of what trips the guard, or less, if left out
    #[arg(long, value_name = "M/S", value_parser = speed)]
    pub speed: Option<f64>,
    /// What it is called, as models name it; the name of its profile if left out
    #[arg(long)]
    pub name: Option<String>,
    /// How long it plays; until stopped if left out
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Holds still until forces come, as a hand would, and plays then; not for `--script push`, which has no beginning
    #[arg(long)]
    pub wait: bool,
    /// Frames a second, if not those of its profile
    #[arg(long, value_name = "HZ", value_parser = hertz)]
    pub rate: Option<f64>,
    /// Seed of the random noise on its measured positions; the same seed gives the same noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Frames that a force is under way before the motors have it
    #[arg(long, value_name = "FRAMES", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=31))]
    pub delay: u16,
    /// What `--script file` plays: its tracks are degrees of freedom in order, in metres (csv, npy, wav)
    #[arg(long, value_name = "FILE", required_if_eq("script", "file"))]
    pub gesture: Option<PathBuf>,
    /// Force of `--script push` in newtons; a fifth of its largest, downwards, if left out
    #[arg(long, value_name = "N")]
    pub push: Option<f64>,
    /// Waits for the force that answers each frame, and keeps no time of its own: with `ca serve --clock device` a loop
    /// that is the same every time. For measurements, never with a hand
    #[arg(long)]
    pub lockstep: bool,
    /// Writes each frame to a file: number, time, number of the force, its mode, why off, positions, forces held
    #[arg(long, value_name = "FILE.csv")]
    pub force_log: Option<PathBuf>,
    /// Priority (SCHED_FIFO); 0 asks for none
    #[arg(long, value_name = "0-99", default_value_t = 60, value_parser = clap::value_parser!(u8).range(0..=99))]
    pub priority: u8,
    /// Prints what it saw as JSON
    #[arg(long)]
    pub json: bool,
}

/// What a simulated hand does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ScriptKind {
    /// down and up again, twice a second
    Strike,
    /// evenly back and forth
    Bow,
    /// fast and small
    Shake,
    /// stays in the middle
    Hold,
    /// is no hand: a force on the bare device
    Push,
    /// what `--gesture` says
    File,
}

/// A calibration.
#[derive(Args)]
pub struct CalibrateArgs {
    /// The device, running, unless `--low` and `--high` say what it says
    pub name: String,
    /// What it is, for the distance between its stops: a profile by name or file
    #[arg(long, value_name = "NAME|FILE")]
    pub profile: Option<String>,
    /// What it says at its low stops: one number, or one for each degree of freedom
    #[arg(long, value_name = "N,...", value_delimiter = ',', requires = "high")]
    pub low: Vec<f64>,
    /// What it says at its high stops
    #[arg(long, value_name = "N,...", value_delimiter = ',', requires = "low")]
    pub high: Vec<f64>,
    /// The file to write; the one `ca serve` reads for this device if left out
    #[arg(short, long, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Prints it as JSON too
    #[arg(long)]
    pub json: bool,
}

/// A test of a device.
#[derive(Args)]
pub struct ConformanceArgs {
    /// The device, running
    pub name: String,
    /// The profile that `ca serve` will be given for it, by name or file; the profile with its name if left out
    #[arg(long, value_name = "[DEVICE=]PROFILE")]
    pub profile: Vec<String>,
    /// Largest force it is given, in newtons; at most a twentieth of what it says it can give. 0 tests without
    #[arg(long, value_name = "N", default_value_t = 0.5)]
    pub force: f64,
    /// Prints the table as JSON
    #[arg(long)]
    pub json: bool,
}
