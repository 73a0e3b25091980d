//! A device in a loop with a key: the greatest stiffness of the key before the hand is shaken.
//!
//! The axes are dimensionless. K T/b is the delay of one gesture period T against the friction of the device. b T/m is
//! the share of its speed that this friction takes away in a period. Theory is the exact characteristic polynomial of a
//! mass with friction under a held force, and of the filter H(z) of the rate boundary (docs/numerics.md §5.2). The
//! Schur–Cohn criterion tests it. The passivity bound K T/b = 1/κ, valid for any mass, is drawn thin.
//!
//! Some maps play the rate boundary alone, with the device beside it. Others play the whole device loop: frames,
//! engine, guard and a simulated device.

use super::{Axis, Line, Map, growth};
use crate::scene;
use ca_core::{Scene, tick};
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::{Engine, EngineCommand, Options, Port, Setup};
use ca_haptic::frame::{DeviceFrame, ForceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_haptic::simulated::{Device, Hand, Script};
use std::sync::Arc;

/// Length of a gesture period \[s\].
const FRAME_DT: f64 = 1.0 / 3000.0;
/// Friction of the device \[N s/m\].
const B: f64 = 2.0;
/// Frames per run.
const FRAMES: usize = 2000;
/// Initial force \[N\]: far below the limits of the guard, and far above rounding.
const KICK: f64 = 1e-6;

/// Returns a device of `beta` = b T/m without limits that arms immediately.
pub(super) fn device(beta: f64) -> Profile {
    let mut p = Profile::shipped("tgr12").expect("shipped");
    (p.dof, p.force, p.range) = (1, 1e9, [-1e3, 1e3]);
    p.body.mass = B * FRAME_DT / beta;
    (p.body.friction, p.body.dry, p.body.step, p.body.noise, p.body.force_step) = (B, 0.0, 0.0, 0.0, 0.0);
    let l = &mut p.guard;
    (l.speed, l.slew, l.edge, l.passivity, l.oscillation) = (1e4, Some(1e15), 0.0, false, false);
    (l.clear_time, l.ramp) = (FRAME_DT, FRAME_DT);
    p
}

/// Compiles a key on a spring of `kt` = K T/b.
pub(super) fn key(rate: &str, kt: f64) -> Scene {
    let k = kt * B / FRAME_DT;
    let text = format!(
        "[rate]\n{rate}\n[TGR]\nkey = {{ device = \"key\", dof = 0 }}\n[SOL]\nwall = {{}}\n[RES]\n\
         spring = {{ between = [\"key\", \"wall\"], k = {k:?} }}\n[SOX]\nout = {{ from = \"key\" }}\n"
    );
    scene(&text)
}

/// An engine with one device, forces on.
pub(super) struct Rig {
    /// Engine.
    pub engine: Engine,
    frame: DeviceFrame,
}

impl Rig {
    /// Arms at 0, without a force on the key.
    pub(super) fn new(scene: Scene, profile: Profile) -> Rig {
        let setup = Setup { device: "key".into(), profile, calibration: Calibration::default(), gains: vec![] };
        let scene = Arc::new(scene);
        let port = Port::new(&scene, setup);
        let mut frame = DeviceFrame::new("key", 1);
        frame.session = 7;
        let mut rig = Rig { engine: Engine::new(scene, vec![port], Options::default()), frame };
        rig.engine.command(EngineCommand::Order(None, Order::Arm));
        let on = (0..100).any(|_| rig.go(0, |_| ()).mode == Mode::On as u32);
        assert!(on, "forces are not on");
        rig
    }

    /// Sends a frame that answers the force of `delay` frames ago, modified by `change`, and returns the answer.
    pub(super) fn go(&mut self, delay: u64, change: impl FnOnce(&mut DeviceFrame)) -> ForceFrame {
        self.frame.seq += 1;
        self.frame.t_device_ns += (FRAME_DT * 1e9) as u64;
        self.frame.ack = self.engine.ports[0].out.seq.saturating_sub(delay);
        let mut sent = self.frame;
        change(&mut sent);
        self.engine.take(0, &mut sent);
        let out = *self.engine.answer().next().expect("one device");
        self.engine.finish();
        out
    }
}

/// Returns the motion of the device in the frame after a force of [`KICK`] \[m\].
fn unit(beta: f64) -> f64 {
    KICK / B * FRAME_DT * beta.min(1.0)
}

/// Tests the rate boundary with a device beside it.
fn border_grows(rate: &str, kt: f64, beta: f64) -> bool {
    let scene = key(rate, kt);
    let (mut s, profile) = (scene.state(), device(beta));
    let mut device = Device::new(&profile, Hand::NONE, Script::Push { force: 0.0 }, 0, 1);
    // the tick that ends a frame is the first of the next
    tick(&scene, &mut s);
    let mut force = KICK;
    let step = || {
        let x = device.step(&[force], FRAME_DT)[0];
        s.input[0] = x;
        (0..scene.rates.ratio).for_each(|_| tick(&scene, &mut s));
        force = s.ports.border[0].force;
        x.abs() / unit(beta)
    };
    growth(FRAMES, step) > GROWN
}

/// Tests the whole loop, with a force that is `delay` frames late.
fn loop_grows(rate: &str, delay: usize, kt: f64, beta: f64) -> bool {
    let profile = device(beta);
    let mut device = Device::new(&profile, Hand::NONE, Script::Push { force: 0.0 }, delay, 1);
    let mut rig = Rig::new(key(rate, kt), profile);
    let mut force = KICK;
    let step = || {
        let x = device.step(&[force], FRAME_DT)[0];
        force = f64::from(rig.go(delay as u64, |f| f.pos[0] = x).force[0]);
        x.abs() / unit(beta)
    };
    growth(FRAMES, step) > GROWN
}

/// Ratio of peaks beyond which the loop grows. A period has tens of frames, so peaks of a steady oscillation agree to a
/// thousandth.
const GROWN: f64 = 1.01;

/// Rate boundary as a filter: the force that answers a position, divided by K, as coefficients of powers of 1/z.
type Filter = &'static [f64];

const HALF: Filter = &[1.0];
const ONE: Filter = &[0.5, 0.5];
const LATE: Filter = &[0.0, 1.0];
const LATER: Filter = &[0.0, 0.5, 0.5];

/// Returns true if the loop has a root outside the unit circle: (z − 1)(z − e^−β) z^n + (K T/b)(g₁ z + g₀) z^n H = 0.
fn unstable(h: Filter, kt: f64, beta: f64) -> bool {
    let (fade, n) = ((-beta).exp(), h.len() - 1);
    // motion in a period under a held force, over its final speed
    let lag = (1.0 - fade) / beta;
    let (g1, g0) = (1.0 - lag, lag - fade);
    // coefficients, the constant first
    let mut p = vec![0.0; n + 3];
    (p[n], p[n + 1], p[n + 2]) = (fade, -(1.0 + fade), 1.0);
    for (i, h) in h.iter().enumerate() {
        p[n - i] += kt * g0 * h;
        p[n - i + 1] += kt * g1 * h;
    }
    // Schur–Cohn: in this polynomial and all that follow, the first coefficient is smaller than the last
    while p.len() > 1 {
        let m = p.len() - 1;
        let (first, last) = (p[0], p[m]);
        if first.abs() >= last.abs() {
            return true;
        }
        p = (1..=m).map(|i| last * p[i] - first * p[m - i]).collect();
    }
    false
}

/// Returns K T/b at the stability boundary of a loop with this filter, for a device of `beta`.
fn boundary(h: Filter, beta: f64) -> f64 {
    let (mut low, mut high) = (1e-3, 20.0);
    while high - low > 1e-9 {
        let middle = 0.5 * (low + high);
        *(if unstable(h, middle, beta) { &mut high } else { &mut low }) = middle;
    }
    low
}

/// Returns the theoretical boundary of E02 for the loops of κ = 1/2, 1, 3/2, 2: K T/b at this b T/m.
pub fn limit(kappa: f64, beta: f64) -> f64 {
    let h = [HALF, ONE, LATE, LATER][(2.0 * kappa) as usize - 1];
    boundary(h, beta)
}

fn lines(h: Filter, kappa: f64) -> Vec<Line> {
    let [low, high] = AXES[1].ends;
    let edge = Line::curve(low, high, |e| [boundary(h, 10f64.powf(e)), 10f64.powf(e)]);
    vec![edge, Line::rule([1.0 / kappa, 10f64.powf(low)], [1.0 / kappa, 10f64.powf(high)])]
}

const AXES: [Axis; 2] = [Axis::of("K T/b", 0.0, 4.0), Axis::log("b T/m", -1.5, 1.0)];

/// A key whose position is a straight line over each frame.
pub const LINEAR: Map = Map {
    name: "border_linear",
    title: "A device at a key: linear position, mean force",
    text: "A mass m with friction b under a force held for a gesture period T, on a TGR with a spring K; sixteen \
           ticks to a period, `border = \"linear\"`. H = K (1 + 1/z)/2: passive below K T/b = 1 for any device \
           (thin), stable up to the line. It starts from a small displacement; it grows if its amplitude rises.",
    axes: AXES,
    words: ["comes to rest", "shakes"],
    measured: |kt, beta| border_grows("", kt, beta),
    theory: |kt, beta| Some(unstable(ONE, kt, beta)),
    lines: || lines(ONE, 1.0),
    band: 0.02,
};

/// A key whose position jumps.
pub const HOLD: Map = Map {
    name: "border_hold",
    title: "A device at a key: held position, mean force at the jump",
    text: "The same with `border = \"hold\"`. The force is the mean of the forces before and after the jump, so H is \
           the same.",
    measured: |kt, beta| border_grows("border = \"hold\"", kt, beta),
    ..LINEAR
};

/// The same rate for gesture and sound.
pub const LOOP_HALF: Map = Map {
    name: "loop_half",
    title: "The device loop at one rate, κ = 1/2",
    text: "The engine as it serves a device: frames, input checks, guard and force frames, with a simulated device in \
           lock-step. Gesture and sound at 3 kHz, H = K: passive below K T/b = 2.",
    axes: [Axis::of("K T/b", 0.0, 8.0), AXES[1]],
    measured: |kt, beta| loop_grows("sound = 3000\ngesture = 3000", 0, kt, beta),
    theory: |kt, beta| Some(unstable(HALF, kt, beta)),
    lines: || lines(HALF, 0.5),
    ..LINEAR
};

/// Default rates and boundary.
pub const LOOP_ONE: Map = Map {
    name: "loop_one",
    title: "The device loop at 3 and 48 kHz, κ = 1",
    text: "The default rates and border. Passive below K T/b = 1.",
    measured: |kt, beta| loop_grows("", 0, kt, beta),
    ..LINEAR
};

/// One rate, with a force used one frame later.
pub const LOOP_LATE: Map = Map {
    name: "loop_late",
    title: "The device loop at one rate, the force one frame late, κ = 3/2",
    text: "As over shared memory, where a device uses the answer at its next tick: H = K/z. Passive below K T/b = \
           2/3.",
    measured: |kt, beta| loop_grows("sound = 3000\ngesture = 3000", 1, kt, beta),
    theory: |kt, beta| Some(unstable(LATE, kt, beta)),
    lines: || lines(LATE, 1.5),
    ..LINEAR
};

/// Default rates and boundary over shared memory.
pub const LOOP_LATER: Map = Map {
    name: "loop_later",
    title: "The device loop at 3 and 48 kHz, the force one frame late, κ = 2",
    text: "The default border and a force used one frame late, as in a device process. Passive below K \
           T/b = 1/2.",
    measured: |kt, beta| loop_grows("", 1, kt, beta),
    theory: |kt, beta| Some(unstable(LATER, kt, beta)),
    lines: || lines(LATER, 2.0),
    ..LINEAR
};
