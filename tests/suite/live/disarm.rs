//! Whatever is full or was asked before, `disarm` is obeyed with the next frame.

use ca_haptic::engine::{Engine, Options, Port};
use ca_haptic::frame::{DeviceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::serve::{Clock, Desk, Every, Live, Shared, rings};
use ca_tests::{KEY, profile, setup};
use std::sync::Arc;

#[test]
fn a_full_ring_does_not_stand_before_disarm() {
    let text =
        KEY.replace("[TGR]", "[param]\nk = { value = 500, unit = \"N/m\", live = true, min = 1, max = 1000 }\n[TGR]");
    let scene = Arc::new(crate::play::with(&text.replace("k = 500", "k = \"k\""), &ca_core::Options::default()));
    let own = setup("key", profile(|p| (p.guard.clear_time, p.guard.ramp) = (0.001, 0.001)));
    let engine = Engine::new(scene.clone(), vec![Port::new(&scene, own)], Options::default());
    let (ends, mut gateway, desk_ends) = rings(&scene, 1, 0);
    let shared = Arc::new(Shared::default());
    let mut desk = Desk::new(desk_ends, shared.clone(), scene, &engine.ports, vec![]);
    let mut live = Live::new(engine, ends, shared, Clock::Device { patience: 0 }, Every::default());
    let mut frame = DeviceFrame::new("key", 1);
    frame.session = 1;
    let mut go = |live: &mut Live| {
        frame.seq += 1;
        frame.t_device_ns += 333_333;
        gateway.frames.push((0, frame)).expect("room");
        live.frame();
        Mode::read(gateway.forces.pop().expect("a force").1.mode)
    };
    desk.order(None, Order::Arm).expect("asked");
    let on = (0..100).find(|_| go(&mut live) == Mode::On);
    assert!(on.is_some());
    // nobody fetches records: two seconds and more, and then so many changes that no place is left for what they leave
    (0..8000).for_each(|_| assert_eq!(go(&mut live), Mode::On));
    for _ in 0..100 {
        let _ = desk.set(&[("k".into(), 400.0)]);
        go(&mut live);
    }
    while desk.set(&[("k".into(), 300.0)]).is_ok() {}
    assert!(desk.order(None, Order::Arm).is_err(), "there is no room for anything else");
    desk.order(None, Order::Disarm).expect("obeyed");
    assert_eq!(go(&mut live), Mode::Off);
    (0..100).for_each(|_| assert_eq!(go(&mut live), Mode::Off));
}

#[test]
fn arming_that_was_asked_for_before_is_void() {
    let scene = Arc::new(crate::play::with(KEY, &ca_core::Options::default()));
    let own = setup("key", profile(|p| (p.guard.clear_time, p.guard.ramp) = (0.001, 0.001)));
    let engine = Engine::new(scene.clone(), vec![Port::new(&scene, own)], Options::default());
    let (ends, mut gateway, desk_ends) = rings(&scene, 1, 0);
    let shared = Arc::new(Shared::default());
    let mut desk = Desk::new(desk_ends, shared.clone(), scene, &engine.ports, vec![]);
    let mut live = Live::new(engine, ends, shared, Clock::Device { patience: 0 }, Every::default());
    let mut frame = DeviceFrame::new("key", 1);
    frame.session = 1;
    let mut modes = |live: &mut Live| -> Vec<Mode> {
        let go = |_| {
            frame.seq += 1;
            frame.t_device_ns += 333_333;
            gateway.frames.push((0, frame)).expect("room");
            live.frame();
            Mode::read(gateway.forces.pop().expect("a force").1.mode)
        };
        (0..50).map(go).collect()
    };
    // both before the engine comes by
    desk.order(None, Order::Arm).expect("asked");
    desk.order(Some("key"), Order::Disarm).expect("obeyed");
    assert!(modes(&mut live).iter().all(|m| *m == Mode::Off));
    desk.order(Some("key"), Order::Disarm).expect("obeyed");
    desk.order(None, Order::Arm).expect("asked");
    assert_eq!(modes(&mut live).last(), Some(&Mode::On), "and what is asked for after it holds");
}
