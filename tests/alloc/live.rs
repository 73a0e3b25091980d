//! Checks that the whole loop in its thread allocates nothing: rings, clock, engine and guard.
//!
//! A device, a gateway and a recorder run beside it. Both cores are busy, and faults, changes and reloads never stop.
//! Frames and records handed over and lost must add up. Runs three seconds, or a minute with `CA_LONG=1`.

use super::{calls, engine};
use ca_core::State;
use ca_haptic::engine::{Engine, EngineCommand, Retired};
use ca_haptic::frame::{CAUSES, DeviceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::record::Record;
use ca_haptic::rt::{now_ns, wait_until};
use ca_haptic::serve::{Clock, GatewayEnds, Live, RecordIntervals, Shared, rings};
use rtrb::Consumer;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Ends all threads of a test, also if it fails.
struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Relaxed);
    }
}

/// Simulates a hand that presses, jumps, leaves and comes back, with an impossible frame now and then. Returns the
/// number of frames sent, of frames for which the ring was full, and of forces received.
fn play(mut ends: GatewayEnds, over: &AtomicBool) -> (u64, u64, u64) {
    let (mut sent, mut full, mut forces) = (0, 0, 0);
    let mut next = DeviceFrame::new("hand", 2);
    next.session = 1;
    let mut due = now_ns();
    for n in 0_u64.. {
        while ends.forces.pop().is_ok() {
            forces += 1;
        }
        if over.load(Relaxed) {
            break;
        }
        let t = n % 3000;
        let phase = (t % 500) as f64 / 500.0;
        next.seq += 1;
        next.t_device_ns += 333_333;
        next.pos[0] = if t > 1000 { 0.01 * (0.25 - (phase - 0.75).abs()).max(0.0) } else { 0.0 };
        next.pos[1] = if t > 2000 { next.pos[0] * 20.0 } else { next.pos[0] };
        let mut f = next;
        match n % 97 {
            0 => f.pos[0] = f64::NAN,
            1 => f.layout = n,
            2 => f.seq = 0,
            _ => {}
        }
        if !(1600..1900).contains(&t) {
            match ends.frames.push((0, f)) {
                Ok(()) => sent += 1,
                Err(_) => full += 1,
            }
        }
        // after a stall, continues from now and does not catch up
        due = wait_until(due + 333_333);
    }
    while ends.forces.pop().is_ok() {
        forces += 1;
    }
    (sent, full, forces)
}

/// Contents of the rings as the recorder found them.
#[derive(Debug, Default)]
struct Found {
    devices: u64,
    forces: u64,
    /// energy and hashes
    regular: u64,
    /// records reported as missing
    lost: u64,
    sound: u64,
    modes: [u64; 5],
    reloads: u64,
    commands: u64,
}

impl Found {
    fn look(&mut self, records: &mut Consumer<Record>, sound: &mut Consumer<f64>) {
        while let Ok(r) = records.pop() {
            match r {
                Record::Device { .. } => self.devices += 1,
                Record::Force { frame, .. } => {
                    self.forces += 1;
                    self.modes[Mode::read(frame.mode) as usize] += 1;
                }
                Record::Lost { records, .. } => self.lost += records,
                Record::Energy { .. } | Record::Hash { .. } => self.regular += 1,
                Record::Marked { .. } | Record::Waiting { .. } => {}
                Record::Retired { retired: Retired::State(_), .. } => self.reloads += 1,
                Record::Retired { .. } | Record::Order { .. } | Record::Manual { .. } | Record::Swapped { .. } => {
                    self.commands += 1;
                }
            }
        }
        while let Ok(_tick) = sound.pop() {
            let n = sound.pop().expect("a length");
            self.sound += n as u64;
            sound.read_chunk(n as usize).expect("as many as it says").commit_all();
        }
    }
}

#[test]
fn nor_does_the_loop_while_both_cores_are_busy() {
    let frames: u64 = if ca_tests::long_form::long_form("all but three seconds of a minute") { 180_000 } else { 9000 };
    let (engine, state, change) = engine::engine(true, true);
    let scene = engine.scene.clone();
    let (ends, gateway, mut recorder) = rings(&scene, 1, 0);
    let shared = Arc::new(Shared::default());
    let live =
        Live::new(engine, ends, shared.clone(), Clock::Monotonic, RecordIntervals { energy: 30, view: 0, hash: 3000 });
    let (over, ended) = (AtomicBool::new(false), AtomicBool::new(false));
    let mut found = Found::default();
    let (n, engine, device) = std::thread::scope(|s| {
        let all_over = Over(&over);
        for _ in 0..2 {
            s.spawn(|| burn(&over));
        }
        let device = s.spawn(|| play(gateway, &over));
        let engine = s.spawn(|| {
            let _ended = Over(&ended);
            let mut back: Option<Engine> = None;
            let n = calls(|| back = Some(live.run(Some(frames))));
            (n, back.expect("it ran"))
        });
        let mut turns = 0_u64;
        while !ended.load(Relaxed) {
            found.look(&mut recorder.records, &mut recorder.sound);
            while recorder.timings.pop().is_ok() {}
            let act = match turns % 25 {
                3 | 8 => Some(EngineCommand::Order(None, Order::Arm)),
                13 => Some(EngineCommand::Set(Box::new(change.clone()))),
                20 => Some(EngineCommand::Order(Some(0), Order::Trip(CAUSES[(turns / 25) as usize % CAUSES.len()]))),
                23 if (turns / 25) % 4 == 3 => Some(EngineCommand::Reload(Box::<State>::new(state.clone()))),
                _ => None,
            };
            // a full ring means that the engine has enough to do
            if let Some(a) = act {
                let _ = recorder.commands.push((0, a));
            }
            turns += 1;
            std::thread::sleep(Duration::from_millis(20));
        }
        drop(all_over);
        let (n, engine) = engine.join().expect("the engine");
        (n, engine, device.join().expect("the device"))
    });
    found.look(&mut recorder.records, &mut recorder.sound);
    let c = engine.counts;
    let (sent, full, forces) = device;
    let lost = [&shared.lost_records, &shared.lost_forces, &shared.lost_sound];
    let [lost_records, lost_forces, lost_sound] = lost.map(|n| n.load(Relaxed));
    eprintln!(
        "{} frames, {n} calls of the allocator; positions: {sent} sent, {full} not taken, {} used, {} dropped; \
         forces: {forces} fetched, {lost_forces} lost; records: {lost_records} lost; {c:?}; {found:?}",
        c.frames, c.taken, c.dropped
    );
    assert_eq!(n, 0, "calls of the allocator");
    // one frame more, the last, reports that forces are off
    assert_eq!(c.frames, frames + 1);
    assert_eq!(forces + lost_forces, c.frames, "every force was fetched, or counted");
    // frames sent after the engine ended are still in the ring
    let looked = c.taken + c.dropped;
    assert!(looked <= sent && sent - looked <= 64, "{sent} positions, {looked} looked at");
    let noted = looked + c.frames + c.frames / 30 + c.frames / 3000;
    assert_eq!(found.devices + found.forces + found.regular + lost_records, noted, "every record, or counted");
    assert!(found.lost <= lost_records);
    assert_eq!(
        found.sound + lost_sound,
        c.frames * u64::from(scene.rates.ratio) * scene.counts.channels as u64 - first(&scene)
    );
    let [off, ramp, on, _, fault] = found.modes;
    assert!([off, ramp, on, fault].iter().all(|n| *n > 20), "off, ramp, on, damp, fault: {found:?}");
    assert!(
        found.reloads > 0 && found.commands > 10 && c.faults > 3 && c.dropped > 50 && c.stale > 40 && c.refused == 0,
        "{c:?} {found:?}"
    );
}

fn burn(over: &AtomicBool) {
    while !over.load(Relaxed) {
        std::hint::spin_loop();
    }
}

/// Samples missing from the sound of the first frame, which only places the devices.
fn first(scene: &ca_core::Scene) -> u64 {
    u64::from(scene.rates.ratio - 1) * scene.counts.channels as u64
}
