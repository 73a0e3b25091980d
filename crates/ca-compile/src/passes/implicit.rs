//! Chooses the linear links and cells of the methods `centred` and `implicit`. Their matrix is in
//! `emit/methods/implicit.rs`.
//!
//! The method comes from the link, its group or the model, and is chosen before laws are specialised. A cell needs no
//! matrix: its spring and damper only add to its inertia ([`ca_core::internal::mat::cel`]). The pass refuses links
//! whose matrix would change from tick to tick (distances in space, quadripoles, moving points), and links that share a
//! mass with a link which is solved with the coming motion.

use crate::net::waveguides::WaveguideNode;
use crate::net::{End, LiaNode, Wired};
use crate::passes::auto::Refusals;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::sync::Arc;
use ca_core::internal::live::Source;
use ca_core::internal::phi::implicit;
use ca_core::internal::tuning::Method;
use ca_model::Model;
use ca_model::diag::Diags;

/// Sets the method of links and cells, as written for them, their group or the model.
pub fn choose(net: &mut Wired) {
    let asked = |net: &Wired, item: u32, kind: &ca_core::Kind, values: &[Source]| {
        let at = |name: &str| {
            let i = kind.param(name)?;
            values.get(i)?.get(&net.items[item as usize].slots)
        };
        let medium = net.medium_of(net.items[item as usize].group);
        at("method").map_or(medium.method, Method::of).theta(at("theta").or(medium.theta))
    };
    // Item, values as written, and values for the implicit law: most links of a generator share them.
    let mut last: Option<(u32, [Arc<[Source]>; 2])> = None;
    // The same for the previous explicit link, the most frequent case.
    let mut explicit: Option<(u32, Arc<[Source]>)> = None;
    for i in 0..net.lias.len() {
        let l = &net.lias[i];
        if explicit.as_ref().is_some_and(|(item, values)| *item == l.item && Arc::ptr_eq(values, &l.values)) {
            continue;
        }
        // Parameters of the law before specialisation; only these kinds have such a method.
        let (k, z) = match l.kind.code {
            "REF" => (Some(1), Some(2)),
            "RES" => (Some(1), None),
            "FRO" => (None, Some(1)),
            _ => continue,
        };
        let Some(theta) = asked(net, l.item, l.kind, &l.values) else {
            explicit = Some((l.item, l.values.clone()));
            continue;
        };
        // With θ = 0 and without viscosity the implicit link equals the explicit one.
        let z_of = z.and_then(|z| l.values.get(z)).copied().unwrap_or(Source::Absent);
        let live = matches!(z_of, Source::Slot(_)) && net.is_live(l.item);
        if theta == 0.0 && !live && z_of.get(&net.items[l.item as usize].slots).unwrap_or(0.0) == 0.0 {
            continue;
        }
        let known = last.as_ref().filter(|(item, [old, _])| *item == l.item && old[..] == l.values[..]);
        let values = known.map_or_else(
            || {
                let from = |p: Option<usize>| p.and_then(|p| l.values.get(p).copied()).unwrap_or(Source::Absent);
                Arc::from([from(k), from(z), Source::Const(theta)])
            },
            |(_, [_, new])| new.clone(),
        );
        last = Some((l.item, [l.values.clone(), values.clone()]));
        let l = &mut net.lias[i];
        (l.law, l.values) = (&implicit::LAW, values);
    }
    let cell = &ca_core::internal::mat::CEL;
    let Some((method, theta)) = cell.param("method").zip(cell.param("theta")) else { return };
    // A waveguide junction stays explicit: its damper represents the waves that leave it.
    let junctions: BTreeSet<u32> = net.lines.iter().flat_map(WaveguideNode::junctions).collect();
    for i in (0..net.mats.len()).filter(|i| !junctions.contains(&(*i as u32))) {
        let m = &net.mats[i];
        if m.code != cell.code {
            continue;
        }
        let Some(share) = asked(net, m.item, cell, &m.values) else { continue };
        let mut values = m.values.to_vec();
        // The method `implicit` with θ = 0 is `centred`.
        (values[method], values[theta]) = (Source::Const(2.0), Source::Const(share));
        net.mats[i].values = Arc::from(values);
    }
}

/// Returns whether some link or cell has θ = 1/12, for which the tick is of fourth order without viscosity.
pub fn is_fourth(net: &Wired) -> bool {
    let twelfth = |theta: Option<f64>| theta.is_some_and(|t| (t - 1.0 / 12.0).abs() < 1e-6);
    let links = net.lias.iter().filter(|l| l.law.implicit).filter_map(|l| l.values.get(2).map(|v| (l.item, *v)));
    let cell = &ca_core::internal::mat::CEL;
    let cells = net.mats.iter().filter(|m| m.code == cell.code && m.values.len() == cell.params.len());
    let theta = cell.param("theta").unwrap_or(0);
    let cells = cells.filter_map(|m| m.values.get(theta).map(|v| (m.item, *v)));
    links.chain(cells).any(|(item, theta)| twelfth(theta.get(&net.items[item as usize].slots)))
}

/// Refuses links whose matrix would change.
pub fn check(model: &Model, net: &mut Wired, diags: &mut Diags) {
    let mut refusals = Refusals::begin(model, net);
    let mut late: BTreeMap<u32, &LiaNode> = BTreeMap::new();
    for l in net.lias.iter().filter(|l| !l.law.stage.is_explicit()) {
        late.extend(l.all_ends().filter_map(|e| if let End::Mat(m) = e { Some((m, l)) } else { None }));
    }
    for l in net.lias.iter().filter(|l| l.law.implicit) {
        if refusals.knows(l.item) {
            continue;
        }
        let shared = l.all_ends().find_map(|e| match e {
            End::Mat(m) if !net.mats[m as usize].is_fixed() => late.get(&m).map(|late| (m, *late)),
            _ => None,
        });
        let point = l.all_ends().find(|e| matches!(e, End::Point(_)));
        let (title, label, help) = if l.is_radial() || l.onto.is_some() {
            let title = format!("`{}` is implicit, but measures a distance in space", l.name);
            (title, "not between points in space", "give it a direction with `along`, or use `method = \"ca\"`")
        } else if let Some(point) = point {
            let title = format!("`{}` is implicit at a moving point, `{}`", l.name, net.end_name(point));
            (title, "not at moving points", "use `method = \"ca\"`, or replace the point by a mass such as `low[8]`")
        } else if let Some((m, other)) = shared {
            let m = &net.mats[m as usize].name;
            if refusals.is_chosen(other.item) {
                let why = format!("`{}` is implicit and also acts on `{m}`", l.name);
                refusals.refuse(&net.items, other.item, (why, "", ""), diags);
                continue;
            }
            let title = format!("`{}` and `{}` are both implicit and both act on `{m}`", l.name, other.name);
            (title, "two kinds of implicit links at one mass", "use `method = \"ca\"` for one of them")
        } else {
            continue;
        };
        refusals.refuse(&net.items, l.item, (title, label, help), diags);
    }
    refusals.end(net);
}
