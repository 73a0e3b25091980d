//! Finds strings, chains and meshes among single masses and plans to write each as one generator.
//!
//! Decides that only what a generator gives back exactly is taken: masses of one inertia, at rest at 0, held by links
//! of one stiffness and viscosity, written the same way (a named parameter and its value are not the same). Everything
//! else that touches a member stays, and is pointed at its new name, `low[133]`. Chains are found by structure alone.
//! Lattices are read from labels that end in two numbers and then verified link by link: finding a lattice without
//! labels is a search, and no published model needs it.

use super::chain;
use super::lattice;
use super::names::Names;
use super::net::{Arg, Part};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

/// A generator in the place of many parts.
#[derive(Clone, Debug)]
pub(super) struct Generator {
    pub kind: &'static str,
    pub name: String,
    pub args: Vec<(&'static str, Arg)>,
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

/// Stiffness and viscosity of a link, as written; no viscosity for RES.
pub(super) type Law = (Arg, Option<Arg>);
/// The same, ordered.
pub(super) type LawKey = ((u8, u64), Option<(u8, u64)>);

/// The parts, seen as a graph.
pub(super) struct Graph<'p> {
    pub parts: &'p [Part],
    /// links that hold on to each part
    pub links: Vec<Vec<usize>>,
    /// parts whose force is heard; they must keep all their links
    pub weighed: BTreeSet<usize>,
}

impl<'p> Graph<'p> {
    fn new(parts: &'p [Part]) -> Graph<'p> {
        let mut links = vec![Vec::new(); parts.len()];
        for (i, part) in parts.iter().enumerate() {
            if let [a, b] = part.ends[..] {
                links[a].push(i);
                links[b].push(i);
            }
        }
        let weighed = parts.iter().filter(|p| p.kind == "SOF").flat_map(|p| p.ends.iter().copied()).collect();
        Graph { parts, links, weighed }
    }

    /// The inertia of a mass at rest at 0 under no gravity.
    pub fn mass(&self, part: usize) -> Option<Arg> {
        match (&self.parts[part], &self.parts[part].args[..]) {
            (Part { kind: "MAS", group: None, .. }, &[("m", m)]) => Some(m),
            _ => None,
        }
    }

    /// Whether it is a ground at 0.
    pub fn is_ground(&self, part: usize) -> bool {
        self.parts[part].kind == "SOL" && self.parts[part].args.is_empty()
    }

    /// The law of a linear spring without a rest length.
    pub fn law(&self, link: usize) -> Option<Law> {
        match (self.parts[link].kind, &self.parts[link].args[..]) {
            ("RES", &[("k", k)]) => Some((k, None)),
            ("REF", &[("k", k), ("z", z)]) => Some((k, Some(z))),
            _ => None,
        }
    }

    /// The end of `link` that is not `part`.
    pub fn other_end(&self, link: usize, part: usize) -> usize {
        match self.parts[link].ends[..] {
            [a, b] => a + b - part,
            _ => part,
        }
    }
}

/// A law as a key to group by.
pub(super) fn key(law: Law) -> LawKey {
    (law.0.key(), law.1.map(Arg::key))
}

/// What may be written as generators.
pub(super) fn plan(parts: &[Part], names: &mut Names) -> Plan {
    let graph = Graph::new(parts);
    let mut plan = Plan { gone: vec![false; parts.len()], ..Plan::default() };
    lattice::meshes(&graph, names, &mut plan);
    chain::chains(&graph, names, &mut plan);
    plan
}

/// The arguments all generators share.
pub(super) fn medium(m: Arg, law: Law) -> [(&'static str, Arg); 3] {
    [("m", m), ("k", law.0), ("z", law.1.unwrap_or(Arg::Num(0.0)))]
}
