//! PEFRL: checks whether a model can use the method ([`ca_core::internal::method::pefrl`]).
//!
//! The method applies to the whole model, since the inside of a tick cannot be mixed with other schemes. Refused are
//! laws that depend on motion (viscosity, friction) or have memory, implicit laws, ports that move, and modules tuned
//! to the pitch of another scheme. The force passes of the scene run again at each kick. Those at the beginning of the
//! tick serve outputs of forces.

use crate::net::worst::worst_mats;
use crate::net::{LiaNode, MatRole, Pruned};
use crate::options::Options;
use alloc::collections::BTreeSet;
use alloc::format;
use ca_core::internal::live::Source;
use ca_core::internal::tuning::Method;
use ca_model::diag::{Diag, Diags};
use ca_model::{Model, Span};

/// Refuses models that the method cannot compute.
pub fn check(model: &Model, net: &Pruned, options: &Options, diags: &mut Diags) {
    if !net.is_composed() {
        return;
    }
    if options.energy {
        let d = Diag::error("E028", "`method = \"pefrl\"` does not support the energy ledger");
        let at = model.meta("method").map_or(Span::NONE, |e| e.span);
        diags.push(d.at(at, "for the whole model").help("leave out the ledger, or use `method = \"ca\"`"));
    }
    for (g, _) in model.groups.iter().zip(&net.media).filter(|(_, m)| m.method != Method::Pefrl) {
        let title = format!("`{}` has another method, but `pefrl` applies to the whole model", g.name);
        let at = g.props.iter().find(|e| e.key == "method").map_or(Span::NONE, |e| e.span);
        diags.push(Diag::error("E028", title).at(at, "not with `pefrl`").help("remove one of the two methods"));
    }
    let rows = worst_mats(net);
    let mats = net.mats.iter().zip(&rows).zip(&net.alive).filter(|(_, alive)| **alive);
    let of_mats = mats.filter_map(|((m, row), _)| {
        let item = &net.items[m.item as usize];
        let tuned = item.kind.param("f").and_then(|f| item.slots.get(f)).is_some_and(Option::is_some);
        let why = if tuned {
            (format!("`{}` is tuned to the pitch of the explicit scheme", item.name), "write stiffness, not `f`")
        } else if let MatRole::Port(..) = m.role {
            (format!("`{}` is moved from outside", m.name), "push a mass with `[ENF]` instead")
        } else if row.z != 0.0 {
            (format!("`{}` is damped", m.name), "leave out its `z` or `t60`, and `friction` of the model")
        } else if crate::net::linearisation::own(net, m).implicit != 0.0 {
            (format!("`{}` is implicit", m.name), "leave out its `method`")
        } else {
            return None;
        };
        Some((m.item, why))
    });
    let bounds = crate::net::worst::worst_bounds(net);
    let of_links = net.lias.iter().zip(&bounds).filter_map(|(l, b)| {
        let why = if !l.law.stage.is_explicit() || l.law.implicit {
            (format!("`{}` is implicit", l.name), "leave out its `method`")
        } else if b.z != 0.0 || loses(net, l) {
            (format!("the force of `{}` depends on motion", l.name), "use springs and contacts without viscosity")
        } else if l.law.mem > 0 {
            (
                format!("the force of `{}` depends on the past", l.name),
                "use links whose force depends only on positions",
            )
        } else {
            return None;
        };
        Some((l.item, why))
    });
    let of_waves = net.lines.iter().map(|l| {
        let name = &net.items[l.item as usize].name;
        (l.item, (format!("`{name}` is a waveguide"), "use a `[STRING]`"))
    });
    let mut reported = BTreeSet::new();
    for (item, (why, help)) in of_waves.chain(of_mats).chain(of_links) {
        if reported.insert(item) {
            let at = model.items[net.items[item as usize].model].name_span;
            let d = Diag::error("E028", format!("`pefrl` cannot compute the model: {why}")).at(at, "not with `pefrl`");
            diags.push(d.help(format!("{help}, or use `method = \"ca\"`")));
        }
    }
}

/// Returns whether a Hertz contact loses energy, or may by a live change. Its bound does not show this as a slope.
fn loses(net: &Pruned, l: &LiaNode) -> bool {
    let Some(from) = l.kind.param("h").and_then(|h| l.values.get(h)) else { return false };
    let live = net.is_live(l.item) && matches!(from, Source::Slot(_));
    live || from.get(&net.items[l.item as usize].slots).is_some_and(|h| h != 0.0)
}
