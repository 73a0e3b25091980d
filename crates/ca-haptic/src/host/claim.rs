//! Which server plays a device.
//!
//! A server claims a device when the device sends, not when the server starts: most models name a device that is absent, and two
//! of them may be open at the same time. The claim is the only publisher on the line of forces. The server with the claim keeps it
//! until it ends. Other servers ignore the frames of the device, and claim it again once a second while it sends. A separate
//! thread makes the claim, because iceoryx2 may wait a second for a process that comes or goes, and forces of other devices must
//! not wait.

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

/// Between two claims of a device that another server has \[ns\].
const AGAIN_NS: u64 = 1_000_000_000;
/// A frame that waited longer is of a device that has gone \[ns\].
const FRESH_NS: u64 = 250_000_000;

type Forces = Publisher<Ipc, ForceFrame, ()>;

/// Result of a claim.
pub(super) enum News {
    /// the device is ours, and [`Claim::waiting`] gives its newest frame
    Ours {
        /// the newest force was sent to it
        told: bool,
    },
    /// another server has it, in words; said once of each
    Taken(String),
}

/// A device, ours or not.
pub(super) struct Claim {
    site: Site,
    line: Arc<Frames<ForceFrame>>,
    forces: Option<Forces>,
    asked: Option<Receiver<Result<Forces, HostError>>>,
    /// how long others may claim it first \[ns\]
    after: u64,
    /// when it is claimed \[ns\]; none where the device has not spoken
    next: Option<u64>,
    /// what was said of the server that has it
    said: String,
    /// the newest frame that was not used, and when it came \[ns\]
    frame: Option<(DeviceFrame, u64)>,
    /// the newest force that was not sent
    force: Option<ForceFrame>,
}

impl Claim {
    /// Of a device that is claimed when it speaks, `after` which others have had their turn.
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

    /// Of a device that is claimed now.
    pub(super) fn now(site: &Site, line: Frames<ForceFrame>) -> Result<Claim, HostError> {
        let forces = line.publisher(site)?;
        Ok(Claim { forces: Some(forces), ..Claim::when_it_speaks(site, line, Duration::ZERO) })
    }

    pub(super) fn is_ours(&self) -> bool {
        self.forces.is_some()
    }

    /// A frame of a device that is not ours came at `now` \[ns\].
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

    /// The result of a claim, once.
    pub(super) fn news(&mut self) -> Option<News> {
        match self.asked.as_ref()?.try_recv() {
            Ok(Ok(forces)) => {
                // a device gives no force before it saw its engine at rest
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

    /// The frame that came before the device was ours, once, and not where it is of long ago.
    pub(super) fn waiting(&mut self, now: u64) -> Option<DeviceFrame> {
        self.frame.take().filter(|(_, at)| now.saturating_sub(*at) < FRESH_NS).map(|(frame, _)| frame)
    }

    /// Sends a force; whether it went, or nothing of a device that is not ours.
    pub(super) fn send(&mut self, force: &ForceFrame) -> Option<bool> {
        let sent = self.forces.as_ref().map(|forces| forces.send_copy(*force).is_ok());
        if sent.is_none() {
            self.force = Some(*force);
        }
        sent
    }
}
