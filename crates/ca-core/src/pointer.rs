//! A pointer that pulls on one mass of a playing scene, without a device. Several fingers have a pointer each.
//!
//! A virtual coupling (Colgate et al. 1995), a spring κ and a damper ν, joins the pointer and the mass. It is not a
//! pass of the scene: the update of a MAT is linear in its force, x_{n+1} = … + C·F, so C·F is added after the passes
//! have run. A scene without a pointer has no cost and the same bits.
//!
//! A linear scene stays stable (docs/numerics.md §8). With the dimensionless κ = k·C and ν = z·C the largest
//! eigenvalue, whose limit is 4, is at most [`Certificate::bound`] + κ + 2ν (Weyl's inequality); after a factorisation
//! [`Certificate::headroom`] is the margin. The coupling takes at most half of the margin. With a share q of it the ends of
//! a contact or friction are at most 1/(1 − q) times as mobile, so q also keeps them within the rules of the
//! certificate. Further fingers share what the first one leaves: the second takes half of it, the third a quarter, and so
//! on. Together they stay below the margin. The mass follows the pointer at 1000 Hz at most, critically damped. κ and ν
//! are stored without unit, so that the coupling weakens when a live parameter makes the mass lighter.
//!
//! The pointer moves in a straight line to its last reported position, since a mouse reports 60 to 120 times a second.
//! Its distance from rest is limited to its reach, and its force to the spring force at a hundredth of the reach. This
//! keeps laws with a cubic stiffness, which the certificate does not cover far from rest, from diverging.

use crate::scene::certificate::{Certificate, Level};
use crate::scene::{InputRole, Location, Scene};
use crate::state::{FINGERS, State};
use alloc::string::String;

/// Frequency of a single mass on the undamped coupling \[Hz\].
const FEEL: f64 = 1000.0;
/// Time in which the pointer moves to its last reported position \[s\].
const GLIDE: f64 = 1.0 / 60.0;
/// Minimum reach of a pointer \[m\].
const REACH: f64 = 0.01;
/// Largest elongation of the coupling's spring, relative to the reach.
const STRETCH: f64 = 0.01;
/// Largest share of the margin that the first coupling takes.
const SHARE: f64 = 0.5;
/// Limits of the certificate's rules: contact ratio and friction slope (docs/numerics.md §3.2, §3.5).
const CONTACT: f64 = 1.0;
const FRICTION: f64 = 1.5;
/// Time by which speeds at load are converted to distances \[s\].
const THROW: f64 = 1e-3;

/// Why a mass cannot be held.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refused {
    /// the MAT does not exist
    Unknown,
    /// forces do not move it
    Fixed(String),
    /// a port moves it
    Port(String),
    /// it is a modal mass
    Modal(String),
    /// it is solved together with other masses
    Implicit(String),
    /// it belongs to a group at the gesture rate
    Slow(String),
    /// the scheme of the scene has several steps per sample
    Scheme(&'static str),
    /// the certificate leaves no margin for a coupling
    Margin(String),
}

impl core::fmt::Display for Refused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Refused::Unknown => f.write_str("the scene has no such mass"),
            Refused::Fixed(m) => write!(f, "`{m}` is fixed; pull a mass beside it"),
            Refused::Port(m) => write!(f, "`{m}` is a port; move it with its slider or its device"),
            Refused::Modal(m) => {
                write!(f, "`{m}` is in a group with `method = \"modal\"`; pull a mass outside the group")
            }
            Refused::Implicit(m) => write!(f, "`{m}` has implicit links; pull a mass that they do not touch"),
            Refused::Slow(m) => write!(f, "`{m}` is in a group at the gesture rate; pull a mass outside the group"),
            Refused::Scheme(what) => write!(f, "masses of a model with {what} cannot be pulled; move a port instead"),
            Refused::Margin(m) => write!(f, "`{m}` cannot be pulled: the stability margin is used up (see `ca check`)"),
        }
    }
}
impl core::error::Error for Refused {}

/// A pointer that can hold one mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Pointer {
    finger: u8,
    /// index of the MAT in the scene
    mass: usize,
    /// first slot in the state, and number of axes
    place: usize,
    axes: usize,
    /// first coefficient C of its slots
    inertia: usize,
    /// stiffness k·C and damping z·C of the coupling, dimensionless
    spring: f64,
    damper: f64,
    reach: f64,
    /// present and next position of the pointer \[m\], relative to rest
    at: [f64; 3],
    to: [f64; 3],
    /// motion per tick \[m\], and ticks left
    step: [f64; 3],
    left: u32,
    /// ticks of a movement
    glide: u32,
    /// contribution of the coupling in this tick \[m\], and the motion before it
    add: [f64; 3],
    before: [f64; 3],
}

impl Pointer {
    /// Makes the pointer of a finger (0 to 9) for MAT number `mass` of [`Scene::symbols`]. It has no effect
    /// until [`Pointer::hold`]. Each finger has one pointer at a time, and each mass too.
    ///
    /// # Errors
    /// If the mass cannot be held, with the reason.
    pub fn new(scene: &Scene, mass: usize, finger: u8) -> Result<Pointer, Refused> {
        let symbol = scene.symbols.get(mass).filter(|_| mass < scene.mats()).ok_or(Refused::Unknown)?;
        let Location::Mat(place) = symbol.location else { return Err(Refused::Unknown) };
        let name = || alloc::format!("{}", symbol.name);
        let (first, axes) = (place as usize, if symbol.axes > 1 { 3 } else { 1 });
        let mine = |p: &u32| (first..first + axes).contains(&(*p as usize));
        let ports = scene.layout.ports.enx.iter().chain(&scene.layout.ports.tgr);
        if ports.map(|p| p.mat).any(|p| mine(&p)) {
            return Err(Refused::Port(name()));
        }
        if scene.layout.places.modal.iter().any(|m| mine(&m.mat)) {
            return Err(Refused::Modal(name()));
        }
        if let Some(links) = &scene.layout.implicit {
            if links.places.iter().chain(links.pairs.iter().flat_map(|p| &p.ends)).any(mine) {
                return Err(Refused::Implicit(name()));
            }
        }
        if let Some(group) = &scene.layout.rates.slow {
            if group.ports.iter().chain(&group.shown).any(|p| mine(&p.at)) {
                return Err(Refused::Slow(name()));
            }
        }
        let inertia = 2 * scene.layout.counts.n_mat + first;
        let masses = scene.initial.coef.get(inertia..inertia + axes).unwrap_or_default();
        // a mass in a plane has C = 0 for the axis across it
        if masses.iter().all(|c| *c == 0.0) {
            return Err(Refused::Fixed(name()));
        }
        if scene.oversample() > 1 {
            return Err(Refused::Scheme("several ticks per sample"));
        }
        if scene.passes.moves.iter().any(|op| op.name() == "kick") {
            return Err(Refused::Scheme("the method `pefrl`"));
        }
        if usize::from(finger) >= FINGERS {
            return Err(Refused::Margin(name()));
        }
        let (spring, damper) = coupling(available(&scene.certificate, finger), scene.rates.sample_dt);
        if spring == 0.0 {
            return Err(Refused::Margin(name()));
        }
        Ok(Pointer {
            finger,
            mass,
            place: first,
            axes,
            inertia,
            spring,
            damper,
            reach: reach(scene),
            at: [0.0; 3],
            to: [0.0; 3],
            step: [0.0; 3],
            left: 0,
            glide: (GLIDE * scene.rate).max(1.0) as u32,
            add: [0.0; 3],
            before: [0.0; 3],
        })
    }

    /// Returns the number of the finger, and the index of the MAT that it holds.
    pub fn grip(&self) -> (u8, usize) {
        (self.finger, self.mass)
    }

    /// Returns stiffness \[N/m\] and damping \[N s/m\] of the coupling, in this state.
    pub fn coupling(&self, scene: &Scene, s: &State) -> [f64; 2] {
        let c = s.coef[self.inertia..][..self.axes].iter().copied().fold(0.0, f64::max);
        [self.spring / c, self.damper / c * scene.rates.sample_dt]
    }

    /// Starts at the position of the mass, without force, whatever its motion.
    pub fn hold(&mut self, s: &State) {
        for k in 0..self.axes {
            self.at[k] = s.x[self.place + k];
        }
        (self.to, self.step, self.left) = (self.at, [0.0; 3], 0);
    }

    /// Moves the pointer to `to`, a displacement from rest \[m\] (on a line only the first number counts). A number
    /// that is not finite is ignored; one out of reach is limited to the reach.
    pub fn pull(&mut self, to: [f64; 3]) {
        for (k, to) in to.into_iter().enumerate().take(self.axes) {
            if to.is_finite() {
                self.to[k] = to.clamp(-self.reach, self.reach);
            }
            self.step[k] = (self.to[k] - self.at[k]) / f64::from(self.glide);
        }
        self.left = self.glide;
    }

    /// Computes, before the masses move, the contribution of the coupling from positions and motions at x_n.
    pub fn prepare(&mut self, s: &State) {
        let moves = self.left > 0;
        for k in 0..self.axes {
            let (x, d) = (s.x[self.place + k], s.d[self.place + k]);
            let step = if moves { self.step[k] } else { 0.0 };
            self.before[k] = d;
            let most = self.spring * STRETCH * self.reach;
            self.add[k] = (self.spring * (self.at[k] - x) + self.damper * (step - d)).clamp(-most, most);
            self.at[k] = if self.left > 1 { self.at[k] + step } else { self.to[k] };
        }
        self.left = self.left.saturating_sub(1);
    }

    /// Adds the contribution after the masses have moved, and enters its work F·(d_n + d_{n+1})/2 in the ledger.
    pub fn apply(&mut self, s: &mut State) {
        let mut work = 0.0;
        for k in 0..self.axes {
            let c = s.coef[self.inertia + k];
            if c == 0.0 {
                continue;
            }
            let add = self.add[k];
            s.d[self.place + k] += add;
            s.x[self.place + k] += add;
            work += add / c * 0.5 * (self.before[k] + s.d[self.place + k]);
        }
        if let Some(ledger) = &mut s.ledger {
            ledger.pulled += work;
        }
    }
}

/// Returns the margin of the certificate that is available for κ + 2ν of a finger.
fn available(c: &Certificate, finger: u8) -> f64 {
    let linear = match (c.level, c.headroom) {
        (Level::Unstable, _) => 0.0,
        (_, Some(headroom)) => headroom,
        _ => 4.0 - c.largest.map_or(c.bound, |l| l.1),
    };
    let all = (1.0 - c.rules.contact / CONTACT).min(1.0 - c.rules.friction / FRICTION).min(1.0);
    let first = all.min(SHARE);
    let share = if finger == 0 { first } else { (all - first) / f64::from(1u32 << finger) };
    share * linear
}

/// Returns dimensionless stiffness and damping: critically damped, at [`FEEL`] or with κ + 2ν = κ + 4√κ at most `most`.
fn coupling(most: f64, sample_dt: f64) -> (f64, f64) {
    if most.is_nan() || most <= 0.0 {
        return (0.0, 0.0);
    }
    let wanted = core::f64::consts::TAU * FEEL * sample_dt;
    let root = (libm::sqrt(4.0 + most) - 2.0).min(wanted);
    (root * root, 2.0 * root)
}

/// Returns the reach: the largest displacement, travel of a speed at load, built-in gesture, or length of a link.
fn reach(scene: &Scene) -> f64 {
    let s = &scene.initial;
    let places = s.x.iter().map(|x| x.abs());
    let thrown = s.d.iter().map(|d| d.abs() * scene.rate * THROW);
    let driven = scene
        .about
        .gestures
        .iter()
        .filter(|(name, _)| scene.inputs.iter().any(|i| i.name == *name && i.role != InputRole::Force));
    let driven = driven.flat_map(|(_, points)| points.iter().map(|p| p[1].abs()));
    let lengths = scene.layout.links.reach.iter().map(|r| libm::sqrt(r[..3].iter().map(|v| *v * *v).sum()));
    places.chain(thrown).chain(driven).chain(lengths).filter(|v| v.is_finite()).fold(REACH, f64::max)
}
