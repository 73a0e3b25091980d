//! Finds meshes: masses whose labels end in `row_column`, each linked to its neighbours.
//!
//! The whole lattice is taken if it is a rectangle of masses with some nodes held: all of the border, the four corners,
//! or any others, which are then listed. Otherwise the largest rectangle of masses is taken. The rest goes to
//! [`super::chain`] or is written singly.

use super::generator_plan::{Generator, GeneratorPlan};
use super::graph::{Graph, Law, key, medium};
use super::names::{Names, stem};
use super::part::Arg;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;

/// Smallest number of nodes along the shorter side of a mesh that is written as a generator.
const SMALLEST: usize = 3;

/// Nodes by place, their common inertia and law, and the links between neighbours.
struct Lattice {
    nodes: Vec<Option<usize>>,
    rows: usize,
    cols: usize,
    m: Arg,
    law: Law,
    links: BTreeMap<(usize, usize), usize>,
}

#[derive(Clone, Copy)]
struct Area {
    i0: usize,
    i1: usize,
    j0: usize,
    j1: usize,
}

impl Area {
    fn size(self) -> usize {
        (self.i1 - self.i0) * (self.j1 - self.j0)
    }
}

pub(super) fn meshes(graph: &Graph<'_>, names: &mut Names, plan: &mut GeneratorPlan) {
    let mut groups: BTreeMap<&str, Vec<(usize, usize, usize)>> = BTreeMap::new();
    for (part, p) in graph.parts.iter().enumerate() {
        if (graph.mass(part).is_some() || graph.is_ground(part))
            && let Some((base, i, j)) = place(&p.name)
        {
            groups.entry(base).or_default().push((i, j, part));
        }
    }
    let mut groups: Vec<_> = groups.into_values().collect();
    groups.sort_by_key(|g| g.iter().map(|n| n.2).min());
    for group in groups {
        let Some(lattice) = lattice(graph, &group) else { continue };
        let whole = Area { i0: 0, i1: lattice.rows, j0: 0, j1: lattice.cols };
        let bordered = ["closed", "corner"].into_iter().find(|e| lattice.is_whole(graph, e)).map(|e| (e, whole));
        if let Some((edges, area)) = bordered {
            lattice.write(graph, edges, Vec::new(), area, names, plan);
        } else if let Some(fixed) = lattice.held(graph) {
            lattice.write(graph, "open", fixed, whole, names, plan);
        } else if let Some(area) = lattice.largest(graph) {
            lattice.write(graph, "open", Vec::new(), area, names, plan);
        }
    }
}

/// Splits a label: `mesh_m3_12` is (`mesh_m`, 3, 12).
fn place(label: &str) -> Option<(&str, usize, usize)> {
    let (left, j) = label.rsplit_once('_')?;
    let base = left.trim_end_matches(|c: char| c.is_ascii_digit());
    let i = left.get(base.len()..)?;
    let small = |s: &str| if s.len() <= 6 { s.parse::<usize>().ok() } else { None };
    Some((base, small(i)?, small(j)?))
}

fn lattice(graph: &Graph<'_>, group: &[(usize, usize, usize)]) -> Option<Lattice> {
    if group.len() < SMALLEST * SMALLEST {
        return None;
    }
    let (i0, i1) = (group.iter().map(|n| n.0).min()?, group.iter().map(|n| n.0).max()?);
    let (j0, j1) = (group.iter().map(|n| n.1).min()?, group.iter().map(|n| n.1).max()?);
    let (rows, cols) = (i1 - i0 + 1, j1 - j0 + 1);
    if rows.checked_mul(cols).is_none_or(|n| n > 4 * group.len()) {
        return None;
    }
    let mut nodes = vec![None; rows * cols];
    let mut places = BTreeMap::new();
    for &(i, j, part) in group {
        let at = (i - i0) * cols + (j - j0);
        if nodes[at].is_none() {
            nodes[at] = Some(part);
            places.insert(part, (i, j));
        }
    }
    let m = commonest(places.keys().filter_map(|&p| graph.mass(p)).map(|m| (m.key(), m)))?;
    let mut near: Vec<(usize, usize, usize, Law)> = Vec::new();
    for (&a, &(i, j)) in &places {
        for &link in &graph.links[a] {
            let b = graph.other_end(link, a);
            let (Some(law), Some(&(ib, jb))) = (graph.law(link), places.get(&b)) else { continue };
            if i.abs_diff(ib) + j.abs_diff(jb) == 1 && a < b {
                near.push((a, b, link, law));
            }
        }
    }
    let law: Law = commonest(near.iter().map(|n| (key(n.3), n.3)))?;
    let mut links = BTreeMap::new();
    for (a, b, link, _) in near.into_iter().filter(|n| n.3 == law) {
        links.entry((a, b)).or_insert(link);
    }
    Some(Lattice { nodes, rows, cols, m, law, links })
}

fn commonest<K: Ord, T>(all: impl Iterator<Item = (K, T)>) -> Option<T> {
    let mut counts: BTreeMap<K, (usize, T)> = BTreeMap::new();
    for (k, t) in all {
        counts.entry(k).or_insert((0, t)).0 += 1;
    }
    counts.into_values().max_by_key(|(n, _)| *n).map(|(_, t)| t)
}

impl Lattice {
    fn node(&self, i: usize, j: usize) -> Option<usize> {
        self.nodes.get(i * self.cols + j).copied().flatten()
    }

    fn is_member(&self, graph: &Graph<'_>, i: usize, j: usize) -> bool {
        self.node(i, j).is_some_and(|p| graph.mass(p) == Some(self.m))
    }

    fn is_ground(&self, graph: &Graph<'_>, i: usize, j: usize) -> bool {
        self.node(i, j).is_some_and(|p| graph.is_ground(p))
    }

    fn link(&self, a: (usize, usize), b: (usize, usize)) -> Option<usize> {
        let (a, b) = (self.node(a.0, a.1)?, self.node(b.0, b.1)?);
        self.links.get(&(a.min(b), a.max(b))).copied()
    }

    fn is_whole(&self, graph: &Graph<'_>, edges: &str) -> bool {
        let end = |i: usize, n: usize| i == 0 || i + 1 == n;
        self.is_mesh(graph, |i, j| match edges {
            "closed" => end(i, self.rows) || end(j, self.cols),
            _ => end(i, self.rows) && end(j, self.cols),
        })
    }

    /// Returns the held nodes if all of the lattice is a mesh with at most 16 of them.
    fn held(&self, graph: &Graph<'_>) -> Option<Vec<[usize; 2]>> {
        let places = (0..self.rows).flat_map(|i| (0..self.cols).map(move |j| [i, j]));
        let fixed: Vec<[usize; 2]> = places.filter(|[i, j]| self.is_ground(graph, *i, *j)).collect();
        let few = !fixed.is_empty() && fixed.len() <= 16;
        (few && self.is_mesh(graph, |i, j| fixed.contains(&[i, j]))).then_some(fixed)
    }

    /// Returns true if all of it is a mesh with grounds at the places of `fixed` and masses elsewhere.
    fn is_mesh(&self, graph: &Graph<'_>, fixed: impl Fn(usize, usize) -> bool) -> bool {
        let tied =
            |a: (usize, usize), b: (usize, usize)| (fixed(a.0, a.1) && fixed(b.0, b.1)) || self.link(a, b).is_some();
        self.rows >= SMALLEST
            && self.cols >= SMALLEST
            && (0..self.rows).all(|i| {
                (0..self.cols).all(|j| {
                    let right = j + 1 == self.cols || tied((i, j), (i, j + 1));
                    let down = i + 1 == self.rows || tied((i, j), (i + 1, j));
                    let own = if fixed(i, j) { self.is_ground(graph, i, j) } else { self.is_member(graph, i, j) };
                    own && right && down
                })
            })
    }

    /// Finds the largest rectangle of masses with all its links.
    ///
    /// For each row it finds how many masses of each column, and how many links between neighbouring columns, end there
    /// without a gap, then tries every span of columns. Rows are taken along the longer side, because the search grows
    /// with the square of the shorter one.
    fn largest(&self, graph: &Graph<'_>) -> Option<Area> {
        let turned = self.cols > self.rows;
        let (rows, cols) = if turned { (self.cols, self.rows) } else { (self.rows, self.cols) };
        let at = |i: usize, j: usize| if turned { (j, i) } else { (i, j) };
        let mut best: Option<Area> = None;
        let mut height = vec![0usize; cols];
        let mut ladder = vec![0usize; cols];
        for i in 0..rows {
            for j in 0..cols {
                let here = at(i, j);
                let member = self.is_member(graph, here.0, here.1);
                let hangs = i > 0 && self.link(at(i - 1, j), here).is_some();
                let rung = j + 1 < cols && self.link(here, at(i, j + 1)).is_some();
                height[j] = usize::from(member) * (1 + if hangs { height[j] } else { 0 });
                ladder[j] = if rung { ladder[j] + 1 } else { 0 };
            }
            for j0 in 0..cols {
                let mut h = height[j0];
                for j1 in j0 + 1..=cols {
                    if h < SMALLEST {
                        break;
                    }
                    let area = Area { i0: i + 1 - h, i1: i + 1, j0, j1 };
                    if j1 - j0 >= SMALLEST && best.is_none_or(|b| area.size() > b.size()) {
                        best = Some(area);
                    }
                    h = h.min(ladder[j1 - 1]).min(height.get(j1).copied().unwrap_or(0));
                }
            }
        }
        best.map(|a| if turned { Area { i0: a.j0, i1: a.j1, j0: a.i0, j1: a.i1 } } else { a })
    }

    fn write(
        &self,
        graph: &Graph<'_>,
        edges: &'static str,
        fixed: Vec<[usize; 2]>,
        area: Area,
        names: &mut Names,
        plan: &mut GeneratorPlan,
    ) {
        let places = || (area.i0..area.i1).flat_map(|i| (area.j0..area.j1).map(move |j| (i, j)));
        let parts: Vec<usize> = places().filter_map(|(i, j)| self.node(i, j)).collect();
        let labels: Vec<&str> = parts.iter().map(|&p| graph.parts[p].name.as_str()).collect();
        let mut base = stem(&labels);
        if base.is_empty() {
            base.push_str("mesh");
        }
        let name = names.unique(&base);
        for (i, j) in places() {
            let next = [(i, j + 1), (i + 1, j)];
            let inside = |n: &&(usize, usize)| n.0 < area.i1 && n.1 < area.j1;
            for link in next.iter().filter(inside).filter_map(|n| self.link((i, j), *n)) {
                plan.gone[link] = true;
            }
            if let Some(part) = self.node(i, j) {
                plan.gone[part] = true;
                plan.names.insert(part, format!("{name}[{},{}]", i - area.i0, j - area.j0));
            }
        }
        let (Some(&first), Some(&last)) = (parts.first(), parts.last()) else { return };
        let sides = [("nx", area.i1 - area.i0), ("ny", area.j1 - area.j0)];
        let mut args: Vec<(&'static str, Arg)> = sides.iter().map(|&(k, n)| (k, Arg::Num(n as f64))).collect();
        args.extend(medium(self.m, self.law));
        args.push(("edges", Arg::Word(edges)));
        let at = parts.iter().copied().min().unwrap_or(first);
        plan.generators.push(Generator { kind: "MESH", name, args, fixed, at, members: (first, last) });
    }
}
