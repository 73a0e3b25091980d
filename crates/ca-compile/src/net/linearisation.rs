//! Linear coefficients of modules for small motions at load: slopes of links, mobility and own stiffness of MATs.

use crate::net::{LiaNode, MatNode, MatRole, Resolved};
use alloc::vec::Vec;
use ca_core::Bound;
use ca_core::internal::live::Loader;
use ca_core::internal::op::loaded;
use ca_core::internal::tuning::Scheme;

/// Coefficients of a MAT in the linear network.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Own {
    /// Mobility T²/m \[m/N\]; 0 for a MAT that does not move.
    pub c: f64,
    /// Stiffness to ground \[N/m\].
    pub k: f64,
    /// Viscosity to ground \[N per m/tick\].
    pub z: f64,
    /// Inertia of an implicit cell beyond its mass \[N per m/tick²\].
    pub implicit: f64,
}

/// Returns the coefficients of a MAT at load. For a cell tuned in a modal group they describe the mode itself, while
/// the stored ones give the explicit scheme the same pitch.
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

/// Returns the coefficients of a MAT at load as stored in the scene.
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

/// Returns pitch \[Hz\] and decay time \[s\] of a cell that is given by them.
fn pitch(m: &MatNode, values: &[Option<f64>]) -> Option<(f64, f64)> {
    let cell = &ca_core::internal::mat::CEL;
    let at = |name: &str| values.get(cell.param(name)?).copied().flatten();
    let f = at("f").filter(|_| m.code == cell.code)?;
    Some((f, at("t60").unwrap_or(f64::INFINITY)))
}

/// Returns the slopes of a link at load.
pub fn slopes(net: &Resolved, l: &LiaNode) -> Bound {
    (l.law.at_load.bound)(&loaded(l.law, &net.values(l.item, &l.values), net.tick_dt), &net.tables)
}
