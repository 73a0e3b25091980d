//! Scene: a compiled model. Immutable; shared between threads; everything a tick reads and never writes.
//!
//! Counts first, then arrays with their shape. All of it is written once, by the compiler (`ca-compile`), whose findings are not part of it.

mod bind;
pub mod certificate;
pub mod growth;
mod identity;
mod numbers;
mod parts;
#[cfg(feature = "bytes")]
mod plan;
mod start;
pub mod symbols;

use crate::equivalence::Gains;
use crate::io::midi::MidiMap;
use crate::kind::name::Name;
use crate::live::{Controls, LivePlan};
use crate::numeric::Real;
use crate::op::layout::{Account, Layout};
use crate::op::{Integrate, Op};
use crate::state::{Identity, State};
use alloc::borrow::Cow;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
pub use bind::Unbound;
use certificate::Certificate;
pub use identity::{ARITHMETIC, identify, same_since};
pub use numbers::{numbers, structure};
pub use parts::{About, InHand, OutputNames, Passes};
#[cfg(feature = "bytes")]
pub use plan::{PLAN_VERSION, Plan, PlanError};
pub use start::{Order, Start, start};
pub use symbols::{Location, Symbol, Symbols};

/// What stands in a place of [`State::input`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum InputRole {
    /// absolute position \[m\] per sound sample
    Position,
    /// force \[N\] per sound sample
    Force,
    /// absolute position \[m\] per gesture frame, through the rate border
    Device,
}

/// One place of [`State::input`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Input {
    /// name of the port
    pub name: String,
    /// what it takes
    pub role: InputRole,
    /// the value it has before anything is heard \[m\] or \[N\]
    pub rest: f64,
    /// its MIDI mapping, if the model has one
    pub midi: Option<MidiMap>,
    /// device and degree of freedom of a TGR
    pub device: Option<(String, u32)>,
    /// between the hand and this place, for a device
    pub gains: Gains,
}

/// A spring and a damper side by side from a device port to a mass, which has the links of the port instead: the device cannot
/// render these (docs/numerics.md §5.2). In the numbers of the model.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Coupling {
    /// name of the TGR
    pub port: String,
    /// stiffness of the spring \[N/m\]
    pub k: f64,
    /// viscosity of the damper \[N s/m\]
    pub z: f64,
    /// the mass \[kg\]
    pub m: f64,
    /// the stiffness that is felt of the links at their stiffest \[N/m\]
    pub felt: f64,
}

/// A compiled model.
pub struct Scene<R: Real = f64> {
    /// sound rate \[Hz\]
    pub rate: f64,
    /// what the passes read
    pub layout: Layout<R>,
    /// what a tick runs
    pub passes: Passes<R>,
    /// indices into [`State::input`]
    pub inputs: Vec<Input>,
    /// what the outputs are called
    pub names: OutputNames,
    /// live coefficients and how to compute them
    pub live: LivePlan,
    /// what the author says of it
    pub about: About,
    /// name and place of every module, MATs first, in document order
    pub symbols: Symbols,
    /// stability as the compiler could prove it
    pub certificate: Certificate,
    /// how it is in the hand
    pub hand: InHand,
    /// the state at load
    pub initial: State<R>,
    /// what it was made of, where ports are part of the start, or the scene is bound to another precision
    pub before: Option<Before<R>>,
}

/// The parts of which the state at load is made.
#[derive(Clone)]
pub struct Before<R: Real = f64> {
    /// the rules of the start
    pub start: Start,
    /// the state as written
    pub state: State<R>,
    /// the passes that sum forces, in the order in which the start sums them
    pub forces: Vec<Op<R>>,
}

impl<R: Real> Scene<R> {
    /// A state at load, the only allocation of a scene's life.
    pub fn state(&self) -> State<R> {
        self.initial.clone()
    }

    /// What its states and patches are known by: the same of a model that is compiled twice with the same options.
    pub fn identity(&self) -> Identity {
        self.initial.scene
    }

    /// A state at load under hands that are at a place and under way: `hand` gives, for an index into [`State::input`], the
    /// absolute position \[m\] and its change per tick \[m\] at the first tick, or `None` where it stands still at rest.
    ///
    /// Only position ports that some link feels by the motion to come are asked for ([`crate::op::layout::Enx::implicit`]): those
    /// links are of second order or more from the first tick on. All others begin as by [`Scene::state`], from a hand
    /// that stands where it is.
    pub fn state_from(&self, hand: impl Fn(usize) -> Option<[f64; 2]>) -> State<R> {
        let moves = self.layout.oversample() == 1 && self.layout.ports.enx.iter().any(|p| p.implicit);
        let Some(before) = self.before.as_ref().filter(|_| moves) else { return self.state() };
        let mut s = before.state.clone();
        for p in self.layout.ports.enx.iter().filter(|p| p.implicit) {
            let Some([x, d]) = hand(p.input as usize).filter(|v| v.iter().all(|v| v.is_finite())) else { continue };
            let (m, d) = (p.mat as usize, R::of(d));
            let x = R::inner(R::Outer::of(x) - p.rest);
            s.x[m] = if self.layout.ports.ahead.contains(&p.mat) { x - d } else { x };
            s.d[m] = d;
        }
        let mut s = start(&self.layout, &before.forces, before.start, s);
        s.scene = self.initial.scene;
        s
    }

    /// MATs by number, whatever their axes.
    pub fn mats(&self) -> usize {
        self.symbols.mats()
    }

    /// LIAs by number; [`Counts::n_lia`](crate::op::layout::Counts::n_lia) also counts places in a row that no link takes.
    pub fn lias(&self) -> usize {
        self.symbols.lias().len()
    }

    /// The index into [`State::input`] of the port `name`.
    pub fn input(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|i| i.name == name)
    }

    /// Name of the MAT at a place of the state; the three places of one in space have its name.
    pub fn mat_name(&self, mat: usize) -> Cow<'static, str> {
        self.symbols.mat(mat).map_or("a moving point".into(), |n| n.to_string().into())
    }

    /// Name of the link with this number in the ledger.
    pub fn audited_name(&self, link: usize) -> Option<Cow<'static, str>> {
        let of = |a: &&Account<R>| (a.first..a.first + a.n).contains(&link);
        let account = self.layout.ledger.as_ref()?.accounts.iter().find(of)?;
        Some(lia_name(self, account.op, link - account.first))
    }

    /// The live parameters, to be played.
    pub fn controls(&self) -> Controls {
        Controls::new(&self.live, 1.0 / (self.rate * f64::from(self.oversample()))).over::<R>()
    }
}

/// Name of a link of a scene by op and position.
pub fn lia_name<R: Real>(scene: &Scene<R>, op: usize, i: usize) -> Cow<'static, str> {
    scene.symbols.lia(op, i).map_or("?".into(), |n| n.to_string().into())
}

/// Modules of a pass of a scene. [`Op::n`] also counts places in a row that no link takes, and of a mesh only one of its
/// two directions.
pub fn modules<R: Real>(scene: &Scene<R>, op: &Op<R>) -> usize {
    if op.law.is_none() || op.form.stride == 0 {
        return op.n;
    }
    // the links of a pass that integrates are listed behind all other links, both directions of a mesh from one mass on
    let fused = scene.passes.summed().len();
    let runs = |i: usize| {
        let listed = &scene.passes.forces[i];
        if i < fused { listed.first == op.first } else { listed.mat == op.mat && op.form.integrate != Integrate::No }
    };
    scene.symbols.lias().iter().filter(|l| runs(l[0] as usize)).count()
}

/// The links in the ledger of a scene, each with its number there: all at once, since one by one they are looked for anew.
pub fn audited_links<R: Real>(scene: &Scene<R>) -> impl Iterator<Item = (usize, Name)> + '_ {
    let accounts = scene.layout.ledger.as_ref().map_or(&[][..], |l| &l.accounts);
    scene.symbols.iter().skip(scene.symbols.mats()).filter_map(|s| {
        let Location::Lia(op, i) = s.location else { return None };
        let of = accounts.iter().find(|a| a.op == op as usize)?;
        Some((of.first + i as usize, s.name))
    })
}

/// A scene reads as its layout, with names added: `scene.counts.n_mat`, `scene.rates.sample_dt`.
impl<R: Real> core::ops::Deref for Scene<R> {
    type Target = Layout<R>;
    fn deref(&self) -> &Layout<R> {
        &self.layout
    }
}

impl<R: Real> core::fmt::Debug for Scene<R> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "Scene({} MAT, {} LIA, {} ops at {} Hz)",
            self.mats(),
            self.lias(),
            self.passes.forces.len(),
            self.rate
        )
    }
}
