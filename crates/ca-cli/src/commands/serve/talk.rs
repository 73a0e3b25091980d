//! What goes through shared memory: the gateway of the devices, and the control.

use super::answer::answer;
use crate::{Failure, term};
use ca_core::Scene;
use ca_haptic::host::control::ControlServer;
use ca_haptic::host::{Event, Gateway, Rings, Running, Site};
use ca_haptic::rt::Wish;
use ca_haptic::serve::{Desk, GatewayEnds};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, channel};

/// Open lines; none for a scene that needs none.
pub(super) struct Talk {
    names: Vec<String>,
    site: Option<Site>,
    control: Option<ControlServer>,
    gateway: Option<Running>,
    events: Receiver<(u32, Event)>,
}

impl Talk {
    pub(super) fn open(names: &[String], scene: &Scene, ends: GatewayEnds, wish: Wish) -> Result<Talk, Failure> {
        let (tell, events) = channel();
        let mut talk = Talk { names: names.to_vec(), site: None, control: None, gateway: None, events };
        if names.is_empty() && scene.live.params.is_empty() {
            return Ok(talk);
        }
        let site = Site::of_user()?;
        site.sweep();
        if !names.is_empty() {
            let rings = Rings { incoming: ends.frames, outgoing: ends.forces, events: tell };
            talk.gateway = Some(Gateway::start(&site, names, rings, wish)?);
        }
        talk.control = Some(ControlServer::open(&site)?);
        talk.site = Some(site);
        Ok(talk)
    }

    /// Closes the lines once the last force is sent. What went over those of all devices: received, of these foreign,
    /// never seen, no room; sent, not sent.
    pub(super) fn end(self) -> Option<[(&'static str, u64); 6]> {
        let gateway = self.gateway?;
        let t = gateway.traffic.clone();
        drop(gateway);
        let counts = [
            ("received", &t.received),
            ("foreign", &t.foreign),
            ("missed", &t.missed),
            ("full", &t.full),
            ("sent", &t.sent),
            ("unsent", &t.unsent),
        ];
        Some(counts.map(|(name, n)| (name, n.load(Relaxed))))
    }

    pub(super) fn granted(&self) -> Option<String> {
        self.gateway.as_ref().map(|g| g.granted.to_string())
    }

    /// One turn: what devices do, what people ask. True where somebody asked to stop.
    pub(super) fn turn(&mut self, desk: &mut Desk, sweep: bool, quiet: bool) -> bool {
        while let Ok((k, event)) = self.events.try_recv() {
            let name = self.names.get(k as usize).map_or("?", String::as_str);
            match event {
                Event::Here { session } if !quiet => term::note(&format!("{name}: here (session {session:x})")),
                Event::Gone => term::warning(&format!("{name}: gone")),
                Event::Foreign { version, device } => term::warning(&format!(
                    "{name}: frames of version {version} for `{device}`, which are not used; rebuild the device process"
                )),
                _ => {}
            }
        }
        if sweep {
            if let Some(site) = &self.site {
                site.sweep();
            }
        }
        let mut leave = false;
        if let Some(control) = &mut self.control {
            control.poll(&mut |request| answer(desk, request, &mut leave));
        }
        leave
    }
}
