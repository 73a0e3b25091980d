//! Manual input without a device: pointers that pull masses (one for each finger), ports moved by sliders, and the
//! gesture of a model.
//!
//! All of it acts on the inputs of the scene and on the [`Pointer`]s, so that a scene without manual input pays only one
//! check per tick. No port jumps, because a jump is a blow: ports glide to their targets (without a glide only if a
//! model specifies that for its MIDI), and the model's own gesture begins with a lead-in from the present positions.
//! When a gesture stops, positions stay and forces are released. Gestures and sliders move the port of a device until
//! the device has sent a frame. The recorder sets live parameters in a gesture, because it knows the other changes:
//! they come as [`Change`](super::Change).

use ca_core::internal::state::FINGERS;
use ca_core::pointer::Pointer;
use ca_core::{InputRole, Scene, State};
use ca_io::gesture::{Track, own};

/// Duration of the glide to the value of a slider \[s\]: a slider on the page sends 60 values a second.
pub const GLIDE: f64 = 1.0 / 60.0;
/// Longest glide of a port \[s\].
pub const LONGEST: f64 = 60.0;
/// Duration of the lead-in, from the present positions to the start of a gesture \[s\].
const LEAD: f64 = 0.05;

/// Returns the lead-in of a gesture \[ticks\].
pub(crate) fn lead(scene: &Scene) -> u64 {
    (LEAD * scene.rate).round() as u64
}

/// An action of manual input.
#[derive(Clone, Debug, PartialEq)]
pub enum ManualInput {
    /// Holds a mass with the finger of the pointer.
    Grab(Pointer),
    /// Pulls the mass that finger `.0` holds to this displacement from rest \[m\].
    Pull(u8, [f64; 3]),
    /// Releases the mass that this finger holds.
    Release(u8),
    /// Starts the model's own gesture.
    Play(Box<OwnGesture>),
    /// Stops it.
    Stop,
    /// Moves a port, by its index into [`State::input`], to a position \[m\] or a force \[N\] in a time \[s\].
    Port(u32, f64, f64),
}

/// A [`ManualInput`] without the memory that it needs, for the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ManualEvent {
    /// Holds MAT number `.1` with finger `.0`.
    Grab(u8, u32),
    /// Pulls the mass that finger `.0` holds to this displacement \[m\].
    Pull(u8, [f64; 3]),
    /// Releases the mass that this finger holds.
    Release(u8),
    /// Starts the model's own gesture.
    Play,
    /// Stops it.
    Stop,
    /// Moves a port to a position \[m\] or a force \[N\] in a time \[s\].
    Port(u32, f64, f64),
}

impl ManualInput {
    /// Returns the form for the record.
    pub fn event(&self) -> ManualEvent {
        match self {
            ManualInput::Grab(pointer) => {
                let (finger, mass) = pointer.grip();
                ManualEvent::Grab(finger, mass as u32)
            }
            ManualInput::Pull(finger, to) => ManualEvent::Pull(*finger, *to),
            ManualInput::Release(finger) => ManualEvent::Release(*finger),
            ManualInput::Play(_) => ManualEvent::Play,
            ManualInput::Stop => ManualEvent::Stop,
            ManualInput::Port(port, value, over) => ManualEvent::Port(*port, *value, *over),
        }
    }
}

impl ManualEvent {
    /// Returns the action that repeats it in a scene; `None` if the scene lacks the mass or the gesture.
    pub fn to_input(&self, scene: &Scene) -> Option<ManualInput> {
        Some(match *self {
            ManualEvent::Grab(finger, mass) => ManualInput::Grab(Pointer::new(scene, mass as usize, finger).ok()?),
            ManualEvent::Pull(finger, to) => ManualInput::Pull(finger, to),
            ManualEvent::Release(finger) => ManualInput::Release(finger),
            ManualEvent::Play => ManualInput::Play(Box::new(OwnGesture::new(scene)?)),
            ManualEvent::Stop => ManualInput::Stop,
            ManualEvent::Port(port, value, over) => ManualInput::Port(port, value, over),
        })
    }
}

impl ManualEvent {
    /// Returns a description; `None` for an action that comes many times a second.
    pub fn words(&self, scene: Option<&Scene>) -> Option<String> {
        Some(match self {
            ManualEvent::Grab(_, mass) => {
                let symbol = scene.and_then(|s| s.symbols.get(*mass as usize));
                symbol.map_or_else(|| format!("grabs mass {mass}"), |s| format!("grabs {}", s.name))
            }
            ManualEvent::Release(_) => "lets go".into(),
            ManualEvent::Play => "the model's own gesture begins".into(),
            ManualEvent::Stop => "the model's own gesture ends".into(),
            ManualEvent::Pull(..) | ManualEvent::Port(..) => return None,
        })
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Driven {
    input: usize,
    role: InputRole,
    track: Track,
    near: usize,
    /// Value at the start of the gesture.
    from: f64,
}

/// The gesture of a model, as an engine plays it.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnGesture {
    driven: Vec<Driven>,
    /// Tick at which it began.
    start: u64,
    /// Ticks of its lead-in.
    lead: u64,
    sample_dt: f64,
    /// True after the scene was loaded again: it is stopped, and its memory is freed on another thread later.
    over: bool,
}

impl OwnGesture {
    /// Makes the gesture of a scene; `None` if the model has none.
    pub fn new(scene: &Scene) -> Option<OwnGesture> {
        if scene.about.gestures.is_empty() {
            return None;
        }
        let driven = own(scene).flatten().filter_map(|track| {
            let input = scene.input(track.name())?;
            Some(Driven { input, role: scene.inputs[input].role, track, near: 0, from: 0.0 })
        });
        let driven = driven.collect();
        Some(OwnGesture { driven, start: 0, lead: lead(scene), sample_dt: scene.rates.sample_dt, over: false })
    }

    fn begin(&mut self, state: &State) {
        self.start = state.tick;
        for d in &mut self.driven {
            (d.from, d.near) = (state.input[d.input], 0);
        }
    }

    /// Sets the ports for which `is` returns true to their values at `tick`.
    fn drive(&mut self, tick: u64, input: &mut [f64], is: impl Fn(InputRole, usize) -> bool) {
        if self.over {
            return;
        }
        let since = tick.saturating_sub(self.start);
        for d in &mut self.driven {
            if !is(d.role, d.input) {
                continue;
            }
            let t = since.saturating_sub(self.lead) as f64 * self.sample_dt;
            let value = d.track.at_near(&mut d.near, t);
            input[d.input] =
                if since < self.lead { d.from + (value - d.from) * since as f64 / self.lead as f64 } else { value };
        }
    }
}

/// A port that moves to a target.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Glide {
    input: usize,
    to: f64,
    step: f64,
    left: u32,
}

impl Glide {
    fn advance(&mut self, input: &mut [f64], ticks: u32) {
        let x = &mut input[self.input];
        *x = if self.left > ticks { *x + self.step * f64::from(ticks) } else { self.to };
        self.left = self.left.saturating_sub(ticks);
    }
}

pub(super) struct ManualState {
    /// Has capacity for each finger.
    pub(super) pointers: Vec<Pointer>,
    own: Option<Box<OwnGesture>>,
    /// Has capacity for each port.
    glides: Vec<Glide>,
    rate: f64,
}

impl ManualState {
    pub(super) fn new(scene: &Scene) -> ManualState {
        ManualState {
            pointers: Vec::with_capacity(FINGERS),
            own: None,
            glides: Vec::with_capacity(scene.inputs.len()),
            rate: scene.rate,
        }
    }

    /// Executes an action. Returns memory to be freed on another thread, and false if it does not fit the scene.
    pub(super) fn apply(
        &mut self,
        scene: &Scene,
        state: &State,
        action: ManualInput,
    ) -> (Option<Box<OwnGesture>>, bool) {
        match action {
            ManualInput::Grab(mut pointer) => {
                pointer.hold(state);
                let (finger, mass) = pointer.grip();
                self.pointers.retain(|p| p.grip().0 != finger && p.grip().1 != mass);
                // one for each finger, so it always fits
                if self.pointers.len() < self.pointers.capacity() {
                    self.pointers.push(pointer);
                }
            }
            ManualInput::Pull(finger, to) => {
                if let Some(pointer) = self.pointers.iter_mut().find(|p| p.grip().0 == finger) {
                    pointer.pull(to);
                }
            }
            ManualInput::Release(finger) => self.pointers.retain(|p| p.grip().0 != finger),
            ManualInput::Play(mut own) => {
                own.begin(state);
                return (self.own.replace(own), true);
            }
            ManualInput::Stop => return (self.stop(state), true),
            ManualInput::Port(port, value, over) => {
                let good = value.is_finite() && (0.0..=LONGEST).contains(&over);
                if !good || port as usize >= scene.inputs.len() {
                    return (None, false);
                }
                self.send(state, port as usize, value, over);
            }
        }
        (None, true)
    }

    fn send(&mut self, state: &State, input: usize, to: f64, over: f64) {
        let ticks = (over * self.rate).max(1.0) as u32;
        let step = (to - state.input[input]) / f64::from(ticks);
        let glide = Glide { input, to, step, left: ticks };
        let has_capacity = self.glides.len() < self.glides.capacity();
        match self.glides.iter_mut().find(|g| g.input == input) {
            Some(g) => *g = glide,
            // one for each port, so it always fits
            None if has_capacity => self.glides.push(glide),
            None => {}
        }
    }

    fn stop(&mut self, state: &State) -> Option<Box<OwnGesture>> {
        let own = self.own.take()?;
        for d in own.driven.iter().filter(|d| d.role == InputRole::Force) {
            self.send(state, d.input, 0.0, GLIDE);
        }
        Some(own)
    }

    pub(super) fn release_all(&mut self) {
        self.pointers.clear();
        self.glides.clear();
        if let Some(own) = &mut self.own {
            own.over = true;
        }
    }

    /// Moves the ports of devices that have not sent a frame, once a gesture frame.
    pub(super) fn frame(&mut self, scene: &Scene, state: &mut State, silent: impl Fn(usize) -> bool) {
        let is_device = |input: usize| scene.inputs[input].role == InputRole::Device;
        for g in self.glides.iter_mut().filter(|g| is_device(g.input)) {
            // the device moves this port
            if !silent(g.input) {
                g.left = 0;
                continue;
            }
            g.advance(&mut state.input, scene.rates.ratio);
        }
        self.glides.retain(|g| g.left > 0 || !is_device(g.input));
        if let Some(own) = &mut self.own {
            // at the gesture rate, its value is read at the end of the frame
            let end = state.tick + if state.tick == 0 { 0 } else { u64::from(scene.rates.ratio) - 1 };
            own.drive(end, &mut state.input, |role, input| role == InputRole::Device && silent(input));
        }
    }

    /// Moves the other ports, once a tick before its forces.
    #[inline]
    pub(super) fn tick(&mut self, scene: &Scene, state: &mut State) {
        if !self.glides.is_empty() {
            let is_device = |g: &Glide| scene.inputs[g.input].role == InputRole::Device;
            self.glides.iter_mut().filter(|g| !is_device(g)).for_each(|g| g.advance(&mut state.input, 1));
            self.glides.retain(|g| g.left > 0 || is_device(g));
        }
        if let Some(own) = &mut self.own {
            own.drive(state.tick, &mut state.input, |role, _| role != InputRole::Device);
        }
    }
}
