//! The loop through a simulated hand, against docs/numerics.md §5.2 and §5.3. `crates/ca-haptic/tests/passivity` tests
//! the passivity stage in this loop.
//!
//! Lock-step: the position at the end of a frame is answered before the next begins. A spring has the delay of its mean
//! force and of the hold: κ = 1 (1/2 at one rate). One frame of delay at the device models a reply over shared memory,
//! used at its next tick: κ = 2.

use super::{FRAME_DT, KEY, Rig, bare, force, mode};
use crate::play::{case, off, rows, within};
use ca_haptic::frame::{Mode, flag};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_haptic::simulated::{Device, Hand, Script, ScriptOptions};

fn e02() -> Profile {
    let mut p = bare();
    (p.body.mass, p.body.friction) = (0.2, 2.0);
    p
}

struct Loop {
    rig: Rig,
    device: Device,
    force: f64,
    delay: u64,
}

impl Loop {
    fn new(text: &str, p: &Profile, script: Script, delay: usize) -> Loop {
        let device = Device::new(p, Hand::NONE, script, delay, 1);
        let mut rig = Rig::new(text, p.clone());
        rig.on(device.measured().to_vec().as_slice());
        Loop { rig, device, force: 0.0, delay: delay as u64 }
    }

    /// Runs a frame with an additional force `kick`. Returns position, force and flags.
    fn step(&mut self, kick: f64) -> (f64, f64, u32) {
        let x = self.device.step(&[self.force + kick], FRAME_DT)[0];
        // acknowledges the force the motors had: from the last frame or earlier
        self.rig.next.ack = self.rig.engine.ports[0].out.seq - self.delay;
        let f = self.rig.go(&[x]);
        self.force = force(&f);
        (x, self.force, f.flags)
    }
}

/// Returns true if a key of stiffness `k` oscillates with growing amplitude after a nudge.
fn grows(k: f64, rate: &str, delay: usize) -> bool {
    let text = format!("[rate]\n{rate}\n{}", KEY.replace("500", &format!("{k:e}")));
    let mut l = Loop::new(&text, &e02(), Script::Push { force: 0.0 }, delay);
    let mut most = [0.0f64; 2];
    for n in 0..6000 {
        let (x, ..) = l.step(if n == 0 { 1.0 } else { 0.0 });
        if (1000..2000).contains(&n) {
            most[0] = most[0].max(x.abs());
        } else if n >= 5000 {
            most[1] = most[1].max(x.abs());
        }
    }
    assert!(most[0] > 0.0);
    most[1] > most[0]
}

#[test]
fn e02_the_stiffest_key_is_that_of_theory() {
    let case = case("E02");
    let want: Vec<f64> = rows(case, "values/rows").iter().map(|r| r[1]).collect();
    let (one, border) = ("sound = 3000\ngesture = 3000", "");
    for (what, rate, delay, k) in [
        ("one rate, κ = 1/2", one, 0, want[0]),
        ("linear and mean, κ = 1", border, 0, want[1]),
        ("one rate and a reply at the next tick, κ = 3/2", one, 1, want[3]),
        ("linear and mean, a reply at the next tick, κ = 2", border, 1, want[4]),
    ] {
        let (mut lo, mut hi) = (0.9 * k, 1.1 * k);
        assert!(!grows(lo, rate, delay) && grows(hi, rate, delay), "{what}: {k}");
        while hi / lo > 1.001 {
            let middle = 0.5 * (lo + hi);
            *(if grows(middle, rate, delay) { &mut hi } else { &mut lo }) = middle;
        }
        within(what, off(0.5 * (lo + hi), k), 0.003);
    }
}

/// A key pressed with 2 N against a wall of stiffness `k` for five seconds. Returns the peak-to-peak motion \[m\] of
/// every half second, and the final leak \[J\].
fn pressed(k: f64) -> (Vec<f64>, f64) {
    let key = KEY.replace("[RES]", "[BUT]");
    let text = key.replace("[\"key\", \"wall\"], k = 500", &format!("[\"wall\", \"key\"], k = {k:e}"));
    let mut p = e02();
    p.force = 100.0;
    let mut l = Loop::new(&text, &p, Script::Push { force: 0.0 }, 0);
    let mut swing = Vec::new();
    for _ in 0..10 {
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for _ in 0..1500 {
            let (x, ..) = l.step(-2.0);
            (low, high) = (low.min(x), high.max(x));
        }
        swing.push(high - low);
    }
    let ledger = &l.rig.engine.ports[0].chain.ledger;
    (swing, ledger.received[0] - ledger.hand_work[0])
}

#[test]
fn a_pressed_wall_shakes_as_theory_says() {
    // K = 20 000 is above the limit of 6007 of this device: the 2970 µm of docs/numerics.md §5.3, known to three digits
    let (swing, made) = pressed(20_000.0);
    within("K = 20 000", off(swing[9], 2970e-6), 0.005);
    assert!(made > 0.1, "{made} J");
    // K = 5500 is below: ringing that decays at (b − K T)/2m, past the reference of 602 µm within a second
    let (swing, _) = pressed(5500.0);
    assert!(swing[0] > 602e-6 && swing[1] < 602e-6, "{swing:?}");
    let rate = (2.0 - 5500.0 * FRAME_DT) / 0.4;
    // over four seconds; peaks sampled twice per period of 38 ms are half a percent of that, and the rate is of first
    // order in ωT = 0.055
    within("its decay", off((swing[1] / swing[9]).ln() / 4.0, rate), 0.02);
}

#[test]
fn h13_a_shaking_loop_is_weakened_and_says_so() {
    // 40 kN/m needs 13 N s/m at κ = 1, but the device has 2: without the controller it oscillates at the force limit
    let mut p = super::profile(|p| {
        p.guard.passivity = false;
        (p.guard.edge, p.guard.speed) = (0.0, 5.0);
        (p.body.step, p.body.noise) = (0.0, 0.0);
    });
    p.guard.slew = Some(1e6);
    let text = KEY.replace("500", "40000");
    let mut l = Loop::new(&text, &p, Script::Push { force: 0.0 }, 0);
    let (mut weak, mut most) = (None, [0.0f64; 2]);
    for n in 0..3000 {
        let (_, f, flags) = l.step(if n == 0 { 1.0 } else { 0.0 });
        if flags & flag::OSCILLATION != 0 && weak.is_none() {
            weak = Some(n);
        }
        let late = usize::from(weak.is_some_and(|w| n > w + 10));
        most[late] = most[late].max(f.abs());
    }
    assert!(weak.is_some_and(|n| n >= 150), "{weak:?}");
    assert!(most[0] > 9.9 && most[1] <= 3.0 + 1e-9, "{most:?}");
}

#[test]
fn every_script_can_be_played_on_every_device() {
    for name in ["tgr12", "falcon", "firefader"] {
        let p = Profile::shipped(name).expect("shipped");
        for script in ca_haptic::simulated::SCRIPTS {
            let middle = 0.5 * (p.range[0] + p.range[1]);
            let hand = if script == "push" { Hand::NONE } else { Hand::finger(p.force, &p) };
            let s = Script::named(script, &p, ScriptOptions::default()).expect("a script");
            let mut device = Device::new(&p, hand, s, 0, 1);
            let text = KEY.replace("500", "2").replace("dof = 0", &format!("dof = 0, x = {middle}"));
            let mut rig = Rig::new(&text.replace("wall = {}", &format!("wall = {{ x = {middle} }}")), p.clone());
            rig.order(Order::Arm);
            let ratio = (3000.0 / p.rate).round() as u32;
            let (mut force, mut on) = ([0.0; 3], false);
            for n in 0..9000 {
                if n % ratio == 0 {
                    device.step(&force[..p.dof.min(3) as usize], f64::from(ratio) * FRAME_DT);
                    device.frame(&mut rig.next);
                    let mut f = rig.next;
                    rig.engine.take(0, &mut f);
                }
                let f = rig.frame();
                force = [0, 1, 2].map(|k| f64::from(f.force[k]));
                on |= mode(&f) == Mode::On;
                // a push without a hand ends in a fast motion, which trips as intended
                assert!(script == "push" || mode(&f) != Mode::Fault, "{name}, {script}: frame {n}");
            }
            assert!(on || script == "push", "{name}, {script}: forces never on");
        }
    }
}
