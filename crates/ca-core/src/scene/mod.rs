//! Scene: a compiled model. It is immutable and shared between threads, and holds everything that a tick only reads.
//!
//! Counts come first, then arrays with their shapes, all written once by the compiler (`ca-compile`).

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
use crate::live::{Controls, LiveTable};
use crate::numeric::Real;
use crate::op::layout::{Account, Enx, Layout};
use crate::op::{Integrate, Op};
use crate::state::{Identity, State};
use alloc::borrow::Cow;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
pub use bind::Unbound;
use certificate::Certificate;
pub use identity::{ARITHMETIC, identify, same_since};
pub use numbers::{numbers, structure};
pub use parts::{About, InHand, OutputNames, PRESET, Passes};
#[cfg(feature = "bytes")]
pub use plan::{PLAN_VERSION, Plan, PlanError};
pub use start::{Order, Start, start};
pub use symbols::{Location, Symbol, Symbols};

/// Meaning of a value in [`State::input`].
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

/// A value in [`State::input`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Input {
    /// name of the port
    pub name: String,
    /// meaning of the value
    pub role: InputRole,
    /// value before anything has sounded \[m\] or \[N\]
    pub rest: f64,
    /// MIDI mapping, if the model has one
    pub midi: Option<MidiMap>,
    /// device and degree of freedom of a TGR
    pub device: Option<(String, u32)>,
    /// gains between the device and this value, for a device
    pub gains: Gains,
}

/// A virtual coupling: a spring and a damper in parallel, from a device port to a mass that carries the links of the
/// port, since the device cannot render these itself (docs/numerics.md §5.2). All numbers are in units of the model.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Coupling {
    /// name of the TGR
    pub port: String,
    /// stiffness of the spring \[N/m\]
    pub k: f64,
    /// viscosity of the damper \[N s/m\]
    pub z: f64,
    /// mass \[kg\]
    pub m: f64,
    /// stiffness at the device when the links are at their stiffest \[N/m\]
    pub device_stiffness: f64,
}

/// A compiled model.
pub struct Scene<R: Real = f64> {
    /// sound rate \[Hz\]
    pub rate: f64,
    /// arrays that the passes read
    pub layout: Layout<R>,
    /// passes of a tick
    pub passes: Passes<R>,
    /// indices into [`State::input`]
    pub inputs: Vec<Input>,
    /// names of the outputs
    pub names: OutputNames,
    /// live coefficients and how to compute them
    pub live: LiveTable,
    /// title, gestures and other statements of the author
    pub about: About,
    /// name and location of every module, MATs first, in document order
    pub symbols: Symbols,
    /// stability as proven by the compiler
    pub certificate: Certificate,
    /// the model at a device
    pub hand: InHand,
    /// the state at load
    pub initial: State<R>,
    /// source of the state at load, if ports are part of the start, or the scene is bound to another precision
    pub before: Option<Before<R>>,
}

/// The parts from which the state at load is made.
#[derive(Clone)]
pub struct Before<R: Real = f64> {
    /// rules of the start
    pub start: Start,
    /// state as written
    pub state: State<R>,
    /// passes that sum forces, in the order of the start
    pub forces: Vec<Op<R>>,
}

impl<R: Real> Scene<R> {
    /// Returns a state at load. This allocates; a tick does not.
    pub fn state(&self) -> State<R> {
        self.initial.clone()
    }

    /// Returns the identity of its states and patches, which is the same for the same model and compiler options.
    pub fn identity(&self) -> Identity {
        self.initial.scene
    }

    /// Returns a state at load whose ports have an initial position and motion. `hand` gives, for an index into
    /// [`State::input`], the position \[m\] and its change per sample \[m\] at the first tick, or `None` for a port at
    /// its place in the model.
    ///
    /// It is called only for position and device ports with links that are solved with the coming motion
    /// ([`crate::op::layout::Enx::implicit`]). Those links store the energy of this position, not that of the place in
    /// the model. At one tick per sample, links at position ports are also of second order or more from the first tick
    /// on: a device port, and any port of a scene with several ticks per sample, begins without motion.
    pub fn state_from(&self, hand: impl Fn(usize) -> Option<[f64; 2]>) -> State<R> {
        let Some(before) = self.before.as_ref().filter(|_| self.begins_by_hand().next().is_some()) else {
            return self.state();
        };
        let mut s = before.state.clone();
        for (p, moves) in self.begins_by_hand() {
            let Some([x, d]) = hand(p.input as usize).filter(|v| v.iter().all(|v| v.is_finite())) else { continue };
            let (m, d) = (p.mat as usize, R::of(if moves { d } else { 0.0 }));
            let x = R::inner(R::Outer::of(x) - p.rest);
            s.x[m] = if self.layout.ports.ahead.contains(&p.mat) { x - d } else { x };
            s.d[m] = d;
        }
        let mut s = start(&self.layout, &before.forces, before.start, s);
        s.scene = self.initial.scene;
        s
    }

    /// Returns the ports whose initial position is part of the start, each with whether its motion is too.
    fn begins_by_hand(&self) -> impl Iterator<Item = (&Enx<R>, bool)> {
        let ports = &self.layout.ports;
        let moves = self.layout.oversample() == 1;
        let all = ports.enx.iter().map(move |p| (p, moves)).chain(ports.tgr.iter().map(|p| (p, false)));
        all.filter(|(p, _)| p.implicit)
    }

    /// Returns the number of MATs, with any number of axes.
    pub fn mats(&self) -> usize {
        self.symbols.mats()
    }

    /// Returns the number of LIAs. [`Counts::n_lia`](crate::op::layout::Counts::n_lia) also counts the padding of rows.
    pub fn lias(&self) -> usize {
        self.symbols.lias().len()
    }

    /// Returns the index into [`State::input`] of the port `name`.
    pub fn input(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|i| i.name == name)
    }

    /// Returns the name of the MAT at a slot of the state. The three slots of a MAT in space have the same name.
    pub fn mat_name(&self, mat: usize) -> Cow<'static, str> {
        self.symbols.mat(mat).map_or("a moving point".into(), |n| n.to_string().into())
    }

    /// Returns the name of the link with this number in the ledger.
    pub fn audited_name(&self, link: usize) -> Option<Cow<'static, str>> {
        let of = |a: &&Account<R>| (a.first..a.first + a.n).contains(&link);
        let account = self.layout.ledger.as_ref()?.accounts.iter().find(of)?;
        Some(lia_name(self, account.op, link - account.first))
    }

    /// Returns the live parameters, for playing.
    pub fn controls(&self) -> Controls {
        Controls::new(&self.live, 1.0 / (self.rate * f64::from(self.oversample()))).over::<R>()
    }
}

/// Returns the name of a link by op and position.
pub fn lia_name<R: Real>(scene: &Scene<R>, op: usize, i: usize) -> Cow<'static, str> {
    scene.symbols.lia(op, i).map_or("?".into(), |n| n.to_string().into())
}

/// Returns the modules of a pass. [`Op::n`] also counts padding, and for a mesh only one of its two directions.
pub fn modules<R: Real>(scene: &Scene<R>, op: &Op<R>) -> usize {
    if op.law.is_none() || op.form.stride == 0 {
        return op.n;
    }
    // links that a pass integrates are listed after all others; both directions of a mesh start at the same mass
    let fused = scene.passes.summed().len();
    let runs = |i: usize| {
        let listed = &scene.passes.forces[i];
        if i < fused { listed.first == op.first } else { listed.mat == op.mat && op.form.integrate != Integrate::No }
    };
    scene.symbols.lias().iter().filter(|l| runs(l[0] as usize)).count()
}

/// Iterates over the links in the ledger, each with its number there. Finding them one by one would search each time.
pub fn audited_links<R: Real>(scene: &Scene<R>) -> impl Iterator<Item = (usize, Name)> + '_ {
    let accounts = scene.layout.ledger.as_ref().map_or(&[][..], |l| &l.accounts);
    scene.symbols.iter().skip(scene.symbols.mats()).filter_map(|s| {
        let Location::Lia(op, i) = s.location else { return None };
        let of = accounts.iter().find(|a| a.op == op as usize)?;
        Some((of.first + i as usize, s.name))
    })
}

/// A scene dereferences to its layout: `scene.counts.n_mat`, `scene.rates.sample_dt`.
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
