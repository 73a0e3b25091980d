//! `[preset]`: values of live parameters, chosen together by a name.
//!
//! A value is read as the `value` of its parameter: in its unit, within its range.

use crate::findings::{range_help, wrong_unit};
use crate::lower::params;
use crate::lower::parsed_param::{ParsedParam, Raw};
use crate::net::Resolved;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::LiveParam;
use ca_core::internal::kind::alg_to_si;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;
use ca_model::suggest::nearest;
use ca_model::{Entry, Model, Value, quantity};

/// Maximum number of values of all presets together.
const MOST: usize = 100_000;

/// Reads all presets. `alg` is the tick \[s\] of models in `alg` units.
pub fn presets(model: &Model, net: &mut Resolved, alg: Option<f64>, named: &[ParsedParam], diags: &mut Diags) {
    let mut spent = 0;
    for preset in &model.presets {
        let Value::Table(entries) = &preset.value else { continue };
        spent += entries.len();
        if spent > MOST {
            let d = Diag::error("E027", format!("the presets have more than {MOST} values"));
            diags.push(d.at(preset.key_span, "with this one").help("leave out what a preset does not change"));
            return;
        }
        if entries.is_empty() {
            let d = Diag::error("E005", format!("preset `{}` sets nothing", preset.key)).at(preset.key_span, "empty");
            diags.push(d.help("write below it a live parameter and its value, e.g. `k = \"8 kN/m\"`"));
        }
        let mut values: Vec<(String, f64)> = Vec::new();
        for e in entries {
            let declared = model.params.iter().find(|p| p.key == e.key);
            let live = net.params.iter().position(|p| p.name == e.key);
            let (Some(declared), Some(live)) = (declared, live) else {
                sets_nothing(preset, e, net, named, diags);
                continue;
            };
            if net.driven.iter().any(|d| d.param == live) {
                let d = Diag::error("E021", format!("preset `{}` sets `{}`, which a port drives", preset.key, e.key));
                diags.push(d.at(e.key_span, "driven by a port").help("leave it out"));
                continue;
            }
            values.extend(value(preset, e, declared, &net.params[live], alg, diags).map(|v| (e.key.clone(), v)));
        }
        net.presets.push((preset.key.clone(), values));
    }
}

/// The value of a parameter in a preset, or nothing where it has been reported.
fn value(
    preset: &Entry,
    e: &Entry,
    declared: &Entry,
    live: &LiveParam,
    alg: Option<f64>,
    diags: &mut Diags,
) -> Option<f64> {
    let what = format!("`{}` of preset `{}`", e.key, preset.key);
    let as_declared = params::raw_value(declared, &what, &mut Diags::new())?;
    let mut changed = declared.clone();
    changed.set_value(e.value.clone(), e.span);
    let raw = params::raw_value(&changed, &what, diags)?;
    let v = match (raw, as_declared) {
        (Raw::Quantity(q), _) if q.has_unit && !q.dim.same(live.unit.dim) => {
            let d = wrong_unit(&what, live.unit.symbol, &quantity::unit_of(q.dim), e.span);
            diags.push(d.at(declared.key_span, "the parameter").help("write it in the unit of the parameter"));
            return None;
        }
        (Raw::Quantity(q), Raw::Bare(_)) if q.has_unit => {
            q.value / alg.map_or(1.0, |tick| alg_to_si(live.unit.dim, tick))
        }
        (raw, _) => raw.number(),
    };
    if !(v >= live.min && v <= live.max) {
        let d = Diag::error("E009", format!("{what} is out of range: {}", Plain(v))).at(e.span, "out of range");
        diags.push(d.help(range_help(live.min, live.max, |v| format!("{}", Plain(v)))));
        return None;
    }
    Some(v)
}

fn sets_nothing(preset: &Entry, e: &Entry, net: &Resolved, named: &[ParsedParam], diags: &mut Diags) {
    let of = named.iter().find(|n| n.name == e.key);
    if of.is_some_and(|n| n.value.is_none()) {
        return; // reported where it is declared
    }
    let d = Diag::error("E021", format!("preset `{}` sets `{}`, which is not a live parameter", preset.key, e.key));
    let d = d.at(e.key_span, "not a live parameter");
    let live = || net.params.iter().map(|p| p.name.as_str());
    diags.push(match (of, nearest(&e.key, live())) {
        (Some(n), _) => {
            let d = d.at(n.span, "declared here, not live");
            d.help(format!("declare it as `{} = {{ value = …, live = true }}`", e.key))
        }
        (None, Some(near)) => {
            let new = if near.contains('.') { format!("\"{near}\"") } else { near.into() };
            d.help(format!("did you mean `{near}`?")).fix(e.key_span, new)
        }
        (None, None) if net.params.is_empty() => {
            d.help("a preset sets parameters that `[param]` declares with `live = true`; the model has none")
        }
        (None, None) => {
            let all: Vec<String> = live().take(12).map(|n| format!("`{n}`")).collect();
            d.help(format!("the live parameters are {}", all.join(", ")))
        }
    });
}
