//! Shell completion.
//!
//! The shell runs this program at each Tab. So the names of models come from one list and are always current, unlike
//! those in a script with fixed lists.

use ca_core::Catalog;
use ca_lab::catalog;
use ca_lab::load::BUNDLED;
use ca_model::diag::CODES;
use ca_model::part::library::LIBRARY;
use clap_complete::CompletionCandidate;
use clap_complete::engine::{PathCompleter, ValueCompleter as _};
use std::ffi::OsStr;
use std::path::Path;

fn named<'a>(current: &OsStr, all: impl IntoIterator<Item = &'a str>) -> Vec<CompletionCandidate> {
    let begun = current.to_string_lossy();
    all.into_iter().filter(|name| name.starts_with(&*begun)).map(CompletionCandidate::new).collect()
}

pub(crate) fn bundled(current: &OsStr) -> Vec<CompletionCandidate> {
    named(current, BUNDLED.iter().map(|m| m.0))
}

/// Completes names of bundled models and paths of model files.
pub(crate) fn models(current: &OsStr) -> Vec<CompletionCandidate> {
    let is_model = |path: &Path| {
        let name = path.to_string_lossy();
        name.ends_with(".ca.toml") || ca_import::of(&name).is_some()
    };
    let mut all = bundled(current);
    all.extend(PathCompleter::any().filter(is_model).stdio().complete(current));
    all
}

/// Completes paths of files that `ca import` reads.
pub(crate) fn foreign(current: &OsStr) -> Vec<CompletionCandidate> {
    PathCompleter::any().filter(|path| ca_import::of(&path.to_string_lossy()).is_some()).complete(current)
}

pub(crate) fn listed(current: &OsStr) -> Vec<CompletionCandidate> {
    named(current, pages(&catalog()))
}

pub(crate) fn codes(current: &OsStr) -> Vec<CompletionCandidate> {
    named(current, CODES.iter().map(|c| c.0))
}

/// All words with a page in `ca list`.
pub(crate) fn pages(catalog: &Catalog) -> Vec<&'static str> {
    let words = ["kinds", "models", "parts"].into_iter().chain(catalog.iter().map(|k| k.code));
    words.chain(BUNDLED.iter().map(|m| m.0)).chain(LIBRARY.iter().map(|p| p.0)).collect()
}
