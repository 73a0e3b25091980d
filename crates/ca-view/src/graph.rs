//! The masses and links of a scene as a graph, for a drawing.
//!
//! The graph is read from the scene, not from the model, so it shows what runs, also for imported and generated models.
//! Names only show which masses were made together (an *item*), since a generator numbers them in the order of its
//! shape; links show how they are connected. Moving points, masses computed by modes and the ends of waveguides are not
//! MATs; they become nodes behind the MATs.

use ca_core::internal::kind::name::{Index, Part};
use ca_core::internal::op::layout::{CoordinateSource, MeasureKind, Termination};
use ca_core::internal::op::{Op, pass};
use ca_core::{Location, Scene};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Largest number of drawn spheres.
const SPHERES: usize = 64;
/// Marks a missing node.
pub const NONE: u32 = u32::MAX;

/// Place of the displacement of a node in the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// One number.
    Line(u32),
    /// Three successive numbers.
    Space(u32),
    /// A node that does not move.
    Still,
}

/// Link between two nodes.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// The nodes.
    pub ends: [u32; 2],
    /// Index into [`Graph::laws`]; `None` for the second port of a quadripole, which is not drawn.
    pub law: Option<u16>,
    /// Axis of a link between a mass on a line and one in space.
    pub axis: Option<u8>,
}

/// Masses made together by a generator, or a single mass.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// First node; the others follow.
    pub first: u32,
    /// Number of nodes.
    pub len: u32,
    /// Nodes in both directions of a grid.
    pub grid: Option<[u32; 2]>,
    /// True if its masses move in space.
    pub space: bool,
    /// True for a moving point, whose place is between masses.
    pub between: bool,
}

impl Item {
    /// Returns the range of its nodes.
    pub fn nodes(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.len) as usize
    }
}

/// String of travelling waves.
pub struct Wave {
    /// Nodes in order, including both ends.
    pub nodes: Vec<u32>,
    /// Distance of each node from the first \[ticks\].
    pub at: Vec<f64>,
}

/// Masses and links. Arrays marked "(nodes)" have one entry for each node.
#[derive(Default)]
pub struct Graph {
    /// Place of the displacement (nodes).
    pub source: Vec<Source>,
    /// Index into `kinds` (nodes).
    pub kind: Vec<u16>,
    /// Codes of masses.
    pub kinds: Vec<&'static str>,
    /// Index into `items` (nodes).
    pub item: Vec<u32>,
    /// Index in the item (nodes).
    pub index: Vec<Index>,
    /// Rest position \[m\], on a line in the first number (nodes).
    pub rest: Vec<[f64; 3]>,
    /// All items.
    pub items: Vec<Item>,
    /// Number of MATs, which are the first nodes, in the order of the symbols.
    pub mats: usize,
    /// Links.
    pub edges: Vec<Edge>,
    /// Codes of links, each with whether it is a contact.
    pub laws: Vec<(&'static str, bool)>,
    /// Nodes under a moving point, with their weights.
    pub under: BTreeMap<u32, Vec<(u32, f64)>>,
    /// Ports that control moving points, with these points.
    leads: Vec<(u32, u32)>,
    /// Strings of waves.
    pub waves: Vec<Wave>,
    /// Spheres that hold others: node in the middle, and radius \[m\].
    pub spheres: Vec<(u32, f64)>,
    /// Upward axis and its sign.
    pub up: (usize, f64),
    /// Largest displacement of a mass on a line at the start \[m\].
    pub begin: f64,
}

impl Graph {
    /// Reads a scene.
    pub fn new(scene: &Scene) -> Graph {
        let mut graph = Graph::default();
        // node and axis for each place of the state
        let mut of = vec![(NONE, 0u8); scene.counts.n_mat];
        graph.masses(scene, &mut of);
        graph.mats = graph.source.len();
        graph.points(scene, &mut of);
        graph.waveguides(scene, &of);
        let mut balls = BTreeSet::new();
        for l in scene.symbols.lias() {
            let (Some(op), i) = (scene.passes.forces.get(l[0] as usize), l[1] as usize) else { continue };
            graph.link(scene, op, i, &of, &mut balls);
        }
        graph.spheres = balls.into_iter().map(|(node, bits)| (node, f64::from_bits(bits))).collect();
        // a port that only controls a moving point: its value is a fraction, not a position
        for (port, point) in std::mem::take(&mut graph.leads) {
            if !graph.edges.iter().any(|e| e.law.is_some() && e.ends.contains(&port)) {
                graph.source[port as usize] = Source::Still;
                graph.rest[port as usize] = [0.0; 3];
                graph.edges.push(Edge { ends: [port, point], law: None, axis: None });
            }
        }
        graph.up = up(scene, &graph, &of);
        graph
    }

    /// Returns the number of nodes.
    pub fn len(&self) -> usize {
        self.source.len()
    }

    /// Returns true if a node moves in space.
    pub fn is_space(&self, node: usize) -> bool {
        matches!(self.source[node], Source::Space(_))
    }

    /// Returns the code of a node.
    pub fn code(&self, node: usize) -> &'static str {
        self.kinds[self.kind[node] as usize]
    }

    /// Returns true for a fixed point.
    pub fn is_fixed(&self, node: usize) -> bool {
        self.code(node) == "SOL"
    }

    /// Returns true for a port, which a hand or a gesture moves.
    pub fn is_port(&self, node: usize) -> bool {
        matches!(self.code(node), "ENX" | "TGR")
    }

    /// Returns true for a contact, a pluck or a bow.
    pub fn is_contact(&self, edge: &Edge) -> bool {
        edge.law.is_some_and(|law| self.laws[law as usize].1)
    }

    fn node(&mut self, source: Source, code: &'static str, index: Index, rest: [f64; 3]) -> u32 {
        let kind = self.kinds.iter().position(|k| *k == code).unwrap_or_else(|| {
            self.kinds.push(code);
            self.kinds.len() - 1
        });
        self.source.push(source);
        self.kind.push(kind as u16);
        self.item.push(self.items.len() as u32);
        self.index.push(index);
        self.rest.push(rest);
        self.len() as u32 - 1
    }

    /// Makes an item of the nodes since the last one.
    fn close(&mut self, between: bool) {
        let first = self.items.last().map_or(0, |i| i.first + i.len);
        let len = self.len() as u32 - first;
        if len == 0 {
            return;
        }
        let size = |index: &Index| if let Index::Two(i, j) = index { Some([i + 1, j + 1]) } else { None };
        let sizes = self.index[first as usize..].iter().map(size);
        let grid = sizes.reduce(|a, b| Some([a?[0].max(b?[0]), a?[1].max(b?[1])])).flatten();
        let grid = grid.filter(|[nx, ny]| *nx > 1 && *ny > 1);
        let space = self.is_space(first as usize);
        self.items.push(Item { first, len, grid, space, between });
    }

    fn masses(&mut self, scene: &Scene, of: &mut [(u32, u8)]) {
        let mut last: Option<(Arc<str>, Part, bool)> = None;
        for s in scene.symbols.iter().take(scene.mats()) {
            let Location::Mat(place) = s.location else { continue };
            let space = s.axes > 1;
            // fixed ends belong to their string, modes do not
            let part = if s.name.part == Part::Mode { Part::Mode } else { Part::Own };
            let joins = last.as_ref().is_some_and(|(of, p, sp)| {
                s.name.index != Index::None && Arc::ptr_eq(of, &s.name.of) && (*p, *sp) == (part, space)
            });
            if !joins {
                self.close(false);
                last = Some((s.name.of.clone(), part, space));
            }
            let at = |k: usize| scene.places.rest.get(place as usize + k).map_or(0.0, |v| *v);
            let (source, rest) = if space {
                (Source::Space(place), [at(0), at(1), at(2)])
            } else {
                (Source::Line(place), [at(0), 0.0, 0.0])
            };
            if !space {
                let x = scene.initial.x.get(place as usize).map_or(0.0, |x| x.abs());
                self.begin = self.begin.max(finite(x));
            }
            let node = self.node(source, s.code, s.name.index, rest.map(finite));
            for (axis, slot) in of.iter_mut().skip(place as usize).take(if space { 3 } else { 1 }).enumerate() {
                *slot = (node, axis as u8);
            }
        }
        self.close(false);
    }

    /// Adds moving points and masses computed by modes.
    fn points(&mut self, scene: &Scene, of: &mut [(u32, u8)]) {
        for p in &scene.places.moving_points {
            let cell = pass::cell(scene, &scene.initial, p);
            let nodes = cell.node.iter().zip(&cell.weight).take(cell.n);
            let under: Vec<(u32, f64)> =
                nodes.map(|(m, w)| (of[*m as usize].0, *w)).filter(|(m, w)| *m != NONE && *w > 0.0).collect();
            let node = self.node(Source::Line(p.mat), "@", Index::None, [0.0; 3]);
            of[p.mat as usize] = (node, 0);
            self.under.insert(node, under);
            for at in p.at {
                if let CoordinateSource::Mat(port) = at {
                    self.leads.push((of[port as usize].0, node));
                }
            }
            self.close(true);
        }
        let mut group = None;
        for m in &scene.places.modal {
            if group.is_some_and(|first| first != m.first) {
                self.close(false);
            }
            group = Some(m.first);
            let rest = scene.places.rest.get(m.mat as usize).map_or(0.0, |v| *v);
            let node = self.node(Source::Line(m.mat), "MAS", Index::None, [finite(rest), 0.0, 0.0]);
            of[m.mat as usize] = (node, 0);
        }
        self.close(false);
    }

    /// Adds strings of waves: their ends, and a link for each section.
    fn waveguides(&mut self, scene: &Scene, of: &[(u32, u8)]) {
        let all = &scene.waves;
        let node = |j: usize| all.junctions.get(j).map_or(NONE, |j| of[j.mat as usize].0);
        let mut begun: Option<Wave> = None;
        // order of delays in a string: near end, both directions between junctions, far end
        for d in &all.delays {
            let ticks = d.len.max(1) as f64;
            let here = node(d.junction);
            // memory of junctions is in ascending order
            let next = all.junctions.partition_point(|j| j.memory <= d.to).checked_sub(1).map_or(NONE, node);
            match (&mut begun, d.end) {
                (Some(wave), Termination::Open) => {
                    if next != here && !wave.nodes.contains(&next) {
                        wave.nodes.push(next);
                        wave.at.push(wave.at.last().map_or(0.0, |at| at + ticks));
                    }
                }
                (None, Termination::Open) => begun = Some(Wave { nodes: vec![here, next], at: vec![0.0, ticks] }),
                (None, _) => {
                    let rest = self.rest.get(here as usize).copied().unwrap_or_default();
                    let end = self.node(Source::Still, "SOL", Index::None, rest);
                    begun = Some(Wave { nodes: vec![end, here], at: vec![0.0, 0.5 * ticks] });
                }
                (Some(_), _) => {
                    let rest = self.rest.get(here as usize).copied().unwrap_or_default();
                    let end = self.node(Source::Still, "SOL", Index::None, rest);
                    if let Some(mut wave) = begun.take() {
                        wave.at.push(wave.at.last().map_or(0.0, |at| at + 0.5 * ticks));
                        wave.nodes.push(end);
                        self.waves.push(wave);
                    }
                    self.close(false);
                }
            }
        }
        self.waves.extend(begun);
        self.close(false);
        let pairs: Vec<[u32; 2]> = self.waves.iter().flat_map(|w| w.nodes.windows(2).map(|p| [p[0], p[1]])).collect();
        for ends in pairs.into_iter().filter(|e| !e.contains(&NONE)) {
            let law = Some(self.law("WAVE", false));
            self.edges.push(Edge { ends, law, axis: None });
        }
    }

    fn law(&mut self, code: &'static str, contact: bool) -> u16 {
        let at = self.laws.iter().position(|l| *l == (code, contact)).unwrap_or_else(|| {
            self.laws.push((code, contact));
            self.laws.len() - 1
        });
        at as u16
    }

    fn link(&mut self, scene: &Scene, op: &Op, i: usize, of: &[(u32, u8)], balls: &mut BTreeSet<(u32, u64)>) {
        let Some(law) = op.law else { return };
        let radius = holds(scene, op, i).filter(|_| balls.len() < SPHERES);
        if let Some(set) = op.ports.pair_set {
            // the pairs of two sets are not drawn
            let Some(set) = scene.links.pair_sets.get(set) else { return };
            for m in set.members.iter().take(set.rows).filter(|_| set.rows < SPHERES) {
                let node = of[*m as usize].0;
                balls.extend(radius.filter(|_| node != NONE).map(|r| (node, r.to_bits())));
            }
            return;
        }
        // plucks and bows touch too, without a threshold
        let code = law.code.split(' ').next().unwrap_or(law.code);
        let contact = law.contact || ["PLK", "ATT", "BOW"].iter().any(|touch| code.ends_with(touch));
        let ports = [
            (scene.links.ends.get(op.first + i), true),
            (op.ports.onto.and_then(|(_, first, _)| scene.links.onto.get(first + i)), false),
        ];
        for (slots, drawn) in ports {
            let Some([a, b]) = slots.map(|e| e.map(|slot| of.get(slot as usize).copied().unwrap_or((NONE, 0)))) else {
                continue;
            };
            if a.0 == NONE || b.0 == NONE || a.0 == b.0 {
                continue;
            }
            let axis = match [a, b].map(|e| self.is_space(e.0 as usize)) {
                [true, false] => Some(a.1),
                [false, true] => Some(b.1),
                _ => None,
            };
            let law = drawn.then(|| self.law(code, contact));
            self.edges.push(Edge { ends: [a.0, b.0], law, axis });
            if drawn {
                balls.extend(radius.filter(|_| self.is_space(a.0 as usize)).map(|r| (a.0, r.to_bits())));
            }
        }
    }
}

/// Returns the radius \[m\] within which link `i` of a pass holds its second end, free of force at smaller distances.
fn holds(scene: &Scene, op: &Op, i: usize) -> Option<f64> {
    let law = op.law.filter(|law| law.contact && op.form.measure == MeasureKind::Radial)?;
    let coefs: Option<Vec<f64>> =
        (0..law.coefs).map(|s| scene.initial.coef.get(op.coef + s * op.n + i).copied()).collect();
    let (from, to) = (law.fns.idle)(&coefs?);
    (from == f64::NEG_INFINITY && to > 0.0 && to.is_finite()).then_some(to)
}

/// Returns the upward axis and its sign: against gravity in space, else the last axis of space, to which a single
/// number for `gravity` applies; on a line the second axis, which is up on a screen.
fn up(scene: &Scene, graph: &Graph, of: &[(u32, u8)]) -> (usize, f64) {
    let mut sum = [0.0; 3];
    if let Some(op) = scene.passes.forces.iter().find(|op| op.name() == "weight" && op.law.is_none()) {
        for (k, slot) in scene.weighed.iter().enumerate() {
            let (node, axis) = of.get(*slot as usize).copied().unwrap_or((NONE, 0));
            if node != NONE && graph.is_space(node as usize) {
                sum[axis as usize] += scene.initial.coef.get(op.coef + k).copied().unwrap_or(0.0);
            }
        }
    }
    let axis = (0..3).fold(0, |best, k| if f64::abs(sum[k]) > f64::abs(sum[best]) { k } else { best });
    if sum[axis] != 0.0 {
        return (axis, -sum[axis].signum());
    }
    let solid = scene.symbols.iter().take(scene.mats()).any(|s| s.axes == 3);
    (if solid { 2 } else { 1 }, 1.0)
}

fn finite(v: f64) -> f64 {
    if v.is_finite() { v } else { 0.0 }
}
