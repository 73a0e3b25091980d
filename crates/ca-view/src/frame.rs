//! Frames: coordinate systems in which nodes on a line are drawn.
//!
//! A node on a line has a place across its motion (to the right, into the depth) and one along it: its rest position,
//! at the scale of the motion, so that a hammer 6 mm below its string is drawn there and meets it. All these nodes
//! share one frame with upward motion, except nodes that a link ties to a mass in space along an axis. Those have a
//! frame at that mass, with motion along that axis.

use crate::graph::Graph;
use std::collections::BTreeMap;

/// Directions and origin of a group of nodes.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Directions: to the right, into the depth, along the motion.
    pub axes: [[f64; 3]; 3],
    /// Middle \[m\].
    pub origin: [f64; 3],
}

impl Frame {
    /// Returns a frame with its motion along an axis of space.
    pub fn new(axis: usize, sign: f64) -> Frame {
        let unit = |k: usize, s: f64| {
            let mut v = [0.0; 3];
            v[k] = s;
            v
        };
        let right = unit(usize::from(axis == 0), 1.0);
        let up = unit(axis, sign);
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        Frame { axes: [right, cross(up, right), up], origin: [0.0; 3] }
    }

    /// Converts a place in the frame to space \[m\].
    pub fn point(&self, at: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| self.origin[k] + (0..3).map(|a| self.axes[a][k] * at[a]).sum::<f64>())
    }

    /// Removes the part along the motion from a point in space.
    pub fn across(&self, p: [f64; 3]) -> [f64; 3] {
        let h: f64 = (0..3).map(|k| p[k] * self.axes[2][k]).sum();
        [0, 1, 2].map(|k| p[k] - h * self.axes[2][k])
    }
}

/// Place of a node in a frame.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Index of the frame.
    pub frame: usize,
    /// Place to the right, into the depth and along the motion \[m\].
    pub at: [f64; 3],
}

/// Places of all nodes, filled step by step.
pub struct Places {
    /// Frames; the first is for all nodes that are not tied to space.
    pub frames: Vec<Frame>,
    /// Places of nodes on a line that are placed (nodes).
    pub placed: Vec<Option<Placed>>,
    /// Width of the drawing \[m\].
    pub width: f64,
    /// Signed distance of the next place beyond the end of a row; 0 for all other nodes (nodes).
    pub beyond: Vec<f64>,
    /// Masses on a line that are tied to masses in space, see [`tied`].
    pub tied: BTreeMap<u32, (u8, [f64; 3])>,
    /// Frames of single masses tied to space, by axis and middle.
    ties: BTreeMap<(u8, [u64; 3]), usize>,
    /// Front of all bodies \[m\].
    pub front: f64,
}

impl Places {
    /// Starts without placed nodes; `main` is the first frame.
    pub fn new(graph: &Graph, main: Frame, width: f64) -> Places {
        let n = graph.len();
        Places {
            frames: vec![main],
            placed: vec![None; n],
            width,
            beyond: vec![0.0; n],
            tied: tied(graph),
            ties: BTreeMap::new(),
            front: 0.0,
        }
    }

    /// Returns the place of a mass that is tied to a mass in space: beside it, towards the negative end of the axis.
    pub fn tie_one(&mut self, graph: &Graph, line: u32) -> Option<Placed> {
        let (axis, middle) = self.tied.get(&line).copied()?;
        let mut new = Frame::new(axis as usize, 1.0);
        let across = new.across(middle);
        new.origin = [0, 1, 2].map(|k| across[k] - 0.7 * self.width * new.axes[2][k]);
        let key = (axis, new.origin.map(f64::to_bits));
        let frame = *self.ties.entry(key).or_insert_with(|| {
            self.frames.push(new);
            self.frames.len() - 1
        });
        Some(Placed { frame, at: [0.0, 0.0, graph.rest[line as usize][0]] })
    }
}

/// Returns for masses on a line that are tied to space the axis, and the mean place of the masses there \[m\].
fn tied(graph: &Graph) -> BTreeMap<u32, (u8, [f64; 3])> {
    let mut all: BTreeMap<u32, (u8, [f64; 3], f64)> = BTreeMap::new();
    for e in &graph.edges {
        let Some(axis) = e.axis else { continue };
        let [a, b] = e.ends;
        let (line, point) = if graph.is_space(b as usize) { (a, b) } else { (b, a) };
        let (_, sum, n) = all.entry(line).or_insert((axis, [0.0; 3], 0.0));
        (0..3).for_each(|k| sum[k] += graph.rest[point as usize][k]);
        *n += 1.0;
    }
    all.into_iter().map(|(line, (axis, sum, n))| (line, (axis, sum.map(|v| v / n)))).collect()
}
