//! Hands without a device, as the recorder knows them: what is held, and how far the model's own gesture is.
//!
//! Decides that live parameters of a gesture are set from here, as by anybody else: the recorder alone knows what else
//! was set, and what it sets is recorded, so that a take has the same bits however late this thread was.

use super::{Recorder, Refused};
use crate::engine::{EngineCommand, LONGEST, OwnGesture, Touch, Touched, lead};
use ca_core::Scene;
use ca_core::pointer::Pointer;
use ca_io::gesture::{Track, own};

/// No port is sent further than this \[m or N\]: no model that is played is so large, and its numbers would leave every range.
pub(super) const FURTHEST: f64 = 1e6;

/// What the recorder knows of hands without a device.
pub(super) struct Hand {
    /// MAT that is held
    held: Option<usize>,
    /// the tick from which the gesture is played as it is written, after its lead-in
    began: Option<u64>,
    /// ticks of the lead-in, and that it takes
    lead: u64,
    length: u64,
    /// live parameters in it
    params: Vec<Track>,
}

impl Hand {
    pub(super) fn new(scene: &Scene) -> Hand {
        let all: Vec<Track> = own(scene).flatten().collect();
        let length = all.iter().map(Track::duration).fold(0.0, f64::max) * scene.rate;
        let params = all.into_iter().filter(|t| scene.input(t.name()).is_none()).collect();
        Hand { held: None, began: None, lead: lead(scene), length: length.ceil() as u64, params }
    }

    /// The scene was loaded again.
    pub(super) fn let_go(&mut self) {
        (self.held, self.began) = (None, None);
    }

    /// The engine did it.
    pub(super) fn touched(&mut self, tick: u64, touched: &Touched) {
        match touched {
            Touched::Grab(mass) => self.held = Some(*mass as usize),
            Touched::Release => self.held = None,
            Touched::Play => self.began = Some(tick + self.lead),
            Touched::Stop => self.began = None,
            Touched::Pull(_) | Touched::Port(..) => {}
        }
    }
}

impl Recorder {
    /// A pointer holds MAT number `mass` of the scene, where it is; one that held another lets go of that.
    ///
    /// # Errors
    /// If it cannot be held, or the engine takes no order.
    pub fn grab(&mut self, mass: usize) -> Result<(), Refused> {
        let pointer = Pointer::new(&self.scene, mass)?;
        self.command(EngineCommand::Touch(Touch::Grab(pointer)))
    }

    /// Pulls the mass that is held to a displacement from rest \[m\]; on a line the first number counts.
    ///
    /// # Errors
    /// If that is not a place, or the engine does not take orders.
    pub fn drag(&mut self, to: [f64; 3]) -> Result<(), Refused> {
        if to.iter().any(|x| !x.is_finite()) {
            return Err(Refused::Place);
        }
        self.command(EngineCommand::Touch(Touch::Pull(to)))
    }

    /// Lets go of the mass that is held.
    ///
    /// # Errors
    /// If the engine takes no order.
    pub fn release(&mut self) -> Result<(), Refused> {
        self.command(EngineCommand::Touch(Touch::Release))
    }

    /// Begins the model's own gesture, from its start, or ends it.
    ///
    /// # Errors
    /// If the model has none, or the engine takes no order.
    pub fn gesture(&mut self, play: bool) -> Result<(), Refused> {
        if !play {
            return self.command(EngineCommand::Touch(Touch::Stop));
        }
        let own = OwnGesture::new(&self.scene).ok_or(Refused::NoGesture)?;
        self.command(EngineCommand::Touch(Touch::Play(Box::new(own))))
    }

    /// Sends a position port, or a device key whose device has said nothing or does not have it, to a position \[m\], or a force port to a force \[N\], in so long \[s\].
    ///
    /// # Errors
    /// If the port does not exist or belongs to a device, or the engine does not take orders.
    pub fn port(&mut self, name: &str, value: f64, over: f64) -> Result<(), Refused> {
        let Some(input) = self.scene.input(name) else {
            return Err(Refused::Port(name.into(), self.scene.inputs.iter().map(|i| i.name.clone()).collect()));
        };
        let device = self.scene.inputs[input].device.as_ref();
        if let Some(device) = device.filter(|d| self.seen.iter().any(|s| s.name == d.0 && d.1 < s.dof)) {
            return Err(Refused::OfDevice(name.into(), device.0.clone()));
        }
        if !value.is_finite() || over.is_nan() {
            return Err(Refused::Value(name.into()));
        }
        if value.abs() > FURTHEST {
            return Err(Refused::Far(name.into()));
        }
        self.command(EngineCommand::Touch(Touch::Port(input as u32, value, over.clamp(0.0, LONGEST))))
    }

    /// The MAT that a pointer holds.
    pub fn held(&self) -> Option<usize> {
        self.hand.held
    }

    /// Whether the model's own gesture is under way.
    pub fn playing(&self) -> bool {
        self.hand.began.is_some_and(|began| self.tick < began + self.hand.length)
    }

    /// Sets the live parameters of the gesture to where they are now.
    pub(super) fn turn_gesture(&mut self) {
        if self.hand.params.is_empty() || !self.playing() {
            return;
        }
        let Some(began) = self.hand.began else { return };
        let t = self.tick.saturating_sub(began) as f64 * self.scene.rates.sample_dt;
        let params = self.controls.params();
        let changes: Vec<(String, f64)> = self
            .hand
            .params
            .iter()
            .filter_map(|track| {
                let param = params.iter().find(|p| p.name == track.name())?;
                let value = track.at(t).clamp(param.min, param.max);
                (value != param.value).then(|| (param.name.clone(), value))
            })
            .collect();
        if !changes.is_empty() {
            // an engine that has more to do than it can take is asked again at the next turn
            let _ = self.set(&changes);
        }
    }
}
