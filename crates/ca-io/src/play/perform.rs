//! Performance: a scene driven by gestures over time.
//!
//! Position and force ports read a gesture at every sound sample. Device ports read it once per gesture frame, through
//! the rate boundary of the scene. Live parameters read it once per gesture frame and ramp over that frame, so that a
//! gesture of straight lines gives a coefficient of straight lines. The command, Python and the tests all play scenes
//! through this loop, so the same model, gesture and parameters give the same bits everywhere.

use crate::error::{FileError, FileErrorKind};
use crate::gesture::{Gesture, Track, own};
pub use crate::play::player::DIVERGED;
use crate::play::player::Player;
use ca_core::internal::border::frame_due;
use ca_core::internal::numeric::Plain;
use ca_core::{Controls, InputRole, Level, LiveParam, Patch, Scene, State};
use std::ops::{Deref, DerefMut};

/// Silence after a gesture, and least length of a play \[s\].
const TAIL: f64 = 2.0;
const LEAST: f64 = 3.0;
/// Time for a sound to die away after the last event of a MIDI file \[s\].
const RING: f64 = 10.0;

enum Target {
    Input(usize),
    Device(usize),
    /// Index in [`Controls::params`].
    Param(usize),
}

/// Target of a track; numbers are indices in [`State::input`](ca_core::State::input).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Driven<'a> {
    /// Port of a device.
    Device(usize),
    /// Port of position or force.
    Port(usize),
    /// Live parameter.
    Param(&'a str),
}

struct Drive {
    target: Target,
    track: Track,
    near: usize,
    /// First value outside the range of a live parameter.
    outside: Option<f64>,
}

/// A scene played by gestures: a [`Player`] and the tracks that drive it.
pub struct Performance<'a> {
    /// Scene.
    pub scene: &'a Scene,
    /// Player with the state.
    pub player: Player,
    /// Live parameters of the scene.
    pub controls: Controls,
    drives: Vec<Drive>,
    /// Time of the last event of a MIDI file \[s\].
    midi_ends: Option<f64>,
    /// The last change of a parameter, kept to reuse its memory.
    patch: Patch,
}

impl Deref for Performance<'_> {
    type Target = Player;

    fn deref(&self) -> &Player {
        &self.player
    }
}

impl DerefMut for Performance<'_> {
    fn deref_mut(&mut self) -> &mut Player {
        &mut self.player
    }
}

impl<'a> Performance<'a> {
    /// Plays `scene` by its built-in gesture. Tracks of `gesture` replace built-in ones of the same name.
    ///
    /// # Errors
    /// If a track drives neither a port nor a live parameter, with the names that could be driven; or if a built-in
    /// gesture is not a curve over time.
    pub fn new(scene: &'a Scene, gesture: Option<&Gesture>) -> Result<Performance<'a>, FileError> {
        let mut p = Performance {
            scene,
            player: Player::new(scene.state()),
            controls: scene.controls(),
            drives: Vec::new(),
            midi_ends: gesture.filter(|g| g.is_midi()).map(Gesture::duration),
            patch: Patch { scene: scene.identity(), set: Vec::with_capacity(scene.live.coefs.len()) },
        };
        for track in own(scene) {
            let track = track?;
            if gesture.is_none_or(|g| g.track(track.name()).is_none()) {
                p.drive(track)?;
            }
        }
        for track in gesture.map_or(&[][..], Gesture::tracks) {
            p.drive(track.clone())?;
        }
        p.player = Player::new(scene.state_from(|input| p.hand(input)));
        Ok(p)
    }

    /// Returns the value of the gesture on input `input` of [`State::input`](ca_core::State::input) at the first tick,
    /// and its change per sample; `None` if nothing drives that input. A hand that moves at the first tick is taken to
    /// have moved before it.
    pub fn hand(&self, input: usize) -> Option<[f64; 2]> {
        let d = self.drives.iter().find(|d| matches!(d.target, Target::Input(i) | Target::Device(i) if i == input))?;
        let [now, next] = [0.0, self.scene.rates.sample_dt].map(|t| d.track.at(t));
        Some([now, next - now])
    }

    fn drive(&mut self, track: Track) -> Result<(), FileError> {
        let name = track.name();
        let param = || self.controls.params().iter().position(|p| p.name == name);
        let target = match (self.scene.inputs.iter().position(|i| i.name == name), param()) {
            (Some(i), _) if self.scene.inputs[i].role == InputRole::Device => Target::Device(i),
            (Some(i), _) => Target::Input(i),
            (None, Some(p)) => Target::Param(p),
            (None, None) => {
                let inputs = self.scene.inputs.iter().map(|i| i.name.as_str());
                let all: Vec<String> = inputs
                    .chain(self.controls.params().iter().map(|p| p.name.as_str()))
                    .map(|n| format!("`{n}`"))
                    .collect();
                let fix = if all.is_empty() {
                    "the model has neither ports nor live parameters".into()
                } else {
                    format!("choose one of {}", all.join(", "))
                };
                return Err(FileError::new(
                    FileErrorKind::Usage,
                    format!("`{name}` is not a port or live parameter of the model"),
                )
                .fix(fix));
            }
        };
        self.drives.push(Drive { target, track, near: 0, outside: None });
        Ok(())
    }

    /// Returns the time until the last gesture ends \[s\]; 0 without gestures.
    pub fn duration(&self) -> f64 {
        self.drives.iter().map(|d| d.track.duration()).fold(0.0, f64::max)
    }

    /// Returns the end of a gesture that contains a MIDI file \[s\].
    pub fn midi_ends(&self) -> Option<f64> {
        self.midi_ends
    }

    /// Returns the live parameters whose gesture has left their range so far and was clamped, each with the first value
    /// outside \[SI\].
    pub fn clamped(&self) -> impl Iterator<Item = (&LiveParam, f64)> {
        let params = self.controls.params();
        self.drives.iter().filter_map(move |d| match d.target {
            Target::Param(p) => Some((params.get(p)?, d.outside?)),
            _ => None,
        })
    }

    /// Returns the names of the driven ports and parameters.
    pub fn driven(&self) -> Vec<&str> {
        self.drives.iter().map(|d| d.track.name()).collect()
    }

    /// Returns each target with its value at the gesture frame that begins at tick `tick`, for an engine that plays the
    /// scene itself.
    pub fn hands(&mut self, tick: u64) -> impl Iterator<Item = (Driven<'_>, f64)> {
        let t = self.end_of_frame(tick);
        let params = self.controls.params();
        self.drives.iter_mut().map(move |d| {
            let value = d.track.at_near(&mut d.near, t);
            let what = match d.target {
                Target::Input(i) => Driven::Port(i),
                Target::Device(i) => Driven::Device(i),
                Target::Param(p) => Driven::Param(&params[p].name),
            };
            (what, value)
        })
    }

    /// Returns the time for which values read at the start of a frame are meant \[s\]: the end of the frame.
    fn end_of_frame(&self, tick: u64) -> f64 {
        let tick_dt = self.scene.rates.sample_dt;
        if tick == 0 { 0.0 } else { tick as f64 * tick_dt + f64::from(self.scene.rates.ratio - 1) * tick_dt }
    }

    /// Runs one tick; the outputs are in `state.output`.
    pub fn tick(&mut self) {
        if !self.diverged {
            self.move_hands();
        }
        self.player.tick(self.scene);
    }

    /// Sets ports and live parameters to the values of their gestures at this tick.
    fn move_hands(&mut self) {
        let end = self.end_of_frame(self.state.tick);
        let (scene, s) = (self.scene, &mut self.player.state);
        let frame = frame_due(scene, s.tick);
        let t = s.tick as f64 * scene.rates.sample_dt;
        for d in &mut self.drives {
            match &d.target {
                Target::Input(i) => s.input[*i] = d.track.at_near(&mut d.near, t),
                Target::Device(i) if frame => s.input[*i] = d.track.at_near(&mut d.near, end),
                Target::Param(p) if frame => {
                    let v = d.track.at_near(&mut d.near, end);
                    let param = &self.controls.params()[*p];
                    if param.value != v {
                        if !(param.min..=param.max).contains(&v) {
                            d.outside = d.outside.or(Some(v));
                        }
                        // an out-of-range value is clamped, because a gesture is a signal and must never stop a
                        // performance
                        let v = v.max(param.min).min(param.max);
                        if self.controls.set_indexed(*p, v, &mut self.patch).is_ok() {
                            s.apply(&self.patch, if s.tick == 0 { 1 } else { scene.rates.frame });
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// Runs `n` ticks, and appends the outputs of each to `rows`.
    pub fn ticks(&mut self, n: u64, rows: &mut Vec<f64>) {
        if self.drives.is_empty() {
            return self.player.ticks(self.scene, n, rows);
        }
        for _ in 0..n {
            self.tick();
            rows.extend_from_slice(&self.player.state.output[..self.scene.counts.n_out]);
        }
    }

    /// Runs a tick for each row of `rows` (ticks × inputs), and writes the values of the inputs to it.
    pub fn given(&mut self, rows: &mut [f64]) {
        for row in rows.chunks_exact_mut(self.scene.inputs.len().max(1)) {
            self.tick();
            row.copy_from_slice(&self.player.state.input);
        }
    }

    /// Plays up to tick number `tick`, or until positions are out of range, which is checked every `look` ticks.
    pub fn until(&mut self, tick: u64, look: u64) {
        while self.state.tick < tick && self.state.is_bounded(DIVERGED) {
            (0..look.min(tick - self.state.tick)).for_each(|_| self.tick());
        }
    }

    /// Returns the module that most likely caused a divergence ([`Player::diverged`]), and the reason. This is the
    /// module that the certificate names, if it found the scene unstable. Otherwise it is the link that created most
    /// energy in a second run with a ledger, on the scene `audited`; otherwise the MAT with the largest displacement.
    pub fn blame(&self, audited: Option<&Scene>, gesture: Option<&Gesture>) -> (String, String) {
        let cert = &self.scene.certificate;
        if cert.lower >= 4.0 {
            let why = format!(
                "too stiff for its mass at this rate (largest eigenvalue at least {:.3}, the limit is 4)",
                Plain(cert.lower)
            );
            return (cert.worst.clone(), why);
        }
        if cert.level == Level::NotProven && cert.bound >= 4.0 {
            let why = format!(
                "it may be too stiff for its mass at this rate (largest eigenvalue at most {:.3}, the limit is 4)",
                Plain(cert.bound)
            );
            return (cert.worst.clone(), why);
        }
        if let Some(scene) = audited {
            if let Ok(mut audited) = Performance::new(scene, gesture) {
                // up to the first tick out of range: later entries say nothing about the cause
                audited.until(self.state.tick + 64, 1);
                if let Some((link, made)) = audited.state.ledger.as_deref().and_then(ca_core::Ledger::largest_error) {
                    if let Some(name) = scene.audited_name(link) {
                        return (name.into_owned(), format!("it created {made:.3e} J"));
                    }
                }
            }
        }
        let m = furthest(&self.state);
        (self.scene.mat_name(m).into(), "its displacement is the largest".into())
    }
}

/// Returns the MAT with the largest displacement, or one that is not a number.
fn furthest(state: &State) -> usize {
    let size = |i: &usize| if state.x[*i].is_nan() { f64::INFINITY } else { state.x[*i].abs() };
    (0..state.x.len()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0)
}

/// Returns the longest time for which a scene is played \[s\]: as asked; until 10 s after the last event of a MIDI
/// file; as the model says; or 2 s beyond its gestures, and at least 3 s.
pub fn seconds(p: &Performance, asked: Option<f64>) -> f64 {
    let midi = p.midi_ends.map(|end| end + RING);
    asked.or(midi).or(p.scene.about.seconds).unwrap_or((p.duration() + TAIL).max(LEAST))
}

/// Returns the number of samples in `seconds`; at least one.
pub fn frames(scene: &Scene, seconds: f64) -> u64 {
    (seconds * scene.rate).round().max(1.0) as u64
}
