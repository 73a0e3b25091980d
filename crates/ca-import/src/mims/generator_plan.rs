//! The generators to write, and the names by which other parts refer to their members.

use super::part::Arg;
use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

#[derive(Clone, Debug)]
pub(super) struct Generator {
    pub kind: &'static str,
    pub name: String,
    pub args: Vec<(&'static str, Arg)>,
    /// Nodes of a mesh that are held besides its edges.
    pub fixed: Vec<[usize; 2]>,
    /// Part whose place in the order it takes: its first mass, since its grounds may be shared.
    pub at: usize,
    /// First and last member, for the header.
    pub members: (usize, usize),
}

#[derive(Clone, Debug, Default)]
pub(super) struct GeneratorPlan {
    pub generators: Vec<Generator>,
    /// New names of parts that are now inside a generator.
    pub names: BTreeMap<usize, String>,
    /// True for each part that a generator makes.
    pub gone: Vec<bool>,
}
