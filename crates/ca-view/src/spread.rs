//! Spread: places in a plane for the nodes of a network, so that what is far apart along the links is far apart there.
//!
//! Decides for the high-dimensional embedding of Harel and Koren (2002): distances to a few nodes that are far from each
//! other, counted in links, and of these numbers the two directions in which they differ most. It takes one walk over the
//! network for each of them, however long the network is; eigenvectors of the Laplacian by iteration take as many as the
//! square of its length, and springs that find their balance take more.

use crate::graph::NONE;

/// Nodes to which distances are counted.
const PIVOTS: usize = 10;

/// Who is next to whom, among some nodes.
pub struct Adjacent {
    start: Vec<u32>,
    list: Vec<u32>,
}

impl Adjacent {
    /// Among `nodes` of `n`, which are numbered in their order; a pair that is linked twice stands here once.
    pub fn new(n: usize, nodes: &[u32], links: impl Iterator<Item = [u32; 2]> + Clone) -> Adjacent {
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
        Adjacent { start: begin, list: once }
    }

    /// How many nodes.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Those next to a node.
    pub fn around(&self, i: usize) -> &[u32] {
        &self.list[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// The parts that hang together, each in ascending order.
    pub fn parts(&self) -> Vec<Vec<usize>> {
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
                for n in self.around(part[at]) {
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

    /// Links from `from` to every node; to what cannot be reached one more than to the furthest.
    fn distances(&self, from: usize) -> Vec<f64> {
        let mut at = vec![f64::INFINITY; self.len()];
        let mut queue = vec![from];
        at[from] = 0.0;
        let mut head = 0;
        while head < queue.len() {
            let here = queue[head];
            head += 1;
            for n in self.around(here) {
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

/// A place for each node.
pub fn spread(net: &Adjacent) -> Vec<[f64; 2]> {
    let n = net.len();
    if n == 0 {
        return Vec::new();
    }
    // each pivot is the node that is furthest from those before
    let mut all: Vec<Vec<f64>> = Vec::new();
    let mut nearest = vec![f64::INFINITY; n];
    let mut pivot = 0;
    for _ in 0..PIVOTS.min(n) {
        let d = net.distances(pivot);
        nearest.iter_mut().zip(&d).for_each(|(m, d)| *m = m.min(*d));
        all.push(d);
        pivot = (0..n).fold(0, |best, i| if nearest[i] > nearest[best] { i } else { best });
    }
    for d in &mut all {
        let mean = d.iter().sum::<f64>() / n as f64;
        d.iter_mut().for_each(|v| *v -= mean);
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut matrix: Vec<Vec<f64>> = all.iter().map(|a| all.iter().map(|b| dot(a, b)).collect()).collect();
    let axes = [0, 1].map(|_| principal(&mut matrix));
    let along = |i: usize, axis: &[f64]| all.iter().zip(axis).map(|(d, a)| d[i] * a).sum::<f64>();
    // what is equally far from all pivots (leaves of one branch) is moved apart, each in a direction of its own
    let golden = 2.399_963_229_728_653;
    let at = |i: usize| {
        let [x, y] = [0, 1].map(|k| along(i, &axes[k]));
        let r = if net.around(i).len() < 2 { 0.45 } else { 0.05 };
        [x + r * libm::cos(golden * i as f64), y + r * libm::sin(golden * i as f64)]
    };
    (0..n).map(at).collect()
}

/// The eigenvector of the largest eigenvalue of a symmetric matrix, which is then taken out of it.
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
