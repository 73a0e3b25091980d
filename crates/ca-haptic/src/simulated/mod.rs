//! Simulated device, for `ca device sim` and tests.
//!
//! The motion is exact between frames rather than integrated in small steps. A mass with viscous and dry friction moves
//! between end stops, under a force held over the frame. The hand is a mass, a spring and a damper around the intention
//! of the player. A loop that shakes therefore does so only for the reasons of docs/numerics.md §5.2. Imperfections of
//! the hardware are added: steps and noise of the sensor, steps of the force, frames of delay. The device uses no clock
//! and no transport; the same seed and forces give the same positions.

mod body;
mod script;

pub use script::{Intention, SCRIPTS, Script, ScriptOptions};

use crate::frame::{DOF, DeviceFrame, status, uid};
use crate::profile::Profile;
use body::Mechanics;

/// Hand on a device, for each degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Stiffness around the intended position \[N/m\].
    pub stiffness: f64,
    /// Viscosity around the intended position \[N s/m\].
    pub damping: f64,
    /// Mass that moves with the device \[kg\].
    pub mass: f64,
}

impl Hand {
    /// No hand.
    pub const NONE: Hand = Hand { stiffness: 0.0, damping: 0.0, mass: 0.0 };

    /// Returns a finger that holds a device against up to `force` newtons.
    ///
    /// That force displaces it by a tenth of the travel. It is critically damped, with its own 20 g and the device's
    /// mass.
    pub fn finger(force: f64, profile: &Profile) -> Hand {
        let travel = profile.range[1] - profile.range[0];
        let (stiffness, mass) = ((force / (0.1 * travel)).max(100.0), 0.02);
        Hand { stiffness, damping: 2.0 * (stiffness * (mass + profile.body.mass)).sqrt(), mass }
    }
}

/// A simulated device.
pub struct Device {
    n: usize,
    mechanics: Mechanics,
    hand: Hand,
    script: Script,
    step: f64,
    noise: f64,
    force_step: f64,
    most: f64,
    rng: Random,
    /// Position \[m\] and speed \[m/s\] of each DOF.
    state: [[f64; 2]; DOF],
    measured: [f64; DOF],
    /// Forces of the motors in the last frame \[N\].
    held: [f64; DOF],
    /// Delayed forces \[N\], a ring.
    late: Vec<[f64; DOF]>,
    turn: usize,
    time: f64,
    /// Time at which the script began \[s\].
    begin: f64,
    frames: u64,
    frame_dt: f64,
}

impl Device {
    /// Makes a device with this profile and hand that plays `script`, from the position in which the script starts.
    ///
    /// `delay` is the number of frames until a force reaches the motors.
    pub fn new(profile: &Profile, hand: Hand, script: Script, delay: usize, seed: u64) -> Device {
        let b = &profile.body;
        let n = (profile.dof as usize).min(DOF);
        let mechanics = Mechanics { mass: b.mass + hand.mass, friction: b.friction, dry: b.dry, range: profile.range };
        let mut state = [[0.0; 2]; DOF];
        for (k, s) in state.iter_mut().enumerate().take(n) {
            s[0] = script.at(k, 0.0).position.clamp(profile.range[0], profile.range[1]);
        }
        let mut device = Device {
            n,
            mechanics,
            hand,
            script,
            step: b.step,
            noise: b.noise,
            force_step: b.force_step,
            most: profile.force,
            rng: Random(seed | 1),
            state,
            measured: [0.0; DOF],
            held: [0.0; DOF],
            late: vec![[0.0; DOF]; delay],
            turn: 0,
            time: 0.0,
            begin: 0.0,
            frames: 0,
            frame_dt: 0.0,
        };
        device.measure();
        device
    }

    /// Simulates a frame of `frame_dt` seconds under forces \[N\], clipped by the motors. Returns the readings \[m\].
    pub fn step(&mut self, force: &[f64], frame_dt: f64) -> &[f64] {
        let mut now = [0.0; DOF];
        for (to, f) in now.iter_mut().zip(force).take(self.n) {
            *to = if f.is_finite() { f.clamp(-self.most, self.most) } else { 0.0 };
            if self.force_step > 0.0 {
                *to = (*to / self.force_step).round() * self.force_step;
            }
        }
        if !self.late.is_empty() {
            core::mem::swap(&mut now, &mut self.late[self.turn]);
            self.turn = (self.turn + 1) % self.late.len();
        }
        self.held = now;
        for (k, now) in now.iter().enumerate().take(self.n) {
            let t = self.time - self.begin;
            let (a, b) = (self.script.at(k, t), self.script.at(k, t + frame_dt));
            let drive = body::Drive {
                force: now + 0.5 * (a.force + b.force),
                from: a.position,
                to: b.position,
                stiffness: self.hand.stiffness,
                damping: self.hand.damping,
            };
            self.state[k] = self.mechanics.go(self.state[k], &drive, frame_dt);
        }
        self.frames += 1;
        (self.time, self.frame_dt) = (self.time + frame_dt, frame_dt);
        self.measure();
        &self.measured[..self.n]
    }

    /// Restarts the script at the present time.
    pub fn begin(&mut self) {
        self.begin = self.time;
    }

    fn measure(&mut self) {
        for k in 0..self.n {
            let noise = if self.noise > 0.0 { self.noise * self.rng.normal() } else { 0.0 };
            let x = self.state[k][0] + noise;
            self.measured[k] = if self.step > 0.0 { (x / self.step).round() * self.step } else { x };
        }
    }

    /// Returns the sensor readings \[m\].
    pub fn measured(&self) -> &[f64] {
        &self.measured[..self.n]
    }

    /// Returns the forces of the motors in the last frame \[N\].
    pub fn held(&self) -> &[f64] {
        &self.held[..self.n]
    }

    /// Returns the true position \[m\] and speed \[m/s\] of a degree of freedom.
    pub fn truth(&self, k: usize) -> [f64; 2] {
        self.state[k]
    }

    /// Returns the simulated time \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Writes the readings to the next frame of a session, begun by the caller with [`DeviceFrame::new`].
    ///
    /// The caller sets [`DeviceFrame::ack`] to the number of the force frame that it passed to the last
    /// [`Device::step`].
    pub fn frame(&self, to: &mut DeviceFrame) {
        to.seq += 1;
        to.n = self.n as u16;
        to.status |= status::SIMULATED | status::CONNECTED | status::POWERED | status::CALIBRATED;
        to.t_device_ns = (self.time * 1e9).round() as u64;
        to.period_ns = (self.frame_dt * 1e9).round() as u32;
        to.pos[..self.n].copy_from_slice(&self.measured[..self.n]);
        for (to, held) in to.force_measured.iter_mut().zip(&self.held).take(self.n) {
            *to = *held as f32;
        }
        let [low, high] = self.mechanics.range;
        let at_end = self.state[..self.n].iter().any(|s| s[0] <= low || s[0] >= high);
        to.status = if at_end { to.status | status::EDGE } else { to.status & !status::EDGE };
        if to.device == [0; 16] {
            to.device = uid("simulated");
        }
    }
}

/// Deterministic random numbers: xorshift, two of them for a normal one.
struct Random(u64);

impl Random {
    /// Returns a uniform number in 0 … 1, exclusive.
    fn even(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    /// Returns a normal number of mean 0 and deviation 1 (Box and Muller).
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.even().ln()).sqrt();
        radius * (std::f64::consts::TAU * self.even()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> Profile {
        let mut p = Profile::shipped("tgr12").expect("shipped");
        (p.body.step, p.body.noise) = (0.0, 0.0);
        p
    }

    #[test]
    fn the_same_seed_gives_the_same_bits() {
        let p = Profile::shipped("firefader").expect("shipped");
        let run = |seed| {
            let script = Script::named("bow", &p, ScriptOptions::default()).expect("a script");
            let mut noisy = p.clone();
            noisy.body.noise = 1e-4;
            let mut d = Device::new(&noisy, Hand::finger(1.0, &noisy), script, 1, seed);
            (0..500).flat_map(|_| d.step(&[0.1, -0.1], 0.002).to_vec()).map(f64::to_bits).collect::<Vec<_>>()
        };
        assert_eq!(run(7), run(7));
        assert_ne!(run(7), run(8));
    }

    #[test]
    fn a_script_that_begins_later_is_the_same_later() {
        let p = plain();
        let run = |wait: u32| {
            let script = Script::named("strike", &p, ScriptOptions::default()).expect("a script");
            let mut d = Device::new(&p, Hand::finger(10.0, &p), script, 0, 1);
            for _ in 0..wait {
                assert_eq!(d.step(&[], 1.0 / 1024.0)[0], 0.0, "it waits where it rests");
                d.begin();
            }
            (0..3000).map(|_| d.step(&[], 1.0 / 1024.0)[0]).collect::<Vec<_>>()
        };
        let (now, later) = (run(0), run(5000));
        assert!(now.iter().zip(&later).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(now.iter().any(|x| *x < -0.005));
    }

    #[test]
    fn sensor_and_motor_have_steps_and_delay() {
        let mut p = plain();
        (p.body.step, p.body.force_step, p.force) = (1e-4, 0.5, 10.0);
        let push = |delay: usize, f: f64, n: usize| {
            let mut d = Device::new(&p, Hand::NONE, Script::Push { force: 0.0 }, delay, 1);
            for _ in 0..n {
                let x = d.step(&[f], 1.0 / 3000.0)[0];
                assert!((x / 1e-4 - (x / 1e-4).round()).abs() < 1e-6);
            }
            d.truth(0)
        };
        assert_eq!(push(0, 0.2, 30), [0.0; 2], "less than half a step of force is none");
        assert_eq!(push(0, 0.6, 30), push(0, 0.5, 30));
        assert_eq!(push(0, 1e9, 30), push(0, 10.0, 30), "no more than the motors have");
        assert_eq!(push(0, f64::NAN, 30), [0.0; 2]);
        assert_eq!(push(4, 1.0, 4), [0.0; 2]);
        assert_eq!(push(4, 1.0, 34), push(0, 1.0, 30));
    }

    #[test]
    fn noise_is_as_loud_as_said() {
        let mut p = plain();
        p.body.noise = 1e-5;
        let mut d = Device::new(&p, Hand::NONE, Script::Push { force: 0.0 }, 0, 3);
        let n = 20_000;
        let x: Vec<f64> = (0..n).map(|_| d.step(&[0.0], 1.0 / 3000.0)[0]).collect();
        let mean = x.iter().sum::<f64>() / f64::from(n);
        let rms = (x.iter().map(|x| x * x).sum::<f64>() / f64::from(n)).sqrt();
        // four standard errors
        assert!(mean.abs() < 4.0 * 1e-5 / f64::from(n).sqrt(), "{mean}");
        assert!((rms / 1e-5 - 1.0).abs() < 4.0 / f64::from(2 * n).sqrt(), "{rms}");
    }

    #[test]
    fn frames_count_and_tell_the_time() {
        let p = plain();
        let mut d = Device::new(&p, Hand::NONE, Script::Push { force: 1.0 }, 0, 1);
        let mut f = DeviceFrame::new("key", 12);
        d.frame(&mut f);
        assert_eq!((f.seq, f.t_device_ns, f.pos[0]), (1, 0, 0.0));
        for _ in 0..3000 {
            d.step(&[], 1.0 / 3000.0);
        }
        d.frame(&mut f);
        assert_eq!((f.seq, f.t_device_ns, f.period_ns), (2, 1_000_000_000, 333_333));
        // pushed against its stop
        assert_eq!(f.pos[0], 0.01);
        assert!(f.status & status::EDGE != 0 && f.has_this_layout());
    }
}
