//! `ca fit`: fits numbers of a model to a recorded sound.
//!
//! This module prints and writes; `ca_fit` computes.

mod args;
mod write;

pub use args::FitArgs;

use super::render;
use crate::args::{Playing, Source};
use crate::load::{self, Loaded};
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, page, term};
use ca_compile::Options;
use ca_fit::{Distance, Fit, FitOptions, Prediction, Range, Stage, StopReason, Words, fit, report};
use ca_io::recording::Recording;
use ca_model::Value;
use ca_model::quantity::{Plain, six};
use serde_json::{Value as Json, json};
use std::io::Write as _;
use std::path::Path;

/// Runs the command.
pub fn run(args: &FitArgs) -> Outcome {
    render::listen();
    args.report.as_deref().map_or(Ok(()), page::is_page)?;
    let page = args.report.iter().map(|p| ("--report", &**p));
    let written: Vec<_> = args.to_file.write.iter().map(|p| ("--write", &**p)).chain(page).collect();
    let read = render::inputs("", &args.gesture).into_iter().chain([("the recording", &*args.to)]);
    outputs::check_distinct(&written, &read.collect::<Vec<_>>())?;
    let source = Source { set: args.set.clone(), ..Source::of(&args.model) };
    let loaded = load::load(&source)?;
    let writes = args.to_file.in_place || args.to_file.write.is_some();
    if args.to_file.in_place {
        load::own_file(&args.model)?;
    }
    if let (true, Some(format)) = (writes, loaded.format) {
        let what =
            format!("a {} file cannot be written; convert it to a model file with `ca import FILE`", format.name);
        return Err(Failure::Usage(what));
    }
    // the written text contains fitted values of varied numbers, but not values of `--set`
    if let Some((name, _)) = args.set.iter().find(|(name, _)| writes && !args.vary.contains(name)) {
        let what = format!("`--set {name}` changes a number that is not varied, so it would not be written");
        return Err(Failure::Usage(format!(
            "{what}; write the value in the file first, or add the number to `--vary`"
        )));
    }
    if let Some(path) = &args.to_file.write {
        write::may_be(path, args.to_file.force)?;
    }
    if writes {
        // refuses numbers without a place in the file before the work begins
        args.vary.iter().try_for_each(|name| write::place(&loaded.model, name).map(drop))?;
    }
    let recording = Recording::open(&args.to)?;
    let ranges: Vec<Range> = args.range.iter().map(range).collect::<Result<_, _>>()?;
    let options = Options { rate: Some(recording.rate), clouds: loaded.clouds.clone(), ..Options::default() };
    let scene = load::scene(&loaded, &options)?;
    load::warn(&loaded, &scene);
    let playing = Playing { seconds: None, gesture: args.gesture.clone(), gesture_rate: None };
    let gesture = render::gesture(&playing, &scene)?;
    let bar = (!args.json).then(|| term::progress(u64::from(args.renders)));
    let mut ask = FitOptions {
        vary: &args.vary,
        ranges: &ranges,
        seconds: args.seconds,
        gain: args.gain,
        renders: args.renders,
        gesture: gesture.as_ref(),
        words: &Words::COMMAND,
        progress: &mut |done, _| {
            if let Some(bar) = &bar {
                bar.set_position(u64::from(done));
            }
            !render::stopped()
        },
    };
    let found = fit(&loaded, &recording, &mut ask);
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    let found = found?;
    let target = args.to.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    if args.json {
        writeln!(std::io::stdout().lock(), "{:#}", value(&loaded, &target, &found))?;
    } else {
        print(&loaded, &target, &found)?;
    }
    found.warnings().iter().for_each(|what| term::warning(what));
    let good = found.is_nearer() && found.explained && !found.is_elsewhere();
    if writes && !good {
        term::warning("nothing is written");
    } else if writes {
        let text = write::text(&loaded.model, &found)?;
        if args.to_file.in_place {
            ca_io::atomic_file::write(Path::new(&args.model), text.as_bytes())?;
        } else if let Some(path) = &args.to_file.write {
            super::new::write(path, &text, args.to_file.force)?;
        }
        if let Some(path) = args.to_file.write.as_deref().or(args.to_file.in_place.then_some(Path::new(&args.model))) {
            term::note(&format!("written to `{}`", path.display()));
        }
    }
    if let Some(path) = &args.report {
        page::write(path, &report(&found, &loaded.name, &target).html())?;
        term::note(&format!("page written to `{}`", path.display()));
    }
    Ok(if good { Ended::Well } else { Ended::Degraded })
}

/// Parses a range such as `low.f=80 Hz..160 Hz`.
fn range((name, text): &(String, String)) -> Result<Range, Failure> {
    let Some((from, to)) = text.split_once("..") else {
        let what = format!("--range: `{name}={text}` has only one end");
        return Err(Failure::Usage(format!("{what}; write it e.g. as `low.f=80..160`")));
    };
    Ok(Range { name: name.clone(), ends: [Value::typed(from), Value::typed(to)] })
}

fn print(loaded: &Loaded, target: &str, found: &Fit) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}, fitted to {:.3} s of {target} in {} renders", loaded.name, found.seconds, found.renders)?;
    for f in &found.fitted {
        let v = &f.varied;
        writeln!(out, "  {}: {} → {} {}", v.name, v.shown(v.start), v.shown(f.value), f.uncertainty())?;
    }
    let line = |d: &Distance| format!("levels off by {:.2} dB, residual of the samples {:.1} dB", d.levels, d.samples);
    writeln!(out, "  before: {}", line(&found.before))?;
    writeln!(out, "  after:  {}", line(&found.after))?;
    let ms = Plain(six(1e3 * found.delay));
    let by = match found.stage {
        Stage::Samples => format!("samples, over {:.3} s", found.phase),
        Stage::Levels => "levels; phases do not agree".into(),
    };
    writeln!(out, "  gain {}, delay {ms} ms; last fitted to {by}", Plain(six(found.gain)))?;
    if let Some(b) = &found.beyond {
        writeln!(out, "  in the {:.3} s after the fitted part:", b.seconds)?;
        writeln!(out, "    the model: {}", line(&b.model))?;
        writeln!(out, "    {} with as many numbers: {}", b.named(), line(&b.sinusoids))?;
    }
    Ok(())
}

fn value(loaded: &Loaded, target: &str, found: &Fit) -> Json {
    let distance = |d: &Distance| json!({ "levels_db": d.levels, "samples_db": d.samples });
    let numbers: Vec<Json> = found
        .fitted
        .iter()
        .map(|f| {
            json!({ "name": f.varied.name, "unit": f.varied.unit, "start": f.varied.start, "value": f.value,
                "deviation": f.deviation, "at_end": f.at_end })
        })
        .collect();
    let beyond = |b: &Prediction| {
        json!({ "seconds": b.seconds, "model": distance(&b.model), "sinusoids": distance(&b.sinusoids),
            "count": b.count })
    };
    json!({
        "name": loaded.name, "target": target, "renders": found.renders, "seconds": found.seconds,
        "parameters": numbers, "gain": found.gain, "delay_s": found.delay,
        "settled": found.halt == StopReason::Settled, "explained": found.explained && !found.is_elsewhere(), "nearer": found.is_nearer(),
        "pitch": { "recording_hz": found.pitch.recording, "start_hz": found.pitch.start, "found_hz": found.pitch.found,
            "far": found.pitch.starts_far(), "elsewhere": found.is_elsewhere() },
        "stage": if found.stage == Stage::Samples { "samples" } else { "levels" }, "phase_s": found.phase,
        "before": distance(&found.before), "after": distance(&found.after),
        "beyond": found.beyond.as_ref().map(beyond),
    })
}
