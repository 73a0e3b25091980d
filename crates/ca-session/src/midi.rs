//! MIDI into ports and live parameters of a running model.
//!
//! A port moves by MIDI as its `midi` says. A controller that no port follows can be bound to a live parameter while the
//! model plays ([`Midi::learn`]). Everything ends in the recorder, so that a take has it. Events that move nothing are
//! reported once.

use crate::refused::Refused;
use ca_core::Scene;
use ca_haptic::engine::LONGEST;
use ca_haptic::serve::Recorder;
use ca_io::gesture::{Glide, Motion, port_maps};
use ca_io::live_midi::{Cable, LiveMidi, Played};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// Channel and number of a controller.
type Control = (u8, u8);

/// MIDI of all cables. The caller's clock gives the times.
pub struct Midi {
    live: LiveMidi,
    /// the parameter that a controller sets
    bound: BTreeMap<Control, String>,
    /// the parameter that the next controller is bound to
    learning: Option<String>,
    /// controllers that were reported to move nothing
    reported: BTreeSet<Control>,
    /// ports that the pedal held and that come up: when, and where they go then
    lifted: Vec<(Duration, String, Glide)>,
}

impl Midi {
    /// The ports of a scene, with no note held.
    pub fn new(scene: &Scene) -> Midi {
        Midi {
            live: LiveMidi::new(&port_maps(scene)),
            bound: BTreeMap::new(),
            learning: None,
            reported: BTreeSet::new(),
            lifted: Vec::new(),
        }
    }

    /// Another version of the model plays: notes that were held end with their ports.
    pub fn version(&mut self, scene: &Scene) {
        self.live = LiveMidi::new(&port_maps(scene));
        self.lifted.clear();
    }

    /// Moves ports whose time has come. To be called every few milliseconds.
    pub fn turn(&mut self, recorder: &mut Recorder, now: Duration) {
        while let Some(due) = self.lifted.iter().position(|l| l.0 <= now) {
            let (_, name, glide) = self.lifted.swap_remove(due);
            let done = recorder.port(&name, glide.to, glide.over);
            complain(recorder, done.map_err(Refused::from));
        }
    }

    /// Plays whole events that came without a cable.
    pub fn play(&mut self, recorder: &mut Recorder, bytes: &[u8], now: Duration) {
        self.feed(recorder, &mut Cable::default(), bytes, now);
    }

    /// Plays bytes as they come by a cable.
    pub fn feed(&mut self, recorder: &mut Recorder, cable: &mut Cable, bytes: &[u8], now: Duration) {
        for played in self.live.feed(cable, bytes) {
            let done = match played {
                Played::Port(name, motion) => self.port(recorder, name, motion, now),
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

    /// Moves a port at once, or once it has come up.
    fn port(
        &mut self,
        recorder: &mut Recorder,
        name: String,
        Motion { lift, glide }: Motion,
        now: Duration,
    ) -> Result<(), Refused> {
        self.lifted.retain(|l| l.1 != name);
        let first = lift.unwrap_or(glide);
        recorder.port(&name, first.to, first.over)?;
        if lift.is_some() {
            let up = now + Duration::from_secs_f64(first.over.clamp(0.0, LONGEST));
            self.lifted.push((up, name, glide));
        }
        Ok(())
    }

    fn control(&mut self, recorder: &mut Recorder, at: Control, part: f64, used: bool) -> Result<(), Refused> {
        if let Some(name) = self.learning.take() {
            recorder.say(false, format!("controller {} on channel {} sets `{name}`", at.1, at.0));
            // one controller a parameter
            self.bound.retain(|_, n| *n != name);
            self.bound.insert(at, name);
        }
        let Some(name) = self.bound.get(&at) else {
            if !used && self.reported.insert(at) {
                let text = format!("controller {} on channel {} moves nothing; bind it to a parameter", at.1, at.0);
                recorder.say(false, text);
            }
            return Ok(());
        };
        let range = recorder.controls().params().iter().find(|p| p.name == *name).map(|p| (p.min, p.max));
        let (min, max) = range.ok_or_else(|| format!("`{name}` is no live parameter any more"))?;
        recorder.set(&[(name.clone(), if part >= 1.0 { max } else { min + part * (max - min) })])?;
        Ok(())
    }

    /// The next controller that moves sets this live parameter from then on, between its bounds. Without a name no
    /// controller is waited for.
    ///
    /// # Errors
    /// If the parameter does not exist, or lacks bounds.
    pub fn learn(&mut self, recorder: &Recorder, name: Option<&str>) -> Result<(), Refused> {
        if let Some(name) = name {
            let params = recorder.controls().params();
            let param = params.iter().find(|p| p.name == name);
            let param = param.ok_or_else(|| format!("`{name}` is not a live parameter of this model"))?;
            if !(param.min.is_finite() && param.max.is_finite()) {
                return Err(
                    format!("`{name}` has no bounds to go between; give it `min` and `max` in the model").into()
                );
            }
        }
        self.learning = name.map(Into::into);
        Ok(())
    }

    /// The parameter that waits for a controller.
    pub fn learning(&self) -> Option<&str> {
        self.learning.as_deref()
    }

    /// Channel, number and parameter of each controller that is bound.
    pub fn bound(&self) -> impl Iterator<Item = (u8, u8, &str)> {
        self.bound.iter().map(|((channel, number), name)| (*channel, *number, name.as_str()))
    }
}

/// Reports why MIDI did nothing.
fn complain(recorder: &mut Recorder, done: Result<(), Refused>) {
    if let Err(why) = done {
        recorder.say(true, format!("MIDI: {why}"));
    }
}
