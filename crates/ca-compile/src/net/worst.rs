//! The worst of what may change: for each mass and each link, its numbers at the ends of the ranges of all live
//! parameters it follows.

use crate::net::{MatNode, MatRole, Resolved};
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Arg, Args};
use ca_core::internal::live::{Loader, Source};
use ca_core::internal::op::loaded;
use ca_core::{Bound, Role};

/// A MAT at the worst corner of what may change; nothing of what is fixed.
#[derive(Clone, Copy, Default)]
pub struct WorstMat {
    /// mobility T²/m \[m/N\]
    pub c: f64,
    /// stiffness of its own \[N/m\], as of a CEL
    pub k: f64,
    /// viscosity of its own and of its medium \[N per m/tick\]
    pub z: f64,
}

/// Each MAT; generators make thousands with the same values, and each corner may solve for a pitch.
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
    // worst corner of what may change: lightest, stiffest, most damped
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

/// The parameter values of a module at load and at every corner of the ranges of the live parameters it follows.
fn corners(net: &Resolved, item: u32, values: &[Source]) -> Vec<Vec<Option<f64>>> {
    let it = &net.items[item as usize];
    let mut all = alloc::vec![net.values(item, values)];
    let mut live: Vec<usize> = it.follows.iter().map(|f| f.1).collect();
    live.sort_unstable();
    live.dedup();
    if live.is_empty() {
        return all;
    }
    // no kind has so many parameters that this were a number to fear
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
                    // out of reach, so a change to it is refused
                    Err(_) => continue,
                }
            }
            _ => args.iter().map(Arg::num).collect(),
        };
        all.push(values.iter().map(|s| s.get(&slots)).collect());
    }
    all
}

/// The bound of each link, at the worst corner of what may change.
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
            // what counts is k − lift, whose worst is not that of k
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
