//! Inputs besides devices and pages: cables of MIDI ([`midi`]), a sound server that brings MIDI, and OSC ([`osc`]).
//!
//! [`ca_session::Midi`] decides what an event of MIDI moves.

mod midi;
mod osc;
mod token;

use crate::request::InputOptions;
use ca_audio::EventReader;
use ca_core::Scene;
use ca_haptic::serve::Recorder;
use ca_lab::Failure;
use ca_lab::take::devices;
use ca_session::Midi;
use midi::Cables;
use osc::Osc;
use std::time::{Duration, Instant};
use token::Token;

/// All of them.
pub(crate) struct Inputs {
    pub(crate) midi: Midi,
    begun: Instant,
    cables: Option<Cables>,
    /// of the server of sound
    events: Option<EventReader>,
    osc: Option<Osc>,
}

impl Inputs {
    /// Opens what is asked for; `plays` where a MIDI device that is there needs no asking; `events` of the server of sound.
    pub(crate) fn open(
        options: &InputOptions,
        scene: &Scene,
        plays: bool,
        events: Option<EventReader>,
    ) -> Result<Inputs, Failure> {
        // forces on a hand follow from what it does
        let closed = options.osc_token.is_some() || !devices(scene).is_empty();
        let osc = match options.osc {
            Some(port) => Some(Osc::open(port, Token::open(options.osc_token.as_deref(), closed)?, closed)?),
            None => None,
        };
        Ok(Inputs {
            midi: Midi::new(scene),
            begun: Instant::now(),
            cables: Cables::open(options.midi.as_deref(), plays)?,
            events,
            osc,
        })
    }

    /// The server of sound is another one, which brings these, or none.
    pub(crate) fn served(&mut self, events: Option<EventReader>) {
        self.events = events;
    }

    /// What there is, in words.
    pub(crate) fn said(&self) -> Vec<String> {
        let midi = self.cables.iter().flat_map(Cables::names).map(|name| format!("MIDI: {name}"));
        let osc = self.osc.iter().map(Osc::said);
        let events = self.events.iter().map(|e| format!("MIDI: {}", e.name()));
        midi.chain(events).chain(osc).collect()
    }

    /// One turn: what came since the last one; OSC until `end`, the rest waits.
    pub(crate) fn turn(&mut self, recorder: &mut Recorder, end: Instant) {
        // it waits where it is
        if recorder.is_swapping() {
            return;
        }
        let begun = self.begun;
        self.midi.turn(recorder, begun.elapsed());
        if let Some(mut cables) = self.cables.take() {
            cables.turn(|cable, bytes| self.midi.feed(recorder, cable, bytes, begun.elapsed()));
            for (bad, text) in cables.news() {
                recorder.say(bad, text);
            }
            self.cables = Some(cables);
        }
        if let Some(mut events) = self.events.take() {
            events.turn(|cable, bytes| self.midi.feed(recorder, cable, bytes, begun.elapsed()));
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

    /// Time since the inputs were opened.
    pub(crate) fn now(&self) -> Duration {
        self.begun.elapsed()
    }
}
