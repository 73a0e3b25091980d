//! Speaks to other processes: to devices by the gateway, to `ca set`, `ca disarm` and the like by the control.

use crate::language::ModelLanguage;
use crate::outcome::Failure;
use crate::term;
use ca_core::{Input, Scene, Unit};
use ca_haptic::coupling;
use ca_haptic::engine::Setup;
use ca_haptic::frame::About;
use ca_haptic::host::control::ControlServer;
use ca_haptic::host::{Event, Gateway, Rings, Running, Site};
use ca_haptic::profile::Profile;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::{GatewayEnds, Recorder};
use ca_lab::take::dofs;
use ca_model::quantity::{show, six};
use ca_session::{Change, answer};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Delay of claims by a server without the control, so that the server with the control is first.
const SECOND: Duration = Duration::from_millis(300);

/// Open lines. A scene without devices, live parameters and page needs none; the control also ends and sets a page.
pub(super) struct Talk {
    names: Vec<String>,
    setups: Vec<Setup>,
    /// what the scene wants of devices that nobody has described, and what they may do at most
    unknown: Vec<Option<Unknown>>,
    /// devices that said what they are, and the engine does not know it yet
    refits: Vec<u32>,
    site: Option<Site>,
    control: Option<ControlServer>,
    gateway: Option<Running>,
    events: Receiver<(u32, Event)>,
}

impl Talk {
    /// Opens what the scene needs. Beside another server, which has the control of this user, a scene with a `page` goes without: it
    /// is set and armed in its page. The other server has a device first that both name.
    pub(super) fn open(
        setups: &[Setup],
        unknown: Vec<Option<Profile>>,
        scene: &Scene,
        ends: GatewayEnds,
        request: RtRequest,
        page: bool,
    ) -> Result<Talk, Failure> {
        let (tell, events) = channel();
        let names: Vec<String> = setups.iter().map(|s| s.device.clone()).collect();
        let wanted = setups.iter().map(|s| dofs(scene, &s.device));
        let unknown = unknown.into_iter().zip(wanted).map(|(p, wanted)| Some(Unknown { most: p?, wanted })).collect();
        let setups = setups.to_vec();
        let mut talk = Talk {
            names: names.clone(),
            setups,
            unknown,
            refits: Vec::new(),
            site: None,
            control: None,
            gateway: None,
            events,
        };
        if names.is_empty() && scene.live.params.is_empty() && !page {
            return Ok(talk);
        }
        let site = Site::of_user()?;
        if !names.is_empty() {
            site.sweep();
        }
        match ControlServer::open(&site) {
            Ok(control) => talk.control = Some(control),
            Err(e) if page => {
                let verbs = if names.is_empty() {
                    "`ca set` and `ca stop`"
                } else {
                    "`ca set`, `ca stop`, `ca arm` and `ca disarm`"
                };
                term::note(&format!("{verbs} do not reach this one, its page does: {}", e.what));
            }
            Err(e) => return Err(e.into()),
        }
        if !names.is_empty() {
            let rings = Rings { incoming: ends.frames, outgoing: ends.forces, events: tell };
            let after = if talk.control.is_some() { Duration::ZERO } else { SECOND };
            talk.gateway = Some(Gateway::start(&site, &names, rings, request, after)?);
        }
        talk.site = Some(site);
        Ok(talk)
    }

    /// Closes the lines once the last force is sent. What went over those of all devices: received, of these foreign,
    /// never seen, no room; sent, not sent.
    pub(super) fn end(self) -> Option<super::summary::Traffic> {
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
            ("unclaimed", &t.unclaimed[0]),
            ("unclaimed_forces", &t.unclaimed[1]),
        ];
        Some(counts.map(|(name, n)| (name, n.load(Relaxed))))
    }

    pub(super) fn granted(&self) -> Option<String> {
        self.gateway.as_ref().map(|g| g.granted.to_string())
    }

    /// What each device is, as far as is known.
    pub(super) fn setups(&self) -> Option<&[Setup]> {
        self.refits.is_empty().then_some(&self.setups)
    }

    /// One turn: what devices do, what people ask. True where somebody asked to stop. `change` takes numbers of
    /// the model that are not live, where it can be made anew.
    pub(super) fn turn(&mut self, recorder: &mut Recorder, sweep: bool, mut change: Option<Change<'_>>) -> bool {
        while let Ok((k, event)) = self.events.try_recv() {
            let name = self.names.get(k as usize).map_or("?", String::as_str);
            match event {
                Event::Here { session } => recorder.say(false, format!("{name}: here (session {session:x})")),
                Event::Gone => recorder.say(true, format!("{name}: gone")),
                Event::Taken(who) => {
                    recorder.say(true, format!("{who}; that process keeps the device until it ends"));
                }
                Event::Foreign(why) => {
                    let fix = why.fix();
                    recorder.say(true, format!("{name}: frames came that {why}, and are not used; {fix}"));
                }
                Event::About(about) => {
                    let Some(setup) = self.setups.get_mut(k as usize) else { continue };
                    match &self.unknown[k as usize] {
                        Some(unknown) => match unknown.fit(setup, &about, recorder.scene()) {
                            Ok(Some(said)) => {
                                recorder.say(false, format!("{name}: {said}"));
                                self.refits.push(k);
                            }
                            Ok(None) => {}
                            Err(why) => recorder.say(true, format!("{name}: {why}")),
                        },
                        None => {
                            for what in differs(&setup.profile, &about) {
                                recorder.say(true, format!("{name}: {what}"));
                            }
                        }
                    }
                }
            }
        }
        // an engine that has more to do than it can take is asked again
        self.refits.retain(|k| recorder.refit(*k, self.setups[*k as usize].clone()).is_err());
        if let (true, Some(site), Some(_)) = (sweep, &self.site, &self.gateway) {
            site.sweep();
        }
        let mut leave = false;
        if let Some(control) = &mut self.control {
            control.poll(&mut |request| {
                // a borrow for each request
                let change: Option<Change<'_>> = match &mut change {
                    Some(change) => Some(*change),
                    None => None,
                };
                answer(recorder, &ModelLanguage, request, &mut leave, change)
            });
        }
        leave
    }
}

/// A device that nobody has described: what it is comes from itself.
struct Unknown {
    /// what such a device may do at most
    most: Profile,
    /// degrees of freedom the scene uses
    wanted: u32,
}

impl Unknown {
    /// Makes the setup what the device says, and gives that in words; `None` where it was so before.
    fn fit(&self, setup: &mut Setup, about: &About, scene: &Scene) -> Result<Option<String>, String> {
        let p = self.most.described(about)?;
        let of = |i: &Input| i.device.as_ref().is_some_and(|d| d.0 == setup.device && d.1 < p.dof);
        if p.dof < self.wanted && (p.axes > 1 || !scene.inputs.iter().any(of)) {
            let (n, wanted) = (p.dof, self.wanted);
            return Err(format!("the model uses {wanted} of its degrees of freedom and it has {n}: it is not played"));
        }
        if p == setup.profile {
            return Ok(None);
        }
        let said = Setup { profile: p, ..setup.clone() };
        // couplings were chosen for what such a device holds as far as was known
        if let Some((key, k)) = coupling::beyond(scene, &said) {
            let k = show(six(k), Unit::STIFFNESS);
            return Err(format!(
                "`{key}` is {k} stiff in the hand, more than it holds by what it says: it is not played; describe it in a \
                 profile (`--profile`)"
            ));
        }
        *setup = said;
        let p = &setup.profile;
        let others = if p.dof < self.wanted {
            format!("; the model has keys for {}, of which MIDI and gestures play the others", self.wanted)
        } else {
            String::new()
        };
        let vector = if p.axes > 1 { format!(", {} to a force", p.axes) } else { String::new() };
        Ok(Some(format!(
            "it says: {}, {} degrees of freedom{vector}, {} frames a second; at most {} N, since nobody has described it{others}",
            p.title, p.dof, p.rate, p.force
        )))
    }
}

/// Where a device says less of itself than its profile does, which is what the guard goes by.
fn differs(p: &Profile, a: &About) -> Vec<String> {
    let n = (a.n as usize).min(p.dof as usize);
    let least = a.force[..n].iter().copied().fold(f32::INFINITY, f32::min);
    let mut list = Vec::new();
    if u32::from(a.n) < p.dof {
        list.push(format!(
            "has {} degrees of freedom, its profile `{}` {}: its frames are not used; give it a profile with `dof = {}`",
            a.n, p.name, p.dof, a.n
        ));
    }
    if f64::from(least) < p.force * (1.0 - 1e-6) && least > 0.0 {
        list.push(format!("gives at most {least} N, its profile `{}` {}", p.name, p.force));
    }
    if (f64::from(a.rate) / p.rate - 1.0).abs() > 0.05 {
        list.push(format!("sends {} frames a second, its profile `{}` {}", a.rate, p.name, p.rate));
    }
    list
}
