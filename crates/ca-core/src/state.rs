//! State: all numbers that change while a scene plays, as flat arrays.
//!
//! Decides that a state is plain data: a clone is a snapshot, assigning it restores, a hash of its bits is a golden
//! number. Positions are relative to rest and motion is the change per tick, which drifts far less than keeping two
//! absolute positions (numerics 1.6).

use crate::border::Border;
use crate::energy::Ledger;
use crate::live::Ramps;
use crate::scene::Scene;
use alloc::vec::Vec;
use core::hash::Hasher;

/// Nodes and weights under a moving point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    /// how many of the four are used: 2 on a string, 4 on a mesh
    pub n: usize,
    /// places among the MATs
    pub node: [u32; 4],
    /// weights, which sum to 1
    pub weight: [f64; 4],
}

/// All that changes. Shapes in brackets; the writer of each array is named.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// displacement from rest \[m\] (n_mat); written by `moves`, ports by `reads`
    pub x: Vec<f64>,
    /// x_n − x_{n−1} \[m/tick\] (n_mat); written with `x`
    pub d: Vec<f64>,
    /// summed force \[N\] (n_mat); written by `forces`, cleared by `moves`
    pub f: Vec<f64>,
    /// coefficients (n_coef): P, Q and C of the MATs, then those of weights, links, points and outputs;
    /// written at load and by changes
    pub coef: Vec<f64>,
    /// memory of laws (n_mem); written by `forces`
    pub mem: Vec<f64>,
    /// forces of links that are heard, audited or in passing \[N\] (n_tap); written by `forces`
    pub tap: Vec<f64>,
    /// what the ports are given, absolute \[m\] or \[N\]; written by the caller before a tick (devices: before a frame)
    pub input: Vec<f64>,
    /// the last good value of each input (inputs); written by `reads`
    pub held: Vec<f64>,
    /// what is heard (n_out); written by `writes`
    pub output: Vec<f64>,
    /// moving points (proxies); written by `aim`
    pub cells: Vec<Cell>,
    /// device ports (tgr); written by the border
    pub border: Vec<Border>,
    /// coefficients on their way to a new value
    pub ramps: Ramps,
    /// energy book, where the scene keeps one
    pub ledger: Option<Ledger>,
    /// ticks done
    pub tick: u64,
    /// inputs that were not finite and were held or zeroed instead
    pub refused: u64,
}

impl State {
    /// A hash of everything that decides the future: FNV-1a over the bits of positions, motions, coefficients, memory,
    /// border and tick. Equal states have equal hashes on every machine.
    pub fn bits(&self) -> u64 {
        let mut h = fnv::FnvHasher::default();
        for v in [&self.x, &self.d, &self.coef, &self.mem].into_iter().flatten() {
            h.write(&v.to_bits().to_le_bytes());
        }
        for b in &self.border {
            for v in [b.from, b.to, b.sum] {
                h.write(&v.to_bits().to_le_bytes());
            }
        }
        h.write(&self.tick.to_le_bytes());
        h.finish()
    }

    /// True while every position and motion is finite and below `limit` \[m\].
    pub fn is_sound(&self, limit: f64) -> bool {
        self.x.iter().all(|x| x.abs() < limit) && self.d.iter().all(|d| d.abs() < limit)
    }

    /// The MAT with the largest displacement, or the first that is not finite.
    pub fn wildest(&self) -> usize {
        let size = |i: &usize| if self.x[*i].is_nan() { f64::INFINITY } else { self.x[*i].abs() };
        (0..self.x.len()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0)
    }

    /// The value of a position input; one that is not finite is replaced by the last good one, and counted.
    pub(crate) fn heard(&mut self, input: u32) -> f64 {
        let i = input as usize;
        let v = self.input[i];
        if v.is_finite() {
            self.held[i] = v;
        } else {
            self.refused += 1;
        }
        self.held[i]
    }
}

/// Runs one tick: inputs → changes → forces at x_n → outputs → advance.
pub fn tick(scene: &Scene, s: &mut State) {
    sense(scene, s);
    advance(scene, s);
}

/// The first half of a tick: reads inputs, sums the forces at x_n and writes the outputs. What a device must get of
/// this tick is known here, before any mass moves.
pub fn sense(scene: &Scene, s: &mut State) {
    for op in scene.reads.iter().chain(&scene.forces).chain(&scene.writes) {
        (op.kernel)(op, scene, s);
    }
}

/// The second half of a tick: moves the masses from x_n to x_{n+1}.
pub fn advance(scene: &Scene, s: &mut State) {
    for op in &scene.moves {
        (op.kernel)(op, scene, s);
    }
    s.tick += 1;
}

/// Runs `out.len() / n_out` ticks and writes their outputs, interleaved. Inputs keep the values they have.
pub fn process(scene: &Scene, s: &mut State, out: &mut [f64]) {
    for frame in out.chunks_exact_mut(scene.n_out.max(1)) {
        tick(scene, s);
        for (o, v) in frame.iter_mut().zip(&s.output) {
            *o = *v;
        }
    }
}
