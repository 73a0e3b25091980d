//! Hands without a device: a pointer that pulls on a mass, ports moved by a slider, and the gesture that a model brings along.
//!
//! Decides that all of them end in what a scene knows already, its inputs and the [`Pointer`], so that a scene without them pays nothing but a question a
//! tick; that nothing jumps, since a jump of a port is a blow: ports glide to where they are sent (over no time only where a model
//! says so of its MIDI), and the model's own
//! gesture begins with a lead-in from where its ports are; and that who stops a gesture leaves positions where they are and lets go of
//! forces. A port of a device is moved by a gesture, or sent somewhere, as long as no device has spoken. Live parameters in a
//! gesture are the recorder's, which knows what else was set: they come as changes.

use ca_core::pointer::Pointer;
use ca_core::{InputRole, Scene, State};
use ca_io::gesture::{Track, own};

/// Time a port takes to where a slider sends it \[s\]: that of a page speaks 60 times a second.
pub const GLIDE: f64 = 1.0 / 60.0;
/// No port takes longer to where it is sent \[s\].
pub const LONGEST: f64 = 60.0;
/// Time from where ports are to where a gesture begins \[s\].
const LEAD: f64 = 0.05;

/// Ticks of the lead-in of a gesture.
pub(crate) fn lead(scene: &Scene) -> u64 {
    (LEAD * scene.rate).round() as u64
}

/// What a hand without a device does.
#[derive(Clone, Debug, PartialEq)]
pub enum Touch {
    /// holds a mass
    Grab(Pointer),
    /// pulls it to this displacement from rest \[m\]
    Pull([f64; 3]),
    /// lets go
    Release,
    /// begins the model's own gesture
    Play(Box<OwnGesture>),
    /// ends it
    Stop,
    /// sends a port, by its index into [`State::input`], to a position \[m\] or a force \[N\] in so long \[s\]
    Port(u32, f64, f64),
}

/// The same without what it needs: for the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Touched {
    /// MAT number `.0` is held
    Grab(u32),
    /// it is pulled to this displacement \[m\]
    Pull([f64; 3]),
    /// it is let go
    Release,
    /// the model's own gesture begins
    Play,
    /// it ends
    Stop,
    /// a port is sent to a position \[m\] or a force \[N\] in so long \[s\]
    Port(u32, f64, f64),
}

impl Touch {
    /// What is recorded of it.
    pub fn touched(&self) -> Touched {
        match self {
            Touch::Grab(pointer) => Touched::Grab(pointer.mass() as u32),
            Touch::Pull(to) => Touched::Pull(*to),
            Touch::Release => Touched::Release,
            Touch::Play(_) => Touched::Play,
            Touch::Stop => Touched::Stop,
            Touch::Port(port, value, over) => Touched::Port(*port, *value, *over),
        }
    }
}

impl Touched {
    /// What does it again in a scene; `None` where that has no such mass or gesture.
    pub fn again(&self, scene: &Scene) -> Option<Touch> {
        Some(match *self {
            Touched::Grab(mass) => Touch::Grab(Pointer::new(scene, mass as usize).ok()?),
            Touched::Pull(to) => Touch::Pull(to),
            Touched::Release => Touch::Release,
            Touched::Play => Touch::Play(Box::new(OwnGesture::new(scene)?)),
            Touched::Stop => Touch::Stop,
            Touched::Port(port, value, over) => Touch::Port(port, value, over),
        })
    }
}

impl Touched {
    /// In words; none for what comes many times a second.
    pub fn words(&self, scene: Option<&Scene>) -> Option<String> {
        Some(match self {
            Touched::Grab(mass) => {
                let symbol = scene.and_then(|s| s.symbols.get(*mass as usize));
                symbol.map_or_else(|| format!("grabs mass {mass}"), |s| format!("grabs {}", s.name))
            }
            Touched::Release => "lets go".into(),
            Touched::Play => "the model's own gesture begins".into(),
            Touched::Stop => "the model's own gesture ends".into(),
            Touched::Pull(_) | Touched::Port(..) => return None,
        })
    }
}

/// A port that a gesture moves.
#[derive(Clone, Debug, PartialEq)]
struct Driven {
    input: usize,
    role: InputRole,
    track: Track,
    near: usize,
    /// where it was when the gesture began
    from: f64,
}

/// The gesture that a model brings along, as an engine plays it.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnGesture {
    driven: Vec<Driven>,
    /// tick at which it began
    start: u64,
    /// ticks of its lead-in
    lead: u64,
    sample_dt: f64,
    /// the scene was loaded again: nothing of it is left but its memory, which is freed elsewhere
    over: bool,
}

impl OwnGesture {
    /// Of a scene; `None` where the model brings none.
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

    /// Moves the ports of one kind to where they are at `tick`.
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

/// A port on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Glide {
    input: usize,
    to: f64,
    step: f64,
    left: u32,
}

impl Glide {
    /// So many ticks on.
    fn turn(&mut self, input: &mut [f64], ticks: u32) {
        let x = &mut input[self.input];
        *x = if self.left > ticks { *x + self.step * f64::from(ticks) } else { self.to };
        self.left = self.left.saturating_sub(ticks);
    }
}

/// All hands of an engine that are no device.
pub(super) struct Hands {
    pub(super) pointer: Option<Pointer>,
    own: Option<Box<OwnGesture>>,
    /// room for every port
    glides: Vec<Glide>,
    rate: f64,
}

impl Hands {
    pub(super) fn new(scene: &Scene) -> Hands {
        Hands { pointer: None, own: None, glides: Vec::with_capacity(scene.inputs.len()), rate: scene.rate }
    }

    /// Does what is asked; gives back what is to be freed elsewhere, and false where the scene has no such port.
    pub(super) fn touch(&mut self, scene: &Scene, state: &State, touch: Touch) -> (Option<Box<OwnGesture>>, bool) {
        match touch {
            Touch::Grab(mut pointer) => {
                pointer.hold(state);
                self.pointer = Some(pointer);
            }
            Touch::Pull(to) => {
                if let Some(pointer) = &mut self.pointer {
                    pointer.pull(to);
                }
            }
            Touch::Release => self.pointer = None,
            Touch::Play(mut own) => {
                own.begin(state);
                return (self.own.replace(own), true);
            }
            Touch::Stop => return (self.stop(state), true),
            Touch::Port(port, value, over) => {
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
        let room = self.glides.len() < self.glides.capacity();
        match self.glides.iter_mut().find(|g| g.input == input) {
            Some(g) => *g = glide,
            // one for each port, for which there is room
            None if room => self.glides.push(glide),
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

    /// Lets go of everything.
    pub(super) fn let_go(&mut self) {
        self.pointer = None;
        self.glides.clear();
        if let Some(own) = &mut self.own {
            own.over = true;
        }
    }

    /// Once a gesture frame: ports of devices, of those for which nobody speaks.
    pub(super) fn frame(&mut self, scene: &Scene, state: &mut State, silent: impl Fn(usize) -> bool) {
        let is_device = |input: usize| scene.inputs[input].role == InputRole::Device;
        for g in self.glides.iter_mut().filter(|g| is_device(g.input)) {
            // whose device speaks goes where that is
            if !silent(g.input) {
                g.left = 0;
                continue;
            }
            g.turn(&mut state.input, scene.rates.ratio);
        }
        self.glides.retain(|g| g.left > 0 || !is_device(g.input));
        if let Some(own) = &mut self.own {
            // at a frame it is read where the frame ends, as everywhere
            let end = state.tick + if state.tick == 0 { 0 } else { u64::from(scene.rates.ratio) - 1 };
            own.drive(end, &mut state.input, |role, input| role == InputRole::Device && silent(input));
        }
    }

    /// Once a tick, before its forces.
    #[inline]
    pub(super) fn tick(&mut self, scene: &Scene, state: &mut State) {
        if !self.glides.is_empty() {
            let is_device = |g: &Glide| scene.inputs[g.input].role == InputRole::Device;
            self.glides.iter_mut().filter(|g| !is_device(g)).for_each(|g| g.turn(&mut state.input, 1));
            self.glides.retain(|g| g.left > 0 || is_device(g));
        }
        if let Some(own) = &mut self.own {
            own.drive(state.tick, &mut state.input, |role, _| role != InputRole::Device);
        }
    }
}
