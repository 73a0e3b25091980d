//! Places masses that belong to no body beside the masses that they are linked to.
//!
//! The order follows the links, starting at the bodies: first masses that move (hammers, plectra, their keys), then
//! masses with many links (a bridge), then fixed points, whose place depends on all that they hold. A mass that rests
//! away from its neighbour along the motion is drawn exactly there, so that its blow looks right; otherwise it is moved
//! move_aside a little. All places differ.

use crate::frame::{Frame, Placed, Places};
use crate::graph::Graph;
use std::collections::{BTreeSet, HashMap};

/// A mass with at least this many permanent links is placed late.
const MANY: usize = 5;

/// Order of placement.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Placement {
    Moves,
    Bridge,
    Fixed,
}

/// Places all remaining nodes.
pub fn place(graph: &Graph, p: &mut Places) {
    let free: Vec<u32> = graph
        .items
        .iter()
        .filter(|i| !i.space)
        .flat_map(crate::graph::Item::nodes)
        .filter(|n| p.placed[*n].is_none())
        .map(|n| n as u32)
        .collect();
    if free.is_empty() {
        return;
    }
    let around = neighbours(graph, &free);
    let grain = 0.006 * p.width;
    let cells = p.placed.iter().flatten().map(|s| (cell(&p.frames, s, grain, [0.0; 3]), 0)).collect();
    let mut occupied = OccupiedCells { cells, grain, width: p.width };
    let tied: Vec<u32> = p.tied.keys().copied().filter(|n| p.placed[*n as usize].is_none()).collect();
    for n in tied {
        if let Some(mut stand) = p.tie_one(graph, n) {
            occupied.move_aside(&p.frames, &mut stand);
            p.placed[n as usize] = Some(stand);
        }
    }
    let held = |around: &[(u32, bool)]| around.iter().filter(|(_, contact)| !contact).count();
    let order = |i: usize| {
        let n = free[i] as usize;
        match () {
            () if graph.is_fixed(n) => Placement::Fixed,
            () if held(&around[i]) >= MANY && !graph.is_port(n) => Placement::Bridge,
            () => Placement::Moves,
        }
    };
    // index in `free` of each node
    let mut of = vec![usize::MAX; graph.len()];
    free.iter().enumerate().for_each(|(i, n)| of[*n as usize] = i);
    let mut waiting: BTreeSet<(Placement, usize)> = BTreeSet::new();
    for i in 0..free.len() {
        if p.placed[free[i] as usize].is_none() && around[i].iter().any(|(n, _)| p.placed[*n as usize].is_some()) {
            waiting.insert((order(i), i));
        }
    }
    let left = (0..free.len()).filter(|i| p.placed[free[*i] as usize].is_none());
    let mut left: BTreeSet<(Placement, usize)> = left.map(|i| (order(i), i)).collect();
    let mut alone = 0;
    loop {
        // all masses of one stage that are next to placed ones, together
        let round: Vec<usize> = match waiting.first() {
            Some((now, _)) => waiting.iter().take_while(|w| w.0 == *now).map(|w| w.1).collect(),
            None => match left.first() {
                Some(l) => vec![l.1],
                None => break,
            },
        };
        let stands: Vec<Placed> = round
            .iter()
            .map(|i| {
                beside_neighbours(graph, p, free[*i] as usize, &around[*i], order(*i)).unwrap_or_else(|| {
                    alone += 1;
                    by_itself(graph, p, free[*i] as usize, alone - 1)
                })
            })
            .collect();
        for (i, mut stand) in round.iter().zip(stands) {
            occupied.move_aside(&p.frames, &mut stand);
            p.placed[free[*i] as usize] = Some(stand);
            waiting.remove(&(order(*i), *i));
            left.remove(&(order(*i), *i));
        }
        for i in round {
            for (n, _) in &around[i] {
                let next = of[*n as usize];
                if next != usize::MAX && p.placed[*n as usize].is_none() {
                    waiting.insert((order(next), next));
                }
            }
        }
    }
}

/// Returns the neighbours on a line of each free mass, and whether the link is a contact.
fn neighbours(graph: &Graph, free: &[u32]) -> Vec<Vec<(u32, bool)>> {
    let mut of = vec![usize::MAX; graph.len()];
    free.iter().enumerate().for_each(|(i, n)| of[*n as usize] = i);
    let mut all = vec![Vec::new(); free.len()];
    for e in &graph.edges {
        let [a, b] = e.ends;
        for (from, to) in [(a, b), (b, a)] {
            if let Some(list) = all.get_mut(of[from as usize]) {
                if !graph.is_space(to as usize) {
                    list.push((to, graph.is_contact(e)));
                }
            }
        }
    }
    all
}

/// Places a mass beside its neighbours, if any of them is placed.
fn beside_neighbours(
    graph: &Graph,
    p: &Places,
    node: usize,
    around: &[(u32, bool)],
    order: Placement,
) -> Option<Placed> {
    let w = p.width;
    let standing = || around.iter().filter_map(|(n, _)| p.placed[*n as usize]);
    let frame = standing().next()?.frame;
    let (mut sum, mut low, mut high, mut n) = ([0.0; 3], [f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0);
    for s in standing().filter(|s| s.frame == frame) {
        for k in 0..3 {
            sum[k] += s.at[k];
            low[k] = low[k].min(s.at[k]);
            high[k] = high[k].max(s.at[k]);
        }
        n += 1.0;
    }
    let [u, v, height] = sum.map(|s| s / n);
    let rest = graph.rest[node][0];
    let apart = (rest - height).abs() >= 0.004 * w;
    let at = match order {
        Placement::Moves if apart => [u, v, rest],
        Placement::Moves if graph.code(node) == "CEL" => [u, v + 0.1 * w, rest + 0.06 * w],
        Placement::Moves => [u, v - 0.06 * w, rest - 0.08 * w],
        Placement::Bridge => [u, high[1] + 0.16 * w, rest],
        Placement::Fixed => {
            let beyond = around.iter().map(|(m, _)| p.beyond[*m as usize]).find(|b| *b != 0.0);
            let wide = high[0] - low[0];
            // a fixed point that is struck stands at its rest
            let met = apart && around.iter().any(|(_, contact)| *contact);
            let below = |by: f64| if met { rest } else { height - by * w };
            match beyond {
                // end of a row
                Some(beyond) if n == 1.0 => [u + beyond, v, rest],
                // holds a row of several masses: beside its left end
                _ if n > 2.0 && high[1] - low[1] < 0.5 * wide => [low[0] - 0.08 * w, v, below(0.03)],
                _ if n > 1.0 => [u, v, below(if n < MANY as f64 { 0.14 } else { 0.3 })],
                _ => [u - 0.07 * w, v - 0.02 * w, below(0.14)],
            }
        }
    };
    Some(Placed { frame, at })
}

/// Places a mass without placed neighbours, in rows in front of everything else.
fn by_itself(graph: &Graph, p: &Places, node: usize, i: usize) -> Placed {
    let (column, row) = ((i % 9) as f64, (i / 9) as f64);
    let at = [(column - 4.0) / 8.0 * p.width, p.front - (0.25 + 0.12 * row) * p.width, graph.rest[node][0]];
    Placed { frame: 0, at }
}

/// Returns the grid cell of a node, shifted by `moved` cells, in the first frame or in space.
fn cell(frames: &[Frame], s: &Placed, grain: f64, moved: [f64; 3]) -> [i64; 4] {
    let at = if s.frame == 0 { s.at } else { frames[s.frame].point(s.at) };
    let [a, b, c] = [0, 1, 2].map(|k| libm::floor(at[k] / grain + moved[k]) as i64);
    [s.frame.min(1) as i64, a, b, c]
}

struct OccupiedCells {
    /// Occupied cells, with the number of masses that were moved move_aside from each.
    cells: HashMap<[i64; 4], u32>,
    grain: f64,
    width: f64,
}

impl OccupiedCells {
    /// Returns true if another mass stands within a quarter of a cell.
    fn has(&self, frames: &[Frame], s: &Placed) -> bool {
        let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -0.25 } else { 0.25 });
        (0..8).any(|i| self.cells.contains_key(&cell(frames, s, self.grain, corner(i))))
    }

    /// Moves a mass move_aside, around its wanted place, until no other stands there.
    fn move_aside(&mut self, frames: &[Frame], s: &mut Placed) {
        let (wanted, from) = (cell(frames, s, self.grain, [0.0; 3]), s.at);
        let mut k = self.cells.get(&wanted).copied().unwrap_or(0);
        while self.has(frames, s) {
            k += 1;
            // first a row to both sides, then a spiral
            let (right, back) = if k <= 12 {
                (f64::from(k.div_ceil(2)) * if k % 2 == 0 { -1.0 } else { 1.0 }, 0.0)
            } else {
                let (r, angle) = (libm::sqrt(f64::from(k)) + 4.0, 2.399_963_229_728_653 * f64::from(k));
                (r * libm::cos(angle), r * libm::sin(angle))
            };
            let step = 0.045 * self.width;
            s.at = [from[0] + step * right, from[1] + step * back, from[2]];
        }
        self.cells.insert(cell(frames, s, self.grain, [0.0; 3]), 0);
        self.cells.insert(wanted, k);
    }
}
