//! One device in the engine: the ports of the scene that its DOF move, its guard, and its force frame.

use super::mean_force::{MeanForce, is_slower};
use crate::calibration::Calibration;
use crate::equivalence::Gains;
use crate::frame::{Cause, DOF, DeviceFrame, ForceFrame, Mode, flag, status};
use crate::guard::input::{FrameVerdict, InputValidator};
use crate::guard::{Chain, GuardFrame};
use crate::profile::Profile;
use ca_core::internal::scene::Coupling;
use ca_core::{InputRole, Scene, State};

/// A degree of freedom of a device, and the port of the scene that it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Degree of freedom of the device.
    pub dof: usize,
    /// Index into [`State::input`].
    pub input: usize,
    /// Index into [`PortState::border`](ca_core::internal::state::PortState::border).
    pub border: usize,
    /// Gains between the real and the simulated world.
    pub gains: Gains,
}

/// The device of a port, and its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Name of the device, as in the model.
    pub device: String,
    /// Profile of the device.
    pub profile: Profile,
    /// Conversion from readings of the device to metres, and from newtons to its units.
    pub calibration: Calibration,
    /// Gains of each DOF; DOF beyond the list have gain 1.
    pub gains: Vec<Gains>,
}

/// A device in an engine.
pub struct Port {
    /// Name of the device.
    pub name: String,
    /// Profile of the device.
    pub profile: Profile,
    /// Guard.
    pub chain: Chain,
    /// Frame in progress.
    pub hand: GuardFrame,
    /// Last force frame.
    pub out: ForceFrame,
    /// Links from DOF to ports of the scene.
    pub links: Vec<Link>,
    validator: InputValidator,
    calibration: Calibration,
    /// Force of each link in the previous frame \[N\], in the scene.
    last: Vec<f64>,
    /// Frames of the engine per frame of the device.
    pace: u32,
    /// Largest motion of a port in one frame, and while it approaches a device that appears \[m, real\].
    reach: f64,
    gentle: f64,
    /// DOF that move a port, one bit each.
    used: u32,
    /// Flags of each frame: `COUPLED` if the scene couples a key of the device.
    flags: u32,
    /// For a coupled device that is slower than the engine.
    mean_force: Option<MeanForce>,
    /// Position of each DOF in the scene \[m, real\].
    there: [f64; DOF],
}

/// Returns the keys of a device that are coupled in this scene, with their stiffness at the hand \[N/m\].
pub fn coupled<'s>(scene: &'s Scene, device: &str) -> Vec<(&'s str, f64)> {
    let of = |c: &'s Coupling| {
        scene.ports.tgr.iter().find_map(|p| {
            let input = &scene.inputs[p.input as usize];
            let mine = input.device.as_ref().is_some_and(|d| d.0 == device);
            let same = mine && scene.mat_name(p.mat as usize) == c.port;
            same.then(|| (c.port.as_str(), c.device_stiffness * input.gains.stiffness()))
        })
    };
    scene.hand.couplings.iter().filter_map(of).collect()
}

impl Port {
    /// Makes the port of a device, with the inputs of `scene` that name it.
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
                // only MIDI and gestures move the others
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
        // a device slower than the engine moves farther in one frame
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

    pub(super) fn take(&mut self, frame: &DeviceFrame) -> FrameVerdict {
        let mut real = *frame;
        self.calibration.positions(&mut real.pos);
        if self.calibration.axis.len() >= self.profile.dof as usize {
            // the positions are metres now, whatever the device reports
            real.status |= status::CALIBRATED;
        }
        self.validator.take(&real, &mut self.hand)
    }

    /// Moves the ports of the scene towards the hand, once a frame before its first tick. They move no faster than a
    /// hand can, and approach a device that appears elsewhere gently, so that its appearance does not cause a blow.
    pub(super) fn place(&mut self, state: &mut State) {
        self.validator.update(&mut self.hand);
        if self.hand.age == u32::MAX {
            return;
        }
        self.hand.arrived |= !self.used;
        for k in (0..self.hand.n).filter(|k| self.used >> k & 1 == 1) {
            let reach = if self.hand.arrived >> k & 1 == 1 { self.reach } else { self.gentle };
            let step = self.hand.x[k] - self.there[k];
            // exactly at the hand, if it is within reach or has passed this position
            if step.abs() < reach || step * (step - self.hand.moved[k]) < 0.0 {
                self.there[k] = self.hand.x[k];
                self.hand.arrived |= 1 << k;
            } else {
                self.there[k] += step.clamp(-reach, reach);
            }
        }
        for l in &self.links {
            state.input[l.input] = l.gains.alpha * self.there[l.dof];
        }
    }

    /// Returns true if the device has sent a frame and moves this input of the scene.
    pub(super) fn speaks_for(&self, input: usize) -> bool {
        self.hand.age != u32::MAX && self.links.iter().any(|l| l.input == input)
    }

    /// Returns true if the device has sent frames, and the next one is overdue.
    pub(super) fn is_stale(&self) -> bool {
        self.hand.age != u32::MAX && self.hand.age >= self.pace
    }

    /// Guards the force of the frame and writes the force frame.
    pub(super) fn answer(&mut self, scene: &Scene, state: &State, session: u64, diverged: bool) {
        let hand = &mut self.hand;
        hand.force = [0.0; DOF];
        (hand.received, hand.mean) = ([0.0; DOF], [0.0; DOF]);
        hand.flags = self.flags;
        hand.inject = 0.0;
        for (l, last) in self.links.iter().zip(&mut self.last) {
            let b = &state.ports.border[l.border];
            // force on the hand = +β · force on the port (docs/numerics.md §6); several ports of one DOF add up
            hand.force[l.dof] += l.gains.beta * b.force;
            // with one tick per frame, the mean of two forces gives the exact power (docs/numerics.md §5.1)
            let mean = if scene.rates.ratio == 1 { 0.5 * (*last + b.force) } else { b.force };
            *last = b.force;
            hand.mean[l.dof] += l.gains.beta * mean;
            hand.received[l.dof] -= l.gains.beta / l.gains.alpha * mean * (b.to - b.from);
        }
        if let Some(mean) = &mut self.mean_force {
            mean.pass(&mut hand.force[..hand.n], hand.is_new);
        }
        if diverged {
            // a force that is not finite is the more specific cause
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
        hand.is_new = false;
        hand.tripped = Cause::None;
    }

    /// Restarts the approach to the device, from its position in the state `initial`.
    pub(super) fn reach_again(&mut self, initial: &State) {
        for l in &self.links {
            self.there[l.dof] = initial.input[l.input] / l.gains.alpha;
        }
        self.hand.arrived = 0;
        self.last.fill(0.0);
        self.mean_force = self.mean_force.as_ref().map(|_| MeanForce::new());
    }

    /// Continues from the state of another port of the same device.
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

    /// Fades out the last force of `before`, instead of ending it in one frame.
    pub(super) fn fade_from(&mut self, before: &Port) {
        if matches!(before.hand.mode, Mode::Ramp | Mode::On | Mode::Damp) {
            self.hand.sent = before.hand.sent;
            self.chain.fade_out();
        }
    }

    /// Returns the number of frames dropped by the input checks.
    pub fn dropped(&self) -> u64 {
        self.validator.dropped
    }
}
