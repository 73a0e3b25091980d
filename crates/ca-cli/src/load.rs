//! From what was typed to a model and a scene.

use crate::Failure;
use crate::args::Source;
use ca_core::{Options, Scene};
pub use ca_lab::load::{
    BUNDLED, Loaded, bundled, compiled, has_extension, import, mims_text, reason, stem, text, ticked, warnings,
};
use std::path::Path;

/// Refuses to write sound to a file that is not called `.wav`.
pub fn is_sound(path: &Path) -> Result<(), Failure> {
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

/// Compiles, or shows all findings and ends the command.
pub fn scene(loaded: &Loaded, options: &Options) -> Result<Scene, Failure> {
    Ok(ca_lab::load::scene(loaded, options)?)
}
