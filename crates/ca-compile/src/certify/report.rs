//! Writes the certificate, with findings that name the responsible module and a fix.

use crate::certify::accumulate::Accumulated;
use crate::certify::bound::Bounds;
use crate::certify::cause::{span, unstable};
use crate::certify::decide::Decision;
use crate::certify::exact::Exact;
use crate::certify::rules::{Decides, at, contacts, devices, frictions, hardening, methods};
use crate::certify::{device_keys, lpr_support, ripple, simultaneous_contacts};
use crate::findings::round_up;
use crate::net::{LiaNode, Pruned};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::string::ToString;
use alloc::vec::Vec;
use ca_core::internal::scene::certificate::FactorVerdict;
use ca_core::{Bound, Certificate, Level, Unit};
use ca_model::Model;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::{self, Plain};

/// Writes the certificate; `asked` requests the largest eigenvalue.
pub fn report(
    model: &Model,
    net: &Pruned,
    sums: &Accumulated,
    bounds: &Bounds,
    decided: &Decision,
    asked: bool,
    diags: &mut Diags,
) -> Certificate {
    let exact = decided.exact.as_ref();
    let mut cert = Certificate {
        level: decided.level,
        bound: bounds.upper,
        lower: bounds.lower,
        exact: decided.verdict != FactorVerdict::Open,
        worst: bounds.worst.map(|i| net.mats[i].name.to_string()).unwrap_or_default(),
        not_judged: not_judged(net),
        ..Certificate::default()
    };
    cert.largest = exact.filter(|_| asked).and_then(|e| e.largest(&cert, true));
    cert.headroom = exact.filter(|_| decided.verdict == FactorVerdict::Stable).and_then(Exact::headroom);
    // The MAT nearest to the limit may owe it to links that are not always present, so a certain cause comes first.
    let blamed = bounds.cause.filter(|_| bounds.lower >= 4.0).or(bounds.worst);
    match (cert.level, blamed) {
        (Level::Unstable, Some(i)) => diags.push(match exact {
            Some(e) if decided.verdict == FactorVerdict::Unstable => e.blame(model, net, sums, i, &cert),
            _ => unstable(model, net, sums, i),
        }),
        (Level::NotProven, _) => diags.push(not_proven(model, net, sums, bounds, &cert)),
        _ => {}
    }
    cert.ripple = ripple::ripple(net, exact, &cert);
    lpr_support::lpr_support(model, net, diags);
    let held = |l: &LiaNode, b: &Bound| exact.filter(|_| decided.few)?.mobility(net, l, b);
    let mut decides = Decides::default();
    contacts(model, net, sums, held, (&mut cert, &mut decides), diags);
    simultaneous_contacts::simultaneous(model, net, sums, &mut cert, diags);
    frictions(model, net, sums, held, (&mut cert, &mut decides), diags);
    hardening(net, sums, held, (&mut cert, &mut decides));
    methods(model, net, sums, &mut decides, diags);
    if cert.level == Level::RuleOfThumb {
        cert.rules.decides = decides.name();
    }
    devices(model, net, &sums.links, diags);
    cert.keys = device_keys::keys(net, &sums.links);
    cert
}

fn not_proven(model: &Model, net: &Pruned, sums: &Accumulated, bounds: &Bounds, cert: &Certificate) -> Diag {
    let why = if bounds.covered {
        let links = bounds.worst.map_or("the links".into(), |i| format!("the links of `{}`", net.mats[i].name));
        format!("{links} may be too stiff (largest eigenvalue at most {:.3}, the limit is 4)", Plain(bounds.upper))
    } else {
        "a negative spring is not outweighed by the springs beside it".into()
    };
    let mut d = Diag::warning("W107", format!("stability is not proven: {why}"));
    if let Some(i) = bounds.worst {
        d = d.at(span(model, net, net.mats[i].item), "nearest to the limit");
        // Label the steepest non-linear link there.
        let touches = |l: &LiaNode| l.all_ends().any(|e| net.under(e).contains(&(i as u32)));
        let nonlinear = net.lias.iter().zip(&sums.links).zip(&sums.reached);
        let nonlinear =
            nonlinear.filter(|((l, b), _)| !b.linear && !b.contact && l.law.stage.is_explicit() && touches(l));
        if let Some(((l, b), r)) = nonlinear.max_by(|a, b| a.0.1.h().total_cmp(&b.0.1.h())) {
            let k = quantity::show(round_up(b.h()), Unit::STIFFNESS);
            d = d.at(span(model, net, l.item), format!("decisive: a slope of up to {k}{}", at(r.as_ref())));
        }
    }
    let help = "the model may still be stable; to be sure, lower the stiffness and viscosity at";
    d.help(format!("{help} `{}`, make it heavier, or raise the {} rate", cert.worst, net.clock()))
}

/// Returns the items with masses left out because no output depends on them. Masses replaced by modes are not among
/// them.
fn not_judged(net: &Pruned) -> Vec<String> {
    let items: BTreeSet<u32> = net.without_output.iter().map(|m| net.mats[*m as usize].item).collect();
    items.into_iter().map(|i| net.items[i as usize].name.to_string()).collect()
}
