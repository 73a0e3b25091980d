//! Pointer: a hand without a device that pulls on one mass of a scene that plays.
//!
//! Decides on a virtual coupling (Colgate et al. 1995) between the pointer and the mass, a spring κ and a damper ν, and
//! that it is no pass of the scene: the update of a MAT is linear in its force, x_{n+1} = … + C·F, so that what the
//! coupling adds, C·F to motion and place, can be added once the passes have run. A scene that nobody holds pays
//! nothing for it and keeps its bits, and no kernel has to know.
//!
//! It leaves a linear scene stable. With κ = k·C and ν = z·C, both without unit, the coupling adds a matrix of rank one
//! with the eigenvalue κ + 2ν to T²M⁻¹K + 2TM⁻¹Z, whose eigenvalues must lie below 4 (docs/numerics.md §8); by Weyl's
//! inequality the largest of the sum is at most [`Certificate::bound`] + κ + 2ν; where a factorisation decided, it says what is
//! left ([`Certificate::room`]). κ and ν take half of that at most. A coupling that takes the share q of what is left makes the
//! ends of a contact or of a friction at most 1/(1 − q) times as easy to move, so q is no more than keeps them within
//! the rules of the certificate. And never more than what is wanted: a mass that follows the pointer at a thousand
//! hertz, critically damped. They are kept without unit, so that a live parameter that makes the mass lighter makes the coupling weaker too.
//!
//! The pointer moves in a straight line from where it was to where it was last seen, since a mouse is read 60 to 120 times
//! a second. How far it may be from rest has a bound, its reach, and so has how hard it pulls: as the spring does at a
//! hundredth of that. Laws that stiffen with the cube of their length, which no certificate covers far from rest, are not
//! pressed to where they diverge.

use crate::scene::certificate::{Certificate, Level};
use crate::scene::{InputRole, Location, Scene};
use crate::state::State;
use alloc::string::String;

/// Frequency at which a mass alone would swing about the pointer, undamped \[Hz\].
const FEEL: f64 = 1000.0;
/// Time in which the pointer gets to where it was last seen \[s\].
const GLIDE: f64 = 1.0 / 60.0;
/// Least reach of a pointer \[m\].
const REACH: f64 = 0.01;
/// The coupling pulls as hard as its spring does at this share of the reach.
const STRETCH: f64 = 0.01;
/// Share of what is left that the coupling takes at most.
const SHARE: f64 = 0.5;
/// The rules of the certificate: the largest ratio of a contact, and the steepest friction (docs/numerics.md §3.2, §3.5).
const CONTACT: f64 = 1.0;
const FRICTION: f64 = 1.5;
/// Speeds at load are as far as they would go in this time \[s\].
const THROW: f64 = 1e-3;

/// Why a mass cannot be held.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refused {
    /// there is no MAT of this number
    Unknown,
    /// no force moves it
    Fixed(String),
    /// a port moves it
    Port(String),
    /// it goes by its modes
    Modal(String),
    /// what moves it is solved together with other masses
    Implicit(String),
    /// it is computed once a gesture frame
    Slow(String),
    /// the scheme of the scene has several steps in a sample
    Scheme(&'static str),
    /// the certificate leaves nothing for a coupling
    Margin(String),
}

impl core::fmt::Display for Refused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Refused::Unknown => f.write_str("the scene has no such mass"),
            Refused::Fixed(m) => write!(f, "`{m}` is fixed; pull on a mass beside it"),
            Refused::Port(m) => write!(f, "`{m}` is a port; move it by its slider or its device"),
            Refused::Modal(m) => write!(f, "`{m}` is in a group that goes by its modes; pull on a mass outside of it"),
            Refused::Implicit(m) => write!(f, "`{m}` is held by implicit links; pull on a mass outside of them"),
            Refused::Slow(m) => write!(f, "`{m}` is in a group at the gesture rate; pull on a mass outside of it"),
            Refused::Scheme(what) => write!(f, "a model with {what} cannot be pulled on; push it by a port"),
            Refused::Margin(m) => write!(f, "`{m}`: nothing is left of the stability margin for a hand (`ca check`)"),
        }
    }
}
impl core::error::Error for Refused {}

/// A pointer that holds a mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Pointer {
    /// number of the MAT among those of the scene
    mass: usize,
    /// its first place in the state, and how many
    place: usize,
    axes: usize,
    /// first of the coefficients C of its places
    inertia: usize,
    /// stiffness k·C and damping z·C of the coupling, without unit
    spring: f64,
    damper: f64,
    reach: f64,
    /// where the pointer is, and is going \[m\], from rest
    at: [f64; 3],
    to: [f64; 3],
    /// its motion a tick \[m\], and ticks left
    step: [f64; 3],
    left: u32,
    /// ticks of a glide
    glide: u32,
    /// what the coupling adds in this tick \[m\], and the motion before it
    add: [f64; 3],
    before: [f64; 3],
}

impl Pointer {
    /// A pointer for MAT number `mass` of a scene, in the order of [`Scene::symbols`]; holds nothing until
    /// [`Pointer::hold`].
    ///
    /// # Errors
    /// Where the mass cannot be held, with the reason.
    pub fn new(scene: &Scene, mass: usize) -> Result<Pointer, Refused> {
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
        // a mass in a plane has no force across it
        if masses.iter().all(|c| *c == 0.0) {
            return Err(Refused::Fixed(name()));
        }
        if scene.oversample() > 1 {
            return Err(Refused::Scheme("several ticks in a sample"));
        }
        if scene.passes.moves.iter().any(|op| op.name() == "kick") {
            return Err(Refused::Scheme("the method `pefrl`"));
        }
        let (spring, damper) = coupling(room(&scene.certificate), scene.rates.sample_dt);
        if spring == 0.0 {
            return Err(Refused::Margin(name()));
        }
        Ok(Pointer {
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

    /// Number of the MAT that it is for.
    pub fn mass(&self) -> usize {
        self.mass
    }

    /// Stiffness \[N/m\] and damping \[N s/m\] of the coupling, in this state.
    pub fn coupling(&self, scene: &Scene, s: &State) -> [f64; 2] {
        let c = s.coef[self.inertia..][..self.axes].iter().copied().fold(0.0, f64::max);
        [self.spring / c, self.damper / c * scene.rates.sample_dt]
    }

    /// Begins where the mass is: with no force, however it moves.
    pub fn hold(&mut self, s: &State) {
        for k in 0..self.axes {
            self.at[k] = s.x[self.place + k];
        }
        (self.to, self.step, self.left) = (self.at, [0.0; 3], 0);
    }

    /// The pointer was seen at `to`, a displacement from rest \[m\] (on a line the first number alone). What is not finite
    /// counts for nothing, what is out of reach is as far as that.
    pub fn pull(&mut self, to: [f64; 3]) {
        for (k, to) in to.into_iter().enumerate().take(self.axes) {
            if to.is_finite() {
                self.to[k] = to.clamp(-self.reach, self.reach);
            }
            self.step[k] = (self.to[k] - self.at[k]) / f64::from(self.glide);
        }
        self.left = self.glide;
    }

    /// Before the masses move: what the coupling will add, from places and motions at x_n.
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

    /// After the masses moved: adds it, and enters its work, F·(d_n + d_{n+1})/2, in the ledger.
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

/// What the certificate leaves for κ + 2ν.
fn room(c: &Certificate) -> f64 {
    let linear = match (c.level, c.room) {
        (Level::Unstable, _) => 0.0,
        (_, Some(room)) => room,
        _ => 4.0 - c.largest.map_or(c.bound, |l| l.1),
    };
    let share = (1.0 - c.rules.contact / CONTACT).min(1.0 - c.rules.friction / FRICTION).min(SHARE);
    share * linear
}

/// Stiffness and damping without unit: critically damped, at [`FEEL`] or with κ + 2ν = κ + 4√κ no more than `most`.
fn coupling(most: f64, sample_dt: f64) -> (f64, f64) {
    if most.is_nan() || most <= 0.0 {
        return (0.0, 0.0);
    }
    let wanted = core::f64::consts::TAU * FEEL * sample_dt;
    let root = (libm::sqrt(4.0 + most) - 2.0).min(wanted);
    (root * root, 2.0 * root)
}

/// How far an instrument is pulled at most: as far as anything of it is from its rest, is thrown, or is moved by its own
/// gesture.
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
