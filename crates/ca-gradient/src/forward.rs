//! Forward: a scene with the derivatives of all it begins with, played.
//!
//! Decides for as many renders as there are seven parameters begun, one after the other: a number and seven derivatives fill the
//! vectors of a processor, and a loop over any number of them would be one of loads and stores. A scene that is linear for the most
//! part is left to its own passes ([`crate::tangent`]). What the ports are given
//! is written down beforehand, tick by tick, by the one loop that reads gestures ([`Played`]); a scene without ports
//! needs none of it.

use crate::difference::{Start, derivatives};
use crate::parameter::put;
use crate::parts::Parts;
use crate::parts::numbers::Numbers;
use crate::played::{BLOCK, GoesOn, Played, diverged, frames_of, zeros};
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

/// A scene, with the derivatives of all that it begins with.
pub struct Forward {
    /// in double precision, for its ports
    pub(crate) plain: Scene,
    parameters: Vec<Parameter>,
    /// of each parameter, the derivatives of the numbers of the scene
    derivatives: Vec<Vec<f64>>,
    model: Model,
    catalog: Catalog,
    options: Options,
    /// plays it by its own passes, if it is linear for the most part
    tangent: Option<Tangent>,
}

/// What a scene sounds, and its derivatives. All arrays row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangents {
    /// \[Hz\]
    pub rate: f64,
    /// samples
    pub frames: usize,
    /// numbers of a sample: the sound channels, then the probes
    pub outputs: usize,
    /// how many of them are sound channels
    pub channels: usize,
    /// by which parameters
    pub parameters: Vec<Parameter>,
    /// what is heard; the bits of a render (frames x outputs)
    pub output: Vec<f64>,
    /// its derivatives, per unit of the parameter (frames x outputs x parameters)
    pub tangents: Vec<f64>,
}

impl Forward {
    /// A model, compiled with these options, and by which parameters is differentiated: names as `--set` takes them, such as
    /// `low.f`, `hammer.v` or the name of a `[param]`, and numbers of lists, such as `ball.v[1]`.
    ///
    /// # Errors
    /// [`Error::Model`] where the model has errors; [`Error::Refused`] where there is no such parameter, it is not numeric by
    /// which there are derivatives, or the scene has groups at the gesture rate.
    pub fn new(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Forward, Error> {
        Forward::made(loaded, options, wrt, Tangent::is_worth)
    }

    /// The same by the passes of the scene, of whatever size it is, with dual numbers for links that are not linear alone; `None`
    /// where something of it is not known that way. Scenes that are small take longer so, and [`Forward::new`] leaves them out.
    ///
    /// # Errors
    /// As [`Forward::new`].
    pub fn by_passes(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Option<Forward>, Error> {
        Ok(Some(Forward::made(loaded, options, wrt, |_, _| true)?).filter(|f| f.tangent.is_some()))
    }

    /// The same by dual numbers for all of a tick: the reference for the other ways.
    ///
    /// # Errors
    /// As [`Forward::new`].
    pub fn by_dual_numbers(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Forward, Error> {
        Forward::made(loaded, options, wrt, |_, _| false)
    }

    /// `by_passes` says of scenes that are known that way whether to go it.
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

    /// The same, of a scene that keeps the energy ledger.
    pub(crate) fn with_ledger(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Forward, Error> {
        let (mut forward, _) = Forward::begun(loaded, options, wrt)?;
        forward.options.energy = true;
        let scene = forward.compiled(&forward.model).map_err(Error::Refused)?;
        forward.differenced(scene)
    }

    /// With the derivatives of the numbers that its `scene` begins with.
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

    /// The same without derivatives of the numbers that it begins with, and the scene to be bound to dual numbers.
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
            let what = "no derivatives of this scene: groups at the gesture rate are not differentiated; leave out `rate = \"gesture\"` of the group";
            return Err(Error::refused(what));
        }
        Ok((forward, scene))
    }

    /// The scene in double precision, and by what is differentiated.
    pub(crate) fn into_parts(self) -> (Scene, Vec<Parameter>) {
        (self.plain, self.parameters)
    }

    /// The sound rate \[Hz\].
    pub fn rate(&self) -> f64 {
        self.plain.rate
    }

    /// The time of a tick \[s\].
    pub(crate) fn sample_dt(&self) -> f64 {
        self.plain.rates.sample_dt
    }

    /// How many numbers a sample has: the sound channels, then the probes.
    pub fn outputs(&self) -> usize {
        self.plain.counts.n_out
    }

    /// By what is differentiated.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// What is heard, and all its derivatives, in so many seconds, or in as many as a render of the model has.
    ///
    /// # Errors
    /// [`Error::Gesture`] where the gesture does not fit the model, [`Error::Refused`] where it drives a live parameter, or
    /// where the scene diverges.
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

    /// What is heard alone (frames x outputs): what a loss is computed of, whose cotangent [`Forward::gradient`] takes.
    ///
    /// # Errors
    /// As [`Forward::tangents`].
    pub fn output(&self, seconds: Option<f64>, gesture: Option<&Gesture>, goes_on: GoesOn) -> Result<Vec<f64>, Error> {
        crate::played::output(&self.plain, seconds, gesture, goes_on)
    }

    /// The gradient of a loss of what is heard (parameters), from its cotangent: the derivatives of the loss by each number that is
    /// heard (frames x outputs), as many frames as it has. Takes no memory for derivatives of samples.
    ///
    /// # Errors
    /// As [`Forward::tangents`], and where the cotangent has no whole rows.
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

    /// Plays it with the derivatives by `some` parameters; `heard` gets the state after each sample.
    pub(crate) fn play(
        &self,
        played: &Played,
        some: std::ops::Range<usize>,
        heard: &mut impl FnMut(usize, &State<Dual>),
        goes_on: GoesOn,
    ) -> Result<(), Error> {
        if let Some(tangent) = &self.tangent {
            let given = (&played.given[..], played.frames);
            return tangent.play(&self.plain, given, some, &mut |frame, row| {
                heard(frame, row);
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
            heard(frame, &player.state);
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

/// A scene over dual numbers.
pub(crate) fn over_dual(scene: &Scene) -> Result<Scene<Dual>, Error> {
    scene.bind(&laws()).map_err(|why| Error::Refused(why.to_string()))
}
