//! Arguments of `ca check`.

use crate::args::Source;
use clap::Args;

/// Says everything that can be known of a model before it sounds
///
/// Reads, checks and compiles the model, shows every finding with its place and what to do, and sums up: modules,
/// rates, how late force and sound answer a gesture, what the springs at each device key ask of a device, what is proven
/// of stability and which module is nearest to the limit. With `--schedule`, the passes of one
/// tick in order with their cost, measured here and now, and what the compiler left out; beside it the cost that a table
/// of instructions predicts, at what an instruction takes here in a network of links that are looked up one by one. With `--device`, what of it that
/// device can render: each key's stiffness against the device's own and against what stays passive, and to what it is softened
/// where it is beyond, the force over the travel against the largest, degrees of freedom and rates. Exit code 1 with errors, 3 if the model is certainly unstable
/// or asks more of the device than it can give: stiffness, travel, degrees of freedom. A force that only passes the largest is
/// none of these: it is rendered up to that, as at every hard stop.
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
    /// Shows the passes of one tick and measures what each costs
    #[arg(long)]
    pub schedule: bool,
    /// Plays the model and shows how loud each output is, and by how much its gain is off
    #[arg(long)]
    pub levels: bool,
    /// Narrows down the largest eigenvalue, and so how much stiffer everything could be
    #[arg(long)]
    pub exact: bool,
    /// Compares with a device: the name of a profile that comes with us, or a file `profile.toml`
    #[arg(long, value_name = "NAME|FILE")]
    pub device: Option<String>,
    /// Checks again whenever the file is saved, until Ctrl-C
    #[arg(long, conflicts_with = "json")]
    pub watch: bool,
    /// Prints `{diagnostics, summary, schedule, levels, device}` as JSON
    #[arg(long)]
    pub json: bool,
}
