//! Contacts on one side of a mass, which may be stable individually and unstable together.
//!
//! With all of them pressed, the largest eigenvalue is at least T²/m times the sum of k + 2z/T over these contacts and
//! over the permanent links of the mass. From 4 on the mass oscillates with growing amplitude while it presses
//! (docs/numerics.md §3.2). Contacts on opposite sides may never press at once, and those in space have different
//! directions, so they are judged individually.

use crate::certify::accumulate::Accumulated;
use crate::certify::cause::{any, faster, span};
use crate::certify::rules::{stable, word};
use crate::findings::round_down;
use crate::net::{End, LiaNode, Measure, Pruned};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Certificate;
use ca_model::Model;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;

/// A pressed contact: k + 2z/T, and the part by z.
struct PressedContact<'a> {
    link: &'a LiaNode,
    h: f64,
    viscous: f64,
}

/// Warns of contacts that are unstable together but not individually.
pub fn simultaneous(model: &Model, net: &Pruned, sums: &Accumulated, cert: &mut Certificate, diags: &mut Diags) {
    // Contacts by mass, axis and side.
    let mut sides: BTreeMap<(u32, u8, bool), Vec<PressedContact>> = BTreeMap::new();
    for ((l, b), reached) in net.lias.iter().zip(&sums.links).zip(&sums.reached) {
        let Measure::Line(axes) = l.measure else { continue };
        if !b.contact || !l.law.stage.is_explicit() || l.sets.is_some() {
            continue;
        }
        let (k, z) = reached.map_or((b.k, b.z), |r| (r.k, r.z));
        for (second, (end, axis)) in l.ends.into_iter().zip(axes).enumerate() {
            if let End::Mat(m) = end {
                // A contact with `sense = "inside"` presses from the other side.
                let side = (second == 1) != (word(net, l, "sense") == "inside");
                sides.entry((m, axis, side)).or_default().push(PressedContact {
                    link: l,
                    h: k + 2.0 * z,
                    viscous: 2.0 * z,
                });
            }
        }
    }
    let mut reported = BTreeSet::new();
    for ((m, ..), contacts) in sides {
        let (mass, s) = (&net.mats[m as usize], &sums.mats[m as usize]);
        let c = s.scaled_mobility;
        let pressed: f64 = contacts.iter().map(|p| p.h).sum();
        let at = c * (pressed + s.certain);
        let Some(most) = contacts.iter().max_by(|a, b| a.h.total_cmp(&b.h)) else { continue };
        // A single contact is judged by `contacts`, with the links that hold its mass.
        if at < 4.0 || contacts.len() < 2 || c * most.h >= 4.0 || c * s.certain >= 4.0 || !reported.insert(mass.item) {
            continue;
        }
        cert.rules.closed = cert.rules.closed.max(at);
        let n = contacts.len();
        let title = format!(
            "`{}` is unstable while its {n} contacts on one side press at once: T²k/m + 2Tz/m is {:.3}, the limit is 4",
            mass.name,
            Plain(at)
        );
        let share = round_down(100.0 * (4.0 / c - s.certain) / pressed);
        let softer = format!("make them at most {} % as stiff and viscous", Plain(share));
        let heavier = format!("make `{}` heavier", mass.name);
        let method = match stable(most.link) {
            "" => String::new(),
            method => format!("use {method}"),
        };
        let viscous = c * (s.viscous + contacts.iter().map(|p| p.viscous).sum::<f64>());
        let help = any(&[&method, &softer, &heavier, &faster(net, at, Some(viscous))]);
        diags
            .push(Diag::warning("W117", title).at(span(model, net, most.link.item), "the stiffest of them").help(help));
    }
}
