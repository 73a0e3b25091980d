//! The engine: takes device frames, and returns forces and sound, one gesture frame at a time.
//!
//! It is a function of the scene and of the order of frames and commands only, without clock or thread.
//! [`serve`](crate::serve) adds real time; a take replays the same calls and gives the same bits. A frame has two
//! halves, because its force is known before the masses of its last tick move: [`Engine::answer`] makes the force
//! frames, to be sent at once, and [`Engine::finish`] does the rest. After [`Engine::new`] nothing allocates, locks,
//! logs or panics.
//!
//! Frame n covers the ticks (n−1)R+1 … nR (docs/numerics.md §5.1); the very first only places the devices.

mod manual;
mod mean_force;
mod port;
mod refit;
mod sound;
mod swap;
#[cfg(all(test, feature = "system"))]
pub(crate) mod tests;

pub(crate) use manual::lead;
pub use manual::{GLIDE, LONGEST, ManualEvent, ManualInput, OwnGesture};
#[cfg(feature = "system")]
pub(crate) use mean_force::is_slower;
pub use port::{Link, Port, Setup, coupled};
pub use refit::Refit;
pub use swap::{FixedPart, Swap, continuing_masses};

use crate::frame::{DeviceFrame, ForceFrame};
use crate::guard::Order;
use crate::guard::input::FrameVerdict;
use ca_core::internal::state::scene_of;
use ca_core::{Patch, Scene, State, compute_forces, integrate};
use manual::ManualState;
use sound::PeakLimit;
use std::sync::Arc;

/// Parameters that change in one tick, prepared outside the engine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// Numbers of live parameters, with their values (SI units), for the record.
    pub params: Vec<(u32, f64)>,
    /// Changes of the coefficients, in order.
    pub patches: Vec<Patch>,
}

/// A command to a running engine.
#[derive(Clone, Debug, PartialEq)]
pub enum EngineCommand {
    /// Sets parameters, ramped over the next gesture frame.
    Set(Box<Change>),
    /// Turns forces on or off, for one device, or for all with `None`.
    Order(Option<u32>, Order),
    /// Replaces the state, usually by the state at load, and turns forces off. Made outside, because that allocates.
    Reload(Box<State>),
    /// Replaces the port of a device that has described itself. Made outside, because that allocates.
    Refit(Box<Refit>),
    /// Manual input without a device.
    Manual(ManualInput),
    /// Replaces the scene by another version. Made outside, because that allocates.
    Swap(Box<Swap>),
    /// Changes nothing; its record contains the hash of the state.
    Mark,
}

/// Memory that a command leaves behind, to be freed on another thread.
#[derive(Clone, Debug, PartialEq)]
pub enum Retired {
    /// The change that was applied.
    Change(Box<Change>),
    /// The state before a reload.
    State(Box<State>),
    /// The port before a refit, with the new profile.
    Port(Box<Refit>),
    /// A gesture that was stopped or replaced.
    Gesture(Box<OwnGesture>),
    /// The scene that played before the replaced one, or a refused swap.
    Swap(Box<Swap>),
}

/// Options of an engine that do not belong to the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Number that changes with each start, sent with each force frame.
    pub session: u64,
    /// Displacement \[m\], or motion per tick \[m\], beyond which the model has diverged (H15).
    pub diverged: f64,
    /// True if forces fade out when another version of the scene begins to play. In older takes they end in one frame.
    pub fades: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options { session: 1, diverged: 1e3, fades: true }
    }
}

/// Counts of an engine, including each kind of loss.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Gesture frames played.
    pub frames: u64,
    /// Device frames used.
    pub taken: u64,
    /// Device frames dropped by the input checks (H10).
    pub dropped: u64,
    /// Gesture frames for which a connected device sent nothing, although its rate made a frame due.
    pub stale: u64,
    /// Faults that latched.
    pub faults: u64,
    /// Sound samples that were clipped or not finite (H16).
    pub clipped: u64,
    /// Commands that did not fit the scene.
    pub refused: u64,
}

/// A scene that devices play.
pub struct Engine {
    /// Scene.
    pub scene: Arc<Scene>,
    /// State of the scene.
    pub state: State,
    /// Devices.
    pub ports: Vec<Port>,
    /// Counts.
    pub counts: Counts,
    options: Options,
    /// Sound of this frame, interleaved (R × channels).
    sound: Vec<f64>,
    filled: usize,
    peak_limit: PeakLimit,
    manual: ManualState,
    /// Previous scene, whose sound fades out.
    before: Option<Box<Swap>>,
    diverged: bool,
    /// True once the scene has reached the force of the frame.
    prepared: bool,
    /// Faults of ports that were replaced.
    past_faults: u64,
}

impl Engine {
    /// Makes an engine at rest. [`Port::new`] has matched devices and scene.
    pub fn new(scene: Arc<Scene>, ports: Vec<Port>, options: Options) -> Engine {
        let state = scene.state();
        let channels = scene.counts.channels;
        let sound = vec![0.0; scene.rates.ratio as usize * channels];
        let peak_limit = PeakLimit::new(channels, scene.rate);
        let manual = ManualState::new(&scene);
        let mut engine = Engine {
            scene,
            state,
            ports,
            counts: Counts::default(),
            options,
            sound,
            filled: 0,
            peak_limit,
            manual,
            before: None,
            diverged: false,
            prepared: false,
            past_faults: 0,
        };
        for p in &mut engine.ports {
            p.out.session = options.session;
        }
        engine
    }

    /// Returns the first tick of the next frame, with which frames taken now are stamped.
    pub fn due(&self) -> u64 {
        self.state.tick
    }

    /// Takes and stamps a frame of device number `k`. If several come before a gesture frame, the last good one counts.
    pub fn take(&mut self, k: usize, frame: &mut DeviceFrame) -> FrameVerdict {
        frame.tick = self.state.tick;
        let Some(port) = self.ports.get_mut(k) else { return FrameVerdict::Foreign };
        let verdict = port.take(frame);
        if verdict == FrameVerdict::Good {
            self.counts.taken += 1;
        } else {
            self.counts.dropped += 1;
        }
        verdict
    }

    /// Executes a command from the next tick on. Returns memory to be freed on another thread.
    pub fn command(&mut self, act: EngineCommand) -> Option<Retired> {
        match act {
            EngineCommand::Set(change) => {
                // at once before the first tick
                let ticks = if self.state.tick == 0 { 1 } else { self.scene.rates.frame };
                for patch in &change.patches {
                    if !self.state.apply(patch, ticks) {
                        self.counts.refused += 1;
                    }
                }
                return Some(Retired::Change(change));
            }
            EngineCommand::Order(which, order) => match which {
                None => self.ports.iter_mut().for_each(|p| p.chain.order(order)),
                Some(k) => match self.ports.get_mut(k as usize) {
                    Some(p) => p.chain.order(order),
                    None => self.counts.refused += 1,
                },
            },
            EngineCommand::Reload(mut state) => {
                if scene_of(&state) == self.scene.identity() {
                    // the tick continues, because it gives the phase in a frame and numbers the frames of a take
                    state.tick = self.state.tick;
                    core::mem::swap(&mut self.state, &mut state);
                    self.diverged = false;
                    self.peak_limit.reset();
                    self.manual.release_all();
                    for p in &mut self.ports {
                        p.chain.order(Order::Disarm);
                        p.reach_again(&self.state);
                    }
                } else {
                    self.counts.refused += 1;
                }
                return Some(Retired::State(state));
            }
            EngineCommand::Refit(mut refit) => {
                let port = self.ports.get_mut(refit.which as usize);
                match port.and_then(|p| refit.swap(p)) {
                    Some(faults) => self.past_faults += faults,
                    None => self.counts.refused += 1,
                }
                return Some(Retired::Port(refit));
            }
            EngineCommand::Manual(input) => {
                let (gone, done) = self.manual.apply(&self.scene, &self.state, input);
                self.counts.refused += u64::from(!done);
                return gone.map(Retired::Gesture);
            }
            EngineCommand::Swap(mut swap) => {
                let faults = self.ports.iter().map(|p| p.chain.faults()).sum::<u64>();
                let Engine { scene, state, ports, manual, .. } = self;
                if !swap.swap(scene, state, ports, manual, (!self.diverged, self.options.fades)) {
                    self.counts.refused += 1;
                    return Some(Retired::Swap(swap));
                }
                self.past_faults += faults;
                if core::mem::take(&mut self.diverged) {
                    self.peak_limit.reset();
                }
                return self.before.replace(swap).map(Retired::Swap);
            }
            EngineCommand::Mark => {}
        }
        None
    }

    /// Runs the scene up to the force of the frame, which [`Engine::answer`] then guards. A caller can read a clock in
    /// between: an order to the guard before [`Engine::answer`] still affects this frame. A second call does nothing.
    pub fn prepare(&mut self) {
        if core::mem::replace(&mut self.prepared, true) {
            return;
        }
        let first = self.state.tick == 0;
        for p in &mut self.ports {
            p.place(&mut self.state);
            self.counts.stale += u64::from(p.is_stale());
        }
        let ports = &self.ports;
        let silent = |input: usize| !ports.iter().any(|p| p.speaks_for(input));
        self.manual.frame(&self.scene, &mut self.state, silent);
        self.filled = 0;
        let ticks = if first { 1 } else { self.scene.rates.ratio };
        for j in 1..=ticks {
            if j > 1 && !self.diverged {
                self.advance();
            }
            self.sample();
        }
        self.watch();
    }

    /// Does the first half of a gesture frame: calls [`Engine::prepare`], guards the forces, and returns the frames to
    /// send, one per device.
    pub fn answer(&mut self) -> impl Iterator<Item = &ForceFrame> {
        self.prepare();
        self.prepared = false;
        let (state, diverged, options) = (&self.state, self.diverged, &self.options);
        for p in &mut self.ports {
            p.answer(&self.scene, state, options.session, diverged);
        }
        self.counts.faults = self.past_faults + self.ports.iter().map(|p| p.chain.faults()).sum::<u64>();
        self.ports.iter().map(|p| &p.out)
    }

    /// Does the second half: moves the masses of the last tick. Returns the sound of the frame, interleaved.
    pub fn finish(&mut self) -> &[f64] {
        if self.diverged {
            // the tick advances, so that frames have the right numbers
            self.state.tick += 1;
        } else {
            self.advance();
        }
        self.counts.frames += 1;
        &self.sound[..self.filled]
    }

    fn advance(&mut self) {
        if let Some(before) = &mut self.before {
            before.advance();
        }
        self.manual.pointers.iter_mut().for_each(|p| p.prepare(&self.state));
        integrate(&self.scene, &mut self.state);
        self.manual.pointers.iter_mut().for_each(|p| p.apply(&mut self.state));
    }

    /// Plays one tick up to its outputs. It does not use `ca_io::player::Player`, because manual and pointers move
    /// between its halves, the limit of positions is an option, and the tick advances after a divergence.
    fn sample(&mut self) {
        let n = self.scene.counts.channels;
        if self.diverged {
            self.state.output.fill(0.0);
            // for the last sample of the frame, `finish` advances the tick
            self.state.tick += u64::from(self.filled > 0);
        } else {
            self.manual.tick(&self.scene, &mut self.state);
            compute_forces(&self.scene, &mut self.state);
        }
        let to = &mut self.sound[self.filled..self.filled + n];
        to.copy_from_slice(&self.state.output[..n]);
        if let Some(before) = self.before.as_mut().filter(|_| !self.diverged) {
            before.sample(to);
        }
        self.counts.clipped += self.peak_limit.pass(to, self.diverged);
        self.filled += n;
    }

    /// Detects a divergence (H15).
    fn watch(&mut self) {
        if !self.diverged && !self.state.is_bounded(self.options.diverged) {
            self.diverged = true;
        }
    }

    /// Returns the options.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Returns true if the model has diverged.
    pub fn has_diverged(&self) -> bool {
        self.diverged
    }
}
