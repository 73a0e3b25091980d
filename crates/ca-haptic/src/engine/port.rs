//! One device as the engine sees it: which of its DOF move which ports of the scene, its guard, its force frame.

use super::mean_force::{MeanForce, is_slower};
use crate::calibration::Calibration;
use crate::equivalence::Gains;
use crate::frame::{Cause, DOF, DeviceFrame, ForceFrame, Mode, flag, status};
use crate::guard::input::{FrameVerdict, InputValidator};
use crate::guard::{Chain, GuardFrame};
use crate::profile::Profile;
use ca_core::internal::scene::Coupling;
use ca_core::{InputRole, Scene, State};

/// A degree of freedom of a device, and the port of the scene it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// degree of freedom of the device
    pub dof: usize,
    /// place in [`State::input`]
    pub input: usize,
    /// place in [`PortState::border`](ca_core::internal::state::PortState::border)
    pub border: usize,
    /// between the real and the simulated world
    pub gains: Gains,
}

/// What makes a port: a device and the choices that go with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// name of the device, as in the model
    pub device: String,
    /// its numbers
    pub profile: Profile,
    /// from what the device says to metres, and from newtons to what it takes
    pub calibration: Calibration,
    /// of each of its DOF; the unit where shorter
    pub gains: Vec<Gains>,
}

/// A device in an engine.
pub struct Port {
    /// name of the device
    pub name: String,
    /// its numbers
    pub profile: Profile,
    /// its guard
    pub chain: Chain,
    /// the frame under way
    pub hand: GuardFrame,
    /// the last force frame
    pub out: ForceFrame,
    /// what moves what
    pub links: Vec<Link>,
    validator: InputValidator,
    calibration: Calibration,
    /// force of each link in the frame before \[N\], of the scene
    last: Vec<f64>,
    /// frames of the engine from one frame of the device to the next
    pace: u32,
    /// the farthest a port of the scene follows in a frame, and on its way to a device that appears \[m\], real
    reach: f64,
    gentle: f64,
    /// DOF that move something, a bit each
    used: u32,
    /// flags of every frame: whether the scene couples a key of it
    flags: u32,
    /// of a coupled device that is slower than the engine
    mean_force: Option<MeanForce>,
    /// where the scene has each DOF \[m\], real
    there: [f64; DOF],
}

/// Keys of a device that are coupled in this scene, with what is felt of them in the hand \[N/m\].
pub fn coupled<'s>(scene: &'s Scene, device: &str) -> Vec<(&'s str, f64)> {
    let of = |c: &'s Coupling| {
        scene.ports.tgr.iter().find_map(|p| {
            let input = &scene.inputs[p.input as usize];
            let mine = input.device.as_ref().is_some_and(|d| d.0 == device);
            let same = mine && scene.mat_name(p.mat as usize) == c.port;
            same.then(|| (c.port.as_str(), c.felt * input.gains.stiffness()))
        })
    };
    scene.hand.couplings.iter().filter_map(of).collect()
}

impl Port {
    /// The port of a device, with the inputs of `scene` that name it.
    pub fn new(scene: &Scene, setup: Setup) -> Port {
        let frame_dt = f64::from(scene.rates.ratio) * scene.rates.sample_dt;
        let Setup { device, profile, calibration, gains } = setup;
        let n = profile.dof as usize;
        let mut links = Vec::new();
        for (border, p) in scene.ports.tgr.iter().enumerate() {
            let input = p.input as usize;
            let i = &scene.inputs[input];
            if i.role != InputRole::Device {
                continue;
            }
            if let Some((_, dof)) = i.device.as_ref().filter(|d| d.0 == device) {
                let dof = *dof as usize;
                // others are moved by MIDI and gestures alone
                if dof < n.min(DOF) {
                    links.push(Link { dof, input, border, gains: gains.get(dof).copied().unwrap_or_default() });
                }
            }
        }
        let mut out = ForceFrame::new(&device, n);
        out.ttl_us = (profile.guard.ttl * 1e6) as u32;
        out.calibration = calibration.id();
        let mut there = [0.0; DOF];
        for l in &links {
            there[l.dof] = scene.inputs[l.input].rest / l.gains.alpha;
        }
        // a device slower than the engine moves farther at once
        let frame = frame_dt.max(1.0 / profile.rate);
        let couples = !coupled(scene, &device).is_empty();
        Port {
            chain: Chain::new(&profile, frame_dt),
            validator: InputValidator::new(&profile, frame_dt),
            hand: GuardFrame::new(n, frame_dt),
            reach: 2.0 * profile.guard.speed * frame,
            gentle: (profile.range[1] - profile.range[0]) / profile.guard.approach * frame_dt,
            pace: (1.0 / (profile.rate * frame_dt)).ceil().clamp(1.0, 1e9) as u32,
            used: links.iter().fold(0, |u, l| u | 1 << l.dof),
            flags: if couples { flag::COUPLED } else { 0 },
            mean_force: (couples && is_slower(&profile, frame_dt)).then(MeanForce::new),
            last: vec![0.0; links.len()],
            name: device,
            profile,
            out,
            links,
            calibration,
            there,
        }
    }

    /// A frame that came from the device.
    pub(super) fn take(&mut self, frame: &DeviceFrame) -> FrameVerdict {
        let mut real = *frame;
        self.calibration.positions(&mut real.pos);
        if self.calibration.axis.len() >= self.profile.dof as usize {
            // counts of a sensor are metres from here on, whatever the device knows of them
            real.status |= status::CALIBRATED;
        }
        self.validator.take(&real, &mut self.hand)
    }

    /// Once a frame, before its first tick: moves the ports of the scene towards the hand. They follow no faster than a
    /// hand can move; and to a device that appears somewhere else they go gently, so that its appearance does not strike.
    pub(super) fn place(&mut self, state: &mut State) {
        self.validator.update(&mut self.hand);
        if self.hand.age == u32::MAX {
            return;
        }
        self.hand.met |= !self.used;
        for k in (0..self.hand.n).filter(|k| self.used >> k & 1 == 1) {
            let reach = if self.hand.met >> k & 1 == 1 { self.reach } else { self.gentle };
            let step = self.hand.x[k] - self.there[k];
            // exactly the hand where it can be reached, or came by
            if step.abs() < reach || step * (step - self.hand.moved[k]) < 0.0 {
                self.there[k] = self.hand.x[k];
                self.hand.met |= 1 << k;
            } else {
                self.there[k] += step.clamp(-reach, reach);
            }
        }
        for l in &self.links {
            state.input[l.input] = l.gains.alpha * self.there[l.dof];
        }
    }

    /// True where the device has spoken and moves this input of the scene.
    pub(super) fn speaks_for(&self, input: usize) -> bool {
        self.hand.age != u32::MAX && self.links.iter().any(|l| l.input == input)
    }

    /// True where the device is there and its next frame did not come when it was due.
    pub(super) fn is_stale(&self) -> bool {
        self.hand.age != u32::MAX && self.hand.age >= self.pace
    }

    /// The force of the frame, through the guard, onto the wire.
    pub(super) fn answer(&mut self, scene: &Scene, state: &State, session: u64, diverged: bool) {
        let hand = &mut self.hand;
        hand.force = [0.0; DOF];
        (hand.received, hand.mean) = ([0.0; DOF], [0.0; DOF]);
        hand.flags = self.flags;
        hand.inject = 0.0;
        for (l, last) in self.links.iter().zip(&mut self.last) {
            let b = &state.ports.border[l.border];
            // +β · force on the port, which is that on the hand (docs/numerics.md §6); several ports of one DOF add
            hand.force[l.dof] += l.gains.beta * b.force;
            // at one rate the force is that of a tick, and power is exact by the mean of two (docs/numerics.md §5.1)
            let mean = if scene.rates.ratio == 1 { 0.5 * (*last + b.force) } else { b.force };
            *last = b.force;
            hand.mean[l.dof] += l.gains.beta * mean;
            hand.received[l.dof] -= l.gains.beta / l.gains.alpha * mean * (b.to - b.from);
        }
        if let Some(mean) = &mut self.mean_force {
            mean.pass(&mut hand.force[..hand.n], hand.fresh);
        }
        if diverged {
            // a force that is not finite says more than that the model diverged
            if hand.force[..hand.n].iter().any(|f| !f.is_finite()) {
                hand.trip(Cause::Nonfinite);
            }
            hand.trip(Cause::ModelUnstable);
            (hand.force, hand.received, hand.mean) = ([0.0; DOF], [0.0; DOF], [0.0; DOF]);
        }
        self.chain.pass(hand);
        let (ack_session, ack) = self.validator.ack();
        let out = &mut self.out;
        (out.session, out.ack_session, out.ack) = (session, ack_session, ack);
        out.seq += 1;
        out.tick = state.tick;
        (out.mode, out.cause, out.flags) = (hand.mode as u32, hand.cause as u16, hand.flags);
        out.inject = hand.inject as f32;
        for k in 0..hand.n {
            out.force[k] = hand.force[k] as f32;
        }
        self.calibration.forces(&mut out.force);
        hand.frame += 1;
        hand.fresh = false;
        hand.tripped = Cause::None;
    }

    /// After a reload the scene has its devices at rest again.
    pub(super) fn reach_again(&mut self, initial: &State) {
        for l in &self.links {
            self.there[l.dof] = initial.input[l.input] / l.gains.alpha;
        }
        self.hand.met = 0;
        self.last.fill(0.0);
        self.mean_force = self.mean_force.as_ref().map(|_| MeanForce::new());
    }

    /// Goes on from where another port of the same device is.
    pub(super) fn follow(&mut self, before: &Port) {
        self.out = ForceFrame { ttl_us: self.out.ttl_us, n: self.out.n, ..before.out };
        self.hand.frame = before.hand.frame;
        self.there = before.there;
        for (to, from) in self.last.iter_mut().zip(&before.last) {
            *to = *from;
        }
        self.validator.dropped = before.validator.dropped;
        if let (Some(to), Some(from)) = (&mut self.mean_force, &before.mean_force) {
            *to = from.clone();
        }
    }

    /// The force that `before` sent last fades out, rather than end in a frame; a fault goes on as one.
    pub(super) fn fade_from(&mut self, before: &Port) {
        if matches!(before.hand.mode, Mode::Ramp | Mode::On | Mode::Damp) {
            self.hand.sent = before.hand.sent;
            self.chain.fade_out();
        }
    }

    /// Frames the input checks dropped.
    pub fn dropped(&self) -> u64 {
        self.validator.dropped
    }
}
