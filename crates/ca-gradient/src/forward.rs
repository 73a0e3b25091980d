//! Forward mode: plays a scene together with the derivatives of all numbers it begins with.
//!
//! Parameters are taken seven at a time, one play for each seven: a value and seven derivatives fill the vectors of a
//! processor, while a loop over any number of derivatives would spend its time on loads and stores. A mostly linear
//! scene is played by its own passes instead ([`crate::tangent`]). Port inputs are computed beforehand for every tick,
//! by the same loop that reads gestures elsewhere ([`Played`]).

use crate::difference::{Start, derivatives};
use crate::parameter::put;
use crate::parts::Parts;
use crate::parts::numbers::Numbers;
use crate::play_io::{BLOCK, GoesOn, Played, diverged, frames_of, zeros};
use crate::tangent::Tangent;
use crate::{Error, Parameter};
use ca_compile::load::finish;
use ca_core::internal::scene;
use ca_core::{Catalog, Dual, Precision, Scene, State, TANGENTS};
use ca_io::gesture::Gesture;
use ca_io::player::Player;
use ca_model::Model;
use ca_model::diag::Diags;
use cordis_anima::{Loaded, Options, catalog, laws};

/// Scene with the derivatives of everything it begins with.
pub struct Forward {
    /// The scene in double precision, for its ports.
    pub(crate) plain: Scene,
    parameters: Vec<Parameter>,
    /// Derivatives of the numbers of the scene, per parameter.
    derivatives: Vec<Vec<f64>>,
    model: Model,
    catalog: Catalog,
    options: Options,
    /// Plays the scene by its own passes, if it is mostly linear.
    tangent: Option<Tangent>,
}

/// Outputs of a scene and their derivatives. All arrays are row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangents {
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Number of samples.
    pub frames: usize,
    /// Values per sample: the sound channels, then the probes.
    pub outputs: usize,
    /// Number of sound channels.
    pub channels: usize,
    /// Parameters differentiated by.
    pub parameters: Vec<Parameter>,
    /// Outputs, with the bits of a render (frames x outputs).
    pub output: Vec<f64>,
    /// Derivatives of the outputs, per unit of the parameter (frames x outputs x parameters).
    pub tangents: Vec<f64>,
}

impl Forward {
    /// Compiles a model with these options, to be differentiated by the parameters `wrt`: names in the syntax of
    /// `--set`, such as `low.f`, `hammer.v` or the name of a `[param]`, and numbers of lists, such as `ball.v[1]`.
    ///
    /// # Errors
    /// [`Error::Model`] where the model has errors; [`Error::Refused`] where a parameter does not exist or is not a
    /// number with a derivative, or where the scene has groups at the gesture rate.
    pub fn new(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Forward, Error> {
        Forward::made(loaded, options, wrt, Tangent::is_worth)
    }

    /// As [`Forward::new`], by the passes of the scene whatever its size, with dual numbers only for links that are not
    /// linear. Returns `None` where this method does not support a part of the scene. It is slower for small scenes,
    /// for which [`Forward::new`] does not use it.
    ///
    /// # Errors
    /// As [`Forward::new`].
    pub fn by_passes(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Option<Forward>, Error> {
        Ok(Some(Forward::made(loaded, options, wrt, |_, _| true)?).filter(|f| f.tangent.is_some()))
    }

    /// As [`Forward::new`], by dual numbers for the whole tick: the reference for the other methods.
    ///
    /// # Errors
    /// As [`Forward::new`].
    pub fn by_dual_numbers(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Forward, Error> {
        Forward::made(loaded, options, wrt, |_, _| false)
    }

    /// `by_passes` decides, for a scene that the method by passes supports, whether to use it.
    fn made(
        loaded: &Loaded,
        options: &Options,
        wrt: &[&str],
        by_passes: fn(&Scene, &Parts) -> bool,
    ) -> Result<Forward, Error> {
        let (mut forward, mut scene) = Forward::begun(loaded, options, wrt)?;
        if let Some(parts) = Tangent::parts(&forward.plain).filter(|parts| by_passes(&forward.plain, parts)) {
            let options = Options { energy: false, audited: false, exact: false, ..options.clone() };
            let numbers = Numbers::new(loaded, &options, &forward.parameters)?;
            forward.tangent = Tangent::new(&forward.plain, parts, over_dual(&scene)?, numbers);
            if forward.tangent.is_some() {
                return Ok(forward);
            }
            scene = forward.compiled(&forward.model).map_err(Error::Refused)?;
        }
        forward.differenced(scene)
    }

    /// As [`Forward::new`], for a scene with the energy ledger.
    pub(crate) fn with_ledger(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Forward, Error> {
        let (mut forward, _) = Forward::begun(loaded, options, wrt)?;
        forward.options.energy = true;
        let scene = forward.compiled(&forward.model).map_err(Error::Refused)?;
        forward.differenced(scene)
    }

    /// Adds the derivatives of the numbers that its `scene` begins with.
    fn differenced(mut self, mut scene: Scene) -> Result<Forward, Error> {
        let start = Start::of(&mut scene);
        for p in &self.parameters {
            let other = |value: f64| {
                let mut other = self.compiled(&put(p, &self.model, value))?;
                Ok(Start::of(&mut other))
            };
            let all = derivatives(&start, p, &other)?;
            self.derivatives.push(all);
        }
        Ok(self)
    }

    /// Returns a `Forward` without derivatives of the start, and the scene to bind to dual numbers.
    pub(crate) fn begun(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<(Forward, Scene), Error> {
        let options = Options { energy: false, audited: false, exact: false, ..options.clone() };
        let plain = loaded.compile(&options)?.scene;
        let (model, catalog) = (loaded.model.clone(), catalog());
        let options = Options {
            rate: options.rate,
            probes: options.probes,
            clouds: loaded.clouds.clone(),
            whole: options.whole,
            precision: Precision::Dual,
            ..Options::default()
        };
        let forward = Forward {
            plain,
            parameters: wrt.iter().map(|name| Parameter::find(&model, &catalog, name)).collect::<Result<_, _>>()?,
            derivatives: Vec::new(),
            model,
            catalog,
            options,
            tangent: None,
        };
        let scene = forward.compiled(&forward.model).map_err(Error::Refused)?;
        if scene.rates.slow.is_some() {
            let what = "no derivatives of this scene: groups at the gesture rate are not differentiated; remove `rate = \"gesture\"` from the group";
            return Err(Error::refused(what));
        }
        Ok((forward, scene))
    }

    pub(crate) fn into_parts(self) -> (Scene, Vec<Parameter>) {
        (self.plain, self.parameters)
    }

    /// The sound rate \[Hz\].
    pub fn rate(&self) -> f64 {
        self.plain.rate
    }

    /// Duration of a tick \[s\].
    pub(crate) fn sample_dt(&self) -> f64 {
        self.plain.rates.sample_dt
    }

    /// Values per sample: the sound channels, then the probes.
    pub fn outputs(&self) -> usize {
        self.plain.counts.n_out
    }

    /// Parameters differentiated by.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Returns the outputs and all their derivatives over `seconds`, or over the length of a render of the model.
    ///
    /// # Errors
    /// [`Error::Gesture`] where the gesture does not fit the model; [`Error::Refused`] where it drives a live
    /// parameter, or where the scene diverges.
    pub fn tangents(
        &self,
        seconds: Option<f64>,
        gesture: Option<&Gesture>,
        goes_on: GoesOn,
    ) -> Result<Tangents, Error> {
        let played = Played::new(&self.plain, seconds, gesture, goes_on)?;
        let (frames, outputs, n) = (played.frames, self.plain.counts.n_out, self.parameters.len());
        let mut to = Tangents {
            rate: self.plain.rate,
            frames,
            outputs,
            channels: self.plain.counts.channels,
            parameters: self.parameters.clone(),
            output: zeros(frames, outputs, 1)?,
            tangents: zeros(frames, outputs, n)?,
        };
        for first in (0..n.max(1)).step_by(TANGENTS) {
            let some = first..n.min(first + TANGENTS);
            self.play(
                &played,
                some.clone(),
                &mut |frame, s| {
                    for (k, v) in s.output.iter().enumerate() {
                        let at = frame * outputs + k;
                        to.output[at] = v.value();
                        to.tangents[at * n..][some.clone()].copy_from_slice(&v.tangents()[..some.len()]);
                    }
                },
                goes_on,
            )?;
        }
        Ok(to)
    }

    /// Returns the outputs without derivatives (frames x outputs), to compute a loss from. The cotangent of that loss
    /// goes to [`Forward::gradient`].
    ///
    /// # Errors
    /// As [`Forward::tangents`].
    pub fn output(&self, seconds: Option<f64>, gesture: Option<&Gesture>, goes_on: GoesOn) -> Result<Vec<f64>, Error> {
        crate::play_io::output(&self.plain, seconds, gesture, goes_on)
    }

    /// Returns the gradient of a loss by the parameters. The cotangent holds the derivative of the loss by each output
    /// value (frames x outputs) and sets the number of frames. No derivatives of samples are stored.
    ///
    /// # Errors
    /// As [`Forward::tangents`], and where the cotangent is empty, not finite or not made of whole rows.
    pub fn gradient(&self, cotangent: &[f64], gesture: Option<&Gesture>, goes_on: GoesOn) -> Result<Vec<f64>, Error> {
        let outputs = self.plain.counts.n_out.max(1);
        let seconds = frames_of(cotangent, outputs)? as f64 / self.plain.rate;
        let played = Played::new(&self.plain, Some(seconds), gesture, goes_on)?;
        let n = self.parameters.len();
        let mut gradient = vec![0.0; n];
        for first in (0..n).step_by(TANGENTS) {
            let some = first..n.min(first + TANGENTS);
            self.play(
                &played,
                some.clone(),
                &mut |frame, s| {
                    for (v, by) in s.output.iter().zip(&cotangent[frame * outputs..]) {
                        for (sum, t) in gradient[some.clone()].iter_mut().zip(v.tangents()) {
                            *sum += by * t;
                        }
                    }
                },
                goes_on,
            )?;
        }
        Ok(gradient)
    }

    /// Plays the scene with the derivatives by `some` parameters; `on_sample` receives the state after each sample.
    pub(crate) fn play(
        &self,
        played: &Played,
        some: std::ops::Range<usize>,
        on_sample: &mut impl FnMut(usize, &State<Dual>),
        goes_on: GoesOn,
    ) -> Result<(), Error> {
        if let Some(tangent) = &self.tangent {
            let given = (&played.given[..], played.frames);
            return tangent.play(&self.plain, given, some, &mut |frame, row| {
                on_sample(frame, row);
                let asks = (frame as u64 + 1).is_multiple_of(BLOCK);
                if asks && !goes_on() { Err(Error::Stopped) } else { Ok(()) }
            });
        }
        let mut scene = over_dual(&self.compiled(&self.model).map_err(Error::Refused)?)?;
        let columns = &self.derivatives[some];
        let mut i = 0;
        scene::numbers(&mut scene, &mut |v: &mut Dual| {
            for (t, all) in v.tangents_mut().iter_mut().zip(columns) {
                *t = all[i];
            }
            i += 1;
        });
        let mut player = Player::new(scene.state_from(|input| played.hands.get(input).copied().flatten()));
        let inputs = scene.inputs.len();
        for frame in 0..played.frames {
            player.state.input.copy_from_slice(&played.given[frame * inputs..][..inputs]);
            player.tick(&scene);
            on_sample(frame, &player.state);
            if player.diverged {
                return Err(diverged());
            }
            if player.state.tick.is_multiple_of(BLOCK) && !goes_on() {
                return Err(Error::Stopped);
            }
        }
        Ok(())
    }

    fn compiled(&self, model: &Model) -> Result<Scene, String> {
        finish(model, Diags::new(), &self.catalog, &self.options).map(|c| c.scene).map_err(|diags| Error::first(&diags))
    }
}

pub(crate) fn over_dual(scene: &Scene) -> Result<Scene<Dual>, Error> {
    scene.bind(&laws()).map_err(|why| Error::Refused(why.to_string()))
}
