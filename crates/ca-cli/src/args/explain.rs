//! A code of a finding.

use super::completions;
use clap::Args;
use clap_complete::ArgValueCompleter;

/// Explains a finding by its code
///
/// Prints the page of a code such as E013: what it means, models that have the finding, and what is said of each and how
/// it is mended. Without a code: all of them with their titles; E are errors, for which nothing is compiled, W warnings, N
/// notes. The pages are part of the program, and those of its version.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca explain
  ca explain E013
  ca explain w103 --json")]
pub struct ExplainArgs {
    /// The code, as it stands in brackets behind `error`, `warning` or `note`
    #[arg(add = ArgValueCompleter::new(completions::codes))]
    pub code: Option<String>,
    /// As JSON
    #[arg(long)]
    pub json: bool,
}
