//! The engine: frames of devices in, forces and sound out, one gesture frame at a time.
//!
//! Decides that this is a pure function of what it is given: the scene, the order of frames and commands, and nothing else,
//! no clock, no thread. Real time is somebody else's ([`serve`](crate::serve)); a take replays the same calls and gets
//! the same bits. A frame has two halves, because the force of the frame is known before the masses of its last tick
//! move: [`Engine::answer`] makes the force frames, to be sent at once, and [`Engine::finish`] does the rest. After
//! [`Engine::new`] nothing allocates, locks, logs or panics.
//!
//! Frame n covers the ticks (n−1)R+1 … nR (docs/numerics.md §5.1); the very first only places the devices.

mod mean_force;
mod port;
mod refit;
mod sound;
mod swap;
#[cfg(all(test, feature = "system"))]
pub(crate) mod tests;
mod touch;

#[cfg(feature = "system")]
pub(crate) use mean_force::is_slower;
pub use port::{Link, Port, Setup, coupled};
pub use refit::Refit;
pub use swap::{FixedPart, Swap, carried};
pub(crate) use touch::lead;
pub use touch::{GLIDE, LONGEST, OwnGesture, Touch, Touched};

use crate::frame::{DeviceFrame, ForceFrame};
use crate::guard::Order;
use crate::guard::input::FrameVerdict;
use ca_core::internal::state::scene_of;
use ca_core::{Patch, Scene, State, compute_forces, integrate};
use sound::PeakLimit;
use std::sync::Arc;
use touch::Hands;

/// Several parameters that change in one tick, made ready outside the engine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// live parameter by number, and its value \[SI\]: for the record
    pub params: Vec<(u32, f64)>,
    /// what it does to the coefficients, in order
    pub patches: Vec<Patch>,
}

/// What somebody asks of a running engine.
#[derive(Clone, Debug, PartialEq)]
pub enum EngineCommand {
    /// new values of parameters, ramped over the next gesture frame
    Set(Box<Change>),
    /// forces on or off, of one device or all
    Order(Option<u32>, Order),
    /// this state of the same scene instead, usually that at load, and forces off; made outside, since that allocates
    Reload(Box<State>),
    /// a device said what it is: its port made anew outside, since that allocates
    Refit(Box<Refit>),
    /// a hand without a device does something
    Touch(Touch),
    /// another version of the scene, made outside, since that allocates
    Swap(Box<Swap>),
    /// changes nothing; the record of it has the hash of the state
    Mark,
}

/// What an act leaves behind, to be freed elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub enum Retired {
    /// a change that was made
    Change(Box<Change>),
    /// the state before a reload
    State(Box<State>),
    /// the port before a refit, with the profile that took its place
    Port(Box<Refit>),
    /// a gesture that ended
    Gesture(Box<OwnGesture>),
    /// the scene before the one that a swap took out, or one that had nothing to give
    Swap(Box<Swap>),
}

/// Numbers of an engine that are not of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// a number that changes with every start, sent with every force frame
    pub session: u64,
    /// displacement \[m\] or motion a tick beyond which the model has diverged (H15)
    pub diverged: f64,
    /// forces fade out where another version of the scene begins to play; in takes of before they ended in a frame
    pub fades: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options { session: 1, diverged: 1e3, fades: true }
    }
}

/// What was counted. Nothing is lost without a number here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// gesture frames done
    pub frames: u64,
    /// device frames used
    pub taken: u64,
    /// device frames dropped by the input checks (H10)
    pub dropped: u64,
    /// gesture frames for which a device that was there sent nothing, beyond what its rate explains
    pub stale: u64,
    /// faults that latched
    pub faults: u64,
    /// sound samples that were clipped or not finite (H16)
    pub clipped: u64,
    /// commands that did not fit the scene
    pub refused: u64,
}

/// A scene being played by devices.
pub struct Engine {
    /// the scene
    pub scene: Arc<Scene>,
    /// its state
    pub state: State,
    /// its devices
    pub ports: Vec<Port>,
    /// what was counted
    pub counts: Counts,
    options: Options,
    /// sound of this frame, interleaved (R × channels)
    sound: Vec<f64>,
    filled: usize,
    peak_limit: PeakLimit,
    hands: Hands,
    /// the scene before this one, which fades out
    before: Option<Box<Swap>>,
    diverged: bool,
    /// the scene is at the force of the frame
    prepared: bool,
    /// faults of ports that were made anew
    past_faults: u64,
}

impl Engine {
    /// An engine at rest. Devices and scene have been matched by [`Port::new`].
    pub fn new(scene: Arc<Scene>, ports: Vec<Port>, options: Options) -> Engine {
        let state = scene.state();
        let channels = scene.counts.channels;
        let sound = vec![0.0; scene.rates.ratio as usize * channels];
        let peak_limit = PeakLimit::new(channels, scene.rate);
        let hands = Hands::new(&scene);
        let mut engine = Engine {
            scene,
            state,
            ports,
            counts: Counts::default(),
            options,
            sound,
            filled: 0,
            peak_limit,
            hands,
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

    /// The first tick of the frame that comes next: what is taken now is stamped with it.
    pub fn due(&self) -> u64 {
        self.state.tick
    }

    /// Takes a frame of device number `k`, and stamps it. Several may come before one gesture frame; the last good one
    /// counts.
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

    /// Does what somebody asked, from the next tick on. Gives back what must be freed elsewhere.
    pub fn command(&mut self, act: EngineCommand) -> Option<Retired> {
        match act {
            EngineCommand::Set(change) => {
                // at once where nothing has sounded yet
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
                    // the tick goes on: it says which phase of a frame comes, and numbers the frames of a take
                    state.tick = self.state.tick;
                    core::mem::swap(&mut self.state, &mut state);
                    self.diverged = false;
                    self.peak_limit.reset();
                    self.hands.let_go();
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
            EngineCommand::Touch(touch) => {
                let (gone, done) = self.hands.touch(&self.scene, &self.state, touch);
                self.counts.refused += u64::from(!done);
                return gone.map(Retired::Gesture);
            }
            EngineCommand::Swap(mut swap) => {
                let faults = self.ports.iter().map(|p| p.chain.faults()).sum::<u64>();
                let Engine { scene, state, ports, hands, .. } = self;
                if !swap.swap(scene, state, ports, hands, (!self.diverged, self.options.fades)) {
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

    /// Runs the scene up to the force of the frame, which [`Engine::answer`] then guards. By itself for who wants to look
    /// at a clock in between: what a stage of the guard is asked before [`Engine::answer`] still counts for this frame.
    /// A second call does nothing.
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
        self.hands.frame(&self.scene, &mut self.state, silent);
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

    /// The first half of a gesture frame: runs the scene up to the force of the frame, unless [`Engine::prepare`] did,
    /// guards it and gives the frames to send, one per device.
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

    /// The second half: the masses of the last tick move. Returns the sound of the frame, interleaved.
    pub fn finish(&mut self) -> &[f64] {
        if self.diverged {
            // time goes on, so that frames keep their numbers
            self.state.tick += 1;
        } else {
            self.advance();
        }
        self.counts.frames += 1;
        &self.sound[..self.filled]
    }

    /// The masses move.
    fn advance(&mut self) {
        if let Some(before) = &mut self.before {
            before.advance();
        }
        match &mut self.hands.pointer {
            None => integrate(&self.scene, &mut self.state),
            Some(pointer) => {
                pointer.prepare(&self.state);
                integrate(&self.scene, &mut self.state);
                pointer.apply(&mut self.state);
            }
        }
    }

    /// One tick up to its outputs. No `ca_io::player::Player`: hands and pointers move between its halves, the limit of positions is an
    /// option, and time goes on after a divergence so that frames keep their numbers.
    fn sample(&mut self) {
        let n = self.scene.counts.channels;
        if self.diverged {
            self.state.output.fill(0.0);
            // the tick of the frame's last sample moves in `finish`
            self.state.tick += u64::from(self.filled > 0);
        } else {
            self.hands.tick(&self.scene, &mut self.state);
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

    /// H15: whether positions are still those of an instrument.
    fn watch(&mut self) {
        if !self.diverged && !self.state.is_bounded(self.options.diverged) {
            self.diverged = true;
        }
    }

    /// The numbers it was made with.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Whether the model has diverged.
    pub fn has_diverged(&self) -> bool {
        self.diverged
    }
}
