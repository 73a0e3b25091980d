//! The plan: which parts become generators, and under what names the rest finds them.

use super::part::Arg;
use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

/// A generator in the place of many parts.
#[derive(Clone, Debug)]
pub(super) struct Generator {
    pub kind: &'static str,
    pub name: String,
    pub args: Vec<(&'static str, Arg)>,
    /// nodes of a mesh that are held besides its edges
    pub fixed: Vec<[usize; 2]>,
    /// the part it stands in the place of: its first mass (its grounds may be others' too)
    pub at: usize,
    /// first and last of the members, for the header
    pub members: (usize, usize),
}

/// What becomes of the parts.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    pub generators: Vec<Generator>,
    /// new names of parts that are now inside a generator
    pub names: BTreeMap<usize, String>,
    /// per part: whether a generator makes it
    pub gone: Vec<bool>,
}
