//! The parts as a graph: what a search for rows and lattices asks of them.
//!
//! Decides what counts as regular: a mass at rest at 0 under no gravity, a ground at 0, a linear spring without a rest
//! length. Two laws are one only if they are written the same way.

use super::part::{Arg, Part};
use alloc::collections::BTreeSet;
use alloc::vec;
use alloc::vec::Vec;

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

/// The arguments all generators share.
pub(super) fn medium(m: Arg, law: Law) -> [(&'static str, Arg); 3] {
    [("m", m), ("k", law.0), ("z", law.1.unwrap_or(Arg::Num(0.0)))]
}
