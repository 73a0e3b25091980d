//! Small: links and masses of passes that have few, run one by one.
//!
//! Decides so because a pass takes as long to begin as some links do, and is begun in each tick of each derivative: a mass that
//! is held at a long string takes as long there as half of the string.

use crate::parts::Parts;
use crate::parts::rows::Rows;
use ca_core::internal::op::Op;
use ca_core::{Scene, State};

/// As many of a pass.
pub const FEW: usize = 4;

/// All of a scene.
pub struct Small {
    /// slots of the ends, and the force per e and w
    links: Vec<([usize; 2], [f64; 2])>,
    /// slots, and P, Q and C
    masses: Vec<(usize, [f64; 3])>,
}

impl Small {
    /// Those of a scene, and all its other passes of linear links and of motion.
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

    /// Adds the forces of the links.
    pub fn pull(&self, s: &mut State) {
        for ([a, b], [by_e, by_w]) in &self.links {
            let force = by_e * (s.x[*b] - s.x[*a]) + by_w * (s.d[*b] - s.d[*a]);
            s.f[*a] += force;
            s.f[*b] -= force;
        }
    }

    /// Moves the masses.
    pub fn integrate(&self, s: &mut State) {
        for (m, [p, q, c]) in &self.masses {
            s.d[*m] = p * s.d[*m] + q * s.x[*m] + c * s.f[*m];
            s.x[*m] += s.d[*m];
            s.f[*m] = 0.0;
        }
    }
}
