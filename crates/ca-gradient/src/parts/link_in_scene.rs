//! Links evaluated alone, located in a scene: the numbers and state that they read there.

use crate::parts::Link;
use crate::parts::record::Row;
use crate::parts::single_link::SingleLink;
use ca_core::internal::op::Op;
use ca_core::{Dual, Scene};

/// A link evaluated alone, or several solved together, with its location in the scene.
pub struct Placed {
    pub single: SingleLink,
    pub slots: Vec<usize>,
    /// Indices of its memory, and of the last lengths of its ports.
    pub mem: Vec<usize>,
    pub lengths: Vec<usize>,
    /// Tap of each force, if it is tapped.
    pub taps: Vec<Option<usize>>,
    /// Numbers it reads: index into the values read, and index of the number stored as `f64`.
    pub numbers: Vec<(usize, f64)>,
    /// Indices of its coefficients, in the order in which it reads them.
    pub coefs: Vec<usize>,
    /// Elongations without a force, for contacts on a line without memory.
    pub idle: Option<(f64, f64)>,
    /// Its memory may be nonzero while it gives no force.
    remembers: bool,
}

impl Placed {
    /// Locates a link; `place` is the scene with each number replaced by its index. Returns `None` where the `dual`
    /// scene does not have its law.
    pub fn new(scene: &Scene, link: &Link, dual: &Scene<Dual>, place: &Scene) -> Option<Placed> {
        let ops: Vec<&Op> = link.members.iter().map(|(k, _)| &scene.passes.forces[*k]).collect();
        let each = || ops.iter().zip(&link.members).map(|(op, (_, i))| (*op, *i));
        let mut single = if link.together {
            let at = |m: u32| link.slots.binary_search(&(m as usize)).map_or(0, |at| at as u32);
            let ends = each().map(|(op, i)| scene.layout.links.ends[op.first + i].map(at)).collect();
            SingleLink::together(&ops, ends, link.slots.len(), dual)?
        } else {
            SingleLink::new(ops[0], dual)?
        };
        let (sh, n) = (&single.shape, scene.layout.counts.n_mat);
        let reaches = |(op, i): (&Op, usize)| {
            let of = [Some(op.ports.reach), op.ports.onto.map(|o| o.2)];
            of.into_iter().flatten().map(move |r| r + i)
        };
        let lengths: Vec<usize> = each().flat_map(reaches).collect();
        let of_law = |op: &Op| op.law.map_or((0, 0), |law| (law.coefs, law.mem));
        let coefs =
            each().flat_map(|(op, i)| (0..of_law(op).0).map(move |k| op.coef + k * op.n + i)).collect::<Vec<_>>();
        let mem = each().flat_map(|(op, i)| (0..of_law(op).1).map(move |k| op.mem + i * of_law(op).1 + k)).collect();
        let mut numbers: Vec<(usize, f64, f64)> = Vec::new();
        let mut number_at = |k: usize, [v, at]: [f64; 2]| numbers.push((k, v, at));
        let all = [&scene.initial.coef, &place.initial.coef];
        for (k, coef) in coefs.iter().enumerate() {
            number_at(sh.coef() + k, all.map(|c| c[*coef]));
        }
        for (k, (op, i)) in each().enumerate() {
            number_at(sh.e0() + k, [scene, place].map(|s| s.layout.links.e0[op.first + i]));
        }
        for (which, (p, r)) in sh.ports.iter().zip(&lengths).enumerate().filter(|(_, (p, _))| p.axes > 1) {
            debug_assert_eq!(p.axes, 3);
            for k in 0..4 {
                number_at(sh.reach() + 4 * which + k, [scene, place].map(|s| s.layout.links.reach[*r][k]));
            }
        }
        for (k, slot) in link.slots.iter().enumerate() {
            for which in 0..3 {
                number_at(sh.own() + which * sh.slots + k, all.map(|c| c[which * n + slot]));
            }
        }
        for (k, v, _) in &numbers {
            single.given[*k] = *v;
        }
        Some(Placed {
            slots: link.slots.clone(),
            mem,
            lengths,
            taps: each().map(|(op, i)| op.form.tap.then_some(op.tap + i)).collect(),
            numbers: numbers.into_iter().map(|(k, _, at)| (k, at)).collect(),
            coefs,
            idle: single.idle(ops[0]),
            remembers: link.together,
            single,
        })
    }

    /// Returns whether it gives no force in the tick that began with `row`. For a link that depends on the sum of
    /// forces, `sums` holds the forces on its ends before it and the size of what it adds.
    pub fn is_idle(&self, row: &Row, sums: Option<&[f64]>) -> bool {
        let away = |(from, to): (f64, f64)| {
            let e = row.x[self.slots[1]] - row.x[self.slots[0]] + self.single.given[self.single.shape.e0()];
            e >= from && e <= to
        };
        let empty = || !self.remembers || self.mem.iter().all(|m| row.mem[*m] == 0.0);
        sums.is_some_and(|sums| sums.last() == Some(&0.0)) && empty() || self.idle.is_some_and(away)
    }

    pub fn read(&mut self, row: &Row, sums: Option<&[f64]>) {
        let SingleLink { given, shape: sh, .. } = &mut self.single;
        for (k, slot) in self.slots.iter().enumerate() {
            (given[k], given[sh.d() + k]) = (row.x[*slot], row.d[*slot]);
        }
        if let Some((_, sums)) = sums.and_then(<[f64]>::split_last) {
            given[sh.f()..][..sums.len()].copy_from_slice(sums);
        }
        for (to, at) in given[sh.memory()..].iter_mut().zip(&self.mem) {
            *to = row.mem[*at];
        }
        for (k, (_, at)) in sh.ports.iter().zip(&self.lengths).enumerate().filter(|(_, (p, _))| p.follows) {
            given[sh.length() + k] = row.lengths[*at];
        }
    }
}
