//! `ca tune`: tunes parts of a model to a pitch.

mod args;

pub use args::TuneArgs;

use crate::args::Source;
use crate::load::{self, Loaded};
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_compile::Options;
use ca_fit::tune::{Tuned, stable, targets, tune, value};
use ca_model::quantity;
use std::io::Write as _;
use std::path::Path;

/// Runs the command.
pub fn run(args: &TuneArgs) -> Outcome {
    let mut loaded = load::load(&Source::of(&args.model))?;
    if let Some(format) = loaded.format {
        let what = format!("a {} file cannot be tuned; convert it to a model file with `ca import FILE`", format.name);
        return Err(Failure::Usage(what));
    }
    load::scene(&loaded, &Options::default())?;
    let scale = args.scale.zip(args.root.as_deref());
    let targets = targets(&loaded.model, &args.parts, scale, args.a4)?;
    let (text, done) = tune(&mut loaded, &targets, args.mode)?;
    let scene = load::scene(&loaded, &Options::default())?;
    if let Err(why) = stable(&scene) {
        term::findings(&scene.findings, &loaded.model);
        return Err(why.into());
    }
    if args.to.in_place {
        ca_io::atomic_file::write(load::own_file(&args.model)?, text.as_bytes())?;
    } else if let Some(path) = &args.to.write {
        super::new::write(path, &text, args.to.force)?;
    }
    print(&loaded, &done, args.json)?;
    if let Some(path) = args.to.write.as_deref().or(args.to.in_place.then_some(Path::new(&args.model))) {
        term::note(&format!("written to `{}`", path.display()));
    }
    // prints warnings and notes, as every command that compiles does
    term::findings(&loaded.diags, &loaded.model);
    Ok(Ended::Well)
}

fn print(loaded: &Loaded, done: &[Tuned], as_json: bool) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    if as_json {
        writeln!(out, "{:#}", value(&loaded.name, done))?;
        return Ok(());
    }
    writeln!(out, "{}", loaded.name)?;
    for t in done {
        let off = t.off();
        let (from, to) = (quantity::Plain(t.before), quantity::Plain(t.reached));
        writeln!(out, "  {}: {from:.4} Hz → {to:.4} Hz, {off:+.6} cents off, by {}", t.part, t.number)?;
    }
    Ok(())
}
