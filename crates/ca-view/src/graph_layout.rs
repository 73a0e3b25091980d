//! Lays out the nodes of a network in a plane, so that nodes far apart along the links are far apart there.
//!
//! The method is multidimensional scaling by pivots (Brandes and Pich, 2007). It counts distances in links to a few
//! nodes that are far from each other, and takes the two directions of largest variation in their centred squares. It
//! needs one breadth-first search for each pivot, whatever the length of the network. Iterating eigenvectors of the
//! Laplacian takes about as many steps as the square of that length, and relaxing springs takes more. Distances without
//! squares would be simpler, but bend long networks to a bow.

use crate::graph::NONE;

const PIVOTS: usize = 10;

/// Adjacency lists of some nodes.
pub struct Adjacency {
    start: Vec<u32>,
    list: Vec<u32>,
}

impl Adjacency {
    /// Builds the lists of `nodes`, renumbered in their order, out of `n`. Double links count once.
    pub fn new(n: usize, nodes: &[u32], links: &(impl Iterator<Item = [u32; 2]> + Clone)) -> Adjacency {
        let mut number = vec![NONE; n];
        nodes.iter().enumerate().for_each(|(i, n)| number[*n as usize] = i as u32);
        let pairs = || {
            let both = links.clone().map(|e| e.map(|n| number[n as usize]));
            both.filter(|[a, b]| *a != NONE && *b != NONE && a != b)
        };
        let mut start = vec![0u32; nodes.len() + 1];
        pairs().flatten().for_each(|a| start[a as usize + 1] += 1);
        (0..nodes.len()).for_each(|i| start[i + 1] += start[i]);
        let (mut next, mut list) = (start.clone(), vec![0; start[nodes.len()] as usize]);
        for [a, b] in pairs() {
            for (from, to) in [(a, b), (b, a)] {
                list[next[from as usize] as usize] = to;
                next[from as usize] += 1;
            }
        }
        let (mut once, mut begin) = (Vec::with_capacity(list.len()), Vec::with_capacity(start.len()));
        for i in 0..nodes.len() {
            begin.push(once.len() as u32);
            let around = &mut list[start[i] as usize..start[i + 1] as usize];
            around.sort_unstable();
            let from = once.len();
            for a in around {
                if once[from..].last() != Some(a) {
                    once.push(*a);
                }
            }
        }
        begin.push(once.len() as u32);
        Adjacency { start: begin, list: once }
    }

    /// Returns the number of nodes.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Returns the neighbours of a node.
    pub fn neighbours(&self, i: usize) -> &[u32] {
        &self.list[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// Returns the connected components, each in ascending order.
    pub fn components(&self) -> Vec<Vec<usize>> {
        let mut seen = vec![false; self.len()];
        let mut all = Vec::new();
        for first in 0..self.len() {
            if seen[first] {
                continue;
            }
            seen[first] = true;
            let mut part = vec![first];
            let mut at = 0;
            while at < part.len() {
                for n in self.neighbours(part[at]) {
                    if !seen[*n as usize] {
                        seen[*n as usize] = true;
                        part.push(*n as usize);
                    }
                }
                at += 1;
            }
            part.sort_unstable();
            all.push(part);
        }
        all
    }

    /// Counts the links from `from` to every node; unreachable nodes get one more than the farthest.
    fn distances(&self, from: usize) -> Vec<f64> {
        let mut at = vec![f64::INFINITY; self.len()];
        let mut queue = vec![from];
        at[from] = 0.0;
        let mut head = 0;
        while head < queue.len() {
            let here = queue[head];
            head += 1;
            for n in self.neighbours(here) {
                if at[*n as usize].is_infinite() {
                    at[*n as usize] = at[here] + 1.0;
                    queue.push(*n as usize);
                }
            }
        }
        let far = at[queue[queue.len() - 1]] + 1.0;
        at.iter_mut().filter(|d| d.is_infinite()).for_each(|d| *d = far);
        at
    }
}

/// Returns a place for each node.
pub fn layout(net: &Adjacency) -> Vec<[f64; 2]> {
    let n = net.len();
    if n == 0 {
        return Vec::new();
    }
    // each pivot is the node farthest from those before
    let mut all: Vec<Vec<f64>> = Vec::new();
    let mut nearest = vec![f64::INFINITY; n];
    let mut pivot = 0;
    for _ in 0..PIVOTS.min(n) {
        let d = net.distances(pivot);
        nearest.iter_mut().zip(&d).for_each(|(m, d)| *m = m.min(*d));
        all.push(d);
        pivot = (0..n).fold(0, |best, i| if nearest[i] > nearest[best] { i } else { best });
    }
    let far = largest(&all);
    let pivots = all.len() as f64;
    let mut of_node = vec![0.0; n];
    for d in &mut all {
        for v in d.iter_mut() {
            *v *= *v;
        }
        let mean = d.iter().sum::<f64>() / n as f64;
        d.iter_mut().zip(&mut of_node).for_each(|(v, sum)| {
            *v -= mean;
            *sum += *v / pivots;
        });
    }
    for d in &mut all {
        d.iter_mut().zip(&of_node).for_each(|(v, mean)| *v = -0.5 * (*v - mean));
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut matrix: Vec<Vec<f64>> = all.iter().map(|a| all.iter().map(|b| dot(a, b)).collect()).collect();
    let axes = [0, 1].map(|_| principal(&mut matrix));
    let along = |i: usize, axis: &[f64]| all.iter().zip(axis).map(|(d, a)| d[i] * a).sum::<f64>();
    let mut at: Vec<[f64; 2]> = (0..n).map(|i| [along(i, &axes[0]), along(i, &axes[1])]).collect();
    // products of distances scale as squares of places
    for k in 0..2 {
        let size = libm::pow(at.iter().map(|p| p[k] * p[k]).sum::<f64>(), 0.25);
        if size > 0.0 {
            for p in &mut at {
                p[k] /= size;
            }
        }
    }
    let (low, high) = at.iter().fold((0.0f64, 0.0f64), |(low, high), p| (low.min(p[0]), high.max(p[0])));
    let link = if high > low { (high - low) / far } else { 1.0 };
    // nodes equally far from all pivots (leaves of one branch) are moved apart, each in a different direction
    for (i, p) in at.iter_mut().enumerate() {
        let r = link * if net.neighbours(i).len() < 2 { 0.4 } else { 0.05 };
        let angle = 2.399_963_229_728_653 * i as f64;
        *p = [p[0] + r * libm::cos(angle), p[1] + r * libm::sin(angle)];
    }
    at
}

fn largest(all: &[Vec<f64>]) -> f64 {
    all.iter().flatten().copied().fold(1.0, f64::max)
}

/// Returns the eigenvector of the largest eigenvalue of a symmetric matrix, and removes it from the matrix.
fn principal(matrix: &mut [Vec<f64>]) -> Vec<f64> {
    let n = matrix.len();
    let mut v: Vec<f64> = (0..n).map(|i| 1.0 / (1.0 + i as f64)).collect();
    let mut value = 0.0;
    for _ in 0..200 {
        let next: Vec<f64> = matrix.iter().map(|row| row.iter().zip(&v).map(|(a, b)| a * b).sum()).collect();
        value = libm::sqrt(next.iter().map(|x| x * x).sum());
        if value <= 1e-300 {
            return vec![0.0; n];
        }
        v = next.into_iter().map(|x| x / value).collect();
    }
    for (row, a) in matrix.iter_mut().zip(&v) {
        row.iter_mut().zip(&v).for_each(|(m, b)| *m -= value * a * b);
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
        libm::hypot(a[0] - b[0], a[1] - b[1])
    }

    #[test]
    fn a_grid_is_spread_as_a_grid() {
        let (nx, ny) = (12u32, 9u32);
        let along = (0..nx * ny).filter(|n| n % ny + 1 < ny).map(|n| [n, n + 1]);
        let across = (0..(nx - 1) * ny).map(|n| [n, n + ny]);
        let links: Vec<[u32; 2]> = along.chain(across).collect();
        let nodes: Vec<u32> = (0..nx * ny).collect();
        let at = layout(&Adjacency::new(nodes.len(), &nodes, &links.iter().copied()));
        let lengths: Vec<f64> = links.iter().map(|[a, b]| apart(at[*a as usize], at[*b as usize])).collect();
        let (short, long) = lengths.iter().fold((f64::INFINITY, 0.0f64), |(s, l), v| (s.min(*v), l.max(*v)));
        assert!(long < 3.0 * short, "{short} to {long}");
        // all nodes are farther apart than half of the shortest link
        for i in 0..at.len() {
            assert!((0..i).all(|j| apart(at[i], at[j]) > 0.5 * short), "{i}");
        }
    }

    #[test]
    fn what_is_long_is_not_bent_and_leaves_stand_apart() {
        // ladder of 40 steps, with three leaves at one end
        let mut links: Vec<[u32; 2]> = (0..40).flat_map(|i| [[2 * i, 2 * i + 2], [2 * i + 1, 2 * i + 3]]).collect();
        links.extend((0..41).map(|i| [2 * i, 2 * i + 1]));
        links.extend((82..85).map(|leaf| [81, leaf]));
        let nodes: Vec<u32> = (0..85).collect();
        let net = Adjacency::new(85, &nodes, &links.iter().copied());
        let at = layout(&net);
        let length = apart(at[0], at[80]);
        let (low, high) = at.iter().fold((0.0f64, 0.0f64), |(l, h), p| (l.min(p[1]), h.max(p[1])));
        assert!(high - low < 0.3 * length, "{} of {length}", high - low);
        assert!((0..40).all(|i| (at[2 * i + 2][0] - at[2 * i][0]) * (at[80][0] - at[0][0]) > 0.0));
        assert!(apart(at[82], at[83]) > 0.002 * length && apart(at[83], at[84]) > 0.002 * length);
        assert_eq!(net.components().len(), 1);
        assert!(layout(&Adjacency::new(0, &[], &[].into_iter())).is_empty());
    }
}
