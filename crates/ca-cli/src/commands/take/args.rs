//! Arguments of `ca replay` and `ca log`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Plays a take again, and says whether it is as it was
///
/// A take (`*.mcap`) holds the model, the devices and every frame, so nothing else is needed. Each force frame, each
/// sound sample and each hash of the state is computed again and compared to the bit; the first difference is shown,
/// with both values. Exit code 3 if something is not as it was, or is missing in the take; with `--verify`, 1.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca replay take.mcap
  ca replay take.mcap --verify --json
  ca replay take.mcap --energy
  ca replay take.mcap -o again.wav")]
pub struct ReplayArgs {
    /// The take, `*.mcap`, finished or cut off
    pub file: PathBuf,
    /// Fails if anything is not as it was
    #[arg(long)]
    pub verify: bool,
    /// Writes the sound as it is computed now
    #[arg(short, long, value_name = "FILE.wav")]
    pub output: Option<PathBuf>,
    /// Keeps the energy ledger, and says where the energy of the hands went
    #[arg(long)]
    pub energy: bool,
    /// Prints the verdict as JSON
    #[arg(long)]
    pub json: bool,
}

/// Looks into takes, saves what was cut off, and takes parts out
///
/// A take (`*.mcap`) is one performance: model, devices, every frame, sound, events. It opens in Foxglove, Lichtblick,
/// PlotJuggler and Python (`mcap`); these commands do without. A take whose program was killed reads up to its last
/// quarter of a second.
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

/// What is done with a take.
#[derive(Subcommand)]
pub enum LogCommand {
    /// Shows topics, counts, length, what was lost, and faults with cause and time
    Info {
        /// The take, `*.mcap`
        file: PathBuf,
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Copies what is whole of a take that was cut off into a new file with an index
    Recover {
        /// The take, `*.mcap`; it is left as it is
        file: PathBuf,
        /// The file to write; `NAME.recovered.mcap` beside the take if left out
        #[arg(short, long, value_name = "FILE.mcap")]
        output: Option<PathBuf>,
        /// Overwrites the file
        #[arg(long)]
        force: bool,
    },
    /// Takes a part out: a topic as .csv or .npy, `sound` as .wav, `model`, or an attachment by its name
    Export {
        /// The take, `*.mcap`
        file: PathBuf,
        /// `sound`, `model`, a topic such as `/device/tgr12/in`, or the name of an attachment
        what: String,
        /// The file to write
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        /// Overwrites the file
        #[arg(long)]
        force: bool,
    },
}
