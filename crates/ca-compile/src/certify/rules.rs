//! Rules for contacts, friction, hardening springs and device keys, which no eigenvalue bounds.

use crate::certify::accumulate::{Accumulated, Sums};
use crate::certify::cause::{any, faster, span};
use crate::certify::max_elongation::{Cause, MaxElongation};
use crate::findings::{round_down, round_up};
use crate::net::{End, LiaNode, Pruned, elongation, linearisation};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::{String, ToString};
use ca_core::internal::method::friction::STEEPEST;
use ca_core::internal::op::{SolveStage, loaded};
use ca_core::internal::scene::growth::Growth;
use ca_core::{Bound, Certificate, Level, Type, Unit};
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::rounded;
use ca_model::{Model, quantity};

/// The link that decides a verdict by rule: it uses the largest share of its limit.
#[derive(Default)]
pub struct Decides {
    share: f64,
    name: String,
}

impl Decides {
    fn take(&mut self, l: &LiaNode, share: f64) {
        if share > self.share || self.name.is_empty() {
            *self = Decides { share, name: l.name.to_string() };
        }
    }

    /// Returns its name; among links without a number, the first.
    pub fn name(self) -> String {
        self.name
    }
}

/// Applies the rules for contacts (docs/numerics.md §3.2). A contact is unstable while it presses if T²k + 2Tz ≥ 4 with
/// its steepest slopes within reach. kT²/m ≤ 1 is a rule of thumb, and the certificate has the depth at which a power
/// law reaches it. `held` returns the mobility of both ends with the links that hold them, if it is known.
pub fn contacts(
    model: &Model,
    net: &Pruned,
    sums: &Accumulated,
    held: impl Fn(&LiaNode, &Bound) -> Option<f64>,
    (cert, decides): (&mut Certificate, &mut Decides),
    diags: &mut Diags,
) {
    let mut reported = BTreeSet::new();
    for ((l, b), reached) in net.lias.iter().zip(&sums.links).zip(&sums.reached) {
        if b.active && l.law.stage.is_explicit() && reported.insert(l.item) {
            let d = Diag::warning("W110", format!("`{}` may add energy: its table is not passive", l.name));
            let help = "a friction table adds no energy if the force has the sign of the speed, a spring table if it \
                        never falls; if the link should add energy, watch the level";
            diags.push(d.at(span(model, net, l.item), "active").help(help));
        }
        let (q, p) = b.power;
        if !b.contact || (b.k == 0.0 && b.z == 0.0 && q == 0.0) || !l.law.stage.is_explicit() {
            continue;
        }
        let c = held(l, b).unwrap_or_else(|| mobility(net, l, &sums.mats));
        let (k, z) = reached.map_or((b.k, b.z), |r| (r.k, r.z));
        let (a, closed) = (k * c, (k + 2.0 * z) * c);
        decides.take(l, a.max(0.25 * closed));
        cert.rules.closed = cert.rules.closed.max(closed);
        if closed >= 4.0 && reported.insert(l.item) {
            diags.push(
                unstable_contact(net, l, ([k, z, c], p), reached.as_ref(), cert.level < Level::NotProven)
                    .at(span(model, net, l.item), "unstable contact"),
            );
        }
        if q * c > 0.0 {
            let depth = libm::pow(1.0 / (p * q * c), 1.0 / (p - 1.0));
            if depth.is_finite() && cert.rules.depth.as_ref().is_none_or(|d| depth < d.1) {
                cert.rules.depth = Some((l.name.to_string(), depth));
            }
        }
        if a > cert.rules.contact {
            cert.rules.contact = a;
            cert.rules.stiffest = l.name.to_string();
        }
        if a > 1.0 && reported.insert(l.item) {
            let word = if a > 2.0 { "adds energy at most impacts" } else { "may add energy at an impact" };
            let title =
                format!("contact `{}` {word}: kT²/m is {:.3}{}", l.name, quantity::Plain(a), at(reached.as_ref()));
            let softer = format!("a smaller `k`, heavier masses, a higher {} rate", net.clock());
            let ways = any(&[stable(l), &softer]);
            let help = format!("use {ways}; an impact may add energy at any `k`; {}", Growth::near(a));
            diags.push(Diag::warning("W104", title).at(span(model, net, l.item), "stiff contact").help(help));
        }
    }
}

/// Returns the method that a contact could use instead; empty if there is none.
pub fn stable(l: &LiaNode) -> &'static str {
    let words = methods_of(l);
    let serves = words.contains(&"stable") && (words.contains(&"stable3d") || !l.is_radial());
    if serves { "`method = \"stable\"`" } else { "" }
}

fn methods_of(l: &LiaNode) -> &'static [&'static str] {
    match l.kind.param("method").map(|at| l.kind.params[at].ty) {
        Some(Type::Choice(words)) => words,
        _ => &[],
    }
}

/// Returns the elongation of the steepest slope, as the end of a sentence.
pub fn at(reached: Option<&MaxElongation>) -> String {
    // Within a nanometre it is at rest.
    let Some(r) = reached.filter(|r| r.far > 1e-9) else { return String::new() };
    let far = quantity::show(rounded(r.far, 3), Unit::METRE);
    match r.cause {
        Cause::Energy => format!(" at an elongation of {far}, which the energy at load may reach"),
        Cause::Stroke => format!(" at an elongation of {far}, which the stroke of its port reaches"),
    }
}

/// Returns the warning for a contact that is unstable while it presses, with slopes `k`, `z` and mobility `c`, and the
/// power `p` of its law or 0. Only `exact`
/// slopes and mobility give numbers that mend it: links that are too stiff themselves make the masses more mobile.
fn unstable_contact(
    net: &Pruned,
    l: &LiaNode,
    ([k, z, c], p): ([f64; 3], f64),
    reached: Option<&MaxElongation>,
    exact: bool,
) -> Diag {
    let closed = (k + 2.0 * z) * c;
    let title = format!(
        "contact `{}` {} unstable while it presses: T²k/m + 2Tz/m is {:.3}{}, the limit is 4",
        l.name,
        if reached.is_some() { "may be" } else { "is" },
        quantity::Plain(closed),
        at(reached)
    );
    let (headroom, dt) = (4.0 / c, net.tick_dt);
    let fix = if !exact {
        String::from("soften it")
    } else if reached.is_some() {
        // A softer contact is pressed deeper: at one energy the slope of αᵖ is as k^(2/(p + 1)), of its viscosity as
        // k^(1/(p + 1)).
        let share =
            if p > 0.0 { libm::pow(4.0 / closed, (p + 1.0) * if z > 0.0 { 1.0 } else { 0.5 }) } else { 4.0 / closed };
        format!("make it at most {} % as stiff", quantity::Plain(round_down(100.0 * share)))
    } else if k < headroom && z > 0.0 {
        format!("keep `z` below {}", quantity::show(round_down(0.5 * (headroom - k) * dt), Unit::VISCOSITY))
    } else if z == 0.0 {
        format!("keep `k` below {}", quantity::show(round_down(headroom), Unit::STIFFNESS))
    } else {
        let share = 4.0 / closed;
        let k = quantity::show(round_down(k * share), Unit::STIFFNESS);
        let z = quantity::show(round_down(z * share * dt), Unit::VISCOSITY);
        format!("keep `k` below {k} and `z` below {z}")
    };
    let method = match stable(l) {
        "" => String::new(),
        method => format!("use {method}"),
    };
    let rate = if exact { faster(net, closed, Some(2.0 * z * c)) } else { String::new() };
    Diag::warning("W117", title).help(any(&[&method, &fix, "use heavier masses", &rate]))
}

/// Applies the rule for friction along a curve, such as a bow (docs/numerics.md §3.5): above slope·T/m = 1.5 a sticking
/// contact oscillates at every other sample.
pub fn frictions(
    model: &Model,
    net: &Pruned,
    sums: &Accumulated,
    held: impl Fn(&LiaNode, &Bound) -> Option<f64>,
    (cert, decides): (&mut Certificate, &mut Decides),
    diags: &mut Diags,
) {
    let mut reported = BTreeSet::new();
    for (l, b) in net.lias.iter().zip(&sums.links).filter(|(l, b)| rubs(b) && l.law.stage.is_explicit()) {
        let c = held(l, b).unwrap_or_else(|| mobility(net, l, &sums.mats));
        let steep = b.z * c;
        cert.rules.friction = cert.rules.friction.max(steep);
        decides.take(l, steep / 1.5);
        if steep > 1.5 && reported.insert(l.item) {
            let title = format!(
                "the friction of `{}` is too steep to stick: slope·T/m is {:.3}, the limit is 1.5",
                l.name,
                quantity::Plain(steep)
            );
            // A linear part that is not stable hides how mobile the ends are.
            let less = round_up(steep / 1.5);
            let less =
                if cert.level < Level::NotProven { format!("{} times ", quantity::Plain(less)) } else { String::new() };
            let method = if steep < STEEPEST { "newton" } else { "secant" };
            let other = match methods_of(l) {
                words if words.contains(&method) => format!("`method = \"{method}\"`, or "),
                words if words.contains(&"stable") && !l.is_radial() => "`method = \"stable\"`, or ".into(),
                _ => String::new(),
            };
            let help = format!(
                "use {other}a {less}smaller force, a {less}larger sticking speed, heavier masses, or a higher {} rate",
                net.clock()
            );
            diags.push(Diag::warning("W113", title).at(span(model, net, l.item), "steep friction").help(help));
        }
    }
}

/// Finds the hardening spring that decides, and lists those with an unknown largest elongation.
pub fn hardening(
    net: &Pruned,
    sums: &Accumulated,
    held: impl Fn(&LiaNode, &Bound) -> Option<f64>,
    (cert, decides): (&mut Certificate, &mut Decides),
) {
    let mut open = BTreeSet::new();
    for ((l, b), reached) in net.lias.iter().zip(&sums.links).zip(&sums.reached) {
        if b.linear || b.contact || b.curve || !l.law.stage.is_explicit() {
            continue;
        }
        let c = held(l, b).unwrap_or_else(|| mobility(net, l, &sums.mats));
        decides.take(l, 0.25 * b.h() * c);
        if b.hardens && reached.is_none() && open.insert(l.item) {
            cert.rules.open.push(net.items[l.item as usize].name.to_string());
        }
    }
}

/// Returns the method written for a link.
pub fn method(net: &Pruned, l: &LiaNode) -> &'static str {
    word(net, l, "method")
}

/// Returns the chosen word of a choice of a link; empty if its kind does not have the choice or none is made.
pub fn word(net: &Pruned, l: &LiaNode, choice: &str) -> &'static str {
    let Some(at) = l.kind.param(choice) else { return "" };
    let Type::Choice(words) = l.kind.params[at].ty else { return "" };
    let value = net.values(l.item, &l.values).get(at).copied().flatten();
    value.and_then(|v| words.get(v as usize)).copied().unwrap_or_default()
}

/// Returns whether this is set-valued friction solved together with others, where it creeps.
pub fn creeps(net: &Pruned, l: &LiaNode) -> bool {
    matches!(l.law.stage, SolveStage::Coupled(_)) && method(net, l) == "set-valued"
}

/// kT²/m up to which the energy of a contact or of a non-linear spring holds to rounding by its method
/// (`methods::potential`, `methods::shared`): the rounding of positions makes at most 1e-14 kT²/m of the peak.
const STIFFEST: f64 = 1e9;

/// zT/m of a contact up to which the same holds.
const MOST_VISCOUS: f64 = 1e3;

/// Returns kT²/m of a contact or non-linear spring, or zT/m of a contact, for which rounding decides the energy of its
/// method, with its name and limit. A law that hardens counts with its slope at load.
pub fn rounds(net: &Pruned, sums: &Accumulated, l: &LiaNode, b: &Bound) -> Option<(f64, &'static str, f64)> {
    if l.law.stage.is_explicit() || !b.contact && b.linear {
        return None;
    }
    let k = if b.hardens || b.varying > 0.0 || b.power.0 > 0.0 { b.k.max(slope_at_load(net, l)) } else { b.k };
    let c = mobility(net, l, &sums.mats);
    // A live viscosity counts with its value, since its range may be unbounded.
    let z = if net.is_live(l.item) { linearisation::slopes(net, l).z } else { b.z };
    let viscous = if b.contact { z * c } else { 0.0 };
    let all = [(k * c, "kT²/m", STIFFEST), (viscous, "zT/m", MOST_VISCOUS)];
    all.into_iter().find(|(a, _, most)| a > most)
}

/// Returns the slope of a law at load \[N/m\], or 0 if its elongation is not known.
fn slope_at_load(net: &Pruned, l: &LiaNode) -> f64 {
    let Some(e) = elongation::at_load(net, l) else { return 0.0 };
    let coefs = loaded(l.law, &net.values(l.item, &l.values), net.tick_dt);
    let [k, _] = (l.law.at_load.steepest)(&coefs, &net.tables, [e, e]);
    if k.is_finite() { k } else { 0.0 }
}

/// Reports methods beyond their limits: a contact too stiff for its energy to be exact, set-valued friction that creeps,
/// and Newton's method where the secant replaces it.
pub fn methods(model: &Model, net: &Pruned, sums: &Accumulated, decides: &mut Decides, diags: &mut Diags) {
    let mut reported = BTreeSet::new();
    for (l, b) in net.lias.iter().zip(&sums.links).filter(|(l, _)| !l.law.stage.is_explicit()) {
        let together = matches!(l.law.stage, SolveStage::Coupled(_));
        let d = if let Some((a, what, most)) = rounds(net, sums, l, b) {
            decides.take(l, a / most);
            let title = format!(
                "`{}` may add energy by rounding: {what} is {:.3}, the limit is {most:e}",
                l.name,
                quantity::Plain(a)
            );
            Diag::warning("W119", title).at(span(model, net, l.item), "stiffer than its method is exact").help(format!(
                "use a smaller `{}`, heavier masses or a higher {} rate",
                &what[..1],
                net.clock()
            ))
        } else if creeps(net, l) {
            decides.take(l, 0.0);
            Diag::warning("W118", format!("`{}` creeps where it should stick", l.name))
                .at(span(model, net, l.item), "solved together with other links, or in space")
                .help(
                    "below its static force it slides at up to `v0` (0.1 mm/s if left out): write a smaller `v0`, or \
                     give each mass only one such link, on a line",
                )
        } else if method(net, l) == "newton" && (together || b.z * mobility(net, l, &sums.mats) >= STEEPEST) {
            let why = if together {
                "it is solved together with other links, or in space".into()
            } else {
                let steep = quantity::Plain(b.z * mobility(net, l, &sums.mats));
                format!("slope·T/m is {steep:.3}, and Newton's method needs a value below 4")
            };
            let help =
                "the secant method is of first order: for more accuracy, raise the sound rate or use a gentler slope";
            Diag::note("N206", format!("`{}` uses the secant method: {why}", l.name))
                .at(span(model, net, l.item), "not by Newton's method")
                .help(help)
        } else {
            continue;
        };
        if reported.insert(l.item) {
            diags.push(d);
        }
    }
}

/// Returns whether a law resists motion along a curve.
pub fn rubs(b: &Bound) -> bool {
    b.curve && b.z > 0.0
}

/// Returns T²/m of both ends of a contact together; for a set, of its most mobile pair.
fn mobility(net: &Pruned, l: &LiaNode, mats: &[Sums]) -> f64 {
    let end = |e: End| {
        let all = net.under(e).into_iter().map(|m| mats[m as usize].c);
        let End::Point(p) = e else { return all.fold(0.0, f64::max) };
        // Each mode moves a modal mass by its share.
        match &net.points[p as usize].shape {
            Some((shares, _)) => all.zip(shares).map(|(c, w)| w * w * c).sum(),
            None => all.fold(0.0, f64::max),
        }
    };
    let Some(sets) = &l.sets else { return l.all_ends().map(end).sum() };
    // The largest mobility and the next.
    let two = |set: &[u32]| {
        set.iter().map(|m| mats[*m as usize].c).fold((0.0f64, 0.0f64), |(a, b), c| (a.max(c), b.max(a.min(c))))
    };
    let (first, next) = two(&sets[0]);
    if sets[1].is_empty() { first + next } else { first + two(&sets[1]).0 }
}

/// Warns of viscosity directly at a device key, which the delay of the device turns into noise and instability (ICMC
/// 2013, 7.1).
pub fn devices(model: &Model, net: &Pruned, bounds: &[Bound], diags: &mut Diags) {
    let is_key = |e: &End| matches!(e, End::Mat(m) if net.mats[*m as usize].code == "TGR");
    let mut reported = BTreeSet::new();
    // A virtual coupling belongs to the key, and respects the friction of the device.
    let written = |l: &LiaNode| model.items[net.items[l.item as usize].model].kind != "TGR";
    for (l, b) in net.lias.iter().zip(bounds) {
        if b.z > 0.0 && written(l) && l.all_ends().any(|e| is_key(&e)) && reported.insert(l.item) {
            let d = Diag::warning("W105", format!("`{}` applies viscosity directly to a device key", l.name))
                .at(span(model, net, l.item), "noisy, and limited by the device's own friction")
                .help("link the key to a MAS by a RES, and damp that MAS to a fixed point instead");
            diags.push(d);
        }
    }
}
