//! `ca equiv`: shows and sets the size and weight of a model in the hand.
//!
//! A change is first written as text, in the `[equivalence]` section of the model file. Everything shown comes from
//! compiling that text, so the output matches the behaviour of the file. α and β are shown only on request (GENESIS
//! paper, 6.4: users never need to change them).

mod args;
mod table;

pub use args::{EquivArgs, WriteTo};

use crate::args::Source;
use crate::load;
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_compile::Options;
use ca_core::equivalence::Equivalence;
use ca_edit::Document;
use ca_edit::equivalence::{Change, KeyScale, Refused, change};
use ca_io::atomic_file;
use ca_model::{Model, write};
use std::io::Write as _;
use std::path::Path;

/// Runs the command.
pub fn run(args: &EquivArgs) -> Outcome {
    let mut loaded = load::load(&Source::of(&args.model))?;
    let mut scene = load::scene(&loaded, &Options::default())?;
    let format = loaded.format;
    let mut text = if format.is_some() { write::write(&loaded.model) } else { loaded.model.text.clone() };
    if !args.set.is_empty() || args.anchor.is_some() || args.key.is_some() {
        text = changed(&text, &loaded.model, &scene.hand.equivalence, args)?;
        loaded = ca_lab::load::reread(&loaded, &text);
        scene = load::scene(&loaded, &Options::default())?;
    }
    if args.to.in_place {
        if let Some(format) = format {
            let why = format!(
                "a {} file cannot store equivalences; write a model file with `--write FILE.ca.toml`",
                format.name
            );
            return Err(Failure::Usage(format!("`{}`: {why}", args.model)));
        }
        atomic_file::write(load::own_file(&args.model)?, text.as_bytes())?;
    } else if let Some(path) = &args.to.write {
        super::new::write(path, &text, args.to.force)?;
    }
    let all = table::EquivalenceTable::new(&loaded, &scene);
    if args.json {
        writeln!(std::io::stdout().lock(), "{:#}", all.json())?;
    } else {
        all.text(&mut std::io::stdout().lock(), args.verbose)?;
    }
    if let Some(path) = args.to.write.as_deref().or(args.to.in_place.then_some(Path::new(&args.model))) {
        term::note(&format!("written to `{}`", path.display()));
    }
    // prints warnings and notes, as every command that compiles does
    term::findings(&loaded.diags, &loaded.model);
    Ok(Ended::Well)
}

/// Returns the text of the model with the requested section.
fn changed(text: &str, model: &Model, now: &Equivalence, args: &EquivArgs) -> Result<String, Failure> {
    let failed = |what: &dyn std::fmt::Display| Failure::Failed(format!("`{}`: {what}", model.file));
    let mut text = Document::read(text).map_err(|e| failed(&e))?;
    let scale = |key| KeyScale { key, lever: args.lever, position: args.position, force: args.force_factor };
    let asked = Change { rows: &args.set, anchor: args.anchor.as_deref(), key: args.key.as_deref().map(scale) };
    change(&mut text, now, &asked).map_err(|e| match e {
        Refused::NotASection => failed(&e),
        _ => Failure::Usage(e.to_string()),
    })?;
    Ok(text.to_string())
}
