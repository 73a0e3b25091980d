//! Arguments of `ca check`.

use crate::args::Source;
use clap::Args;

/// Checks a model and shows what is known about it before it plays
///
/// Reads, checks and compiles the model, shows each finding with its place and a remedy, and prints a summary: modules,
/// rates, the delay from a gesture to force and sound, the demands of the springs at each device key, what is proven
/// about stability, and the module nearest to the limit.
///
/// With `--schedule`, it also lists the passes of one tick in order, each with its cost measured on this machine, and
/// what the compiler left out. A predicted cost is shown beside the measured one. It comes from a table of instruction
/// counts and the time of an instruction, measured in a network of links that are looked up one by one.
///
/// With `--device`, it also shows what that device can render: the stiffness of each key compared with the stiffness of
/// the device and with the passive limit, the softened stiffness of a key beyond a limit, the force over the travel
/// compared with the largest force, degrees of freedom, and rates.
///
/// Exit code 1 if there are errors. Exit code 3 if the model is certainly unstable, or demands more stiffness, travel
/// or degrees of freedom than the device has. A force above the largest does not change the exit code: it is limited to
/// the largest, as at every hard stop.
#[allow(clippy::struct_excessive_bools)]
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca check hammered_string
  ca check hammered_string --schedule
  ca check hammered_string --levels
  ca check hammered_string --set hammer.m='30 g' --rate '96 kHz' --json
  ca check harmonic_chain --exact
  ca check piano_key --latency 1
  ca check hammer_piano --device tgr12")]
pub struct CheckArgs {
    /// the model
    #[command(flatten)]
    pub source: Source,
    /// Shows the passes of one tick and measures the cost of each
    #[arg(long)]
    pub schedule: bool,
    /// Plays the model and shows the level of each output and a factor for its gain
    #[arg(long)]
    pub levels: bool,
    /// Computes tight bounds of the largest eigenvalue, and how much stiffer all links could be
    #[arg(long)]
    pub exact: bool,
    /// Compares with a device: the name of a profile (`ca device list`), or a profile file `*.toml`
    #[arg(long, value_name = "NAME|FILE")]
    pub device: Option<String>,
    /// Checks again each time the file is saved, until Ctrl-C
    #[arg(long, conflicts_with = "json")]
    pub watch: bool,
    /// Prints `{diagnostics, summary, schedule, levels, device}` as JSON
    #[arg(long)]
    pub json: bool,
}
