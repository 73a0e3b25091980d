//! The guard limits every force between a model and a hand, and decides when forces may begin.
//!
//! Each device has one ordered chain of stages, a file per stage. Each stage changes a [`GuardFrame`]; only this file
//! defines their order. A stage that the profile does not ask for is left out. After [`Chain::new`] nothing allocates,
//! locks or panics, and times are counts of frames, never a clock: a take replays the chain bit for bit.
//!
//! ```text
//! input (before the model) → finite → workspace → saturation → passivity → oscillation → thermal → gate → slew
//! ```
//!
//! The largest force comes before the stages that weaken: weakening 800 N would have no effect if the next stage cut
//! the force to 10 N. No stage after it makes a vector longer (the passivity stage cuts its own sum). The gate (arming,
//! fade-in, latched faults, damped stop) stands before the slew limit, so that the last stage guarantees |ΔF| ≤ limit
//! on the wire, where it can be checked; only off and fault are zero at once. The names H1 to H18 in the headers of
//! stages are the requirements of docs/safety.md.
//!
//! A fault sets the force to zero at once. The input check, `finite` and a diverged model trip it by [`GuardFrame::trip`];
//! the gate itself finds excess velocity and stale frames. The result is rounded towards zero to the single precision of the wire, so that
//! rounding exceeds no limit and the ledgers hold the values sent. The engine stamps the TTL on the frame.

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

/// One device during one frame, as it passes through the chain.
#[derive(Clone, Debug)]
pub struct GuardFrame {
    /// Degrees of freedom.
    pub n: usize,
    /// Length of a frame \[s\].
    pub frame_dt: f64,
    /// Engine frames (periods of the gesture rate) since the engine began.
    pub frame: u64,
    /// True if a good frame of the device came since the last one.
    pub is_new: bool,
    /// Engine frames since the last good frame of the device.
    pub age: u32,
    /// Frames since the last one of any kind, dropped ones included.
    pub silent: u32,
    /// True if the last good frame reported `CALIBRATED` and `POWERED`, and not `BRAKE`.
    pub calibrated: bool,
    /// DOF at whose position the scene arrived after the device appeared, a bit each; set for DOF that the scene lacks.
    pub arrived: u32,
    /// Position of the device \[m\].
    pub x: [f64; DOF],
    /// Motion since the last frame \[m\].
    pub moved: [f64; DOF],
    /// Speed, averaged over a few frames of the device \[m/s\].
    pub v: [f64; DOF],
    /// Energy that the model received during this frame through its mean force, in units of the hand \[J\].
    pub received: [f64; DOF],
    /// Mean force of the model on the hand in this frame, with the same limits: the ideal rate boundary \[N\].
    pub mean: [f64; DOF],
    /// Force on the hand, changed by each stage \[N\].
    pub force: [f64; DOF],
    /// Force sent with the frame before \[N\].
    pub sent: [f64; DOF],
    /// Number of the force frame that the device held during its motion, from 1; 0 where it does not report one.
    pub ack: u64,
    /// Age of that force frame in frames; 1 where the device does not report one.
    pub ago: u64,
    /// Force held by the device \[N\]; where it does not report one, the force sent with the frame before.
    pub acting: [f64; DOF],
    /// Force that the passivity stage added \[N\].
    pub injected: [f64; DOF],
    /// Largest injected damping \[N s/m\].
    pub inject: f64,
    /// Bits of [`flag`](crate::frame::flag) set so far.
    pub flags: u32,
    /// Mode of the force, written by the gate; before it, the mode of the frame before.
    pub mode: Mode,
    /// Reason why forces are off, written by the gate.
    pub cause: Cause,
    /// First fault of this frame.
    pub tripped: Cause,
}

impl GuardFrame {
    /// Makes a frame for a device of `n` degrees of freedom at `frame_dt` seconds a frame, at rest and off.
    pub fn new(n: usize, frame_dt: f64) -> GuardFrame {
        GuardFrame {
            n: n.min(DOF),
            frame_dt,
            frame: 0,
            is_new: false,
            age: u32::MAX,
            silent: u32::MAX,
            calibrated: false,
            arrived: 0,
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

    /// Records a fault: forces end with this frame, and stay off until the device is armed again.
    pub fn trip(&mut self, cause: Cause) {
        if self.tripped == Cause::None {
            self.tripped = cause;
        }
    }

    /// Returns the length of the force vector over `axes` neighbouring DOF from `at` \[N\].
    pub fn length(&self, at: usize, axes: usize) -> f64 {
        norm(&self.force[at..(at + axes).min(self.n)])
    }
}

/// Returns the length of a vector; for one component exactly its magnitude.
pub fn norm(v: &[f64]) -> f64 {
    if let [x] = v { x.abs() } else { v.iter().map(|x| x * x).sum::<f64>().sqrt() }
}

/// Rounds `f` towards zero to single precision; 0 if it is not finite.
fn wired(f: f64) -> f64 {
    // clears the 29 bits that single precision lacks
    let cut = f64::from_bits(f.to_bits() & !((1 << 29) - 1)) as f32;
    if cut.is_finite() { f64::from(cut) } else { 0.0 }
}

/// One stage of the chain.
pub trait Stage: Send {
    /// Returns its name in reports.
    fn name(&self) -> &'static str;
    /// Changes the frame; called once a frame, also while forces are off.
    fn pass(&mut self, hand: &mut GuardFrame);
    /// Records the force finally sent, for stages with ledgers; called once a frame after the whole chain.
    fn sent(&mut self, hand: &GuardFrame) {
        let _ = hand;
    }
}

/// Order from a person or program to a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Turns forces on, once nothing pushes; ends a fault.
    Arm,
    /// Turns forces off.
    Disarm,
    /// Raises a fault from outside, e.g. of a model that diverged.
    Trip(Cause),
}

/// The stages of one device, in order.
pub struct Chain {
    /// Energy that the hand gave, and where it went.
    pub ledger: ledger::HandLedger,
    finite: finite::Finite,
    stages: Vec<Box<dyn Stage>>,
    gate: gate::Gate,
    slew: slew::Slew,
    /// Last forces sent, a ring by the number of their frame \[N\].
    past: Box<[[f64; DOF]; PAST]>,
}

/// Number of forces stored until the device reports which of them it held.
const PAST: usize = 32;

impl Chain {
    /// Builds the chain that a profile asks for, at `frame_dt` seconds a frame.
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

    /// Passes a frame; afterwards `hand.force` may be sent to the device.
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

    /// Fades out the force sent last, which came from another scene.
    pub fn fade_out(&mut self) {
        self.gate.fade_out();
    }

    /// Returns the number of faults that latched so far.
    pub fn faults(&self) -> u64 {
        self.gate.faults()
    }

    /// Returns what kept forces from beginning in the last frame.
    pub fn wait(&self) -> wait::Wait {
        self.gate.wait()
    }

    /// Returns true if the chain was armed, and no fault ended that.
    pub fn is_armed(&self) -> bool {
        self.gate.is_armed()
    }

    /// Returns the names of the stages, in order.
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
