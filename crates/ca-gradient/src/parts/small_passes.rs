//! Passes with few links or masses, run one by one.
//!
//! A pass takes as long to begin as some links take, and begins in each tick of each derivative: a single mass held at
//! a long string takes as long as half of that string.

use crate::parts::Parts;
use crate::parts::rows::Rows;
use ca_core::internal::op::Op;
use ca_core::{Scene, State};

/// Passes of at most this many links or masses are run one by one.
pub const FEW: usize = 4;

pub struct Small {
    /// Slots of the ends, and the force per e and w.
    links: Vec<([usize; 2], [f64; 2])>,
    /// Slot, and P, Q and C.
    masses: Vec<(usize, [f64; 3])>,
}

impl Small {
    /// Returns them, the other passes of linear links, and the other passes of motion.
    pub fn of<'a>(scene: &'a Scene, parts: &Parts) -> (Small, Vec<&'a Op>, Vec<&'a Op>) {
        let mut small = Small { links: Vec::new(), masses: Vec::new() };
        let (coef, n) = (&scene.initial.coef, scene.layout.counts.n_mat);
        let (mut linear, mut moves) = (Vec::new(), Vec::new());
        for (k, basis) in &parts.linear {
            let op = &scene.passes.forces[*k];
            if op.n > FEW || op.form.tap {
                linear.push(op);
                continue;
            }
            let rows = Rows::listed(scene, op, basis);
            let slopes = |i: usize| basis.slopes(|k| coef[op.coef + k * op.n + i]);
            small.links.extend(rows.slots().enumerate().map(|(i, slots)| (slots, slopes(i))));
        }
        for op in &scene.passes.moves {
            if op.n > FEW || !op.name().starts_with("integrate") {
                moves.push(op);
                continue;
            }
            let own = |m: usize| (m, [0, 1, 2].map(|k| coef[k * n + m]));
            small.masses.extend((op.mat..op.mat + op.n).map(own));
        }
        (small, linear, moves)
    }

    pub fn pull(&self, s: &mut State) {
        for ([a, b], [by_e, by_w]) in &self.links {
            let force = by_e * (s.x[*b] - s.x[*a]) + by_w * (s.d[*b] - s.d[*a]);
            s.f[*a] += force;
            s.f[*b] -= force;
        }
    }

    pub fn integrate(&self, s: &mut State) {
        for (m, [p, q, c]) in &self.masses {
            s.d[*m] = p * s.d[*m] + q * s.x[*m] + c * s.f[*m];
            s.x[*m] += s.d[*m];
            s.f[*m] = 0.0;
        }
    }
}
