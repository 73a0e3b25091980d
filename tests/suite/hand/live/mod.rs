//! The real-time loop without shared memory: engine thread, rings and recorder, with frames from the test.

mod disarm;

use crate::play::scene;
use ca_core::Scene;
use ca_haptic::engine::{Engine, Options, Port};
use ca_haptic::frame::{Cause, DeviceFrame, ForceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_haptic::record::Record;
use ca_haptic::serve::{Clock, GatewayEnds, Live, RecordIntervals, Recorder, Shared, Sink, rings};
use ca_tests::profile;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

const MODEL: &str = r#"
[param]
k = { value = 500, unit = "N/m", live = true, min = 0, max = 1000 }
z = { value = 0.001, unit = "N s/m", live = true, min = 0, max = 1 }
[TGR]
key = { device = "key", dof = 0 }
[MAS]
bob = { m = "10 g" }
[SOL]
wall = {}
[REF]
spring = { between = ["key", "bob"], k = "k", z = "z" }
[RES]
string = { between = ["wall", "bob"], k = 20000 }
[SOX]
out = { from = "bob", gain = 100 }
"#;

fn engine(scene: &Arc<Scene>, profile: Profile) -> Engine {
    let port = Port::new(scene, ca_tests::setup("key", profile));
    Engine::new(scene.clone(), vec![port], Options::default())
}

/// Frame `n`, from 1: a key that moves down and up 20 times a second. The amplitude grows during the first 2000 frames,
/// so that nothing pushes while the guard waits for that.
fn device(n: u64) -> DeviceFrame {
    let mut f = DeviceFrame::new("key", 1);
    (f.session, f.seq, f.t_device_ns) = (3, n, n * 333_333);
    f.pos[0] = 0.002 * (n as f64 / 2000.0).min(1.0) * (n as f64 * 20.0 / 3000.0 * crate::play::TURN).sin();
    f
}

/// Everything a sink receives: records, sound, ticks of pictures.
#[derive(Clone, Default)]
struct RecordingSink(Arc<Mutex<Received>>);
type Received = (Vec<Record>, Vec<f64>, Vec<u64>);

impl Sink for RecordingSink {
    fn record(&mut self, record: &Record) -> Result<(), ca_io::FileError> {
        self.0.lock().unwrap().0.push(record.clone());
        Ok(())
    }
    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), ca_io::FileError> {
        let sound = &mut self.0.lock().unwrap().1;
        assert_eq!(sound.len() as u64, tick, "one channel, and nothing is missing");
        sound.extend(frames);
        Ok(())
    }
    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), ca_io::FileError> {
        assert_eq!(x.len(), 3);
        self.0.lock().unwrap().2.push(tick);
        Ok(())
    }
}

struct Running {
    thread: JoinHandle<Engine>,
    gateway: GatewayEnds,
    recorder: Recorder,
    shared: Arc<Shared>,
    recorded: RecordingSink,
}

fn start(scene: &Arc<Scene>, clock: Clock, profile: Profile) -> Running {
    let engine = engine(scene, profile);
    let (ends, gateway, recorder_ends) = rings(scene, 1, 60);
    let (shared, recorded) = (Arc::new(Shared::default()), RecordingSink::default());
    let sinks: Vec<Box<dyn Sink>> = vec![Box::new(recorded.clone())];
    let recorder = Recorder::new(recorder_ends, shared.clone(), scene.clone(), &engine.ports, sinks);
    let every = RecordIntervals { energy: 30, view: 50, hash: 3000 };
    let live = Live::new(engine, ends, shared.clone(), clock, every);
    Running { thread: std::thread::spawn(move || live.run(None)), gateway, recorder, shared, recorded }
}

/// A device whose forces survive a stall of the machine. With a device clock, time is counted in its frames; only the
/// stall time of the engine itself is real time.
fn lasting() -> Profile {
    profile(|p| p.guard.ttl = 60.0)
}

/// In lock-step with the clock of the device, the threads give the same bits as the engine alone.
#[test]
fn threads_add_nothing_to_the_engine() {
    let scene = Arc::new(scene(MODEL).scene);
    let mut run = start(&scene, Clock::Device { patience: 60_000_000_000 }, lasting());
    let mut forces: Vec<ForceFrame> = Vec::new();
    run.recorder.order(None, Order::Arm).unwrap();
    for n in 1..=4000 {
        run.gateway.frames.push((0, device(n))).unwrap();
        loop {
            if let Ok((0, f)) = run.gateway.forces.pop() {
                // the thread sets the time stamp, the engine all else
                assert!(f.t_host_ns > 0);
                forces.push(ForceFrame { t_host_ns: 0, ..f });
                break;
            }
            std::thread::yield_now();
        }
        run.recorder.poll();
    }
    run.shared.stop.store(true, Relaxed);
    let engine_after = run.thread.join().unwrap();
    run.recorder.poll();
    let summary = run.recorder.summary(&engine_after, vec![]);

    let mut alone = engine(&scene, lasting());
    alone.command(ca_haptic::engine::EngineCommand::Order(None, Order::Arm));
    let mut sound = Vec::new();
    for n in 1..=4000 {
        alone.take(0, &mut device(n));
        let f = *alone.answer().next().unwrap();
        assert_eq!(f, forces[n as usize - 1], "frame {n}");
        sound.extend_from_slice(alone.finish());
    }
    assert_eq!(forces.last().unwrap().mode, Mode::On as u32);
    assert!(forces.iter().any(|f| f.force[0].abs() > 0.5));
    let recorded = run.recorded.0.lock().unwrap();
    assert_eq!(recorded.1[..sound.len()], sound);
    // one frame more at the end, which reports that forces are off
    assert_eq!(recorded.1.len(), sound.len() + 16);
    let last =
        recorded.0.iter().rev().find_map(|r| if let Record::Force { frame, .. } = r { Some(*frame) } else { None });
    let last = last.unwrap();
    assert_eq!((last.mode, last.cause, last.force[0]), (Mode::Off as u32, Cause::Disarmed as u16, 0.0));
    let devices = recorded.0.iter().filter(|r| matches!(r, Record::Device { .. })).count();
    assert_eq!((devices, summary.frames, summary.dropped), (4000, 4001, 0));
    assert_eq!(recorded.2.len(), 80, "pictures: one in fifty frames");
    assert!(recorded.0.iter().any(|r| matches!(r, Record::Hash { .. })));
    assert!(summary.is_faithful() && summary.faults.is_empty(), "{summary:?}");
    assert_eq!(summary.frame_us.n, 4000);
}

/// Two parameters set together change in the same tick; if one is invalid, neither changes.
#[test]
fn parameters_change_together_or_not_at_all() {
    let scene = Arc::new(scene(MODEL).scene);
    let mut run = start(&scene, Clock::Device { patience: 60_000_000_000 }, lasting());
    let step = |run: &mut Running, n: u64| {
        run.gateway.frames.push((0, device(n))).unwrap();
        while run.gateway.forces.pop().is_err() {
            std::thread::yield_now();
        }
        run.recorder.poll();
    };
    for n in 1..=10 {
        step(&mut run, n);
    }
    let two = |k: f64, z: f64| [("k".to_string(), k), ("z".to_string(), z)];
    assert!(run.recorder.set(&two(900.0, 7.0)).unwrap_err().to_string().contains("`z` must lie between 0 and 1"));
    assert!(run.recorder.set(&[("q".to_string(), 1.0)]).unwrap_err().to_string().contains("`q`"));
    assert!(run.recorder.order(Some("kay"), Order::Arm).unwrap_err().to_string().contains("`key`"));
    run.recorder.set(&two(900.0, 0.5)).unwrap();
    for n in 11..=20 {
        step(&mut run, n);
    }
    run.shared.stop.store(true, Relaxed);
    let engine = run.thread.join().unwrap();
    run.recorder.poll();
    let recorded = run.recorded.0.lock().unwrap();
    let changes: Vec<_> = recorded
        .0
        .iter()
        .filter_map(|r| match r {
            Record::Retired { tick, retired: ca_haptic::engine::Retired::Change(c) } => Some((*tick, c.params.clone())),
            _ => None,
        })
        .collect();
    assert_eq!(changes, [(9 * 16 + 1, vec![(0, 900.0), (1, 0.5)])]);
    let fresh = {
        let mut c = scene.controls();
        let mut s = scene.state();
        for (name, v) in two(900.0, 0.5) {
            assert!(s.apply(&c.set(&name, v).unwrap(), 1));
        }
        ca_core::tick(&scene, &mut s);
        s.coef
    };
    for (a, b) in engine.state.coef.iter().zip(&fresh) {
        assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
    }
}

/// On the monotonic clock, a device that stops is detected and forces end. Every loss is counted.
#[test]
fn a_device_that_stops_is_a_fault() {
    let scene = Arc::new(scene(MODEL).scene);
    // a busy machine may keep this thread away for longer than a device may be silent, and the engine for longer than a
    // force lives, which would be another fault
    let patient = profile(|p| {
        (p.guard.hold, p.guard.zero, p.guard.ttl) = (Some(0.05), 0.09, 60.0);
        (p.guard.clear_time, p.guard.ramp) = (0.001, 0.001);
    });
    let mut run = start(&scene, Clock::Monotonic, patient);
    run.recorder.order(None, Order::Arm).unwrap();
    let (mut n, mut used, mut armed, mut last) = (0, 0, 0, ForceFrame::new("key", 1));
    let begin = std::time::Instant::now();
    // one frame for each force, so the device is as fast as the engine on any machine
    while last.mode != Mode::On as u32 && begin.elapsed().as_secs() < 60 {
        while let Ok((_, f)) = run.gateway.forces.pop() {
            last = f;
            n += 1;
            let mut frame = device(n);
            (frame.ack, frame.t_host_ns) = (f.seq, ca_haptic::rt::now_ns());
            frame.pos[0] *= 0.01;
            let _ = run.gateway.frames.push((0, frame));
            used += 1;
        }
        run.recorder.poll();
        // a busy machine may keep this thread away for longer than the guard allows
        if last.mode == Mode::Fault as u32 && last.seq > armed + 100 {
            run.recorder.order(None, Order::Arm).unwrap();
            armed = last.seq;
        }
    }
    assert_eq!(last.mode, Mode::On as u32, "{last:?}");
    let mut off = None;
    while off.is_none() && begin.elapsed().as_secs() < 120 {
        while let Ok((_, f)) = run.gateway.forces.pop() {
            if f.mode == Mode::Fault as u32 {
                off = off.or(Some(f));
            }
        }
        run.recorder.poll();
    }
    assert_eq!((off.unwrap().cause, off.unwrap().force[0]), (Cause::WatchdogIn as u16, 0.0));
    run.shared.stop.store(true, Relaxed);
    let engine = run.thread.join().unwrap();
    run.recorder.poll();
    let s = run.recorder.summary(&engine, vec![("engine".into(), "as granted".into())]);
    assert!(s.faults.iter().any(|f| f.cause == Cause::WatchdogIn && f.device == "key"));
    assert!(s.stale > 0 && s.devices[0].frames == used && s.devices[0].loop_us.n > 0, "{s:?}");
    assert_eq!(s.frames, s.frame_us.n + 1);
}
