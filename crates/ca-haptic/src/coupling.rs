//! Virtual coupling: a spring and a damper that soften a key which its device cannot render.
//!
//! [`needed`] compares the stiffness that each key presents to the hand at most with what the device holds, when a scene meets
//! its devices. A key that the device can hold stays as it is and costs nothing. Before a stiffer one stand a spring and a damper
//! (Colgate, Stanley and Brown 1995; Adams and Hannaford 1999), and the scene is compiled once more
//! ([`ca_core::scene::Coupling`]). Behind them the model keeps its stiffness and its sound.
//!
//! With its own friction b a device stays passive up to K ≤ b/(κT), with each force a frame later than it is computed, because
//! real devices take it then (docs/numerics.md §5.2). A key is softened above nine tenths of that, or above the stiffness of the
//! profile if that is less. It is softened to half of what is passive: most profiles do not know the friction exactly, and a
//! coupling that is made has to be right. The spring of the coupling and the links at their stiffest together make that
//! stiffness. The damper takes energy out of the model behind it, which can store what the delay makes. With 3b/4 on a spring of
//! b/(2κT), a device of 0.79 b is passive before any model. The mass between coupling and links is the lightest that the
//! scheme allows. If that is more than a tenth of the device, the hand would feel the mass, and no coupling fits.

use crate::engine::{Setup, coupled};
use crate::profile::Profile;
use ca_compile::{Compiled, Options};
use ca_core::border::{Delays, delays};
use ca_core::scene::Coupling;
use ca_core::scene::certificate::{Key, Level};
use ca_core::{Scene, compute_forces};
use ca_model::quantity::{show, six};
use core::fmt;
use std::collections::BTreeMap;

/// Steps in which a key is moved over its travel, and most of them times the modules of the scene.
const STEPS: usize = 2000;
const MOST: usize = 20_000_000;
/// Part of what is passive up to which a key stays as it is.
const KEPT: f64 = 0.9;
/// Part of what is passive that a softened key is given: the friction of the profile may be wrong.
const SURE: f64 = 0.5;
/// Viscosity of the coupling, as a part of the friction of the device, before links of any stiffness.
const DAMPER: f64 = 0.75;
/// Largest stiffness of a coupling, in stiffnesses that a softened key is given.
const STIFFEST: f64 = 10.0;
/// T²k + 2Tz of coupling and links, times this, is the mass between them: a 16th of the limit of the scheme.
const HEAVIER: f64 = 4.0;
/// Largest mass between coupling and links, in masses of the device.
const LIGHT: f64 = 0.1;

/// Stiffnesses that a device can render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// the stiffest sum of springs on which it is passive, each force a frame later \[N/m\]
    pub passive: f64,
    /// ... were forces taken at once
    pub at_once: f64,
    /// a key up to here stays as it is: 0.9 of `passive`, or the stiffness of the profile if that is less \[N/m\]
    pub kept: f64,
    /// a stiffer one is softened to this: half of `passive`, or the stiffness of the profile if that is less \[N/m\]
    pub given: f64,
}

impl Held {
    /// By a device of this profile, of this scene.
    pub fn new(scene: &Scene, profile: &Profile) -> Held {
        let rate = scene.rate / f64::from(scene.ratio);
        // a slower device holds each force for longer
        let longer = (rate / profile.rate).max(1.0);
        let own = delays(scene);
        let d = Delays { spring: own.spring * longer, frame: own.frame * longer, ..own };
        let b = profile.body.friction;
        let later = Delays { spring: d.spring + d.frame, ..d };
        let passive = later.stiffest(b);
        let [kept, given] =
            [KEPT, SURE].map(|part| profile.stiffness.map_or(part * passive, |k| k.min(part * passive)));
        Held { passive, at_once: d.stiffest(b), kept, given }
    }
}

/// A key over the travel of its device, in the units of the hand.
#[derive(Clone, Debug)]
pub struct Presented {
    /// sum of the links, all contacts closed, live parameters at their stiffest \[N/m\]
    pub certified: f64,
    /// steepest place of the travel \[N/m\]
    pub steepest: f64,
    /// position \[m\] and force \[N\] over the travel
    pub travel: Vec<[f64; 2]>,
}

impl Presented {
    /// Device port number `t` of the scene, moved over `range`, with everything behind it at rest.
    pub fn new(scene: &Scene, t: usize, range: [f64; 2]) -> Presented {
        let port = scene.tgr[t];
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
        let steps = (MOST / (scene.n_mat + scene.n_lia).max(1)).clamp(20, STEPS);
        let span = range[1] - range[0];
        let places = (0..=steps).map(|i| range[0] + span * i as f64 / steps as f64);
        let travel: Vec<[f64; 2]> = places.map(|x| [x, force_at(x)]).collect();
        let slope = |w: &[[f64; 2]]| (w[1][1] - w[0][1]).abs() / (span / steps as f64);
        Presented {
            certified: key.map_or(0.0, |k| k.k * gains.stiffness()),
            steepest: travel.windows(2).map(slope).fold(0.0, f64::max),
            travel,
        }
    }

    /// The stiffest it is \[N/m\].
    pub fn k(&self) -> f64 {
        self.certified.max(self.steepest)
    }
}

/// The key of the certificate at MAT number `at`.
pub fn key(scene: &Scene, at: usize) -> Option<&Key> {
    scene.certificate.keys.iter().find(|k| k.name == scene.mat_name(at))
}

/// A key that is softened.
#[derive(Clone, Debug, PartialEq)]
pub struct Softened {
    /// name of the device
    pub device: String,
    /// what the key presents at most \[N/m\], in the hand
    pub presents: f64,
    /// the stiffness that is felt \[N/m\], in the hand
    pub felt: f64,
    /// how
    pub coupling: Coupling,
}

impl fmt::Display for Softened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Softened { device, presents, felt, coupling } = self;
        let [presents, felt] = [presents, felt].map(|k| show(six(*k), ca_core::kind::Unit::STIFFNESS));
        write!(
            f,
            "`{}` is up to {presents} stiff, more than `{device}` holds: a virtual coupling softens it to {felt} in the hand; \
             the model keeps its stiffness (`ca check --device`)",
            coupling.port
        )
    }
}

/// Keys that their devices cannot render.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Needed {
    /// those that a coupling softens
    pub softened: Vec<Softened>,
    /// names of those for which no coupling fits
    pub too_stiff: Vec<String>,
}

/// The couplings that an uncoupled scene needs before these devices.
pub fn needed(scene: &Scene, setups: &[Setup]) -> Needed {
    let mut all = Needed::default();
    if scene.crossing.feedback {
        for setup in setups {
            of_device(scene, setup, &mut all);
        }
    }
    all
}

fn of_device(scene: &Scene, setup: &Setup, needed: &mut Needed) {
    let p = &setup.profile;
    let Held { kept, given, .. } = Held::new(scene, p);
    // a device that describes itself later has a largest profile
    let gives = p.force > 0.0 || p.is_unknown();
    if !(p.guard.coupling && gives && given > 0.0 && given.is_finite()) {
        return;
    }
    // ports by the MAT they move, whose axes share a coupling: stiffness in the hand, and degrees of freedom
    let mut mats: BTreeMap<String, (f64, f64, Vec<u32>)> = BTreeMap::new();
    let mut sums: BTreeMap<u32, f64> = BTreeMap::new();
    for (t, port) in scene.tgr.iter().enumerate() {
        let input = &scene.inputs[port.input as usize];
        let Some((_, dof)) = input.device.as_ref().filter(|d| d.0 == setup.device && d.1 < p.dof) else { continue };
        let k = Presented::new(scene, t, p.range).k();
        let mat = mats.entry(scene.mat_name(port.mat as usize).into_owned()).or_default();
        let gain = input.gains.stiffness();
        *mat = (mat.0.max(k), mat.1.max(gain), core::mem::take(&mut mat.2));
        mat.2.push(*dof);
    }
    for (k, _, dofs) in mats.values() {
        for d in dofs {
            *sums.entry(*d).or_default() += k;
        }
    }
    let tick_dt = scene.sample_dt / f64::from(scene.oversample());
    for (port, (k, gain, dofs)) in mats {
        // ports of one degree of freedom share what it holds
        let all = dofs.iter().filter_map(|d| sums.get(d)).fold(0.0, |a: f64, b| a.max(*b));
        if all.is_nan() || all <= kept * (1.0 + 1e-9) {
            continue;
        }
        let (share, near) = (k / all, (1.0 - given / all).max(1.0 / STIFFEST));
        let (spring, damper) = (share * given / near, share * DAMPER * p.body.friction / near);
        let felt = 1.0 / (1.0 / spring + 1.0 / k);
        let m = HEAVIER * (tick_dt * tick_dt * (k + spring) + 2.0 * tick_dt * damper);
        let model = |v: f64| v / gain;
        let coupling = Coupling { port, k: model(spring), z: model(damper), m: model(m), felt: model(felt) };
        let fits =
            m <= LIGHT * p.body.mass && [coupling.k, coupling.z, coupling.m].iter().all(|v| v.is_finite() && *v > 0.0);
        if fits {
            needed.softened.push(Softened { device: setup.device.clone(), presents: k, felt, coupling });
        } else {
            needed.too_stiff.push(coupling.port);
        }
    }
}

/// The first key that is stiffer than this device holds, and the stiffness that is felt \[N/m\], with the couplings of the scene.
pub fn beyond(scene: &Scene, setup: &Setup) -> Option<(String, f64)> {
    if !scene.crossing.feedback || !setup.profile.guard.coupling {
        return None;
    }
    let most = Held::new(scene, &setup.profile).kept * (1.0 + 1e-9);
    let known = coupled(scene, &setup.device);
    let soft = |name: &str| known.iter().find(|c| c.0 == name).map(|c| c.1);
    let mine = |t: &usize| {
        let input = &scene.inputs[scene.tgr[*t].input as usize];
        input.device.as_ref().is_some_and(|d| d.0 == setup.device)
    };
    (0..scene.tgr.len()).filter(mine).find_map(|t| {
        let name = scene.mat_name(scene.tgr[t].mat as usize).into_owned();
        let k = soft(&name).unwrap_or_else(|| Presented::new(scene, t, setup.profile.range).k());
        (k > most).then_some((name, k))
    })
}

/// A compiled scene, with the couplings that its devices need.
pub struct Met {
    /// the scene, with the findings of the model as it was written
    pub compiled: Compiled,
    /// keys that are softened
    pub softened: Vec<Softened>,
    /// names of keys for which no coupling fits
    pub too_stiff: Vec<String>,
}

impl Met {
    /// A line for each of these keys.
    pub fn said(&self) -> Vec<String> {
        let hard = |port: &String| {
            format!(
                "`{port}` is stiffer than its device holds, and no coupling fits the model: it can shake in the hand \
                 (`ca check --device`); make it softer"
            )
        };
        self.softened.iter().map(ToString::to_string).chain(self.too_stiff.iter().map(hard)).collect()
    }
}

/// Couples an uncoupled scene to its devices if a key needs it. `options` have the couplings after that, and `again` compiles
/// with them.
pub fn meet<E>(
    compiled: Compiled,
    setups: &[Setup],
    options: &mut Options,
    again: impl FnOnce(&Options) -> Result<Compiled, E>,
) -> Met {
    let Needed { softened, mut too_stiff } = needed(&compiled.scene, setups);
    if softened.is_empty() {
        return Met { compiled, softened, too_stiff };
    }
    options.couplings = softened.iter().map(|s| s.coupling.clone()).collect();
    let stable = |c: &Compiled| {
        c.scene.certificate.level != Level::Unstable || compiled.scene.certificate.level == Level::Unstable
    };
    if let Some(coupled) = again(options).ok().filter(stable) {
        let compiled = Compiled { findings: compiled.findings, ..coupled };
        return Met { compiled, softened, too_stiff };
    }
    options.couplings.clear();
    too_stiff.extend(softened.into_iter().map(|s| s.coupling.port));
    Met { compiled, softened: Vec::new(), too_stiff }
}
