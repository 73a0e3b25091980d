//! Plays one scene many times, each time with other values.
//!
//! A run is a function of the scene, the seed and the index of the run (`axis.rs`). So any worker can compute any run,
//! in any order and repeatedly, with the same result. A failed run is a row like any other, with a status and a
//! message.
#![forbid(unsafe_code)]

mod audio;
mod axis;
pub mod batch;
pub mod folder;
mod measure;
pub mod plan;
mod table;

pub use audio::Audio;
pub use axis::{Axis, Space};
pub use table::{Column, RunTable};

use ca_compile::Options;
use ca_io::gesture::Gesture;
use ca_io::perform::Performance;
use ca_io::sound::Level;
use ca_lab::load::{self, Loaded};
use ca_lab::outcome::Outcome;
use ca_lab::play::{self, BLOCK, Length};
use ca_lab::{Failure, bytes};
use ca_model::Value;

/// Maximum number of runs.
const MOST: u64 = 1 << 40;

/// Columns that differ each time: run time, and run time over duration.
pub const TIMES: [&str; 2] = ["run_time", "rtf"];
/// Other column names that an axis does not get.
const OWN: [&str; 13] = [
    "index", "status", "message", "failed", "module", "frames", "peak", "rms", "partial", "t60", "residual", "seed",
    "scene",
];

/// Returns the column of an axis: its name, with the prefix `param.` if another column has that name.
pub fn column(axis: &Axis) -> String {
    // the last list holds names that data sets add to the columns
    let taken = OWN.iter().chain(&TIMES).chain(&["file", "audio", "done", "run"]).any(|n| *n == axis.name);
    if taken { format!("param.{}", axis.name) } else { axis.name.clone() }
}

/// Specification of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepSpec {
    /// Axes along which values vary.
    pub axes: Vec<Axis>,
    /// Number of random runs; if `None`, every combination of values is played, the last axis varying fastest.
    pub runs: Option<u64>,
    /// Seed of the random values.
    pub seed: u64,
    /// Duration of a run \[s\]; as its model if `None`.
    pub seconds: Option<f64>,
    /// Sound rate \[Hz\]; as the model if `None`.
    pub rate: Option<f64>,
    /// True to compute the energy ledger.
    pub energy: bool,
    /// True to measure pitch and decay.
    pub measure: bool,
}

/// Sweep that is ready to play any of its runs.
pub struct Sweep {
    loaded: Loaded,
    ask: SweepSpec,
    gesture: Option<Gesture>,
    hash: blake3::Hash,
    played: Option<String>,
    runs: u64,
    channels: usize,
    rate: f64,
}

/// Result of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunRow {
    /// Index of the run.
    pub index: u64,
    /// Seed of the run.
    pub seed: u64,
    /// Value on each axis.
    pub values: Vec<Value>,
    /// One of `ok`, `clipped`, `unstable`, `refused` (an input lacked a value), `mute` (neither outputs nor probes),
    /// `gained` (the scheme made more energy than it received) and `invalid` (the model does not compile).
    pub status: &'static str,
    /// Description of the failure; empty without one.
    pub message: String,
    /// Time of divergence \[s\].
    pub failed: Option<f64>,
    /// Module that caused the divergence.
    pub module: Option<String>,
    /// Samples per channel.
    pub frames: u64,
    /// Greatest |sample| before the ceiling; 1 is full scale.
    pub peak: f64,
    /// Root mean square of all samples.
    pub rms: f64,
    /// Strongest partial \[Hz\].
    pub partial: Option<f64>,
    /// Time in which the sound falls by 60 dB \[s\].
    pub t60: Option<f64>,
    /// Residual of the energy ledger, relative to its peak.
    pub residual: Option<f64>,
    /// Hash of its scene, the same on all machines; empty without a scene.
    pub hash: String,
    /// Run time \[s\].
    pub run_time: f64,
    /// Run time over duration.
    pub rtf: f64,
}

impl Sweep {
    /// Prepares a sweep of a model; values that no axis varies stay as they are.
    ///
    /// # Errors
    /// [`Failure::Usage`] where an axis is invalid; [`Failure::Found`] where the model has errors.
    pub fn new(loaded: Loaded, ask: SweepSpec, gesture: Option<Gesture>) -> Result<Sweep, Failure> {
        for (k, axis) in ask.axes.iter().enumerate() {
            if ask.axes[..k].iter().any(|a| a.name == axis.name) {
                return Err(Failure::Usage(format!("`{}` is varied twice; remove one of them", axis.name)));
            }
            varied(axis)?;
            load::set(&mut loaded.clone(), &axis.name, axis.at(0.0))?;
            for end in axis.ends.iter().flatten() {
                measured_so(&loaded, &axis.name, end)?;
            }
        }
        let runs = match ask.runs {
            Some(n) => Some(n),
            None => ask.axes.iter().try_fold(1u64, |n, a| Ok::<_, Failure>(n.saturating_mul(counted(a)?))).map(Some)?,
        };
        let runs = runs.filter(|n| (1..=MOST).contains(n));
        let runs = runs.ok_or_else(|| Failure::Usage(format!("a sweep must have 1 to {MOST} runs")))?;
        let scene = loaded.compile(&Options { rate: ask.rate, ..Options::default() })?;
        // reports a gesture that does not fit before the first run
        Performance::new(&scene, gesture.as_ref())?;
        let (channels, rate) = (scene.counts.channels, scene.rate);
        let hash = bytes::named(&loaded, rate)?;
        let played = gesture.as_ref().map(|g| blake3::hash(format!("{g:?}").as_bytes()).to_hex().to_string());
        Ok(Sweep { loaded, ask, gesture, hash, played, runs, channels, rate })
    }

    /// Number of runs.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// Number of sound channels of a run.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Sound rate \[Hz\].
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Specification of the sweep.
    pub fn spec(&self) -> &SweepSpec {
        &self.ask
    }

    /// Hash of the scene, the same on all machines.
    pub fn hash(&self) -> String {
        self.hash.to_hex().to_string()
    }

    /// Values of a run, one for each axis.
    pub fn point(&self, index: u64) -> Vec<Value> {
        if self.ask.runs.is_some() {
            let seed = axis::seed(&self.hash, self.ask.seed, index);
            return self.ask.axes.iter().map(|a| a.at(axis::place(seed, &a.name))).collect();
        }
        let mut rest = index;
        let mut values: Vec<Value> = Vec::new();
        for a in self.ask.axes.iter().rev() {
            let n = a.count().unwrap_or(1);
            values.extend(match &a.space {
                Space::List(v) => v.get((rest % n) as usize).cloned(),
                Space::Range { .. } => None,
            });
            rest /= n;
        }
        values.reverse();
        values
    }

    /// Plays a run and returns its row and its interleaved sound. `goes_on` is called now and then.
    ///
    /// # Errors
    /// [`Failure::Stopped`] where `goes_on` returns false.
    pub fn run(&self, index: u64, goes_on: &mut dyn FnMut() -> bool) -> Result<(RunRow, Vec<f32>), Failure> {
        let mut row = RunRow {
            index,
            seed: axis::seed(&self.hash, self.ask.seed, index),
            values: self.point(index),
            status: "invalid",
            message: String::new(),
            failed: None,
            module: None,
            frames: 0,
            peak: 0.0,
            rms: 0.0,
            partial: None,
            t60: None,
            residual: None,
            hash: String::new(),
            run_time: 0.0,
            rtf: 0.0,
        };
        match self.play(&mut row, goes_on) {
            Ok(sound) => Ok((row, sound)),
            Err(Failure::Stopped) => Err(Failure::Stopped),
            Err(e) => {
                row.message = e.line();
                Ok((row, Vec::new()))
            }
        }
    }

    fn play(&self, row: &mut RunRow, goes_on: &mut dyn FnMut() -> bool) -> Result<Vec<f32>, Failure> {
        let mut loaded = self.loaded.clone();
        for (axis, value) in self.ask.axes.iter().zip(&row.values) {
            load::set(&mut loaded, &axis.name, value.clone())?;
        }
        let options = Options { rate: self.ask.rate, energy: self.ask.energy, ..Options::default() };
        let scene = loaded.compile(&options)?;
        row.hash = bytes::named(&loaded, scene.rate)?.to_hex().to_string();
        if (scene.rate, scene.counts.channels) != (self.rate, self.channels) {
            let what = format!("this run has {} channels at {} Hz", scene.counts.channels, scene.rate);
            return Err(Failure::Failed(format!(
                "{what}, but all sounds of a sweep have {} at {} Hz",
                self.channels, self.rate
            )));
        }
        let performance = Performance::new(&scene, self.gesture.as_ref())?;
        let length = Length::of(&performance, self.ask.seconds);
        let frames = length.frames;
        let (channels, n_out) = (scene.counts.channels, scene.counts.n_out);
        let (mut sound, mut level) = (Vec::new(), Level::new(channels));
        let len = usize::try_from(frames).ok().and_then(|n| n.checked_mul(channels));
        if len.is_none_or(|n| sound.try_reserve_exact(n).is_err()) {
            return Err(Failure::Failed(format!("{frames} samples do not fit into memory; play fewer seconds")));
        }
        let played = play::play(performance, length, BLOCK, &mut |_, rows, _| {
            let first = sound.len();
            sound.resize(first + rows.len() / n_out.max(1) * channels, 0.0);
            level.keep_rows(rows, n_out.max(1), &mut sound[first..]);
            if goes_on() { Ok(()) } else { Err(Failure::Stopped) }
        })?;
        row.frames = played.frames;
        row.run_time = played.wall.as_secs_f64();
        row.rtf = row.run_time * scene.rate / played.frames as f64;
        row.peak = level.peak.iter().copied().fold(0.0, f64::max);
        row.rms = measure::rms(&sound);
        // the pitch of a diverged sound means nothing
        if self.ask.measure && channels > 0 && played.diverged_at.is_none() {
            let found = measure::measures(&sound, channels, scene.rate);
            (row.partial, row.t60) = (found.partial, found.t60);
        }
        row.residual = played.energy.as_ref().filter(|_| self.ask.energy).map(|b| play::relative(&b.balance()));
        let Outcome { status, message, failed } =
            Outcome::of(&played, &level, (&scene, &scene.findings), (&loaded, &options), self.gesture.as_ref());
        (row.status, row.message) = (status, message);
        if let Some((time, module)) = failed {
            (row.failed, row.module) = (Some(time), Some(module));
        }
        Ok(sound)
    }

    /// Converts rows to columns.
    pub fn table(&self, rows: &[RunRow]) -> RunTable {
        let mut columns: Vec<(String, Column)> = Vec::new();
        let mut add = |name: &str, column: Column| columns.push((name.into(), column));
        let number = |f: &dyn Fn(&RunRow) -> Option<f64>| Column::Number(rows.iter().map(f).collect());
        let text = |f: &dyn Fn(&RunRow) -> Option<String>| Column::Text(rows.iter().map(f).collect());
        add("index", Column::Whole(rows.iter().map(|r| r.index as i64).collect()));
        for (k, a) in self.ask.axes.iter().enumerate() {
            add(
                &column(a),
                if a.is_numeric() { number(&|r| r.values[k].number()) } else { text(&|r| Some(r.values[k].shown())) },
            );
        }
        add("status", text(&|r| Some(r.status.into())));
        add("message", text(&|r| Some(r.message.clone())));
        add("failed", number(&|r| r.failed));
        add("module", text(&|r| r.module.clone()));
        add("frames", Column::Whole(rows.iter().map(|r| r.frames as i64).collect()));
        add("peak", number(&|r| Some(r.peak)));
        add("rms", number(&|r| Some(r.rms)));
        if self.ask.measure {
            add("partial", number(&|r| r.partial));
            add("t60", number(&|r| r.t60));
        }
        if self.ask.energy {
            add("residual", number(&|r| r.residual));
        }
        add("seed", Column::Whole(rows.iter().map(|r| r.seed as i64).collect()));
        add("scene", text(&|r| Some(r.hash.clone())));
        add(TIMES[0], number(&|r| Some(r.run_time)));
        add(TIMES[1], number(&|r| Some(r.rtf)));
        RunTable { columns }
    }
}

/// Refuses an axis that cannot be varied.
fn varied(axis: &Axis) -> Result<(), Failure> {
    if axis.name != "rate.sound" {
        return Ok(());
    }
    let what = "`rate.sound` cannot be varied: all sounds of a sweep have one rate";
    Err(Failure::Usage(format!("{what}; make one sweep for each rate")))
}

/// Returns the number of values of an axis, or an error if it is a range.
fn counted(axis: &Axis) -> Result<u64, Failure> {
    axis.count().ok_or_else(|| {
        let what = format!("`{}` has a continuous range", axis.name);
        Failure::Usage(format!("{what}; give the number of `runs` to draw, or of `steps` in the range"))
    })
}

/// Refuses a quantity in a unit that the parameter does not take, once for a range of random values.
fn measured_so(loaded: &Loaded, name: &str, end: &Value) -> Result<(), Failure> {
    let mut model = loaded.clone();
    load::set(&mut model, name, end.clone())?;
    let Err(mut found) = model.compile(&Options::default()) else { return Ok(()) };
    found.diags.list.retain(|d| d.code == "E008" && !d.span().is_some());
    if found.diags.list.is_empty() { Ok(()) } else { Err(Failure::Found(found)) }
}
