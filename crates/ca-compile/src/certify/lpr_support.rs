//! Support of an LPR: the stiffness between the two ends of its line port.
//!
//! An LPR is in series with the world of its line port: the extension under a force F is F (1/k + χ), with χ the static
//! compliance between the two ends (docs/numerics.md §4.3). Without a connection χ is infinite and the body in space
//! falls apart (W111). If χ is above 1/k, most of the written stiffness is missing (W112). If both ports are on lines,
//! one support is sufficient.
//!
//! Each part of the network that supports LPRs is factorised once, in document order within its envelope, which is a
//! narrow band for strings and meshes. Parts with a wide envelope are only checked for connection. Negative springs
//! (bending) count in the compliance but not as a connection.

use crate::certify::cause::span;
use crate::findings::round_down;
use crate::net::linearisation;
use crate::net::{End, LiaNode, Measure, Pruned};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::{Name, Unit};
use ca_model::diag::{Diag, Diags};
use ca_model::{Model, quantity};

/// Largest number of products in a factorisation.
const WORK: usize = 50_000_000;

/// One degree of freedom: a MAT and an axis.
type Node = usize;

/// Springs of all lines, at load and at rest, without LPRs.
struct Springs {
    /// Stiffness of each node to fixed points, including its own.
    ground: Vec<f64>,
    /// Springs at each node: other end, stiffness.
    around: Vec<Vec<(Node, f64)>>,
    /// True if a moving point has a link, so that stiffness depends on its position.
    moving: bool,
}

fn node(mat: u32, axis: u8) -> Node {
    3 * mat as usize + axis as usize
}

/// Returns the stiffness of a link at rest; 0 for contacts, which may be open.
fn stiffness(net: &Pruned, l: &LiaNode) -> f64 {
    let b = linearisation::slopes(net, l);
    if b.contact { 0.0 } else { b.k }
}

impl Springs {
    fn new(net: &Pruned) -> Springs {
        let n = 3 * net.mats.len();
        let mut s = Springs { ground: alloc::vec![0.0; n], around: alloc::vec![Vec::new(); n], moving: false };
        for (i, m) in net.mats.iter().enumerate() {
            let k = linearisation::own(net, m).k;
            (0..m.axes).for_each(|axis| s.ground[node(i as u32, axis)] = k);
        }
        for (m, before, k) in net.lines.iter().flat_map(|l| l.springs(net.tick_dt)) {
            let i = node(m, 0);
            match before.map(|b| node(b, 0)) {
                None => s.ground[i] += k,
                Some(j) => {
                    s.around[i].push((j, k));
                    s.around[j].push((i, k));
                }
            }
        }
        for l in net.lias.iter().filter(|l| l.onto.is_none()) {
            let Measure::Line([p, q]) = l.measure else { continue };
            let k = stiffness(net, l);
            s.moving |= l.ends.iter().any(|e| matches!(e, End::Point(_)));
            for a in net.under(l.ends[0]) {
                for b in net.under(l.ends[1]) {
                    let fixed = [a, b].map(|m| net.mats[m as usize].is_fixed());
                    let (i, j) = (node(a, p), node(b, q));
                    match fixed {
                        [true, true] => {}
                        [false, true] => s.ground[i] += k,
                        [true, false] => s.ground[j] += k,
                        [false, false] => {
                            s.around[i].push((j, k));
                            s.around[j].push((i, k));
                        }
                    }
                }
            }
        }
        s
    }

    /// Returns the nodes connected to a node by positive springs, in document order.
    fn part(&self, from: Node) -> Vec<Node> {
        let mut seen = BTreeSet::from([from]);
        let mut left = alloc::vec![from];
        while let Some(i) = left.pop() {
            left.extend(self.around[i].iter().filter(|(j, k)| *k > 0.0 && seen.insert(*j)).map(|(j, _)| *j));
        }
        seen.into_iter().collect()
    }
}

/// A connected part, factorised as LLᵀ within the envelope: rows from their first entry to the diagonal.
struct Part {
    nodes: Vec<Node>,
    grounded: bool,
    /// `None` if the envelope is too wide, or if the part is not stiff in every direction.
    rows: Option<Vec<(usize, Vec<f64>)>>,
}

impl Part {
    fn new(s: &Springs, nodes: Vec<Node>) -> Part {
        let grounded = nodes.iter().any(|i| s.ground[*i] > 0.0);
        let rows = if s.moving { None } else { factor(s, &nodes, grounded) };
        Part { nodes, grounded, rows }
    }

    /// Returns the compliance \[m/N\] under forces `pulls` on nodes: the sum of force times displacement.
    fn compliance(&self, pulls: &[(Node, f64)]) -> Option<f64> {
        let rows = self.rows.as_ref()?;
        let mut y = alloc::vec![0.0; rows.len()];
        for (node, pull) in pulls {
            y[self.nodes.binary_search(node).ok()?] += pull;
        }
        // bᵀ K⁻¹ b is the square of L⁻¹ b.
        for i in 0..rows.len() {
            let (first, row) = &rows[i];
            let (last, before) = row.split_last()?;
            let sum: f64 = before.iter().zip(&y[*first..i]).map(|(l, y)| l * y).sum();
            y[i] = (y[i] - sum) / last;
        }
        Some(y.iter().map(|y| y * y).sum())
    }
}

fn factor(s: &Springs, nodes: &[Node], grounded: bool) -> Option<Vec<(usize, Vec<f64>)>> {
    let place = |j: &Node| nodes.binary_search(j).ok();
    let mut rows = Vec::with_capacity(nodes.len());
    let mut work = 0usize;
    for (i, n) in nodes.iter().enumerate() {
        let first = s.around[*n].iter().filter_map(|(j, _)| place(j)).fold(i, usize::min);
        work = work.saturating_add((i - first) * (i - first));
        let mut row = alloc::vec![0.0; i - first + 1];
        row[i - first] = s.ground[*n] + s.around[*n].iter().map(|(_, k)| k).sum::<f64>();
        for (j, k) in &s.around[*n] {
            if let Some(j) = place(j).filter(|j| *j < i) {
                row[j - first] -= k;
            }
        }
        rows.push((first, row));
    }
    if work > WORK {
        return None;
    }
    // A part without ground is held at its first node, where the reaction is 0 because all pulls sum to 0.
    if let (false, Some((_, row))) = (grounded, rows.first_mut()) {
        row[0] *= 2.0;
    }
    for i in 0..rows.len() {
        let (done, rest) = rows.split_at_mut(i);
        let (first, row) = &mut rest[0];
        for j in *first..i {
            let (from, other) = &done[j];
            let start = (*first).max(*from);
            let dot: f64 = row[start - *first..j - *first].iter().zip(&other[start - from..]).map(|(a, b)| a * b).sum();
            row[j - *first] = (row[j - *first] - dot) / other[j - from];
        }
        let (last, before) = row.split_last_mut()?;
        let pivot = *last - before.iter().map(|v| v * v).sum::<f64>();
        if pivot.is_nan() || pivot <= 0.0 {
            return None;
        }
        *last = libm::sqrt(pivot);
    }
    Some(rows)
}

/// Connection between the two ends of a port.
enum Support {
    Nothing,
    /// Compliance \[m/N\]; `None` if it was not computed.
    Gives(Option<f64>),
}

fn support(net: &Pruned, s: &Springs, parts: &mut Vec<Part>, ends: [End; 2], axes: [u8; 2]) -> Support {
    // An end on a string is held if the string is.
    let place =
        |e: End, axis: u8| net.under(e).first().filter(|m| !net.mats[**m as usize].is_fixed()).map(|m| node(*m, axis));
    let at = [place(ends[0], axes[0]), place(ends[1], axes[1])];
    let mut find = |n: Node| {
        parts.iter().position(|p| p.nodes.binary_search(&n).is_ok()).unwrap_or_else(|| {
            parts.push(Part::new(s, s.part(n)));
            parts.len() - 1
        })
    };
    let part = at.map(|n| n.map(&mut find));
    if let ([Some(a), Some(b)], [Some(p), Some(q)]) = (at, part) {
        if p == q {
            return Support::Gives(parts[p].compliance(&[(a, -1.0), (b, 1.0)]));
        }
    }
    if part.iter().flatten().any(|p| !parts[*p].grounded) {
        return Support::Nothing;
    }
    let gives = at.into_iter().zip(part).map(|(n, p)| match (n, p) {
        (Some(n), Some(p)) => parts[p].compliance(&[(n, 1.0)]),
        _ => Some(0.0),
    });
    Support::Gives(gives.sum())
}

/// Checks the line ports of each LPR; at most one finding per item.
pub fn lpr_support(model: &Model, net: &Pruned, diags: &mut Diags) {
    if net.lias.iter().all(|l| l.onto.is_none()) {
        return;
    }
    let springs = Springs::new(net);
    let mut parts = Vec::new();
    let mut reported = BTreeSet::new();
    for l in &net.lias {
        let Some(o) = &l.onto else { continue };
        let k = stiffness(net, l);
        if k <= 0.0 || reported.contains(&l.item) {
            continue;
        }
        let (mut found, mut held) = (None, false);
        for (ends, measure) in [(o.ends, o.measure), (l.ends, l.measure)] {
            let Measure::Line(axes) = measure else { continue };
            let at = span(model, net, l.item);
            let [p, q] = ends.map(|e| net.end_name(e));
            let d = match support(net, &springs, &mut parts, ends, axes) {
                Support::Nothing => nothing(&l.name, [p, q]).at(at, "no stiffness without a support"),
                Support::Gives(Some(soft)) if soft * k > 1.0 => softer(&l.name, [p, q], k, soft).at(at, "softened"),
                Support::Gives(_) => {
                    held = true;
                    break;
                }
            };
            // Of two insufficient ports, report the one with some support.
            found = found.filter(|f: &Diag| f.code == "W112").or(Some(d));
        }
        if let (Some(d), false) = (found, held) {
            reported.insert(l.item);
            diags.push(d);
        }
    }
}

fn nothing(name: &Name, [p, q]: [String; 2]) -> Diag {
    let title = format!("`{name}` has no support: no spring holds `{p}` and `{q}` together");
    Diag::warning("W111", title)
        .help("join them by a `[RES]` or `[REF]`, link each to a `[SOL]`, or make each a `[CEL]`")
}

fn softer(name: &Name, [p, q]: [String; 2], k: f64, soft: f64) -> Diag {
    let newtons = |k: f64| quantity::show(round_down(k), Unit::STIFFNESS);
    let title = format!(
        "the support of `{name}` is softer than `{name}` itself: {} between `{p}` and `{q}`",
        newtons(1.0 / soft)
    );
    let whole = newtons(k / (1.0 + k * soft));
    let help = format!("the two in series have {whole}: use stiffer springs at `{p}` and `{q}`, or a smaller `k` here");
    Diag::warning("W112", title).help(help)
}
