//! Graph: the masses of a scene and what joins them, as a drawing needs them.
//!
//! Decides to read the scene alone, not the model: what is drawn is what runs, also of a model that was imported or made by a
//! program. Names are used for one thing, which masses were made together (an *item*), since a generator gives them in the
//! order of its shape; how they hang together is read from the links. What has a place in the state but is no MAT (moving
//! points, masses that go by their modes), and what has none (the ends of waveguides), becomes a node behind the MATs.

use ca_core::internal::kind::name::{Index, Part};
use ca_core::internal::op::layout::{CoordinateSource, MeasureKind, Termination};
use ca_core::internal::op::{Op, pass};
use ca_core::{Location, Scene};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Spheres that are drawn at most.
const SPHERES: usize = 64;
/// No node.
pub const NONE: u32 = u32::MAX;

/// Where the displacement of a node stands in the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// one number
    Line(u32),
    /// three in a row
    Space(u32),
    /// it does not move
    Still,
}

/// A link, by its nodes.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// its two nodes
    pub ends: [u32; 2],
    /// index into [`Graph::laws`]; `None` for the second port of a quadripole, which is not drawn
    pub law: Option<u16>,
    /// where it joins a mass on a line with one in space, the axis along which
    pub axis: Option<u8>,
}

/// Masses that were made together: those of a generator, or a single one.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// its first node; the others follow
    pub first: u32,
    /// how many
    pub len: u32,
    /// nodes along both directions, of a grid
    pub grid: Option<[u32; 2]>,
    /// whether its masses move in space
    pub space: bool,
    /// whether it is where others are, between masses (a moving point)
    pub between: bool,
}

impl Item {
    /// Its nodes.
    pub fn nodes(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.len) as usize
    }
}

/// A string of waves: its nodes in order, both ends among them, and where each is \[ticks from the first\].
pub struct Wave {
    /// nodes
    pub nodes: Vec<u32>,
    /// distances
    pub at: Vec<f64>,
}

/// Masses and links.
#[derive(Default)]
pub struct Graph {
    /// where each node moves (nodes)
    pub source: Vec<Source>,
    /// what it is, an index into `kinds` (nodes)
    pub kind: Vec<u16>,
    /// codes of masses
    pub kinds: Vec<&'static str>,
    /// the item of each node (nodes)
    pub item: Vec<u32>,
    /// where in it, on a grid (nodes)
    pub index: Vec<Index>,
    /// rest position \[m\], of a mass on a line in its first number (nodes)
    pub rest: Vec<[f64; 3]>,
    /// all items
    pub items: Vec<Item>,
    /// the first of them are MATs, in the order of the symbols
    pub mats: usize,
    /// links
    pub edges: Vec<Edge>,
    /// codes of links, each with whether it is a contact
    pub laws: Vec<(&'static str, bool)>,
    /// nodes under a moving point, and their weights, by its node
    pub under: BTreeMap<u32, Vec<(u32, f64)>>,
    /// ports that lead moving points, with those
    leads: Vec<(u32, u32)>,
    /// strings of waves
    pub waves: Vec<Wave>,
    /// spheres that hold others: the node in their middle, and their radius \[m\]
    pub spheres: Vec<(u32, f64)>,
    /// the axis that is up, and which way along it
    pub up: (usize, f64),
    /// how far from its rest a mass on a line begins at most \[m\]
    pub begin: f64,
}

impl Graph {
    /// Of a scene.
    pub fn new(scene: &Scene) -> Graph {
        let mut graph = Graph::default();
        // for each place of the state its node, and the axis of that
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
        // a port that only says where a moving point stands: a share of a way, no place of its own
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

    /// Nodes.
    pub fn len(&self) -> usize {
        self.source.len()
    }

    /// Whether a node moves in space.
    pub fn is_space(&self, node: usize) -> bool {
        matches!(self.source[node], Source::Space(_))
    }

    /// What a node is.
    pub fn code(&self, node: usize) -> &'static str {
        self.kinds[self.kind[node] as usize]
    }

    /// Whether nothing moves it.
    pub fn is_fixed(&self, node: usize) -> bool {
        self.code(node) == "SOL"
    }

    /// Whether a hand or a gesture moves it.
    pub fn is_port(&self, node: usize) -> bool {
        matches!(self.code(node), "ENX" | "TGR")
    }

    /// Whether a link is a contact, a pluck or a bow.
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

    /// Closes an item over the nodes since the last one.
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
            // the fixed ends of a string are part of it, its modes are not
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

    /// Moving points and masses that go by their modes.
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

    /// Strings of waves: their ends, and a link for each way.
    fn waveguides(&mut self, scene: &Scene, of: &[(u32, u8)]) {
        let all = &scene.waves;
        let node = |j: usize| all.junctions.get(j).map_or(NONE, |j| of[j.mat as usize].0);
        let mut begun: Option<Wave> = None;
        // near end, ways both to and fro between junctions, far end: one string after the other
        for d in &all.delays {
            let ticks = d.len.max(1) as f64;
            let here = node(d.junction);
            // junctions have their memory one behind the other
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

    /// Link `i` of a pass.
    fn link(&mut self, scene: &Scene, op: &Op, i: usize, of: &[(u32, u8)], balls: &mut BTreeSet<(u32, u64)>) {
        let Some(law) = op.law else { return };
        let radius = holds(scene, op, i).filter(|_| balls.len() < SPHERES);
        if let Some(set) = op.ports.pair_set {
            // every pair of two sets: not drawn one by one
            let Some(set) = scene.links.pair_sets.get(set) else { return };
            for m in set.members.iter().take(set.rows).filter(|_| set.rows < SPHERES) {
                let node = of[*m as usize].0;
                balls.extend(radius.filter(|_| node != NONE).map(|r| (node, r.to_bits())));
            }
            return;
        }
        // plucks and bows touch too, though they have no threshold
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

/// The radius \[m\] within which link `i` of a pass holds its second end: it has no force at any distance below.
fn holds(scene: &Scene, op: &Op, i: usize) -> Option<f64> {
    let law = op.law.filter(|law| law.contact && op.form.measure == MeasureKind::Radial)?;
    let coefs: Option<Vec<f64>> =
        (0..law.coefs).map(|s| scene.initial.coef.get(op.coef + s * op.n + i).copied()).collect();
    let (from, to) = (law.fns.idle)(&coefs?);
    (from == f64::NEG_INFINITY && to > 0.0 && to.is_finite()).then_some(to)
}

/// The axis that is up, and which way along it: against the weight of what is in space, else the last of its axes, as one number
/// for `gravity` would have it; on a line the second, which is up on a screen.
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

/// A number to draw.
fn finite(v: f64) -> f64 {
    if v.is_finite() { v } else { 0.0 }
}
