//! The guard between a model and a hand: one test per requirement and per cause, fuzzed frames and forces, and the loop
//! of a simulated device against theory. Time is counted in frames, without a clock.

mod causes;
mod energy;
mod fuzz;
mod loops;
mod reconnection;
mod requirements;
mod slow;

use crate::play::with;
use ca_compile::Options as Compile;
use ca_haptic::engine::{Engine, EngineCommand, Options, Port, Setup};
use ca_haptic::equivalence::Gains;
use ca_haptic::frame::{Cause, DeviceFrame, ForceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::guard::input::FrameVerdict;
use ca_haptic::profile::Profile;
pub use ca_tests::{KEY, profile};
use std::sync::Arc;

/// Gesture frame at the default rates \[s\].
pub const FRAME_DT: f64 = 1.0 / 3000.0;

/// A device without limits that arms within two frames and renders the forces of the model.
pub fn bare() -> Profile {
    profile(|p| {
        (p.force, p.range) = (1e9, [-1e3, 1e3]);
        (p.body.step, p.body.noise) = (0.0, 0.0);
        let l = &mut p.guard;
        (l.speed, l.slew, l.edge, l.passivity, l.oscillation) = (1e4, Some(1e15), 0.0, false, false);
        (l.clear_time, l.ramp) = (FRAME_DT, FRAME_DT);
    })
}

/// An engine with one device, and the next frame of that device.
pub struct Rig {
    pub engine: Engine,
    pub next: DeviceFrame,
    /// Sound of the last frame.
    pub sound: Vec<f64>,
}

impl Rig {
    pub fn new(text: &str, profile: Profile) -> Rig {
        Rig::with(text, profile, vec![], false)
    }

    pub fn with(text: &str, profile: Profile, gains: Vec<Gains>, energy: bool) -> Rig {
        let scene = Arc::new(with(text, &Compile { energy, ..Compile::default() }).scene);
        let mut next = DeviceFrame::new("key", profile.dof as usize);
        next.session = 7;
        let setup = Setup { gains, ..ca_tests::setup("key", profile) };
        let port = Port::new(&scene, setup);
        assert!(!port.links.is_empty(), "the device moves nothing");
        Rig { engine: Engine::new(scene, vec![port], Options::default()), next, sound: vec![] }
    }

    pub fn order(&mut self, order: Order) {
        assert!(self.engine.command(EngineCommand::Order(None, order)).is_none());
    }

    pub fn send(&mut self, x: &[f64]) -> FrameVerdict {
        self.next.seq += 1;
        self.next.t_device_ns += (FRAME_DT * 1e9) as u64;
        self.next.pos[..x.len()].copy_from_slice(x);
        let mut f = self.next;
        self.engine.take(0, &mut f)
    }

    /// Runs a gesture frame.
    pub fn frame(&mut self) -> ForceFrame {
        let out = *self.engine.answer().next().expect("one device");
        self.sound = self.engine.finish().to_vec();
        out
    }

    pub fn go(&mut self, x: &[f64]) -> ForceFrame {
        self.send(x);
        self.frame()
    }

    /// Arms at `x`, where the model must not push, and waits until forces are fully on.
    pub fn on(&mut self, x: &[f64]) -> ForceFrame {
        self.order(Order::Arm);
        (0..6000).map(|_| self.go(x)).find(|f| mode(f) == Mode::On).expect("forces on within two seconds")
    }

    /// Moves to `x` in a straight line over `n` frames, then rests for three.
    pub fn glide(&mut self, x: f64, n: u32) -> ForceFrame {
        let from = self.next.pos[0];
        let mut out = ForceFrame::new("key", 1);
        for i in 1..=n {
            self.go(&[from + (x - from) * f64::from(i) / f64::from(n)]);
        }
        for _ in 0..3 {
            out = self.go(&[x]);
        }
        out
    }
}

pub fn mode(f: &ForceFrame) -> Mode {
    Mode::read(f.mode)
}

pub fn cause(f: &ForceFrame) -> Cause {
    Cause::read(f.cause)
}

pub fn force(f: &ForceFrame) -> f64 {
    f64::from(f.force[0])
}

pub fn is_off(f: &ForceFrame, why: Cause) -> bool {
    mode(f) == Mode::Fault && cause(f) == why && f.force.iter().all(|f| *f == 0.0)
}
