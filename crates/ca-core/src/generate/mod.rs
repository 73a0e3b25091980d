//! Generators: one line of text, many modules.
//!
//! Decides that a generator is two functions. `derive` turns what the author wrote (a pitch, a decay) into the numbers
//! its modules use; it is the same function a live change calls, so a string retuned while playing is exactly the
//! string that would have been compiled. `build` names and connects the modules, and points each of their parameters
//! at a derived number. Expansion happens in the compiler, never in the author's file, and names stay indexable:
//! `low[8]`, `low[-1]`, `low[*]`.

use crate::compile::net::{End, LiaNode, MatNode, MatRole, Net};
use crate::kind::Kind;
use crate::live::Source;
use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

mod bank;
mod mesh;
mod stiff;
mod string;

/// All generator kinds, in the order of the documentation.
pub const KINDS: &[&Kind] = &[&string::STRING, &string::CHAIN, &stiff::KIND, &mesh::KIND, &bank::KIND];

/// A resolved parameter, in SI.
#[derive(Clone, Debug, PartialEq)]
pub enum Arg {
    /// not written and without default
    Absent,
    /// a number, a choice by index, a flag as 0 or 1, the number of a table
    Num(f64),
    /// numbers
    List(Vec<f64>),
}

impl Arg {
    /// The number, if it is one.
    pub fn num(&self) -> Option<f64> {
        match self {
            Arg::Num(v) => Some(*v),
            _ => None,
        }
    }
}

/// The resolved parameters of a generator.
#[derive(Clone, Copy)]
pub struct Args<'a> {
    /// its kind, which names the parameters
    pub kind: &'static Kind,
    /// in the order of [`Kind::params`]
    pub values: &'a [Arg],
    /// the tick \[s\]
    pub te: f64,
}

impl Args<'_> {
    fn arg(&self, name: &str) -> &Arg {
        self.kind.param(name).map_or(&Arg::Absent, |i| &self.values[i])
    }
    /// The number `name`, if written or defaulted.
    pub fn num(&self, name: &str) -> Option<f64> {
        self.arg(name).num()
    }
    /// The number `name`, or 0.
    pub fn or0(&self, name: &str) -> f64 {
        self.num(name).unwrap_or(0.0)
    }
    /// The count `name`, or 0.
    pub fn count(&self, name: &str) -> usize {
        self.or0(name) as usize
    }
    /// The numbers `name`; a single number stands for `n` of them.
    pub fn list(&self, name: &str, n: usize) -> Vec<Option<f64>> {
        match self.arg(name) {
            Arg::Absent => alloc::vec![None; n],
            Arg::Num(v) => alloc::vec![Some(*v); n],
            Arg::List(l) => (0..n).map(|i| l.get(i).copied()).collect(),
        }
    }
    /// How many numbers `name` has; `None` for a single number or none.
    pub fn len(&self, name: &str) -> Option<usize> {
        match self.arg(name) {
            Arg::List(l) => Some(l.len()),
            _ => None,
        }
    }
}

/// Why a generator cannot do what was asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// one line
    pub title: String,
    /// the parameter to point at
    pub param: &'static str,
    /// what to do
    pub help: String,
}

/// A kind that expands.
#[derive(Clone, Copy)]
pub struct Generator {
    /// the numbers its modules use, from its parameters; called at load and at live changes
    pub derive: fn(&Args<'_>) -> Result<Vec<Option<f64>>, Problem>,
    /// names and connects the modules
    pub build: fn(&Args<'_>, &mut Build<'_>),
}

/// What a generator builds into.
pub struct Build<'a> {
    net: &'a mut Net,
    name: String,
    item: u32,
    rest: f64,
    group: Option<u32>,
    /// the derived numbers, to see which are zero for good
    slots: &'a [Option<f64>],
    live: bool,
    masses: Vec<u32>,
    links: Vec<u32>,
    tips: Vec<u32>,
    size: [u32; 2],
    nodes: Vec<u32>,
    /// where the parameters of the last links and masses come from: most of a generator's modules share theirs
    shared: Vec<Arc<[Source]>>,
}

impl<'a> Build<'a> {
    /// Begins to expand item number `item` of the net.
    pub(crate) fn new(
        net: &'a mut Net,
        item: u32,
        slots: &'a [Option<f64>],
        live: bool,
        rest: f64,
        group: Option<u32>,
    ) -> Build<'a> {
        let name = net.items[item as usize].name.clone();
        Build {
            net,
            name,
            item,
            rest,
            group,
            slots,
            live,
            masses: Vec::new(),
            links: Vec::new(),
            tips: Vec::new(),
            size: [0, 1],
            nodes: Vec::new(),
            shared: Vec::new(),
        }
    }

    /// The same list of sources as before, if it was met lately.
    fn share(&mut self, values: &[Source]) -> Arc<[Source]> {
        if let Some(known) = self.shared.iter().find(|s| s[..] == *values) {
            return known.clone();
        }
        let new: Arc<[Source]> = Arc::from(values);
        self.shared.truncate(7);
        self.shared.insert(0, new.clone());
        new
    }

    /// True where slot `i` is nothing and stays so.
    pub fn nothing(&self, i: u32) -> bool {
        !self.live && self.slots[i as usize].unwrap_or(0.0) == 0.0
    }

    /// Adds a mass `name[index]`: a MAS of mass slot `m`, or where slot `z` holds something, a CEL damped to ground.
    pub fn mass(&mut self, index: &str, m: u32, z: u32) -> u32 {
        let damped = !self.nothing(z);
        let kind = if damped { &crate::mat::CEL } else { &crate::mat::MAS };
        let mut values = alloc::vec![Source::Absent; kind.params.len()];
        values[0] = Source::Slot(m);
        if damped {
            values[2] = Source::Slot(z);
        }
        let values = self.share(&values);
        let id = self.mat(format!("{}[{index}]", self.name), kind, values);
        self.masses.push(id);
        id
    }

    /// Adds a CEL `name[index]` of mass slot `m`, frequency slot `f`, decay slot `t60`.
    pub fn cell(&mut self, index: usize, m: u32, f: u32, t60: u32) -> u32 {
        let mut values = alloc::vec![Source::Absent; crate::mat::CEL.params.len()];
        values[0] = Source::Slot(m);
        values[3] = Source::Slot(f);
        values[4] = Source::Slot(t60);
        let id = self.mat(format!("{}[{index}]", self.name), &crate::mat::CEL, values.into());
        self.masses.push(id);
        id
    }

    /// Adds a fixed point: `name[index]` where it stands for a mass (the border of a mesh), else `name.end[i]`.
    pub fn fixed(&mut self, index: Option<&str>) -> u32 {
        let name = match index {
            Some(i) => format!("{}[{i}]", self.name),
            None => format!("{}.end[{}]", self.name, self.tips.len()),
        };
        let id = self.mat(name, &crate::mat::SOL, Arc::from([]));
        if index.is_some() {
            self.masses.push(id);
        } else {
            self.tips.push(id);
        }
        id
    }

    fn mat(&mut self, name: String, kind: &'static Kind, values: Arc<[Source]>) -> u32 {
        let crate::kind::Role::Mat(spec) = kind.role else { return 0 };
        self.net.mats.push(MatNode {
            name,
            code: kind.code,
            role: MatRole::Mat(spec),
            values,
            rest: self.rest,
            dx0: 0.0,
            v: 0.0,
            group: self.group,
            item: self.item,
        });
        self.net.mats.len() as u32 - 1
    }

    /// Adds a link `name.link[i]` of stiffness slot `k` and viscosity slot `z`. The cheapest law that serves is chosen
    /// later, by the same pass that treats links written by hand.
    pub fn link(&mut self, a: u32, b: u32, k: u32, z: u32) {
        let crate::kind::Role::Lia(law) = crate::phi::REF.role else { return };
        let values = self.share(&[Source::Absent, Source::Slot(k), Source::Slot(z), Source::Absent]);
        self.links.push(self.net.lias.len() as u32);
        self.net.lias.push(LiaNode {
            name: format!("{}.link[{}]", self.name, self.links.len() - 1),
            kind: &crate::phi::REF,
            law,
            values,
            ends: [End::Mat(a), End::Mat(b)],
            l0: None,
            item: self.item,
        });
    }

    /// Declares the points a moving point `name@s` may stand between, as `size[0] × size[1]` nodes.
    pub fn walkable(&mut self, nodes: Vec<u32>, size: [u32; 2]) {
        self.nodes = nodes;
        self.size = size;
    }

    /// Registers the names.
    pub(crate) fn finish(self) {
        let family = crate::compile::net::Family {
            masses: self.masses,
            links: self.links,
            tips: self.tips,
            nodes: self.nodes,
            size: self.size,
        };
        self.net.families.insert(self.name, family);
    }
}
