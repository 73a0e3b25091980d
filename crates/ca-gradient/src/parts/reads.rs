//! Reads: what a link that is run alone reads of the numbers of a scene.

use crate::parts::Link;
use crate::parts::alone::Shape;
use ca_core::Scene;

/// What a link that is run alone reads of a scene.
pub struct Reads {
    /// numbers: index into what it reads, the number, and its place among the numbers of the scene
    pub numbers: Vec<(usize, f64, f64)>,
    /// where the last lengths of its ports stand
    pub lengths: Vec<usize>,
}

/// What a link of this `shape` reads; `place` is the scene with each number replaced by its place among them.
pub fn reads(scene: &Scene, place: &Scene, link: &Link, sh: &Shape) -> Reads {
    let op = &scene.forces[link.op];
    let (n, i) = (scene.layout.n_mat, link.i);
    let lengths: Vec<usize> =
        [Some(op.ports.reach), op.ports.onto.map(|o| o.2)].into_iter().flatten().map(|r| r + i).collect();
    let mut numbers: Vec<(usize, f64, f64)> = Vec::new();
    let coefs = [&scene.initial.coef, &place.initial.coef];
    let mut number_at = |k: usize, [v, at]: [f64; 2]| numbers.push((k, v, at));
    for k in 0..sh.coefs {
        number_at(sh.coef() + k, coefs.map(|c| c[op.coef + k * op.n + i]));
    }
    number_at(sh.e0(), [scene, place].map(|s| s.layout.e0[op.first + i]));
    for (which, (p, r)) in sh.ports.iter().zip(&lengths).enumerate().filter(|(_, (p, _))| p.axes > 1) {
        debug_assert_eq!(p.axes, 3);
        for k in 0..4 {
            number_at(sh.reach() + 4 * which + k, [scene, place].map(|s| s.layout.reach[*r][k]));
        }
    }
    for (k, slot) in link.slots.iter().enumerate() {
        for which in 0..3 {
            number_at(sh.own() + which * sh.slots + k, coefs.map(|c| c[which * n + slot]));
        }
    }
    Reads { numbers, lengths }
}
