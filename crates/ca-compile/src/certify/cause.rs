//! Names the cause of instability, and fixes in numbers that an author can type.

use super::bound::explicit;
use crate::certify::accumulate::{Accumulated, Sums};
use crate::findings::{round_down, round_up};
use crate::lower::rates::{CLOCK, FINEST};
use crate::net::{LiaNode, Pruned};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::{Bound, Unit};
use ca_model::diag::{Diag, Diags};
use ca_model::{Model, Span, quantity};

/// Reports each item whose coefficients overflow, and returns whether there is one.
pub fn overflow(model: &Model, net: &Pruned, sums: &Accumulated, diags: &mut Diags) -> bool {
    let good = |s: &Sums| s.scaled_mobility.is_finite() && (s.all * s.scaled_mobility).is_finite();
    let mats = net.mats.iter().zip(&sums.mats).filter(|(_, s)| !good(s)).map(|(m, _)| m.item);
    let links =
        net.lias.iter().zip(&sums.links).filter(|(_, b)| !(b.k.is_finite() && b.z.is_finite())).map(|(l, _)| l.item);
    let items: BTreeSet<u32> = mats.chain(links).collect();
    for item in &items {
        let name = &net.items[*item as usize].name;
        let d = Diag::error("E009", format!("the coefficients of `{name}` are too large to compute"));
        diags.push(
            d.at(span(model, net, *item), "overflows").help("use a larger mass, or less stiffness and viscosity"),
        );
    }
    !items.is_empty()
}

/// Returns the place of the name of a module.
pub fn span(model: &Model, net: &Pruned, item: u32) -> Span {
    model.items[net.items[item as usize].model].name_span
}

/// Returns the warning for an unstable mass, with numbers that fix it.
pub fn unstable(model: &Model, net: &Pruned, sums: &Accumulated, i: usize) -> Diag {
    let m = &net.mats[i];
    let s = &sums.mats[i];
    let at = s.certain * s.scaled_mobility;
    let title = format!(
        "`{}` is too stiff for its mass at this {} rate (largest eigenvalue at least {:.3}, the limit is 4)",
        m.name,
        net.clock(),
        quantity::Plain(at)
    );
    let d = Diag::warning("W103", title).at(span(model, net, m.item), "this mass");
    // The fix changes the link with the largest share.
    let mut most: Option<(&LiaNode, &Bound)> = None;
    for (l, b) in net.lias.iter().zip(&sums.links) {
        let touches = b.linear && l.all_ends().any(|e| net.under(e).contains(&(i as u32)));
        if touches && most.is_none_or(|(_, o)| b.h() > o.h()) {
            most = Some((l, b));
        }
    }
    let mass = net.tick_dt * net.tick_dt / s.c * at / 4.0;
    let heavier = format!("make `{}` heavier than {}", m.name, quantity::show(round_up(mass), Unit::KILOGRAM));
    // The mass of a junction of a waveguide depends on the rate.
    let junction = net.lines.iter().any(|l| l.junctions().contains(&(i as u32)));
    let rate = faster(net, at, (!junction).then_some(s.viscous * s.scaled_mobility));
    match most {
        Some((l, b)) => {
            let (headroom, counted) = (4.0 / s.scaled_mobility - (s.certain - b.h()), explicit(b));
            // Each number has the margin that the other leaves; below 0 no value is small enough.
            let (k, z) = (headroom - 2.0 * counted.z, 0.5 * (headroom - counted.k));
            let fix = if b.lift > 0.0 {
                format!("use `theta = 0.25` or more for `{}`", l.name)
            } else if k > 0.0 && counted.k >= 2.0 * counted.z {
                format!("keep `k` of `{}` below {}", l.name, quantity::show(round_down(k), Unit::STIFFNESS))
            } else if z > 0.0 {
                format!(
                    "keep `z` of `{}` below {}",
                    l.name,
                    quantity::show(round_down(z * net.tick_dt), Unit::VISCOSITY)
                )
            } else if headroom > 0.0 {
                let share = 100.0 * headroom / (counted.k + 2.0 * counted.z);
                format!("make `{}` at most {} % as stiff and viscous", l.name, quantity::Plain(round_down(share)))
            } else {
                format!("soften `{}` and the other links of `{}`", l.name, m.name)
            };
            d.at(span(model, net, l.item), "its stiffest link").help(any(&[&fix, &heavier, &rate]))
        }
        None => d.help(any(&[&heavier, &rate])),
    }
}

/// Returns the help with the sound rate at which an eigenvalue `now` is at the limit, and with sufficient ticks per
/// sample. Empty if neither is allowed.
///
/// Stiffness falls with the square of the rate, viscosity with the rate. `viscous` is the part of `now` by viscosity. If
/// it is unknown, all of `now` is taken as viscosity, so the rate is sufficient.
pub fn faster(net: &Pruned, now: f64, viscous: Option<f64>) -> String {
    let z = viscous.unwrap_or(now);
    let times = (z + libm::sqrt(z * z + 16.0 * (now - z).max(0.0))) / 8.0;
    let above = net.rate * times;
    let (clock, hertz) = (net.clock(), quantity::Plain(above));
    let rate = match viscous {
        Some(_) => format!("raise the {clock} rate above {hertz:.0} Hz"),
        None => format!("raise the {clock} rate to {hertz:.0} Hz, which is enough"),
    };
    let ticks = libm::floor(f64::from(net.oversample) * times) + 1.0;
    let finer = format!("write `oversample = {ticks}` in `[rate]`");
    let finer = if net.slow || ticks > f64::from(FINEST) { "" } else { &finer };
    any(&[if above < CLOCK.1 { &rate } else { "" }, finer])
}

/// Joins alternative fixes, without empty ones.
pub fn any(ways: &[&str]) -> String {
    ways.iter().copied().filter(|w| !w.is_empty()).collect::<Vec<_>>().join(", or ")
}
