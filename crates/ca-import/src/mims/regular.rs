//! Finds strings, chains and meshes among single masses and plans to write each as one generator.
//!
//! Decides that only what a generator gives back exactly is taken: masses of one inertia, at rest at 0, held by links
//! of one stiffness and viscosity, written the same way (a named parameter and its value are not the same). Everything
//! else that touches a member stays, and is pointed at its new name, `low[133]`. Chains are found by structure alone.
//! Lattices are read from labels that end in two numbers and then verified link by link: finding a lattice without
//! labels is a search, and no published model needs it.

use super::chain;
use super::graph::Graph;
use super::lattice;
use super::names::Names;
use super::part::Part;
use super::plan::Plan;
use alloc::vec;

/// What may be written as generators.
pub(super) fn plan(parts: &[Part], names: &mut Names) -> Plan {
    let graph = Graph::new(parts);
    let mut plan = Plan { gone: vec![false; parts.len()], ..Plan::default() };
    lattice::meshes(&graph, names, &mut plan);
    chain::chains(&graph, names, &mut plan);
    plan
}
