//! From what was typed to a model and a scene.

use crate::args::Source;
use crate::outcome::Failure;
use crate::term;
use ca_compile::{Compiled, Options};
pub use ca_lab::load::{
    BUNDLED, Loaded, bundled, compiled, has_extension, mims_text, reason, stem, text, ticked, warnings,
};
use ca_model::diag::Severity;
use std::path::Path;

/// Refuses to write sound to a file that is not called `.wav`.
pub fn check_wav_path(path: &Path) -> Result<(), Failure> {
    // a device such as /dev/null has no extension, and need not
    let plain = !path.exists() || path.is_file();
    if plain && !has_extension(path, "wav") {
        let what = format!("`{}`: sound is written as WAV", path.display());
        return Err(Failure::Usage(format!("{what}; give the file the extension `.wav`")));
    }
    Ok(())
}

/// Reads the model and applies `--set`.
pub fn load(source: &Source) -> Result<Loaded, Failure> {
    let mut loaded = ca_lab::load::load(&source.model)?;
    for (name, value) in source.changes() {
        ca_lab::load::set_typed(&mut loaded, &name, &value).map_err(|e| match Failure::from(e) {
            Failure::Usage(what) => Failure::Usage(format!("--set: {what}")),
            other => other,
        })?;
    }
    Ok(loaded)
}

/// Prints the warnings about a model in full, and nothing else that was found; `-q` leaves them.
pub fn warn(loaded: &Loaded, scene: &Compiled) {
    let mut diags = scene.findings.clone();
    diags.list.retain(|d| d.severity == Severity::Warning);
    if !diags.list.is_empty() {
        term::findings(&diags, &loaded.model);
    }
}

/// Compiles, or shows all findings and ends the command.
pub fn scene(loaded: &Loaded, options: &Options) -> Result<Compiled, Failure> {
    Ok(ca_lab::load::scene(loaded, options)?)
}
