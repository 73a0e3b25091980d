//! Arguments of `ca device`.

use crate::args::common::{hertz, metres, seconds, speed};
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Simulates, lists, calibrates and tests devices
///
/// A device is a separate process that reports the position of the hand and receives the force to apply. `sim` is a
/// device without hardware; a simulated hand plays it from a script. `conformance` is for authors of device programs:
/// it tests a running device for everything the engine relies on. `doctor` shows what this machine lacks. `calibrate`
/// and `conformance` do not work while `ca serve` uses the device. Only `conformance` applies forces.
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

/// Actions on devices.
#[derive(Subcommand)]
pub enum DeviceCommand {
    /// Simulates a device without hardware, moved by a hand that follows a script
    Sim(Box<SimArgs>),
    /// Lists the running devices and the available profiles
    List {
        /// Prints the lists as JSON
        #[arg(long)]
        json: bool,
    },
    /// Checks whether devices can be played on this machine, and suggests fixes
    Doctor {
        /// Prints the results as JSON
        #[arg(long)]
        json: bool,
    },
    /// Records the readings of a device at its two stops, so that its positions are in metres
    Calibrate(CalibrateArgs),
    /// Tests a running device process, with forces
    ///
    /// Tests everything that the engine relies on. Some phases move the device by forces: take your hands off, and keep
    /// a switch that cuts the power of the motors within reach. Software does not replace it (docs/safety.md). `--force
    /// 0` leaves these phases out. Exit code 1 if a test fails.
    Conformance(ConformanceArgs),
}

/// A simulated device.
#[derive(Args)]
pub struct SimArgs {
    /// Profile of the device, by name (`ca device list`) or file
    #[arg(long, value_name = "NAME|FILE", default_value = "tgr12", help_heading = "Device")]
    pub profile: String,
    /// Motion of the hand
    #[arg(long, value_enum, default_value_t = ScriptKind::Strike, help_heading = "Hand")]
    pub script: ScriptKind,
    /// Rest position of the hand: one for all degrees of freedom, or a list in their order, whose last position
    /// applies to the remaining ones (default: the middle of the travel)
    #[arg(long, value_name = "M,...", value_parser = metres, allow_hyphen_values = true, value_delimiter = ',')]
    #[arg(help_heading = "Hand")]
    pub rest: Vec<f64>,
    /// Degrees of freedom that move, counted from 0; the others rest (default: all)
    #[arg(long, value_name = "N,...", value_delimiter = ',', help_heading = "Hand")]
    pub dof: Vec<usize>,
    /// Distance that the hand moves from its rest position; down if negative
    #[arg(long, value_name = "M", value_parser = metres, allow_hyphen_values = true, help_heading = "Hand")]
    pub depth: Option<f64>,
    /// Largest speed of the hand (default: half of the speed that trips the guard, or less)
    #[arg(long, value_name = "M/S", value_parser = speed, help_heading = "Hand")]
    pub speed: Option<f64>,
    /// Name of the device, by which models refer to it (default: the name of its profile)
    #[arg(long, help_heading = "Device")]
    pub name: Option<String>,
    /// Duration (default: until stopped)
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Holds still until forces come, as a hand would, then plays; not for `--script push`, which pushes all the time
    #[arg(long, help_heading = "Hand")]
    pub wait: bool,
    /// Frames per second (default: the rate of its profile)
    #[arg(long, value_name = "HZ", value_parser = hertz, help_heading = "Device")]
    pub rate: Option<f64>,
    /// Seed of the random noise on its measured positions; the same seed gives the same noise
    #[arg(long, default_value_t = 1, help_heading = "Device")]
    pub seed: u64,
    /// Frames until the motors apply a force
    #[arg(long, value_name = "FRAMES", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=31))]
    #[arg(help_heading = "Device")]
    pub delay: u16,
    /// File for `--script file` (csv, npy, wav): its tracks are the degrees of freedom in order, in metres
    #[arg(long, value_name = "FILE", required_if_eq("script", "file"), help_heading = "Hand")]
    pub gesture: Option<PathBuf>,
    /// Force of `--script push` in newtons (default: a fifth of the largest force, downwards)
    #[arg(long, value_name = "N", help_heading = "Hand")]
    pub push: Option<f64>,
    /// Waits for the force that answers each frame instead of keeping time. With `ca serve --clock device`, each run is
    /// the same. For measurements, never with a hand
    #[arg(long)]
    pub lockstep: bool,
    /// Writes each frame to a file: its number and time, the number and mode of the force, why forces are off,
    /// positions, and forces applied
    #[arg(long, value_name = "FILE.csv")]
    pub force_log: Option<PathBuf>,
    /// Priority of the process (SCHED_FIFO); 0 requests none
    #[arg(long, value_name = "0-99", default_value_t = 60, value_parser = clap::value_parser!(u8).range(0..=99))]
    pub priority: u8,
    /// Prints the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// Motion of a simulated hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ScriptKind {
    /// down and up again, twice a second
    Strike,
    /// evenly back and forth
    Bow,
    /// fast and small
    Shake,
    /// stays at rest
    Hold,
    /// no hand, but a constant force on the device
    Push,
    /// plays the file of `--gesture`
    File,
}

/// A calibration.
#[derive(Args)]
pub struct CalibrateArgs {
    /// Name of the device; it must be running unless `--low` and `--high` are given
    pub name: String,
    /// Profile by name or file, which gives the distance between the stops
    #[arg(long, value_name = "NAME|FILE")]
    pub profile: Option<String>,
    /// Readings at the low stops: one number, or one for each degree of freedom
    #[arg(long, value_name = "N,...", value_delimiter = ',', requires = "high")]
    pub low: Vec<f64>,
    /// Readings at the high stops, in the same form
    #[arg(long, value_name = "N,...", value_delimiter = ',', requires = "low")]
    pub high: Vec<f64>,
    /// File to write (default: the file that `ca serve` reads for this device)
    #[arg(short, long, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Prints the calibration as JSON
    #[arg(long)]
    pub json: bool,
}

/// A test of a device.
#[derive(Args)]
pub struct ConformanceArgs {
    /// Name of the running device
    pub name: String,
    /// Profile that `ca serve` will use for the device, by name or file (default: the profile with its name)
    #[arg(long, value_name = "[DEVICE=]PROFILE")]
    pub profile: Vec<String>,
    /// Largest force applied, in newtons; never more than a twentieth of the force the device reports. 0 tests without
    /// forces
    #[arg(long, value_name = "N", default_value_t = 0.5)]
    pub force: f64,
    /// Prints the table as JSON
    #[arg(long)]
    pub json: bool,
}
