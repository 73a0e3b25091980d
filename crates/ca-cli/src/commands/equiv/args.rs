//! Arguments of `ca equiv`.

use crate::args::common::{model_help, pair, quantity_of};
use crate::args::completions;
use ca_core::Unit;
use clap::Args;
use clap_complete::ArgValueCompleter;
use std::path::PathBuf;

/// Shows and sets how large and how heavy a model is in the hand
///
/// The table says what 1 of each quantity of the model is in the real world. `--set` makes one equivalence true and
/// recomputes all others: of one row, while the anchor stays (the travel of the keys, unless said otherwise); of two rows
/// of different kinds, both. `--key` lets one key differ from the others: `--lever` keeps its energy, `--position` and
/// `--force-factor` are the two factors of their own. Nothing is written unless `--write` or `--in-place` says where; the
/// rest of the file, its comments too, stays as it is.
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
    /// Makes so much in the hand equal so much in the model, e.g. mass=20g:1.0; once or twice
    #[arg(long = "set", value_name = "ROW=REAL:SIM", value_parser = equivalence)]
    pub set: Vec<(String, String)>,
    /// What stays while one row is set: position, force, impedance, energy, or a row that stands for one of them
    #[arg(long, value_name = "ROW")]
    pub anchor: Option<String>,
    /// The device key (TGR) that is given a scale of its own
    #[arg(long, requires = "own")]
    pub key: Option<String>,
    /// Both factors of the key: a lever
    #[arg(long, value_parser = factor, group = "own", requires = "key", conflicts_with_all = ["position", "force_factor"])]
    pub lever: Option<f64>,
    /// Its positions, beside those of the other keys
    #[arg(long, value_parser = factor, group = "own", requires = "key")]
    pub position: Option<f64>,
    /// Its forces, beside those of the other keys
    #[arg(long, value_parser = factor, group = "own", requires = "key")]
    pub force_factor: Option<f64>,
    /// where it is written
    #[command(flatten)]
    pub to: WriteTo,
    /// Shows alpha and beta too
    #[arg(short, long)]
    pub verbose: bool,
    /// Prints the table as JSON
    #[arg(long)]
    pub json: bool,
}

/// Where a changed model goes.
#[derive(Args)]
pub struct WriteTo {
    /// Writes the changed model to a new file
    #[arg(long, value_name = "FILE.ca.toml", conflicts_with = "in_place")]
    pub write: Option<PathBuf>,
    /// Changes the model file itself
    #[arg(long)]
    pub in_place: bool,
    /// Overwrites the file of `--write`
    #[arg(long)]
    pub force: bool,
}

fn equivalence(text: &str) -> Result<(String, String), String> {
    pair(text).map_err(|_| "write it like `mass=20g:1.0`".into())
}

fn factor(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::NONE, (1e-6, 1e6))
}
