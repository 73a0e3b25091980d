//! What no bound tells: contacts and device keys, judged by rule.

use crate::certify::accumulate::{Accumulated, Sums};
use crate::certify::blame::span;
use crate::findings::{round_down, round_up};
use crate::net::{End, LiaNode, Pruned};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::ToString;
use ca_core::kind::Unit;
use ca_core::law::Bound;
use ca_core::scene::certificate::Certificate;
use ca_model::diag::{Diag, Diags};
use ca_model::{Model, quantity};

/// Rules for contacts (docs/numerics.md §3.2): kT²/m ≤ 1 recommended, ≤ 2 at the most; of one that grows with a power of
/// its depth, the depth at which its slope is so. The mobility is that of both ends with the links that hold them (`held`),
/// where that is known.
pub fn contacts(
    model: &Model,
    net: &Pruned,
    sums: &Accumulated,
    held: impl Fn(&LiaNode, &Bound) -> Option<f64>,
    cert: &mut Certificate,
    diags: &mut Diags,
) {
    let mut reported = BTreeSet::new();
    for (l, b) in net.lias.iter().zip(&sums.links) {
        if b.active && reported.insert(l.item) {
            let d = Diag::warning("W110", format!("`{}` may feed energy in: its table does not only resist", l.name));
            diags.push(d.at(span(model, net, l.item), "active").help("a force of the sign of its speed only resists, and a spring that never falls only returns; if it is meant to drive, mind the level"));
        }
        let (q, p) = b.power;
        if !b.contact || (b.k == 0.0 && q == 0.0) || l.law.is_staged() {
            continue;
        }
        let c = held(l, b).unwrap_or_else(|| mobility(net, l, &sums.mats));
        if q * c > 0.0 {
            let depth = libm::pow(1.0 / (p * q * c), 1.0 / (p - 1.0));
            if depth.is_finite() && cert.depth.as_ref().is_none_or(|d| depth < d.1) {
                cert.depth = Some((l.name.to_string(), depth));
            }
            continue;
        }
        let a = b.k * c;
        if a > cert.contact {
            cert.contact = a;
            cert.stiffest = l.name.to_string();
        }
        if a > 1.0 && reported.insert(l.item) {
            let safe = quantity::show(round_down(1.0 / c), Unit::STIFFNESS);
            let word = if a > 2.0 { "makes energy at every blow" } else { "may make energy at a blow" };
            let d = Diag::warning(
                "W104",
                format!("contact `{}` {word}: kT²/m is {:.3}, stay below 1", l.name, quantity::Plain(a)),
            );
            let (lo, hi) = (0.12 * a, 1.9 - a);
            let help = if hi > lo {
                let z = |b: f64| quantity::show(round_down(b / (c / net.tick_dt)), Unit::VISCOSITY);
                format!("use `k` up to {safe}, or viscosity `z` between {} and {}", z(lo), z(hi))
            } else {
                format!("use `k` up to {safe}, heavier masses, a higher {} rate", net.clock())
            };
            let stable = if l.kind.param("method").is_some() { ", or `method = \"stable\"`" } else { "" };
            diags.push(d.at(span(model, net, l.item), "stiff contact").help(help + stable));
        }
    }
}

/// Rule for friction that is no straight line, as of a bow (docs/numerics.md §3.5): slope·T/m up to 1.5, or what should
/// stick rings at every other sample.
pub fn frictions(
    model: &Model,
    net: &Pruned,
    sums: &Accumulated,
    held: impl Fn(&LiaNode, &Bound) -> Option<f64>,
    cert: &mut Certificate,
    diags: &mut Diags,
) {
    let mut reported = BTreeSet::new();
    for (l, b) in net.lias.iter().zip(&sums.links).filter(|(l, b)| rubs(b) && !l.law.is_staged()) {
        let c = held(l, b).unwrap_or_else(|| mobility(net, l, &sums.mats));
        let steep = b.z * c;
        cert.friction = cert.friction.max(steep);
        if steep > 1.5 && reported.insert(l.item) {
            let title = format!(
                "`{}` is too steep to stick: slope·T/m is {:.3}, stay below 1.5",
                l.name,
                quantity::Plain(steep)
            );
            let less = quantity::Plain(round_up(steep / 1.5));
            let other = if l.kind.param("method").is_some() { ", or `method = \"newton\"`" } else { "" };
            let help = format!(
                "a {less} times smaller force or larger speed of stick, heavier masses, or a higher {} rate{other}",
                net.clock()
            );
            diags.push(Diag::warning("W113", title).at(span(model, net, l.item), "steep friction").help(help));
        }
    }
}

/// True where a law resists motion along a curve.
pub fn rubs(b: &Bound) -> bool {
    b.curve && b.z > 0.0
}

/// T²/m of both ends of a contact together; of a set, of its most mobile pair.
fn mobility(net: &Pruned, l: &LiaNode, mats: &[Sums]) -> f64 {
    let end = |e: End| net.under(e).iter().map(|m| mats[*m as usize].c).fold(0.0, f64::max);
    let Some(sets) = &l.sets else { return l.all_ends().map(end).sum() };
    // the largest and the next
    let two = |set: &[u32]| {
        set.iter().map(|m| mats[*m as usize].c).fold((0.0f64, 0.0f64), |(a, b), c| (a.max(c), b.max(a.min(c))))
    };
    let (first, next) = two(&sets[0]);
    if sets[1].is_empty() { first + next } else { first + two(&sets[1]).0 }
}

/// The delay of a device turns viscosity straight on a key into noise and instability (ICMC 2013, 7.1).
pub fn devices(model: &Model, net: &Pruned, bounds: &[Bound], diags: &mut Diags) {
    let is_key = |e: &End| matches!(e, End::Mat(m) if net.mats[*m as usize].code == "TGR");
    let mut reported = BTreeSet::new();
    for (l, b) in net.lias.iter().zip(bounds) {
        if b.z > 0.0 && l.all_ends().any(|e| is_key(&e)) && reported.insert(l.item) {
            let d = Diag::warning("W105", format!("`{}` puts viscosity straight on a device key", l.name))
                .at(span(model, net, l.item), "noisy, and limited by the device's own friction")
                .help("tie the key to a MAS by a RES, and damp that MAS to ground instead");
            diags.push(d);
        }
    }
}
