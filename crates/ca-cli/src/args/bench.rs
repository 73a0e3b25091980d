//! How much fits.

use clap::Args;
use std::path::PathBuf;

/// Measures how many modules of each kind play in real time here
///
/// A module is a MAT or a LIA. Each network is made larger until a tick takes as long as a sample lasts at 44.1 and 48 kHz,
/// on one core, counted in the time of the processor. Other programs share its caches and its clock: what is found while nothing else
/// runs is the machine's, what is found beside them may be half of it. Beside it stand
/// the three engines of Leonard, Castagné and Cadoz (2013, Table 1), on the DSP of their time, and how many of each bundled
/// instrument play at once. Parameters differ from module to module everywhere.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca bench
  ca bench --only string,cells,mesh
  ca bench --curve --page bench.html
  ca bench --only string --json")]
pub struct BenchArgs {
    /// Only these networks, by name, and no instruments
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Also the cost of a string of 100 to 1 000 000 modules (half a minute, 2 GB)
    #[arg(long)]
    pub curve: bool,
    /// Also a page with tables and curve
    #[arg(long, value_name = "FILE.html")]
    pub page: Option<PathBuf>,
    /// Prints the tables as JSON
    #[arg(long)]
    pub json: bool,
}
