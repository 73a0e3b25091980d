//! Connections to other processes: devices through the gateway, commands such as `ca set` and `ca disarm` through the
//! control.

use crate::language::ModelLanguage;
use crate::report::Traffic;
use crate::request::Listener;
use crate::setup::host_failure;
use ca_core::Scene;
use ca_haptic::admission::{DeviceWithoutProfile, differences};
use ca_haptic::engine::Setup;
use ca_haptic::host::control::ControlServer;
use ca_haptic::host::{Event, Gateway, Rings, Running, Site};
use ca_haptic::profile::Profile;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::{GatewayEnds, Recorder};
use ca_lab::Failure;
use ca_session::{Change, answer};
use ca_take::dofs;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Delay of claims by a server without the control, so that the server with the control claims first.
const SECOND: Duration = Duration::from_millis(300);

/// Open connections. A scene without devices, live parameters and a page needs none. The control also serves to stop a
/// page and to set its parameters.
pub(crate) struct Connections {
    names: Vec<String>,
    setups: Vec<Setup>,
    /// Degrees of freedom used and upper limits, for each device without a description.
    unknown: Vec<Option<DeviceWithoutProfile>>,
    /// Devices whose description the engine has not received yet.
    refits: Vec<u32>,
    site: Option<Site>,
    control: Option<ControlServer>,
    gateway: Option<Running>,
    events: Receiver<(u32, Event)>,
}

impl Connections {
    /// Opens the connections that the scene needs.
    ///
    /// If another server holds the control of this user, a scene with a `page` runs without the control and is set and
    /// armed in its page. A device named by both servers goes to the other one first.
    pub(crate) fn open(
        (setups, unknown): (&[Setup], Vec<Option<Profile>>),
        scene: &Scene,
        ends: GatewayEnds,
        request: RtRequest,
        page: bool,
        listener: &dyn Listener,
    ) -> Result<Connections, Failure> {
        let (tell, events) = channel();
        let names: Vec<String> = setups.iter().map(|s| s.device.clone()).collect();
        let wanted = setups.iter().map(|s| dofs(scene, &s.device));
        let unknown = unknown
            .into_iter()
            .zip(wanted)
            .map(|(p, wanted)| Some(DeviceWithoutProfile { most: p?, wanted }))
            .collect();
        let setups = setups.to_vec();
        let mut talk = Connections {
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
        let site = Site::of_user().map_err(|e| host_failure(&e))?;
        if !names.is_empty() {
            site.remove_dead();
        }
        match ControlServer::open(&site) {
            Ok(control) => talk.control = Some(control),
            Err(e) if page => {
                let verbs = if names.is_empty() {
                    "`ca set` and `ca stop`"
                } else {
                    "`ca set`, `ca stop`, `ca arm` and `ca disarm`"
                };
                listener.note(&format!("{verbs} cannot control this performance; use its page: {}", e.what));
            }
            Err(e) => return Err(host_failure(&e)),
        }
        if !names.is_empty() {
            let rings = Rings { incoming: ends.frames, outgoing: ends.forces, events: tell };
            let after = if talk.control.is_some() { Duration::ZERO } else { SECOND };
            talk.gateway = Some(Gateway::start(&site, &names, rings, request, after).map_err(|e| host_failure(&e))?);
        }
        talk.site = Some(site);
        Ok(talk)
    }

    /// Closes the connections after the last force was sent. Returns the frame counts summed over all devices.
    pub(crate) fn end(self) -> Option<Traffic> {
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

    pub(crate) fn granted(&self) -> Option<String> {
        self.gateway.as_ref().map(|g| g.granted.to_string())
    }

    /// Returns the setups of the devices, or `None` while the engine has not received all descriptions.
    pub(crate) fn setups(&self) -> Option<&[Setup]> {
        self.refits.is_empty().then_some(&self.setups)
    }

    /// Handles events of devices and requests of users. Returns true if a user requests a stop.
    ///
    /// `change` sets numbers of the model that are not live, if the model can be compiled again.
    pub(crate) fn poll(&mut self, recorder: &mut Recorder, sweep: bool, mut change: Option<Change<'_>>) -> bool {
        while let Ok((k, event)) = self.events.try_recv() {
            let name = self.names.get(k as usize).map_or("?", String::as_str);
            match event {
                Event::Here { session } => recorder.say(false, format!("{name}: connected (session {session:x})")),
                Event::Gone => recorder.say(true, format!("{name}: disconnected")),
                Event::Taken(why) => {
                    recorder.say(true, format!("{why}; that process keeps the device until it ends"));
                }
                Event::Foreign(why) => {
                    let fix = why.fix();
                    recorder.say(true, format!("{name}: ignored frames that {why}; {fix}"));
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
                            for what in differences(&setup.profile, &about) {
                                recorder.say(true, format!("{name}: {what}"));
                            }
                        }
                    }
                }
            }
        }
        // a busy engine is asked again at the next iteration
        self.refits.retain(|k| recorder.refit(*k, self.setups[*k as usize].clone()).is_err());
        if let (true, Some(site), Some(_)) = (sweep, &self.site, &self.gateway) {
            site.remove_dead();
        }
        let mut leave = false;
        if let Some(control) = &mut self.control {
            control.poll(&mut |request| {
                // reborrows for each request
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
