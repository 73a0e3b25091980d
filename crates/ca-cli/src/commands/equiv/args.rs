//! Arguments of `ca equiv`.

use crate::args::common::{model_help, pair, quantity_of};
use crate::args::completions;
use ca_core::Unit;
use clap::Args;
use clap_complete::ArgValueCompleter;
use std::path::PathBuf;

/// Scales a model to a hand: shows and sets its size and weight there
///
/// The table shows the real quantity that equals 1 of each quantity in the model. `--set` makes one equivalence true
/// and recomputes all others. If one row is set, the anchor stays the same (by default the travel of the keys). If two
/// rows of different kinds are set, both become true. `--key` gives one key a different scale: `--lever` keeps its
/// energy; `--position` and `--force-factor` set its two factors separately.
///
/// Nothing is written without `--write` or `--in-place`. The rest of the file, including comments, does not change.
#[allow(clippy::struct_excessive_bools)]
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca equiv piano_key
  ca equiv piano_key --set mass='20 g:10 g' --write heavy.ca.toml
  ca equiv heavy.ca.toml --set position='20 mm:10 mm' --in-place
  ca equiv heavy.ca.toml --set energy='1 mJ:2 mJ' --anchor impedance --json
  ca equiv heavy.ca.toml --key 'key[2].key' --lever 2 --verbose")]
#[command(group(clap::ArgGroup::new("own").multiple(true)))]
pub struct EquivArgs {
    /// the model
    #[arg(help = model_help(), add = ArgValueCompleter::new(completions::models))]
    pub model: String,
    /// Makes a real quantity equal a quantity in the model, e.g. mass=20g:1.0; once or twice
    #[arg(long = "set", value_name = "ROW=REAL:SIM", value_parser = equivalence, help_heading = "Scale")]
    pub set: Vec<(String, String)>,
    /// Row that stays the same while one row is set: position, force, impedance, energy, or a row of the same kind
    #[arg(long, value_name = "ROW", help_heading = "Scale")]
    pub anchor: Option<String>,
    /// Device key (TGR) that gets a different scale
    #[arg(long, requires = "own", help_heading = "Scale of one key")]
    pub key: Option<String>,
    /// Sets both factors of the key to one value, as a lever does
    #[arg(long, value_parser = factor, group = "own", requires = "key", conflicts_with_all = ["position", "force_factor"])]
    #[arg(help_heading = "Scale of one key")]
    pub lever: Option<f64>,
    /// Factor of its positions, relative to the other keys
    #[arg(long, value_parser = factor, group = "own", requires = "key", help_heading = "Scale of one key")]
    pub position: Option<f64>,
    /// Factor of its forces, relative to the other keys
    #[arg(long, value_parser = factor, group = "own", requires = "key", help_heading = "Scale of one key")]
    pub force_factor: Option<f64>,
    /// where it is written
    #[command(flatten)]
    pub to: WriteTo,
    /// Also shows alpha and beta
    #[arg(short, long, help_heading = "Output")]
    pub verbose: bool,
    /// Prints the table as JSON
    #[arg(long, help_heading = "Output")]
    pub json: bool,
}

/// Destination of a changed model.
#[derive(Args)]
pub struct WriteTo {
    /// Writes the changed model to a new file
    #[arg(long, value_name = "FILE.ca.toml", conflicts_with = "in_place", help_heading = "Output")]
    pub write: Option<PathBuf>,
    /// Changes the model file itself
    #[arg(long, help_heading = "Output")]
    pub in_place: bool,
    /// Overwrites the file of `--write` if it exists
    #[arg(long, help_heading = "Output")]
    pub force: bool,
}

fn equivalence(text: &str) -> Result<(String, String), String> {
    pair(text).map_err(|_| "expected ROW=REAL:SIM, e.g. `mass=20g:1.0`".into())
}

fn factor(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::NONE, (1e-6, 1e6))
}
