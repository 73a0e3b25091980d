//! A device written without the client of this project, with at most one fault.

use super::iceoryx_client::RawSite;
use ca_haptic::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, Mode};
use ca_haptic::host::Site;
use ca_haptic::host::force_watchdog::ForceWatchdog;
use ca_haptic::rt::{RtRequest, ask, now_ns, wait_until};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::JoinHandle;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceFault {
    None,
    /// All its frames have the same number.
    Numbers,
    /// It never reports which force it used.
    Ack,
    /// It applies the last force forever.
    Watchdog,
    /// It sends at half its stated rate.
    Rate,
    /// It reports impossible positions.
    Positions,
    /// It accepts the first engine forever.
    Restart,
    /// It accepts an engine that was not seen at rest.
    Unrested,
    /// It accepts force frames with any layout.
    Layout,
    /// It ends with its engine.
    GoesOn,
    /// Its session differs from the announced one.
    Session,
    /// It applies another force than it received.
    Measured,
    /// It never applies a force.
    NoForce,
    /// It moves against the force: positions and forces have opposite signs.
    Sign,
    /// It is correct, but its hand moves to and fro all the time.
    Moves,
}

/// Period of a frame at 3 kHz \[ns\].
const PERIOD: u64 = 333_333;

/// A device in a thread, stopped on drop.
pub struct FaultyDevice {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

pub fn about(name: &str, rate: u32) -> About {
    About {
        session: 77,
        low: [-0.01; DOF],
        high: [0.01; DOF],
        force: [10.0; DOF],
        continuous: [10.0; DOF],
        ..About::new(name, rate, 1)
    }
}

impl FaultyDevice {
    /// Starts a device `name` at 1000 frames per second.
    pub fn new(site: &Site, name: &str, fault: DeviceFault) -> FaultyDevice {
        FaultyDevice::with(site, name, move |place, name, stop| play(place, name, fault, stop))
    }

    fn with(site: &Site, name: &str, play: impl FnOnce(&RawSite, &str, &AtomicBool) + Send + 'static) -> FaultyDevice {
        let stop = Arc::new(AtomicBool::new(false));
        let (end, site, name) = (stop.clone(), site.clone(), name.to_owned());
        let thread = std::thread::spawn(move || play(&RawSite::new(&site), &name, &end));
        FaultyDevice { stop, thread: Some(thread) }
    }

    /// Starts a sensor at 3000 frames per second that applies no force. `frame` fills each frame, numbered from 1.
    pub fn moving(
        site: &Site,
        name: &str,
        mut frame: impl FnMut(u64, &mut DeviceFrame) + Send + 'static,
    ) -> FaultyDevice {
        FaultyDevice::with(site, name, move |place, name, stop| {
            let line = place.writer::<DeviceFrame>(name, "in", 0);
            let mut f = DeviceFrame::new(name, 1);
            (f.session, f.period_ns) = (1, PERIOD as u32);
            for n in 1.. {
                if stop.load(Relaxed) {
                    return;
                }
                f.seq += 1;
                (f.t_host_ns, f.t_device_ns) = (now_ns(), n * PERIOD);
                frame(n, &mut f);
                line.send_copy(f).unwrap();
                wait_until(f.t_host_ns + PERIOD);
            }
        })
    }
}

impl Drop for FaultyDevice {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            // the test panics if the thread did
            let ended = thread.join();
            assert!(ended.is_ok() || std::thread::panicking());
        }
    }
}

fn play(place: &RawSite, name: &str, fault: DeviceFault, stop: &AtomicBool) {
    // like a device process, if permitted
    ask(RtRequest { priority: Some(70), ..RtRequest::default() });
    let frames = place.writer::<DeviceFrame>(name, "in", 0);
    let forces = place.reader::<ForceFrame>(name, "out");
    let says = place.writer::<About>(name, "about", 1);
    let who = about(name, 1000);
    let period = if fault == DeviceFault::Rate { 2_000_000 } else { 1_000_000 };
    let mut watchdog = ForceWatchdog::new(who.device);
    let mut held = ForceFrame::new(name, 1);
    let (mut due, mut frame) = (now_ns(), DeviceFrame::new(name, 1));
    frame.session = if fault == DeviceFault::Session { 78 } else { 77 };
    let mut first = None;
    for n in 1.. {
        if stop.load(Relaxed) {
            return;
        }
        if n % 500 == 1 {
            says.send_copy(who).unwrap();
        }
        while let Some(f) = forces.receive().unwrap() {
            let f = *f;
            match fault {
                DeviceFault::Restart if f.has_this_layout() && *first.get_or_insert(f.session) != f.session => {}
                DeviceFault::Layout => {
                    held = f;
                    let _ = watchdog.take(&f);
                }
                _ => {
                    if watchdog.take(&f) {
                        held = f;
                    }
                }
            }
        }
        let now = now_ns();
        let cause = match fault {
            DeviceFault::NoForce => Cause::Disarmed,
            DeviceFault::Watchdog | DeviceFault::Unrested if watchdog.last().is_some() => {
                let on = !matches!(Mode::read(held.mode), Mode::Off | Mode::Fault);
                let fresh = fault == DeviceFault::Watchdog
                    || now.saturating_sub(held.t_host_ns) < u64::from(held.ttl_us) * 1000;
                match watchdog.cause(now) {
                    _ if on && fresh => Cause::None,
                    Cause::None => Cause::Disarmed,
                    cause => cause,
                }
            }
            _ => watchdog.cause(now),
        };
        if fault == DeviceFault::GoesOn
            && cause == Cause::WatchdogOut
            && watchdog.last().is_some_and(|f| f.mode == Mode::On as u32)
        {
            due = wait_until(due + period);
            continue;
        }
        frame.force_measured[0] = if cause == Cause::None { held.force[0] } else { 0.0 };
        if fault == DeviceFault::Measured {
            frame.force_measured[0] *= 2.0;
        }
        frame.cause = if watchdog.last().is_none() { Cause::Disarmed } else { cause } as u16;
        frame.seq = if fault == DeviceFault::Numbers { 1 } else { n };
        frame.ack = if fault == DeviceFault::Ack { 0 } else { held.seq };
        match fault {
            DeviceFault::Positions => frame.pos[0] = 0.02,
            // a damped finger pushed in the wrong direction
            DeviceFault::Sign => {
                frame.pos[0] = (frame.pos[0] - 2e-4 * f64::from(frame.force_measured[0])).clamp(-0.01, 0.01);
            }
            DeviceFault::Moves => frame.pos[0] = 0.0095 * (std::f64::consts::TAU * n as f64 / 400.0).sin(),
            _ => {}
        }
        (frame.t_device_ns, frame.t_host_ns, frame.period_ns) = (n * period, now, period as u32);
        frames.send_copy(frame).unwrap();
        // after a stall, continues at its rate without catching up
        due = wait_until((due + period).max(now + period / 2));
    }
}
