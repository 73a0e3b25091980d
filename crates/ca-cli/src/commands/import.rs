//! `ca import`: converts a model of another program to a model file.
//!
//! The import ends with a compilation, because an imported model is useful only if it runs.

use crate::args::common::imported;
use crate::args::completions;
use crate::load::{self, Loaded};
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_compile::Options;
use ca_core::Level;
use ca_model::{Model, write};
use clap::Args;
use clap_complete::ArgValueCompleter;
use std::io::Write as _;
use std::path::PathBuf;

/// Converts a model of another program to a model file
#[derive(Args)]
#[command(about = about(), long_about = long_about(), after_long_help = "Examples:
  ca import string.mdl
  ca import string.mdl -o gut.ca.toml --force")]
pub struct ImportArgs {
    /// the imported file
    #[arg(help = file_help(), add = ArgValueCompleter::new(completions::foreign))]
    pub file: PathBuf,
    /// File to write (default: the name of the model in the current directory)
    #[arg(short, long, value_name = "FILE.ca.toml")]
    pub output: Option<PathBuf>,
    /// Overwrites the file if it exists
    #[arg(long)]
    pub force: bool,
}

fn about() -> String {
    format!(
        "Converts a model of another program ({}) to a model file",
        imported(|f| format!("{}, ", f.name)).trim_end_matches(", ")
    )
}

fn long_about() -> String {
    let results = imported(|f| format!("\n\n{}: {}", f.name, f.result));
    format!(
        "{}\n\nEverything that is guessed, changed or lost is reported as a note that points into the imported file. The result is \
         compiled, and its findings are shown.{results}",
        about()
    )
}

fn file_help() -> String {
    let files = imported(|f| format!("{} model, `*.{}`, ", f.name, f.extension));
    format!("The {}", files.trim_end_matches(", "))
}

/// Runs the command.
pub fn run(args: &ImportArgs) -> Outcome {
    let name = args.file.display().to_string();
    if name.ends_with(".ca.toml") {
        return Err(Failure::Usage(format!("`{name}` is a model of this program; there is nothing to import")));
    }
    let text = load::foreign_text(&args.file)?;
    let file = args.file.display().to_string();
    let Loaded { model, diags: notes, .. } = Loaded::import(&text, &file);
    // the findings refer to the imported text
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
    writeln!(out, "to hear it, run\n\n  ca render {shown}\n")?;
    Ok(if scene.certificate.level == Level::Unstable { Ended::Degraded } else { Ended::Well })
}
