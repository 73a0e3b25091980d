//! Elongations of links at load.

use crate::net::{End, LiaNode, Measure, Wired};
use ca_core::Role;

/// Returns the constant part of the elongation of two ends at rest, which the kernel does not measure, and their
/// distance.
fn at_rest(net: &Wired, ends: [End; 2], measure: Measure) -> (f64, f64) {
    let v = net.rest_vector(ends);
    match measure {
        Measure::Line([a, b]) => {
            let d = net.rest(ends[1])[b as usize] - net.rest(ends[0])[a as usize];
            (d, d)
        }
        Measure::Along(n) => {
            let d = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
            (d, d)
        }
        Measure::Radial => (0.0, libm::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])),
    }
}

/// Returns the constant part of the elongation. At rest, laws with a rest length have the elongation 0 unless `l0` is
/// written, and so has the second port of a quadripole. Contacts measure from the positions.
pub fn offset(net: &Wired, l: &LiaNode) -> f64 {
    let (constant, distance) = at_rest(net, l.ends, l.measure);
    let generated = matches!(l.kind.role, Role::Lia(_)) && net.items[l.item as usize].kind.code != l.kind.code;
    let has_length = generated || l.kind.param("l0").is_some();
    let slack = if has_length { l.l0.unwrap_or(distance) } else { 0.0 };
    let slack = if l.measure == Measure::Radial && l.soften != 0.0 {
        libm::sqrt(slack * slack + l.soften * l.soften)
    } else {
        slack
    };
    let second = l.onto.as_ref().map_or(0.0, |o| {
        let (constant, distance) = at_rest(net, o.ends, o.measure);
        let soft = if o.measure == Measure::Radial { l.soften } else { 0.0 };
        let slack = if soft == 0.0 { distance } else { libm::sqrt(distance * distance + soft * soft) };
        constant - slack
    });
    constant - slack + second
}

/// Returns the elongation at load \[m\]; `None` for sets and for links at moving points.
pub fn at_load(net: &Wired, l: &LiaNode) -> Option<f64> {
    let second = l.onto.as_ref().map(|o| (o.ends, o.measure));
    let mut e = offset(net, l);
    for (ends, measure) in core::iter::once((l.ends, l.measure)).chain(second) {
        let (End::Mat(i), End::Mat(j)) = (ends[0], ends[1]) else { return None };
        if l.sets.is_some() {
            return None;
        }
        let [from, to] = [i, j].map(|m| net.mats[m as usize].dx0);
        let by: [f64; 3] = core::array::from_fn(|k| to[k] - from[k]);
        e += match measure {
            Measure::Line([a, b]) => to[b as usize] - from[a as usize],
            Measure::Along(n) => n[0] * by[0] + n[1] * by[1] + n[2] * by[2],
            Measure::Radial => {
                let rest = net.rest_vector(ends);
                let square: f64 = (0..3).map(|k| (rest[k] + by[k]) * (rest[k] + by[k])).sum();
                libm::sqrt(square + l.soften * l.soften)
            }
        };
    }
    Some(e)
}
