//! The parts as a graph, for the search for rows and lattices.
//!
//! Regular parts are a mass at rest at 0 without gravity, a ground at 0, and a linear spring without a rest length. Two
//! laws are equal only if they are written the same way.

use super::part::{Arg, Part};
use alloc::collections::BTreeSet;
use alloc::vec;
use alloc::vec::Vec;

/// Stiffness and viscosity of a link, as written; RES has only the first.
pub(super) type Law = (Arg, Option<Arg>);
pub(super) type LawKey = ((u8, u64), Option<(u8, u64)>);

pub(super) struct Graph<'p> {
    pub parts: &'p [Part],
    /// Links at each part.
    pub links: Vec<Vec<usize>>,
    /// Parts whose force is an output; these must keep all their links.
    pub weighed: BTreeSet<usize>,
}

impl<'p> Graph<'p> {
    pub fn new(parts: &'p [Part]) -> Graph<'p> {
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

    /// Returns the inertia of a mass at rest at 0 without gravity.
    pub fn mass(&self, part: usize) -> Option<Arg> {
        match (&self.parts[part], &self.parts[part].args[..]) {
            (Part { kind: "MAS", group: None, .. }, &[("m", m)]) => Some(m),
            _ => None,
        }
    }

    pub fn is_ground(&self, part: usize) -> bool {
        self.parts[part].kind == "SOL" && self.parts[part].args.is_empty()
    }

    /// Returns the law of a linear spring without a rest length.
    pub fn law(&self, link: usize) -> Option<Law> {
        match (self.parts[link].kind, &self.parts[link].args[..]) {
            ("RES", &[("k", k)]) => Some((k, None)),
            ("REF", &[("k", k), ("z", z)]) => Some((k, Some(z))),
            _ => None,
        }
    }

    /// Returns the end of `link` that is not `part`.
    pub fn other_end(&self, link: usize, part: usize) -> usize {
        match self.parts[link].ends[..] {
            [a, b] => a + b - part,
            _ => part,
        }
    }
}

pub(super) fn key(law: Law) -> LawKey {
    (law.0.key(), law.1.map(Arg::key))
}

/// Returns the arguments that all generators share.
pub(super) fn medium(m: Arg, law: Law) -> [(&'static str, Arg); 3] {
    [("m", m), ("k", law.0), ("z", law.1.unwrap_or(Arg::Num(0.0)))]
}
