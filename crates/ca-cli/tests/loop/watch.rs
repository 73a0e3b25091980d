//! A watcher on the force line: a third process beside server and device, which keeps every force frame it sees and
//! holds it to what the guard promises. Frames it was too slow for are known by their numbers.

use super::raw::Place;
use ca_haptic::frame::{Cause, ForceFrame, Mode};
use ca_haptic::host::Site;
use ca_haptic::profile::Profile;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

pub struct Watch {
    frames: Arc<Mutex<Vec<ForceFrame>>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// What was watched.
pub struct Seen {
    pub frames: Vec<ForceFrame>,
}

impl Watch {
    /// Watches the forces of `device` from now on.
    pub fn of(site: &Site, device: &str) -> Watch {
        let (frames, stop) = (Arc::new(Mutex::new(Vec::new())), Arc::new(AtomicBool::new(false)));
        let (to, end, site, device) = (frames.clone(), stop.clone(), site.clone(), device.to_owned());
        let (ready, is_ready) = std::sync::mpsc::channel();
        let thread = std::thread::spawn(move || {
            let place = Place::new(&site);
            let reader = place.reader::<ForceFrame>(&device, "out");
            ready.send(()).unwrap();
            while !end.load(Relaxed) {
                while let Some(f) = reader.receive().unwrap() {
                    to.lock().unwrap().push(*f);
                }
                std::thread::sleep(Duration::from_micros(100));
            }
        });
        is_ready.recv().unwrap();
        Watch { frames, stop, thread: Some(thread) }
    }

    /// How many so far.
    pub fn count(&self) -> usize {
        self.frames.lock().unwrap().len()
    }

    /// The newest.
    pub fn last(&self) -> Option<ForceFrame> {
        self.frames.lock().unwrap().last().copied()
    }

    /// Ends, and holds all frames to the promises of the guard with these numbers, at 3000 frames a second.
    pub fn end(mut self, p: &Profile) -> Seen {
        self.stop.store(true, Relaxed);
        self.thread.take().unwrap().join().unwrap();
        let frames = std::mem::take(&mut *self.frames.lock().unwrap());
        let gaps = check(&frames, p);
        eprintln!("{} frames of forces watched, {gaps} between them not seen", frames.len());
        assert!(frames.len() > 100, "only {} frames were seen", frames.len());
        Seen { frames }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Length of the first vector of a frame.
pub fn size(f: &[f32]) -> f64 {
    f.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>().sqrt()
}

/// H1, H2, H3 and H8 on the wire. Returns how many frames were not seen.
fn check(frames: &[ForceFrame], p: &Profile) -> u64 {
    let (n, axes) = (p.dof as usize, p.axes as usize);
    let slew = p.slew() / 3000.0;
    let mut gaps = 0;
    for (k, f) in frames.iter().enumerate() {
        assert!(f.is_ours() && f.n as usize == n, "{f:?}");
        assert!(f.force.iter().all(|x| x.is_finite()), "{f:?}");
        assert!(f.force[n..].iter().all(|x| *x == 0.0), "{f:?}");
        let mode = Mode::read(f.mode);
        if matches!(mode, Mode::Off | Mode::Fault) {
            assert!(f.force.iter().all(|x| *x == 0.0), "{f:?}");
        }
        let before = frames[..k].last().filter(|b| b.session == f.session);
        assert!(before.is_none_or(|b| f.seq > b.seq), "numbers grow");
        let apart = before.map_or(1, |b| f.seq - b.seq);
        gaps += apart - 1;
        for at in (0..n).step_by(axes) {
            assert!(size(&f.force[at..at + axes]) <= p.force * (1.0 + 1e-6), "{f:?}");
            if matches!(mode, Mode::Off | Mode::Fault) {
                continue;
            }
            // a session begins at rest, and what is off is zero
            let mut step = [0.0_f32; 3];
            for (a, step) in step.iter_mut().enumerate().take(axes) {
                *step = f.force[at + a] - before.map_or(0.0, |b| b.force[at + a]);
            }
            let jump = size(&step);
            assert!(jump <= slew * apart as f64 * (1.0 + 1e-5) + 1e-6, "{jump} N in {apart} frames: {f:?}");
        }
        // a fault ends by arming only, and arming begins with off
        if let Some(b) = before.filter(|b| Mode::read(b.mode) == Mode::Fault && apart == 1) {
            assert!(matches!(mode, Mode::Fault | Mode::Off), "{b:?}\n{f:?}");
        }
    }
    gaps
}

impl Seen {
    /// The frames of a mode.
    pub fn of(&self, mode: Mode) -> impl Iterator<Item = &ForceFrame> {
        self.frames.iter().filter(move |f| Mode::read(f.mode) == mode)
    }
    /// Causes of faults, in order, each once in a row.
    pub fn faults(&self) -> Vec<Cause> {
        let mut list: Vec<Cause> = self.of(Mode::Fault).map(|f| Cause::read(f.cause)).collect();
        list.dedup();
        list
    }
}

/// The profile of a key, as the server has it.
pub fn key() -> Profile {
    Profile::read(super::stage::PROFILE, "key").unwrap()
}
