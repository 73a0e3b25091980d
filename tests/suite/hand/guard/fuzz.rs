//! Fuzzes devices and models; frames on the wire keep the limits. A million frames, or 20 million with `CA_LONG=1`.

use super::requirements::{STYLUS, angle};
use super::{FRAME_DT, Rig, mode, profile};
use crate::play::Random;
use ca_haptic::frame::{Cause, DOF, DeviceFrame, ForceFrame, Mode, flag, status};
use ca_haptic::guard::{Chain, GuardFrame, Order};
use ca_haptic::profile::Profile;

fn frames() -> u32 {
    if ca_tests::long_form::long_form("nineteen of twenty frames") { 10_000_000 } else { 500_000 }
}

/// Checks force frames on the wire.
struct Watcher {
    p: Profile,
    last: [f64; DOF],
    modes: [u32; 5],
    flags: u32,
}

impl Watcher {
    fn new(p: &Profile) -> Watcher {
        Watcher { p: p.clone(), last: [0.0; DOF], modes: [0; 5], flags: 0 }
    }

    fn see(&mut self, mode: Mode, flags: u32, force: &[f64], n: u32) {
        let axes = self.p.axes as usize;
        let off = matches!(mode, Mode::Off | Mode::Fault);
        let most = self.p.slew() * FRAME_DT;
        for (at, v) in force.chunks(axes).enumerate() {
            assert!(v.iter().all(|f| f.is_finite()), "frame {n}: {v:?}");
            let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|f| f * f).sum::<f64>().sqrt();
            let size = norm(&mut v.iter().copied());
            assert!(size <= self.p.force * (1.0 + 1e-12), "frame {n}: {v:?} is {size}");
            assert!(!off || v.iter().all(|f| *f == 0.0), "frame {n}: {v:?} in {mode:?}");
            let last = &self.last[at * axes..];
            let step = norm(&mut v.iter().zip(last).map(|(a, b)| a - b));
            assert!(off || step <= most * (1.0 + 1e-6), "frame {n}: a step of {step} in {mode:?}");
        }
        self.last[..force.len()].copy_from_slice(force);
        self.modes[mode as usize] += 1;
        self.flags |= flags;
    }

    /// Checks that every mode and all these flags occurred.
    fn saw(&self, flags: u32) {
        assert!(self.modes.iter().all(|n| *n > 100), "off, ramp, on, damp, fault: {:?}", self.modes);
        assert_eq!(self.flags & flags, flags, "{:b}", self.flags);
    }
}

/// A device whose limits make much happen in few frames.
fn eager(axes: u32, continuous: f64) -> Profile {
    profile(|p| {
        (p.dof, p.axes, p.continuous, p.guard.speed) = (3, axes, Some(continuous), 1.0);
        let l = &mut p.guard;
        (l.clear_time, l.ramp, l.stop, l.thermal) = (0.005, 0.02, 0.02, 0.1);
        // the derived limit of 13 N a frame would never apply
        l.slew = Some(6000.0);
    })
}

/// Unusual numbers.
const ODD: [f64; 10] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, f64::MAX, 5e-324, -0.0, 1e160, -1e154];

fn odd(rng: &mut Random) -> f64 {
    ODD[((rng.uniform() + 1.0) * 0.5 * ODD.len() as f64) as usize % ODD.len()]
}

fn chance(rng: &mut Random, one_in: f64) -> bool {
    (rng.uniform() + 1.0) * 0.5 * one_in < 1.0
}

#[test]
fn any_force_of_a_model() {
    for (axes, continuous) in [(1, 5.0), (3, 5.0), (3, 10.0)] {
        let mut p = eager(axes, continuous);
        if continuous == p.force {
            // without stages that turn a vector
            (p.guard.slew, p.guard.passivity, p.guard.edge) = (Some(1e9), false, 0.0);
        }
        let (mut chain, mut hand) = (Chain::new(&p, FRAME_DT), GuardFrame::new(3, FRAME_DT));
        (hand.calibrated, hand.arrived, hand.age) = (true, u32::MAX, 0);
        let mut w = Watcher::new(&p);
        let mut rng = Random(99 + u64::from(axes));
        let (mut size, mut turned) = (0.0, 0);
        for n in 0..frames() / 3 {
            if n % 60 == 0 {
                // in turn: small enough to arm, normal, beyond the device, absurd
                size = [0.0, 0.2, 3.0, 30.0, 1e5, 1e300][(n / 60 % 6) as usize];
                chain.order(Order::Arm);
            }
            if chance(&mut rng, 500.0) {
                chain.order([Order::Disarm, Order::Trip(Cause::Software), Order::Arm][(n % 3) as usize]);
            }
            hand.frame = u64::from(n);
            hand.is_new = chance(&mut rng, 1.3);
            hand.age = if chance(&mut rng, 300.0) { 40 } else { u32::from(!hand.is_new) };
            for k in 0..3 {
                let to = 0.0099 * (f64::from(n) * 1e-3 + k as f64).sin();
                hand.moved[k] = if hand.is_new { to - hand.x[k] } else { 0.0 };
                hand.x[k] += hand.moved[k];
                hand.ack = if chance(&mut rng, 3.0) { (rng.0 % 64 + u64::from(n)).saturating_sub(32) } else { 0 };
                hand.v[k] = if chance(&mut rng, 2000.0) { 3.0 } else { hand.moved[k] / FRAME_DT };
                hand.force[k] =
                    if size > 1e4 && chance(&mut rng, 400.0) { odd(&mut rng) } else { size * rng.uniform() };
                hand.received[k] = if chance(&mut rng, 400.0) { odd(&mut rng) } else { 1e-4 * rng.uniform() };
            }
            let asked = hand.force;
            (hand.flags, hand.inject, hand.tripped) = (0, 0.0, Cause::None);
            chain.pass(&mut hand);
            assert!(hand.inject.is_finite());
            w.see(hand.mode, hand.flags, &hand.force[..3], n);
            // a saturated force keeps its direction
            if continuous == p.force && hand.mode == Mode::On && hand.flags & flag::SATURATED != 0 && size < 1e200 {
                // scaled so that squares do not overflow
                let of = |f: &[f64; DOF]| {
                    let most = f[..3].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                    [f[0] / most, f[1] / most, f[2] / most]
                };
                let a = angle(of(&hand.force), of(&asked));
                assert!(a < 1e-6, "frame {n}: {a}");
                turned += 1;
            }
        }
        let always = flag::SATURATED | flag::STALE | flag::WAIT_CLEAR;
        let more = flag::SLEWED | flag::PASSIVITY | flag::EDGE | flag::THERMAL;
        w.saw(if continuous < p.force { always | more } else { always });
        assert!(continuous < p.force || turned > 100, "{turned}");
    }
}

/// Corrupts a frame at random.
fn spoil(f: &mut DeviceFrame, rng: &mut Random) {
    let k = ((rng.uniform() + 1.0) * 8.0) as u32;
    let bits = rng.0;
    match k {
        0 => f.pos[0] = odd(rng),
        1 => f.pos[2] = odd(rng),
        2 => f.pos[1] += 0.1 * rng.uniform(),
        3 => f.seq = bits % 1000,
        4 => f.session = bits % 3,
        5 => f.magic ^= bits as u32,
        6 => f.layout = bits,
        7 => f.n = bits as u16,
        8 => f.status = bits as u32,
        9 => f.cause = (bits % 16) as u16,
        10 => f.t_device_ns = bits,
        11 => f.version = bits as u32,
        12 => f.status &= !status::CALIBRATED,
        13 => f.vel[0] = odd(rng),
        _ => f.period_ns = bits as u32,
    }
}

#[test]
fn any_frame_of_a_device() {
    let text = format!("[rate]\nsound = 3000\ngesture = 3000\n{STYLUS}").replace("e4 }", "e3 }");
    for axes in [1, 3] {
        let p = eager(axes, 5.0);
        let mut rig = Rig::new(&text, p.clone());
        let mut w = Watcher::new(&p);
        let mut rng = Random(31 + u64::from(axes));
        let (mut x, mut v) = ([0.0f64; 3], [0.0f64; 3]);
        let mut gap = 0;
        for n in 0..frames() / 2 {
            if n % 100 == 0 {
                rig.order(Order::Arm);
            }
            // a hand that comes to rest, then moves randomly, at times faster than allowed
            let wild = [0.0, 0.0, 0.0, 0.01, 0.03, 0.3][(n / 150 % 6) as usize];
            for k in 0..3 {
                v[k] = if wild == 0.0 { -80.0 * x[k] } else { 0.99 * v[k] + wild * rng.uniform() };
                x[k] = (x[k] + v[k] * FRAME_DT).clamp(-0.011, 0.011);
            }
            // frames get lost, repeated or corrupted
            gap = if gap > 0 {
                gap - 1
            } else if chance(&mut rng, 1000.0) {
                50
            } else {
                0
            };
            if gap == 0 {
                rig.send(&x);
                if chance(&mut rng, 300.0) {
                    let mut f = rig.next;
                    spoil(&mut f, &mut rng);
                    rig.engine.take(0, &mut f);
                }
                if chance(&mut rng, 3000.0) {
                    (rig.next.session, rig.next.seq) = (rig.next.session + 1, 0);
                }
            }
            let out: ForceFrame = rig.frame();
            let force = [0, 1, 2].map(|k| f64::from(out.force[k]));
            w.see(mode(&out), out.flags, &force, n);
            assert!(out.force[3..].iter().all(|f| *f == 0.0) && out.inject.is_finite());
        }
        w.saw(flag::SATURATED | flag::SLEWED | flag::EDGE | flag::STALE | flag::WAIT_CLEAR);
        let c = rig.engine.counts;
        assert!(c.dropped > 100 && c.faults > 20 && !rig.engine.has_diverged(), "{c:?}");
        assert!(rig.engine.state.x.iter().all(|x| x.is_finite()));
    }
}
