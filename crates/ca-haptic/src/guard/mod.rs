//! The guard: what stands between a model and a hand.
//!
//! Decides on one ordered chain per device, a stage a file, each taking and giving a [`GuardFrame`]; the order is here and
//! nowhere else. A stage that a profile does not ask for is not in the chain. Nothing allocates, locks or panics after
//! [`Chain::new`], and everything counts frames, never a clock: a take replays it bit for bit.
//!
//! ```text
//! input (before the model) → finite → workspace → saturation → passivity → oscillation → thermal → gate → slew
//! ```
//!
//! The largest force comes before the stages that weaken: a gain on 800 N that the next stage cuts to 10 N would weaken
//! nothing. None of those after it makes a vector longer (the passivity stage cuts its own sum). The gate (arming,
//! fade-in, latched faults, damped stop) stands before the slew limit rather than after it, so that the last stage is
//! the one whose promise |ΔF| ≤ limit a watcher on the wire can hold us to. A fault goes to zero at once. Velocity,
//! staleness and a model that diverged trip from wherever they are noticed: [`GuardFrame::trip`]. What leaves is rounded
//! towards zero to the single precision of the wire, so that rounding passes no limit and the ledgers know what was sent.
//! The TTL is stamped on the frame by the engine.

pub mod finite;
pub mod gate;
pub mod input;
pub mod ledger;
pub mod oscillation;
pub mod passivity;
pub mod saturation;
pub mod slew;
pub mod thermal;
pub mod wait;
pub mod workspace;

use crate::frame::{Cause, DOF, Mode};
use crate::profile::Profile;

/// One device during one frame, on its way through the chain.
#[derive(Clone, Debug)]
pub struct GuardFrame {
    /// degrees of freedom
    pub n: usize,
    /// seconds a frame
    pub frame_dt: f64,
    /// gesture frames since the engine began
    pub frame: u64,
    /// a good frame of the device came since the last one
    pub fresh: bool,
    /// frames since the last good one
    pub age: u32,
    /// frames since the last one of any kind, also one that was dropped
    pub silent: u32,
    /// the device says its positions are metres
    pub calibrated: bool,
    /// DOF that the scene has where they are, a bit each, those it has not at all included: it goes there gently when a
    /// device appears
    pub met: u32,
    /// position \[m\], of the device
    pub x: [f64; DOF],
    /// motion since the last frame \[m\]
    pub moved: [f64; DOF],
    /// speed \[m/s\], a mean over a few frames of the device
    pub v: [f64; DOF],
    /// energy the model received during this frame, by its mean force \[J\] in the measure of the hand
    pub received: [f64; DOF],
    /// mean force of the model on the hand during this frame \[N\], cut as the force is: what the boundary should have given
    pub mean: [f64; DOF],
    /// force on the hand \[N\]; what each stage changes
    pub force: [f64; DOF],
    /// what was sent with the frame before \[N\]
    pub sent: [f64; DOF],
    /// number of the force frame the device held during its motion, from 1; 0 where it does not say
    pub ack: u64,
    /// how many frames ago it was sent; 1 where the device does not say
    pub ago: u64,
    /// that force \[N\]; where the device does not say, what was sent with the frame before
    pub acting: [f64; DOF],
    /// force that the passivity stage added \[N\]
    pub injected: [f64; DOF],
    /// largest damping injected \[N s/m\]
    pub inject: f64,
    /// bits of [`flag`](crate::frame::flag) so far
    pub flags: u32,
    /// how the force is meant, written by the gate; before it, that of the frame before
    pub mode: Mode,
    /// why it is off, written by the gate
    pub cause: Cause,
    /// what went wrong in this frame; the first cause stays
    pub tripped: Cause,
}

impl GuardFrame {
    /// A device of `n` degrees of freedom at frames of `frame_dt` seconds, at rest and off.
    pub fn new(n: usize, frame_dt: f64) -> GuardFrame {
        GuardFrame {
            n: n.min(DOF),
            frame_dt,
            frame: 0,
            fresh: false,
            age: u32::MAX,
            silent: u32::MAX,
            calibrated: false,
            met: 0,
            x: [0.0; DOF],
            moved: [0.0; DOF],
            v: [0.0; DOF],
            received: [0.0; DOF],
            mean: [0.0; DOF],
            force: [0.0; DOF],
            sent: [0.0; DOF],
            ack: 0,
            ago: 1,
            acting: [0.0; DOF],
            injected: [0.0; DOF],
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

/// A number that the wire holds exactly, no larger than `f`; 0 for what is not finite.
fn wired(f: f64) -> f64 {
    // the 29 bits that single precision does not have
    let cut = f64::from_bits(f.to_bits() & !((1 << 29) - 1)) as f32;
    if cut.is_finite() { f64::from(cut) } else { 0.0 }
}

/// One stage of the chain.
pub trait Stage: Send {
    /// What it is called in reports.
    fn name(&self) -> &'static str;
    /// Takes and gives a hand; called once a frame, also while forces are off.
    fn pass(&mut self, hand: &mut GuardFrame);
    /// What was sent in the end, for stages that keep ledgers; called once a frame after the whole chain.
    fn sent(&mut self, hand: &GuardFrame) {
        let _ = hand;
    }
}

/// What a person or program asks of a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// forces on, once nothing pushes; ends a fault
    Arm,
    /// forces off
    Disarm,
    /// a fault from outside, e.g. the model diverged
    Trip(Cause),
}

/// The stages of one device, in order.
pub struct Chain {
    /// what the hand gave, and what became of it
    pub ledger: ledger::HandLedger,
    finite: finite::Finite,
    /// those a profile may leave out, and the largest force
    stages: Vec<Box<dyn Stage>>,
    gate: gate::Gate,
    slew: slew::Slew,
    /// the last forces sent \[N\], a ring by the number of their frame
    past: Box<[[f64; DOF]; PAST]>,
}

/// Forces that are remembered until the device says which of them it held.
const PAST: usize = 32;

impl Chain {
    /// The chain a profile asks for, at frames of `frame_dt` seconds.
    pub fn new(profile: &Profile, frame_dt: f64) -> Chain {
        fn boxed<S: Stage + 'static>(s: S) -> Box<dyn Stage> {
            Box::new(s)
        }
        let stages = [
            workspace::Workspace::new(profile).map(boxed),
            Some(boxed(saturation::Saturation::new(profile))),
            passivity::Passivity::new(profile, frame_dt).map(boxed),
            oscillation::Oscillation::new(profile, frame_dt).map(boxed),
            thermal::Thermal::new(profile, frame_dt).map(boxed),
        ];
        Chain {
            ledger: ledger::HandLedger::default(),
            finite: finite::Finite,
            stages: stages.into_iter().flatten().collect(),
            gate: gate::Gate::new(profile, frame_dt),
            slew: slew::Slew::new(profile, frame_dt),
            past: Box::new([[0.0; DOF]; PAST]),
        }
    }

    /// Arms, disarms or trips.
    pub fn order(&mut self, order: Order) {
        self.gate.order(order);
    }

    /// Passes a frame; afterwards `hand.force` may go to the hand.
    pub fn pass(&mut self, hand: &mut GuardFrame) {
        let ago = (hand.frame + 1).saturating_sub(hand.ack);
        let known = hand.ack > 0 && (1..=PAST as u64).contains(&ago);
        hand.ago = if known { ago } else { 1 };
        hand.acting = if known { self.past[hand.ack as usize % PAST] } else { hand.sent };
        self.finite.pass(hand);
        self.ledger.frame(hand);
        for s in &mut self.stages {
            s.pass(hand);
        }
        self.gate.pass(hand);
        self.slew.pass(hand);
        hand.force[..hand.n].iter_mut().for_each(|f| *f = wired(*f));
        for s in &mut self.stages {
            s.sent(hand);
        }
        hand.sent = hand.force;
        self.past[(hand.frame + 1) as usize % PAST] = hand.force;
    }

    /// The force that was sent last fades out: another scene made it.
    pub fn fade_out(&mut self) {
        self.gate.fade_out();
    }

    /// Faults that latched so far.
    pub fn faults(&self) -> u64 {
        self.gate.faults()
    }

    /// What kept forces from beginning in the last frame.
    pub fn wait(&self) -> wait::Wait {
        self.gate.wait()
    }

    /// Whether somebody has armed it, and no fault ended that.
    pub fn is_armed(&self) -> bool {
        self.gate.is_armed()
    }

    /// Names of the stages, in order.
    pub fn names(&self) -> Vec<&'static str> {
        let own = self.stages.iter().map(|s| s.name());
        [self.finite.name()].into_iter().chain(own).chain([self.gate.name(), self.slew.name()]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_nobody_asks_for_is_not_there() {
        let full = "finite workspace saturation passivity oscillation thermal gate slew";
        let mut p = Profile::shipped("tgr12").expect("shipped");
        p.continuous = Some(3.0);
        let names = |p: &Profile| Chain::new(p, 1.0 / 3000.0).names().join(" ");
        assert_eq!(names(&p), full);
        p.continuous = None;
        assert_eq!(names(&p), full.replace("thermal ", ""));
        (p.guard.passivity, p.guard.oscillation, p.guard.edge) = (false, false, 0.0);
        assert_eq!(names(&p), "finite saturation gate slew");
        // no motors, no forces to guard
        let mouse = Profile::shipped("mouse").expect("shipped");
        assert_eq!(names(&mouse), "finite saturation gate slew");
    }

    #[test]
    fn the_wire_rounds_towards_zero() {
        for f in [0.1, -0.1, 1.0 / 3.0, 2.0, 1.56, -10.0, 1e-30, 1e-320] {
            let w = wired(f);
            assert!(w.abs() <= f.abs() && f64::from(w as f32) == w, "{f} {w}");
            assert!((w - f).abs() <= 1.2e-7 * f.abs() + 1e-45, "{f} {w}");
        }
        assert_eq!([f64::NAN, f64::INFINITY].map(wired), [0.0, 0.0]);
    }
}
