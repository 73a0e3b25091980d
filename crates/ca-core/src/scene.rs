//! Scene: a compiled model. Immutable; shared between threads; everything a tick reads and never writes.
//!
//! Counts first, then arrays with their shape. All of it is written once, by [`compile`](mod@crate::compile).

use crate::energy::LedgerPlan;
use crate::live::LivePlan;
use crate::model::diag::Diags;
use crate::op::Op;
use crate::state::State;
use crate::table::Table;
use alloc::string::String;
use alloc::vec::Vec;

/// A position port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enx {
    /// place in [`State::input`]
    pub input: u32,
    /// the MAT it moves
    pub mat: u32,
    /// its rest position \[m\]; the input is absolute
    pub rest: f64,
}

/// A force port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enf {
    /// place in [`State::input`]
    pub input: u32,
    /// the MAT it pushes
    pub mat: u32,
}

/// Where a coordinate of a moving point comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// a coefficient, which may be live
    Coef(u32),
    /// the absolute position of a MAT, e.g. an ENX
    Mat(u32),
}

/// A moving point: a MAT without mass that stands between nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proxy {
    /// its own place among the MATs
    pub mat: u32,
    /// first node in [`Scene::nodes`]
    pub first: u32,
    /// nodes along the two directions; 1 for a string
    pub size: [u32; 2],
    /// coordinates 0 … 1
    pub at: [Place; 2],
}

/// What an output hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// displacement of a MAT from its rest position
    Position(u32),
    /// summed force on a MAT
    ForceOn(u32),
    /// force of a LIA, at this place in [`State::tap`]
    ForceOf(u32),
}

/// An output or a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// place in [`State::output`]
    pub channel: u32,
    /// what it hears
    pub heard: Heard,
}

/// What stands in a place of [`State::input`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
pub struct Input {
    /// name of the port
    pub name: String,
    /// what it takes
    pub role: InputRole,
    /// the value it has before anything is heard \[m\] or \[N\]
    pub rest: f64,
    /// its MIDI mapping, if the model has one
    pub midi: Option<crate::io::midi::MidiMap>,
    /// device and degree of freedom of a TGR
    pub device: Option<(String, u32)>,
}

/// Name, kind and place of a module that was compiled.
#[derive(Clone, Debug, PartialEq)]
pub struct Symbol {
    /// e.g. `low[3]`
    pub name: String,
    /// code of what runs, e.g. `MAS`, `RES`
    pub code: &'static str,
    /// where it stands
    pub place: Stands,
}

/// Where a module stands in the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stands {
    /// a MAT: place in [`State::x`]
    Mat(u32),
    /// a LIA: op number in [`Scene::forces`] and position in it
    Lia(u32, u32),
}

/// A compiled model.
pub struct Scene {
    /// sound rate \[Hz\]
    pub rate: f64,
    /// tick \[s\], 1/rate
    pub te: f64,
    /// ticks per gesture frame
    pub ratio: u32,
    /// MATs, moving points included
    pub n_mat: usize,
    /// links
    pub n_lia: usize,
    /// coefficients
    pub n_coef: usize,
    /// numbers of memory of laws
    pub n_mem: usize,
    /// places for forces kept or in passing
    pub n_tap: usize,
    /// channels of sound; probes come after them in [`State::output`]
    pub channels: usize,
    /// places in [`State::output`]
    pub n_out: usize,

    /// passes before the forces: ports, ledger, changes, moving points
    pub reads: Vec<Op>,
    /// passes that sum forces at the present positions
    pub forces: Vec<Op>,
    /// passes that write outputs
    pub writes: Vec<Op>,
    /// passes that move the MATs
    pub moves: Vec<Op>,

    /// ends of links, first and second MAT (n_lia x 2)
    pub ends: Vec<[u32; 2]>,
    /// constant part of the elongation \[m\] (n_lia)
    pub e0: Vec<f64>,
    /// rest positions \[m\] (n_mat)
    pub rest: Vec<f64>,
    /// nodes under moving points (any)
    pub nodes: Vec<u32>,
    /// moving points (any)
    pub proxies: Vec<Proxy>,
    /// tables of laws (any)
    pub tables: Vec<Table>,
    /// position ports (any)
    pub enx: Vec<Enx>,
    /// force ports (any)
    pub enf: Vec<Enf>,
    /// device ports (any), across the border
    pub tgr: Vec<Enx>,
    /// MATs with weight (any)
    pub weighed: Vec<u32>,
    /// what is heard, sound first, then probes (any)
    pub outputs: Vec<Output>,
    /// places of [`State::input`]
    pub inputs: Vec<Input>,
    /// names of the sound channels (channels)
    pub channel_names: Vec<String>,
    /// names of the probes (n_out − channels): the selector, with `#i` where it chose several
    pub probe_names: Vec<String>,
    /// what the ledger needs, where the scene keeps one
    pub ledger: Option<LedgerPlan>,
    /// live coefficients and how to compute them
    pub live: LivePlan,
    /// the built-in gesture of the model: what it drives and its points \[s, value\]
    pub gestures: Vec<(String, Vec<[f64; 2]>)>,
    /// name and place of every module, MATs first, in document order
    pub symbols: Vec<Symbol>,
    /// stability as the compiler could prove it
    pub certificate: crate::compile::certify::Certificate,
    /// what the passes of the compiler left out, in words
    pub left_out: Vec<String>,
    /// warnings and notes of the compiler
    pub diags: Diags,
    /// title of the model
    pub title: String,
    /// how long the author lets it sound \[s\], if said
    pub seconds: Option<f64>,
    /// the state at load
    pub(crate) initial: State,
}

impl Scene {
    /// A state at load, the only allocation of a scene's life.
    pub fn state(&self) -> State {
        self.initial.clone()
    }

    /// The place in [`State::input`] of the port `name`.
    pub fn input(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|i| i.name == name)
    }

    /// Name of the MAT at a place of the state.
    pub fn mat_name(&self, mat: usize) -> &str {
        self.symbols.iter().find(|s| s.place == Stands::Mat(mat as u32)).map_or("a moving point", |s| &s.name)
    }

    /// Name of the link with this number in the ledger.
    pub fn audited_name(&self, link: usize) -> Option<&str> {
        let plan = self.ledger.as_ref()?;
        let of = |(op, first): (&Op, &usize)| op.law.is_some() && (*first..first + op.n).contains(&link);
        let op = self.forces.iter().zip(&plan.first).position(of)?;
        Some(self.lia_name(op, link - plan.first[op]))
    }

    /// Name of a link by op and position.
    pub fn lia_name(&self, op: usize, i: usize) -> &str {
        self.symbols.iter().find(|s| s.place == Stands::Lia(op as u32, i as u32)).map_or("?", |s| &s.name)
    }
}

impl core::fmt::Debug for Scene {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Scene({} MAT, {} LIA, {} ops at {} Hz)", self.n_mat, self.n_lia, self.forces.len(), self.rate)
    }
}
