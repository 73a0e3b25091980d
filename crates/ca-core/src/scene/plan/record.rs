//! Records: the parts of a scene that refer to laws, kinds and units, with codes in place of references.
//!
//! All other parts of a scene are written as they are. Records are not recursive, so a file cannot nest them endlessly.

use crate::equivalence::Equivalence;
use crate::kind::Dim;
use crate::kind::builder::Arg;
use crate::kind::name::Name;
use crate::live::{LiveImplicit, Source};
use crate::op::layout::{Copied, Layout, Ports, Response, Row};
use crate::op::{Form, Pass};
use crate::scene::certificate::Certificate;
use crate::scene::{Coupling, Input, Start};
use crate::state::{Between, Border, Cell, Identity, Unknown};
use crate::tuning::Scheme;
use alloc::borrow::Cow;
use alloc::string::String;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// A list borrowed from the scene being written.
pub(super) type List<'a, T> = Cow<'a, [T]>;
/// A text borrowed from the scene being written.
pub(super) type Text<'a> = Cow<'a, str>;

/// A pass. Its law is an index into [`SceneRecord::laws`].
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct OpRecord {
    pub pass: Pass,
    pub law: Option<u32>,
    pub form: Form,
    pub ports: Ports,
    pub n: usize,
    pub first: usize,
    pub mat: usize,
    pub coef: usize,
    pub mem: usize,
    pub tap: usize,
}

#[derive(Serialize, Deserialize)]
pub(super) struct OutputLinkRecord {
    pub law: u32,
    pub ends: [u32; 2],
    pub e0: f64,
    pub coef: u32,
    pub step: u32,
    pub coefs: u32,
    pub tap: u32,
}

#[derive(Serialize, Deserialize)]
pub(super) struct AccountRecord {
    pub op: usize,
    pub n: usize,
    pub ports: Ports,
    pub first: usize,
    pub coef: usize,
    pub mem: usize,
    pub tap: usize,
    pub law: u32,
    pub linear: bool,
    pub live: bool,
    pub rows: [Row; 2],
}

#[derive(Serialize, Deserialize)]
pub(super) struct LedgerRecord {
    pub accounts: Vec<AccountRecord>,
    pub weight: usize,
    pub live: bool,
}

/// A layout without its group and the ticks between two samples.
#[derive(Serialize, Deserialize)]
pub(super) struct LayoutRecord<'a> {
    pub arrays: Cow<'a, Layout>,
    pub output_links: Vec<OutputLinkRecord>,
    pub ledger: Option<LedgerRecord>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct SubstepsRecord<'a> {
    pub times: u32,
    pub tick: Vec<OpRecord>,
    pub inputs: List<'a, u32>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct GroupRecord<'a> {
    pub layout: LayoutRecord<'a>,
    pub reads: Vec<OpRecord>,
    pub forces: Vec<OpRecord>,
    pub after: Vec<OpRecord>,
    pub moves: Vec<OpRecord>,
    pub ports: List<'a, Copied>,
    pub coupled: usize,
    pub compensated: bool,
    pub shown: List<'a, Copied>,
    pub links: usize,
    pub masses: usize,
    pub response: Cow<'a, Response>,
}

/// A state at load without its group. `kick` belongs to its ledger.
#[derive(Serialize, Deserialize)]
pub(super) struct StateRecord<'a> {
    pub x: List<'a, f64>,
    pub d: List<'a, f64>,
    pub f: List<'a, f64>,
    pub coef: List<'a, f64>,
    pub mem: List<'a, f64>,
    pub lengths: List<'a, f64>,
    pub tap: List<'a, f64>,
    pub input: List<'a, f64>,
    pub last_input: List<'a, f64>,
    pub output: List<'a, f64>,
    pub cells: List<'a, Cell>,
    pub border: List<'a, Border>,
    pub late: List<'a, f64>,
    pub blocked: List<'a, [f64; 2]>,
    pub glide: List<'a, [f64; 2]>,
    pub under_way: List<'a, [f64; 2]>,
    pub turns: List<'a, f64>,
    pub lowpass: List<'a, f64>,
    pub implicit: List<'a, f64>,
    pub live: List<'a, u32>,
    pub whole: u32,
    pub written: [List<'a, u32>; 2],
    pub kick: Option<List<'a, f64>>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct SlowRecord<'a> {
    pub scene: Identity,
    pub state: StateRecord<'a>,
    pub ports: List<'a, Between>,
    pub unknown: List<'a, Unknown>,
}

/// A state at load with the state of its group.
#[derive(Serialize, Deserialize)]
pub(super) struct LoadedRecord<'a> {
    pub state: StateRecord<'a>,
    pub slow: Option<SlowRecord<'a>>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct BeforeRecord<'a> {
    pub start: Start,
    pub loaded: LoadedRecord<'a>,
    pub forces: Vec<OpRecord>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct ParamRecord<'a> {
    pub name: Text<'a>,
    pub symbol: Text<'a>,
    pub dim: Dim,
    pub min: f64,
    pub max: f64,
    pub value: f64,
    pub doc: Text<'a>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct DrivenRecord<'a> {
    pub param: ParamRecord<'a>,
    pub port: Text<'a>,
    pub span: [f64; 2],
}

/// Rule for coefficients, with the code of a MAT or a law.
#[derive(Serialize, Deserialize)]
pub(super) enum LoaderRecord<'a> {
    Mat(Text<'a>, f64),
    Lia(Text<'a>),
    Times(f64),
}

/// A live module. Its values are an index into [`LiveRecord::values`].
#[derive(Serialize, Deserialize)]
pub(super) struct ModuleRecord<'a> {
    pub loader: LoaderRecord<'a>,
    pub values: u32,
    pub to: List<'a, u32>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct ItemRecord<'a> {
    pub kind: Text<'a>,
    pub dim: u8,
    pub scheme: Scheme,
    pub args: List<'a, Arg>,
    pub follows: List<'a, (usize, usize, f64)>,
    pub derives: bool,
    pub modules: Vec<ModuleRecord<'a>>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct LiveRecord<'a> {
    pub params: Vec<ParamRecord<'a>>,
    pub coefs: List<'a, u32>,
    pub driven: Vec<DrivenRecord<'a>>,
    pub driven_coefs: List<'a, u32>,
    pub values: Vec<List<'a, Source>>,
    pub items: Vec<ItemRecord<'a>>,
    pub implicit: Option<Cow<'a, LiveImplicit>>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct RunRecord<'a> {
    pub name: Cow<'a, Name>,
    pub code: Text<'a>,
    pub axes: u8,
    pub first: u32,
}

#[derive(Serialize, Deserialize)]
pub(super) struct SymbolsRecord<'a> {
    pub runs: Vec<RunRecord<'a>>,
    pub mats: List<'a, u32>,
    pub lias: List<'a, [u32; 2]>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct SceneRecord<'a> {
    /// codes of the laws of passes, accounts and links that outputs read
    pub laws: Vec<Text<'a>>,
    pub rate: f64,
    pub layout: LayoutRecord<'a>,
    pub substeps: Option<SubstepsRecord<'a>>,
    pub slow: Option<GroupRecord<'a>>,
    pub reads: Vec<OpRecord>,
    pub forces: Vec<OpRecord>,
    pub fused: usize,
    pub writes: Vec<OpRecord>,
    pub moves: Vec<OpRecord>,
    pub inputs: List<'a, Input>,
    pub channel_names: List<'a, String>,
    pub probe_names: List<'a, String>,
    pub probe_of: List<'a, u32>,
    pub live: LiveRecord<'a>,
    pub gestures: List<'a, (String, Vec<[f64; 2]>)>,
    pub presets: List<'a, (String, Vec<(String, f64)>)>,
    pub symbols: SymbolsRecord<'a>,
    pub certificate: Cow<'a, Certificate>,
    pub equivalence: Cow<'a, Equivalence>,
    pub couplings: List<'a, Coupling>,
    pub left_out: List<'a, String>,
    pub sorted: bool,
    pub title: Text<'a>,
    pub seconds: Option<f64>,
    pub initial: LoadedRecord<'a>,
    pub before: Option<BeforeRecord<'a>>,
}
