//! Reads models and compiles scenes from arguments.

use crate::args::Source;
use crate::outcome::Failure;
use crate::term;
use ca_compile::{Compiled, Options};
use ca_core::internal::scene::PRESET;
use ca_io::{FileError, read_limited};
pub use ca_lab::load::{
    BUNDLED, Loaded, bundled, compiled, foreign_text, has_extension, reason, stem, text, ticked, utf8, warnings,
};
use ca_model::diag::Severity;
use std::path::Path;
use std::sync::OnceLock;

pub const STDIN: &str = "-";

/// Reads the model named by a word: a file, a bundled model, or `-` for standard input. Standard input is read once per
/// run and returns the same model each time.
pub fn read(word: &str) -> Result<Loaded, ca_lab::Failure> {
    static TEXT: OnceLock<Result<String, FileError>> = OnceLock::new();
    if word != STDIN {
        return ca_lab::load::load(word);
    }
    let text = TEXT.get_or_init(|| {
        let name = Path::new("stdin");
        utf8(read_limited::text_from(&mut std::io::stdin().lock(), name, read_limited::MODEL)?, name)
    });
    Ok(Loaded::read(text.as_ref().map_err(Clone::clone)?, "stdin"))
}

/// Returns the path of a model to be changed in place. Refuses standard input and bundled models.
pub fn own_file(word: &str) -> Result<&Path, Failure> {
    let why = match word {
        STDIN => "standard input cannot be changed in place",
        _ if Path::new(word).exists() => return Ok(Path::new(word)),
        _ => "a bundled model cannot be changed in place",
    };
    Err(Failure::Usage(format!("`{word}`: {why}; write a copy with `--write FILE.ca.toml`")))
}

/// Sound rate \[Hz\] below which `--rate` probably lacks its `k`.
const LOW_RATE: f64 = 1000.0;

/// Reads the model and applies `--set`.
pub fn load(source: &Source) -> Result<Loaded, Failure> {
    if let Some(rate) = source.rate.filter(|r| *r < LOW_RATE) {
        term::note(&format!("the sound rate is {rate} Hz (`--rate`); did you mean `{rate}k`?"));
    }
    Ok(changed(read(&source.model)?, source)?)
}

/// Applies `--set` and `--preset` to a model.
pub fn changed(mut loaded: Loaded, source: &Source) -> Result<Loaded, ca_lab::Failure> {
    for (name, value) in source.changes() {
        ca_lab::load::set_typed(&mut loaded, &name, &value).map_err(|e| match e {
            ca_lab::Failure::Usage(what) => {
                let option = if name == PRESET { "--preset" } else { "--set" };
                ca_lab::Failure::Usage(format!("{option}: {what}"))
            }
            other => other,
        })?;
    }
    Ok(loaded)
}

/// Prints the full warnings about a model, but no other findings. `-q` does not suppress them.
pub fn warn(loaded: &Loaded, scene: &Compiled) {
    let mut diags = scene.findings.clone();
    diags.list.retain(|d| d.severity == Severity::Warning);
    if !diags.list.is_empty() {
        term::findings(&diags, &loaded.model);
    }
}

/// Compiles a model. If it has errors, returns all findings.
pub fn scene(loaded: &Loaded, options: &Options) -> Result<Compiled, Failure> {
    Ok(loaded.compile(options).map_err(ca_lab::Failure::Found)?)
}
