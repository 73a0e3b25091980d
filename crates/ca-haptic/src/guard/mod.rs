//! The guard: what stands between a model and a hand.
//!
//! Decides on one ordered chain per device, a stage a file, each taking and giving a [`Hand`]; the order is here and
//! nowhere else. A stage that a profile or a scene does not ask for is not in the chain. Nothing allocates, locks or
//! panics after [`Chain::new`], and everything counts frames, never a clock: a take replays it bit for bit.
//!
//! ```text
//! input (before the model) → finite → workspace → passivity → oscillation → thermal → saturation → gate → slew
//! ```
//!
//! The gate (arming, fade-in, latched faults, damped stop) stands before the slew limit rather than after it, so that
//! the last stage is the one whose promise |ΔF| ≤ limit a watcher on the wire can hold us to. A fault goes to zero at
//! once. Velocity, staleness and a model that blew up trip from wherever they are noticed: [`Hand::trip`]. The TTL is
//! stamped on the frame by the engine.

pub mod finite;
pub mod gate;
pub mod input;
pub mod saturation;
pub mod slew;

use crate::frame::{Cause, DOF, Mode};
use crate::profile::Profile;

/// One device during one frame, on its way through the chain.
#[derive(Clone, Debug)]
pub struct Hand {
    /// degrees of freedom
    pub n: usize,
    /// seconds a frame
    pub te: f64,
    /// gesture frames since the engine began
    pub frame: u64,
    /// a good frame of the device came since the last one
    pub fresh: bool,
    /// frames since the last good one
    pub age: u32,
    /// the device says its positions are metres
    pub calibrated: bool,
    /// position \[m\], of the device
    pub x: [f64; DOF],
    /// motion since the last frame \[m\]
    pub moved: [f64; DOF],
    /// speed \[m/s\], a mean over about a millisecond
    pub v: [f64; DOF],
    /// force on the hand \[N\]; what each stage changes
    pub force: [f64; DOF],
    /// what was sent with the frame before \[N\]
    pub sent: [f64; DOF],
    /// largest damping injected \[N s/m\]
    pub inject: f64,
    /// bits of [`flag`](crate::frame::flag) so far
    pub flags: u32,
    /// how the force is meant, written by the gate
    pub mode: Mode,
    /// why it is off, written by the gate
    pub cause: Cause,
    /// what went wrong in this frame; the first cause stays
    pub tripped: Cause,
}

impl Hand {
    /// A device of `n` degrees of freedom at frames of `te` seconds, at rest and off.
    pub fn new(n: usize, te: f64) -> Hand {
        Hand {
            n: n.min(DOF),
            te,
            frame: 0,
            fresh: false,
            age: u32::MAX,
            calibrated: false,
            x: [0.0; DOF],
            moved: [0.0; DOF],
            v: [0.0; DOF],
            force: [0.0; DOF],
            sent: [0.0; DOF],
            inject: 0.0,
            flags: 0,
            mode: Mode::Off,
            cause: Cause::Disarmed,
            tripped: Cause::None,
        }
    }

    /// Something is wrong: forces end with this frame, and stay off until somebody arms again.
    pub fn trip(&mut self, cause: Cause) {
        if self.tripped == Cause::None {
            self.tripped = cause;
        }
    }

    /// Length of a force vector of `axes` neighbouring DOF that begins at `at` \[N\].
    pub fn length(&self, at: usize, axes: usize) -> f64 {
        norm(&self.force[at..(at + axes).min(self.n)])
    }
}

/// Length of a vector; of one component, exactly its size.
pub fn norm(v: &[f64]) -> f64 {
    if let [x] = v { x.abs() } else { v.iter().map(|x| x * x).sum::<f64>().sqrt() }
}

/// One stage of the chain.
pub trait Stage: Send {
    /// What it is called in reports.
    fn name(&self) -> &'static str;
    /// Takes and gives a hand; called once a frame, also while forces are off.
    fn pass(&mut self, hand: &mut Hand);
    /// What was sent in the end, for stages that keep books; called once a frame after the whole chain.
    fn sent(&mut self, hand: &Hand) {
        let _ = hand;
    }
    /// Forgets the past, when somebody arms.
    fn reset(&mut self);
}

/// What a person or program asks of a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// forces on, once nothing pushes; ends a fault
    Arm,
    /// forces off
    Disarm,
    /// a fault from outside, e.g. the model blew up
    Trip(Cause),
}

/// The stages of one device, in order.
pub struct Chain {
    stages: Vec<Box<dyn Stage>>,
    gate: gate::Gate,
    slew: slew::Slew,
}

impl Chain {
    /// The chain a profile asks for, at frames of `te` seconds.
    pub fn new(profile: &Profile, te: f64) -> Chain {
        let stages: Vec<Box<dyn Stage>> =
            vec![Box::new(finite::Finite), Box::new(saturation::Saturation::new(profile))];
        Chain { stages, gate: gate::Gate::new(profile, te), slew: slew::Slew::new(profile, te) }
    }

    /// Arms, disarms or trips.
    pub fn order(&mut self, order: Order) {
        if order == Order::Arm {
            for s in &mut self.stages {
                s.reset();
            }
            self.slew.reset();
        }
        self.gate.order(order);
    }

    /// Passes a frame; afterwards `hand.force` may go to the hand.
    pub fn pass(&mut self, hand: &mut Hand) {
        for s in &mut self.stages {
            s.pass(hand);
        }
        self.gate.pass(hand);
        self.slew.pass(hand);
        for s in &mut self.stages {
            s.sent(hand);
        }
        hand.sent = hand.force;
    }

    /// Whether somebody armed it, and no fault ended that.
    pub fn is_armed(&self) -> bool {
        self.gate.is_armed()
    }

    /// Names of the stages, in order.
    pub fn names(&self) -> Vec<&'static str> {
        self.stages.iter().map(|s| s.name()).chain([self.gate.name(), self.slew.name()]).collect()
    }
}
