//! State of the step from names to modules: the model, the network so far, and the moving points so far.

use crate::net::{Resolved, Wired};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::string::String;
use ca_model::Model;
use ca_model::diag::Diags;

/// A network being wired.
pub(super) struct Wiring<'a> {
    pub model: &'a Model,
    pub net: Wired,
    pub diags: &'a mut Diags,
    /// Names that outputs and probes refer to.
    pub output_names: BTreeSet<String>,
    /// Moving points by their text.
    pub points: BTreeMap<String, u32>,
    /// Names of modules that could not be read or made, which was reported.
    pub broken: BTreeSet<&'a str>,
    /// True once too many links were reported.
    pub over: bool,
    /// Nodes under all moving points, and under the moving points of all links.
    pub under: usize,
}

/// Returns the names that are in the model but not in the network, in full and without their group.
pub(super) fn broken<'a>(model: &'a Model, net: &Resolved) -> BTreeSet<&'a str> {
    let last = |name: &'a str| name.rsplit('.').next().unwrap_or(name);
    let mut all: BTreeSet<&str> = model.lost.iter().flat_map(|l| [l.as_str(), last(l)]).collect();
    if net.items.len() < model.items.len() {
        let made: BTreeSet<&str> = net.items.iter().map(|i| &*i.name).collect();
        all.extend(model.items.iter().map(|i| i.name.as_str()).filter(|n| !made.contains(n)));
    }
    all
}
