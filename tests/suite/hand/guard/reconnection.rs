//! A device that connects or returns anywhere, with any frame number: the scene approaches it slowly.

use super::{FRAME_DT, KEY, Rig, cause, force, is_off, mode, profile};
use crate::play::within;
use ca_haptic::frame::{Cause, Mode, flag, status};
use ca_haptic::guard::Order;
use ca_haptic::guard::input::FrameVerdict;

/// Frames until the scene reaches a device 8 mm away: the travel of 20 mm takes a second.
const WAY: u32 = 1200;

/// The device rests at `x` while the scene approaches it, no faster than allowed and without force.
fn met(rig: &mut Rig, x: f64) {
    let most = 0.02 * FRAME_DT;
    let mut last = rig.engine.state.input[0];
    let mut frames = 0_u32;
    while rig.engine.state.input[0] != x {
        let f = rig.go(&[x]);
        frames += 1;
        assert!(mode(&f) == Mode::Off && force(&f) == 0.0 && f.flags & flag::WAIT_CLEAR != 0, "{f:?}");
        let now = rig.engine.state.input[0];
        assert!((now - last).abs() <= most * (1.0 + 1e-9), "{now} after {last}");
        last = now;
    }
    assert!(frames.abs_diff(WAY) <= 1, "{frames}");
}

#[test]
fn a_device_that_appears_elsewhere_is_met_gently() {
    // without a spring nothing pushes, so only the approach delays forces
    let mut rig = Rig::new(&KEY.replace("500", "0"), profile(|_| {}));
    rig.order(Order::Arm);
    met(&mut rig, 8e-3);
    let wait = (0..400).find(|_| mode(&rig.go(&[8e-3])) == Mode::Ramp).expect("a ramp");
    assert!((298..=300).contains(&wait), "a tenth of a second from there: {wait}");
    // once reached, it is followed at the speed of a hand
    for n in 1..=60 {
        let x = 8e-3 - 1.2e-4 * f64::from(n);
        rig.go(&[x]);
        within("followed", (rig.engine.state.input[0] - x).abs(), 1e-15);
    }
    rig.next.session += 1;
    rig.next.seq = 0;
    rig.go(&[8.8e-3]);
    within("not followed", (rig.engine.state.input[0] - 8e-4).abs(), 1e-5);
    rig.order(Order::Arm);
    met(&mut rig, 8.8e-3);
}

#[test]
fn keys_that_move_all_the_time_are_met_one_by_one() {
    let two = KEY.replace("500", "0").replace("[SOL]", "other = { device = \"key\", dof = 1 }\n[SOL]");
    let mut rig = Rig::new(&two, profile(|p| p.dof = 2));
    rig.order(Order::Arm);
    // 8 mm each way, ten times faster than the approach, and never at both of the scene's positions at once
    let at = |n: u32| [0.0, 1.0].map(|late| 8e-3 * (25.0 * (f64::from(n) * FRAME_DT - late)).sin());
    let met = (1..6000).find(|n| mode(&rig.go(&at(*n))) == Mode::Ramp).expect("a ramp");
    assert!(met < 3000, "{met}");
    for n in met + 1..met + 300 {
        rig.go(&at(n));
        assert_eq!(rig.engine.state.input[..2], at(n), "followed");
    }
}

#[test]
fn a_number_from_nowhere_is_no_end() {
    let mut rig = Rig::new(KEY, profile(|_| {}));
    rig.on(&[0.0]);
    let seq = rig.next.seq;
    rig.next.seq = u64::MAX - 1;
    assert_eq!(rig.send(&[0.0]), FrameVerdict::Good);
    rig.frame();
    rig.next.seq = seq;
    // frames continue in order: eleven are too old and end in a fault, the twelfth is accepted as a new beginning
    let found: Vec<_> = (0..12)
        .map(|_| {
            let verdict = rig.send(&[0.0]);
            (verdict, cause(&rig.frame()))
        })
        .collect();
    assert!(found[..11].iter().all(|f| f.0 == FrameVerdict::Old) && found[11].0 == FrameVerdict::Good, "{found:?}");
    assert!(found[11].1 == Cause::Implausible);
    assert!(is_off(&rig.go(&[0.0]), Cause::Implausible), "and nobody armed");
    rig.on(&[0.0]);
    // repeated frames are not in order
    for _ in 0..40 {
        rig.next.seq = 5;
        assert_eq!(rig.send(&[0.0]), FrameVerdict::Old);
        rig.frame();
    }
    assert!(is_off(&rig.frame(), Cause::Implausible));
}

#[test]
fn nobody_is_armed_on_a_position_that_nobody_sends() {
    let mut rig = Rig::new(KEY, profile(|_| {}));
    rig.on(&[9e-4]);
    // one frame with a wild number, and enough old ones for a new beginning, then silence
    let seq = rig.next.seq;
    rig.next.seq = u64::MAX - 1;
    rig.send(&[9e-4]);
    rig.next.seq = seq;
    (0..11).for_each(|_| assert_eq!(rig.send(&[9e-4]), FrameVerdict::Old));
    rig.frame();
    assert!(is_off(&rig.frame(), Cause::Implausible));
    rig.order(Order::Arm);
    for _ in 0..6000 {
        let f = rig.frame();
        assert!(mode(&f) == Mode::Off && force(&f) == 0.0, "{f:?}");
    }
}

#[test]
fn a_clock_in_other_units_lets_no_jump_through() {
    for (wild, units) in [(false, 1000), (true, 1)] {
        let mut rig = Rig::new(KEY, profile(|_| {}));
        let step = |rig: &mut Rig, x: f64| {
            rig.next.t_host_ns += 333_333;
            rig.next.t_device_ns += 333_333 * (units - 1);
            rig.send(&[x])
        };
        rig.order(Order::Arm);
        let on = (0..6000).find(|_| {
            step(&mut rig, 0.0);
            mode(&rig.frame()) == Mode::On
        });
        assert!(on.is_some());
        if wild {
            rig.next.t_device_ns += 1_000_000_000;
        }
        assert_eq!(step(&mut rig, 5e-3), FrameVerdict::Jump, "{units}");
        let f = rig.frame();
        assert!(mode(&f) == Mode::On && force(&f).abs() < 1e-9, "{f:?}");
    }
}

#[test]
fn power_that_comes_late_is_no_step() {
    let mut rig = Rig::new(KEY, profile(|_| {}));
    let ready = rig.next.status;
    for (lost, at_once) in [(status::POWERED, ready & !status::POWERED), (status::BRAKE, ready | status::BRAKE)] {
        rig.next.status = at_once;
        rig.order(Order::Arm);
        for _ in 0..6000 {
            let f = rig.go(&[0.0]);
            assert!(mode(&f) == Mode::Off && f.flags & flag::WAIT_CLEAR != 0, "{lost}: {f:?}");
        }
        rig.next.status = ready;
        assert_eq!(mode(&rig.on(&[0.0])), Mode::On);
        rig.next.status = at_once;
        assert!(is_off(&rig.go(&[0.0]), Cause::Disconnect), "{lost}");
    }
}

#[test]
fn a_brake_ends_in_its_fault_whoever_arms() {
    let mut rig = Rig::new(KEY, profile(|_| {}));
    rig.on(&[0.0]);
    let braking = (1..60).find(|n| mode(&rig.go(&[2e-4 * f64::from(*n) - 5e-3])) == Mode::Damp);
    let braking = braking.or_else(|| (1..60).find(|n| mode(&rig.go(&[2e-4 * f64::from(*n)])) == Mode::Damp));
    assert!(braking.is_some());
    let x = rig.next.pos[0];
    rig.order(Order::Arm);
    let rest: Vec<_> = (0..700).map(|_| rig.go(&[x])).collect();
    assert_eq!((mode(&rest[0]), rig.engine.counts.faults), (Mode::Damp, 1));
    assert!(is_off(&rest[699], Cause::Velocity));
}

#[test]
fn a_device_that_says_again_what_it_was_sent_can_be_armed() {
    for reported in [Cause::Velocity, Cause::Software, Cause::Disconnect, Cause::WatchdogOut] {
        let mut rig = Rig::new(KEY, profile(|_| {}));
        rig.on(&[0.0]);
        rig.order(Order::Trip(reported));
        rig.next.cause = reported as u16;
        (0..10).for_each(|_| assert!(is_off(&rig.go(&[0.0]), reported)));
        rig.order(Order::Arm);
        // the device hears of it a few frames later
        assert_eq!(mode(&rig.go(&[0.0])), Mode::Off, "{reported:?}");
        rig.next.cause = Cause::Disarmed as u16;
        assert_eq!(mode(&rig.on(&[0.0])), Mode::On, "{reported:?}");
    }
}
