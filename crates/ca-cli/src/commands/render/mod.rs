//! `ca render`: renders a model to a WAV or FLAC file, or to a pipe.
//!
//! All arguments are checked before the first tick, so that a long render cannot fail because of a typing error.
//! Clipped or diverged sound is still written with finite samples, within full scale after a divergence. But the
//! command then does not report success.

mod args;
mod play;
mod summary;

pub use args::{Kernel, RenderArgs, SampleFormat};

pub(crate) use play::{Progress, listen, play, stopped};
pub(crate) use summary::stability_json;

use crate::args::Playing;
use crate::commands::border;
use crate::load::{self, Loaded};
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, term};
use ca_compile::{KernelClass, Options};
use ca_core::{Location, Scene, State};
use ca_io::atomic_file::is_stdout;
use ca_io::files::Files;
use ca_io::format::Format;
use ca_io::gesture::Gesture;
use ca_io::level_and_fade::{Ending, RenderOut};
use ca_io::perform::Performance;
use ca_io::probe::ProbeOut;
use ca_lab::play::{Divergence, Length};
use ca_take::gesture;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

/// A requested probe.
pub(crate) struct Probe {
    /// Selector.
    pub name: String,
    /// Output file.
    pub file: PathBuf,
}

/// Returns names and gains of the outputs, or none if a gain is not a plain number.
fn gains(model: &ca_model::Model) -> Vec<(&str, f64)> {
    let outputs = model.items.iter().filter(|i| matches!(i.kind.as_str(), "SOX" | "SOF"));
    let gain = |i: &ca_model::Item| i.args.iter().find(|e| e.key == "gain").map_or(Some(1.0), |e| e.value.number());
    outputs.map(|i| Some((i.name.as_str(), gain(i)?))).collect::<Option<Vec<_>>>().unwrap_or_default()
}

/// Runs the command.
pub fn run(args: &RenderArgs) -> Outcome {
    let mut loaded = load::load(&args.source)?;
    let output = output(args, &loaded)?;
    let probes = probes(args, &output)?;
    let written = [("-o", &*output)].into_iter().chain(probes.iter().map(|p| ("--probe", &*p.file)));
    let written: Vec<_> = written.chain(args.error_target.files()).collect();
    outputs::check_distinct(&written, &inputs(&args.source.model, &args.playing.gesture))?;
    for (name, value) in args.error_target.changes(&loaded, args.source.rate, args.quiet || args.json)? {
        ca_lab::load::set_typed(&mut loaded, &name, &value)?;
    }
    let options = Options {
        rate: args.source.rate,
        energy: args.energy,
        // includes the probes, which keep the modules they measure
        audited: !args.energy,
        probes: probes.iter().map(|p| p.name.clone()).collect(),
        kernel: if args.kernel == Kernel::Fast { KernelClass::Fast } else { KernelClass::Reference },
        clouds: loaded.clouds.clone(),
        exact: false,
        bounds_only: false,
        whole: false,
        precision: ca_core::Precision::Double,
        arithmetic: None,
        couplings: Vec::new(),
    };
    let mut scene = load::scene(&loaded, &options)?;
    let second = scene.audited.take();
    if scene.counts.channels == 0 {
        let what = format!("`{}` has no output, so there is nothing to write", loaded.name);
        return Err(Failure::Failed(format!("{what}; add e.g. `[SOX]` with `out = {{ from = \"…\" }}`")));
    }
    border::idle(&args.source, &scene);
    let gesture = gesture(&args.playing, &scene)?;
    let performance = Performance::new(&scene, gesture.as_ref())?;
    let (seconds, length) = length(&args.playing, &performance);
    let (format, flac) = format(args, &output)?;
    if args.threads > 1 {
        term::note("`--threads` has no effect: one thread plays a scene");
    }
    let ending = Ending { format, flac, ceiling: args.ceiling, fade: !args.no_fade, normalize: args.normalize };
    // set before files are created, and before opening a pipe, which may wait forever for its reader
    listen();
    let wav = RenderOut::create(&output, scene.rate, scene.counts.channels, ending)?;
    let outs = open_probes(&probes, &scene)?;
    let show = !args.quiet && !args.json;
    let mut files = Files::new(wav, outs, scene.counts.channels, scene.rate);
    let mut done = 0;
    let mut heard = |rows: &[f64]| -> Result<(), Failure> {
        done += rows.len() / scene.counts.n_out.max(1);
        Ok(files.write(rows)?)
    };
    let played = play(performance, length, play::BLOCK, show, &mut |_, rows| heard(rows));
    let played = played.map_err(|e| match e {
        Failure::Interrupted(_) => Failure::Interrupted(interrupted(&output, done as f64 / scene.rate, seconds)),
        other => other,
    })?;
    let (ended, slow) = files.finish(played.diverged_at.is_some())?;
    let audited: &Scene = second.as_deref().unwrap_or(&scene);
    let energy = match &played.energy {
        Some(ledger) => {
            let diverged = played.diverged_at.is_some();
            Some(play::Audit { ledger: ledger.clone(), ticks: played.energy_ticks, complete: true, diverged })
        }
        None => play::audit(audited, gesture.as_ref(), played.frames),
    };
    let divergence = Divergence::of(&played, audited, &scene.findings, gesture.as_ref());
    let summary = summary::Summary {
        args,
        scene: &scene,
        audited,
        written: &ended.written,
        gains: gains(&loaded.model),
        format: match (format, flac) {
            (Format::F32, _) => "32-bit float",
            (Format::I24, false) => "24-bit",
            (Format::I16, false) => "16-bit",
            (Format::I24, true) => "24-bit FLAC",
            (Format::I16, true) => "16-bit FLAC",
        },
        ended: &ended,
        slow: slow.found().collect(),
        furthest: furthest(&scene, &played.performance.state),
        wall: played.wall,
        energy: energy.as_ref(),
        divergence: divergence.as_ref(),
        refused: played.performance.state.ports.refused,
        unsolved: played.performance.state.links.touches.unsolved,
        warnings: load::warnings(&scene.findings),
        probes: &probes,
    };
    summary.warn();
    if args.quiet {
        crate::load::warn(&loaded, &scene);
    }
    for what in ca_lab::play::clamped(&played.performance) {
        term::warning(&what);
    }
    // if the sound goes to standard output, the summary goes to standard error
    let mut out: Box<dyn std::io::Write> =
        if is_stdout(&output) { Box::new(std::io::stderr().lock()) } else { Box::new(std::io::stdout().lock()) };
    if args.json {
        summary.json(&mut out)?;
    } else if !args.quiet {
        summary.text(&mut out)?;
    }
    Ok(if summary.degraded() { Ended::Degraded } else { Ended::Well })
}

fn output(args: &RenderArgs, loaded: &Loaded) -> Result<PathBuf, Failure> {
    let Some(path) = args.output.clone() else {
        let flac = args.format.is_some_and(SampleFormat::is_flac);
        return Ok(PathBuf::from(format!("{}.{}", loaded.name, if flac { "flac" } else { "wav" })));
    };
    if is_stdout(&path) {
        if std::io::stdout().is_terminal() {
            let what = format!("`{}`: standard output is a terminal, which cannot play sound", path.display());
            return Err(Failure::Usage(format!(
                "{what}; send it to a program or a file, as in `ca render … -o - | aplay`"
            )));
        }
        return Ok(path);
    }
    // pipes and devices do not need an extension
    let plain = !path.exists() || path.is_file();
    if plain && !["wav", "flac"].iter().any(|e| load::has_extension(&path, e)) {
        let what = format!("`{}`: sound is written as WAV or FLAC", path.display());
        return Err(Failure::Usage(format!("{what}; give the file the extension `.wav` or `.flac`")));
    }
    Ok(path)
}

/// Returns the sample format, and true for FLAC. `--format` has priority over the file name.
fn format(args: &RenderArgs, output: &Path) -> Result<(Format, bool), Failure> {
    let named = load::has_extension(output, "flac");
    let flac = named || args.format.is_some_and(SampleFormat::is_flac);
    if flac && load::has_extension(output, "wav") {
        let what = format!("`{}`: the extension is `.wav`, but `--format` is FLAC", output.display());
        return Err(Failure::Usage(format!("{what}; use the extension `.flac`, or choose `--format 24`")));
    }
    match args.format {
        Some(SampleFormat::F32) if flac => {
            let what = format!("`{}`: FLAC cannot store floats", output.display());
            Err(Failure::Usage(format!("{what}; choose `--format 24` or `--format 16`, or use the extension `.wav`")))
        }
        None if flac => Ok((Format::I24, flac)),
        None | Some(SampleFormat::F32) => Ok((Format::F32, flac)),
        Some(SampleFormat::I24 | SampleFormat::Flac) => Ok((Format::I24, flac)),
        Some(SampleFormat::I16 | SampleFormat::Flac16) => Ok((Format::I16, flac)),
    }
}

/// Formats the message after Ctrl-C ended a render at `done` of `seconds`.
fn interrupted(output: &Path, done: f64, seconds: f64) -> String {
    let kept = if output.is_file() {
        format!("`{}` is unchanged", output.display())
    } else {
        format!("`{}` was not written", output.display())
    };
    format!("interrupted after {done:.2} s of {seconds} s: none of it is kept, {kept}")
}

fn probes(args: &RenderArgs, output: &Path) -> Result<Vec<Probe>, Failure> {
    let mut list: Vec<Probe> = Vec::new();
    for text in &args.probe {
        let (name, file) = text.split_once('=').map_or((text.as_str(), None), |(n, f)| (n, Some(f)));
        let (name, file) = (name.trim(), file.map(str::trim));
        if name.is_empty() || file == Some("") {
            return Err(Failure::Usage(format!(
                "--probe: `{text}` is not a name; write it e.g. as `low[3]` or `low[3]=bridge.csv`"
            )));
        }
        // `*` is avoided in file names
        let default = || output.with_file_name(format!("{}.npy", name.replace('*', "all")));
        let file = file.map_or_else(default, PathBuf::from);
        if list.iter().any(|p| p.name == name) {
            return Err(Failure::Usage(format!("--probe: `{name}` is given twice; leave out one")));
        }
        list.push(Probe { name: name.into(), file });
    }
    Ok(list)
}

/// Opens the files of all probes, each with its number of columns.
fn open_probes(probes: &[Probe], scene: &Scene) -> Result<Vec<(ProbeOut, usize)>, Failure> {
    let mut outs = Vec::new();
    for (i, p) in probes.iter().enumerate() {
        let columns = scene.names.probe_names.iter().zip(&scene.names.probe_of);
        let own: Vec<&str> = columns.filter(|(_, of)| **of as usize == i).map(|(n, _)| n.as_str()).collect();
        if own.is_empty() {
            let what = format!("--probe: `{}` has no effect, so it was left out of the scene", p.name);
            return Err(Failure::Usage(format!("{what}; probe the modules at its ends")));
        }
        outs.push((ProbeOut::create(&p.file, &own, scene.rate)?, own.len()));
    }
    Ok(outs)
}

/// Lists the input files: the model and its gestures.
pub(crate) fn inputs<'a>(model: &'a str, gestures: &'a [String]) -> Vec<(&'static str, &'a Path)> {
    let gestures = gestures.iter().map(|text| ("the gesture", gesture::port_and_file(text, Path::new("")).1));
    [("the model", Path::new(model))].into_iter().chain(gestures).collect()
}

pub(crate) fn gesture(args: &Playing, scene: &Scene) -> Result<Option<Gesture>, Failure> {
    Ok(gesture::open(&args.gesture, args.gesture_rate, scene, Path::new(""), &mut |what| term::note(what))?)
}

/// Returns the longest time to play \[s\], and the length in samples.
pub(crate) fn length(args: &Playing, p: &Performance) -> (f64, Length) {
    let gesture = p.duration();
    let seconds = ca_lab::play::seconds(p, args.seconds);
    if args.seconds.is_none() && !args.gesture.is_empty() && gesture > seconds {
        term::note(&format!(
            "the gesture lasts {gesture:.3} s, but `seconds` of the model is {seconds} s; use `--seconds` to hear all of it"
        ));
    }
    (seconds, Length::of(p, args.seconds))
}

/// Returns the name of the mass with the largest displacement from rest, except ports and fixed points.
fn furthest(scene: &Scene, state: &State) -> String {
    let mut most = (0.0, String::new());
    for s in scene.symbols.iter() {
        let (Location::Mat(at), false) = (s.location, matches!(s.code, "ENX" | "TGR" | "SOL")) else { continue };
        let far =
            (0..s.axes as usize).filter_map(|k| state.x.get(at as usize + k)).fold(0.0_f64, |m, x| m.max(x.abs()));
        if far > most.0 {
            most = (far, s.name.to_string());
        }
    }
    most.1
}
