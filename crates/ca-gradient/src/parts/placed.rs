//! Placed: a link that is run alone, at its place in a scene: what it reads there, and when it gives no force.

use crate::parts::Link;
use crate::parts::alone::Alone;
use crate::parts::record::Row;
use ca_core::Scene;
use std::ops::Range;

/// A link that is run alone, at its place.
pub struct Placed {
    pub alone: Alone,
    /// slots of its ends
    pub slots: Vec<usize>,
    /// its memory, and the last lengths of its ports
    pub mem: Range<usize>,
    pub lengths: Vec<usize>,
    pub tap: Option<usize>,
    /// the numbers it reads: index into what it reads, and the place of each among the numbers of the scene
    pub numbers: Vec<(usize, f64)>,
    /// elongations at which there is no force, of contacts on a line without memory
    pub idle: Option<(f64, f64)>,
}

impl Placed {
    /// A link of a scene, its numbers given; `place` is the scene with each number replaced by its place among them. `None` where its law
    /// is none of the `dual` scene.
    pub fn new(scene: &Scene, link: &Link, dual: &ca_core_dual::Scene, place: &Scene) -> Option<Placed> {
        let op = &scene.forces[link.op];
        let mut alone = Alone::new(op, dual)?;
        let (sh, n, i) = (&alone.shape, scene.layout.n_mat, link.i);
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
        for (k, v, _) in &numbers {
            alone.given[*k] = *v;
        }
        let mem = op.mem + i * alone.shape.mem;
        Some(Placed {
            slots: link.slots.clone(),
            mem: mem..mem + alone.shape.mem,
            lengths,
            tap: op.form.tap.then_some(op.tap + i),
            numbers: numbers.into_iter().map(|(k, _, at)| (k, at)).collect(),
            idle: alone.idle(op),
            alone,
        })
    }

    /// True where it gives no force in a tick that began with `row`; `sums` are the forces on its ends before it, and how much it adds,
    /// where it goes by them.
    pub fn is_idle(&self, row: &Row, sums: Option<&[f64]>) -> bool {
        let away = |(from, to): (f64, f64)| {
            let e = row.x[self.slots[1]] - row.x[self.slots[0]] + self.alone.given[self.alone.shape.e0()];
            e >= from && e <= to
        };
        sums.is_some_and(|sums| sums.last() == Some(&0.0)) || self.idle.is_some_and(away)
    }

    /// Gives it what it reads of a tick.
    pub fn read(&mut self, row: &Row, sums: Option<&[f64]>) {
        let Alone { given, shape: sh, .. } = &mut self.alone;
        for (k, slot) in self.slots.iter().enumerate() {
            (given[k], given[sh.d() + k]) = (row.x[*slot], row.d[*slot]);
        }
        if let Some((_, sums)) = sums.and_then(<[f64]>::split_last) {
            given[sh.f()..][..sums.len()].copy_from_slice(sums);
        }
        given[sh.memory()..][..sh.mem].copy_from_slice(&row.mem[self.mem.clone()]);
        for (k, (_, at)) in sh.ports.iter().zip(&self.lengths).enumerate().filter(|(_, (p, _))| p.follows) {
            given[sh.length() + k] = row.lengths[*at];
        }
    }
}
