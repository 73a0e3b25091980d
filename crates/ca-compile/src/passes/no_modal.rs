//! Replacement of `modal` for builds without the feature `analysis`, which cannot compute modes.

use crate::net::Pruned;
use alloc::format;
use ca_core::internal::tuning::Method;
use ca_model::Model;
use ca_model::diag::{Diag, Diags};

/// Reports an error for each modal group.
pub fn modal(model: &Model, net: &mut Pruned, diags: &mut Diags) {
    for (i, _) in net.media.iter().enumerate().filter(|(_, m)| m.method == Method::Modal) {
        let name = model.groups.get(i).map_or_else(|| "the model".into(), |g| format!("`{}`", g.name));
        let d = Diag::error("E028", format!("{name} has `method = \"modal\"`, but this build cannot compute modes"));
        diags.push(d.help("build with the feature `analysis`, or use `method = \"ca\"`"));
    }
}
