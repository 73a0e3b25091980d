//! Tables of the coefficients that ports drive.
//!
//! A table has two rows if its coefficients are linear in the parameter, e.g. for stiffness, friction and gain, else
//! [`ROWS`]. Each coefficient follows one source only, a port or a live parameter, because a table cannot describe the
//! combined effect of two.

use crate::net::{NetDriven, Resolved};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::internal::live::{DrivenParam, LiveTable};
use ca_core::internal::op::driven::Driven;
use ca_core::{Controls, Patch};
use ca_model::diag::{Diag, Diags};

/// Rows of a table that is not linear: the error of a pitch over an octave is then below 0.01 cents.
const ROWS: usize = 257;
/// Largest deviation from a straight line, relative to the largest coefficient in the column.
const STRAIGHT: f64 = 1e-12;

/// Returns the tables of all driven parameters, and records their coefficients in `builder`.
pub fn tables(net: &Resolved, plan: &mut LiveTable, diags: &mut Diags) -> Vec<Driven> {
    if net.driven.is_empty() {
        return Vec::new();
    }
    let free = plan.clone();
    let reach: Vec<BTreeSet<u32>> = (0..free.params.len()).map(|p| reached(&free, net.tick_dt, p)).collect();
    let mut all = Vec::new();
    for d in &net.driven {
        let name = &plan.params[d.param].name;
        let places = &reach[d.param];
        if plan.implicit.as_ref().is_some_and(|i| places.iter().any(|p| *p >= i.first)) {
            let title = format!("parameter `{name}` is driven by a port, but changes implicit links");
            let help = "drive a parameter of explicit links, or remove `port` and write a `value`";
            diags.push(Diag::error("E025", title).at(d.at, "driven here").help(help));
            continue;
        }
        let other = (0..free.params.len()).find(|q| *q != d.param && !reach[*q].is_disjoint(places));
        if let Some(q) = other {
            let title = format!("parameters `{name}` and `{}` change the same coefficients", plan.params[q].name);
            let help = "a coefficient that a port drives can follow only one parameter: make the other one constant";
            diags.push(Diag::error("E025", title).at(d.at, "driven here").help(help));
            continue;
        }
        match table(&free, net.tick_dt, d, places) {
            Ok(driven) => {
                plan.driven_coefs.extend(places);
                all.push(driven);
            }
            Err(why) => {
                let d = Diag::error("E025", format!("parameter `{name}` cannot be driven: {why}"))
                    .at(d.at, "declared here");
                diags.push(d.help("choose `min` and `max` closer together"));
            }
        }
    }
    plan.driven_coefs.sort_unstable();
    taken_out(net, plan);
    all
}

/// Removes driven parameters from the live parameters.
fn taken_out(net: &Resolved, plan: &mut LiveTable) {
    let driven = |p: usize| net.driven.iter().find(|d| d.param == p);
    let mut number = 0;
    let mut renumber = Vec::new();
    for p in 0..plan.params.len() {
        renumber.push(driven(p).is_none().then_some(number));
        number += usize::from(driven(p).is_none());
    }
    for (p, param) in core::mem::take(&mut plan.params).into_iter().enumerate() {
        match driven(p) {
            None => plan.params.push(param),
            Some(d) => {
                let port = net.inputs[d.input as usize].name.clone();
                plan.driven.push(DrivenParam { param, port, span: d.span });
            }
        }
    }
    for item in &mut plan.items {
        item.follows.retain_mut(|f| renumber[f.1].map(|to| f.1 = to).is_some());
    }
}

/// Returns the coefficients at `rows` equidistant values of parameter `p`: their indices, then a row per value.
fn rows(controls: &mut Controls, p: usize, rows: usize) -> Result<(Vec<u32>, Vec<Vec<f64>>), String> {
    let (mut patch, mut all, mut places) = (Patch::default(), Vec::new(), Vec::new());
    let [min, max] = [controls.params()[p].min, controls.params()[p].max];
    for k in 0..rows {
        let part = k as f64 / (rows - 1) as f64;
        let v = if k + 1 == rows { max } else { min + part * (max - min) };
        controls.set_indexed(p, v, &mut patch).map_err(|e| format!("{e}"))?;
        all.push(patch.set.iter().map(|s| s.1).collect());
        let written: Vec<u32> = patch.set.iter().map(|s| s.0).collect();
        if k == 0 {
            places = written;
        } else if places != written {
            return Err(
                "a link is implicit at some of its values and explicit at others, and a port cannot drive an implicit \
                 link"
                    .into(),
            );
        }
    }
    Ok((places, all))
}

/// Returns the coefficients that parameter `p` changes; if its bounds cannot be compared, all that it writes.
fn reached(plan: &LiveTable, tick_dt: f64, p: usize) -> BTreeSet<u32> {
    let (mut controls, mut patch) = (Controls::new(plan, tick_dt), Patch::default());
    // Other parameters take values inside their range, since a factor of 0 at load would hide changes.
    for (q, param) in plan.params.iter().enumerate().filter(|(q, _)| *q != p) {
        let _ = controls.set_indexed(q, param.min + 0.37 * (param.max - param.min), &mut patch);
    }
    if let Ok((places, rows)) = rows(&mut controls, p, 5) {
        let changes = |j: &usize| rows.iter().any(|r| r[*j].to_bits() != rows[0][*j].to_bits());
        return (0..places.len()).filter(changes).map(|j| places[j]).collect();
    }
    let _ = controls.set_indexed(p, plan.params[p].value, &mut patch);
    patch.set.iter().map(|s| s.0).collect()
}

fn table(plan: &LiveTable, tick_dt: f64, d: &NetDriven, places: &BTreeSet<u32>) -> Result<Driven, String> {
    let (written, all) = rows(&mut Controls::new(plan, tick_dt), d.param, ROWS)?;
    let columns: Vec<usize> = (0..written.len()).filter(|j| places.contains(&written[*j])).collect();
    let last = ROWS - 1;
    let straight = columns.iter().all(|j| {
        let (a, b) = (all[0][*j], all[last][*j]);
        let largest = all.iter().map(|r| r[*j].abs()).fold(0.0, f64::max);
        let off = |(k, r): (usize, &Vec<f64>)| (r[*j] - (a + k as f64 / last as f64 * (b - a))).abs();
        all.iter().enumerate().map(off).fold(0.0, f64::max) <= STRAIGHT * largest
    });
    let kept: Vec<&Vec<f64>> = if straight { alloc::vec![&all[0], &all[last]] } else { all.iter().collect() };
    let table = kept.iter().flat_map(|r| columns.iter().map(|j| r[*j])).collect();
    let places = columns.iter().map(|j| written[*j]).collect();
    Ok(Driven { input: d.input, span: d.span, rows: kept.len(), places, table })
}
