//! `disarm` takes effect with the next frame, whatever is full or was requested before.

use ca_haptic::engine::{Engine, Options, Port};
use ca_haptic::frame::{DeviceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::serve::{Clock, GatewayEnds, Live, RecordIntervals, Recorder, Shared, rings};
use ca_tests::{KEY, profile, setup};
use std::sync::Arc;

/// A recorder and an engine with one key, stepped by hand; records are not fetched.
struct Played {
    recorder: Recorder,
    live: Live,
    gateway: GatewayEnds,
    frame: DeviceFrame,
}

impl Played {
    fn new(text: &str) -> Played {
        let scene = Arc::new(crate::play::with(text, &ca_compile::Options::default()).scene);
        let own = setup("key", profile(|p| (p.guard.clear_time, p.guard.ramp, p.guard.ttl) = (0.001, 0.001, 60.0)));
        let engine = Engine::new(scene.clone(), vec![Port::new(&scene, own)], Options::default());
        let (ends, gateway, recorder_ends) = rings(&scene, 1, 0);
        let shared = Arc::new(Shared::default());
        let recorder = Recorder::new(recorder_ends, shared.clone(), scene, &engine.ports, vec![]);
        let live = Live::new(engine, ends, shared, Clock::Device { patience: 0 }, RecordIntervals::default());
        let mut frame = DeviceFrame::new("key", 1);
        frame.session = 1;
        Played { recorder, live, gateway, frame }
    }

    /// Runs one frame and returns the mode of the force frame.
    fn go(&mut self) -> Mode {
        self.frame.seq += 1;
        self.frame.t_device_ns += 333_333;
        self.gateway.frames.push((0, self.frame)).expect("room");
        self.live.frame();
        Mode::read(self.gateway.forces.pop().expect("a force").1.mode)
    }
}

#[test]
fn a_full_ring_does_not_stand_before_disarm() {
    let text =
        KEY.replace("[TGR]", "[param]\nk = { value = 500, unit = \"N/m\", live = true, min = 1, max = 1000 }\n[TGR]");
    let mut p = Played::new(&text.replace("k = 500", "k = \"k\""));
    p.recorder.order(None, Order::Arm).expect("asked");
    let on = (0..100).find(|_| p.go() == Mode::On);
    assert!(on.is_some());
    // more than two seconds, then parameter changes until all queues are full
    (0..8000).for_each(|_| assert_eq!(p.go(), Mode::On));
    for _ in 0..100 {
        let _ = p.recorder.set(&[("k".into(), 400.0)]);
        p.go();
    }
    while p.recorder.set(&[("k".into(), 300.0)]).is_ok() {}
    assert!(p.recorder.order(None, Order::Arm).is_err(), "there is no room for anything else");
    p.recorder.order(None, Order::Disarm).expect("obeyed");
    assert_eq!(p.go(), Mode::Off);
    (0..100).for_each(|_| assert_eq!(p.go(), Mode::Off));
}

#[test]
fn arming_that_was_asked_for_before_is_void() {
    let mut p = Played::new(KEY);
    // both orders before the engine runs
    p.recorder.order(None, Order::Arm).expect("asked");
    p.recorder.order(Some("key"), Order::Disarm).expect("obeyed");
    (0..50).for_each(|_| assert_eq!(p.go(), Mode::Off));
    p.recorder.order(Some("key"), Order::Disarm).expect("obeyed");
    p.recorder.order(None, Order::Arm).expect("asked");
    let last = (0..50).map(|_| p.go()).last();
    assert_eq!(last, Some(Mode::On), "and what is asked for after it holds");
}
