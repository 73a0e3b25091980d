//! The builder: what a generator makes before the compiler assigns names and kinds.
//!
//! A generator knows neither the network nor the kinds of its modules. It adds masses, fixed points and links that
//! refer to derived numbers, and the compiler expands them. A live change calls the same function `derive`, so a string
//! retuned while playing equals the string that would have been compiled.

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
    /// not written, and without a default
    Absent,
    /// a number, the index of a choice, a flag as 0 or 1, or the index of a table
    Num(f64),
    /// list of numbers
    List(Vec<f64>),
    /// content of a file
    Cloud(Arc<Cloud>),
}

impl Arg {
    /// Returns the number, if it is one.
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
    /// code of the kind
    pub code: &'static str,
    /// parameters of the kind, with their names
    pub params: &'static [Param],
    /// values in the same order
    pub values: &'a [Arg],
    /// duration of a tick \[s\]
    pub tick_dt: f64,
    /// axes along which its MATs move
    pub dim: u8,
    /// scheme for the linear parts
    pub scheme: Scheme,
}

impl Args<'_> {
    fn arg(&self, name: &str) -> &Arg {
        self.params.iter().position(|p| p.name == name).map_or(&Arg::Absent, |i| &self.values[i])
    }
    /// Returns true if `name` is written or has a default.
    pub fn is_written(&self, name: &str) -> bool {
        *self.arg(name) != Arg::Absent
    }
    /// Returns the number `name`, if it is written or has a default.
    pub fn num(&self, name: &str) -> Option<f64> {
        self.arg(name).num()
    }
    /// Returns the number `name`, or 0.
    pub fn or0(&self, name: &str) -> f64 {
        self.num(name).unwrap_or(0.0)
    }
    /// Returns the count `name`, or 0.
    pub fn count(&self, name: &str) -> usize {
        self.or0(name) as usize
    }
    /// Returns `n` numbers of `name`; a single number is repeated.
    pub fn list(&self, name: &str, n: usize) -> Vec<Option<f64>> {
        (0..n).map(|i| self.nth(name, i)).collect()
    }
    /// Returns number `i` of the list `name`; a single number is the same for all.
    pub fn nth(&self, name: &str, i: usize) -> Option<f64> {
        match self.arg(name) {
            Arg::Absent | Arg::Cloud(_) => None,
            Arg::Num(v) => Some(*v),
            Arg::List(l) => l.get(i).copied(),
        }
    }
    /// Returns the content of the file `name`.
    pub fn cloud(&self, name: &str) -> Option<&Cloud> {
        match self.arg(name) {
            Arg::Cloud(c) => Some(c),
            _ => None,
        }
    }
    /// Returns the length of the list `name`, or `None` for a single number or an absent parameter.
    pub fn len(&self, name: &str) -> Option<usize> {
        match self.arg(name) {
            Arg::List(l) => Some(l.len()),
            _ => None,
        }
    }
}

/// A kind that expands to many modules.
#[derive(Clone, Copy)]
pub struct Generator {
    /// dimensions in which it can be built, e.g. `&[1]` for a line only
    pub dims: &'static [u8],
    /// computes the numbers of its modules and appends them to a list; called at load and at live changes
    pub derive: fn(&Args<'_>, &mut Vec<Option<f64>>) -> Result<(), Problem>,
    /// names and connects the modules, or refuses; called once, so it checks everything that a live change cannot alter
    pub build: fn(&Args<'_>, &mut Builder<'_>) -> Result<(), Problem>,
}

impl Generator {
    /// Returns the numbers of its modules as a new list.
    ///
    /// # Errors
    /// If the parameters cannot be combined.
    pub fn derived(&self, args: &Args<'_>) -> Result<Vec<Option<f64>>, Problem> {
        let mut slots = Vec::new();
        (self.derive)(args, &mut slots)?;
        Ok(slots)
    }
}

/// Type of a MAT. The numbers are slots of the derived list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Built {
    /// a mass with the mass in slot 0, damped to ground by slot 1 if that is used
    Mass(u32, u32),
    /// a cell with mass, frequency and decay time in these slots
    Cell(u32, u32, u32),
    /// a fixed point in place of a mass
    Fixed,
    /// a fixed point beyond an end, `name.end[i]`
    Anchor,
}

/// A link: ends, stiffness slot, viscosity slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkSpec {
    /// first and second end, by index of the MAT
    pub ends: [u32; 2],
    /// slot of the stiffness
    pub k: u32,
    /// slot of the viscosity; a slot that does not exist means no viscosity
    pub z: u32,
    /// rest length \[m\]; `None` means slack with the ends at rest
    pub l0: Option<f64>,
}

/// The modules that a generator makes, before they have names and kinds.
pub struct Builder<'a> {
    slots: &'a [Option<f64>],
    live: bool,
    /// MATs with their indices, in order
    pub mats: Vec<(Built, Index)>,
    /// links, in order
    pub links: Vec<LinkSpec>,
    /// rest positions of the MATs relative to the item \[m\]; empty on a line
    pub places: Vec<[f64; 3]>,
    /// initial velocities of the MATs \[m/s\]; empty if all are at rest
    pub speeds: Vec<[f64; 3]>,
    /// nodes between which a moving point may be
    pub nodes: Vec<u32>,
    /// arrangement of these nodes, `[n, 1]` in a row
    pub size: [u32; 2],
    /// the waveguide whose junctions the MATs are, if any
    pub line: Option<WaveguideSpec>,
}

impl<'a> Builder<'a> {
    /// Makes an empty builder over the derived numbers. `live` is true if they may change while the scene plays.
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

    /// Returns true if slot `i` is zero and stays so.
    pub fn nothing(&self, i: u32) -> bool {
        self.slots.get(i as usize).is_none_or(|v| !self.live && v.unwrap_or(0.0) == 0.0)
    }

    fn mat(&mut self, what: Built, index: Index) -> u32 {
        self.mats.push((what, index));
        self.mats.len() as u32 - 1
    }

    /// Adds a mass `name[index]` with the mass in slot `m`, damped to ground by slot `z`.
    pub fn mass(&mut self, index: impl Into<Index>, m: u32, z: u32) -> u32 {
        self.mat(Built::Mass(m, z), index.into())
    }

    /// Adds a cell `name[index]` with mass, frequency and decay time in the slots `m`, `f` and `t60`.
    pub fn cell(&mut self, index: impl Into<Index>, m: u32, f: u32, t60: u32) -> u32 {
        self.mat(Built::Cell(m, f, t60), index.into())
    }

    /// Adds a fixed point `name[index]` in place of a mass.
    pub fn fixed(&mut self, index: impl Into<Index>) -> u32 {
        self.mat(Built::Fixed, index.into())
    }

    /// Adds a fixed point `name.end[i]`.
    pub fn anchor(&mut self) -> u32 {
        self.mat(Built::Anchor, Index::None)
    }

    /// Adds a link `name.link[i]` with stiffness slot `k` and viscosity slot `z`.
    pub fn link(&mut self, a: u32, b: u32, k: u32, z: u32) {
        self.links.push(LinkSpec { ends: [a, b], k, z, l0: None });
    }

    /// Adds a link with the rest length `l0` \[m\].
    pub fn stretched(&mut self, a: u32, b: u32, k: u32, z: u32, l0: f64) {
        self.links.push(LinkSpec { ends: [a, b], k, z, l0: Some(l0) });
    }

    /// Declares the nodes of a moving point `name@s`, as `size[0] × size[1]` nodes.
    pub fn set_path(&mut self, nodes: Vec<u32>, size: [u32; 2]) {
        self.nodes = nodes;
        self.size = size;
    }
}
