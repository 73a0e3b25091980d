//! Arguments of `ca replay` and `ca log`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Replays a take and compares the result with the recording
///
/// A take (`*.mcap`) contains the model, the devices and every frame, so nothing else is needed. Each force frame, each
/// sound sample and each hash of the state is computed again and compared bit by bit. The first difference is shown
/// with both values. Exit code 3 if something differs or is missing in the take; with `--verify`, exit code 1.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca replay take.mcap
  ca replay take.mcap --verify --json
  ca replay take.mcap --energy
  ca replay take.mcap -o again.wav")]
pub struct ReplayArgs {
    /// The take, `*.mcap`, complete or cut off
    pub file: PathBuf,
    /// Fails (exit code 1) if anything differs or is missing
    #[arg(long)]
    pub verify: bool,
    /// Writes the sound of the replay
    #[arg(short, long, value_name = "FILE.wav")]
    pub output: Option<PathBuf>,
    /// Computes the energy ledger, and shows where the energy of the hands went
    #[arg(long)]
    pub energy: bool,
    /// Prints the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Shows takes, recovers takes that were cut off, and exports parts of takes
///
/// A take (`*.mcap`) is one performance: model, devices, every frame, sound, and events. Foxglove, Lichtblick,
/// PlotJuggler and Python (`mcap`) can open it; these commands do not need them. If the program was killed, the take
/// can be read up to its last quarter of a second.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca log info take.mcap
  ca log info take.mcap --json
  ca log recover take.mcap -o whole.mcap
  ca log export take.mcap sound -o take.wav
  ca log export take.mcap model -o played.ca.toml
  ca log export take.mcap /device/tgr12/in -o hand.npy
  ca log export take.mcap /device/tgr12/out -o force.csv")]
pub struct LogArgs {
    /// what to do
    #[command(subcommand)]
    pub what: LogCommand,
}

/// Actions on a take.
#[derive(Subcommand)]
pub enum LogCommand {
    /// Shows topics, counts, length, losses, and faults with cause and time
    Info {
        /// The take, `*.mcap`
        file: PathBuf,
        /// Prints the information as JSON
        #[arg(long)]
        json: bool,
    },
    /// Copies the intact part of a take that was cut off to a new file with an index
    Recover {
        /// The take, `*.mcap`; it is not changed
        file: PathBuf,
        /// File to write (default: `NAME.recovered.mcap` beside the take)
        #[arg(short, long, value_name = "FILE.mcap")]
        output: Option<PathBuf>,
        /// Overwrites the file
        #[arg(long)]
        force: bool,
    },
    /// Exports a part: a topic as .csv or .npy, `sound` as .wav, `model`, or an attachment by its name
    Export {
        /// The take, `*.mcap`
        file: PathBuf,
        /// `sound`, `model`, a topic such as `/device/tgr12/in`, or the name of an attachment
        what: String,
        /// File to write
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        /// Overwrites the file
        #[arg(long)]
        force: bool,
    },
}
