//! What goes through shared memory: the gateway of the devices, and the control.

use super::answer::answer;
use crate::Failure;
use ca_core::Scene;
use ca_haptic::engine::Setup;
use ca_haptic::frame::About;
use ca_haptic::host::control::ControlServer;
use ca_haptic::host::{Event, Gateway, Rings, Running, Site};
use ca_haptic::profile::Profile;
use ca_haptic::rt::Wish;
use ca_haptic::serve::{Desk, GatewayEnds};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, channel};

/// Open lines; none for a scene that needs none.
pub(super) struct Talk {
    names: Vec<String>,
    profiles: Vec<Profile>,
    site: Option<Site>,
    control: Option<ControlServer>,
    gateway: Option<Running>,
    events: Receiver<(u32, Event)>,
}

impl Talk {
    pub(super) fn open(setups: &[Setup], scene: &Scene, ends: GatewayEnds, wish: Wish) -> Result<Talk, Failure> {
        let (tell, events) = channel();
        let names: Vec<String> = setups.iter().map(|s| s.device.clone()).collect();
        let profiles = setups.iter().map(|s| s.profile.clone()).collect();
        let mut talk = Talk { names: names.clone(), profiles, site: None, control: None, gateway: None, events };
        if names.is_empty() && scene.live.params.is_empty() {
            return Ok(talk);
        }
        let site = Site::of_user()?;
        site.sweep();
        if !names.is_empty() {
            let rings = Rings { incoming: ends.frames, outgoing: ends.forces, events: tell };
            talk.gateway = Some(Gateway::start(&site, &names, rings, wish)?);
        }
        talk.control = Some(ControlServer::open(&site)?);
        talk.site = Some(site);
        Ok(talk)
    }

    /// Closes the lines once the last force is sent. What went over those of all devices: received, of these foreign,
    /// never seen, no room; sent, not sent.
    pub(super) fn end(self) -> Option<super::told::Traffic> {
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
    pub(super) fn turn(&mut self, desk: &mut Desk, sweep: bool) -> bool {
        while let Ok((k, event)) = self.events.try_recv() {
            let name = self.names.get(k as usize).map_or("?", String::as_str);
            match event {
                Event::Here { session } => desk.say(false, format!("{name}: here (session {session:x})")),
                Event::Gone => desk.say(true, format!("{name}: gone")),
                Event::Foreign(why) => {
                    let fix = why.fix();
                    desk.say(true, format!("{name}: frames came that {why}, and are not used; {fix}"));
                }
                Event::About(about) => {
                    for what in self.profiles.get(k as usize).map_or_else(Vec::new, |p| differs(p, &about)) {
                        desk.say(true, format!("{name}: {what}"));
                    }
                }
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

/// Where a device says less of itself than its profile does, which is what the guard goes by.
fn differs(p: &Profile, a: &About) -> Vec<String> {
    let n = (a.n as usize).min(p.dof as usize);
    let least = a.force[..n].iter().copied().fold(f32::INFINITY, f32::min);
    let mut list = Vec::new();
    if u32::from(a.n) < p.dof {
        list.push(format!("has {} degrees of freedom, its profile `{}` {}", a.n, p.name, p.dof));
    }
    if f64::from(least) < p.force * (1.0 - 1e-6) && least > 0.0 {
        list.push(format!("gives at most {least} N, its profile `{}` {}", p.name, p.force));
    }
    if (f64::from(a.rate) / p.rate - 1.0).abs() > 0.05 {
        list.push(format!("sends {} frames a second, its profile `{}` {}", a.rate, p.name, p.rate));
    }
    list
}
