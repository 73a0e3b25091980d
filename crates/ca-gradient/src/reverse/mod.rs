//! Reverse mode: derivatives of a loss by all numbers of a scene and by all inputs, in one backward pass.
//!
//! Only positions, motions and memory pass from one tick to the next. So the scene is played once, with a state stored
//! every √n ticks. Then each stretch between two states, from the last to the first, is played again
//! ([`crate::parts::record`]) and propagated backwards tick by tick ([`adjoint`]). Linear links take as long backwards
//! as forwards, since they are their own transposes; every other link is evaluated alone over dual numbers
//! ([`crate::parts::single_link`]). Time does not grow with the number of parameters, and memory grows with √n. Recording
//! every operation of every tick would take far more.
//!
//! The derivatives are those of forward mode; where a contact closes or opens, they are one-sided in the same sense.

mod adjoint;
mod checkpoints;
mod outputs;
mod single;
mod sums;
mod tapped_links;

use crate::forward::over_dual;
use crate::parts::numbers::Numbers;
use crate::parts::record::Record;
use crate::parts::{Parts, number};
use crate::play_io::{BLOCK, frames_of};
use crate::{Error, Forward, GoesOn, Parameter};
use adjoint::Adjoint;
use ca_core::internal::op::layout::{CoordinateSource, Enx, Shape as PortShape};
use ca_core::{Dual, InputRole, Scene};
use ca_io::gesture::Gesture;
use ca_io::perform::Performance;
use checkpoints::Checkpointed;
use cordis_anima::{Loaded, Options};

pub use checkpoints::Checkpoints;

/// Scene prepared for reverse mode.
pub struct Reverse {
    scene: Scene,
    parts: Parts,
    dual: Scene<Dual>,
    /// The scene with each number replaced by its index.
    place: Scene,
    parameters: Vec<Parameter>,
    /// Derivatives of the numbers of the scene, per parameter.
    derivatives: Vec<Vec<f64>>,
    /// Numbers that some parameter changes.
    needed: Vec<bool>,
    /// Ports with derivatives: indices into [`State::input`].
    ports: Vec<usize>,
}

fn ports(scene: &Scene) -> Vec<usize> {
    let l = &scene.layout;
    let says_where = |input: usize| {
        let mut moved = l.ports.enx.iter().chain(&l.ports.tgr).filter(|p| p.input as usize == input);
        let at = |m: u32| l.places.moving_points.iter().any(|p| p.at.contains(&CoordinateSource::Mat(m)));
        moved.any(|p| at(p.mat))
    };
    let late = |i: usize| scene.inputs[i].role == InputRole::Device && l.ports.crossing.latency > 0;
    (0..scene.inputs.len()).filter(|i| !late(*i) && !says_where(*i)).collect()
}

/// Gradient of a loss, by parameters and by port inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// Derivatives of the loss by each parameter, per its unit.
    pub parameters: Vec<f64>,
    /// Derivatives of the loss by the input of each of [`Reverse::ports`] in each sample, per m or N (frames x ports).
    pub inputs: Vec<f64>,
}

impl Reverse {
    /// Compiles a model to be differentiated by the parameters `wrt`, as [`Forward::new`].
    ///
    /// # Errors
    /// As [`Forward::new`]; [`Error::Refused`] also where the scene has a pass, or a parameter changes a number, that
    /// reverse mode does not support.
    pub fn new(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Reverse, Error> {
        let options = Options { energy: false, audited: false, exact: false, ..options.clone() };
        let (forward, dual) = Forward::begun(loaded, &options, wrt)?;
        let dual = over_dual(&dual)?;
        let (scene, parameters) = forward.into_parts();
        let parts = Parts::of(&scene)?;
        let Numbers { place, count, derivatives: all } = Numbers::new(loaded, &options, &parameters)?;
        let needed: Vec<bool> = (0..count).map(|i| all.iter().any(|d| d[i] != 0.0)).collect();
        let reverse = Reverse { dual, parameters, derivatives: all, ports: ports(&scene), parts, place, needed, scene };
        reverse.check()?;
        Ok(reverse)
    }

    /// Refuses parameters that change a number whose adjoint is not computed.
    fn check(&self) -> Result<(), Error> {
        let mut place = self.place.layout.clone();
        let coef = &self.place.initial.coef;
        let mut wanted: Vec<(f64, &str)> = Vec::new();
        for t in &mut place.tables {
            t.numbers(&mut |v| wanted.push((*v, "the table of a law")));
        }
        wanted.extend(self.place.initial.f.iter().map(|v| (*v, "the forces at load, which start as in mi.lib")));
        wanted.extend(place.out.lowpass.iter().map(|v| (*v, "the low-pass of the outputs")));
        for p in &place.places.moving_points {
            let at =
                p.at.iter()
                    .filter_map(|at| if let CoordinateSource::Coef(c) = at { Some(coef[*c as usize]) } else { None });
            wanted.extend(at.map(|v| (v, "the position of a point on a string or a skin")));
        }
        match wanted.into_iter().find(|(v, _)| self.needed[number(*v)]) {
            Some((_, what)) => {
                Err(Error::refused(format!("no reverse mode: a parameter changes {what}; use forward mode")))
            }
            None => Ok(()),
        }
    }

    /// The sound rate \[Hz\].
    pub fn rate(&self) -> f64 {
        self.scene.rate
    }

    /// Values per sample: the sound channels, then the probes.
    pub fn outputs(&self) -> usize {
        self.scene.counts.n_out
    }

    /// Parameters differentiated by.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Returns the names of the ports with derivatives. Excluded are ports that place a moving point, and devices with
    /// a `latency`. The input of a device counts in the samples at which its frames end, and in the last sample of a
    /// sound that ends within a frame.
    pub fn ports(&self) -> impl Iterator<Item = &str> {
        self.ports.iter().map(|i| self.scene.inputs[*i].name.as_str())
    }

    /// Returns the outputs without derivatives, as [`Forward::output`].
    ///
    /// # Errors
    /// As [`Forward::output`].
    pub fn output(&self, seconds: Option<f64>, gesture: Option<&Gesture>, goes_on: GoesOn) -> Result<Vec<f64>, Error> {
        crate::play_io::output(&self.scene, seconds, gesture, goes_on)
    }

    /// Returns whether reverse mode supports a gesture. It does not where a link that depends on the sum of all forces
    /// holds a port that the gesture moves.
    ///
    /// # Errors
    /// [`Error::Gesture`] where the gesture does not fit the model.
    pub fn knows(&self, gesture: Option<&Gesture>) -> Result<bool, Error> {
        Ok(self.starting_port(&Performance::new(&self.scene, gesture)?).is_none())
    }

    /// Returns the first port whose gesture begins elsewhere, or moving, where that is part of the start
    /// ([`ca_core::Scene::state_from`]).
    fn starting_port(&self, p: &Performance) -> Option<&str> {
        let (ports, moves) = (&self.scene.layout.ports, self.scene.layout.oversample() == 1);
        let mut all = ports.enx.iter().map(|p| (p, moves)).chain(ports.tgr.iter().map(|p| (p, false)));
        let elsewhere = |(port, moves): &(&Enx, bool)| {
            let hand = p.hand(port.input as usize).filter(|_| port.implicit);
            hand.is_some_and(|[x, d]| x != port.rest || (*moves && d != 0.0))
        };
        all.find(elsewhere).map(|(port, _)| self.scene.inputs[port.input as usize].name.as_str())
    }

    /// Propagates the adjoints of port-driven coefficients. Such a coefficient is linear within a frame and ends at the
    /// table value of the input at the beginning of that frame. `to` receives a sample, an input and its adjoint.
    fn drive(&self, tick: usize, given: &[f64], back: &mut Adjoint, mut to: impl FnMut(usize, usize, f64)) {
        let (l, inputs) = (&self.scene.layout, self.scene.inputs.len());
        let frame = l.rates.frame as usize;
        let last = tick.div_ceil(frame) * frame;
        let part = if tick == 0 { 1.0 } else { (tick + frame - last) as f64 / frame as f64 };
        for (d, place) in l.ports.driven.iter().zip(&self.place.layout.ports.driven) {
            let (input, n) = (d.input as usize, d.places.len());
            let device = self.scene.inputs[input].role == InputRole::Device;
            for (last, part) in [(last, part), (last.saturating_sub(frame), 1.0 - part)] {
                let first = (last + 1).saturating_sub(frame);
                let step = (d.rows - 1) as f64 / (d.span[1] - d.span[0]);
                let at = (given[first * inputs + input] - d.span[0]) * step;
                if part == 0.0 || !at.is_finite() {
                    continue;
                }
                let inside = at.clamp(0.0, (d.rows - 1) as f64);
                let row = (inside as usize).min(d.rows - 2);
                let share = inside - row as f64;
                for (k, live) in d.places.iter().enumerate() {
                    let coef = self.scene.live.coefs[*live as usize] as usize;
                    let Ok(which) = self.parts.driven.binary_search(&coef) else { continue };
                    let adjoint = part * back.driven[which];
                    let [below, above] = [row * n + k, (row + 1) * n + k];
                    back.of_numbers[number(place.table[below])] += (1.0 - share) * adjoint;
                    back.of_numbers[number(place.table[above])] += share * adjoint;
                    if at == inside {
                        let slope = (d.table[above] - d.table[below]) * step;
                        to(if device { last } else { first }, input, slope * adjoint);
                    }
                }
            }
        }
    }

    /// Returns the samples of a gesture on which an input depends at a tick, with their weights. For a device these are
    /// the ends of frames, with the interpolation of the border between them (docs/numerics.md §5.1).
    fn given_at(&self, input: usize, tick: usize) -> [(usize, f64); 2] {
        let l = &self.scene.layout;
        let frame = l.rates.frame as usize;
        if self.scene.inputs[input].role != InputRole::Device || tick == 0 {
            return [(tick, 1.0), (tick, 0.0)];
        }
        let last = tick.div_ceil(frame) * frame;
        let part = match l.ports.crossing.shape {
            PortShape::Linear => (tick + frame - last) as f64 / frame as f64,
            PortShape::Hold => 1.0,
        };
        [(last, part), (last - frame, 1.0 - part)]
    }

    /// As [`Forward::gradient`], by port inputs too: the gradient of a loss from its cotangent (frames x outputs).
    ///
    /// # Errors
    /// As [`Forward::gradient`].
    pub fn gradient(&self, cotangent: &[f64], gesture: Option<&Gesture>, goes_on: GoesOn) -> Result<Gradient, Error> {
        let frames = frames_of(cotangent, self.scene.counts.n_out.max(1))?;
        let kept = Checkpointed::of(self, frames, gesture, &mut |_| {}, goes_on)?;
        self.back(&kept, cotangent, goes_on)
    }

    /// As [`Reverse::gradient`], from the stored play; the cotangent has as many samples.
    fn back(&self, kept: &Checkpointed, cotangent: &[f64], goes_on: GoesOn) -> Result<Gradient, Error> {
        let scene = &self.scene;
        let (inputs, outputs, stretch) = (scene.inputs.len(), scene.counts.n_out.max(1), kept.stretch);
        let (frames, given) = (kept.frames, &kept.given);
        let mut back = Adjoint::new(scene, &self.parts, &self.dual, &self.place, &self.needed)?;
        let adjoint = back.outputs.before_low_pass(cotangent);
        let ports = self.ports.len();
        let mut by_inputs = vec![0.0; frames * ports];
        let filters = self.place.layout.out.blockers.iter().flat_map(|b| [b.r, b.g]).any(|v| self.needed[number(v)]);
        let mut record = Record::new(scene, &self.parts, stretch, [filters, false]);
        let mut asked = 0;
        kept.back(|k, s| {
            let first = k * stretch;
            let ticks = stretch.min(frames - first);
            let given_here = &given[first * inputs..][..ticks * inputs];
            record.play(scene, &self.parts, s, given_here, ticks, |_, _| {});
            for i in (0..ticks).rev() {
                let tick = first + i;
                let adjoint = if scene.counts.n_out == 0 { &[] } else { &adjoint[tick * outputs..][..outputs] };
                back.back(tick, record.row(i), adjoint);
                if back.is_full() || i == 0 {
                    back.sum(&record, i);
                }
                // a frame that the end of the sound cuts short ends with its last sample
                let at = |sample: usize, k: usize| sample.min(frames - 1) * ports + k;
                if !self.parts.driven.is_empty() {
                    self.drive(tick, given, &mut back, |sample, input, adjoint| {
                        if let Some(k) = self.ports.iter().position(|i| *i == input) {
                            by_inputs[at(sample, k)] += adjoint;
                        }
                    });
                }
                for (k, i) in self.ports.iter().enumerate() {
                    for (sample, part) in self.given_at(*i, tick) {
                        by_inputs[at(sample, k)] += part * back.inputs[*i];
                    }
                }
            }
            asked += ticks as u64;
            if asked >= BLOCK {
                asked = 0;
                if !goes_on() {
                    return Err(Error::Stopped);
                }
            }
            Ok(())
        })?;
        let numbers = back.end();
        let by =
            |d: &Vec<f64>| d.iter().zip(&numbers).filter(|(d, _)| **d != 0.0).map(|(d, adjoint)| d * adjoint).sum();
        Ok(Gradient { parameters: self.derivatives.iter().map(by).collect(), inputs: by_inputs })
    }
}
