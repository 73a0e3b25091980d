//! Linear links with tapped forces.
//!
//! Tapped forces are propagated back separately from those that move masses, because the passes of linear links, being
//! their own transposes, handle only the latter.

use crate::parts::record::Row;
use crate::parts::{Basis, Parts, number};
use ca_core::internal::op::Band;
use ca_core::{Scene, State};

pub struct TappedLink {
    pub tap: usize,
    pub ends: [usize; 2],
    slopes: [f64; 2],
    /// Indices of its coefficients, each with its α and β.
    coefs: Vec<(usize, [f64; 2])>,
    /// Its constant elongation, and the index of that number.
    e0: (f64, usize),
}

impl TappedLink {
    /// Returns all of a scene; `place` as for [`Adjoint`](super::adjoint::Adjoint).
    pub fn all(scene: &Scene, parts: &Parts, place: &Scene) -> Vec<TappedLink> {
        let coef = &scene.initial.coef;
        let of = |basis: &Basis, tap: usize, ends: [u32; 2], at: &dyn Fn(usize) -> usize, e0: (f64, f64)| TappedLink {
            tap,
            ends: ends.map(|m| m as usize),
            slopes: basis.slopes(|k| coef[at(k)]),
            coefs: basis.0.iter().enumerate().map(|(k, b)| (number(place.initial.coef[at(k)]), *b)).collect(),
            e0: (e0.0, number(e0.1)),
        };
        let mut all = Vec::new();
        for (k, basis) in &parts.linear {
            let op = &scene.passes.forces[*k];
            if op.form.tap {
                all.extend((0..op.n).map(|i| {
                    let e0 = (scene.layout.links.e0[op.first + i], place.layout.links.e0[op.first + i]);
                    let at = |k: usize| op.coef + k * op.n + i;
                    of(basis, op.tap + i, scene.layout.links.ends[op.first + i], &at, e0)
                }));
            }
        }
        for (h, other) in scene.layout.out.links.iter().zip(&place.layout.out.links) {
            let of_row = |(k, _): &&(usize, Basis)| {
                let op = &scene.passes.moves[*k];
                // links across a row have their numbers after the links along it
                let passes = if op.form.band == Band::None { 1 } else { 2 };
                let coefs = op.law.map_or(0, |law| law.coefs);
                (op.coef..op.coef + passes * coefs * op.n).contains(&(h.coef as usize))
            };
            let Some((_, basis)) = parts.rows.iter().find(of_row) else { continue };
            let at = |k: usize| h.coef as usize + k * h.step as usize;
            all.push(of(basis, h.tap as usize, h.ends, &at, (h.e0, other.e0)));
        }
        all
    }

    /// Propagates adjoints back over it in one tick; `phi` is the adjoint of its force.
    pub fn back(&self, row: &Row, phi: f64, a: &mut State, now: &mut [f64], adjoint: &mut [f64]) {
        let ([p, q], [by_e, by_w]) = (self.ends, self.slopes);
        let (e, w) = (row.x[q] - row.x[p] + self.e0.0, row.d[q] - row.d[p]);
        for (m, sign) in [(q, phi), (p, -phi)] {
            a.f[m] += sign * by_e;
            now[m] += sign * by_w;
        }
        for (at, [of_e, of_w]) in &self.coefs {
            adjoint[*at] += phi * (of_e * e + of_w * w);
        }
        adjoint[self.e0.1] += phi * by_e;
    }
}
