//! Manual input without a device, as the recorder tracks it: the held masses and the progress of the model's own gesture.
//!
//! The recorder sets the live parameters of a gesture by the same command as all other changes. Only it knows the other
//! changes, and its commands are recorded, so that a take replays to the same bits even if this thread was late.

use super::{Recorder, Refused};
use crate::engine::{EngineCommand, LONGEST, ManualEvent, ManualInput, OwnGesture, lead};
use ca_core::Scene;
use ca_core::internal::state::FINGERS;
use ca_core::pointer::Pointer;
use ca_io::gesture::{Track, own};

/// Largest value of a port \[m or N\]; playable models need less, and larger values would exceed every range.
pub(super) const FURTHEST: f64 = 1e6;

pub(super) struct ManualProgress {
    held: [Option<usize>; FINGERS],
    /// Tick at which the lead-in of the gesture ends.
    began: Option<u64>,
    /// Duration of the lead-in, and of the gesture \[ticks\].
    lead: u64,
    length: u64,
    /// Live parameters in the gesture.
    params: Vec<Track>,
}

impl ManualProgress {
    pub(super) fn new(scene: &Scene) -> ManualProgress {
        let all: Vec<Track> = own(scene).flatten().collect();
        let length = all.iter().map(Track::duration).fold(0.0, f64::max) * scene.rate;
        let params = all.into_iter().filter(|t| scene.input(t.name()).is_none()).collect();
        ManualProgress { held: [None; FINGERS], began: None, lead: lead(scene), length: length.ceil() as u64, params }
    }

    /// Resets after the scene was loaded again.
    pub(super) fn reset(&mut self) {
        (self.held, self.began) = ([None; FINGERS], None);
    }

    fn hold(&mut self, finger: u8, mass: Option<usize>) {
        if let Some(held) = self.held.get_mut(usize::from(finger)) {
            *held = mass;
        }
    }

    pub(super) fn apply(&mut self, tick: u64, event: &ManualEvent) {
        match event {
            ManualEvent::Grab(finger, mass) => {
                let mass = Some(*mass as usize);
                self.held.iter_mut().filter(|h| **h == mass).for_each(|h| *h = None);
                self.hold(*finger, mass);
            }
            ManualEvent::Release(finger) => self.hold(*finger, None),
            ManualEvent::Play => self.began = Some(tick + self.lead),
            ManualEvent::Stop => self.began = None,
            ManualEvent::Pull(..) | ManualEvent::Port(..) => {}
        }
    }
}

impl Recorder {
    /// Holds MAT number `mass` of the scene with a finger (0 to 9), where it is. The finger releases any
    /// other mass, and any other finger this one.
    ///
    /// # Errors
    /// If the MAT cannot be held, or the engine does not take commands now.
    pub fn grab(&mut self, finger: u8, mass: usize) -> Result<(), Refused> {
        let pointer = Pointer::new(&self.scene, mass, finger)?;
        self.command(EngineCommand::Manual(ManualInput::Grab(pointer)))
    }

    /// Pulls the mass that a finger holds to a displacement from rest \[m\]; in one dimension only the first number counts.
    ///
    /// # Errors
    /// If the displacement is not finite, or the engine does not take commands now.
    pub fn drag(&mut self, finger: u8, to: [f64; 3]) -> Result<(), Refused> {
        if to.iter().any(|x| !x.is_finite()) {
            return Err(Refused::Place);
        }
        self.command(EngineCommand::Manual(ManualInput::Pull(finger, to)))
    }

    /// Releases the mass that a finger holds.
    ///
    /// # Errors
    /// If the engine does not take commands now.
    pub fn release(&mut self, finger: u8) -> Result<(), Refused> {
        self.command(EngineCommand::Manual(ManualInput::Release(finger)))
    }

    /// Starts the model's own gesture from its beginning, or stops it.
    ///
    /// # Errors
    /// If the model has none, or the engine does not take commands now.
    pub fn gesture(&mut self, play: bool) -> Result<(), Refused> {
        if !play {
            return self.command(EngineCommand::Manual(ManualInput::Stop));
        }
        let own = OwnGesture::new(&self.scene).ok_or(Refused::NoGesture)?;
        self.command(EngineCommand::Manual(ManualInput::Play(Box::new(own))))
    }

    /// Moves a position port to a position \[m\], or a force port to a force \[N\], in `over` seconds. A device key
    /// counts as a position port until its device has sent a frame with that key.
    ///
    /// # Errors
    /// If the port does not exist, its device moves it, the value is not finite or too large, or the engine does not
    /// take commands now.
    pub fn port(&mut self, name: &str, value: f64, over: f64) -> Result<(), Refused> {
        let Some(input) = self.scene.input(name) else {
            return Err(Refused::Port(name.into(), self.scene.inputs.iter().map(|i| i.name.clone()).collect()));
        };
        let device = self.scene.inputs[input].device.as_ref();
        if let Some(device) = device.filter(|d| self.monitors.iter().any(|s| s.name == d.0 && d.1 < s.dof)) {
            return Err(Refused::OfDevice(name.into(), device.0.clone()));
        }
        if !value.is_finite() || over.is_nan() {
            return Err(Refused::Value(name.into()));
        }
        if value.abs() > FURTHEST {
            return Err(Refused::Far(name.into()));
        }
        self.command(EngineCommand::Manual(ManualInput::Port(input as u32, value, over.clamp(0.0, LONGEST))))
    }

    /// Returns the MATs that fingers hold.
    pub fn held(&self) -> impl Iterator<Item = usize> {
        self.manual.held.iter().flatten().copied()
    }

    /// Returns true while the model's own gesture plays.
    pub fn playing(&self) -> bool {
        self.manual.began.is_some_and(|began| self.tick < began + self.manual.length)
    }

    /// Sets the live parameters of the gesture to their values at the present tick.
    pub(super) fn apply_gesture_params(&mut self) {
        if self.manual.params.is_empty() || !self.playing() {
            return;
        }
        let Some(began) = self.manual.began else { return };
        let t = self.tick.saturating_sub(began) as f64 * self.scene.rates.sample_dt;
        let params = self.controls.params();
        let changes: Vec<(String, f64)> = self
            .manual
            .params
            .iter()
            .filter_map(|track| {
                let param = params.iter().find(|p| p.name == track.name())?;
                let value = track.at(t).clamp(param.min, param.max);
                (value != param.value).then(|| (param.name.clone(), value))
            })
            .collect();
        if !changes.is_empty() {
            // after an error, the next poll tries again
            let _ = self.set(&changes);
        }
    }
}
