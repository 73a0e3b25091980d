//! Claims a device for one server.
//!
//! A server claims a device when the device sends, not when the server starts: most models name a device that is
//! absent, and two such models may be open at the same time. The claim is the only publisher of the service `out`, and
//! a server holds it until it ends. Other servers ignore the frames of the device and try again once a second while it
//! sends. A separate thread makes the claim: iceoryx2 may wait a second for a process that is just starting or ending,
//! and the forces of other devices must not wait.

use super::error::HostError;
use super::lines::Frames;
use super::room;
use super::site::{Ipc, Site};
use super::within::{LIMIT, within};
use crate::frame::{DeviceFrame, ForceFrame};
use iceoryx2::port::publisher::Publisher;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

/// Interval between attempts to claim a device that another server has \[ns\].
const AGAIN_NS: u64 = 1_000_000_000;
/// Age up to which a frame from before the claim is used \[ns\]. A device with an older one has disconnected.
const FRESH_NS: u64 = 250_000_000;

type Forces = Publisher<Ipc, ForceFrame, ()>;

pub(super) enum News {
    /// This server has the device, and [`Claim::waiting`] returns its newest frame.
    Ours {
        /// True if the newest force was sent to the device.
        told: bool,
    },
    /// Another server has it: message, once for each server.
    Taken(String),
}

pub(super) struct Claim {
    site: Site,
    line: Arc<Frames<ForceFrame>>,
    forces: Option<Forces>,
    asked: Option<Receiver<Result<Forces, HostError>>>,
    /// Delay from its first frame to the claim \[ns\].
    after: u64,
    /// Time of the next claim \[ns\]; `None` before the first frame.
    next: Option<u64>,
    /// Last message of [`News::Taken`].
    said: String,
    /// Newest unused frame, and its arrival time \[ns\].
    frame: Option<(DeviceFrame, u64)>,
    force: Option<ForceFrame>,
}

impl Claim {
    /// Claims the device a time `after` its first frame, so that a server with a shorter delay gets it.
    pub(super) fn when_it_speaks(site: &Site, line: Frames<ForceFrame>, after: Duration) -> Claim {
        Claim {
            site: site.clone(),
            line: Arc::new(line),
            forces: None,
            asked: None,
            after: after.as_nanos() as u64,
            next: None,
            said: String::new(),
            frame: None,
            force: None,
        }
    }

    pub(super) fn now(site: &Site, line: Frames<ForceFrame>) -> Result<Claim, HostError> {
        let forces = line.publisher(site)?;
        Ok(Claim { forces: Some(forces), ..Claim::when_it_speaks(site, line, Duration::ZERO) })
    }

    pub(super) fn is_ours(&self) -> bool {
        self.forces.is_some()
    }

    /// Notes a frame of an unclaimed device that came at `now` \[ns\], and starts a claim when one is due.
    pub(super) fn heard(&mut self, frame: &DeviceFrame, now: u64) {
        self.frame = Some((*frame, now));
        let next = *self.next.get_or_insert(now + self.after);
        if self.asked.is_some() || now < next {
            return;
        }
        self.next = Some(now + AGAIN_NS);
        let (tell, told) = channel();
        let (site, line) = (self.site.clone(), self.line.clone());
        let thread = std::thread::Builder::new().name("ca claims".into()).spawn(move || {
            let _ = tell.send(within(&site, room::DEVICE, LIMIT, move |site| line.publisher(site)));
        });
        self.asked = thread.is_ok().then_some(told);
    }

    /// Returns the result of a claim, once.
    pub(super) fn news(&mut self) -> Option<News> {
        match self.asked.as_ref()?.try_recv() {
            Ok(Ok(forces)) => {
                // a device applies no force before it has received a frame of an engine at rest
                let told = self.force.take().is_some_and(|force| forces.send_copy(force).is_ok());
                (self.forces, self.asked) = (Some(forces), None);
                Some(News::Ours { told })
            }
            Ok(Err(e)) => {
                self.asked = None;
                let new = self.said != e.what;
                self.said = e.what;
                new.then(|| News::Taken(self.said.clone()))
            }
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                self.asked = None;
                None
            }
        }
    }

    /// Returns the newest frame from before the claim, once, if it is younger than [`FRESH_NS`].
    pub(super) fn waiting(&mut self, now: u64) -> Option<DeviceFrame> {
        self.frame.take().filter(|(_, at)| now.saturating_sub(*at) < FRESH_NS).map(|(frame, _)| frame)
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
