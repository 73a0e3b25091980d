//! A model on a page: played, and everything about it.

use super::parts::{self, Facts, finished};
use super::played::EnergyOverTime;
use crate::args::ReportArgs;
use crate::commands::render::{self, Divergence};
use crate::load::{self, Loaded};
use crate::outcome::Failure;
use crate::term::{self, short};
use ca_compile::Options;
use ca_core::Scene;
use ca_io::perform::Performance;
use ca_lab::accuracy::{self, AccuracyOptions};
use ca_lab::play::lasted;
use ca_model::{Item, Value};
use ca_report::{Axis, Block, Curve, Envelope, Plot, Report, Section, Sound, Weight};
use ca_view::Film;
use std::path::Path;

/// Most curves of one plot.
const CURVES: usize = 8;
/// Times the ledger is looked at.
const LOOKS: u64 = 1000;
/// A state is looked at so often a second for the picture \[Hz\].
const PICTURE: f64 = 240.0;
/// What is tried for error against run time: its length \[s\], multiples of the rate, and that of the reference.
const TRIED: f64 = 0.2;
const TIMES: [u32; 3] = [1, 2, 4];
const REFERENCE: u32 = 32;

/// Plays the model and tells all of it.
pub(super) fn report(args: &ReportArgs) -> Result<(String, Report), Failure> {
    render::listen();
    let loaded = load::load(&args.source)?;
    // the ledger is of the explicit scheme
    let composed = matches!(loaded.model.meta("method").map(|e| &e.value), Some(Value::Text(t)) if t == "pefrl");
    let with = |probes: Vec<String>| Options {
        rate: args.source.rate,
        energy: !composed,
        probes,
        clouds: loaded.clouds.clone(),
        ..Options::default()
    };
    // what nobody asked for is no reason to fail
    let own = (args.probe.is_empty()).then(|| load::scene(&loaded, &with(heard(&loaded.model.items))).ok()).flatten();
    let (scene, probes) = match own {
        Some(scene) => (scene, heard(&loaded.model.items)),
        None => (load::scene(&loaded, &with(args.probe.clone()))?, args.probe.clone()),
    };
    load::warn(&loaded, &scene);
    crate::commands::border::idle(&args.source, &scene);
    let gesture = render::gesture(&args.playing, &scene)?;
    let performance = Performance::new(&scene, gesture.as_ref())?;
    let (seconds, length) = render::length(&args.playing, &performance);
    let frames = length.frames;

    let mut sound = Sound::new(scene.rate, &scene.names.channel_names);
    let mut motion = Envelope::new(scene.rate, scene.counts.n_out - scene.counts.channels);
    let mut ledger = EnergyOverTime::default();
    let mut film = Film::new(&scene, seconds);
    // often enough for a picture that does not jerk
    let block = (frames / LOOKS).clamp(1, (scene.rate / PICTURE).max(1.0) as u64).min(1024);
    let played = render::play(performance, length, block, !args.quiet, &mut |p, rows| {
        for row in rows.chunks_exact(scene.counts.n_out.max(1)) {
            sound.push(&row[..scene.counts.channels]);
            motion.push(&row[scene.counts.channels..]);
        }
        film.look(p.state.tick as f64 * scene.rates.sample_dt, &p.state.x);
        if !p.diverged && p.state.is_bounded(ca_io::perform::DIVERGED) {
            ledger.look(p.state.tick as f64 * scene.rates.sample_dt, p.state.ledger.as_deref());
        }
        Ok(())
    })?;
    ledger.end = played.energy.clone();

    let divergence = Divergence::of(&played, &scene, &scene.findings, gesture.as_ref());
    ledger.diverged_at = divergence.as_ref().map(|b| b.time);
    let title = if scene.about.title.is_empty() { &loaded.name } else { &scene.about.title };
    let mut report = Report::new(title, &format!("`{}`, {}", source_name(&loaded), finished()));
    report.picture = ca_lab::view::picture(&film)?;
    report.notes = parts::notes(&sound, divergence.is_some());
    if let Some(divergence) = &divergence {
        report.notes.insert(0, (Weight::Warning, divergence.to_string()));
    }
    let refused = played.performance.state.ports.refused;
    if refused > 0 {
        let what = format!("{refused} inputs had no value; the last good one was held instead");
        report.notes.push((Weight::Warning, what));
    }
    for what in ca_lab::play::clamped(&played.performance) {
        term::warning(&what);
    }
    let mut facts = Facts::of(&scene);
    facts.add("length", format!("{} s", lasted(&scene, &played, frames, seconds)));
    let factor = played.wall.as_secs_f64() / (played.frames as f64 * scene.rates.sample_dt);
    let ledger_kept = if composed { "" } else { " with the energy ledger" };
    facts.add("real-time factor", format!("{}{ledger_kept}, on this machine", short(factor)));
    for (name, value) in args.source.changes() {
        facts.add("changed", format!("{name} = {value}"));
    }
    report.sections.push(facts.section());
    let modes = parts::modes(&loaded.model, &with(Vec::new()));
    report.sections.extend(parts::sound(sound, modes.marks(), divergence.is_some()));
    report.sections.extend(moved(&loaded, &scene, &motion, &probes));
    report.sections.extend(ledger.section(&scene, 1.0));
    report.sections.push(modes.section());
    report.sections.extend(accuracy(args, &loaded)?);
    report.sections.push(parts::stability(&scene));
    let text = vec![Block::Source(loaded.model.file.clone(), loaded.model.text.clone())];
    report.sections.push(Section::new("Model", text));
    Ok((loaded.name, report))
}

/// Error against run time of the model's beginning, by its own gestures; of what cannot be measured, why.
fn accuracy(args: &ReportArgs, loaded: &Loaded) -> Result<Option<Section>, Failure> {
    let seconds = args.accuracy.unwrap_or(TRIED);
    let probes = accuracy::heard(&loaded.model);
    if seconds == 0.0 || probes.is_empty() {
        return Ok(None);
    }
    let mut bar = None;
    let progress = &mut |done, of| {
        if !args.quiet {
            bar.get_or_insert_with(|| term::progress(of)).set_position(done);
        }
        !render::stopped()
    };
    let mut ask = AccuracyOptions {
        rate: args.source.rate,
        probes: &probes,
        seconds: Some(seconds),
        times: &TIMES,
        reference: REFERENCE,
        remedy: "play longer with `--accuracy`, or listen elsewhere with `--probe`",
        progress,
    };
    let found = accuracy::measured(loaded, &mut ask);
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    match found.map_err(Failure::from) {
        Ok(found) => Ok(Some(found.section())),
        Err(Failure::Failed(why) | Failure::Usage(why)) => {
            Ok(Some(Section::new(accuracy::TITLE, vec![Block::Text(why)])))
        }
        Err(other) => Err(other),
    }
}

/// The file without folders.
fn source_name(loaded: &Loaded) -> String {
    Path::new(&loaded.model.file).file_name().map_or_else(|| loaded.name.clone(), |n| n.to_string_lossy().into_owned())
}

/// What the outputs hear, by their names, and the keys of devices.
fn heard(items: &[Item]) -> Vec<String> {
    let shown = items.iter().filter(|i| matches!(i.kind.as_str(), "SOX" | "SOF" | "TGR"));
    shown.map(|i| i.name.clone()).take(CURVES).collect()
}

/// What an output hears, in the words of the model.
fn of_output<'a>(items: &'a [Item], probe: &str) -> Option<&'a str> {
    let from = items.iter().find(|i| i.name == probe)?.args.iter().find(|e| e.key == "from")?;
    if let Value::Text(text) = &from.value { Some(text) } else { None }
}

/// What is drawn, each on an axis of its own: title, quantity and unit.
const DRAWN: [(&str, &str, &str); 4] = [
    ("Displacement", "displacement", "m"),
    ("Speed", "speed", "m/s"),
    ("Acceleration", "acceleration", "m/s²"),
    ("Force", "force", "N"),
];

/// Which of these a probe is: of an output what it hears.
fn drawn(items: &[Item], scene: &Scene, name: &str) -> usize {
    let is_link = |s: &ca_core::Symbol| s.name == name && matches!(s.location, ca_core::Location::Lia(..));
    let item = items.iter().find(|i| i.name == name);
    let hears = item.and_then(|i| i.args.iter().find(|e| e.key == "hear")).map(|e| &e.value);
    match hears {
        Some(Value::Text(text)) if text == "speed" => 1,
        Some(Value::Text(text)) if text == "acceleration" => 2,
        Some(Value::Text(text)) if text == "force" => 3,
        _ if item.is_some_and(|i| i.kind == "SOF") || scene.symbols.iter().any(|s| is_link(&s)) => 3,
        _ => 0,
    }
}

/// Motions and forces over time.
fn moved(loaded: &Loaded, scene: &Scene, motion: &Envelope, probes: &[String]) -> Option<Section> {
    let items = &loaded.model.items;
    let mut all: [Vec<Curve>; DRAWN.len()] = Default::default();
    for (k, (name, of)) in scene.names.probe_names.iter().zip(&scene.names.probe_of).enumerate() {
        let asked = probes.get(*of as usize).map_or("", String::as_str);
        // of an output that hears several, each by its own name
        let shown = of_output(items, asked).filter(|_| name == asked).unwrap_or(name);
        let list = &mut all[drawn(items, scene, name).max(drawn(items, scene, asked))];
        if list.iter().all(|c| c.name != shown) {
            list.push(Curve::line(shown, motion.curve(k)));
        }
    }
    let mut blocks = Vec::new();
    for ((title, quantity, unit), curves) in DRAWN.into_iter().zip(all) {
        let more = curves.len().saturating_sub(CURVES);
        let curves: Vec<Curve> = curves.into_iter().take(CURVES).collect();
        if !curves.is_empty() {
            blocks.push(Block::Plot(Plot::over_time(title, Axis::linear(quantity, unit), motion.grid(), curves)));
        }
        if more > 0 {
            blocks.push(Block::Text(format!("{more} more are not drawn; `ca render --probe` writes all of them.")));
        }
    }
    (!blocks.is_empty()).then(|| Section::new("Motion", blocks))
}
