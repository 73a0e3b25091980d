//! The side of the server: N devices, one thread.
//!
//! Decides that this thread polls instead of waiting for events: a wait on a set of events allocates and costs more than
//! a look every 50 µs (a millisecond while no device is there), and the engine is woken by its own clock. Frames are only
//! looked at for their layout and their sender here; whether they can be true is the guard's question. A device is there
//! from its first frame and gone after a quarter of a second of silence, whatever its process does. Which server plays it is
//! decided then (`claim.rs`).

use super::claim::{Claim, News};
use super::error::{HostError, HostErrorKind};
use super::lines::{Frames, Line, Wakeup, check_name};
use super::room;
use super::site::{Ipc, Site};
use super::within::{LIMIT, within};
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

/// Time between two looks, and while no device is there.
const POLL: Duration = Duration::from_micros(50);
const IDLE: Duration = Duration::from_millis(1);
/// How long the end of the thread is waited for.
const LEAVE: Duration = Duration::from_secs(5);
/// Silence after which a device is gone \[ns\].
const SILENCE_NS: u64 = 250_000_000;

/// Between two words on a device that is another all the time \[ns\].
const REPORT_NS: u64 = 10_000_000;
/// Frames of a device in one look: one that sends without end is no reason for the others to wait.
const BURST: usize = 16;
/// Frames in a row that nobody misses without being gone.
const UNLIKELY: u64 = 1 << 32;

/// What happened to a device.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// its first frame came, of a process with this session
    Here {
        /// as in its frames
        session: u64,
    },
    /// it says who it is; again whenever that changes
    About(Box<About>),
    /// nothing came for a quarter of a second
    Gone,
    /// another server has it, in words; its frames are not used until that one ends
    Taken(String),
    /// frames came that are not used, and why; reported once a session of silence
    Foreign(FrameMismatch),
}

/// What was counted, for all devices together.
#[derive(Debug, Default)]
pub struct Traffic {
    /// device frames received
    pub received: AtomicU64,
    /// of these, not of this version or of another device
    pub foreign: AtomicU64,
    /// device frames that were never seen here: gaps in their numbers
    pub missed: AtomicU64,
    /// device frames for which the ring to the engine had no room
    pub full: AtomicU64,
    /// force frames sent
    pub sent: AtomicU64,
    /// force frames that could not be sent
    pub unsent: AtomicU64,
    /// device frames that are not used, and force frames that are not sent, because the device is not claimed
    pub unclaimed: [AtomicU64; 2],
}

/// One device, seen from here.
struct Place {
    name: String,
    uid: [u8; 16],
    frames: Subscriber<Ipc, DeviceFrame, ()>,
    says: Subscriber<Ipc, About, ()>,
    claim: Claim,
    bell: Notifier<Ipc>,
    session: u64,
    seq: u64,
    /// when the last frame came \[ns\]; 0 while it is gone
    heard: u64,
    complained: bool,
    /// when it last announced itself \[ns\]
    reported: u64,
    about: Option<About>,
}

impl Place {
    /// A frame that is used: whose it is, and what is missing before it.
    fn follow(
        &mut self,
        k: usize,
        frame: &DeviceFrame,
        now: u64,
        events: &mut VecDeque<(usize, Event)>,
        traffic: &Traffic,
    ) {
        if self.heard == 0 || self.session != frame.session {
            // one that changes all the time is reported now and then
            if now.saturating_sub(self.reported) > REPORT_NS {
                events.push_back((k, Event::Here { session: frame.session }));
                (self.reported, self.complained) = (now, false);
            }
        } else {
            let gap = frame.seq.saturating_sub(self.seq).saturating_sub(1);
            // a number from nowhere is not so many frames
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
    // after the ports that belong to it
    _node: Node<Ipc>,
    /// protects the prefix
    _site: Site,
}

impl Gateway {
    /// Opens the lines of these devices. Another server that has one of them is an error; one that was killed is not.
    ///
    /// # Errors
    /// Where a name is none or is taken, or the shared memory cannot be made.
    pub fn open<S: AsRef<str>>(site: &Site, names: &[S]) -> Result<Gateway, HostError> {
        Gateway::with(site, names, None)
    }

    /// The same; with `after`, each device is claimed `after` its first frame instead of now.
    fn with<S: AsRef<str>>(site: &Site, names: &[S], after: Option<Duration>) -> Result<Gateway, HostError> {
        super::stale_shm::strangers(site)?;
        let names: Vec<String> = names.iter().map(|n| n.as_ref().into()).collect();
        let need = room::DEVICE * names.len() as u64;
        // each device has its own patience
        let limit = LIMIT * u32::try_from(names.len()).unwrap_or(u32::MAX).clamp(1, 10);
        within(site, need, limit, move |site| Gateway::made(site, &names, after))
    }

    fn made(site: &Site, names: &[String], after: Option<Duration>) -> Result<Gateway, HostError> {
        let node = site.node("server")?;
        let mut places: Vec<Place> = Vec::new();
        for name in names {
            check_name(name)?;
            if places.iter().any(|p| p.name == *name) {
                let what = format!("the device `{name}` is wanted twice");
                return Err(HostError::new(HostErrorKind::Name, what, "name it once"));
            }
            let line = Frames::open(&node, name, Line::Out, 0)?;
            places.push(Place {
                // first the line that only one can have
                claim: match after {
                    Some(after) => Claim::when_it_speaks(site, line, after),
                    None => Claim::now(site, line)?,
                },
                frames: Frames::open(&node, name, Line::In, 0)?.subscriber(site, 0)?,
                says: Frames::open(&node, name, Line::About, 1)?.subscriber(site, 1)?,
                bell: Wakeup::open(&node, name)?.notifier(site)?,
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

    /// Takes all frames that came, oldest first: the number of the device, and the frame.
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
                if p.claim.is_ours() {
                    p.follow(k, &frame, now, &mut self.events, &self.traffic);
                    incoming(k, *frame);
                } else {
                    self.traffic.unclaimed[0].fetch_add(1, Relaxed);
                    p.claim.heard(&frame, now);
                }
            }
            match p.claim.news() {
                Some(News::Ours { told }) => {
                    if told {
                        self.traffic.unclaimed[1].fetch_sub(1, Relaxed);
                        self.traffic.sent.fetch_add(1, Relaxed);
                    }
                    if let Some(frame) = p.claim.waiting(now) {
                        self.traffic.unclaimed[0].fetch_sub(1, Relaxed);
                        p.follow(k, &frame, now, &mut self.events, &self.traffic);
                        incoming(k, frame);
                    }
                }
                Some(News::Taken(who)) => self.events.push_back((k, Event::Taken(who))),
                None => {}
            }
            if p.heard != 0 && now.saturating_sub(p.heard) > SILENCE_NS {
                p.heard = 0;
                self.events.push_back((k, Event::Gone));
            }
            for _ in 0..BURST {
                // what it says waits until it is ours
                let Some(Ok(Some(about))) = p.claim.is_ours().then(|| p.says.receive()) else { break };
                // bytes, since what is not finite differs from itself
                let new = p.about.is_none_or(|a| a.as_bytes() != about.as_bytes());
                if about.is_ours() && about.device == p.uid && new {
                    p.about = Some(*about);
                    self.events.push_back((k, Event::About(Box::new(*about))));
                }
            }
        }
    }

    /// Sends a force to device `k` and wakes it. Never waits. Its life is counted from `t_host_ns`, which whoever made it
    /// has written: a force that was held up on its way here is no fresh one.
    pub fn send(&mut self, k: usize, frame: &ForceFrame) {
        let Some(p) = self.places.get_mut(k) else { return };
        let Some(sent) = p.claim.send(frame) else {
            self.traffic.unclaimed[1].fetch_add(1, Relaxed);
            return;
        };
        let count = if sent { &self.traffic.sent } else { &self.traffic.unsent };
        count.fetch_add(1, Relaxed);
        // a sleeper that cannot be woken looks by itself sooner or later
        let _ = p.bell.notify();
    }

    /// The oldest event not yet reported: the number of the device, and what happened.
    pub fn event(&mut self) -> Option<(usize, Event)> {
        self.events.pop_front()
    }

    /// What device `k` said of itself last.
    pub fn about(&self, k: usize) -> Option<&About> {
        self.places.get(k)?.about.as_ref()
    }

    /// What was counted.
    pub fn traffic(&self) -> Arc<Traffic> {
        self.traffic.clone()
    }

    /// Moves frames between shared memory and rings until told to stop. Returns itself, with its places.
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
                // one who no longer listens does not want to know
                let _ = rings.events.send((k as u32, event));
            }
            sleep(if self.places.iter().any(|p| p.heard != 0) { POLL } else { IDLE });
        }
        // the last word of an engine is that forces are off: nobody should have to wait for its silence
        while let Ok((k, frame)) = rings.outgoing.pop() {
            self.send(k as usize, &frame);
        }
        self
    }

    /// Opens the lines in a new thread and runs there. Each device is claimed `after` its first frame: the server with the shorter
    /// delay gets it, and the other reports [`Event::Taken`].
    /// Asks the system for `request`; what it granted is in [`Running::granted`].
    ///
    /// # Errors
    /// As [`Gateway::open`], or where no thread can be started.
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
            .map_err(|e| HostError::system("no thread", e))?;
        let (traffic, granted) = reported.recv().map_err(|e| HostError::system("the gateway ended", e))??;
        Ok(Running { traffic, granted, stop, thread: Some(thread) })
    }
}

/// What joins the gateway thread to the rest of a server.
pub struct Rings {
    /// frames of devices, to the engine; where it is full, the newest are lost and counted
    pub incoming: rtrb::Producer<(u32, DeviceFrame)>,
    /// forces, from the engine
    pub outgoing: rtrb::Consumer<(u32, ForceFrame)>,
    /// what happens to devices, to somebody who has time
    pub events: mpsc::Sender<(u32, Event)>,
}

/// A gateway thread. Ends when dropped.
pub struct Running {
    /// what is counted
    pub traffic: Arc<Traffic>,
    /// what the system granted its thread
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
                // one that hangs in iceoryx2 holds up nobody
                return;
            }
            sleep(IDLE);
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Every device that speaks at this place, within this time: most answer within a few milliseconds, a device that sends
/// seldom within a second.
///
/// # Errors
/// Where the shared memory cannot be opened.
pub fn list_devices(site: &Site, patience: Duration) -> Result<Vec<About>, HostError> {
    within(site, room::LOOK, LIMIT + patience, move |site| said(site, patience))
}

fn said(site: &Site, patience: Duration) -> Result<Vec<About>, HostError> {
    let node = site.node("list")?;
    let mut lines = Vec::new();
    for name in super::lines::devices(site)? {
        let line = Frames::<About>::open(&node, &name, Line::About, 1)?;
        let reader = line.subscriber(site, 1)?;
        lines.push((line, reader, None));
    }
    let end = Instant::now() + patience;
    loop {
        let mut waiting = false;
        for (line, reader, said) in &mut lines {
            while let Ok(Some(about)) = reader.receive() {
                if about.is_ours() {
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
