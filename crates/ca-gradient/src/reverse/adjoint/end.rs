//! Adjoints of all numbers of a scene, after the backward pass.
//!
//! Sums over all ticks, of adjoints of forces times positions and motions, become adjoints of the numbers that multiply
//! these (docs/numerics.md §9, eq. 3).

use super::Adjoint;
use crate::parts::{Parts, number};
use ca_core::Scene;

impl Adjoint<'_> {
    /// Returns the adjoints of all numbers, once the first tick is done.
    pub fn end(mut self) -> Vec<f64> {
        let (scene, place) = (self.scene, self.place);
        let (coef, adjoint, n) = (&place.initial.coef, &mut self.of_numbers, scene.layout.counts.n_mat);
        let own = &scene.initial.coef;
        // the adjoint of the motion to come is this inertia times ν
        let [by_d, by_both] = [&self.first[..], &self.a.x[..]].map(|v| inertia(scene, self.parts, v));
        for m in 0..n {
            let [p, q, c] = [0, 1, 2].map(|k| own[k * n + m]);
            if c == 0.0 {
                continue;
            }
            adjoint[number(place.initial.d[m])] += by_d[m];
            adjoint[number(place.initial.x[m])] += by_both[m] - by_d[m];
            let [sp, sq, sc] = &self.masses.sums;
            let at = |sums: &[f64]| sums.get(m).copied().unwrap_or(0.0);
            adjoint[number(coef[m])] += at(sp) / c;
            adjoint[number(coef[n + m])] += at(sq) / c;
            if !sc.is_empty() {
                adjoint[number(coef[2 * n + m])] += (at(sc) - p * at(sp) - q * at(sq)) / (c * c);
            }
        }
        for l in self.listed.iter().chain(&self.rows) {
            for i in 0..l.of.n {
                let [by_e, by_w] = l.products.each_ref().map(|sums| sums.get(i).copied().unwrap_or(0.0));
                if let Some(ahead) = l.next_products.get(i) {
                    let [k, z, theta] = [0, 1, 2].map(|k| l.of.coef + k * l.of.n + i);
                    let more = ahead - by_w;
                    adjoint[number(coef[k])] += by_e + own[theta] * more;
                    adjoint[number(coef[z])] += by_w + 0.5 * more;
                    adjoint[number(coef[theta])] += own[k] * more;
                    continue;
                }
                for (k, [e, w]) in l.of.basis.0.iter().enumerate() {
                    adjoint[number(coef[l.of.coef + k * l.of.n + i])] += e * by_e + w * by_w;
                }
            }
            for (i, elongation_sums) in l.elongation_sums.iter().enumerate() {
                let [slope, _] = l.of.basis.slopes(|k| own[l.of.coef + k * l.of.n + i]);
                adjoint[number(place.layout.links.e0[l.of.first + i])] += slope * elongation_sums;
            }
        }
        for (v, by) in place.initial.links.mem.iter().zip(&self.mem) {
            adjoint[number(*v)] += by;
        }
        for (v, by) in place.initial.links.lengths.iter().zip(&self.lengths) {
            adjoint[number(*v)] += by;
        }
        self.of_numbers
    }
}

/// Returns the inertia of the scene times `v`: masses and what implicit links add.
fn inertia(scene: &Scene, parts: &Parts, v: &[f64]) -> Vec<f64> {
    let (n, coef) = (scene.layout.counts.n_mat, &scene.initial.coef);
    let mut all: Vec<f64> = v.iter().zip(&coef[2 * n..]).map(|(v, c)| if *c == 0.0 { 0.0 } else { v / c }).collect();
    for k in &parts.implicit {
        let op = &scene.passes.forces[*k];
        for i in 0..op.n {
            let [a, b] = scene.layout.links.ends[op.first + i].map(|m| m as usize);
            let [k, z, theta] = [0, 1, 2].map(|k| coef[op.coef + k * op.n + i]);
            let force = ca_core::internal::method::implicit::inertia(&[k, z, theta]) * (v[b] - v[a]);
            all[b] += force;
            all[a] -= force;
        }
    }
    all
}
