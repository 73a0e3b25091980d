//! Shell completion.
//!
//! The shell asks this program at each Tab, so the names of models stand in one list and never get old. The alternative is a
//! script with fixed lists.

use crate::commands::list;
use crate::load::{BUNDLED, has_extension};
use ca_lab::catalog;
use ca_model::diag::CODES;
use clap::Args;
use clap_complete::engine::{PathCompleter, ValueCompleter as _};
use clap_complete::{CompletionCandidate, Shell};
use std::ffi::OsStr;
use std::path::Path;

/// Prints what makes a shell complete commands, options and names of models
///
/// The script makes the shell ask `ca` itself at each Tab. The shell then completes commands, options and their values, bundled
/// models and model files, as the installed program has them. In bash: `echo 'source <(ca completions bash)' >> ~/.bashrc`; in zsh
/// the same with `zsh` and `~/.zshrc`; in fish: `ca completions fish > ~/.config/fish/completions/ca.fish`. Write it again
/// after an update where it is kept in a file.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca completions bash
  ca completions zsh > _ca
  ca completions fish > ca.fish")]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub shell: Shell,
}

fn named<'a>(current: &OsStr, all: impl IntoIterator<Item = &'a str>) -> Vec<CompletionCandidate> {
    let begun = current.to_string_lossy();
    all.into_iter().filter(|name| name.starts_with(&*begun)).map(CompletionCandidate::new).collect()
}

/// Bundled models.
pub(super) fn bundled(current: &OsStr) -> Vec<CompletionCandidate> {
    named(current, BUNDLED.iter().map(|m| m.0))
}

/// Bundled models and files of models.
pub(super) fn models(current: &OsStr) -> Vec<CompletionCandidate> {
    let is_model = |path: &Path| path.to_string_lossy().ends_with(".ca.toml") || has_extension(path, "mdl");
    let mut all = bundled(current);
    all.extend(PathCompleter::any().filter(is_model).stdio().complete(current));
    all
}

/// Words that `ca list` takes.
pub(super) fn listed(current: &OsStr) -> Vec<CompletionCandidate> {
    named(current, list::names(&catalog()))
}

/// Codes of findings.
pub(super) fn codes(current: &OsStr) -> Vec<CompletionCandidate> {
    named(current, CODES.iter().map(|c| c.0))
}
