//! What is at hand while names become modules: the model, the network so far, the moving points met.

use super::net::Net;
use crate::model::Model;
use crate::model::diag::Diags;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::string::String;

/// A network being wired.
pub(super) struct Wiring<'a> {
    pub model: &'a Model,
    pub net: Net,
    pub diags: &'a mut Diags,
    /// names that outputs and probes hear
    pub heard: BTreeSet<String>,
    /// moving points by their text
    pub points: BTreeMap<String, u32>,
    /// nodes under all moving points, and under the moving points of all links
    pub under: usize,
}
