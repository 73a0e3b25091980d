//! Live changes: set by name and in units, computed outside the tick and ramped in it.
//!
//! A tick knows only coefficients, not parameters. [`Controls`] (one per player, outside the real-time thread) turns
//! `strike.k = 8000` into a [`Patch`] with the same functions that the compiler used. So derived parameters such as f
//! and t60 move all their coefficients together. [`State::apply`] starts the ramps without allocating. Only parameters
//! that the model declares `live` are included, or all if the compiler was asked to.

use crate::kind::builder::{Arg, Args, Generator};
use crate::kind::{Kind, MatSpec, Unit};
use crate::method::implicit::Inertia;
use crate::numeric::{Plain, Real};
use crate::op::Law;
use crate::state::{Identity, State};
use crate::tuning::Scheme;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// A parameter that may change while the scene plays.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveParam {
    /// name: a `[param]`, or `module.parameter` if everything is live
    pub name: String,
    /// unit; plain if the model gives none
    pub unit: Unit,
    /// smallest value, SI
    pub min: f64,
    /// largest value, SI
    pub max: f64,
    /// value at load, SI
    pub value: f64,
    /// documentation in one line
    pub doc: String,
}

/// A parameter driven by a port ([`crate::op::driven`]).
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenParam {
    /// the parameter; its value is the one before the port is read
    pub param: LiveParam,
    /// name of the port
    pub port: String,
    /// port values for its smallest and largest value \[m\] or \[N\]
    pub span: [f64; 2],
}

/// Source of a number of a module.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Source {
    /// not written
    Absent,
    /// fixed value
    Const(f64),
    /// slot of its item
    Slot(u32),
}

/// Rule to compute the coefficients of a module.
#[derive(Clone, Copy)]
pub enum Loader {
    /// a MAT, with the viscosity of its medium \[N s/m\]
    Mat(&'static MatSpec, f64),
    /// a LIA
    Lia(&'static Law),
    /// its first parameter times this factor: the gain of an output, or the weight of a mass (acceleration \[m/s²\])
    Times(f64),
}

/// A module with coefficients that depend on live parameters.
#[derive(Clone)]
pub struct LiveModule {
    /// rule for the coefficients
    pub loader: Loader,
    /// sources of the values, in the order of the parameters of its kind
    pub values: alloc::sync::Arc<[Source]>,
    /// destinations: indices into [`LiveTable::coefs`], one per coefficient
    pub to: Vec<u32>,
}

/// An item of the model that depends on live parameters.
#[derive(Clone)]
pub struct LiveItem {
    /// kind of the item
    pub kind: &'static Kind,
    /// axes along which its MATs move
    pub dim: u8,
    /// scheme for its linear parts
    pub scheme: Scheme,
    /// resolved parameters
    pub args: Vec<Arg>,
    /// arguments that follow live parameters: (argument, parameter, factor)
    pub follows: Vec<(usize, usize, f64)>,
    /// generator that derives numbers from them, if it is one
    pub generator: Option<&'static Generator>,
    /// modules made from it
    pub modules: Vec<LiveModule>,
}

/// Live parameters as the compiler knows them.
#[derive(Clone, Default)]
pub struct LiveTable {
    /// scene of the parameters
    pub scene: Identity,
    /// the parameters
    pub params: Vec<LiveParam>,
    /// coefficients that they set: indices into [`State::coef`]
    pub coefs: Vec<u32>,
    /// parameters driven by ports, which cannot be set otherwise
    pub driven: Vec<DrivenParam>,
    /// coefficients that driven parameters set: indices into `coefs`, rising
    pub driven_coefs: Vec<u32>,
    /// items that connect parameters and coefficients
    pub items: Vec<LiveItem>,
    /// factor to recompute, if implicit links depend on live parameters
    pub implicit: Option<LiveImplicit>,
}

/// The part of the factor of implicit links that follows live parameters.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct LiveImplicit {
    /// structure of the matrix
    pub made: Inertia,
    /// first of its coefficients in [`LiveTable::coefs`]
    pub first: u32,
    /// index and present value of each coefficient it depends on, rising
    pub known: Vec<(u32, f64)>,
}

impl LiveImplicit {
    /// Adds the factor to a patch that changes its inputs. Returns false if the factor does not exist.
    fn follow(&mut self, coefs: &[u32], scratch: &mut Scratch, patch: &mut Patch) -> bool {
        let mut changed = false;
        for (i, v) in &patch.set {
            let place = coefs.get(*i as usize).copied().unwrap_or(u32::MAX);
            if let Ok(k) = self.known.binary_search_by_key(&place, |k| k.0) {
                changed |= self.known[k].1.to_bits() != v.to_bits();
                self.known[k].1 = *v;
            }
        }
        if changed {
            let value = |c: u32| self.known.binary_search_by_key(&c, |k| k.0).map_or(f64::NAN, |k| self.known[k].1);
            if !self.made.factor(value, &mut scratch.coefs, &mut scratch.around) {
                return false;
            }
            patch.set.extend((self.first..).zip(scratch.coefs.iter().copied()));
        }
        true
    }
}

/// New values of coefficients, to be applied together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// scene of the patch: [`Scene::identity`](crate::Scene::identity) if made by hand
    pub scene: Identity,
    /// index into [`LiveTable::coefs`] and value
    pub set: Vec<(u32, f64)>,
}

/// Why a live change was refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refused {
    /// no live parameter has this name
    Unknown(String),
    /// outside the declared range
    Range(String, f64, f64),
    /// driven by a port: name of the parameter and of the port
    Driven(String, String),
    /// the values together cannot be solved, e.g. a pitch out of reach
    Unsolvable(String),
}

impl core::fmt::Display for Refused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Refused::Unknown(n) => write!(f, "`{n}` is not a live parameter: declare it in [param] with live = true"),
            Refused::Range(n, lo, hi) => write!(f, "`{n}` must lie between {} and {}", Plain(*lo), Plain(*hi)),
            Refused::Driven(n, port) => write!(f, "`{n}` is driven by the port `{port}`: move the port instead"),
            Refused::Unsolvable(why) => write!(f, "{why}"),
        }
    }
}
impl core::error::Error for Refused {}

/// The live parameters of a scene during a performance. It is used outside the tick.
#[derive(Clone)]
pub struct Controls {
    plan: LiveTable,
    tick_dt: f64,
    /// tests whether a coefficient is finite in the number type of the tick
    finite: fn(f64) -> bool,
    scratch: Scratch,
}

/// Working memory of a change. It is kept so that a gesture that moves a parameter in every frame does not allocate.
#[derive(Clone, Default)]
struct Scratch {
    slots: Vec<Option<f64>>,
    values: Vec<Option<f64>>,
    /// coefficients of a module, or of the factor of implicit links
    coefs: Vec<f64>,
    around: Vec<f64>,
    /// arguments before the change: item, argument and value
    before: Vec<(usize, usize, Arg)>,
    /// coefficients that implicit links depend on, before the change
    known: Vec<f64>,
}

impl Controls {
    /// Makes the parameters with their values at load; `tick_dt` is the duration of a tick \[s\].
    pub fn new(plan: &LiveTable, tick_dt: f64) -> Controls {
        Controls { plan: plan.clone(), tick_dt, finite: f64::is_finite, scratch: Scratch::default() }
    }

    /// Adapts them to a scene over `R`: a value whose coefficients are not finite in `R` is refused.
    #[must_use]
    pub(crate) fn over<R: Real>(self) -> Controls {
        Controls { finite: |v| R::of(v).is_finite(), ..self }
    }

    /// Returns the parameters with their present values.
    pub fn params(&self) -> &[LiveParam] {
        &self.plan.params
    }

    /// Sets `name` to `value` \[SI\] and returns the coefficients that change.
    ///
    /// # Errors
    /// [`Refused`]; nothing has then changed.
    pub fn set(&mut self, name: &str, value: f64) -> Result<Patch, Refused> {
        let Some(p) = self.plan.params.iter().position(|p| p.name == name) else {
            let driven = self.plan.driven.iter().find(|d| d.param.name == name);
            let by_port = driven.map(|d| Refused::Driven(name.into(), d.port.clone()));
            return Err(by_port.unwrap_or_else(|| Refused::Unknown(name.into())));
        };
        let mut patch = Patch::default();
        self.set_indexed(p, value, &mut patch)?;
        Ok(patch)
    }

    /// Sets parameter number `p` of [`Controls::params`] to `value` \[SI\] and replaces the content of `patch` by the
    /// coefficients that change. From the second change on it does not allocate.
    ///
    /// # Errors
    /// [`Refused`]; nothing has then changed, and `patch` is useless.
    pub fn set_indexed(&mut self, p: usize, value: f64, patch: &mut Patch) -> Result<(), Refused> {
        patch.set.clear();
        patch.scene = self.plan.scene;
        let Some(param) = self.plan.params.get(p) else { return Err(Refused::Unknown(format!("parameter {p}"))) };
        if !(value >= param.min && value <= param.max) {
            return Err(Refused::Range(param.name.clone(), param.min, param.max));
        }
        let Scratch { known, before, .. } = &mut self.scratch;
        before.clear();
        known.clear();
        known.extend(self.plan.implicit.iter().flat_map(|a| &a.known).map(|k| k.1));
        let turned = self.compute_patch(p, value, patch);
        if turned.is_err() {
            for (item, arg, value) in self.scratch.before.drain(..) {
                self.plan.items[item].args[arg] = value;
            }
            let now = self.plan.implicit.iter_mut().flat_map(|a| &mut a.known);
            now.zip(&self.scratch.known).for_each(|(k, v)| k.1 = *v);
        } else {
            self.plan.params[p].value = value;
        }
        turned
    }

    fn compute_patch(&mut self, p: usize, value: f64, patch: &mut Patch) -> Result<(), Refused> {
        let (tick_dt, scratch) = (self.tick_dt, &mut self.scratch);
        for (n, item) in self.plan.items.iter_mut().enumerate() {
            let touched = scratch.before.len();
            for (arg, q, factor) in &item.follows {
                if *q == p {
                    let old = core::mem::replace(&mut item.args[*arg], Arg::Num(value * factor));
                    scratch.before.push((n, *arg, old));
                }
            }
            if scratch.before.len() > touched {
                item.patch(tick_dt, scratch, patch)?;
            }
        }
        if !self.plan.driven.is_empty() {
            patch.set.retain(|(place, _)| self.plan.driven_coefs.binary_search(place).is_err());
        }
        let follows = self.plan.implicit.as_mut().is_none_or(|a| a.follow(&self.plan.coefs, scratch, patch));
        if !follows || patch.set.iter().any(|(_, v)| !(self.finite)(*v)) {
            let name = &self.plan.params[p].name;
            return Err(Refused::Unsolvable(format!(
                "`{name}` = {} cannot be computed: choose a less extreme value",
                Plain(value)
            )));
        }
        Ok(())
    }
}

impl LiveItem {
    fn patch(&self, tick_dt: f64, scratch: &mut Scratch, patch: &mut Patch) -> Result<(), Refused> {
        // numbers of the item: derived by its generator, or the parameters themselves
        scratch.slots.clear();
        match self.generator {
            Some(g) => {
                let args = Args {
                    code: self.kind.code,
                    params: self.kind.params,
                    values: &self.args,
                    tick_dt,
                    dim: self.dim,
                    scheme: self.scheme,
                };
                (g.derive)(&args, &mut scratch.slots).map_err(|p| Refused::Unsolvable(p.title))?;
            }
            None => scratch.slots.extend(self.args.iter().map(Arg::num)),
        }
        for m in &self.modules {
            scratch.values.clear();
            scratch.values.extend(m.values.iter().map(|s| s.get(&scratch.slots)));
            m.loader.load(&scratch.values, tick_dt, &mut scratch.coefs);
            patch.set.extend(m.to.iter().copied().zip(scratch.coefs.iter().copied()));
        }
        Ok(())
    }
}

impl Source {
    /// Returns the number, given the slots of the item.
    pub fn get(self, slots: &[Option<f64>]) -> Option<f64> {
        match self {
            Source::Absent => None,
            Source::Const(v) => Some(v),
            Source::Slot(i) => slots.get(i as usize).copied().flatten(),
        }
    }
}

impl Loader {
    /// Replaces the content of `out` by the coefficients for parameter values in SI.
    pub fn load(self, values: &[Option<f64>], tick_dt: f64, out: &mut Vec<f64>) {
        out.clear();
        match self {
            Loader::Mat(spec, medium) => {
                let c = (spec.coefs)(values, tick_dt);
                // C = T²/m, so the damper z of the medium takes zT/m = zC/T
                out.extend([c.p - medium / tick_dt * c.c, c.q, c.c]);
            }
            Loader::Lia(law) => {
                out.resize(law.coefs, 0.0);
                (law.at_load.load)(values, tick_dt, out);
            }
            Loader::Times(by) => out.push(by * values.first().copied().flatten().unwrap_or(0.0)),
        }
    }
}

impl<R: Real> State<R> {
    /// Starts ramping the coefficients of `patch` to their new values, linearly over `ticks` (0 acts like 1), from the
    /// next tick on. All coefficients of a patch arrive in the same tick. Does not allocate.
    ///
    /// Returns false, and changes nothing, if the patch belongs to another scene or holds a value that is not finite.
    pub fn apply(&mut self, patch: &Patch, ticks: u32) -> bool {
        let n = self.ramps.left.len();
        if patch.scene != self.scene || patch.set.iter().any(|(i, v)| *i as usize >= n || !R::of(*v).is_finite()) {
            return false;
        }
        // halfway between two factors is not a factor of either matrix, so the whole patch then changes in one tick
        let whole = patch.set.iter().any(|(i, _)| *i >= self.ramps.instant);
        let ticks = if whole { 1 } else { ticks.max(1) };
        for (i, v) in &patch.set {
            self.ramp(*i as usize, R::Outer::of(*v), ticks);
        }
        true
    }

    /// Ramps live coefficient number `i` to `v` over `ticks` ticks, unless it is there or on its way.
    pub(crate) fn ramp_to(&mut self, i: usize, v: R, ticks: u32) {
        let r = &self.ramps;
        let goal = if r.left[i] == 0 { self.coef[r.index[i] as usize] } else { r.target[i] };
        if goal.wide().to_bits() != v.wide().to_bits() {
            self.ramp(i, v.outer(), ticks);
        }
    }

    fn ramp(&mut self, i: usize, v: R::Outer, ticks: u32) {
        let r = &mut self.ramps;
        if r.left[i] == 0 {
            r.active[r.moving] = i as u32;
            r.moving += 1;
        }
        r.left[i] = ticks;
        r.target[i] = R::inner(v);
        r.step[i] = R::inner((v - self.coef[r.index[i] as usize].outer()) / R::Outer::of(f64::from(ticks)));
    }
}
