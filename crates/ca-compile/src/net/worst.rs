//! Worst-case numbers of each mass and each link over the ranges of all live parameters it follows.

use crate::net::{MatNode, MatRole, Resolved};
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Arg, Args};
use ca_core::internal::live::{Loader, Source};
use ca_core::internal::op::loaded;
use ca_core::{Bound, Role};

/// Worst-case numbers of a MAT; all 0 for a fixed one.
#[derive(Clone, Copy, Default)]
pub struct WorstMat {
    /// Mobility T²/m \[m/N\].
    pub c: f64,
    /// Own stiffness of a CEL \[N/m\].
    pub k: f64,
    /// Own viscosity plus the viscosity of its medium \[N per m/tick\].
    pub z: f64,
}

/// Returns the worst case of each MAT. Consecutive MATs with equal values share the result: generators make thousands
/// of them, and each corner may solve for a pitch.
pub fn worst_mats(net: &Resolved) -> Vec<WorstMat> {
    let mut last: Option<(&MatNode, WorstMat)> = None;
    let mut rows = Vec::with_capacity(net.mats.len());
    for m in &net.mats {
        let same = last.as_ref().filter(|(o, _)| {
            o.item == m.item && o.code == m.code && (Arc::ptr_eq(&o.values, &m.values) || o.values[..] == m.values[..])
        });
        let r = same.map_or_else(|| worst_mat(net, m), |s| s.1);
        rows.push(r);
        last = Some((m, r));
    }
    rows
}

fn worst_mat(net: &Resolved, m: &MatNode) -> WorstMat {
    let MatRole::Mat(spec) = m.role else { return WorstMat::default() };
    let mut out = Vec::new();
    let (mut k, mut z, mut c): (f64, f64, f64) = (0.0, 0.0, 0.0);
    // Worst of all corners: lightest, stiffest, most damped.
    for values in corners(net, m.item, &m.values) {
        Loader::Mat(spec, net.medium(m).friction).load(&values, net.tick_dt, &mut out);
        if out[2] != 0.0 {
            (k, z, c) = (k.max(-out[1] / out[2]), z.max((1.0 - out[0]) / out[2]), c.max(out[2]));
        }
    }
    if c == 0.0 || spec.fixed {
        return WorstMat::default();
    }
    WorstMat { c, k, z }
}

/// Returns the parameter values of a module at load and at every corner of the ranges of its live parameters.
fn corners(net: &Resolved, item: u32, values: &[Source]) -> Vec<Vec<Option<f64>>> {
    let it = &net.items[item as usize];
    let mut all = alloc::vec![net.values(item, values)];
    let mut live: Vec<usize> = it.follows.iter().map(|f| f.1).collect();
    live.sort_unstable();
    live.dedup();
    if live.is_empty() {
        return all;
    }
    // At most 2^16 corners; no kind has that many parameters.
    for corner in 0_u32..1 << live.len().min(16) {
        let mut args = it.args.clone();
        for (arg, p, factor) in &it.follows {
            let param = &net.params[*p];
            let high = live.iter().position(|l| l == p).is_some_and(|k| corner >> k & 1 == 1);
            let v = if high { param.max } else { param.min };
            args[*arg] = Arg::Num((v * factor).clamp(-1e30, 1e30));
        }
        let slots = match it.kind.role {
            Role::Generator(g) => {
                match g.derived(&Args {
                    code: it.kind.code,
                    params: it.kind.params,
                    values: &args,
                    tick_dt: net.tick_dt,
                    dim: it.dim,
                    scheme: net.scheme(it.group),
                }) {
                    Ok(s) => s,
                    // Out of reach of the generator: a change to this corner is refused while playing.
                    Err(_) => continue,
                }
            }
            _ => args.iter().map(Arg::num).collect(),
        };
        all.push(values.iter().map(|s| s.get(&slots)).collect());
    }
    all
}

/// Returns the worst-case bound of each link.
pub fn worst_bounds(net: &Resolved) -> Vec<Bound> {
    let mut last: Option<(u32, Arc<[Source]>, Bound)> = None;
    let mut bounds = Vec::with_capacity(net.lias.len());
    for l in &net.lias {
        if let Some((item, values, b)) = &last {
            if *item == l.item && values[..] == l.values[..] {
                bounds.push(*b);
                continue;
            }
        }
        let mut worst = Bound::default();
        for (i, values) in corners(net, l.item, &l.values).into_iter().enumerate() {
            let b = (l.law.at_load.bound)(&loaded(l.law, &values, net.tick_dt), &net.tables);
            // k − lift is what counts; its largest value need not be at the largest k.
            let most = (worst.k - worst.lift).max(b.k - b.lift);
            let k = worst.k.max(b.k);
            let power = if b.power.0 > worst.power.0 { b.power } else { worst.power };
            worst = if i == 0 { b } else { Bound { k, z: worst.z.max(b.z), lift: k - most, power, ..b } };
        }
        last = Some((l.item, l.values.clone(), worst));
        bounds.push(worst);
    }
    bounds
}
