//! What modules are at load to small motions: slopes of links, mobility and own stiffness of MATs.

use crate::net::{LiaNode, MatNode, MatRole, Resolved};
use alloc::vec::Vec;
use ca_core::Bound;
use ca_core::internal::live::Loader;
use ca_core::internal::op::loaded;
use ca_core::internal::tuning::Scheme;

/// What a MAT is to the linear network: mobility \[m/N\], own stiffness \[N/m\], own viscosity \[N per m/tick\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Own {
    /// T²/m; 0 for what does not move
    pub c: f64,
    /// stiffness to the ground
    pub k: f64,
    /// viscosity to the ground
    pub z: f64,
    /// inertia beyond its mass, of an implicit cell \[N per m/tick²\]
    pub implicit: f64,
}

/// A MAT at load: of a cell that is tuned in a modal group the mode itself, not what the explicit scheme needs to sound like it.
pub fn own(net: &Resolved, m: &MatNode) -> Own {
    let stored = stored(net, m);
    let tuned =
        pitch(m, &net.values(m.item, &m.values)).filter(|_| net.scheme(m.group) == Scheme::Modal && stored.c > 0.0);
    match tuned.and_then(|(f, t60)| Scheme::Modal.tuned(f, t60, net.tick_dt)) {
        Some((a, b)) => {
            Own { k: a / stored.c, z: b / stored.c + net.medium(m).friction / net.tick_dt, implicit: 0.0, ..stored }
        }
        None => stored,
    }
}

/// A MAT at load, as its coefficients have it.
pub fn stored(net: &Resolved, m: &MatNode) -> Own {
    let MatRole::Mat(spec) = m.role else { return Own::default() };
    let mut out = Vec::new();
    let mut values = net.values(m.item, &m.values);
    let loader = Loader::Mat(spec, net.medium(m).friction);
    loader.load(&values, net.tick_dt, &mut out);
    let c = if spec.fixed { 0.0 } else { out[2] };
    if c <= 0.0 {
        return Own::default();
    }
    let own = Own { c, k: -out[1] / c, z: (1.0 - out[0]) / c, implicit: 0.0 };
    let Some(method) =
        ca_core::internal::mat::CEL.param("method").filter(|_| m.code == ca_core::internal::mat::CEL.code)
    else {
        return own;
    };
    if values.get(method).copied().flatten().is_none() {
        return own;
    }
    values[method] = None;
    loader.load(&values, net.tick_dt, &mut out);
    Own { c: out[2], implicit: 1.0 / c - 1.0 / out[2], ..own }
}

/// Pitch \[Hz\] and decay time \[s\] of a cell that is given by them.
fn pitch(m: &MatNode, values: &[Option<f64>]) -> Option<(f64, f64)> {
    let cell = &ca_core::internal::mat::CEL;
    let at = |name: &str| values.get(cell.param(name)?).copied().flatten();
    let f = at("f").filter(|_| m.code == cell.code)?;
    Some((f, at("t60").unwrap_or(f64::INFINITY)))
}

/// The slopes of a link at load.
pub fn slopes(net: &Resolved, l: &LiaNode) -> Bound {
    (l.law.at_load.bound)(&loaded(l.law, &net.values(l.item, &l.values), net.tick_dt), &net.tables)
}
