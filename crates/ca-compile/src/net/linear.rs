//! Builds matrices from the network: the degrees of freedom (dofs), and the row of each link at the pose of load.
//!
//! A link at a moving point becomes one link per node under the point. Its row is a mean of their rows, so a bound that
//! holds for each of them holds wherever the point is.

use crate::analysis::{Dof, Linear, MovingLink, Network, Port};
use crate::net::linearisation;
use crate::net::linearisation::Own;
use crate::net::waveguides::WaveguideNode;
use crate::net::{Coordinate, End, LiaNode, MatNode, MatRole, Measure, OutNode, OutputTap, Pruned, Wired};
use alloc::string::String;
use alloc::string::ToString;
use alloc::vec::Vec;
use ca_core::Bound;
use ca_core::internal::io::Hear;
use ca_core::internal::op::pass;
use ca_core::internal::tuning::Scheme;

/// Assumed positions of moving points: at load, or any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    AtLoad,
    Anywhere,
}

/// First dof of each MAT in the linear network; `None` for a MAT that does not move.
pub struct Numbers(Vec<Option<u32>>);

/// Returns the dofs of a network, without links.
pub fn dofs(net: &Wired, own: &[Own]) -> (Linear, Numbers) {
    let mut linear = Linear::default();
    let mut numbers = Vec::with_capacity(net.mats.len());
    for (i, (m, own)) in net.mats.iter().zip(own).enumerate() {
        let moves = own.c > 0.0;
        numbers.push(moves.then_some(linear.dofs.len() as u32));
        let axes = if moves { m.axes } else { 0 };
        linear.dofs.extend((0..axes).map(|axis| Dof {
            mat: i as u32,
            axis,
            c: own.c,
            k: own.k,
            z: own.z,
            implicit: own.implicit,
        }));
    }
    (linear, Numbers(numbers))
}

/// Largest number of combinations of nodes that the points of one link may have.
const SPOTS: usize = 10_000;

/// Adds the links for which `counts` holds, with their slopes. Returns false if such a link cannot be added: a set of
/// pairs, or one with points that have more than `SPOTS` combinations of nodes.
pub fn links(
    net: &Wired,
    bounds: &[Bound],
    numbers: &Numbers,
    points: Points,
    linear: &mut Linear,
    counts: impl Fn(&LiaNode, &Bound) -> bool,
) -> bool {
    let mut all = true;
    for (i, (l, b)) in net.lias.iter().zip(bounds).enumerate().filter(|(_, (l, b))| counts(l, b)) {
        let spots = l.all_ends().map(|e| net.spots(e)).fold(1, usize::saturating_mul);
        if l.sets.is_some() || (points == Points::Anywhere && spots > SPOTS) {
            all = false;
            continue;
        }
        for row in rows(net, l, b, numbers, points) {
            match row {
                Pull::At(k, z, entries) => {
                    let implicit = 0.25 * b.lift * k + if b.centred { 0.5 * b.z * z } else { 0.0 };
                    linear.link(i as u32, [b.k * k, b.z * z, implicit], &entries);
                }
                Pull::Anywhere(at) => linear.moving_links.push(MovingLink { k: b.k, z: b.z, at }),
            }
        }
    }
    all
}

/// Purpose of a linear network, which decides its coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Modes: cells tuned in a modal group have the coefficients of the mode itself.
    Modes,
    /// The tick: coefficients as stored. Position ports have numbers too, after all that moves.
    Tick,
}

/// Returns the linear part of a network at load, with its inputs and outputs.
pub fn network(net: &Pruned, purpose: Purpose) -> Network {
    let of = match purpose {
        Purpose::Modes => linearisation::own,
        Purpose::Tick => linearisation::stored,
    };
    let mats = net.mats.iter().zip(&net.alive);
    let mut own: Vec<Own> = mats.map(|(m, alive)| if *alive { of(net, m) } else { Own::default() }).collect();
    // Delays are not a matrix: links at a waveguide are reported as if it stood still.
    net.lines.iter().flat_map(WaveguideNode::junctions).for_each(|m| own[m as usize] = Own::default());
    let slopes: Vec<Bound> = net.lias.iter().map(|l| linearisation::slopes(net, l)).collect();
    let (mut linear, mut numbers) = dofs(net, &own);
    let mut driven = Vec::new();
    if purpose == Purpose::Tick {
        let moving = linear.dofs.len();
        for ((m, alive), first) in net.mats.iter().zip(&net.alive).zip(&mut numbers.0) {
            let MatRole::Port(_, inputs) = m.role else { continue };
            if *alive && inputs.iter().any(Option::is_some) {
                *first = Some((moving + driven.len()) as u32);
                driven.extend(
                    inputs.iter().take(m.axes as usize).map(|i| i.map(|i| net.inputs[i as usize].name.clone())),
                );
            }
        }
    }
    let counts = |l: &LiaNode, b: &Bound| b.linear && l.law.stage.is_explicit();
    let whole = links(net, &slopes, &numbers, Points::AtLoad, &mut linear, counts);
    debug_assert!(whole, "the laws of sets are not linear");
    let (mut ports, mut derivatives, mut force_outputs): (Vec<Port>, Vec<Port>, Vec<String>) = Default::default();
    // Last port and channel: a probe may have the name of an output.
    let mut last: Option<(&str, u32)> = None;
    for OutNode { name, tap, quantity: hear, axis, share, channel, .. } in &net.outs {
        let (axis, share, channel) = (*axis, *share, *channel);
        let still = *hear == Hear::Position;
        // Once per output, for any number of modules and axes.
        if !(still && matches!(tap, OutputTap::Position(_))) && force_outputs.last() != Some(name) {
            force_outputs.push(name.clone());
        }
        let (OutputTap::Position(end), Hear::Position | Hear::Speed | Hear::Acceleration) = (*tap, *hear) else {
            continue;
        };
        let here = at_end(net, end, &numbers, Points::AtLoad, |first, _| alloc::vec![(first + u32::from(axis), share)]);
        let here = here.into_iter().flatten();
        // A direction has one output node per axis; they become one port.
        let same = last.replace((name, channel)) == Some((name, channel));
        let of = if still { &mut ports } else { &mut derivatives };
        match of.last_mut().filter(|_| same) {
            Some(port) => port.at.extend(here),
            None => of.push(Port { name: name.clone(), role: "hears", at: here.collect() }),
        }
    }
    for p in &net.pushes {
        let here =
            at_end(net, p.end, &numbers, Points::AtLoad, |first, _| alloc::vec![(first + u32::from(p.axis), 1.0)]);
        let name = net.inputs[p.input as usize].name.clone();
        ports.push(Port { name, role: "pushes", at: here.into_iter().flatten().collect() });
    }
    let mut left_out: Vec<(u32, &str)> =
        net.lines.iter().map(|l| (l.item, net.items[l.item as usize].kind.code)).collect();
    for (l, b) in net.lias.iter().zip(&slopes).filter(|(l, b)| !counts(l, b)) {
        if left_out.last().is_some_and(|o| o.0 == l.item) {
            continue;
        }
        left_out.push((l.item, l.law.code));
        if l.sets.is_none() {
            let row = rows(net, l, b, &numbers, Points::AtLoad).into_iter().next();
            if let Some(Pull::At(_, _, at)) = row {
                ports.push(Port { name: l.name.to_string(), role: "acts", at });
            }
        }
    }
    let names = linear.dofs.iter().map(|p| {
        let m = &net.mats[p.mat as usize];
        if m.in_space() {
            alloc::format!("{}.{}", m.name, ["x", "y", "z"][p.axis as usize % 3])
        } else {
            m.name.to_string()
        }
    });
    let at = |p: &Dof, of: fn(&MatNode) -> [f64; 3]| of(&net.mats[p.mat as usize])[p.axis as usize];
    Network {
        tick_dt: net.tick_dt,
        oversample: net.oversample,
        composed: net.is_composed(),
        modal: linear.dofs.iter().all(|p| {
            let m = &net.mats[p.mat as usize];
            !m.in_space() && net.scheme(m.group) == Scheme::Modal
        }),
        constant: constant(net, &slopes, &linear),
        x: linear.dofs.iter().map(|p| at(p, |m| m.dx0)).collect(),
        v: linear.dofs.iter().map(|p| at(p, |m| m.v)).collect(),
        names: names.collect(),
        link_names: linear.rows.iter().map(|r| net.lias[r.lia as usize].name.to_string()).collect(),
        other_scheme: other_scheme(net, &linear),
        driven,
        ports,
        derivatives,
        force_outputs,
        left_out: left_out.into_iter().map(|(i, code)| (net.items[i as usize].name.to_string(), code)).collect(),
        unheard: names_without_output(net),
        linear,
    }
}

/// Returns the constant force on each dof \[N\].
fn constant(net: &Pruned, slopes: &[Bound], linear: &Linear) -> Vec<f64> {
    let mat = |p: &Dof| &net.mats[p.mat as usize];
    let weight = |p: &Dof| match net.medium(mat(p)).gravity[p.axis as usize] {
        0.0 => 0.0,
        g => net.tick_dt * net.tick_dt / p.c * g,
    };
    let mut all: Vec<f64> = linear.dofs.iter().map(weight).collect();
    for row in linear.rows.chunk_by(|a, b| a.lia == b.lia).filter_map(<[_]>::first) {
        let l = &net.lias[row.lia as usize];
        // A link measured along a line, without a written length, exerts no force at rest.
        if l.l0.is_none() && !l.is_radial() {
            continue;
        }
        let ports = core::iter::once((l.ends, l.measure)).chain(l.onto.iter().map(|o| (o.ends, o.measure)));
        let pulled: f64 = ports.enumerate().map(|(i, (ends, m))| stretch(net, l, ends, m, i == 0)).sum();
        let entries = linear.entries(row);
        let moved = |i: u32| linear.dofs.get(i as usize).map_or(0.0, |p| mat(p).dx0[p.axis as usize]);
        let by_places: f64 = entries.iter().map(|(i, w)| w * moved(*i)).sum();
        let force = slopes[row.lia as usize].k * (pulled - by_places);
        for (i, w) in entries {
            if let Some(f) = all.get_mut(*i as usize) {
                *f -= w * force;
            }
        }
    }
    all
}

/// Returns the setting, if any, by which some dofs do not move by forces at their own positions.
fn other_scheme(net: &Pruned, linear: &Linear) -> Option<&'static str> {
    let group = |i: u32| linear.dofs.get(i as usize).and_then(|p| net.mats[p.mat as usize].group);
    let linked = || linear.rows.iter().flat_map(|r| linear.entries(r)).map(|e| e.0);
    match () {
        () if net.is_composed() => Some("method = \"pefrl\""),
        () if linear.dofs.iter().any(|p| net.medium_of(net.mats[p.mat as usize].group).slow) => {
            Some("rate = \"gesture\"")
        }
        // A mass without links is a mode by itself and moves like any other.
        () if linked().any(|i| net.scheme(group(i)) == Scheme::Modal) => Some("method = \"modal\""),
        () => None,
    }
}

/// Returns the names of modules that no output depends on; for an item kept in part, the names of its members.
fn names_without_output(net: &Pruned) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let mut all = alloc::vec![0_usize; net.items.len()];
    net.mats.iter().filter(|m| !m.is_fixed()).for_each(|m| all[m.item as usize] += 1);
    for of in net.without_output.chunk_by(|a, b| net.mats[*a as usize].item == net.mats[*b as usize].item) {
        let Some(item) = of.first().map(|m| net.mats[*m as usize].item) else { continue };
        if of.len() == all[item as usize] {
            names.push(net.items[item as usize].name.to_string());
        } else {
            names.extend(of.iter().map(|m| net.mats[*m as usize].name.to_string()));
        }
    }
    names
}

/// One row of a link as a share of its slopes, or all rows that its moving points make possible.
pub enum Pull {
    /// Shares of stiffness and of viscosity, and the row.
    At(f64, f64, Vec<(u32, f64)>),
    /// One row for each combination of nodes.
    Anywhere(Vec<Vec<(u32, f64)>>),
}

/// Returns the rows of a link: its own and, for a link in space under tension, those across it.
pub fn rows(net: &Wired, l: &LiaNode, b: &Bound, numbers: &Numbers, points: Points) -> Vec<Pull> {
    let ports: Vec<_> =
        core::iter::once((l.ends, l.measure)).chain(l.onto.iter().map(|o| (o.ends, o.measure))).collect();
    // Per port its direction, per end the nodes it may be at.
    let mut choices: Vec<Vec<(u32, f64)>> = alloc::vec![Vec::new()];
    for (ends, measure) in &ports {
        for (side, end) in ends.iter().enumerate() {
            let sign = if side == 0 { -1.0 } else { 1.0 };
            let pulls = at_end(net, *end, numbers, points, |first, axes| {
                direction(net, *ends, *measure, l.soften, side, axes)
                    .map(|(k, u)| (first + u32::from(k), sign * u))
                    .collect()
            });
            choices = choices.iter().flat_map(|c| pulls.iter().map(|p| c.iter().chain(p).copied().collect())).collect();
        }
    }
    if choices.len() > 1 {
        return alloc::vec![Pull::Anywhere(choices)];
    }
    let mut rows: Vec<Pull> = choices.into_iter().map(|c| Pull::At(1.0, 1.0, c)).collect();
    if !(b.k > 0.0 && b.linear) {
        return rows;
    }
    // Tension adds the stiffness F/l across the link, and no viscosity.
    let pulled: f64 = ports.iter().enumerate().map(|(i, (ends, m))| stretch(net, l, *ends, *m, i == 0)).sum();
    for (ends, _) in ports.iter().filter(|(_, m)| *m == Measure::Radial) {
        let (u, length) = unit(net, *ends, l.soften);
        let tension = pulled / length;
        if !(tension > 0.0 && tension.is_finite()) {
            continue;
        }
        for k in 0..3_u8 {
            // I − uuᵀ row by row: it is a projection, so the outer products of its rows sum to itself.
            let across: [f64; 3] =
                core::array::from_fn(|j| f64::from(u8::from(j == k as usize)) - u[k as usize] * u[j]);
            let mut entries = Vec::new();
            for (end, sign) in ends.iter().zip([-1.0, 1.0]) {
                let End::Mat(m) = end else { continue };
                let Some(first) = numbers.0[*m as usize] else { continue };
                let axes = 0..net.mats[*m as usize].axes;
                entries.extend(axes.map(|j| (first + u32::from(j), sign * across[j as usize])));
            }
            rows.push(Pull::At(tension, 0.0, entries));
        }
    }
    rows
}

/// Returns the extension of a port at load \[m\]: 0 if no end is displaced and no length is written.
fn stretch(net: &Wired, l: &LiaNode, ends: [End; 2], measure: Measure, first: bool) -> f64 {
    let rest = net.rest_vector(ends);
    let (from, to) = (moved(net, ends[0]), moved(net, ends[1]));
    let by: [f64; 3] = core::array::from_fn(|k| to[k] - from[k]);
    let written = if first { l.l0 } else { None };
    match measure {
        Measure::Line([a, b]) => {
            let apart = net.rest(ends[1])[b as usize] - net.rest(ends[0])[a as usize];
            apart + to[b as usize] - from[a as usize] - written.unwrap_or(apart)
        }
        Measure::Along(n) => {
            let dot = |v: [f64; 3]| n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
            dot(rest) + dot(by) - written.unwrap_or(dot(rest))
        }
        Measure::Radial => {
            let soft = |v: f64| libm::sqrt(v * v + l.soften * l.soften);
            let slack = written.unwrap_or(libm::sqrt(rest.iter().map(|x| x * x).sum()));
            unit(net, ends, l.soften).1 - soft(slack)
        }
    }
}

/// Returns how a pull on an end acts on the dofs under it: one list for each node that it may be at.
fn at_end(
    net: &Wired,
    end: End,
    numbers: &Numbers,
    points: Points,
    pull: impl Fn(u32, u8) -> Vec<(u32, f64)>,
) -> Vec<Vec<(u32, f64)>> {
    let on = |m: u32| {
        let axes = net.mats[m as usize].axes;
        numbers.0[m as usize].map(|first| pull(first, axes)).unwrap_or_default()
    };
    let End::Point(p) = end else {
        let End::Mat(m) = end else { return alloc::vec![Vec::new()] };
        return alloc::vec![on(m)];
    };
    let point = &net.points[p as usize];
    let family = net.families.of(&point.family);
    if let Some((weights, _)) = &point.shape {
        let all = family.nodes.iter().zip(weights).flat_map(|(m, w)| on(*m).into_iter().map(move |(i, u)| (i, u * w)));
        return alloc::vec![all.collect()];
    }
    let stands = |c: &Coordinate| match *c {
        Coordinate::At(v) => Some(v),
        _ if points == Points::Anywhere => None,
        Coordinate::Live(p) => Some(net.params[p as usize].value),
        Coordinate::Port(m) => Some(net.mats[m as usize].rest[0]),
    };
    let still: Option<Vec<f64>> = point.at.iter().map(stands).collect();
    let Some(at) = still else { return family.nodes.iter().map(|m| on(*m)).collect() };
    let size = family.size;
    let steps = [0, 1].map(|k| {
        let (i, part) = pass::step(at.get(k).copied().unwrap_or(0.0).clamp(0.0, 1.0), size[k].max(1));
        (i, part)
    });
    let mut here = Vec::new();
    for (i, a) in [(steps[0].0, 1.0 - steps[0].1), (steps[0].0 + 1, steps[0].1)] {
        for (j, b) in [(steps[1].0, 1.0 - steps[1].1), (steps[1].0 + 1, steps[1].1)] {
            let node = family.nodes.get((i * size[1].max(1) + j) as usize).filter(|_| a * b > 0.0);
            here.extend(node.into_iter().flat_map(|m| on(*m)).map(|(place, u)| (place, u * a * b)));
        }
    }
    alloc::vec![here]
}

/// Returns the axes, with weights, by which a port measures one of its ends.
fn direction(
    net: &Wired,
    ends: [End; 2],
    measure: Measure,
    soften: f64,
    side: usize,
    axes: u8,
) -> impl Iterator<Item = (u8, f64)> {
    let u = match measure {
        Measure::Line(axis) => core::array::from_fn(|k| f64::from(u8::from(k == axis[side] as usize))),
        Measure::Along(n) => n,
        Measure::Radial => unit(net, ends, soften).0,
    };
    (0..axes).map(move |k| (k, u[k as usize])).filter(|(_, u)| *u != 0.0)
}

/// Returns the displacement of an end from its rest position at load.
fn moved(net: &Wired, e: End) -> [f64; 3] {
    if let End::Mat(m) = e { net.mats[m as usize].dx0 } else { [0.0; 3] }
}

/// Returns the direction and length from the first to the second end at load.
fn unit(net: &Wired, ends: [End; 2], soften: f64) -> ([f64; 3], f64) {
    let (rest, from, to) = (net.rest_vector(ends), moved(net, ends[0]), moved(net, ends[1]));
    let v: [f64; 3] = core::array::from_fn(|k| rest[k] + to[k] - from[k]);
    let length = libm::sqrt(v.iter().map(|x| x * x).sum::<f64>() + soften * soften).max(f64::MIN_POSITIVE);
    (v.map(|x| x / length), length)
}
