//! Inputs besides devices and pages: cables of MIDI ([`cables`]), a sound server that brings MIDI, and OSC ([`osc`]).
//!
//! [`ca_session::Midi`] decides what an event of MIDI moves.

mod osc;
mod token;

use crate::request::InputOptions;
use ca_audio::EventReader;
use ca_core::Scene;
use ca_haptic::serve::Recorder;
use ca_io::live_midi::cables::{self, Cables};
use ca_lab::Failure;
use ca_session::Midi;
use ca_take::devices;
use osc::Osc;
use std::path::Path;
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
            cables: opened(options.midi.as_deref(), plays)?,
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

/// The cables that are asked for, all of the machine where no path is given; `plays` where those are opened unasked, if they can be.
fn opened(asked: Option<&Path>, plays: bool) -> Result<Option<Cables>, Failure> {
    let (paths, must) = match asked {
        Some(path) if !path.as_os_str().is_empty() => (vec![path.to_path_buf()], true),
        Some(_) => (cables::devices(), true),
        None if plays => (cables::devices(), false),
        None => return Ok(None),
    };
    if paths.is_empty() && must {
        let why = "--midi: this machine has no MIDI device (/dev/snd/midiC*D*); give the path of one, or of a pipe";
        return Err(Failure::Failed(why.into()));
    }
    for path in &paths {
        let file = path.display();
        if let Err(e) = std::fs::metadata(path) {
            return Err(Failure::Failed(format!("--midi {file}: {e}")));
        }
        if must && cables::is_standard_file(path) {
            return Err(Failure::Usage(format!(
                "--midi {file}: it is a Standard MIDI File, whose events have times; `ca render MODEL --gesture {file}` plays it"
            )));
        }
    }
    Ok(if paths.is_empty() { None } else { Some(Cables::open(paths)?) })
}
