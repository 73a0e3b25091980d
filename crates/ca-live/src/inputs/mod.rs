//! Inputs other than devices and pages: MIDI cables ([`cables`]), MIDI from a sound server, and OSC ([`osc`]).
//!
//! [`ca_session::Midi`] maps MIDI events to ports and parameters.

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

pub(crate) struct Inputs {
    pub(crate) midi: Midi,
    begun: Instant,
    cables: Option<Cables>,
    /// MIDI events from the sound server.
    events: Option<EventReader>,
    osc: Option<Osc>,
}

impl Inputs {
    /// Opens the requested inputs. If `plays` is true, MIDI devices are opened without a request. `events` come from
    /// the sound server.
    pub(crate) fn open(
        options: &InputOptions,
        scene: &Scene,
        plays: bool,
        events: Option<EventReader>,
    ) -> Result<Inputs, Failure> {
        // OSC moves parameters and ports, and forces on a hand follow from these
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

    /// Replaces the MIDI events after a change of the sound server.
    pub(crate) fn served(&mut self, events: Option<EventReader>) {
        self.events = events;
    }

    pub(crate) fn messages(&self) -> Vec<String> {
        let midi = self.cables.iter().flat_map(Cables::names).map(|name| format!("MIDI: {name}"));
        let osc = self.osc.iter().map(Osc::message);
        let events = self.events.iter().map(|e| format!("MIDI: {}", e.name()));
        midi.chain(events).chain(osc).collect()
    }

    /// Plays the events since the last call. OSC packets after `end` wait.
    pub(crate) fn poll(&mut self, recorder: &mut Recorder, end: Instant) {
        // events wait in their queues meanwhile
        if recorder.is_swapping() {
            return;
        }
        let begun = self.begun;
        self.midi.poll(recorder, begun.elapsed());
        if let Some(mut cables) = self.cables.take() {
            cables.poll(|cable, bytes| self.midi.feed(recorder, cable, bytes, begun.elapsed()));
            for (bad, text) in cables.take_messages() {
                recorder.say(bad, text);
            }
            self.cables = Some(cables);
        }
        if let Some(mut events) = self.events.take() {
            events.poll(|cable, bytes| self.midi.feed(recorder, cable, bytes, begun.elapsed()));
            if let Some(text) = events.take_warning() {
                recorder.say(true, text);
            }
            self.events = Some(events);
        }
        if let Some(mut osc) = self.osc.take() {
            osc.poll(self, recorder, end);
            self.osc = Some(osc);
        }
    }

    pub(crate) fn now(&self) -> Duration {
        self.begun.elapsed()
    }
}

/// Opens the requested MIDI cables: those at a path, or all of the machine for an empty path. If `plays` is true, opens
/// all that can be opened without a request.
fn opened(asked: Option<&Path>, plays: bool) -> Result<Option<Cables>, Failure> {
    let (paths, must) = match asked {
        Some(path) if !path.as_os_str().is_empty() => (vec![path.to_path_buf()], true),
        Some(_) => (cables::devices(), true),
        None if plays => (cables::devices(), false),
        None => return Ok(None),
    };
    if paths.is_empty() && must {
        let why =
            "--midi: no MIDI device found (/dev/snd/midiC*D*); connect one, or give its path or a pipe: `--midi PATH`";
        return Err(Failure::Failed(why.into()));
    }
    for path in &paths {
        let file = path.display();
        if let Err(e) = std::fs::metadata(path) {
            return Err(Failure::Failed(format!("--midi {file}: {e}")));
        }
        if must && cables::is_standard_file(path) {
            return Err(Failure::Usage(format!(
                "--midi {file}: a Standard MIDI File is not a live input; play it with `ca render MODEL --gesture {file}`"
            )));
        }
    }
    Ok(if paths.is_empty() { None } else { Some(Cables::open(paths)?) })
}
