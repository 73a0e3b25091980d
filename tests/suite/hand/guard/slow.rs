//! Devices slower and coarser than the engine must not cause faults.
//!
//! A simulated hand sweeps the travel at most of the trip speed, on an 8-bit fader at 500 Hz, a stylus at 1 kHz and a
//! key at 3 kHz. Frames arrive up to one engine frame early or late.

use super::{FRAME_DT, KEY, Rig, cause, mode};
use crate::play::Random;
use ca_haptic::frame::{Cause, Mode, flag};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_haptic::simulated::{Device, Hand, Script};
use ca_io::gesture::{Gesture, Track};

struct Swept {
    faults: u64,
    stale: u32,
    dropped: u64,
    late: u64,
    why: Cause,
    fastest: f64,
}

/// Sweeps back and forth for two seconds at `speed` times the trip speed, once forces are on.
fn sweep(name: &str, speed: f64) -> Swept {
    let p = Profile::shipped(name).expect("shipped");
    let [low, high] = p.range;
    let (middle, half) = (0.5 * (low + high), 0.35 * (high - low));
    let quarter = half / (speed * p.guard.speed);
    let mut points = vec![(0.0, middle), (1.5, middle)];
    let (mut t, mut side) = (1.5 + quarter, 1.0);
    while t < 3.5 {
        points.push((t, middle + side * half));
        (t, side) = (t + 2.0 * quarter, -side);
    }
    let track = Track::points("x", points).expect("a track");
    let script = Script::File(Gesture::new(vec![track]).expect("a gesture"));
    // a hand far stiffer than the model, so that the speed is the one intended
    let hand = Hand { stiffness: 4e4, damping: 300.0, mass: 0.05 };
    let mut device = Device::new(&p, hand, script, 0, 11);
    let text = KEY.replace("500", "0.1").replace("dof = 0", &format!("dof = 0, x = {middle}"));
    let mut rig = Rig::new(&text.replace("wall = {}", &format!("wall = {{ x = {middle} }}")), p.clone());
    let ratio = (1.0 / (p.rate * FRAME_DT)).round() as u32;
    let period = f64::from(ratio) * FRAME_DT;
    let mut rng = Random(5);
    let (mut due, mut stale, mut fastest) = (0, 0, 0.0f64);
    let mut force = [0.0; 32];
    let mut why = Cause::None;
    for n in 0..10_500_u32 {
        if n == 30 {
            rig.order(Order::Arm);
        }
        // one frame of jitter to each side for devices slower than the engine
        if n >= due {
            device.step(&force[..p.dof as usize], period);
            device.frame(&mut rig.next);
            let mut f = rig.next;
            rig.engine.take(0, &mut f);
            let wait = (n / ratio + 1) * ratio;
            due = if ratio > 1 { (wait + u32::from(rng.uniform() > 0.0)).max(n + 1) } else { n + 1 };
            fastest = fastest.max(device.truth(0)[1].abs());
        }
        let out = rig.frame();
        for (to, f) in force.iter_mut().zip(out.force) {
            *to = f64::from(f);
        }
        stale += u32::from(out.flags & flag::STALE != 0);
        if mode(&out) == Mode::Fault && why == Cause::None {
            why = cause(&out);
        }
        let on = mode(&out) == Mode::On || why != Cause::None;
        assert!(n != 4400 || on, "{name}: {:?}, flags {:b}", mode(&out), out.flags);
    }
    let c = rig.engine.counts;
    Swept { faults: c.faults, stale, dropped: c.dropped, late: c.stale, why, fastest: fastest / p.guard.speed }
}

#[test]
fn a_fast_hand_on_a_slow_device_is_no_fault() {
    for name in ["firefader", "falcon", "tgr12", "inverse3", "touch"] {
        let s = sweep(name, 0.7);
        assert!(s.fastest > 0.65 && s.fastest < 0.85, "{name}: {}", s.fastest);
        assert_eq!((s.faults, s.stale, s.dropped), (0, 0, 0), "{name}: {} at {}", s.why.name(), s.fastest);
        // a frame that is one late is only counted as late
        assert!(s.late < 10_500 / 3, "{name}: {} late", s.late);
    }
}

#[test]
fn a_throw_is_a_fault_on_every_one_of_them() {
    for name in ["firefader", "falcon", "tgr12", "inverse3", "touch"] {
        let s = sweep(name, 1.3);
        assert_eq!((s.faults, s.why), (1, Cause::Velocity), "{name}");
    }
}

#[test]
fn a_step_of_the_sensor_is_no_motion() {
    // a resting fader that flickers between two counts in every frame
    let p = Profile::shipped("firefader").expect("shipped");
    let step = p.body.step;
    let x = 0.05;
    let text = KEY.replace("500", "0.1");
    let mut rig = Rig::new(&text, p);
    rig.order(Order::Arm);
    let mut on = false;
    for n in 0..6000_u32 {
        if n % 6 == 0 {
            rig.next.t_device_ns += 5 * 333_333;
            rig.send(&[x + step * f64::from(n / 6 % 2)]);
        }
        let f = rig.frame();
        on |= mode(&f) == Mode::On;
        assert!(rig.engine.ports[0].hand.v[0].abs() < 0.125, "{} m/s", rig.engine.ports[0].hand.v[0]);
        assert_ne!(mode(&f), Mode::Fault);
    }
    assert!(on);
}
