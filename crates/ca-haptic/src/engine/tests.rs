//! Tests the engine end to end, without a process: a key on a spring.

use super::{Engine, EngineCommand, Options, Port, Setup};
use crate::calibration::Calibration;
use crate::frame::{Cause, DeviceFrame, Mode};
use crate::guard::Order;
use crate::profile::Profile;
use ca_compile::load;
use std::sync::Arc;

/// A key on a spring of 500 N/m, and nothing else.
pub(crate) const KEY: &str = r#"
[TGR]
key = { device = "key", dof = 0 }
[SOL]
wall = {}
[RES]
spring = { between = ["key", "wall"], k = 500 }
[SOX]
out = { from = "key" }
"#;

pub(crate) fn setup() -> Setup {
    let profile = Profile { dof: 1, ..Profile::shipped("tgr12").expect("shipped") };
    Setup { device: "key".into(), profile, calibration: Calibration::default(), gains: vec![] }
}

fn engine() -> Engine {
    let (_, scene) = load(KEY, "key.ca.toml", &ca_model::catalog(), &ca_compile::Options::default());
    let scene = Arc::new(scene.expect("it compiles").scene);
    let port = Port::new(&scene, setup());
    Engine::new(scene, vec![port], Options::default())
}

#[test]
fn a_spring_is_felt_once_armed_and_clear() {
    let mut e = engine();
    let mut f = DeviceFrame::new("key", 1);
    f.session = 7;
    let mut force = [0.0; 2];
    e.command(EngineCommand::Order(None, Order::Arm));
    for n in 0..6000_u64 {
        f.seq += 1;
        f.t_device_ns = n * 333_333;
        f.pos[0] = if n < 400 { 0.0 } else { (0.000_01 * (n - 400) as f64).min(0.005) };
        e.take(0, &mut f);
        let out = *e.answer().next().expect("one device");
        force = [f64::from(out.force[0]), f64::from(out.mode)];
        e.finish();
    }
    assert_eq!(force[1], f64::from(Mode::On as u32));
    assert!((force[0] + 500.0 * 0.005).abs() < 1e-6, "{force:?}");
}

#[test]
fn an_order_between_the_scene_and_the_guard_counts_for_this_frame() {
    let mut e = engine();
    let mut f = DeviceFrame::new("key", 1);
    f.session = 7;
    e.command(EngineCommand::Order(None, Order::Arm));
    let mut sent = Vec::new();
    for n in 0..6000_u64 {
        (f.seq, f.t_device_ns) = (n + 1, n * 333_333);
        f.pos[0] = if n < 400 { 0.0 } else { (0.000_01 * (n - 400) as f64).min(0.005) };
        e.take(0, &mut f);
        e.prepare();
        if n == 5999 {
            e.command(EngineCommand::Order(Some(0), Order::Trip(Cause::WatchdogOut)));
        }
        sent.push(*e.answer().next().expect("one device"));
        e.finish();
    }
    assert!((f64::from(sent[5998].force[0]) + 500.0 * 0.005).abs() < 1e-6, "{:?}", sent[5998]);
    let last = sent[5999];
    assert_eq!((last.mode, last.cause, last.force[0]), (Mode::Fault as u32, Cause::WatchdogOut as u16, 0.0));
}

#[test]
fn a_device_that_says_what_it_is_goes_on_from_where_it_was() {
    let (_, scene) = load(KEY, "key.ca.toml", &ca_model::catalog(), &ca_compile::Options::default());
    let scene = Arc::new(scene.expect("it compiles").scene);
    let unknown = Profile::shipped("unknown").expect("shipped");
    let with = |profile: Profile| Setup { profile, ..setup() };
    let mut e = Engine::new(scene.clone(), vec![Port::new(&scene, with(unknown.undescribed(1)))], Options::default());
    let mut f = DeviceFrame::new("key", 1);
    f.session = 7;
    let mut play = |e: &mut Engine, frames: u64, x: f64| {
        let mut out = None;
        for _ in 0..frames {
            f.seq += 1;
            f.t_device_ns = f.seq * 333_333;
            // no faster than a hand
            f.pos[0] += (x - f.pos[0]).clamp(-1e-4, 1e-4);
            e.take(0, &mut f);
            out = e.answer().next().copied();
            e.finish();
        }
        out.expect("one device")
    };
    e.command(EngineCommand::Order(None, Order::Arm));
    let before = play(&mut e, 3000, 1e-3);
    assert_eq!((before.mode, before.force[0]), (Mode::Off as u32, 0.0), "it has not said what it is");
    assert_eq!(e.ports[0].chain.wait(), crate::guard::wait::Wait::Undescribed);
    let input = e.state.input.clone();
    let described = unknown.described(&crate::frame::About::new("key", 1000, 1)).expect("it makes sense");
    let retired = e.command(EngineCommand::Refit(Box::new(super::Refit::new(&scene, 0, with(described.clone())))));
    assert!(matches!(retired, Some(super::Retired::Port(ref p)) if p.profile == described));
    assert_eq!((e.counts.dropped, e.state.input == input), (0, true));
    // armed as before, but the key presses: 0.5 N of 2 N
    let after = play(&mut e, 3000, 1e-3);
    assert_eq!((after.seq, after.mode), (before.seq + 3000, Mode::Off as u32));
    let wait = crate::guard::wait::Wait::Presses { dof: 0, force: 0.5, limit: 0.1, count: 1 };
    assert_eq!(e.ports[0].chain.wait(), wait);
    play(&mut e, 6000, 0.0);
    let on = play(&mut e, 600, 1e-3);
    assert!(on.mode == Mode::On as u32 && (f64::from(on.force[0]) + 0.5).abs() < 1e-6, "{on:?}");
    // another device while forces are on: they end in a fault, which is counted
    let other = Profile { force: 1.0, ..described };
    e.command(EngineCommand::Refit(Box::new(super::Refit::new(&scene, 0, with(other)))));
    let fault = play(&mut e, 1, 1e-3);
    assert_eq!((fault.mode, fault.cause), (Mode::Fault as u32, crate::frame::Cause::Disconnect as u16));
    assert_eq!((fault.force[0], e.counts.faults), (0.0, 1));
    // a clone does not contain a port
    let copy = super::Refit::new(&scene, 0, setup()).clone();
    e.command(EngineCommand::Refit(Box::new(copy)));
    assert_eq!((e.counts.refused, e.ports[0].profile.name.as_str()), (1, "unknown"));
}

/// Returns the largest force on a hand that moves 1.5 mm into 500 N/m in 30 ms, while its device sends nothing for
/// `stall` frames on the way.
fn struck_after_a_stall(stall: u64) -> f64 {
    let (_, scene) = load(KEY, "key.ca.toml", &ca_model::catalog(), &ca_compile::Options::default());
    let scene = Arc::new(scene.expect("it compiles").scene);
    let mut e = Engine::new(scene.clone(), vec![Port::new(&scene, setup())], Options::default());
    let (mut f, mut most, mut held) = (DeviceFrame::new("key", 1), 0.0_f64, 0);
    f.session = 7;
    e.command(EngineCommand::Order(None, Order::Arm));
    for n in 0..8000_u64 {
        let way = ((n as f64 - 6000.0) / 90.0).clamp(0.0, 1.0);
        if !(6050..6050 + stall).contains(&n) {
            f.seq += 1;
            (f.ack, f.t_device_ns) = (held, n * 333_333);
            f.pos[0] = 1.5e-3 * way * way * (3.0 - 2.0 * way);
            e.take(0, &mut f);
        }
        let before = held;
        let out = *e.answer().next().expect("one device");
        // used a frame later, and not at all during the stall
        held = if (6050..6050 + stall).contains(&n) { before } else { out.seq };
        most = most.max(f64::from(out.force[0]).abs());
        e.finish();
    }
    most
}

#[test]
fn a_device_that_was_held_up_is_not_struck() {
    for stall in [0, 9, 18, 27] {
        let most = struck_after_a_stall(stall);
        assert!(most < 0.75 * 1.1, "{stall} frames: {most} N where statics give 0.75 N");
    }
}
