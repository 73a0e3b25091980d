//! Plays one scene many times, each time with other values, into one array.
//!
//! ```text
//! model ─ values of some instances ─ compiled as one ─ played ─ a row of one array for each
//! ```
//! Small instances are merged into one model (`merge`), so that each tick begins once for all of them; each keeps the
//! bits of a separate render. Contacts that are solved together would change each other's last bits, so instances of
//! such a scene are played one by one. Threads take further instances when done. All instances have the same duration.
//!
//! An instance that does not compile, or diverges, does not stop the batch: the instances merged with it are played one
//! by one, and its own sound is silent, or ends at the divergence, with a status. A [`Sweep`](crate::Sweep) draws its
//! values, measures and writes files; a batch is given its values and returns sound.

mod merge;

use ca_compile::Options;
use ca_core::Scene;
use ca_core::internal::op::SolveStage;
use ca_io::gesture::Gesture;
use ca_io::perform::Performance;
use ca_io::sound::Level;
use ca_lab::Failure;
use ca_lab::load::{self, Loaded};
use ca_lab::outcome::Outcome;
use ca_lab::play::{self, BLOCK, Sample};
use ca_model::Value;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Modules merged at most, unless one instance has more; with more, a shared beginning of the tick saves nothing.
const TOGETHER: usize = 2000;
/// Instances merged at most.
const MOST: usize = 16;

/// Poll interval of `goes_on`.
const LOOK: Duration = Duration::from_millis(20);

/// Specification of a batch.
#[derive(Clone, Debug, PartialEq)]
pub struct BatchSpec {
    /// Names of parameters, each with its value in every instance.
    pub values: Vec<(String, Vec<Value>)>,
    /// Duration of an instance \[s\]; as the scene if `None`.
    pub seconds: Option<f64>,
    /// Number of threads.
    pub threads: usize,
}

/// Result of a batch, instance after instance.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch<S> {
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Samples per channel of an instance.
    pub frames: usize,
    /// Number of sound channels.
    pub channels: usize,
    /// Number of probes.
    pub probes: usize,
    /// Sound within full scale (instances x frames x channels).
    pub sound: Vec<S>,
    /// Probes (instances x frames x probes).
    pub probed: Vec<S>,
    /// Outcome of each instance.
    pub outcomes: Vec<Outcome>,
    /// Greatest |sample| of each instance before the ceiling; 1 is full scale.
    pub peaks: Vec<f64>,
}

/// Plays a scene once for each value. `goes_on` is called regularly with the number of finished and of all instances.
///
/// # Errors
/// [`Failure::Usage`] where the columns have different lengths, a parameter or a target of the gesture does not exist,
/// or the result does not fit into memory; [`Failure::Found`] where the scene itself has errors; [`Failure::Stopped`]
/// where `goes_on` returns false.
pub fn batch<S: Sample>(
    loaded: &Loaded,
    options: &Options,
    spec: &BatchSpec,
    gesture: Option<&Gesture>,
    goes_on: &mut dyn FnMut(u64, u64) -> bool,
) -> Result<Batch<S>, Failure> {
    let n = instances(loaded, spec)?;
    let scene = loaded.compile(options)?.scene;
    let performance = Performance::new(&scene, gesture)?;
    let frames = play::frames(&scene, play::seconds(&performance, spec.seconds));
    let (channels, probes) = (scene.counts.channels, scene.counts.n_out - scene.counts.channels);
    let one = usize::try_from(frames).ok();
    let width = |width: usize| one.and_then(|frames| frames.checked_mul(width));
    let refused = || {
        let what = format!("{n} instances of {frames} samples do not fit into memory");
        Failure::Usage(format!("{what}; play fewer instances at a time, or fewer seconds"))
    };
    let (per_sound, per_probes) = (width(channels).ok_or_else(refused)?, width(probes).ok_or_else(refused)?);
    let mut sound = zeros::<S>(n.checked_mul(per_sound)).ok_or_else(refused)?;
    let mut probed = zeros::<S>(n.checked_mul(per_probes)).ok_or_else(refused)?;
    let mut ended = vec![(Outcome::invalid(String::new()), 0.0); n];

    let (rate, stop) = (scene.rate, AtomicBool::new(false));
    let shared = Shared { loaded, options, spec, gesture, rate, frames, channels, probes, stop: &stop };
    let most = if solves_at_once(&scene) { 1 } else { MOST };
    // few enough that each thread has some
    let some = (TOGETHER / (scene.counts.n_mat + scene.counts.n_lia).max(1))
        .clamp(1, most)
        .min(n.div_ceil(spec.threads.max(1)).max(1));
    let rows = rows(&mut sound, n, per_sound).into_iter().zip(rows(&mut probed, n, per_probes)).zip(&mut ended);
    let slots = rows.enumerate().map(|(index, ((sound, probed), to))| Slot { index, sound, probed, to });
    let slots = Mutex::new(slots);
    let (done, each) = mpsc::channel();
    let work = |done: mpsc::Sender<usize>| {
        while !stop.load(Relaxed) {
            // the lock only covers steps of an iterator, which do not panic
            let mut next: Vec<_> = slots.lock().unwrap_or_else(PoisonError::into_inner).by_ref().take(some).collect();
            if next.is_empty() {
                return;
            }
            if next.len() == 1 {
                shared.play(&mut next[0]);
            } else if shared.together(&mut next).is_none() {
                for slot in &mut next {
                    // an instance that diverges is silent from there, so earlier output of the merged play is cleared
                    slot.sound.fill(S::default());
                    slot.probed.fill(S::default());
                    shared.play(slot);
                }
            }
            // the receiver is gone after a stop
            let _ = done.send(next.len());
        }
    };
    let wanted = std::thread::scope(|scope| {
        for _ in 0..spec.threads.clamp(1, n.max(1)) {
            let done = done.clone();
            scope.spawn(|| work(done));
        }
        drop(done);
        let mut played = 0;
        loop {
            match each.recv_timeout(LOOK) {
                Ok(more) => played += more as u64,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return goes_on(played, n as u64),
            }
            if !goes_on(played, n as u64) {
                stop.store(true, Relaxed);
                return false;
            }
        }
    });
    if !wanted {
        return Err(Failure::Stopped);
    }
    let (outcomes, peaks) = ended.into_iter().unzip();
    Ok(Batch { rate, frames: frames as usize, channels, probes, sound, probed, outcomes, peaks })
}

/// Returns whether links are solved together; then each changes the last bits of all others, across instances too.
fn solves_at_once(scene: &Scene) -> bool {
    scene.passes.forces.iter().filter_map(|op| op.law).any(|law| matches!(law.stage, SolveStage::Coupled(_)))
}

/// Returns the number of instances, or an error where a varied parameter does not exist or columns differ in length.
fn instances(loaded: &Loaded, spec: &BatchSpec) -> Result<usize, Failure> {
    let Some((first, values)) = spec.values.first() else {
        return Err(Failure::Usage("a batch needs at least one parameter; give its value for each instance".into()));
    };
    for (name, all) in &spec.values {
        if all.len() != values.len() {
            let (n, of_first) = (all.len(), values.len());
            return Err(Failure::Usage(format!(
                "`{name}` has {n} values, but `{first}` has {of_first}; give each one value per instance"
            )));
        }
        if name == "rate.sound" {
            return Err(Failure::Usage("`rate.sound` cannot be varied: all sounds of a batch have one rate".into()));
        }
        if name == "model.seconds" {
            let what =
                "`model.seconds` cannot be varied: all sounds of a batch are equally long; set `seconds` of the batch";
            return Err(Failure::Usage(what.into()));
        }
        if let Some(value) = all.first() {
            load::set(&mut loaded.clone(), name, value.clone())?;
        }
    }
    Ok(values.len())
}

/// Allocates `n` zeros; `None` where they do not fit into memory.
fn zeros<S: Sample>(n: Option<usize>) -> Option<Vec<S>> {
    let (n, mut all) = (n?, Vec::new());
    all.try_reserve_exact(n).ok()?;
    all.resize(n, S::default());
    Some(all)
}

/// Splits an array into `n` rows of a width, which may be 0.
fn rows<S>(mut all: &mut [S], n: usize, width: usize) -> Vec<&mut [S]> {
    let row = |_| {
        let (row, rest) = std::mem::take(&mut all).split_at_mut(width);
        all = rest;
        row
    };
    (0..n).map(row).collect()
}

struct Slot<'r, S> {
    index: usize,
    sound: &'r mut [S],
    probed: &'r mut [S],
    to: &'r mut (Outcome, f64),
}

impl<S: Sample> Slot<'_, S> {
    /// Stores rows of outputs (channels, then `probes` probes) from sample `first`.
    fn store(&mut self, rows: &[f64], probes: usize, level: &mut Level, first: usize) {
        let channels = level.peak.len();
        let width = (channels + probes).max(1);
        level.keep_rows(rows, width, &mut self.sound[first * channels..]);
        if probes > 0 {
            for (row, to) in rows.chunks_exact(width).zip(self.probed[first * probes..].chunks_exact_mut(probes)) {
                row[channels..].iter().zip(to).for_each(|(x, to)| *to = S::of(*x));
            }
        }
    }
}

fn peak(level: &Level) -> f64 {
    level.peak.iter().copied().fold(0.0, f64::max)
}

struct Shared<'a> {
    loaded: &'a Loaded,
    options: &'a Options,
    spec: &'a BatchSpec,
    gesture: Option<&'a Gesture>,
    rate: f64,
    frames: u64,
    channels: usize,
    probes: usize,
    stop: &'a AtomicBool,
}

impl Shared<'_> {
    fn instance(&self, index: usize) -> Result<Loaded, Failure> {
        let mut loaded = self.loaded.clone();
        for (name, values) in &self.spec.values {
            load::set(&mut loaded, name, values[index].clone())?;
        }
        Ok(loaded)
    }

    /// Plays some instances as one scene. Returns `None`, without outcomes, if that is impossible or one fails.
    fn together<S: Sample>(&self, some: &mut [Slot<'_, S>]) -> Option<()> {
        let (n, channels, width) = (some.len(), self.channels, self.channels + self.probes);
        let mut all: Loaded = self.loaded.clone();
        let mut models = Vec::with_capacity(n);
        for slot in some.iter() {
            let Loaded { model, clouds, .. } = self.instance(slot.index).ok()?;
            models.push(model);
            all.clouds.extend(clouds);
        }
        all.model = merge::models(&models, channels, &load::catalog())?;
        let probes = merge::probes(&self.options.probes, n);
        let compiled = all.compile(&Options { bounds_only: true, probes, ..self.options.clone() }).ok()?;
        let scene = &compiled.scene;
        let whole = (scene.rate, scene.counts.channels, scene.counts.n_out) == (self.rate, n * channels, n * width);
        if !whole || solves_at_once(scene) {
            return None;
        }
        let gesture = self.gesture.map(|g| merge::gesture(g, n).ok_or(())).transpose().ok()?;
        let mut levels = vec![Level::new(channels); n];
        let mut own = Vec::with_capacity(BLOCK as usize * width);
        let performance = Performance::new(scene, gesture.as_ref()).ok()?;
        // a block of all instances has as many numbers as one of a single instance, to stay in the first cache
        let block = (BLOCK / n as u64).max(64);
        let played = play::play(performance, self.frames, block, &mut |_, rows, done| {
            let first = done as usize - rows.len() / (n * width).max(1);
            for (i, (slot, level)) in some.iter_mut().zip(&mut levels).enumerate() {
                own.clear();
                for row in rows.chunks_exact((n * width).max(1)) {
                    own.extend_from_slice(&row[i * channels..][..channels]);
                    own.extend_from_slice(&row[n * channels + i * self.probes..][..self.probes]);
                }
                slot.store(&own, self.probes, level, first);
            }
            if self.stop.load(Relaxed) { Err(()) } else { Ok(()) }
        });
        let played = played.ok()?;
        if played.diverged_at.is_some() || played.performance.state.ports.refused > 0 {
            return None;
        }
        for (slot, level) in some.iter_mut().zip(&levels) {
            *slot.to = (Outcome::judge(level, 0, width > 0), peak(level));
        }
        Some(())
    }

    fn play<S: Sample>(&self, slot: &mut Slot<'_, S>) {
        // stability is only judged for an instance that diverges, so that a render gives the same message
        let quick = Options { bounds_only: true, ..self.options.clone() };
        let first = self.played(slot, &quick);
        let again = first.as_ref().is_ok_and(|(outcome, _)| outcome.status == "unstable");
        let ended = if again { self.played(slot, self.options) } else { first };
        *slot.to = ended.unwrap_or_else(|e| (Outcome::invalid(e.line()), 0.0));
    }

    fn played<S: Sample>(&self, slot: &mut Slot<'_, S>, options: &Options) -> Result<(Outcome, f64), Failure> {
        let loaded = self.instance(slot.index)?;
        let compiled = loaded.compile(options)?;
        let scene = &compiled.scene;
        let probes = scene.counts.n_out - scene.counts.channels;
        if (scene.rate, scene.counts.channels, probes) != (self.rate, self.channels, self.probes) {
            let of = |channels: usize, probes: usize, rate: f64| {
                format!("{channels} channels and {probes} probes at {rate} Hz")
            };
            return Err(Failure::Failed(format!(
                "this instance has {}, but the unchanged scene has {}; all instances of a batch need the same shape",
                of(scene.counts.channels, probes, scene.rate),
                of(self.channels, self.probes, self.rate)
            )));
        }
        let mut level = Level::new(self.channels);
        let played = play::play(Performance::new(scene, self.gesture)?, self.frames, BLOCK, &mut |_, rows, done| {
            slot.store(rows, probes, &mut level, done as usize - rows.len() / scene.counts.n_out.max(1));
            if self.stop.load(Relaxed) { Err(Failure::Stopped) } else { Ok(()) }
        })?;
        let outcome = Outcome::of(&played, &level, (scene, &compiled.findings), (&loaded, options), self.gesture);
        Ok((outcome, peak(&level)))
    }
}
