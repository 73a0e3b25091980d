//! `ca import`: a MIMS model becomes a model file.
//!
//! Decides that an import ends with a compilation, because what was imported is only worth something if it runs.

use crate::args::ImportArgs;
use crate::load::{self, Loaded};
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_compile::Options;
use ca_core::Level;
use ca_model::{Model, write};
use std::io::Write as _;
use std::path::PathBuf;

/// Runs the command.
pub fn run(args: &ImportArgs) -> Outcome {
    let text = load::mims_text(&args.file)?;
    let file = args.file.display().to_string();
    let Loaded { model, diags: notes, .. } = Loaded::import(&text, &file);
    // the findings point into the MIMS text
    let original = Model { file, text, ..Model::default() };
    term::findings(&notes, &original);
    if notes.has_errors() {
        return Err(Failure::Reported);
    }
    let output = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.ca.toml", load::stem(&args.file))));
    let text = write::write(&model);
    super::new::write(&output, &text, args.force)?;
    let mut out = std::io::stdout().lock();
    let shown = output.display().to_string();
    writeln!(out, "{shown} written: {} lines from {}", text.lines().count(), original.text.lines().count())?;

    let loaded = Loaded::read(&text, &shown);
    let (scene, diags) = load::compiled(&loaded, &Options::default());
    term::findings(&diags, &loaded.model);
    let Some(scene) = scene else { return Err(Failure::Reported) };
    writeln!(out, "it compiles: {} MAT, {} LIA, stability {}", scene.mats(), scene.lias(), scene.certificate.level)?;
    writeln!(out, "hear it with\n\n  ca render {shown}\n")?;
    Ok(if scene.certificate.level == Level::Unstable { Ended::Degraded } else { Ended::Well })
}
