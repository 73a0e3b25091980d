//! Watches the forces: a third process besides server and device records every force frame, and its test compares them
//! with the guarantees of the guard.
//!
//! The watcher creates the line before server and device start, with a queue of a third of a second, and a thread
//! writes the file. So it misses no frame while the machine stalls. Sequence numbers reveal any missed frame.

use super::helper_process::{HelperProcess, Job};
use super::iceoryx_client::RawSite;
use ca_haptic::frame::{Cause, ForceFrame, Mode};
use ca_haptic::host::Site;
use ca_haptic::profile::Profile;
use ca_haptic::rt::{RtRequest, ask};
use std::io::Write as _;
use std::time::Duration;
use zerocopy::{FromBytes as _, IntoBytes as _};

/// Frames by which the watcher may be late.
const QUEUE: usize = 1024;

pub struct ForceWatcher(HelperProcess);

pub struct Seen {
    pub frames: Vec<ForceFrame>,
    /// Frames not seen, before the first of a session and between two; counted at the end.
    pub unseen: u64,
}

impl ForceWatcher {
    /// Starts to watch the forces of `device` before its server starts.
    pub fn of(site: &Site, device: &str) -> ForceWatcher {
        ForceWatcher(HelperProcess::start(site, "force_watcher::every_force", device, 0))
    }

    pub fn count(&self) -> usize {
        self.0.written() / size_of::<ForceFrame>()
    }

    pub fn last(&self) -> Option<ForceFrame> {
        self.0.last(size_of::<ForceFrame>()).map(|b| ForceFrame::read_from_bytes(&b).unwrap())
    }

    pub fn so_far(&self) -> Seen {
        Seen { frames: read(&self.0.read()), unseen: 0 }
    }

    /// Ends the watcher and checks all frames against the guard limits in `p`, at 3000 frames per second.
    pub fn end(self, p: &Profile) -> Seen {
        let frames = read(&self.0.end());
        let unseen = check(&frames, p);
        eprintln!("{} frames of forces watched, {unseen} not seen", frames.len());
        assert!(frames.len() > 100, "only {} frames were seen", frames.len());
        Seen { frames, unseen }
    }
}

fn read(record: &[u8]) -> Vec<ForceFrame> {
    record.chunks_exact(size_of::<ForceFrame>()).map(|b| ForceFrame::read_from_bytes(b).unwrap()).collect()
}

#[test]
#[ignore = "a part of other tests"]
fn every_force() {
    let Some(job) = Job::asked() else { return };
    let place = RawSite::new(&job.site);
    let reader = place.deep_reader::<ForceFrame>(&job.device, "out", QUEUE);
    let mut record = job.ready();
    let (heap, heaps) = std::sync::mpsc::channel::<Vec<u8>>();
    // writing may block
    let writer = std::thread::spawn(move || heaps.iter().for_each(|h| record.write_all(&h).unwrap()));
    ask(RtRequest { priority: Some(50), ..RtRequest::default() });
    loop {
        // frames before the end are still read
        let over = job.is_over();
        let mut frames = Vec::new();
        while let Some(f) = reader.receive().unwrap() {
            frames.extend_from_slice(f.as_bytes());
        }
        heap.send(frames).unwrap();
        if over {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    drop(heap);
    writer.join().unwrap();
}

/// Length of the first vector of a frame.
pub fn size(f: &[f32]) -> f64 {
    f.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>().sqrt()
}

/// Checks H1, H2, H3 and H8 on the frames sent. Returns the number of frames not seen.
fn check(frames: &[ForceFrame], p: &Profile) -> u64 {
    let (n, axes) = (p.dof as usize, p.axes as usize);
    let slew = p.slew() / 3000.0;
    let mut gaps = 0;
    for (k, f) in frames.iter().enumerate() {
        assert!(f.has_this_layout() && f.n as usize == n, "{f:?}");
        assert!(f.force.iter().all(|x| x.is_finite()), "{f:?}");
        assert!(f.force[n..].iter().all(|x| *x == 0.0), "{f:?}");
        let mode = Mode::read(f.mode);
        if matches!(mode, Mode::Off | Mode::Fault) {
            assert!(f.force.iter().all(|x| *x == 0.0), "{f:?}");
        }
        let before = frames[..k].last().filter(|b| b.session == f.session);
        assert!(before.is_none_or(|b| f.seq > b.seq), "numbers grow");
        // a session begins with sequence number 1, at rest
        let apart = f.seq - before.map_or(0, |b| b.seq);
        gaps += apart - 1;
        for at in (0..n).step_by(axes) {
            assert!(size(&f.force[at..at + axes]) <= p.force * (1.0 + 1e-6), "{f:?}");
            if matches!(mode, Mode::Off | Mode::Fault) {
                continue;
            }
            // missing axes are zero
            let mut step = [0.0_f32; 3];
            for (a, step) in step.iter_mut().enumerate().take(axes) {
                *step = f.force[at + a] - before.map_or(0.0, |b| b.force[at + a]);
            }
            let jump = size(&step);
            assert!(jump <= slew * apart as f64 * (1.0 + 1e-5) + 1e-6, "{jump} N in {apart} frames: {f:?}");
        }
        // only arming ends a fault, and arming begins with mode off
        if let Some(b) = before.filter(|b| Mode::read(b.mode) == Mode::Fault && apart == 1) {
            assert!(matches!(mode, Mode::Fault | Mode::Off), "{b:?}\n{f:?}");
        }
    }
    gaps
}

impl Seen {
    pub fn of(&self, mode: Mode) -> impl Iterator<Item = &ForceFrame> {
        self.frames.iter().filter(move |f| Mode::read(f.mode) == mode)
    }
    /// Causes of faults in order, without repetitions.
    pub fn faults(&self) -> Vec<Cause> {
        let mut list: Vec<Cause> = self.of(Mode::Fault).map(|f| Cause::read(f.cause)).collect();
        list.dedup();
        list
    }
}

pub fn key() -> Profile {
    Profile::read(super::sandbox::PROFILE, "key").unwrap()
}
