//! What is at hand while names become modules: the model, the network so far, the moving points met.

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
    /// names that outputs and probes hear
    pub heard: BTreeSet<String>,
    /// moving points by their text
    pub points: BTreeMap<String, u32>,
    /// names of modules that are there but could not be read or made; that has been reported
    pub broken: BTreeSet<&'a str>,
    /// whether it has been said that there are more links than a model holds
    pub over: bool,
    /// nodes under all moving points, and under the moving points of all links
    pub under: usize,
}

/// Names that stand in the model, but not in the network, in full and without their group.
pub(super) fn broken<'a>(model: &'a Model, net: &Resolved) -> BTreeSet<&'a str> {
    let last = |name: &'a str| name.rsplit('.').next().unwrap_or(name);
    let mut all: BTreeSet<&str> = model.lost.iter().flat_map(|l| [l.as_str(), last(l)]).collect();
    if net.items.len() < model.items.len() {
        let made: BTreeSet<&str> = net.items.iter().map(|i| &*i.name).collect();
        all.extend(model.items.iter().map(|i| i.name.as_str()).filter(|n| !made.contains(n)));
    }
    all
}
