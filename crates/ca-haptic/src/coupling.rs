//! Virtual coupling: a spring and a damper that soften a key which its device cannot render.
//!
//! When a scene meets its devices, [`needed`] compares the largest stiffness of each key with the stiffness that its
//! device can render. A key within that limit stays as it is and costs nothing. A stiffer key gets a spring and a
//! damper in front of it (Colgate, Stanley and Brown 1995; Adams and Hannaford 1999), and the scene is compiled once
//! more ([`ca_core::internal::scene::Coupling`]). Behind the coupling the model keeps its stiffness and its sound.
//!
//! A device with friction b stays passive up to K ≤ b/(κT). κ includes one more frame, because real devices use a force
//! one frame after it was computed (docs/numerics.md §5.2). A key is softened if it exceeds nine tenths of that limit,
//! or the stiffness of the profile if that is less. It is softened to half of the limit, because the friction in most
//! profiles is inexact and a coupling must be safe. That value is the series stiffness of the coupling's spring and the
//! links at their stiffest.
//!
//! The damper dissipates energy of the model behind it, which can store the energy that the delay makes. With 3b/4 on a
//! spring of b/(2κT), a device is passive in front of any model if its friction is at least 0.79 b. The mass between
//! coupling and links is 16 times the lightest for which the scheme is stable. If it exceeds a tenth of the device's
//! mass, the hand would feel it: no coupling fits, and the device gives no force.
//!
//! A device slower than the engine gets the mean force of a coupled key over each device frame, one device frame later
//! ([`crate::engine::Port`]). The stiffness of a softened key allows for that frame too.
//!
//! Sticking friction joins a key rigidly to a body, and a damper near the friction of the device makes as much energy
//! as a stiff spring. Both count as a spring far stiffer than the limit.

use crate::engine::{Setup, coupled, is_slower};
use crate::profile::Profile;
use ca_compile::{Compiled, Options};
use ca_core::internal::border::{Delays, delays};
use ca_core::internal::scene::Coupling;
use ca_core::internal::scene::certificate::Key;
use ca_core::{Level, Scene, compute_forces};
use ca_model::quantity::{show, six};
use core::fmt;
use std::collections::BTreeMap;

/// Maximum number of steps in which a key is moved over its travel, and the largest number of steps × modules of the scene.
const STEPS: usize = 2000;
const MOST: usize = 20_000_000;
/// Part of the passivity limit up to which a key stays as it is.
const KEPT: f64 = 0.9;
/// Part of the passivity limit to which a key is softened, because the friction of the profile may be wrong.
const SURE: f64 = 0.5;
/// Viscosity of the coupling in front of infinitely stiff links, as a part of the device's friction.
const DAMPER: f64 = 0.75;
/// Largest stiffness of a coupling, as a multiple of the stiffness to which a key is softened.
const STIFFEST: f64 = 10.0;
/// Mass between coupling and links, as a multiple of their T²k + 2Tz: 16 times the lightest that is stable.
const HEAVIER: f64 = 4.0;
/// Largest mass between coupling and links, as a part of the device's mass.
const LIGHT: f64 = 0.1;
/// Stiffness that stands for sticking friction and strong dampers, as a multiple of [`StiffnessLimits::unchanged`].
const RIGID: f64 = 1000.0;
/// Slopes count only below this multiple of the device's largest force: above it, the device cannot stop the hand.
const REACHED: f64 = 2.0;

/// Stiffness limits of a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessLimits {
    /// Stiffest sum of springs on which it is passive, if it uses each force one frame later \[N/m\].
    pub passive: f64,
    /// The same, if it uses each force at once \[N/m\].
    pub at_once: f64,
    /// Stiffness up to which a key stays as it is: 0.9 of `passive`, or the profile's if less \[N/m\].
    pub unchanged: f64,
    /// Stiffness to which a stiffer key is softened: half of `passive`, or the profile's if less \[N/m\]. A
    /// device slower than the scene counts one more frame of delay.
    pub softened_to: f64,
}

impl StiffnessLimits {
    /// Computes the limits of a device with this profile in this scene.
    pub fn new(scene: &Scene, profile: &Profile) -> StiffnessLimits {
        let rate = scene.rate / f64::from(scene.rates.ratio);
        // a slower device holds each force longer
        let longer = (rate / profile.rate).max(1.0);
        let own = delays(scene);
        let d = Delays { spring: own.spring * longer, frame: own.frame * longer, ..own };
        let b = profile.body.friction;
        let later = |frames: f64| Delays { spring: d.spring + frames * d.frame, ..d }.stiffest(b);
        let passive = later(1.0);
        let softened = if is_slower(profile, 1.0 / rate) { later(2.0) } else { passive };
        let most = |k: f64| profile.stiffness.map_or(k, |own| own.min(k));
        let (kept, given) = (most(KEPT * passive), most(SURE * softened));
        StiffnessLimits { passive, at_once: d.stiffest(b), unchanged: kept, softened_to: given }
    }
}

/// A key as the hand meets it over the travel of its device, in the units of the hand.
#[derive(Clone, Debug)]
pub struct Presented {
    /// Sum over the links, with all contacts closed and live parameters at their stiffest \[N/m\].
    pub certified: f64,
    /// Steepest slope in the part of the travel that the hand can reach against the device \[N/m\].
    pub steepest: f64,
    /// Sum of the viscosities \[N s/m\].
    pub viscosity: f64,
    /// True if sticking friction holds it.
    pub sticks: bool,
    /// Position \[m\] and force \[N\] over the travel.
    pub travel: Vec<[f64; 2]>,
}

impl Presented {
    /// Moves device port number `t` of the scene over the range of its device, with everything behind it at rest.
    pub fn new(scene: &Scene, t: usize, profile: &Profile) -> Presented {
        let range = profile.range;
        let port = scene.ports.tgr[t];
        let input = &scene.inputs[port.input as usize];
        let (gains, at) = (input.gains, port.mat as usize);
        let key = key(scene, at);
        let mut state = scene.state();
        state.d.fill(0.0);
        let force_at = |x: f64| {
            let mut s = state.clone();
            s.input[port.input as usize] = gains.alpha * x;
            compute_forces(scene, &mut s);
            gains.beta * s.f[at]
        };
        let steps = (MOST / (scene.counts.n_mat + scene.counts.n_lia).max(1)).clamp(20, STEPS);
        let span = range[1] - range[0];
        let places = (0..=steps).map(|i| range[0] + span * i as f64 / steps as f64);
        let travel: Vec<[f64; 2]> = places.map(|x| [x, force_at(x)]).collect();
        let slope = |w: &[[f64; 2]]| (w[1][1] - w[0][1]).abs() / (span / steps as f64);
        let most = if profile.force > 0.0 { REACHED * profile.force } else { f64::INFINITY };
        let reached = travel.windows(2).filter(|w| w[0][1].abs().min(w[1][1].abs()) < most);
        let of_key = |of: fn(&Key) -> f64| key.map_or(0.0, |k| of(k) * gains.stiffness());
        Presented {
            certified: of_key(|k| k.k),
            steepest: reached.map(slope).fold(0.0, f64::max),
            viscosity: of_key(|k| k.z),
            sticks: key.is_some_and(|k| k.sticks),
            travel,
        }
    }

    /// Returns true for a key that a device of this friction \[N s/m\] cannot render, however soft its springs are.
    pub fn is_rigid(&self, friction: f64) -> bool {
        self.sticks || self.viscosity > KEPT * friction
    }

    /// Returns the larger of the two stiffnesses \[N/m\].
    pub fn k(&self) -> f64 {
        self.certified.max(self.steepest)
    }
}

/// Returns the key of the certificate at MAT number `at`.
pub fn key(scene: &Scene, at: usize) -> Option<&Key> {
    scene.certificate.keys.iter().find(|k| k.name == scene.mat_name(at))
}

/// A key that is softened.
#[derive(Clone, Debug, PartialEq)]
pub struct Softened {
    /// Name of the device.
    pub device: String,
    /// Largest stiffness of the key in the hand \[N/m\].
    pub presents: f64,
    /// True if sticking friction or a damper holds it more firmly than that.
    pub rigid: bool,
    /// Stiffness felt in the hand \[N/m\].
    pub stiffness: f64,
    /// The coupling that softens it.
    pub coupling: Coupling,
}

impl fmt::Display for Softened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Softened { device, presents, rigid, stiffness: felt, coupling } = self;
        let [presents, felt] = [presents, felt].map(|k| show(six(*k), ca_core::Unit::STIFFNESS));
        let is = if *rigid {
            "is held by sticking friction or a strong damper".into()
        } else {
            format!("has a stiffness of up to {presents}")
        };
        write!(
            f,
            "`{}` {is}, which `{device}` cannot render: a virtual coupling softens it to {felt} in the hand; the model \
             does not change (see `ca check --device`)",
            coupling.port
        )
    }
}

/// Keys that their devices cannot render.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Needed {
    /// Keys that a coupling softens.
    pub softened: Vec<Softened>,
    /// Keys for which no coupling fits.
    pub too_stiff: Vec<TooStiff>,
}

/// A key for which no coupling fits.
#[derive(Clone, Debug, PartialEq)]
pub struct TooStiff {
    /// Name of the device.
    pub device: String,
    /// Name of the TGR.
    pub port: String,
}

/// Returns the couplings that an uncoupled scene needs for these devices.
pub fn needed(scene: &Scene, setups: &[Setup]) -> Needed {
    let mut all = Needed::default();
    if scene.ports.crossing.feedback {
        for setup in setups {
            of_device(scene, setup, &mut all);
        }
    }
    all
}

fn of_device(scene: &Scene, setup: &Setup, needed: &mut Needed) {
    let p = &setup.profile;
    let StiffnessLimits { unchanged: kept, softened_to: given, .. } = StiffnessLimits::new(scene, p);
    // an unknown device may be without force until it describes itself, but its couplings are chosen before that
    let gives = p.force > 0.0 || p.is_unknown();
    if !(p.guard.coupling && gives && given > 0.0 && given.is_finite()) {
        return;
    }
    let b = p.body.friction;
    // ports by the MAT they move: its axes share a coupling
    let mut mats: BTreeMap<String, Moved> = BTreeMap::new();
    let mut sums: BTreeMap<u32, f64> = BTreeMap::new();
    for (t, port) in scene.ports.tgr.iter().enumerate() {
        let input = &scene.inputs[port.input as usize];
        let Some((_, dof)) = input.device.as_ref().filter(|d| d.0 == setup.device && d.1 < p.dof) else { continue };
        let presented = Presented::new(scene, t, p);
        let moved = mats.entry(scene.mat_name(port.mat as usize).into_owned()).or_default();
        moved.k = moved.k.max(presented.k());
        moved.z = moved.z.max(presented.viscosity);
        moved.rigid |= presented.is_rigid(b);
        moved.gain = moved.gain.max(input.gains.stiffness());
        moved.dofs.push(*dof);
    }
    for moved in mats.values() {
        for d in &moved.dofs {
            *sums.entry(*d).or_default() += moved.counts(kept);
        }
    }
    let tick_dt = scene.rates.sample_dt / f64::from(scene.oversample());
    for (port, moved) in mats {
        let k = moved.counts(kept);
        // ports of one degree of freedom share the stiffness limit
        let all = moved.dofs.iter().filter_map(|d| sums.get(d)).fold(0.0, |a: f64, b| a.max(*b));
        if all.is_nan() || all <= kept * (1.0 + 1e-9) {
            continue;
        }
        let (share, near) = (k / all, (1.0 - given / all).max(1.0 / STIFFEST));
        let (spring, damper) = (share * given / near, share * DAMPER * b / near);
        let felt = 1.0 / (1.0 / spring + 1.0 / k);
        let m = HEAVIER * (tick_dt * tick_dt * (moved.k + spring) + 2.0 * tick_dt * (damper + moved.z));
        let model = |v: f64| v / moved.gain;
        let device = setup.device.clone();
        let coupling =
            Coupling { port, k: model(spring), z: model(damper), m: model(m), device_stiffness: model(felt) };
        let fits =
            m <= LIGHT * p.body.mass && [coupling.k, coupling.z, coupling.m].iter().all(|v| v.is_finite() && *v > 0.0);
        if fits {
            needed.softened.push(Softened { device, presents: moved.k, rigid: moved.rigid, stiffness: felt, coupling });
        } else {
            needed.too_stiff.push(TooStiff { device, port: coupling.port });
        }
    }
}

/// A MAT moved by ports of one device, in the units of the hand.
#[derive(Default)]
struct Moved {
    /// Largest stiffness among its axes \[N/m\].
    k: f64,
    /// Viscosity \[N s/m\].
    z: f64,
    rigid: bool,
    /// Stiffness in the hand per stiffness in the model.
    gain: f64,
    dofs: Vec<u32>,
}

impl Moved {
    /// Returns the stiffness to compare with `kept` \[N/m\]; a rigid key counts as at least [`RIGID`] times that.
    fn counts(&self, kept: f64) -> f64 {
        if self.rigid { self.k.max(RIGID * kept) } else { self.k }
    }
}

/// Returns the first key that is too stiff for this device as coupled, with its felt stiffness \[N/m\].
pub fn beyond(scene: &Scene, setup: &Setup) -> Option<(String, f64)> {
    if !scene.ports.crossing.feedback || !setup.profile.guard.coupling {
        return None;
    }
    let profile = &setup.profile;
    let most = StiffnessLimits::new(scene, profile).unchanged * (1.0 + 1e-9);
    let known = coupled(scene, &setup.device);
    let soft = |name: &str| known.iter().find(|c| c.0 == name).map(|c| c.1);
    let mine = |t: &usize| {
        let input = &scene.inputs[scene.ports.tgr[*t].input as usize];
        input.device.as_ref().is_some_and(|d| d.0 == setup.device)
    };
    (0..scene.ports.tgr.len()).filter(mine).find_map(|t| {
        let name = scene.mat_name(scene.ports.tgr[t].mat as usize).into_owned();
        let presented = Presented::new(scene, t, profile);
        let rigid = presented.is_rigid(profile.body.friction);
        let k = soft(&name).unwrap_or_else(|| if rigid { f64::INFINITY } else { presented.k() });
        (k > most).then_some((name, k))
    })
}

/// A compiled scene, with the couplings that its devices need.
pub struct CoupledScene {
    /// The scene, with the findings of the model as it was written.
    pub compiled: Compiled,
    /// Keys that are softened.
    pub softened: Vec<Softened>,
    /// Keys for which no coupling fits.
    pub too_stiff: Vec<TooStiff>,
}

impl CoupledScene {
    /// Returns a line for each of these keys.
    pub fn messages(&self) -> Vec<String> {
        let hard = |t: &TooStiff| {
            format!(
                "`{}` is stiffer than `{}` can render, and no coupling fits the model: the device gives no force; make \
                 the key softer (see `ca check --device`)",
                t.port, t.device
            )
        };
        self.softened.iter().map(ToString::to_string).chain(self.too_stiff.iter().map(hard)).collect()
    }
}

impl CoupledScene {
    /// Returns these setups; a device gives no force if no coupling fits one of its keys.
    pub fn setups(&self, setups: &[Setup]) -> Vec<Setup> {
        let mut setups = setups.to_vec();
        for s in &mut setups {
            if self.too_stiff.iter().any(|t| t.device == s.device) {
                s.profile.force = 0.0;
            }
        }
        setups
    }
}

/// Couples an uncoupled scene to its devices if a key needs it.
///
/// `again` compiles the scene with these couplings. Afterwards `options` holds the couplings in use.
pub fn couple<E>(
    compiled: Compiled,
    setups: &[Setup],
    options: &mut Options,
    again: impl FnOnce(&Options) -> Result<Compiled, E>,
) -> CoupledScene {
    let Needed { softened, mut too_stiff } = needed(&compiled.scene, setups);
    if softened.is_empty() {
        return CoupledScene { compiled, softened, too_stiff };
    }
    options.couplings = softened.iter().map(|s| s.coupling.clone()).collect();
    let stable = |c: &Compiled| {
        c.scene.certificate.level != Level::Unstable || compiled.scene.certificate.level == Level::Unstable
    };
    if let Some(coupled) = again(options).ok().filter(stable) {
        let compiled = Compiled { findings: compiled.findings, ..coupled };
        return CoupledScene { compiled, softened, too_stiff };
    }
    options.couplings.clear();
    too_stiff.extend(softened.into_iter().map(|s| TooStiff { device: s.device, port: s.coupling.port }));
    CoupledScene { compiled, softened: Vec::new(), too_stiff }
}
