//! Frames of every kind of device, and the speed measured from them.

use super::*;

const FRAME_DT: f64 = 1.0 / 3000.0;

/// Returns the largest and last speed measured and the dropped frames, while a device of `rate` frames a second moves
/// at `speed` with its own clock, one frame being `spike` metres off.
fn fastest(rate: u32, speed: f64, clock: impl Fn(f64) -> u64, spike: f64) -> (f64, f64, u64) {
    let mut p = Profile::shipped("tgr12").expect("shipped");
    (p.dof, p.rate, p.guard.speed) = (1, f64::from(rate), 1.0);
    let (mut validator, mut hand) = (InputValidator::new(&p, FRAME_DT), GuardFrame::new(1, FRAME_DT));
    let mut f = DeviceFrame::new("key", 1);
    let (mut most, mut last) = (0.0f64, 0.0);
    let every = 3000 / rate;
    for n in 0..3000_u32 {
        if n.is_multiple_of(every) {
            let t = f64::from(n) * FRAME_DT;
            f.seq += 1;
            f.t_device_ns = clock(t);
            f.pos[0] = speed * t + if n == 1500 { spike } else { 0.0 };
            validator.take(&f, &mut hand);
        }
        validator.update(&mut hand);
        (hand.frame, hand.is_new) = (hand.frame + 1, false);
        most = most.max(hand.v[0].abs());
        last = hand.v[0];
    }
    (most, last, validator.dropped)
}

#[test]
fn speed_is_that_of_the_hand_whatever_its_clock_says() {
    type Clock = (&'static str, fn(f64) -> u64);
    let clocks: [Clock; 5] = [
        ("right", |t| (t * 1e9) as u64 + 77),
        ("none", |_| 0),
        ("microseconds", |t| (t * 1e6) as u64),
        ("a thousand times too fast", |t| (t * 1e12) as u64),
        ("backwards", |t| 10_000_000_000 - (t * 1e9) as u64),
    ];
    for rate in [3000, 1000, 500] {
        for (name, clock) in clocks {
            let (most, last, dropped) = fastest(rate, 0.4, clock, 0.0);
            assert!((most - 0.4).abs() < 1e-5 && (last - 0.4).abs() < 1e-5, "{rate} Hz, {name}: {most} {last}");
            assert_eq!(dropped, 0, "{rate} Hz, {name}");
        }
    }
}

#[test]
fn one_wrong_position_is_no_throw() {
    for rate in [3000, 1000, 500] {
        let frame = 1.0 / f64::from(rate);
        let clock = |t: f64| (t * 1e9) as u64;
        // as far as H10 accepts from a hand at rest; farther is dropped
        let (most, _, dropped) = fastest(rate, 0.0, clock, 1.99 * (frame + FRAME_DT));
        assert!(dropped == 0 && most > 0.5 && most < 1.0, "{rate} Hz: {most} m/s, {dropped} dropped");
        let (most, _, dropped) = fastest(rate, 0.0, clock, 5.0 * frame);
        assert!(dropped == 1 && most == 0.0, "{rate} Hz: {most} m/s, {dropped} dropped");
    }
}

/// Returns the cause that ends forces in four seconds of an armed device. `frames` passes on its frames before each
/// engine frame, without a fault in the first two seconds.
fn ended(p: &Profile, what: &str, mut frames: impl FnMut(u32, &mut dyn FnMut(&DeviceFrame))) -> Cause {
    let mut validator = InputValidator::new(p, FRAME_DT);
    let mut hand = GuardFrame::new(p.dof as usize, FRAME_DT);
    let mut chain = crate::guard::Chain::new(p, FRAME_DT);
    chain.order(crate::guard::Order::Arm);
    for n in 0..12_000_u32 {
        frames(n, &mut |f| _ = validator.take(f, &mut hand));
        validator.update(&mut hand);
        hand.arrived = u32::MAX;
        chain.pass(&mut hand);
        (hand.frame, hand.is_new, hand.tripped) = (hand.frame + 1, false, Cause::None);
        if n == 5999 {
            assert_eq!((hand.mode, hand.cause), (Mode::On, Cause::None), "{what}");
        }
    }
    assert_eq!(hand.mode, Mode::Fault, "{what}");
    hand.cause
}

/// Returns the cause that ends forces when `wrong` alters the later frames of a device of `rate` frames a second;
/// `wrong` returns false to send none.
fn wronged(rate: u32, wrong: impl Fn(u32, &mut DeviceFrame) -> bool) -> Cause {
    let mut p = Profile::shipped("tgr12").expect("shipped");
    (p.dof, p.rate, p.guard.speed) = (2, f64::from(rate), 1.0);
    let every = 3000 / rate;
    ended(&p, &format!("{rate} Hz"), |n, send| {
        if n.is_multiple_of(every) {
            let mut f = DeviceFrame::new("key", 2);
            (f.seq, f.t_device_ns) = (u64::from(n / every) + 1, u64::from(n) * 333_333);
            if n < 6000 || wrong(n / every, &mut f) {
                send(&f);
            }
        }
    })
}

#[test]
fn forces_end_for_what_was_wrong_at_every_rate() {
    for rate in [3000, 1000, 500, 250] {
        let far = wronged(rate, |n, f| {
            f.pos[1] = if n % 2 == 0 { 2.0 } else { 4.0 };
            true
        });
        assert_eq!(far, Cause::Implausible, "jumps of 2 m at {rate} Hz");
        let stays = wronged(rate, |_, f| {
            f.pos = [2.0; DOF];
            true
        });
        assert_eq!(stays, Cause::Implausible, "2 m away at {rate} Hz");
        let nan = wronged(rate, |_, f| {
            f.pos[0] = f64::NAN;
            true
        });
        assert_eq!(nan, Cause::Implausible, "not finite at {rate} Hz");
        for mask in [0, 1, 2, u32::MAX - 2] {
            let masked = wronged(rate, |_, f| {
                f.mask = mask;
                true
            });
            assert_eq!(masked, Cause::Implausible, "mask {mask:x} at {rate} Hz");
        }
        assert_eq!(wronged(rate, |_, _| false), Cause::WatchdogIn, "silence at {rate} Hz");
    }
}

#[test]
fn a_position_that_is_not_valid_moves_nothing() {
    let mut p = Profile::shipped("tgr12").expect("shipped");
    p.dof = 2;
    let (mut validator, mut hand) = (InputValidator::new(&p, FRAME_DT), GuardFrame::new(2, FRAME_DT));
    let mut f = DeviceFrame::new("key", 3);
    for (seq, mask, verdict) in [
        (1, 0, FrameVerdict::Masked),
        (2, 0b01, FrameVerdict::Masked),
        (3, 0b110, FrameVerdict::Masked),
        // positions beyond the profile need not be valid
        (4, 0b011, FrameVerdict::Good),
        (5, u32::MAX, FrameVerdict::Good),
    ] {
        (f.seq, f.mask, f.pos) = (seq, mask, [1e-3; DOF]);
        assert_eq!(validator.take(&f, &mut hand), verdict, "mask {mask:b}");
        let moved = if verdict == FrameVerdict::Good { 1e-3 } else { 0.0 };
        assert_eq!(hand.x[..2], [moved; 2], "mask {mask:b}");
    }
    assert_eq!(validator.dropped, 3);
}

/// Returns the cause that ends forces in a throw at `speed` times the trip speed, with `at_once` device frames arriving
/// together, as on a busy machine.
fn thrown(speed: f64, at_once: u32) -> Cause {
    let mut p = Profile::shipped("tgr12").expect("shipped");
    (p.dof, p.rate, p.guard.speed, p.range) = (1, 3000.0, 0.5, [-10.0, 10.0]);
    let mut f = DeviceFrame::new("key", 1);
    ended(&p, &format!("{speed} of the trip, {at_once} frames at once"), |n, send| {
        let last = n % at_once == at_once - 1;
        for k in (0..at_once).rev().filter(|_| last) {
            f.seq += 1;
            f.t_device_ns = u64::from(n - k) * 333_333;
            f.pos[0] = 0.5 * speed * FRAME_DT * f64::from((n - k).saturating_sub(6000).min(60));
            send(&f);
        }
    })
}

#[test]
fn a_throw_ends_forces_however_its_frames_come() {
    // beyond these the device is late, and forces do not begin
    for at_once in 1..=4 {
        assert_eq!(thrown(1.5, at_once), Cause::Velocity, "{at_once} frames at once");
        // above the fastest motion accepted, the throw is found first only if each frame comes alone
        let cause = if at_once == 1 { Cause::Velocity } else { Cause::Implausible };
        assert_eq!(thrown(3.0, at_once), cause, "{at_once} frames at once");
    }
}
