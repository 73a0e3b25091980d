//! Builder: what a generator makes before the compiler gives it names and kinds.
//!
//! Decides that a generator knows neither the network nor the kinds of its modules: it adds masses, fixed points and
//! links that point at derived numbers, and the compiler expands what was built. `derive` is the function a live change
//! calls too, so a string retuned while playing is exactly the string that would have been compiled.

use crate::kind::Param;
use crate::kind::cloud::Cloud;
use crate::kind::name::Index;
use crate::tuning::Scheme;
pub use crate::tuning::problem::Problem;
use crate::tuning::wave::WaveguideSpec;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// A resolved parameter, in SI.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Arg {
    /// not written and without default
    Absent,
    /// a number, a choice by index, a flag as 0 or 1, the number of a table
    Num(f64),
    /// numbers
    List(Vec<f64>),
    /// what a file holds
    Cloud(Arc<Cloud>),
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
    /// code of its kind
    pub code: &'static str,
    /// the parameters of its kind, which name them
    pub params: &'static [Param],
    /// in the same order
    pub values: &'a [Arg],
    /// the tick \[s\]
    pub tick_dt: f64,
    /// axes along which its MATs move
    pub dim: u8,
    /// how what is linear in it is computed
    pub scheme: Scheme,
}

impl Args<'_> {
    fn arg(&self, name: &str) -> &Arg {
        self.params.iter().position(|p| p.name == name).map_or(&Arg::Absent, |i| &self.values[i])
    }
    /// Whether `name` is written or defaulted.
    pub fn is_written(&self, name: &str) -> bool {
        *self.arg(name) != Arg::Absent
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
        (0..n).map(|i| self.nth(name, i)).collect()
    }
    /// Number `i` of the list `name`; one number stands for all.
    pub fn nth(&self, name: &str, i: usize) -> Option<f64> {
        match self.arg(name) {
            Arg::Absent | Arg::Cloud(_) => None,
            Arg::Num(v) => Some(*v),
            Arg::List(l) => l.get(i).copied(),
        }
    }
    /// What the file `name` holds.
    pub fn cloud(&self, name: &str) -> Option<&Cloud> {
        match self.arg(name) {
            Arg::Cloud(c) => Some(c),
            _ => None,
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

/// A kind that expands.
#[derive(Clone, Copy)]
pub struct Generator {
    /// in how many dimensions it can be built, e.g. `&[1]` for what lives on a line
    pub dims: &'static [u8],
    /// the numbers its modules use, from its parameters, behind those of a list; called at load and at live changes,
    /// which reuse the list
    pub derive: fn(&Args<'_>, &mut Vec<Option<f64>>) -> Result<(), Problem>,
    /// names and connects the modules, or says why they cannot be; called once, so whatever no live change can alter is
    /// refused here
    pub build: fn(&Args<'_>, &mut Builder<'_>) -> Result<(), Problem>,
}

impl Generator {
    /// The numbers its modules use, as a list of their own.
    ///
    /// # Errors
    /// Where the parameters do not go together.
    pub fn derived(&self, args: &Args<'_>) -> Result<Vec<Option<f64>>, Problem> {
        let mut slots = Vec::new();
        (self.derive)(args, &mut slots)?;
        Ok(slots)
    }
}

/// What a MAT is; numbers are slots of the derived list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Built {
    /// a mass of slot 0, damped to ground by slot 1 where that holds something
    Mass(u32, u32),
    /// a cell of mass, frequency and decay slots
    Cell(u32, u32, u32),
    /// a fixed point in the place of a mass
    Fixed,
    /// a fixed point beyond the end, `name.end[i]`
    Anchor,
}

/// A link: ends, stiffness slot, viscosity slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkSpec {
    /// first and second end, by number of the MAT
    pub ends: [u32; 2],
    /// slot of the stiffness
    pub k: u32,
    /// slot of the viscosity; one that does not exist means none
    pub z: u32,
    /// rest length \[m\]; slack where its ends are at rest if `None`
    pub l0: Option<f64>,
}

/// What a generator makes, before it has names and kinds.
pub struct Builder<'a> {
    slots: &'a [Option<f64>],
    live: bool,
    /// MATs with the index they are called by, in order
    pub mats: Vec<(Built, Index)>,
    /// links, in order
    pub links: Vec<LinkSpec>,
    /// rest positions of the MATs, from that of the item \[m\]; none on a line
    pub places: Vec<[f64; 3]>,
    /// initial velocities of the MATs \[m/s\]; none where all are at rest
    pub speeds: Vec<[f64; 3]>,
    /// nodes a moving point may stand between
    pub nodes: Vec<u32>,
    /// their arrangement, `[n, 1]` in a row
    pub size: [u32; 2],
    /// the string of waves whose junctions the MATs are, if they are
    pub line: Option<WaveguideSpec>,
}

impl<'a> Builder<'a> {
    /// Nothing yet, over the derived numbers; `live` where they may change while playing.
    pub fn new(slots: &'a [Option<f64>], live: bool) -> Builder<'a> {
        Builder {
            slots,
            live,
            mats: Vec::new(),
            links: Vec::new(),
            places: Vec::new(),
            speeds: Vec::new(),
            nodes: Vec::new(),
            size: [0, 1],
            line: None,
        }
    }

    /// True where slot `i` is nothing and stays so.
    pub fn nothing(&self, i: u32) -> bool {
        self.slots.get(i as usize).is_none_or(|v| !self.live && v.unwrap_or(0.0) == 0.0)
    }

    fn mat(&mut self, what: Built, index: Index) -> u32 {
        self.mats.push((what, index));
        self.mats.len() as u32 - 1
    }

    /// Adds a mass `name[index]` of mass slot `m`, damped to ground by slot `z`.
    pub fn mass(&mut self, index: impl Into<Index>, m: u32, z: u32) -> u32 {
        self.mat(Built::Mass(m, z), index.into())
    }

    /// Adds a cell `name[index]` of mass slot `m`, frequency slot `f`, decay slot `t60`.
    pub fn cell(&mut self, index: impl Into<Index>, m: u32, f: u32, t60: u32) -> u32 {
        self.mat(Built::Cell(m, f, t60), index.into())
    }

    /// Adds a fixed point `name[index]` where a mass would be.
    pub fn fixed(&mut self, index: impl Into<Index>) -> u32 {
        self.mat(Built::Fixed, index.into())
    }

    /// Adds a fixed point `name.end[i]`.
    pub fn anchor(&mut self) -> u32 {
        self.mat(Built::Anchor, Index::None)
    }

    /// Adds a link `name.link[i]` of stiffness slot `k` and viscosity slot `z`.
    pub fn link(&mut self, a: u32, b: u32, k: u32, z: u32) {
        self.links.push(LinkSpec { ends: [a, b], k, z, l0: None });
    }

    /// Adds a link of rest length `l0` \[m\].
    pub fn stretched(&mut self, a: u32, b: u32, k: u32, z: u32, l0: f64) {
        self.links.push(LinkSpec { ends: [a, b], k, z, l0: Some(l0) });
    }

    /// Declares the points a moving point `name@s` may stand between, as `size[0] × size[1]` nodes.
    pub fn set_path(&mut self, nodes: Vec<u32>, size: [u32; 2]) {
        self.nodes = nodes;
        self.size = size;
    }
}
