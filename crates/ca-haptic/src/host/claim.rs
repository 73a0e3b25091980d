//! Claims a device for one server.
//!
//! A server claims a device when the device sends, not when the server starts: most models name a device that is
//! absent, and two such models may be open at the same time. The claim is the only publisher of the service `out`, and
//! a server holds it until it ends. Other servers ignore the frames of the device and try again once a second while it
//! sends. A separate thread makes the claim: iceoryx2 may wait a second for a process that is just starting or ending,
//! and the forces of other devices must not wait.

use super::error::HostError;
use super::free_memory;
use super::services::Frames;
use super::site::{Ipc, Site};
use super::timeout::{LIMIT, with_timeout};
use crate::frame::{DeviceFrame, ForceFrame};
use iceoryx2::port::publisher::Publisher;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

/// Interval between attempts to claim a device that another server has \[ns\].
const RETRY_NS: u64 = 1_000_000_000;
/// Age up to which a frame from before the claim is used \[ns\]. A device with an older one has disconnected.
const MAX_AGE_NS: u64 = 250_000_000;

type Forces = Publisher<Ipc, ForceFrame, ()>;

pub(super) enum ClaimResult {
    /// This server has the device, and [`Claim::take_frame`] returns its newest frame.
    Granted {
        /// True if the newest force was sent to the device.
        force_sent: bool,
    },
    /// Another server has it: message, once for each server.
    Taken(String),
}

pub(super) struct Claim {
    site: Site,
    service: Arc<Frames<ForceFrame>>,
    forces: Option<Forces>,
    attempt: Option<Receiver<Result<Forces, HostError>>>,
    /// Delay from its first frame to the claim \[ns\].
    after: u64,
    /// Time of the next claim \[ns\]; `None` before the first frame.
    next: Option<u64>,
    /// Last message of [`ClaimResult::Taken`].
    last_message: String,
    /// Newest unused frame, and its arrival time \[ns\].
    frame: Option<(DeviceFrame, u64)>,
    force: Option<ForceFrame>,
}

impl Claim {
    /// Claims the device a time `after` its first frame, so that a server with a shorter delay gets it.
    pub(super) fn on_first_frame(site: &Site, service: Frames<ForceFrame>, after: Duration) -> Claim {
        Claim {
            site: site.clone(),
            service: Arc::new(service),
            forces: None,
            attempt: None,
            after: after.as_nanos() as u64,
            next: None,
            last_message: String::new(),
            frame: None,
            force: None,
        }
    }

    pub(super) fn now(site: &Site, service: Frames<ForceFrame>) -> Result<Claim, HostError> {
        let forces = service.publisher(site)?;
        Ok(Claim { forces: Some(forces), ..Claim::on_first_frame(site, service, Duration::ZERO) })
    }

    pub(super) fn is_granted(&self) -> bool {
        self.forces.is_some()
    }

    /// Notes a frame of an unclaimed device that came at `now` \[ns\], and starts a claim when one is due.
    pub(super) fn note_frame(&mut self, frame: &DeviceFrame, now: u64) {
        self.frame = Some((*frame, now));
        let next = *self.next.get_or_insert(now + self.after);
        if self.attempt.is_some() || now < next {
            return;
        }
        self.next = Some(now + RETRY_NS);
        let (tell, result) = channel();
        let (site, service) = (self.site.clone(), self.service.clone());
        let thread = std::thread::Builder::new().name("ca claims".into()).spawn(move || {
            let _ = tell.send(with_timeout(&site, free_memory::DEVICE, LIMIT, move |site| service.publisher(site)));
        });
        self.attempt = thread.is_ok().then_some(result);
    }

    /// Returns the result of a claim, once.
    pub(super) fn result(&mut self) -> Option<ClaimResult> {
        match self.attempt.as_ref()?.try_recv() {
            Ok(Ok(forces)) => {
                // a device applies no force before it has received a frame of an engine at rest
                let force_sent = self.force.take().is_some_and(|force| forces.send_copy(force).is_ok());
                (self.forces, self.attempt) = (Some(forces), None);
                Some(ClaimResult::Granted { force_sent })
            }
            Ok(Err(e)) => {
                self.attempt = None;
                let new = self.last_message != e.what;
                self.last_message = e.what;
                new.then(|| ClaimResult::Taken(self.last_message.clone()))
            }
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                self.attempt = None;
                None
            }
        }
    }

    /// Returns the newest frame from before the claim, once, if it is younger than [`MAX_AGE_NS`].
    pub(super) fn take_frame(&mut self, now: u64) -> Option<DeviceFrame> {
        self.frame.take().filter(|(_, at)| now.saturating_sub(*at) < MAX_AGE_NS).map(|(frame, _)| frame)
    }

    /// Sends a force. Returns true if it was sent, and `None` for an unclaimed device.
    pub(super) fn send(&mut self, force: &ForceFrame) -> Option<bool> {
        let sent = self.forces.as_ref().map(|forces| forces.send_copy(*force).is_ok());
        if sent.is_none() {
            self.force = Some(*force);
        }
        sent
    }
}
