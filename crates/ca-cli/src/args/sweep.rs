//! One model, many values.

use clap::Args;
use std::path::PathBuf;

/// Plays a model many times, each time with other values
///
/// A plan names a model, what is varied and between which values, and how many runs are drawn; without a number, every
/// combination is played. Each run has a row: its values, whether it was well, how loud it was, its strongest partial, its
/// decay, the time it took; a run that diverges or makes no sense is a row too, and says why. Sounds and rows go into a
/// folder, in chunks that appear whole or not at all; what is there already is not done again, so the same command goes on
/// where it was stopped. A run depends on the model, the seed and its number only: any number of threads, machines or parts
/// gives the same `manifest.parquet`, to the byte.
#[derive(Args)]
#[command(after_long_help = "A plan:
  model = \"plucked_string\"
  seconds = 0.5
  runs = 200                # without: every combination of values
  seed = 1
  audio = \"flac\"            # or \"wav\", \"none\"

  [set]
  \"left.gain\" = 0.5
  \"right.gain\" = 0.5

  [vary]
  \"pick.z\" = { from = \"20 mN s/m\", to = \"0.1 N s/m\" }
  \"pick.k\" = { from = \"1 kN/m\", to = \"9 kN/m\", log = true }
  \"low.f\" = [\"110 Hz\", \"146.83 Hz\", \"220 Hz\"]

It may also have `rate`, `gesture` (files, as of `ca render`), `gesture_rate`, `energy = true`
for the energy ledger, `measure = false` to leave out pitch and decay, `chunk = 10` runs that are
written at once, `folder`, and `steps` of a range.

Examples:
  ca sweep plucked.sweep.toml --dry-run
  ca sweep plucked.sweep.toml
  ca sweep plucked.sweep.toml -o takes --threads 2 --json
  ca sweep plucked.sweep.toml -o parts --shard 1/2
  ca sweep plucked.sweep.toml -o parts --shard 2/2")]
pub struct SweepArgs {
    /// The plan, `*.sweep.toml`
    #[arg(value_name = "PLAN.toml")]
    pub plan: PathBuf,
    /// Folder of sounds and rows; that of the plan, or its name beside it, if left out
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Does the K-th of N parts only; each may run on a machine of its own, in the same folder
    #[arg(long, value_name = "K/N", value_parser = part)]
    pub shard: Option<(u64, u64)>,
    /// Threads; as many as there are cores if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Says what would be played, and plays the first run
    #[arg(long)]
    pub dry_run: bool,
    /// Prints the summary as JSON
    #[arg(long)]
    pub json: bool,
}

fn part(text: &str) -> Result<(u64, u64), String> {
    let (k, n) = text.split_once('/').ok_or("write it like `3/64`")?;
    let (k, n) = (k.trim().parse::<u64>(), n.trim().parse::<u64>());
    match (k, n) {
        (Ok(k), Ok(n)) if (1..=n).contains(&k) => Ok((k, n)),
        _ => Err("the first of two parts is `1/2`, the other `2/2`".into()),
    }
}
