//! `ca tune`: tunes parts of a model to a pitch.

mod args;
mod pitch;

pub use args::{Scale, TuneArgs};

use crate::args::Source;
use crate::load::{self, Loaded};
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_compile::Options;
use ca_core::Level;
use ca_fit::tune::{PitchTarget, Tuned, tune};
use ca_model::{Model, Value, quantity};
use pitch::pitch;
use serde_json::{Value as Json, json};
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
    let targets = targets(args, &loaded.model)?;
    let (text, done) = tune(&mut loaded, &targets, args.mode)?;
    let scene = load::scene(&loaded, &Options::default())?;
    if scene.certificate.level == Level::Unstable {
        term::findings(&scene.findings, &loaded.model);
        return Err(Failure::Failed(
            "the tuned model would diverge; choose a lower pitch, or a higher sound rate".into(),
        ));
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

/// Lists the parts, or single cells of banks, with their target pitches.
fn targets(args: &TuneArgs, model: &Model) -> Result<Vec<PitchTarget>, Failure> {
    let usage = Failure::Usage;
    let Some((scale, root)) = args.scale.zip(args.root.as_deref()) else {
        let target = |text: &String| {
            let (part, to) =
                text.split_once('=').ok_or_else(|| format!("`{text}`: expected PART=PITCH, e.g. `low=A2`"))?;
            Ok(PitchTarget { part: part.trim().to_owned(), cell: None, hz: pitch(to, args.a4)? })
        };
        return args.parts.iter().map(target).collect::<Result<_, String>>().map_err(usage);
    };
    let root = pitch(root, args.a4).map_err(usage)?;
    let mut all = Vec::new();
    for part in &args.parts {
        if part.contains('=') {
            return Err(usage(format!(
                "`{part}`: with `--scale`, the scale sets the pitch; give only the name of the part"
            )));
        }
        let cells = model.items.iter().find(|i| i.name == *part).and_then(|i| i.args.iter().find(|e| e.key == "f"));
        match cells.map(|e| &e.value) {
            Some(Value::List(list)) => {
                all.extend((0..list.len()).map(|k| PitchTarget { part: part.clone(), cell: Some(k), hz: 0.0 }));
            }
            _ => all.push(PitchTarget { part: part.clone(), cell: None, hz: 0.0 }),
        }
    }
    all.iter_mut().enumerate().for_each(|(n, w)| w.hz = root * scale.degree(n));
    Ok(all)
}

fn print(loaded: &Loaded, done: &[Tuned], as_json: bool) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    if as_json {
        let list: Vec<Json> = done
            .iter()
            .map(|t| {
                json!({ "part": t.part, "wanted_hz": t.target, "before_hz": t.before, "heard_hz": t.reached, "off_cents": t.off(),
                    "number": t.number })
            })
            .collect();
        writeln!(out, "{:#}", json!({ "name": loaded.name, "tuned": list }))?;
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
