//! MIDI to ports and live parameters of a running model.
//!
//! A port moves by MIDI as its `midi` says. A controller that no port follows can be bound to a live parameter while
//! the model plays ([`Midi::learn`]). Everything passes through the recorder, so that a take contains it. Events that
//! move nothing are reported once.

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
    /// Parameter that each bound controller sets.
    bound: BTreeMap<Control, String>,
    /// Parameter that the next controller is bound to.
    learning: Option<String>,
    /// Controllers reported to move nothing.
    reported: BTreeSet<Control>,
    /// channel and number of program changes that were reported to choose nothing
    programs: BTreeSet<(u8, u8)>,
    /// Ports that were held by the pedal and return to rest: end of the return, name and next motion.
    lifted: Vec<(Duration, String, Glide)>,
}

impl Midi {
    /// Takes the ports of a scene, with no note held.
    pub fn new(scene: &Scene) -> Midi {
        Midi {
            live: LiveMidi::new(&port_maps(scene)),
            bound: BTreeMap::new(),
            learning: None,
            reported: BTreeSet::new(),
            programs: BTreeSet::new(),
            lifted: Vec::new(),
        }
    }

    /// Changes to another version of the model: held notes end with their ports.
    pub fn version(&mut self, scene: &Scene) {
        self.live = LiveMidi::new(&port_maps(scene));
        self.lifted.clear();
    }

    /// Starts motions that are due. Call it every few milliseconds.
    pub fn poll(&mut self, recorder: &mut Recorder, now: Duration) {
        while let Some(due) = self.lifted.iter().position(|l| l.0 <= now) {
            let (_, name, glide) = self.lifted.swap_remove(due);
            let done = recorder.port(&name, glide.to, glide.over);
            complain(recorder, done.map_err(Refused::from));
        }
    }

    /// Plays whole events that do not come from a cable.
    pub fn play(&mut self, recorder: &mut Recorder, bytes: &[u8], now: Duration) {
        self.feed(recorder, &mut Cable::default(), bytes, now);
    }

    /// Plays bytes from a cable.
    pub fn feed(&mut self, recorder: &mut Recorder, cable: &mut Cable, bytes: &[u8], now: Duration) {
        for played in self.live.feed(cable, bytes) {
            let done = match played {
                Played::Port(name, motion) => self.port(recorder, name, motion, now),
                Played::Control { channel, number, part, used } => {
                    self.control(recorder, (channel, number), part, used)
                }
                Played::Program { channel, number } => self.program(recorder, channel, number),
                Played::Unheard(text) => {
                    recorder.say(false, text);
                    Ok(())
                }
            };
            complain(recorder, done);
        }
    }

    /// Moves a port now, or first to rest and then on.
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

    /// Sets the live parameters of the preset of this number, in the order of the model.
    fn program(&mut self, recorder: &mut Recorder, channel: u8, number: u8) -> Result<(), Refused> {
        let presets = &recorder.scene().about.presets;
        let Some((name, values)) = presets.get(usize::from(number)).cloned() else {
            let n = presets.len();
            if self.programs.insert((channel, number)) {
                let text = format!(
                    "program {number} on channel {channel} has no effect: the model has {n} presets, from program 0"
                );
                recorder.say(false, text);
            }
            return Ok(());
        };
        recorder.set(&values)?;
        recorder.say(false, format!("preset `{name}`"));
        Ok(())
    }

    fn control(&mut self, recorder: &mut Recorder, at: Control, part: f64, used: bool) -> Result<(), Refused> {
        if let Some(name) = self.learning.take() {
            recorder.say(false, format!("controller {} on channel {} now sets `{name}`", at.1, at.0));
            // one controller for each parameter
            self.bound.retain(|_, n| *n != name);
            self.bound.insert(at, name);
        }
        let Some(name) = self.bound.get(&at) else {
            if !used && self.reported.insert(at) {
                let text =
                    format!("controller {} on channel {} has no effect; bind it to a live parameter", at.1, at.0);
                recorder.say(false, text);
            }
            return Ok(());
        };
        let range = recorder.controls().params().iter().find(|p| p.name == *name).map(|p| (p.min, p.max));
        let (min, max) = range.ok_or_else(|| format!("`{name}` is no longer a live parameter"))?;
        recorder.set(&[(name.clone(), if part >= 1.0 { max } else { min + part * (max - min) })])?;
        Ok(())
    }

    /// Binds the next controller that moves to this live parameter, between its bounds. Without a name, cancels the
    /// binding.
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
                    format!("`{name}` has no bounds, so no controller can set it; give it `min` and `max`").into()
                );
            }
        }
        self.learning = name.map(Into::into);
        Ok(())
    }

    /// Returns the parameter that waits for a controller.
    pub fn learning(&self) -> Option<&str> {
        self.learning.as_deref()
    }

    /// Returns channel, number and parameter of each bound controller.
    pub fn bound(&self) -> impl Iterator<Item = (u8, u8, &str)> {
        self.bound.iter().map(|((channel, number), name)| (*channel, *number, name.as_str()))
    }
}

fn complain(recorder: &mut Recorder, done: Result<(), Refused>) {
    if let Err(why) = done {
        recorder.say(true, format!("MIDI: {why}"));
    }
}
