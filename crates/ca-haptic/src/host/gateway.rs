//! Receives frames from all devices on one thread, and sends them forces.
//!
//! The thread polls every 50 µs (every 1 ms without devices). An iceoryx2 `WaitSet` allocates on each wait and is
//! slower, and the engine runs on its own clock anyway. This module checks only the layout and sender of a frame;
//! `guard` checks its content. A device counts as connected from its first frame until 250 ms without one. Its first
//! frame also starts the claim that decides which server uses it (`claim.rs`).

use super::claim::{Claim, ClaimResult};
use super::error::{HostError, HostErrorKind};
use super::free_memory;
use super::services::{Frames, Service, Wakeup, check_name};
use super::site::{Ipc, Site};
use super::timeout::{LIMIT, with_timeout};
use crate::frame::{About, DeviceFrame, ForceFrame, FrameMismatch, uid};
use crate::rt::{Granted, RtRequest, now_ns};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::Node;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, mpsc};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};
use zerocopy::IntoBytes;

/// Poll interval with devices.
const POLL: Duration = Duration::from_micros(50);
/// Poll interval without devices.
const IDLE: Duration = Duration::from_millis(1);
/// Longest wait for the end of the thread.
const LEAVE: Duration = Duration::from_secs(5);
/// Time without frames after which a device counts as disconnected \[ns\].
const SILENCE_NS: u64 = 250_000_000;

/// Shortest interval between two [`Event::Here`] of a device whose session keeps changing \[ns\].
const REPORT_NS: u64 = 10_000_000;
/// Maximum number of frames of one device in one poll, so that a device that never stops sending does not delay the others.
const BURST: usize = 16;
/// A gap of at least this many frame numbers counts as one missed frame: a real one would exceed [`SILENCE_NS`].
const UNLIKELY: u64 = 1 << 32;

/// An event of a device.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The first frame of a process came.
    Here {
        /// Session number in its frames.
        session: u64,
    },
    /// The device described itself, for the first time or with changes.
    About(Box<About>),
    /// No frame came for 250 ms.
    Gone,
    /// Another server has the device, as the message says; its frames are ignored until that server ends.
    Taken(String),
    /// Unusable frames came, for this reason; reported once until the next [`Event::Here`].
    Foreign(FrameMismatch),
}

/// Counters, for all devices together.
#[derive(Debug, Default)]
pub struct Traffic {
    /// Device frames received.
    pub received: AtomicU64,
    /// Received frames of another version or another device.
    pub foreign: AtomicU64,
    /// Device frames missed, from gaps in their numbers.
    pub missed: AtomicU64,
    /// Device frames lost because the ring to the engine was full.
    pub full: AtomicU64,
    /// Force frames sent.
    pub sent: AtomicU64,
    /// Force frames that could not be sent.
    pub unsent: AtomicU64,
    /// Device frames not used and force frames not sent, because the device is not claimed.
    pub unclaimed: [AtomicU64; 2],
}

struct Place {
    name: String,
    uid: [u8; 16],
    frames: Subscriber<Ipc, DeviceFrame, ()>,
    says: Subscriber<Ipc, About, ()>,
    claim: Claim,
    wakeup: Notifier<Ipc>,
    session: u64,
    seq: u64,
    /// Time of the last frame \[ns\]; 0 while disconnected.
    heard: u64,
    complained: bool,
    /// Time of the last [`Event::Here`] \[ns\].
    reported: u64,
    about: Option<About>,
}

impl Place {
    /// Notes a frame that is used: reports a new session, and counts the frames missed before it.
    fn follow(
        &mut self,
        k: usize,
        frame: &DeviceFrame,
        now: u64,
        events: &mut VecDeque<(usize, Event)>,
        traffic: &Traffic,
    ) {
        if self.heard == 0 || self.session != frame.session {
            if now.saturating_sub(self.reported) > REPORT_NS {
                events.push_back((k, Event::Here { session: frame.session }));
                (self.reported, self.complained) = (now, false);
            }
        } else {
            let gap = frame.seq.saturating_sub(self.seq).saturating_sub(1);
            traffic.missed.fetch_add(if gap < UNLIKELY { gap } else { 1 }, Relaxed);
        }
        (self.session, self.seq, self.heard) = (frame.session, frame.seq, now.max(1));
    }
}

/// All devices of a server.
pub struct Gateway {
    places: Vec<Place>,
    events: VecDeque<(usize, Event)>,
    traffic: Arc<Traffic>,
    // dropped after its ports
    _node: Node<Ipc>,
    /// Holds the lock on the prefix.
    _site: Site,
}

impl Gateway {
    /// Opens the services of these devices and claims the devices now.
    ///
    /// # Errors
    /// If a name is invalid or given twice, another running server has a device, or the shared memory cannot be made.
    pub fn open<S: AsRef<str>>(site: &Site, names: &[S]) -> Result<Gateway, HostError> {
        Gateway::with(site, names, None)
    }

    /// Opens the services. Each device is claimed a time `after` its first frame, or now for `None`.
    fn with<S: AsRef<str>>(site: &Site, names: &[S], after: Option<Duration>) -> Result<Gateway, HostError> {
        super::stale_shm::strangers(site)?;
        let names: Vec<String> = names.iter().map(|n| n.as_ref().into()).collect();
        let need = free_memory::DEVICE * names.len() as u64;
        let limit = LIMIT * u32::try_from(names.len()).unwrap_or(u32::MAX).clamp(1, 10);
        with_timeout(site, need, limit, move |site| Gateway::made(site, &names, after))
    }

    fn made(site: &Site, names: &[String], after: Option<Duration>) -> Result<Gateway, HostError> {
        let node = site.node("server")?;
        let mut places: Vec<Place> = Vec::new();
        for name in names {
            check_name(name)?;
            if places.iter().any(|p| p.name == *name) {
                let what = format!("device `{name}` is given twice");
                return Err(HostError::new(HostErrorKind::Name, what, "give it once"));
            }
            let line = Frames::open(&node, name, Service::Out, 0)?;
            places.push(Place {
                // the exclusive service first
                claim: match after {
                    Some(after) => Claim::on_first_frame(site, line, after),
                    None => Claim::now(site, line)?,
                },
                frames: Frames::open(&node, name, Service::In, 0)?.subscriber(site, 0)?,
                says: Frames::open(&node, name, Service::About, 1)?.subscriber(site, 1)?,
                wakeup: Wakeup::open(&node, name)?.notifier(site)?,
                name: name.clone(),
                uid: uid(name),
                session: 0,
                seq: 0,
                heard: 0,
                complained: false,
                reported: 0,
                about: None,
            });
        }
        Ok(Gateway { places, events: VecDeque::new(), traffic: Arc::default(), _node: node, _site: site.clone() })
    }

    /// Receives all waiting frames and gives `incoming` the number of the device and the frame, oldest first.
    pub fn poll(&mut self, incoming: &mut impl FnMut(usize, DeviceFrame)) {
        let now = now_ns();
        for (k, p) in self.places.iter_mut().enumerate() {
            for _ in 0..BURST {
                let Ok(Some(frame)) = p.frames.receive() else { break };
                self.traffic.received.fetch_add(1, Relaxed);
                if let Some(why) = frame.mismatch(p.uid) {
                    self.traffic.foreign.fetch_add(1, Relaxed);
                    if !p.complained {
                        p.complained = true;
                        self.events.push_back((k, Event::Foreign(why)));
                    }
                    continue;
                }
                if p.claim.is_granted() {
                    p.follow(k, &frame, now, &mut self.events, &self.traffic);
                    incoming(k, *frame);
                } else {
                    self.traffic.unclaimed[0].fetch_add(1, Relaxed);
                    p.claim.note_frame(&frame, now);
                }
            }
            match p.claim.result() {
                Some(ClaimResult::Granted { force_sent }) => {
                    if force_sent {
                        self.traffic.unclaimed[1].fetch_sub(1, Relaxed);
                        self.traffic.sent.fetch_add(1, Relaxed);
                    }
                    if let Some(frame) = p.claim.take_frame(now) {
                        self.traffic.unclaimed[0].fetch_sub(1, Relaxed);
                        p.follow(k, &frame, now, &mut self.events, &self.traffic);
                        incoming(k, frame);
                    }
                }
                Some(ClaimResult::Taken(who)) => self.events.push_back((k, Event::Taken(who))),
                None => {}
            }
            if p.heard != 0 && now.saturating_sub(p.heard) > SILENCE_NS {
                p.heard = 0;
                self.events.push_back((k, Event::Gone));
            }
            for _ in 0..BURST {
                // descriptions are read once the device is claimed
                let Some(Ok(Some(about))) = p.claim.is_granted().then(|| p.says.receive()) else { break };
                // as bytes, because NaN differs from itself
                let new = p.about.is_none_or(|a| a.as_bytes() != about.as_bytes());
                if about.has_this_layout() && about.device == p.uid && new {
                    p.about = Some(*about);
                    self.events.push_back((k, Event::About(Box::new(*about))));
                }
            }
        }
    }

    /// Sends a force to device `k` and wakes it, without blocking. The lifetime of the force runs from `t_host_ns`,
    /// which the caller has set, so that a delay before this call counts.
    pub fn send(&mut self, k: usize, frame: &ForceFrame) {
        let Some(p) = self.places.get_mut(k) else { return };
        let Some(sent) = p.claim.send(frame) else {
            self.traffic.unclaimed[1].fetch_add(1, Relaxed);
            return;
        };
        let count = if sent { &self.traffic.sent } else { &self.traffic.unsent };
        count.fetch_add(1, Relaxed);
        // a device that cannot be woken reads the force at its own timeout
        let _ = p.wakeup.notify();
    }

    /// Removes and returns the oldest event, with the number of its device.
    pub fn event(&mut self) -> Option<(usize, Event)> {
        self.events.pop_front()
    }

    /// Returns the last `About` of device `k`.
    pub fn about(&self, k: usize) -> Option<&About> {
        self.places.get(k)?.about.as_ref()
    }

    /// Returns the counters.
    pub fn traffic(&self) -> Arc<Traffic> {
        self.traffic.clone()
    }

    /// Moves frames between shared memory and rings until `stop` is set, and returns the gateway, still open.
    #[must_use]
    pub fn run(mut self, rings: &mut Rings, stop: &AtomicBool) -> Gateway {
        while !stop.load(Relaxed) {
            let traffic = self.traffic.clone();
            self.poll(&mut |k, frame| {
                if rings.incoming.push((k as u32, frame)).is_err() {
                    traffic.full.fetch_add(1, Relaxed);
                }
            });
            while let Ok((k, frame)) = rings.outgoing.pop() {
                self.send(k as usize, &frame);
            }
            while let Some((k, event)) = self.event() {
                let _ = rings.events.send((k as u32, event));
            }
            sleep(if self.places.iter().any(|p| p.heard != 0) { POLL } else { IDLE });
        }
        // the last frames turn forces off, so that devices need not wait for a timeout
        while let Ok((k, frame)) = rings.outgoing.pop() {
            self.send(k as usize, &frame);
        }
        self
    }

    /// Opens the services in a new thread and runs there.
    ///
    /// Each device is claimed a time `after` its first frame: the server with the shorter delay gets it, and the other
    /// reports [`Event::Taken`]. The thread asks the system for `request`; [`Running::granted`] has the result.
    ///
    /// # Errors
    /// If a name is invalid or given twice, the shared memory cannot be made, or no thread can be started.
    pub fn start<S: AsRef<str>>(
        site: &Site,
        names: &[S],
        mut rings: Rings,
        request: RtRequest,
        after: Duration,
    ) -> Result<Running, HostError> {
        let (site, names): (Site, Vec<String>) = (site.clone(), names.iter().map(|n| n.as_ref().into()).collect());
        let stop = Arc::new(AtomicBool::new(false));
        let (tell, reported) = mpsc::channel();
        let end = stop.clone();
        let thread = std::thread::Builder::new()
            .name("ca gateway".into())
            .spawn(move || match Gateway::with(&site, &names, Some(after)) {
                Ok(gateway) => {
                    let _ = tell.send(Ok((gateway.traffic(), crate::rt::ask(request))));
                    drop(gateway.run(&mut rings, &end));
                }
                Err(e) => {
                    let _ = tell.send(Err(e));
                }
            })
            .map_err(|e| HostError::system("cannot start a thread", e))?;
        let stopped = |e| HostError::system("the gateway thread stopped unexpectedly", e);
        let (traffic, granted) = reported.recv().map_err(stopped)??;
        Ok(Running { traffic, granted, stop, thread: Some(thread) })
    }
}

/// Connections of the gateway thread to the rest of a server.
pub struct Rings {
    /// Device frames to the engine; when it is full, new frames are lost and counted.
    pub incoming: rtrb::Producer<(u32, DeviceFrame)>,
    /// Forces from the engine.
    pub outgoing: rtrb::Consumer<(u32, ForceFrame)>,
    /// Events of devices, to a thread that is not real-time.
    pub events: mpsc::Sender<(u32, Event)>,
}

/// A gateway thread, which ends when this value is dropped.
pub struct Running {
    /// Counters.
    pub traffic: Arc<Traffic>,
    /// Priority and other rights that the system granted the thread.
    pub granted: Granted,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        let end = Instant::now() + LEAVE;
        while self.thread.as_ref().is_some_and(|t| !t.is_finished()) {
            if Instant::now() > end {
                // a thread that hangs in iceoryx2 is left behind
                return;
            }
            sleep(IDLE);
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Returns the `About` of each device of this site that answers within `patience`. Most devices need a few
/// milliseconds, a device that rarely sends up to a second.
///
/// # Errors
/// If the shared memory cannot be opened.
pub fn list_devices(site: &Site, patience: Duration) -> Result<Vec<About>, HostError> {
    with_timeout(site, free_memory::LISTING, LIMIT + patience, move |site| read_descriptions(site, patience))
}

fn read_descriptions(site: &Site, patience: Duration) -> Result<Vec<About>, HostError> {
    let node = site.node("list")?;
    let mut lines = Vec::new();
    for name in super::services::devices(site)? {
        let line = Frames::<About>::open(&node, &name, Service::About, 1)?;
        let reader = line.subscriber(site, 1)?;
        lines.push((line, reader, None));
    }
    let end = Instant::now() + patience;
    loop {
        let mut waiting = false;
        for (line, reader, said) in &mut lines {
            while let Ok(Some(about)) = reader.receive() {
                if about.has_this_layout() {
                    *said = Some(*about);
                }
            }
            waiting |= said.is_none() && line.writers() > 0;
        }
        if !waiting || Instant::now() >= end {
            break;
        }
        sleep(Duration::from_millis(2));
    }
    Ok(lines.into_iter().filter_map(|l| l.2).collect())
}
