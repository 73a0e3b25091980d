//! The client for device processes: sends positions and receives forces.
//!
//! A device process needs five calls: open, send, read the newest force, wait for one, and [`DeviceClient::safe_force`]
//! for the forces that may reach the motors. Device and engine may start in either order. An engine that is killed,
//! stopped or restarted is not an error: forces are zero (see [`force_watchdog`](super::force_watchdog)) until the next engine sends any.

use super::error::HostError;
use super::force_watchdog::ForceWatchdog;
use super::free_memory;
use super::services::{Frames, Service, Wakeup, check_name};
use super::session::session_number;
use super::site::{Ipc, Site};
use super::timeout::{LIMIT, with_timeout};
use crate::frame::{About, Cause, DOF, DeviceFrame, ForceFrame, VERSION, text, uid};
use crate::rt::now_ns;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::Node;
use std::time::Duration;

/// Interval between `About` messages \[ns\].
const EVERY_NS: u64 = 1_000_000_000;

/// The connection of a device process to the engine.
pub struct DeviceClient {
    about: About,
    seq: u64,
    reported: u64,
    held: Option<u64>,
    /// Number of the force frame last returned to the caller.
    given: u64,
    watchdog: ForceWatchdog,
    // ports are dropped before their node
    frames: Publisher<Ipc, DeviceFrame, ()>,
    forces: Subscriber<Ipc, ForceFrame, ()>,
    says: Publisher<Ipc, About, ()>,
    wakeup: Listener<Ipc>,
    _node: Node<Ipc>,
    /// Holds the lock on the prefix.
    _site: Site,
}

impl DeviceClient {
    /// Opens the services of the device that [`About::device`] names, and fills in session and header of `about`.
    ///
    /// # Errors
    /// If the name is invalid or taken, the shared memory belongs to another user or is too small, or a call to
    /// iceoryx2 fails.
    pub fn open(site: &Site, about: About) -> Result<DeviceClient, HostError> {
        let name = text(&about.device);
        check_name(&name)?;
        super::stale_shm::strangers(site)?;
        with_timeout(site, free_memory::DEVICE, LIMIT, move |site| DeviceClient::made(site, &name, about))
    }

    fn made(site: &Site, name: &str, mut about: About) -> Result<DeviceClient, HostError> {
        (about.magic, about.version, about.layout) = (About::MAGIC, VERSION, About::LAYOUT);
        (about.device, about.session) = (uid(name), session_number());
        let node = site.node(&format!("device {name}"))?;
        // the exclusive service first
        let frames = Frames::open(&node, name, Service::In, 0)?.publisher(site)?;
        let forces = Frames::open(&node, name, Service::Out, 0)?.subscriber(site, 0)?;
        let says = Frames::open(&node, name, Service::About, 1)?.publisher(site)?;
        let wakeup = Wakeup::open(&node, name)?.listener(site)?;
        let watchdog = ForceWatchdog::new(about.device);
        let mut client = DeviceClient {
            about,
            seq: 0,
            reported: 0,
            held: None,
            given: 0,
            watchdog,
            frames,
            forces,
            says,
            wakeup,
            _node: node,
            _site: site.clone(),
        };
        client.send_about(now_ns())?;
        Ok(client)
    }

    /// Returns the description that the device sends.
    pub fn about(&self) -> &About {
        &self.about
    }

    fn send_about(&mut self, now: u64) -> Result<(), HostError> {
        self.reported = now;
        self.says
            .send_copy(self.about)
            .map_err(|e| HostError::system("the description of the device cannot be sent", e))?;
        Ok(())
    }

    /// Reports that the motors applied the force frame `seq` until the next frame. The next [`DeviceClient::send`] then
    /// acknowledges this frame and sends the `cause` of the caller unchanged. A device needs this if it applies forces
    /// later than it reads them, or by other rules than [`DeviceClient::safe_force`].
    pub fn held(&mut self, seq: u64) {
        self.held = Some(seq);
    }

    /// Sends a frame and returns the number of its readers.
    ///
    /// It fills in header, device, session, `seq`, time, `ack` (the last force frame returned by
    /// [`DeviceClient::safe_force`] or [`DeviceClient::force`]), and a period of 0. If `cause` is 0, it sends the cause
    /// for which the force is zero, and leaves `frame.cause` unchanged. 0 readers are not an error, because the engine
    /// may start later.
    ///
    /// # Errors
    /// If a call to iceoryx2 fails.
    pub fn send(&mut self, frame: &mut DeviceFrame) -> Result<usize, HostError> {
        let now = now_ns();
        if now.saturating_sub(self.reported) >= EVERY_NS {
            self.send_about(now)?;
        } else {
            // a new reader gets the last message at once
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
            // Only causes that the device found itself are sent. A cause of the engine becomes `Disarmed`, because the
            // engine would take its own fault for a new one. So does a missing engine, if there was none before.
            let found = self.watchdog.last().map_or(Cause::Disarmed, |_| self.watchdog.cause(now));
            sent.cause = match found {
                Cause::None | Cause::WatchdogOut | Cause::Disconnect => found,
                _ => Cause::Disarmed,
            } as u16;
        }
        self.frames.send_copy(sent).map_err(|e| HostError::system("a frame cannot be sent", e))
    }

    /// Receives all waiting frames. Returns true if one is newer than the last.
    fn drain(&mut self) -> bool {
        let mut newer = false;
        // a frame that cannot be received counts as missing, and `watchdog` returns zero force
        while let Ok(Some(frame)) = self.forces.receive() {
            newer |= self.watchdog.take(&frame);
        }
        newer
    }

    /// Returns the newest force frame with this layout and for this device, if one came since the last call. It is for
    /// display and measurement; use [`DeviceClient::safe_force`] for motors.
    pub fn force(&mut self) -> Option<ForceFrame> {
        if self.drain() { self.acknowledge().copied() } else { None }
    }

    /// Returns the forces that may reach the motors now \[N\]. They are zero when the last frame is older than its
    /// `ttl_us`, when its mode is off or fault, and until the session of the engine has sent a frame with one of these
    /// modes.
    pub fn safe_force(&mut self) -> [f64; DOF] {
        self.drain();
        self.acknowledge();
        self.watchdog.force(now_ns())
    }

    /// Returns the newest frame and notes it as the one that the motors hold from now on. A frame that is read only for
    /// [`DeviceClient::cause`] does not reach the motors and must not be acknowledged.
    fn acknowledge(&mut self) -> Option<&ForceFrame> {
        let last = self.watchdog.last();
        self.given = last.map_or(0, |f| f.seq);
        last
    }

    /// Returns why [`DeviceClient::safe_force`] is zero; [`Cause::None`] if it returns a force of the engine.
    pub fn cause(&mut self) -> Cause {
        self.drain();
        self.watchdog.cause(now_ns())
    }

    /// Returns the state of the connection to the engine.
    pub fn watchdog(&self) -> &ForceWatchdog {
        &self.watchdog
    }

    /// Sleeps until a force frame comes, at most for `timeout`. Returns true if one came.
    pub fn wait(&mut self, timeout: Duration) -> bool {
        self.wakeup.timed_wait(|_| {}, timeout).map_or_else(
            |_| {
                // sleeps on an error too, so that the caller does not spin
                std::thread::sleep(timeout);
                false
            },
            |n| n > 0,
        )
    }
}
