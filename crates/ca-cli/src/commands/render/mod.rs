//! `ca render`: a model into a WAV file.
//!
//! Decides that everything that can be refused is refused before the first tick, so that a long render never ends in a
//! spelling mistake; and that sound which is not what the model meant (cut off, diverged) is still written, finite, and after a
//! divergence within full scale, but never called a success.

mod play;
mod summary;

pub(crate) use play::{listen, play, stopped};
pub(crate) use summary::{
    Divergence, decibel, deepening, fitting, grows, joule, level, makers, relative, rippling, stability,
    stability_json, tenths, too_loud,
};

use crate::args::{Kernel, Playing, RenderArgs, SampleFormat};
use crate::commands::border;
use crate::load::{self, Loaded};
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_compile::{KernelClass, Options};
use ca_core::scene::{Halves, Location};
use ca_core::{Scene, State};
use ca_io::ending::{Ending, RenderOut};
use ca_io::files::Files;
use ca_io::gesture::Gesture;
use ca_io::perform::Performance;
use ca_io::probe::ProbeOut;
use ca_io::sound::Format;
use ca_lab::catalog;
use ca_lab::gesture;
use std::path::{Path, PathBuf};

/// Data of a WAV file \[bytes\].
const MOST: u64 = u32::MAX as u64 - 100;

/// A probe as asked.
pub(crate) struct Probe {
    /// selector
    pub name: String,
    /// where to
    pub file: PathBuf,
}

/// Runs the command.
pub fn run(args: &RenderArgs) -> Outcome {
    // before there is a file that would be left behind
    listen();
    let loaded = load::load(&args.source)?;
    let output = output(args, &loaded)?;
    let probes = probes(args, &output)?;
    let options = Options {
        rate: args.source.rate,
        energy: args.energy,
        // with its probes, which keep what they hear
        audited: !args.energy,
        probes: probes.iter().map(|p| p.name.clone()).collect(),
        kernel: if args.kernel == Kernel::Fast { KernelClass::Fast } else { KernelClass::Reference },
        clouds: loaded.clouds.clone(),
        exact: false,
        bounds_only: false,
        whole: false,
    };
    let mut scene = load::scene(&loaded, &options)?;
    let second = scene.audited.take();
    if scene.channels == 0 {
        let what = format!("`{}` has no output, so there is nothing to write", loaded.name);
        return Err(Failure::Failed(format!("{what}; add e.g. `[SOX]` with `out = {{ from = \"…\" }}`")));
    }
    border::idle(&args.source, &scene);
    let gesture = gesture(&args.playing, &scene, &output)?;
    let performance = Performance::new(&scene, gesture.as_ref())?;
    let (seconds, frames) = length(&args.playing, &scene, &performance);
    let format = match args.format {
        SampleFormat::F32 => Format::F32,
        SampleFormat::I24 => Format::I24,
        SampleFormat::I16 => Format::I16,
    };

    if frames.saturating_mul(scene.channels as u64 * u64::from(format.bits() / 8)) > MOST {
        let what = format!("{seconds} s of {} channels are more than the 4 GiB a WAV file holds", scene.channels);
        return Err(Failure::Usage(format!("{what}; render less with `--seconds`, or `--format 16`")));
    }
    let halves = if args.threads > 1 { Some(halves(&loaded, &options, &scene)?) } else { None };
    let ending = Ending { format, ceiling: args.ceiling, fade: !args.no_fade, normalize: args.normalize };
    let wav = RenderOut::create(&output, scene.rate, scene.channels, ending)?;
    let outs = open_probes(&probes, &scene)?;
    let show = !args.quiet && !args.json;
    let mut files = Files::new(wav, outs, scene.channels, scene.rate);
    let played = match &halves {
        Some(h) => {
            play::play_halves(performance, h, gesture.as_ref(), frames, show, &mut |rows| Ok(files.write(rows)?))?
        }
        None => play(performance, frames, play::BLOCK, show, &mut |_, rows| Ok(files.write(rows)?))?,
    };
    let (ended, slow) = files.finish(played.diverged_at.is_some())?;
    let audited: &Scene = second.as_deref().unwrap_or(&scene);
    let energy = match &played.energy {
        Some(ledger) => {
            let diverged = played.diverged_at.is_some();
            Some(play::Audit { ledger: ledger.clone(), ticks: played.energy_ticks, whole: true, diverged })
        }
        None => play::audit(audited, gesture.as_ref(), frames),
    };
    let divergence = Divergence::of(&played, audited, &scene.findings, gesture.as_ref());
    let summary = summary::Summary {
        args,
        scene: &scene,
        audited,
        written: &ended.written,
        ended: &ended,
        slow: slow.found().collect(),
        furthest: furthest(&scene, &played.performance.state),
        wall: played.wall,
        energy: energy.as_ref(),
        divergence: divergence.as_ref(),
        refused: played.performance.state.refused,
        warnings: load::warnings(&scene.findings),
        probes: &probes,
        halves: halves.as_ref(),
    };
    summary.warn();
    if args.quiet {
        crate::load::warn(&loaded, &scene);
    }
    for what in ca_lab::play::clamped(&played.performance) {
        term::warning(&what);
    }
    if args.json {
        summary.json()?;
    } else if !args.quiet {
        summary.text()?;
    }
    Ok(if summary.degraded() { Ended::Degraded } else { Ended::Well })
}

/// The scene in two, for two threads.
fn halves(loaded: &Loaded, options: &Options, scene: &Scene) -> Result<Halves, Failure> {
    let cut = ca_compile::halves(&loaded.model, &catalog(), options, scene);
    cut.map_err(|why| Failure::Usage(format!("--threads 2: `{}` is not cut in two, since {why}", loaded.name)))
}

/// Where the sound goes.
fn output(args: &RenderArgs, loaded: &Loaded) -> Result<PathBuf, Failure> {
    let Some(path) = args.output.clone() else { return Ok(PathBuf::from(format!("{}.wav", loaded.name))) };
    load::check_wav_path(&path)?;
    Ok(path)
}

/// Whether two names mean the same file, as far as that exists.
fn same(a: &Path, b: &Path) -> bool {
    a == b || a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b))
}

fn probes(args: &RenderArgs, output: &Path) -> Result<Vec<Probe>, Failure> {
    let mut list: Vec<Probe> = Vec::new();
    for text in &args.probe {
        let (name, file) = text.split_once('=').map_or((text.as_str(), None), |(n, f)| (n, Some(f)));
        let (name, file) = (name.trim(), file.map(str::trim));
        if name.is_empty() || file == Some("") {
            return Err(Failure::Usage(format!("--probe: `{text}`; write it like `low[3]` or `low[3]=bridge.csv`")));
        }
        // `*` is not for files
        let default = || output.with_file_name(format!("{}.npy", name.replace('*', "all")));
        let file = file.map_or_else(default, PathBuf::from);
        if list.iter().any(|p| p.name == name) {
            return Err(Failure::Usage(format!("--probe: `{name}` is asked for twice")));
        }
        if list.iter().any(|p| same(&p.file, &file)) || same(output, &file) {
            return Err(Failure::Usage(format!("--probe: `{}` would be written twice", file.display())));
        }
        list.push(Probe { name: name.into(), file });
    }
    Ok(list)
}

/// Opens the files of all probes, each with its columns.
fn open_probes(probes: &[Probe], scene: &Scene) -> Result<Vec<(ProbeOut, usize)>, Failure> {
    let mut outs = Vec::new();
    for (i, p) in probes.iter().enumerate() {
        let columns = scene.probe_names.iter().zip(&scene.probe_of);
        let own: Vec<&str> = columns.filter(|(_, of)| **of as usize == i).map(|(n, _)| n.as_str()).collect();
        if own.is_empty() {
            let what = format!("--probe: `{}` does nothing, so it was left out", p.name);
            return Err(Failure::Usage(format!("{what}; probe the modules at its ends")));
        }
        outs.push((ProbeOut::create(&p.file, &own, scene.rate)?, own.len()));
    }
    Ok(outs)
}

/// All gesture files as one gesture; none of them is `output`.
pub(crate) fn gesture(args: &Playing, scene: &Scene, output: &Path) -> Result<Option<Gesture>, Failure> {
    for text in &args.gesture {
        let file = gesture::port_and_file(text, Path::new("")).1;
        if same(file, output) {
            let what = format!("`{}` is the gesture and would be overwritten", file.display());
            return Err(Failure::Usage(format!("{what}; choose another file with `-o`")));
        }
    }
    Ok(gesture::open(&args.gesture, args.gesture_rate, scene, Path::new(""), &mut |what| term::note(what))?)
}

/// How long it is played \[s\], and in ticks.
pub(crate) fn length(args: &Playing, scene: &Scene, p: &Performance) -> (f64, u64) {
    let gesture = p.duration();
    let seconds = ca_lab::play::seconds(p, args.seconds);
    if args.seconds.is_none() && !args.gesture.is_empty() && gesture > seconds {
        term::note(&format!(
            "the gesture lasts {gesture:.3} s, the model asks for {seconds} s; use `--seconds` to hear all of it"
        ));
    }
    (seconds, ca_lab::play::frames(scene, seconds))
}

/// The body that is furthest from its rest, ports and fixed points aside.
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
