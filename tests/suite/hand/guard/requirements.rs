//! H1 to H11, H15 and H16, one by one. H12 and H13 are in `loops.rs`, H14 is in `causes.rs`.

use super::{FRAME_DT, KEY, Rig, bare, cause, force, is_off, mode, profile};
use crate::play::within;
use ca_haptic::engine::{EngineCommand, Retired};
use ca_haptic::equivalence::Gains;
use ca_haptic::frame::{Cause, Mode, flag};
use ca_haptic::guard::input::FrameVerdict;
use ca_haptic::guard::{Chain, GuardFrame, Order};

const EXPLODING: &str = include_str!("../../../models/exploding_resonator.ca.toml");

/// Three axes of one force vector, each on its own spring.
pub const STYLUS: &str = r#"
[TGR]
x = { device = "key", dof = 0 }
y = { device = "key", dof = 1 }
z = { device = "key", dof = 2 }
[SOL]
wall = {}
[RES]
a = { between = ["x", "wall"], k = 1e4 }
b = { between = ["y", "wall"], k = 2e4 }
c = { between = ["z", "wall"], k = 3e4 }
[SOX]
out = { from = "x" }
"#;

#[test]
fn h1_no_number_is_no_force_in_the_same_frame() {
    let gains = vec![Gains { alpha: 1.0, beta: f64::MAX }];
    let mut rig = Rig::with(KEY, profile(|_| {}), gains, false);
    rig.on(&[0.0]);
    assert!(is_off(&rig.glide(5e-3, 30), Cause::Nonfinite));
    let mut rig = Rig::new(KEY, profile(|_| {}));
    rig.on(&[0.0]);
    assert!(force(&rig.glide(4e-3, 60)) < -1.9);
    rig.engine.state.ports.border[0].sum = f64::NAN;
    let f = rig.go(&[4e-3]);
    assert!(is_off(&f, Cause::Nonfinite), "{f:?}");
    assert!(is_off(&rig.go(&[4e-3]), Cause::Nonfinite), "it stays");
}

#[test]
fn h2_vectors_are_cut_and_keep_their_direction() {
    let mut p = bare();
    (p.dof, p.axes, p.force) = (3, 3, 8.0);
    let mut rig = Rig::new(STYLUS, p);
    rig.on(&[0.0; 3]);
    for scale in [1e-4, 3e-4, 1e-3, 0.1, 10.0] {
        for _ in 0..3 {
            rig.go(&[scale, -scale, scale]);
        }
        let f = rig.go(&[scale, -scale, scale]);
        let v = [f.force[0], f.force[1], f.force[2]].map(f64::from);
        let want = [-1e4 * scale, 2e4 * scale, -3e4 * scale];
        let (size, full) = (norm(v), norm(want));
        assert!(size <= 8.0 && size >= full.min(8.0) * (1.0 - 1e-6), "{v:?}");
        assert_eq!(f.flags & flag::SATURATED != 0, full > 8.0);
        within("angle", angle(v, want), 1e-6);
    }
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    norm(cross) / (norm(a) * norm(b))
}

#[test]
fn h3_force_does_not_jump() {
    // 1 MN/m: 0.2 mm are 200 N, cut to the 10 N of the device; 40 kN/m times 0.5 m/s allow 6.67 N a frame
    let mut rig =
        Rig::new(&KEY.replace("500", "1e6"), profile(|p| (p.guard.oscillation, p.guard.speed) = (false, 0.5)));
    rig.on(&[0.0]);
    let (mut last, mut slowed) = (0.0, 0);
    for n in 0..300 {
        let f = rig.go(&[if n / 20 % 2 == 0 { 1e-4 } else { -1e-4 }]);
        assert_eq!(mode(&f), Mode::On);
        within("a frame", (force(&f) - last).abs(), 20_000.0 * FRAME_DT * (1.0 + 1e-6));
        slowed += u32::from(f.flags & flag::SLEWED != 0);
        last = force(&f);
    }
    assert!(slowed > 20);
}

#[test]
fn h4_motors_stay_within_their_rating() {
    let p = profile(|p| p.continuous = Some(3.0));
    let mut chain = Chain::new(&p, FRAME_DT);
    let mut hand = GuardFrame::new(1, FRAME_DT);
    (hand.calibrated, hand.arrived, hand.age) = (true, u32::MAX, 0);
    chain.order(Order::Arm);
    let (mut heat, mut worst, mut peak, mut last) = (0.0, 0.0f64, 0, 0.0);
    for n in 0..33_000 {
        (hand.force[0], hand.flags) = (if n < 3400 { 0.0 } else { 10.0 }, 0);
        chain.pass(&mut hand);
        // independent estimate: exponential mean over one second
        heat += (1.0 - (-FRAME_DT).exp()) * (hand.force[0] * hand.force[0] - heat);
        worst = worst.max(heat);
        peak += u32::from(hand.force[0] > 9.99);
        last = hand.force[0];
    }
    // −ln(1 − 0.8·9/100) of a second at the peak, then down to the rating
    assert!((200..240).contains(&peak), "{peak} frames at the peak");
    within("r.m.s. over a second", worst.sqrt(), 3.0 * (1.0 + 1e-3));
    within("in the end", (last - 3.0).abs(), 1e-3);
    assert!(hand.flags & flag::THERMAL != 0 && hand.mode == Mode::On);
    // arming again does not cool a motor
    chain.order(Order::Disarm);
    chain.order(Order::Arm);
    for n in 0..4000 {
        hand.force[0] = if n < 310 { 0.0 } else { 10.0 };
        chain.pass(&mut hand);
        assert!(hand.force[0] < 9.9, "frame {n}");
    }
}

#[test]
fn h5_forces_wait_until_nothing_pushes_and_fade_in() {
    let mut rig = Rig::new(KEY, profile(|_| {}));
    rig.order(Order::Arm);
    // inside the spring: 5 mm on 500 N/m
    for _ in 0..6000 {
        let f = rig.go(&[5e-3]);
        assert!(mode(&f) == Mode::Off && cause(&f) == Cause::None && force(&f) == 0.0);
        assert!(f.flags & flag::WAIT_CLEAR != 0);
    }
    rig.glide(9.8e-4, 50);
    // 0.49 N of 10 N counts as clear, for 0.1 s
    let from = (0..400).find(|_| mode(&rig.go(&[9.8e-4])) == Mode::Ramp).expect("a ramp");
    assert!((250..=300).contains(&from), "{from}");
    let (mut last, mut n) = (0.0, 0);
    loop {
        let f = rig.go(&[9.8e-4]);
        n += 1;
        let size = -force(&f);
        assert!(size >= last && size - last <= 0.49 / 2900.0, "{last} {size}");
        last = size;
        if mode(&f) == Mode::On {
            break;
        }
    }
    assert_eq!(n, 3000);
    within("on", (last - 0.49).abs(), 1e-6);
    // positions of an uncalibrated device never arm
    let mut rig = Rig::new(KEY, profile(|_| {}));
    rig.next.status &= !ca_haptic::frame::status::CALIBRATED;
    rig.order(Order::Arm);
    assert!((0..3000).all(|_| mode(&rig.go(&[0.0])) == Mode::Off));
}

#[test]
fn h6_h8_stale_input_fades_and_stays_off() {
    let mut rig = Rig::new(KEY, profile(|_| {}));
    rig.on(&[0.0]);
    let held = force(&rig.glide(4e-3, 60));
    within("before", (held + 2.0).abs(), 1e-6);
    let mut last = held;
    for age in 1..=40 {
        let f = rig.frame();
        assert_eq!(f.flags & flag::STALE != 0, age > 3, "age {age}");
        match age {
            1..=3 => assert_eq!(force(&f), held),
            4..=29 => assert!(mode(&f) == Mode::On && force(&f) > last, "age {age}: {last} {}", force(&f)),
            _ => assert!(is_off(&f, Cause::WatchdogIn), "age {age}"),
        }
        last = force(&f);
    }
    for _ in 0..3000 {
        assert!(is_off(&rig.go(&[0.0]), Cause::WatchdogIn), "data that return do not arm");
    }
    assert_eq!(rig.engine.counts.faults, 1);
    assert_eq!(rig.engine.counts.stale, 40);
    rig.on(&[0.0]);
    within("armed again", (force(&rig.glide(4e-3, 60)) + 2.0).abs(), 1e-6);
    rig.order(Order::Disarm);
    let f = rig.go(&[4e-3]);
    assert!(mode(&f) == Mode::Off && cause(&f) == Cause::Disarmed && force(&f) == 0.0);
}

#[test]
fn h7_every_frame_says_how_long_it_lives() {
    let mut rig = Rig::new(KEY, profile(|_| {}));
    // also before the first frame, and while off
    for n in 0..10 {
        let f = if n < 5 { rig.frame() } else { rig.go(&[0.0]) };
        assert_eq!((f.ttl_us, f.seq), (5000, n + 1));
        assert_eq!(f.ack, if n < 5 { 0 } else { n - 4 });
    }
    let mut rig = Rig::new(KEY, profile(|p| p.guard.ttl = 0.0123));
    assert_eq!(rig.frame().ttl_us, 12_300);
}

#[test]
fn h9_a_throw_is_braked_then_off() {
    let mut rig = Rig::new(KEY, profile(|p| p.range = [-10.0, 10.0]));
    rig.on(&[0.0]);
    // 1.5 m/s, 50 % above the trip
    let mut x = 0.0;
    let mut damped = 0;
    for n in 0..900 {
        x += 1.5 * FRAME_DT;
        let f = rig.go(&[x]);
        match mode(&f) {
            Mode::On => assert!(n < 4, "frame {n} at 1.5 m/s"),
            Mode::Damp => {
                damped += 1;
                assert_eq!(cause(&f), Cause::Velocity);
                if damped > 4 {
                    within("−b v", (force(&f) + 5.0 * 1.5).abs(), 1e-5);
                }
            }
            _ => assert!(is_off(&f, Cause::Velocity)),
        }
    }
    // 200 ms; their last frame is already zero
    assert_eq!(damped, 599);
}

#[test]
fn h10_frames_that_cannot_be_true_are_dropped() {
    let spoil = |rig: &mut Rig, what: u32| {
        let good = rig.next;
        rig.next.seq += 1;
        rig.next.t_device_ns += 333_333;
        let mut f = rig.next;
        let want = match what % 5 {
            0 => {
                f.layout ^= 1;
                FrameVerdict::Foreign
            }
            1 => {
                f.seq = good.seq;
                FrameVerdict::Old
            }
            2 => {
                f.pos[0] = f64::NAN;
                FrameVerdict::Nonfinite
            }
            3 => {
                f.pos[0] += 5e-3;
                FrameVerdict::Jump
            }
            _ => {
                f.n = 0;
                FrameVerdict::Foreign
            }
        };
        assert_eq!(rig.engine.take(0, &mut f), want);
        rig.next.seq = good.seq;
        rig.frame()
    };
    let mut rig = Rig::new(KEY, profile(|_| {}));
    rig.on(&[0.0]);
    rig.glide(2e-3, 60);
    for n in 0..9 {
        within("its force", (force(&spoil(&mut rig, n)) + 1.0).abs(), 1e-6);
        rig.go(&[2e-3]);
    }
    assert_eq!(rig.engine.counts.dropped, 9);
    assert!(is_off(&spoil(&mut rig, 9), Cause::Implausible));
    // nine in any tenth of a second do not trip
    rig.glide(0.0, 400);
    rig.on(&[0.0]);
    for n in 0..200 {
        assert_eq!(mode(&spoil(&mut rig, n)), Mode::On);
        for _ in 0..36 {
            rig.go(&[0.0]);
        }
    }
}

#[test]
fn h11_the_last_of_the_travel_is_soft() {
    let mut rig = Rig::new(&KEY.replace("500", "0.001"), profile(|_| {}));
    rig.on(&[0.0]);
    // 20 mm: the last 1 mm on each side, up to 10 N at the end
    assert_eq!(rig.glide(8.9e-3, 100).flags & flag::EDGE, 0);
    let f = rig.glide(9.5e-3, 100);
    assert!(f.flags & flag::EDGE != 0);
    within("half way", (force(&f) + 5.0).abs(), 1e-4);
    let f = rig.glide(0.012, 100);
    within("beyond", (force(&f) + 10.0).abs(), 1e-6);
    // the model gets the true position
    assert_eq!(rig.engine.state.input[0], 0.012);
    let f = rig.glide(-9.5e-3, 400);
    within("the other end", (force(&f) - 5.0).abs(), 1e-4);
}

#[test]
fn h15_h16_what_explodes_is_taken_from_hand_and_ear() {
    let mut rig = Rig::new(EXPLODING, profile(|_| {}));
    let first = rig.engine.state.clone();
    rig.on(&[0.0]);
    let (mut frames, mut peak) = (0, 0.0f64);
    while !rig.engine.has_diverged() {
        frames += 1;
        assert!(frames < 9000, "it does not explode");
        // the frame that notices it already has zero force
        let f = rig.go(&[0.0]);
        peak = rig.sound.iter().fold(peak, |m, v| m.max(v.abs()));
        assert!(peak <= 1.0);
        assert_eq!(is_off(&f, Cause::ModelUnstable), rig.engine.has_diverged(), "{f:?}");
    }
    assert!(peak > 0.9, "it was loud: {peak}");
    // silent within 5 ms of sound samples, this frame included
    let mut after = rig.sound.clone();
    while after.len() < 480 {
        assert!(is_off(&rig.go(&[0.0]), Cause::ModelUnstable));
        after.extend(&rig.sound);
    }
    let silent = after.iter().rposition(|v| *v != 0.0).map_or(0, |i| i + 1);
    assert!(silent <= 240, "{silent} samples");
    let faded = &after[16..silent];
    assert!(faded.len() > 100 && faded.windows(2).all(|w| w[1].abs() < w[0].abs()), "no click on the way");
    // after a reload it fades in; forces stay off until armed
    let retired = rig.engine.command(EngineCommand::Reload(Box::new(first)));
    assert!(matches!(retired, Some(Retired::State(_))));
    let f = rig.go(&[0.0]);
    assert!(mode(&f) == Mode::Off && cause(&f) == Cause::Disarmed);
    assert!(!rig.engine.has_diverged() && rig.sound.iter().all(|v| v.abs() < 1e-3));
    rig.on(&[0.0]);
    assert!(rig.sound.iter().any(|v| *v != 0.0));
}
