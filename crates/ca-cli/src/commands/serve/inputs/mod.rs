//! What plays a running model besides devices and pages: MIDI ([`midi`], [`events`]) and OSC ([`osc`]).
//!
//! Decides that both end in what the recorder does for anybody: ports that glide, live parameters, the model's own gesture, so that a
//! take has all of it. A port moves by MIDI as its `midi` says; a controller that no port listens to can be bound to a live
//! parameter while it plays ([`Inputs::learn`]), and what moves nothing is told once.

mod midi;
mod osc;
mod token;

use super::devices;
use crate::args::ServeArgs;
use crate::outcome::Failure;
use ca_audio::EventReader;
use ca_core::Scene;
use ca_haptic::engine::LONGEST;
use ca_haptic::serve::Recorder;
use ca_io::gesture::{Glide, Motion};
use ca_io::live_midi::{Cable, LiveMidi, Played};
use ca_lab::gesture::port_maps;
use midi::Cables;
use osc::Osc;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};
use token::Token;

/// Channel and number of a controller.
type Control = (u8, u8);

/// All of them.
pub(crate) struct Inputs {
    live: LiveMidi,
    cables: Option<Cables>,
    /// of the server of sound
    events: Option<EventReader>,
    osc: Option<Osc>,
    /// the parameter that a controller sets
    bound: BTreeMap<Control, String>,
    /// the parameter that the next controller is bound to
    learning: Option<String>,
    /// controllers that were told to move nothing
    told: BTreeSet<Control>,
    /// ports that the pedal held and that come up: where they go then, and when
    lifted: Vec<(Instant, String, Glide)>,
}

impl Inputs {
    /// Opens what is asked for; `plays` where a MIDI device that is there needs no asking; `events` of the server of sound.
    pub(super) fn open(
        args: &ServeArgs,
        scene: &Scene,
        plays: bool,
        events: Option<EventReader>,
    ) -> Result<Inputs, Failure> {
        // forces on a hand follow from what it does
        let closed = args.osc_token.is_some() || !devices(scene).is_empty();
        let osc = match args.osc {
            Some(port) => Some(Osc::open(port, Token::open(args.osc_token.as_deref(), closed)?, closed)?),
            None => None,
        };
        Ok(Inputs {
            live: LiveMidi::new(&port_maps(scene)),
            cables: Cables::open(args.midi.as_deref(), plays)?,
            events,
            osc,
            bound: BTreeMap::new(),
            learning: None,
            told: BTreeSet::new(),
            lifted: Vec::new(),
        })
    }

    /// Another version of the model plays: notes that were held are let go of with their ports.
    pub(crate) fn version(&mut self, scene: &Scene) {
        self.live = LiveMidi::new(&port_maps(scene));
        self.lifted.clear();
    }

    /// The server of sound is another one, which brings these, or none.
    pub(super) fn served(&mut self, events: Option<EventReader>) {
        self.events = events;
    }

    /// What there is, in words.
    pub(super) fn said(&self) -> Vec<String> {
        let midi = self.cables.iter().flat_map(Cables::names).map(|name| format!("MIDI: {name}"));
        let osc = self.osc.iter().map(Osc::said);
        let events = self.events.iter().map(|e| format!("MIDI: {}", e.name()));
        midi.chain(events).chain(osc).collect()
    }

    /// One turn: what came since the last one; OSC until `end`, the rest waits.
    pub(super) fn turn(&mut self, recorder: &mut Recorder, end: Instant) {
        // it waits where it is
        if recorder.is_swapping() {
            return;
        }
        let now = Instant::now();
        while let Some(due) = self.lifted.iter().position(|l| l.0 <= now) {
            let (_, name, glide) = self.lifted.swap_remove(due);
            let done = recorder.port(&name, glide.to, glide.over);
            complain(recorder, done);
        }
        if let Some(mut cables) = self.cables.take() {
            cables.turn(|cable, bytes| self.feed(recorder, cable, bytes));
            for (bad, text) in cables.news() {
                recorder.say(bad, text);
            }
            self.cables = Some(cables);
        }
        if let Some(mut events) = self.events.take() {
            events.turn(|cable, bytes| self.feed(recorder, cable, bytes));
            if let Some(text) = events.news() {
                recorder.say(true, text);
            }
            self.events = Some(events);
        }
        if let Some(mut osc) = self.osc.take() {
            osc.turn(self, recorder, end);
            self.osc = Some(osc);
        }
    }

    /// MIDI as it comes from elsewhere, whole events.
    pub(crate) fn midi(&mut self, recorder: &mut Recorder, bytes: &[u8]) {
        self.feed(recorder, &mut Cable::default(), bytes);
    }

    fn feed(&mut self, recorder: &mut Recorder, cable: &mut Cable, bytes: &[u8]) {
        for played in self.live.feed(cable, bytes) {
            let done = match played {
                Played::Port(name, motion) => self.port(recorder, name, motion),
                Played::Control { channel, number, part, used } => {
                    self.control(recorder, (channel, number), part, used)
                }
                Played::Unheard(text) => {
                    recorder.say(false, text);
                    Ok(())
                }
            };
            complain(recorder, done);
        }
    }

    /// Sends a port on its way: at once, or once it has come up.
    fn port(&mut self, recorder: &mut Recorder, name: String, Motion { lift, glide }: Motion) -> Result<(), String> {
        self.lifted.retain(|l| l.1 != name);
        let first = lift.unwrap_or(glide);
        recorder.port(&name, first.to, first.over)?;
        if lift.is_some() {
            let up = Instant::now() + Duration::from_secs_f64(first.over.clamp(0.0, LONGEST));
            self.lifted.push((up, name, glide));
        }
        Ok(())
    }

    fn control(&mut self, recorder: &mut Recorder, at: Control, part: f64, used: bool) -> Result<(), String> {
        if let Some(name) = self.learning.take() {
            recorder.say(false, format!("controller {} on channel {} sets `{name}`", at.1, at.0));
            // one controller a parameter
            self.bound.retain(|_, n| *n != name);
            self.bound.insert(at, name);
        }
        let Some(name) = self.bound.get(&at) else {
            if !used && self.told.insert(at) {
                let text = format!("controller {} on channel {} moves nothing; bind it to a parameter", at.1, at.0);
                recorder.say(false, text);
            }
            return Ok(());
        };
        let range = recorder.controls().params().iter().find(|p| p.name == *name).map(|p| (p.min, p.max));
        let (min, max) = range.ok_or_else(|| format!("`{name}` is no live parameter any more"))?;
        recorder.set(&[(name.clone(), if part >= 1.0 { max } else { min + part * (max - min) })])
    }

    /// The next controller that moves sets this live parameter from now on, between its bounds; none where no name is given.
    ///
    /// # Errors
    /// In words, where there is no such parameter, or it has no bounds.
    pub(crate) fn learn(&mut self, recorder: &Recorder, name: Option<&str>) -> Result<(), String> {
        if let Some(name) = name {
            let params = recorder.controls().params();
            let param = params.iter().find(|p| p.name == name);
            let param = param.ok_or_else(|| format!("`{name}` is not a live parameter of this model"))?;
            if !(param.min.is_finite() && param.max.is_finite()) {
                return Err(format!("`{name}` has no bounds to go between; give it `min` and `max` in the model"));
            }
        }
        self.learning = name.map(Into::into);
        Ok(())
    }

    /// The parameter that waits for a controller.
    pub(crate) fn learning(&self) -> Option<&str> {
        self.learning.as_deref()
    }

    /// Channel, number and parameter of each controller that is bound.
    pub(crate) fn bound(&self) -> impl Iterator<Item = (u8, u8, &str)> {
        self.bound.iter().map(|((channel, number), name)| (*channel, *number, name.as_str()))
    }
}

/// Says why MIDI did nothing.
fn complain(recorder: &mut Recorder, done: Result<(), String>) {
    if let Err(why) = done {
        recorder.say(true, format!("MIDI: {why}"));
    }
}
