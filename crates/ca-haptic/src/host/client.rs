//! The side of a device: positions out, forces in.
//!
//! Decides that a device process needs five calls and no knowledge of who comes first: it opens or makes its lines,
//! sends, takes the newest force, may wait for it, and asks [`DeviceClient::safe_force`] for what may reach a motor. An
//! engine that is killed, stopped or started again is no error here: forces become zero (see [`watch`](super::watch))
//! and come back with the next engine.

use super::error::HostError;
use super::lines::{Frames, Line, Wakeup, check_name};
use super::room;
use super::session::session;
use super::site::{Ipc, Site};
use super::watch::Watch;
use super::within::{LIMIT, within};
use crate::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, VERSION, text, uid};
use crate::rt::now_ns;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::Node;
use std::time::Duration;

/// How often a device says who it is \[ns\].
const EVERY_NS: u64 = 1_000_000_000;

/// A device on its lines.
pub struct DeviceClient {
    about: About,
    seq: u64,
    reported: u64,
    held: Option<u64>,
    /// number of the force frame that the caller was given last
    given: u64,
    watch: Watch,
    // ports before the node they belong to
    frames: Publisher<Ipc, DeviceFrame, ()>,
    forces: Subscriber<Ipc, ForceFrame, ()>,
    says: Publisher<Ipc, About, ()>,
    bell: Listener<Ipc>,
    _node: Node<Ipc>,
    /// protects the prefix
    _site: Site,
}

impl DeviceClient {
    /// Opens the lines of the device that `about` names ([`About::device`]); session and header are filled in here.
    ///
    /// # Errors
    /// Where the name is none or is taken, the shared memory is not ours or too small, or iceoryx2 refuses.
    pub fn open(site: &Site, about: About) -> Result<DeviceClient, HostError> {
        let name = text(&about.device);
        check_name(&name)?;
        super::stale_shm::strangers(site)?;
        within(site, room::DEVICE, LIMIT, move |site| DeviceClient::made(site, &name, about))
    }

    fn made(site: &Site, name: &str, mut about: About) -> Result<DeviceClient, HostError> {
        (about.magic, about.version, about.layout) = (About::MAGIC, VERSION, About::LAYOUT);
        (about.device, about.session) = (uid(name), session());
        let node = site.node(&format!("device {name}"))?;
        // first the line that only one can have
        let frames = Frames::open(&node, name, Line::In, 0)?.publisher(site)?;
        let forces = Frames::open(&node, name, Line::Out, 0)?.subscriber(site, 0)?;
        let says = Frames::open(&node, name, Line::About, 1)?.publisher(site)?;
        let bell = Wakeup::open(&node, name)?.listener(site)?;
        let watch = Watch::new(about.device);
        let mut client = DeviceClient {
            about,
            seq: 0,
            reported: 0,
            held: None,
            given: 0,
            watch,
            frames,
            forces,
            says,
            bell,
            _node: node,
            _site: site.clone(),
        };
        client.tell(now_ns())?;
        Ok(client)
    }

    /// What it says of itself.
    pub fn about(&self) -> &About {
        &self.about
    }

    fn tell(&mut self, now: u64) -> Result<(), HostError> {
        self.reported = now;
        self.says.send_copy(self.about).map_err(|e| HostError::system("what the device is cannot be said", e))?;
        Ok(())
    }

    /// Says that what moved the motors until the next frame was force frame `seq`, and not the newest, as in a device
    /// that takes forces later than they come, or by other rules than [`DeviceClient::safe_force`]. Holds for one
    /// [`DeviceClient::send`], which then leaves it to the caller to say why there is no force.
    pub fn held(&mut self, seq: u64) {
        self.held = Some(seq);
    }

    /// Sends a frame: fills in who it is from (header, device, session), its number, the last force that was asked for
    /// ([`DeviceClient::safe_force`], [`DeviceClient::force`]), the time and, where 0, the period; on the wire also why
    /// there is no force, where the frame gives no reason of its own. Returns how many read it; 0 is no error, the engine
    /// may come later.
    ///
    /// # Errors
    /// Where iceoryx2 refuses; a frame that nobody reads is no error.
    pub fn send(&mut self, frame: &mut DeviceFrame) -> Result<usize, HostError> {
        let now = now_ns();
        if now.saturating_sub(self.reported) >= EVERY_NS {
            self.tell(now)?;
        } else {
            // one who came since is given the last at once
            let _ = self.says.update_connections();
        }
        self.seq += 1;
        (frame.magic, frame.version, frame.layout) = (DeviceFrame::MAGIC, VERSION, DeviceFrame::LAYOUT);
        (frame.device, frame.session, frame.seq) = (self.about.device, self.about.session, self.seq);
        let own = self.held.is_none();
        frame.ack = self.held.take().unwrap_or(self.given);
        frame.t_host_ns = now;
        if frame.period_ns == 0 && self.about.rate > 0 {
            frame.period_ns = 1_000_000_000 / self.about.rate;
        }
        let mut sent = *frame;
        if own && sent.cause == 0 {
            // what it found itself; else, where the engine gives no force, that it was not asked for one: why, the engine
            // knows better, and would take its own fault for another. One that never heard of an engine misses none
            let found = self.watch.last().map_or(Cause::Disarmed, |_| self.watch.cause(now));
            sent.cause = match found {
                Cause::None | Cause::WatchdogOut | Cause::Disconnect => found,
                _ => Cause::Disarmed,
            } as u16;
        }
        self.frames.send_copy(sent).map_err(|e| HostError::system("a frame cannot be sent", e))
    }

    /// Takes all that came. True if there is a newer frame than before.
    fn drain(&mut self) -> bool {
        let mut newer = false;
        // what cannot be received is not there: the watch makes it zero
        while let Ok(Some(frame)) = self.forces.receive() {
            newer |= self.watch.take(&frame);
        }
        newer
    }

    /// The newest force frame of this layout and for this device, if one came since the last call. For display and
    /// measurement; motors get [`DeviceClient::safe_force`].
    pub fn force(&mut self) -> Option<ForceFrame> {
        if self.drain() { self.give().copied() } else { None }
    }

    /// What may reach the motors now \[N\]: zeros after the life of the last frame, when off or at fault, from an engine
    /// not yet seen at rest.
    pub fn safe_force(&mut self) -> [f64; DOF] {
        self.drain();
        self.give();
        self.watch.force(now_ns())
    }

    /// The newest frame, which is what the motors hold from now on: one that is only looked at ([`DeviceClient::cause`])
    /// acts on nobody, and must not be acknowledged.
    fn give(&mut self) -> Option<&ForceFrame> {
        let last = self.watch.last();
        self.given = last.map_or(0, |f| f.seq);
        last
    }

    /// Why [`DeviceClient::safe_force`] gives nothing; [`Cause::None`] where it gives a force.
    pub fn cause(&mut self) -> Cause {
        self.drain();
        self.watch.cause(now_ns())
    }

    /// What it knows of its engine.
    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    /// Sleeps until a force frame comes, at most this long. True if one came.
    pub fn wait(&mut self, timeout: Duration) -> bool {
        self.bell.timed_wait(|_| {}, timeout).map_or_else(
            |_| {
                // a bell that cannot be heard does not make the caller spin
                std::thread::sleep(timeout);
                false
            },
            |n| n > 0,
        )
    }
}
