//! The first samples: decides whether the model needs the start of mi.lib and notes what differs.
//!
//! A model at rest, unstretched and without weight gets the usual start, so most imported files do not mention it.
//! Differences that remain (see `start` of `[model]`) are notes at the module that shows them.

use super::names::Losses;
use super::part::{Arg, Net, Part};
use alloc::format;
use ca_model::diag::Diag;

/// Returns true if a part is displaced, moves or is pressed at the start.
pub(super) fn matters(net: &Net) -> bool {
    let away = |p: &Part| p.args.iter().any(|a| matches!(a.0, "dx0" | "v" | "x"));
    let pressed = |p: &Part| p.kind == "BUT" && p.arg("d") != Arg::Num(0.0);
    net.parts.iter().any(|p| p.group.is_some() || away(p) || pressed(p))
}

pub(super) fn notes(net: &Net, losses: &mut Losses) {
    for link in &net.parts {
        let [a, b] = link.ends[..] else { continue };
        let get = |key: &str| net.value(link.arg(key));
        let (Some(a), Some(b)) = (net.parts.get(a), net.parts.get(b)) else { continue };
        let d = get("d");
        if link.kind == "BUT" && get("z") * d != 0.0 && place(net, b) - place(net, a) < d {
            let title = format!("`{}` touches in the first sample, without the force of its threshold", link.name);
            let d = Diag::note("N201", title).at(link.span, "mi.lib treats the threshold as a speed there");
            losses.add("touches", d);
        }
        let viscous = get("z") != 0.0 || link.kind == "BOW";
        if let Some(port) = [a, b].into_iter().find(|p| p.kind == "ENX" && viscous) {
            let d = Diag::note("N201", format!("`{}` starts at its first value, without a speed", port.name))
                .at(port.span, "mi.lib treats the first value as a jump from 0")
                .help("start its gesture at 0 to get the same motion");
            losses.add(&format!("first {}", port.name), d);
        }
    }
}

/// Returns the position of a part in the first sample.
fn place(net: &Net, part: &Part) -> f64 {
    let get = |key: &str| net.value(part.arg(key));
    let (x, v) = (get("dx0") + net.value(part.rest), get("v"));
    let weight = part.group.and_then(|g| net.groups.get(g)).map_or(0.0, |g| g.1);
    let own = if part.kind == "CEL" { (get("k") * x + get("z") * v) / get("m") } else { 0.0 };
    x + v - own - weight
}
