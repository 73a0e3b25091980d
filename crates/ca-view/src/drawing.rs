//! Drawing of a compiled scene: its masses, their places and how they move.
//!
//! A drawing depends on the scene alone and never changes. It has the rest positions of the masses, the direction of
//! each motion, and links by their ends. The displacements of a state follow mass by mass, one number on a line and
//! three in space. The layout makes the instrument recognisable: strings are rows that move across, meshes lie in a
//! plane and move along its normal, and hammers are at what they strike. Coordinates are the same on every machine.

use crate::graph::{Edge, Graph, NONE, Source};
use crate::{bodies, place, thin};
use ca_core::internal::op::layout::{Output, Tap};
use ca_core::{InputRole, Scene};
use serde_json::{Value, json};

/// A gesture with a range of at least this [m] is a bow stroke, which is not related to the size of the instrument.
const STROKE: f64 = 0.05;

#[derive(Clone, Debug, PartialEq)]
struct Links {
    kind: &'static str,
    contact: bool,
    /// Indices of drawn masses, in pairs.
    ends: Vec<u32>,
}

/// Drawing of a scene. Arrays marked "(masses)" have one entry for each drawn mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Index of the displacement in the state (masses).
    pub(crate) source: Vec<Source>,
    /// Rest positions \[m\] (masses).
    rest: Vec<[f64; 3]>,
    /// Directions of motion, 0 in space (masses).
    axis: Vec<[f64; 3]>,
    /// True for fixed points (masses).
    fixed: Vec<bool>,
    /// Index into `kinds` (masses).
    kind: Vec<u16>,
    kinds: Vec<&'static str>,
    links: Vec<Links>,
    /// Drawn mass in the middle, if any; centre \[m\]; radius \[m\].
    spheres: Vec<(Option<u32>, [f64; 3], f64)>,
    up: [f64; 3],
    /// Number of the MAT of each drawn mass, if any (masses).
    mats: Vec<Option<u32>>,
    /// Drawn mass of each MAT, if any (MATs).
    drawn: Vec<Option<u32>>,
    /// Size of a view in bytes.
    pub(crate) bytes: usize,
    /// Total number of masses, if not all are drawn.
    of: Option<usize>,
}

impl Drawing {
    /// Lays out a scene.
    pub fn new(scene: &Scene) -> Drawing {
        Drawing::of_at_most(scene, thin::MOST)
    }

    /// Lays out a scene with at most about `masses` masses.
    pub fn of_at_most(scene: &Scene, masses: usize) -> Drawing {
        let graph = Graph::new(scene);
        let (bodies, chained) = bodies::bodies(&graph);
        let (at, axes, up) = place::place(&graph, &bodies, motion(scene));
        let (shown, near) = thin::thin(&graph, &chained, masses);
        let mut number = vec![NONE; graph.len()];
        shown.iter().enumerate().for_each(|(i, n)| number[*n as usize] = i as u32);
        let some = |n: u32| (n != NONE).then_some(n);
        let source: Vec<Source> = shown.iter().map(|n| graph.source[*n as usize]).collect();
        let ball = |(n, r): &(u32, f64)| (some(number[*n as usize]), graph.rest[*n as usize], *r);
        Drawing {
            rest: shown.iter().map(|n| at[*n as usize]).collect(),
            axis: shown.iter().map(|n| axes[*n as usize]).collect(),
            fixed: shown.iter().map(|n| graph.is_fixed(*n as usize)).collect(),
            kind: shown.iter().map(|n| graph.kind[*n as usize]).collect(),
            kinds: graph.kinds.clone(),
            links: links(&graph, &near, &number, shown.len() < graph.len()),
            spheres: graph.spheres.iter().map(ball).collect(),
            up,
            mats: shown.iter().map(|n| ((*n as usize) < graph.mats).then_some(*n)).collect(),
            drawn: number[..graph.mats].iter().map(|n| some(*n)).collect(),
            bytes: source.iter().map(|s| if matches!(s, Source::Space(_)) { 12 } else { 4 }).sum(),
            of: (shown.len() < graph.len()).then_some(graph.len()),
            source,
        }
    }

    /// Returns the drawing in the form that pages read.
    ///
    /// Each mass has its place at `rest` \[m\], the `axis` of its motion on a line (zeros in `space`, where a view has
    /// three numbers for it), whether it is `fixed`, and its `kind`, an index into `kinds`. `links` are grouped by
    /// kind, with pairs of masses as `ends`. `spheres` hold other masses, `up` is the upward direction, and `decimated`
    /// is set if not all masses are drawn.
    pub fn json(&self) -> Value {
        let flat = |all: &[[f64; 3]]| all.iter().flatten().map(|v| short(*v)).collect::<Vec<Value>>();
        let bits = |all: &mut dyn Iterator<Item = bool>| all.map(u8::from).collect::<Vec<u8>>();
        let link = |l: &Links| json!({"kind": l.kind, "contact": l.contact, "ends": l.ends});
        let sphere = |(mass, centre, radius): &(Option<u32>, [f64; 3], f64)| {
            let mass = mass.map_or(-1, i64::from);
            json!({"mass": mass, "centre": flat(std::slice::from_ref(centre)), "radius": short(*radius)})
        };
        json!({
            "masses": self.masses(),
            "rest": flat(&self.rest),
            "axis": flat(&self.axis),
            "space": bits(&mut self.source.iter().map(|s| matches!(s, Source::Space(_)))),
            "fixed": bits(&mut self.fixed.iter().copied()),
            "kind": self.kind,
            "kinds": self.kinds,
            "links": self.links.iter().map(link).collect::<Vec<Value>>(),
            "spheres": self.spheres.iter().map(sphere).collect::<Vec<Value>>(),
            "up": self.up,
            "decimated": self.of.map(|of| json!({"of": of, "shown": self.masses()})),
        })
    }

    /// Returns the number of drawn masses.
    pub fn masses(&self) -> usize {
        self.source.len()
    }

    /// Appends the displacements \[m\] of the drawn masses at the positions `x` of a state, as little-endian `f32`: one
    /// for a mass on a line, three in space.
    pub fn view(&self, x: &[f64], out: &mut Vec<u8>) {
        out.reserve(self.bytes);
        let at = |place: u32| x.get(place as usize).copied().unwrap_or(0.0) as f32;
        for source in &self.source {
            match *source {
                Source::Line(p) => out.extend_from_slice(&at(p).to_le_bytes()),
                Source::Space(p) => (p..p + 3).for_each(|p| out.extend_from_slice(&at(p).to_le_bytes())),
                Source::Still => out.extend_from_slice(&[0; 4]),
            }
        }
    }

    /// Returns the number of the MAT at a drawn mass, in the order of the symbols; `None` for moving points and other
    /// nodes.
    pub fn scene_mass(&self, drawn: usize) -> Option<usize> {
        self.mats.get(drawn).copied().flatten().map(|m| m as usize)
    }

    /// Returns the drawn mass of a MAT, if it is drawn.
    pub fn drawn_mass(&self, mass: usize) -> Option<usize> {
        self.drawn.get(mass).copied().flatten().map(|d| d as usize)
    }
}

/// Returns the smallest range of a gesture on a position port, else the usual motion of an output at full scale \[m\].
fn motion(scene: &Scene) -> Option<f64> {
    let port = |name: &str| scene.inputs.iter().any(|i| i.name == name && i.role != InputRole::Force);
    let range = |points: &[[f64; 2]]| {
        let values = || points.iter().map(|p| p[1]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let ranges = scene.about.gestures.iter().filter(|(name, _)| port(name)).map(|(_, points)| range(points));
    let least = ranges.filter(|r| (1e-9..STROKE).contains(r)).fold(f64::INFINITY, f64::min);
    if least.is_finite() {
        return Some(least);
    }
    let gains = scene.passes.writes.first().map(|op| op.coef - op.first)?;
    let plain = scene.out.outputs.len() - scene.out.blockers.len() - scene.out.of_motion[0];
    let gain = |(k, o): (usize, &Output)| {
        let place = matches!(o.tap, Tap::Position(_)) && k < plain;
        let heard = place && (o.channel as usize) < scene.counts.channels;
        scene.initial.coef.get(gains + k).map(|gain| gain.abs()).filter(|gain| heard && *gain > 0.0)
    };
    let mut all: Vec<f64> = scene.out.outputs.iter().enumerate().filter_map(gain).collect();
    all.sort_unstable_by(f64::total_cmp);
    all.get(all.len() / 2).map(|gain| 2.0 / gain).filter(|m| m.is_finite())
}

fn links(graph: &Graph, near: &[u32], number: &[u32], thinned: bool) -> Vec<Links> {
    let drawn = |e: &Edge| {
        let law = e.law?;
        let [a, b] = e.ends.map(|n| near[n as usize]);
        let both = a != NONE && b != NONE && a != b;
        both.then(|| (law, [a, b].map(|n| number[n as usize])))
    };
    let mut all: Vec<(u16, [u32; 2])> = graph.edges.iter().filter_map(drawn).collect();
    if thinned {
        // thinning may have made several links equal
        all.sort_unstable();
        all.dedup();
    }
    let mut links: Vec<Links> =
        graph.laws.iter().map(|(kind, contact)| Links { kind, contact: *contact, ends: Vec::new() }).collect();
    for (law, ends) in all {
        links[law as usize].ends.extend(ends);
    }
    links.retain(|l| !l.ends.is_empty());
    links
}

/// Rounds a number to 7 digits, enough for a drawing.
fn short(v: f64) -> Value {
    if v == 0.0 {
        return json!(0);
    }
    format!("{v:.6e}").parse::<f64>().map_or(json!(0), |v| json!(v))
}
