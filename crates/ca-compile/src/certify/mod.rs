//! Certify: what can be said of stability before anything moves, and which module to blame.
//!
//! Decides for the cheap bounds of docs/numerics.md §1.3 first (two sums per module, no matrix), which settle almost
//! every scene. With h = T²k + 2Tz for each link and d_i their sum at mass i: d_i/m_i ≥ 4 is certainly unstable and
//! this module is the cause; the smaller of the Gershgorin and the link bound below 4 is certainly stable. Between
//! them, and with the feature `analysis`, one sparse factorisation decides. Contacts and other non-linear links are
//! judged by rule (docs/numerics.md §3.2) and said to be.

mod blame;
#[cfg_attr(not(feature = "analysis"), path = "no_exact.rs")]
mod exact;
mod keys;
mod negative;
mod rigid;
mod ripple;
mod rules;

use crate::net::worst::{Row, worst_bounds, worst_rows};
use crate::net::{End, LiaNode, Net};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use blame::{overflow, span, unstable};
use ca_core::certificate::Verdict;
pub use ca_core::certificate::{Certificate, Level};
use ca_core::law::Bound;
use ca_model::Model;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;
use exact::Exact;
use negative::Negative;
use rules::{contacts, devices, frictions, rubs};

/// Judges the network; warnings name the module and what would mend it. The largest eigenvalue is narrowed down only
/// where it is `asked` for.
pub fn certify(model: &Model, net: &Net, asked: bool, diags: &mut Diags) -> Certificate {
    let mut rows = worst_rows(net);
    // what is left out does not move
    for (r, _) in rows.iter_mut().zip(&net.alive).filter(|(_, alive)| !**alive) {
        *r = Row::default();
    }
    // a method with another limit is judged as heavier masses would be by the explicit one
    let ease = net.ease();
    for r in &mut rows {
        r.c *= ease;
    }
    let bounds = worst_bounds(net);
    let mut springs = Negative::default();
    for (l, b) in net.lias.iter().zip(&bounds) {
        let h = b.h();
        let sides: Vec<(bool, Vec<u32>)> = l.all_ends().map(|e| (matches!(e, End::Mat(_)), net.under(e))).collect();
        // of a curve of friction the slope is one that it has somewhere
        let sure = if b.curve { b.k } else { h };
        // ends that move: the row of the link at each of them holds so many entries
        let moving = |ids: &[u32]| ids.iter().any(|m| rows[*m as usize].c > 0.0);
        let reach = |e: End| if moving(&net.under(e)) { net.reach(e) } else { 0.0 };
        let others = (l.all_ends().map(reach).sum::<f64>() - 1.0).max(0.0);
        for (here, m) in sides.iter().flat_map(|(here, ids)| ids.iter().map(move |m| (*here, m))) {
            let r = &mut rows[*m as usize];
            if l.law.is_late() {
                // passive whatever it holds, and no part of the linear network
            } else if b.linear || !b.contact {
                // what eases the limit is left out of what no mass may pass
                r.all += if b.lift > 0.0 { h.max(0.0) } else { h };
                r.disc += h + others * h.abs();
                if here {
                    r.own += sure;
                    r.most = r.most.max(sure);
                    r.eased += sure.min(0.0);
                    r.radial |= l.is_radial();
                }
            } else {
                r.touch += h;
            }
        }
        // what is not always there covers nothing
        if let ([End::Mat(i), End::Mat(j)], false) = (l.ends, b.contact) {
            springs.add(i, j, b.k);
        }
    }
    if overflow(model, net, &rows, &bounds, diags) {
        return Certificate::default();
    }
    let mut cert = Certificate::default();
    let (mut pair, mut cause): (f64, Option<usize>) = (0.0, None);
    let junction = |i: usize| net.lines.iter().any(|l| l.junctions().contains(&(i as u32)));
    for (i, r) in rows.iter().enumerate() {
        let g = r.disc * r.c;
        cert.bound = cert.bound.max(g);
        // springs of different directions do not add up: a third of them does, and so does the stiffest
        let sure = if r.radial { (r.own / 3.0).max(r.most + r.eased) } else { r.own };
        // waves that come back may hold a junction against its own damper, which is where they leave
        let sure = if junction(i) { sure - 2.0 * r.z } else { sure };
        if sure * r.c > cert.lower {
            (cert.lower, cause) = (sure * r.c, Some(i));
        }
    }
    // the contacts of a set are judged by rule, and no two of its members are tied
    for l in net.lias.iter().filter(|l| l.sets.is_none() && !l.law.is_late()) {
        let d = |e: End| {
            let one = |m: &u32| rows[*m as usize].all * rows[*m as usize].c;
            net.reach(e).max(1.0) * net.under(e).iter().map(one).fold(0.0, f64::max)
        };
        pair = pair.max(l.all_ends().map(d).sum());
    }
    // a mass with a spring of its own is a link to the ground
    pair = rows.iter().map(|r| r.all * r.c).fold(pair, f64::max);
    let negative = bounds.iter().any(|b| b.k < 0.0);
    if !negative {
        cert.bound = cert.bound.min(pair);
    }
    let worst = (0..rows.len()).max_by(|a, b| (rows[*a].all * rows[*a].c).total_cmp(&(rows[*b].all * rows[*b].c)));
    cert.worst = worst.map(|i| net.mats[i].name.clone()).unwrap_or_default();
    cert.not_judged = not_judged(net);

    let covered = !negative || springs.covered();
    let explicit: Vec<_> = net.lias.iter().zip(&bounds).filter(|(l, _)| !l.law.is_late()).collect();
    let linear = explicit.iter().all(|(_, b)| b.linear);
    let radial = explicit.iter().any(|(l, _)| l.is_radial());
    let held = |l: &LiaNode| l.all_ends().flat_map(|e| net.under(e)).any(|m| rows[m as usize].all > 0.0);
    let ruled = |b: &Bound| (b.contact && b.k > 0.0) || rubs(b);
    let judged = |l: &LiaNode, b: &Bound| ruled(b) && l.sets.is_none() && !l.law.is_late() && held(l);
    let spots = |l: &LiaNode| l.ends.iter().map(|e| net.spots(*e)).product::<usize>();
    let touching: usize = net.lias.iter().zip(&bounds).filter(|(l, b)| judged(l, b)).map(|(l, _)| spots(l)).sum();
    let few = touching > 0 && touching.saturating_mul(rows.len()) <= exact::WORK;
    let between = cert.lower < 4.0 && cert.bound >= 4.0 && covered;
    let exact = if between || few || asked { Exact::new(net, &rows, &bounds) } else { None };
    let verdict = exact.as_ref().filter(|_| between).map_or(Verdict::Open, |e| e.verdict(net, &bounds));
    let verdict = if verdict == Verdict::Unstable && !net.lines.is_empty() { Verdict::Open } else { verdict };
    cert.exact = verdict != Verdict::Open;
    cert.largest = exact.as_ref().filter(|_| asked).and_then(|e| e.largest(&cert, true));
    cert.level = if cert.lower >= 4.0 || verdict == Verdict::Unstable {
        Level::Unstable
    } else if (cert.bound < 4.0 || verdict == Verdict::Stable) && covered {
        match (linear, radial) {
            (true, false) => Level::Proven,
            (true, true) => Level::Linearised,
            (false, _) => Level::RuleOfThumb,
        }
    } else {
        Level::NotProven
    };
    // of what is unstable by itself, that; what is nearest to the limit may owe it to what is not certainly there
    if let (Level::Unstable, Some(i)) = (cert.level, cause.filter(|_| cert.lower >= 4.0).or(worst)) {
        diags.push(match &exact {
            Some(e) if verdict == Verdict::Unstable => e.blame(model, net, &bounds, i, &cert),
            _ => unstable(model, net, &rows, &bounds, i),
        });
    }
    if cert.level == Level::NotProven {
        let why = if covered {
            format!("the bounds allow up to {:.3}, the limit is 4", Plain(cert.bound))
        } else {
            "some spring is negative and not covered by those beside it".into()
        };
        let mut d = Diag::warning("W107", format!("stability is not proven: {why}"));
        if let Some(i) = worst {
            d = d.at(span(model, net, net.mats[i].item), "nearest to the limit");
        }
        let help = "it may well be stable; to be sure, lower the stiffness and viscosity at";
        diags.push(d.help(format!("{help} `{}`, make it heavier, or raise the sound rate", cert.worst)));
    }
    cert.ripple = ripple::ripple(net, exact.as_ref(), &cert);
    rigid::rigid(model, net, diags);
    let held = |l: &LiaNode, b: &Bound| Some(exact.as_ref().filter(|_| few)?.mobility(net, l, b)? / ease);
    for r in &mut rows {
        r.c /= ease;
    }
    contacts(model, net, &rows, &bounds, held, &mut cert, diags);
    frictions(model, net, &rows, &bounds, held, &mut cert, diags);
    devices(model, net, &bounds, diags);
    cert.keys = keys::keys(net, &bounds);
    cert
}

/// Items of which some mass is left out, since nothing hears it. Masses whose modes stand for them are heard.
fn not_judged(net: &Net) -> Vec<String> {
    let items: BTreeSet<u32> = net.unheard.iter().map(|m| net.mats[*m as usize].item).collect();
    items.into_iter().map(|i| net.items[i as usize].name.clone()).collect()
}
