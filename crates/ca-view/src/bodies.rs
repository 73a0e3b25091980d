//! Finds bodies: connected masses on a line, each with a shape: a row, a ring, a sheet, a net.
//!
//! Masses of one generator form a body, and their links decide its shape. Links between neighbours make a row, or a
//! ring if the last is joined to the first; two indices make a sheet. Masses written one by one are analysed as a
//! network: paths and circles become rows and rings, and others are laid out by distance ([`crate::graph_layout`]). Masses
//! with many links (a bridge) are removed first, so that the network falls into its parts.

use crate::graph::{Graph, NONE};
use crate::graph_layout::{Adjacency, layout};
use ca_core::internal::kind::name::Index;
use std::f64::consts::PI;

/// Smaller networks that are neither path nor circle are placed mass by mass.
const NET: usize = 8;

/// Arrangement of the masses of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Linked, one behind the other.
    Row,
    /// One behind the other without links, as the cells of a bank.
    Cells,
    /// In the plane.
    Plane,
}

/// Masses with relative places.
#[derive(Debug)]
pub struct Body {
    /// Nodes of the body.
    pub nodes: Vec<u32>,
    /// Places across the motion, around the middle, in units of the larger side (nodes x 2).
    pub at: Vec<[f64; 2]>,
    /// Arrangement.
    pub shape: Shape,
    /// Extent in both directions; the larger is 1.
    pub sides: [f64; 2],
    /// Number of masses along it, which gives the length of a row among others.
    pub long: usize,
}

impl Body {
    /// Makes a body from nodes and places, which are centred and scaled.
    fn new(nodes: Vec<u32>, mut at: Vec<[f64; 2]>, shape: Shape, long: usize) -> Body {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in &at {
            for k in 0..2 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let size = [high[0] - low[0], high[1] - low[1]];
        let scale = match size[0].max(size[1]) {
            s if s > 0.0 => 1.0 / s,
            _ => 1.0,
        };
        for p in &mut at {
            for k in 0..2 {
                p[k] = (p[k] - 0.5 * (low[k] + high[k])) * scale;
            }
        }
        Body { nodes, at, shape, sides: size.map(|s| s * scale), long }
    }

    /// Makes a row of nodes at distances `along` it.
    fn row(nodes: Vec<u32>, along: impl Iterator<Item = f64>) -> Body {
        let long = nodes.len();
        Body::new(nodes, along.map(|u| [u, 0.0]).collect(), Shape::Row, long)
    }

    fn cells(nodes: Vec<u32>) -> Body {
        let n = nodes.len();
        Body { shape: Shape::Cells, ..Body::row(nodes, (0..n).map(|i| i as f64)) }
    }

    /// Makes a circle of nodes, the first in front.
    fn ring(nodes: Vec<u32>) -> Body {
        let (n, long) = (nodes.len() as f64, nodes.len());
        let at = |i: usize| {
            let angle = 2.0 * PI * i as f64 / n - 0.5 * PI;
            [libm::cos(angle), libm::sin(angle)]
        };
        Body::new(nodes, (0..long).map(at).collect(), Shape::Plane, long)
    }
}

/// Links within an item, by distance of their ends in it.
#[derive(Clone, Copy, Default)]
struct ItemLinks {
    /// Links of neighbours.
    next: usize,
    /// Links of masses more than two apart, except the first with the last.
    far: usize,
    /// True if the first and the last are linked.
    closed: bool,
    any: bool,
}

impl ItemLinks {
    /// Returns true if `n` masses form a row, apart from a few links.
    fn is_row(&self, n: usize) -> bool {
        4 * self.far < n
    }
}

/// Returns all bodies, and for each item whether its masses are linked in order.
pub fn bodies(graph: &Graph) -> (Vec<Body>, Vec<bool>) {
    let mut within = vec![ItemLinks::default(); graph.items.len()];
    for e in graph.edges.iter().filter(|e| e.law.is_some()) {
        let [a, b] = e.ends.map(|n| n as usize);
        let item = graph.item[a];
        if item != graph.item[b] {
            continue;
        }
        let (apart, len) = (a.abs_diff(b), graph.items[item as usize].len as usize);
        let w = &mut within[item as usize];
        w.any = true;
        match apart {
            1 => w.next += 1,
            _ if apart + 1 == len => w.closed = true,
            _ => w.far += usize::from(apart > 2),
        }
    }
    let chained = graph.items.iter().zip(&within);
    let chained = chained.map(|(i, w)| i.grid.is_some() || (w.any && w.is_row(i.len as usize))).collect();
    let mut taken = vec![false; graph.len()];
    let mut all = Vec::new();
    for wave in graph.waves.iter().filter(|w| !w.nodes.contains(&NONE)) {
        wave.nodes.iter().for_each(|n| taken[*n as usize] = true);
        all.push(Body::row(wave.nodes.clone(), wave.at.iter().copied()));
    }
    for (item, w) in graph.items.iter().zip(&within) {
        if item.space || item.between || item.len < 2 || item.nodes().any(|n| taken[n]) {
            continue;
        }
        item.nodes().for_each(|n| taken[n] = true);
        let (nodes, n): (Vec<u32>, usize) = (item.nodes().map(|n| n as u32).collect(), item.len as usize);
        all.push(match item.grid {
            Some(size) => {
                let at = |n: usize| match graph.index[n] {
                    Index::Two(i, j) => [f64::from(i), f64::from(j)],
                    _ => [0.0; 2],
                };
                Body::new(nodes, item.nodes().map(at).collect(), Shape::Plane, size[0].max(size[1]) as usize)
            }
            None if !w.any => Body::cells(nodes),
            None if w.is_row(n) && (!w.closed || n < 4 || w.next + 1 < n) => Body::row(nodes, (0..n).map(|i| i as f64)),
            None if w.is_row(n) || n <= NET * NET => Body::ring(nodes),
            None => net(graph, nodes),
        });
    }
    all.extend(by_hand(graph, &mut taken));
    (all, chained)
}

fn net(graph: &Graph, nodes: Vec<u32>) -> Body {
    let adjacent = Adjacency::new(graph.len(), &nodes, &graph.edges.iter().filter(|e| e.law.is_some()).map(|e| e.ends));
    let at = layout(&adjacent);
    let long = libm::sqrt(nodes.len() as f64) as usize + 1;
    Body::new(nodes, at, Shape::Plane, long)
}

/// Finds bodies among masses that were written one by one.
fn by_hand(graph: &Graph, taken: &mut [bool]) -> Vec<Body> {
    let moves = |n: usize| !(graph.is_fixed(n) || graph.is_port(n));
    let free: Vec<u32> = graph
        .items
        .iter()
        .filter(|i| !i.space && !i.between)
        .flat_map(crate::graph::Item::nodes)
        .filter(|n| !taken[*n] && moves(*n))
        .map(|n| n as u32)
        .collect();
    let springs = || graph.edges.iter().filter(|e| e.law.is_some() && !graph.is_contact(e)).map(|e| e.ends);
    let all = Adjacency::new(graph.len(), &free, &springs());
    let degrees: Vec<usize> = (0..free.len()).map(|i| all.neighbours(i).len()).collect();
    let linked = degrees.iter().filter(|d| **d > 0).count().max(1);
    let mean = degrees.iter().sum::<usize>() as f64 / linked as f64;
    let is_hub = |d: usize| d >= 5 && d as f64 > 3.0 * mean;
    let some: Vec<u32> = free.iter().zip(&degrees).filter(|(_, d)| !is_hub(**d)).map(|(n, _)| *n).collect();
    let parts = Adjacency::new(graph.len(), &some, &springs());
    let mut bodies = Vec::new();
    for part in parts.components() {
        let ends: Vec<usize> = part.iter().copied().filter(|i| parts.neighbours(*i).len() < 2).collect();
        let thin = part.iter().all(|i| parts.neighbours(*i).len() <= 2);
        let (path, circle) = (thin && ends.len() == 2, thin && ends.is_empty());
        if part.len() < 3 || !(path || circle || part.len() >= NET) {
            continue;
        }
        let body = if path || circle {
            // from the first end, or from the first mass of a circle, along the links
            let mut order = vec![ends.first().copied().unwrap_or(part[0])];
            let mut before = usize::MAX;
            while order.len() < part.len() {
                let here = order[order.len() - 1];
                let next = parts.neighbours(here).iter().map(|n| *n as usize).find(|n| *n != before && *n != order[0]);
                let Some(next) = next else { break };
                before = here;
                order.push(next);
            }
            let nodes: Vec<u32> = order.into_iter().map(|i| some[i]).collect();
            let n = nodes.len();
            if path { Body::row(nodes, (0..n).map(|i| i as f64)) } else { Body::ring(nodes) }
        } else {
            net(graph, part.iter().map(|i| some[*i]).collect())
        };
        body.nodes.iter().for_each(|n| taken[*n as usize] = true);
        bodies.push(body);
    }
    // cells without links to a body or to space stand in a row, like a bank
    let mut held = vec![false; graph.len()];
    for [a, b] in springs() {
        held[a as usize] |= taken[b as usize];
        held[b as usize] |= taken[a as usize];
    }
    graph.edges.iter().filter(|e| e.axis.is_some()).for_each(|e| e.ends.iter().for_each(|n| held[*n as usize] = true));
    let row = |code: &str| -> Vec<u32> {
        let fits = |n: &u32| graph.code(*n as usize) == code && !taken[*n as usize] && !held[*n as usize];
        some.iter().copied().filter(fits).collect()
    };
    let mut cells = row("CEL");
    if cells.is_empty() && bodies.is_empty() && !taken.contains(&true) {
        cells = row("MAS");
    }
    if !cells.is_empty() {
        for n in &cells {
            taken[*n as usize] = true;
        }
        bodies.push(Body::cells(cells));
    }
    bodies
}
