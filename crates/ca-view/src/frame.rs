//! Frames: the directions in which nodes on a line are drawn, and where in them each stands.
//!
//! Decides for frames: what moves on a line has a place across its motion (to the right, into the depth) and one along it
//! (its rest, at the scale of the motion, so that a hammer 6 mm below its string is drawn there and meets it). All that moves
//! on a line stands in one frame with its motion upwards; but what a link ties to a mass in space along an axis stands in a
//! frame at that mass, moving along that axis.

use crate::graph::Graph;
use std::collections::BTreeMap;

/// Directions of what is drawn together: to the right, into the depth, along the motion; and where their middle is.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// the three directions
    pub axes: [[f64; 3]; 3],
    /// the middle \[m\]
    pub origin: [f64; 3],
}

impl Frame {
    /// With the motion along an axis of space.
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

    /// A place of the frame in space \[m\].
    pub fn point(&self, at: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| self.origin[k] + (0..3).map(|a| self.axes[a][k] * at[a]).sum::<f64>())
    }

    /// The same, without the part along the motion.
    pub fn across(&self, p: [f64; 3]) -> [f64; 3] {
        let h: f64 = (0..3).map(|k| p[k] * self.axes[2][k]).sum();
        [0, 1, 2].map(|k| p[k] - h * self.axes[2][k])
    }
}

/// Where a node stands: in which frame, and there to the right, into the depth and along the motion \[m\].
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// index of the frame
    pub frame: usize,
    /// the place in it
    pub at: [f64; 3],
}

/// Nodes, as they are placed one after the other.
pub struct Places {
    /// the first is that of all that is tied to no axis of space
    pub frames: Vec<Frame>,
    /// where nodes on a line stand, as far as they are placed (nodes)
    pub stand: Vec<Option<Placed>>,
    /// width of what is drawn \[m\]
    pub width: f64,
    /// distance of neighbours at the ends of rows, by node; 0 elsewhere (nodes)
    pub beyond: Vec<f64>,
    /// masses on a line that are tied to some in space, see [`tied`]
    pub tied: BTreeMap<u32, (u8, [f64; 3])>,
    /// frames of single masses tied to space, by axis and middle
    ties: BTreeMap<(u8, [u64; 3]), usize>,
    /// the front of all bodies \[m\]
    pub front: f64,
}

impl Places {
    /// Nothing is placed yet; `main` is the frame of all that is tied to no axis of space.
    pub fn new(graph: &Graph, main: Frame, width: f64) -> Places {
        let n = graph.len();
        Places {
            frames: vec![main],
            stand: vec![None; n],
            width,
            beyond: vec![0.0; n],
            tied: tied(graph),
            ties: BTreeMap::new(),
            front: 0.0,
        }
    }

    /// The place of a mass on a line that is tied to one in space: beside it, towards where its axis comes from.
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

/// What masses on a line are tied to in space, by their nodes: the axis, and the middle of the masses there \[m\].
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
