//! Plans which strings, chains and meshes of single masses are written as generators.
//!
//! Only parts that a generator reproduces exactly are taken: masses of one inertia, at rest at 0, held by links of one
//! stiffness and viscosity, written the same way (a named parameter differs from its value). Other parts that touch a
//! member stay and refer to its new name, `low[133]`. Chains are found by structure alone, lattices by labels that end
//! in two numbers, then checked link by link: no published model needs a search for lattices without labels.

use super::chain;
use super::generator_plan::GeneratorPlan;
use super::graph::Graph;
use super::lattice;
use super::names::Names;
use super::part::Part;
use alloc::vec;

pub(super) fn plan(parts: &[Part], names: &mut Names) -> GeneratorPlan {
    let graph = Graph::new(parts);
    let mut plan = GeneratorPlan { gone: vec![false; parts.len()], ..GeneratorPlan::default() };
    lattice::meshes(&graph, names, &mut plan);
    chain::chains(&graph, names, &mut plan);
    plan
}
