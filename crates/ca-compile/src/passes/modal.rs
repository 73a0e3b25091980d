//! Modal: the linear part of a group by its exact modes (docs/numerics.md §3.1).
//!
//! The masses, cells and linear links of a group with `method = "modal"` become one oscillator per mode, tuned to its
//! exact poles (docs/numerics.md §1.5). Each mass with another link, output or force port becomes a port, i.e. a sum
//! over modes. Forces on the port act on the modes by the same weights, so that no energy is made. The modes are
//! ordinary cells for the certificate and the energy ledger.
//!
//! A mode keeps its mass rather than its static stiffness, so that a blow moves it by the right amount. Damping is
//! assigned to each mode separately, with a warning if it couples them (W115). Modes above half the sound rate are left
//! out. Eigenvectors come from faer, whose last bits depend on the vector instructions of the machine. Other methods
//! have the same bits on all machines.

use crate::analysis::modes::{LARGEST, Mode, modes};
use crate::analysis::{Linear, Network};
use crate::net::linear::{Points, dofs, links};
use crate::net::linearisation;
use crate::net::linearisation::Own;
use crate::net::waveguides::WaveguideNode;
use crate::net::{End, Family, LiaNode, MatNode, MatRole, Measure, Medium, OutputTap, PointNode, Pruned};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::string::ToString;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::kind::name::Part;
use ca_core::internal::kind::{Coefs, MatSpec};
use ca_core::internal::live::Source;
use ca_core::internal::scene::symbols;
use ca_core::internal::tuning::Method;
use ca_core::{Name, Precision, Role};
use ca_model::diag::{Diag, Diags};
use ca_model::{Model, Span};

/// Kind of a mode: its parameters are the coefficients P, Q and C.
static MODE: MatSpec = MatSpec {
    code: symbols::MODE,
    coefs: |p, _| {
        let at = |i: usize| p.get(i).copied().flatten().unwrap_or(0.0);
        Coefs { p: at(0), q: at(1), c: at(2) }
    },
    fixed: false,
};

/// Coupling by damping above this is more than rounding.
const COUPLED: f64 = 1e-9;

/// Replaces the linear part of each modal group.
pub fn modal(model: &Model, net: &mut Pruned, diags: &mut Diags) {
    // Each group inserts a medium of modes before the last, the medium of the model, whose index therefore changes.
    for group in 0..net.media.len() {
        let group = if group < model.groups.len() { group } else { net.media.len() - 1 };
        if net.media[group].method == Method::Modal {
            one(model, net, group, diags);
        }
    }
}

/// Returns whether a module belongs to the group; the last medium is for modules without a group.
fn belongs(net: &Pruned, of: Option<u32>, group: usize) -> bool {
    of.map_or(net.media.len() - 1, |g| g as usize) == group
}

/// Returns whether a link becomes part of the modes.
fn inside(net: &Pruned, l: &LiaNode, within: &[bool], group: usize) -> bool {
    let mut ends = l.ends.iter();
    let held = ends.all(|e| matches!(e, End::Mat(m) if within[*m as usize] || net.mats[*m as usize].is_still()));
    held && belongs(net, net.items[l.item as usize].group, group)
        && l.law.linear
        && !l.law.implicit
        && matches!(l.measure, Measure::Line(_))
        && l.onto.is_none()
}

impl MatNode {
    /// Returns whether neither forces nor inputs move it.
    fn is_still(&self) -> bool {
        matches!(self.role, MatRole::Mat(s) if s.fixed)
    }
}

fn refuse(model: &Model, net: &Pruned, item: u32, code: &'static str, title: String, help: &str) -> Diag {
    let span: Span = model.items[net.items[item as usize].model].name_span;
    Diag::error(code, title).at(span, "in a modal group").help(help)
}

fn one(model: &Model, net: &mut Pruned, group: usize, diags: &mut Diags) {
    let mut within: Vec<bool> = net
        .mats
        .iter()
        .zip(&net.alive)
        .map(|(m, alive)| *alive && !m.is_fixed() && !m.in_space() && belongs(net, m.group, group))
        .collect();
    // Waveguide junctions are exact without modes.
    for m in net.lines.iter().flat_map(WaveguideNode::junctions) {
        within[m as usize] = false;
    }
    let Some(first) = within.iter().position(|w| *w) else { return };
    let item = net.mats[first].item;
    let name = model.groups.get(group).map_or_else(|| "the model".into(), |g| format!("`{}`", g.name));
    if let Some(d) = obstacle(model, net, &within, &name, item, group) {
        diags.push(d);
        return;
    }
    let keep: Vec<bool> = net.lias.iter().map(|l| !inside(net, l, &within, group)).collect();
    let own: Vec<Own> = net
        .mats
        .iter()
        .zip(&within)
        .map(|(m, w)| if *w { linearisation::own(net, m) } else { Own::default() })
        .collect();
    let bounds: Vec<_> = net.lias.iter().map(|l| linearisation::slopes(net, l)).collect();
    let (mut linear, numbers) = dofs(net, &own);
    links(net, &bounds, &numbers, Points::AtLoad, &mut linear, |l, _| inside(net, l, &within, group));
    let tick_dt = net.tick_dt;
    let network = Network { tick_dt, linear, ..Network::default() };
    let Some(mut found) = modes(&network) else {
        let title = format!(
            "{name} has {} degrees of freedom, or coefficients that cannot be computed",
            network.linear.dofs.len()
        );
        let help = format!(
            "modes are computed for up to {LARGEST} degrees of freedom: use `method = \"ca\"`, or a smaller group"
        );
        diags.push(refuse(model, net, item, "E027", title, &help));
        return;
    };
    if net.precision == Precision::Dual {
        found.list.iter_mut().for_each(oriented);
    }
    warn(model, net, item, &found.list, &name, diags);
    let kept: Vec<&Mode> = found.list.iter().filter(|m| m.a < core::f64::consts::PI * core::f64::consts::PI).collect();
    if kept.len() < found.list.len() {
        net.left_out.push(format!("{} modes of {name} above half the sound rate", found.list.len() - kept.len()));
    }
    let most = network.linear.dofs.iter().map(|p| p.c).fold(0.0, f64::max);
    let modes = oscillators(net, &network.linear, &kept, most, item);
    // Other links, outputs and force ports act on its masses at ports.
    let mut ports: BTreeMap<u32, u32> = BTreeMap::new();
    let row: BTreeMap<u32, usize> = network.linear.dofs.iter().enumerate().map(|(i, p)| (p.mat, i)).collect();
    let family = format!("{name} modes");
    let mut points = core::mem::take(&mut net.points);
    let wired = &mut net.wired;
    let mats = &wired.resolved.mats;
    let mut port = |end: &mut End| {
        let End::Mat(m) = *end else { return };
        let Some(i) = row.get(&m) else { return };
        let id = *ports.entry(m).or_insert_with(|| {
            let weights = kept.iter().map(|k| k.shape[*i] * tick_dt / libm::sqrt(most)).collect();
            let mat = &mats[m as usize];
            let shape = Some((weights, mat.rest));
            points.push(PointNode { name: mat.name.to_string(), family: family.clone(), at: Vec::new(), shape });
            points.len() as u32 - 1
        });
        *end = End::Point(id);
    };
    for (l, _) in wired.resolved.lias.iter_mut().zip(&keep).filter(|(_, keep)| **keep) {
        l.ends.iter_mut().for_each(&mut port);
        l.onto.iter_mut().for_each(|o| o.ends.iter_mut().for_each(&mut port));
    }
    for o in &mut wired.outs {
        if let OutputTap::Position(e) | OutputTap::ForceOn(e) = &mut o.tap {
            port(e);
        }
    }
    wired.pushes.iter_mut().for_each(|p| port(&mut p.end));
    net.points = points;
    net.families.insert(&Arc::from(family.as_str()), Family { nodes: modes, ..Family::default() });
    within.iter().zip(&mut net.alive).filter(|(w, _)| **w).for_each(|(_, alive)| *alive = false);
    let lias = core::mem::take(&mut net.lias);
    net.drop_links(lias, &keep);
}

/// Fixes the sign of a shape, so that it does not depend on rounding: derivatives use differences of scenes compiled
/// around a parameter value. The sound keeps its bits. The sign comes from a sum whose weights are asymmetric, so that
/// it does not vanish for symmetric shapes.
fn oriented(mode: &mut Mode) {
    let weights = (0..mode.shape.len()).map(|i| 1.0 + 0.618_033_988_749_895 * i as f64 % 1.0);
    if weights.zip(&mode.shape).map(|(w, v)| w * v).sum::<f64>() < 0.0 {
        mode.shape.iter_mut().for_each(|v| *v = -*v);
    }
}

fn obstacle(model: &Model, net: &Pruned, within: &[bool], name: &str, item: u32, group: usize) -> Option<Diag> {
    let refuse = |item, code, title, help| Some(refuse(model, net, item, code, title, help));
    let touches = |l: &LiaNode| l.all_ends().any(|e| net.under(e).iter().any(|m| within[*m as usize]));
    let of = |i: u32| &*net.items[i as usize].name;
    if net.media[group].gravity != [0.0; 3] {
        return refuse(
            item,
            "E028",
            format!("{name} has `method = \"modal\"`, which does not support gravity"),
            "use `gravity` only in other groups",
        );
    }
    let mut mats = net.mats.iter().zip(within).filter(|(_, w)| **w).map(|(m, _)| m.item);
    let mut links = net.lias.iter().filter(|l| inside(net, l, within, group)).map(|l| l.item);
    if let Some(i) = mats.find(|i| net.is_live(*i)).or_else(|| links.find(|i| net.is_live(*i))) {
        let title = format!("{name} has `method = \"modal\"`, but `{}` follows a live parameter", of(i));
        return refuse(i, "E028", title, "use a number, because modes are computed once, or `method = \"ca\"`");
    }
    for (i, l) in net.lias.iter().enumerate().filter(|(_, l)| touches(l)) {
        let heard = net.outs.iter().any(|o| o.tap == OutputTap::ForceOf(i as u32));
        if inside(net, l, within, group) && heard {
            let title = format!("{name} has `method = \"modal\"`, so an output cannot read the force of `{}`", l.name);
            return refuse(
                l.item,
                "E028",
                title,
                "read a mass, or a link that is not part of the modes, or use `method = \"ca\"`",
            );
        }
        if l.law.implicit || !l.law.stage.is_explicit() && l.onto.is_some() {
            let title = format!("`{}` is implicit at a mass of {name}, which has `method = \"modal\"`", l.name);
            return refuse(l.item, "E028", title, "use `method = \"ca\"` for one of them");
        }
    }
    let points = net.points.iter().find(|p| net.families.of(&p.family).nodes.iter().any(|m| within[*m as usize]))?;
    let title = format!("{name} has `method = \"modal\"`, so the point `{}` cannot move along it", points.name);
    refuse(item, "E028", title, "use a mass such as `low[8]`, or `method = \"ca\"`")
}

fn warn(model: &Model, net: &Pruned, item: u32, list: &[Mode], name: &str, diags: &mut Diags) {
    let most = list.iter().map(|m| m.coupled).fold(0.0, f64::max);
    if most > COUPLED {
        let span = model.items[net.items[item as usize].model].name_span;
        let title = format!("damping couples the modes of {name}, but the scene ignores this coupling");
        let d = Diag::warning("W115", title).at(span, format!("by up to {most:.1e} of their distance"));
        diags.push(
            d.help("damp all masses in proportion to their mass, or use `method = \"ca\"` where the coupling matters"),
        );
    }
}

/// Adds the modes as MATs with the initial state of their masses, and returns their numbers.
fn oscillators(net: &mut Pruned, linear: &Linear, kept: &[&Mode], most: f64, item: u32) -> Vec<u32> {
    let tick_dt = net.tick_dt;
    // A medium without friction: the modes contain the friction of the masses.
    let medium = net.media.len() as u32 - 1;
    net.media.insert(medium as usize, Medium::default());
    let from_lpr = linear.dofs.iter().any(|p| net.from_lpr.get(p.mat as usize) == Some(&true));
    let group = Arc::from(model_name(net, item));
    let mut numbers = Vec::with_capacity(kept.len());
    for (j, mode) in kept.iter().enumerate() {
        // Mass-normalised: q = Σ φ m x.
        let project = |of: &dyn Fn(&MatNode) -> f64| -> f64 {
            let sum: f64 =
                linear.dofs.iter().zip(&mode.shape).map(|(p, u)| u / p.c * of(&net.mats[p.mat as usize])).sum();
            sum * tick_dt * libm::sqrt(most)
        };
        let (x, v) = (project(&|m| m.dx0[0]), project(&|m| m.v[0]));
        let (a, b, before) = exact(mode, x, v * tick_dt);
        // The start of a scene subtracts half a tick of spring and damper again.
        let d = (x - before + 0.5 * -a * x) / (1.0 + 0.5 * b);
        let d = if d.is_finite() { d } else { v * tick_dt };
        numbers.push(net.mats.len() as u32);
        net.mats.push(MatNode {
            name: Name::new(&group, Part::Mode, j.into()),
            code: symbols::MODE,
            role: MatRole::Mat(&MODE),
            values: Arc::from([Source::Const(1.0 - b), Source::Const(-a), Source::Const(most)]),
            axes: 1,
            rest: [0.0; 3],
            dx0: [x, 0.0, 0.0],
            v: [d / tick_dt, 0.0, 0.0],
            group: Some(medium),
            item,
        });
        net.alive.push(true);
        if !net.from_lpr.is_empty() {
            net.from_lpr.push(from_lpr);
        }
    }
    numbers
}

fn model_name(net: &Pruned, item: u32) -> String {
    let name = &net.items[item as usize].name;
    match (name.split_once('.'), net.items[item as usize].kind.role) {
        (Some((group, _)), _) => group.into(),
        (None, Role::Generator(_)) => name.to_string(),
        (None, _) => "model".into(),
    }
}

/// Returns stiffness a and viscosity b for which the scheme has the exact poles of a mode, and its displacement one
/// tick earlier, from displacement `x` and speed `v` per tick.
fn exact(mode: &Mode, x: f64, v: f64) -> (f64, f64, f64) {
    let s = 0.5 * mode.b;
    let square = mode.a - s * s;
    if square > 0.0 {
        let theta = libm::sqrt(square);
        let (q, half) = (-libm::expm1(-s), libm::sin(0.5 * theta));
        let r = 1.0 - q;
        let a = q * q + 4.0 * r * half * half;
        let (sin, cos) = libm::sincos(theta);
        return (a, -libm::expm1(-2.0 * s), libm::exp(s) * (x * cos - (v + s * x) / theta * sin));
    }
    // Two real poles, e^(−s ± g).
    let g = libm::sqrt(-square);
    let (slow, fast) = (mode.a / (s + g).max(f64::MIN_POSITIVE), s + g);
    let (p, q) = (-libm::expm1(-slow), -libm::expm1(-fast));
    // sinh(g)/g tends to 1 for a double pole; a free mode moves uniformly.
    let shape = if g > 0.0 { libm::sinh(g) / g } else { 1.0 };
    (p * q, p + q - p * q, libm::exp(s) * (x * libm::cosh(g) - (v + s * x) * shape))
}
