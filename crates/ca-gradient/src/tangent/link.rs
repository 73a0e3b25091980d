//! Link: one that is run alone, with the derivatives of all that it reads.

use crate::parts::alone::Alone;
use crate::parts::reads::{Reads, reads};
use crate::parts::record::Row;
use crate::parts::{Link, number};
use ca_core::{Scene, State};

/// A link that is run alone.
pub struct Moving {
    alone: Alone,
    /// slots of its ends
    slots: Vec<usize>,
    /// first number of its memory, and those of its lengths
    mem: usize,
    lengths: Vec<usize>,
    tap: Option<usize>,
    /// elongations at which there is no force, of contacts on a line without memory
    idle: Option<(f64, f64)>,
}

impl Moving {
    /// A link of a scene; the rest as for [`Added`](super::added::Added).
    pub fn new(
        scene: &Scene,
        link: &Link,
        dual: &ca_core_dual::Scene,
        place: &Scene,
        columns: &[&[f64]],
    ) -> Option<Moving> {
        let op = &scene.forces[link.op];
        let mut alone = Alone::new(op, dual)?;
        let Reads { numbers, lengths } = reads(scene, place, link, &alone.shape);
        for (k, v, at) in numbers {
            alone.given[k] = v;
            for (to, column) in alone.moving[k].iter_mut().zip(columns) {
                *to = column[number(at)];
            }
        }
        Some(Moving {
            mem: op.mem + link.i * alone.shape.mem,
            lengths,
            tap: op.form.tap.then_some(op.tap + link.i),
            slots: link.slots.clone(),
            idle: alone.idle(op),
            alone,
        })
    }

    /// How many slots its ends have.
    pub fn slots(&self) -> usize {
        self.slots.len()
    }

    /// The link in one tick, which began with `row`, and its derivatives, added to those of all else, `to`; `sums` as for
    /// [`Single::back`](crate::reverse::single::Single::back).
    pub fn play(&mut self, row: &Row, sums: Option<&[f64]>, to: &mut [State]) {
        let mems = self.mem..self.mem + self.alone.shape.mem;
        let no_force = sums.is_some_and(|sums| sums.last() == Some(&0.0));
        let away = self.idle.is_some_and(|(from, until)| {
            let e = row.x[self.slots[1]] - row.x[self.slots[0]] + self.alone.given[self.alone.shape.e0()];
            e >= from && e <= until
        });
        if no_force || away {
            // then memory is written anew
            for s in to {
                s.mem[mems.clone()].fill(0.0);
                self.tap.into_iter().for_each(|t| s.tap[t] = 0.0);
            }
            return;
        }
        let (given, moving) = (&mut self.alone.given, &mut self.alone.moving);
        let sh = &self.alone.shape;
        let (at_d, at_f, at_mem, at_length) = (sh.d(), sh.f(), sh.memory(), sh.length());
        for (k, slot) in self.slots.iter().enumerate() {
            (given[k], given[at_d + k]) = (row.x[*slot], row.d[*slot]);
            for (q, s) in to.iter().enumerate() {
                (moving[k][q], moving[at_d + k][q]) = (s.x[*slot], s.d[*slot]);
                if sums.is_some() {
                    moving[at_f + k][q] = s.f[*slot];
                }
            }
        }
        if let Some(sums) = sums {
            given[at_f..][..sums.len() - 1].copy_from_slice(&sums[..sums.len() - 1]);
        }
        given[at_mem..][..mems.len()].copy_from_slice(&row.mem[mems.clone()]);
        for (k, at) in mems.clone().enumerate() {
            for (q, s) in to.iter().enumerate() {
                moving[at_mem + k][q] = s.mem[at];
            }
        }
        let follows = || sh.ports.iter().zip(&self.lengths).enumerate().filter(|(_, (p, _))| p.follows);
        for (k, (_, at)) in follows() {
            given[at_length + k] = row.lengths[*at];
            for (q, s) in to.iter().enumerate() {
                // what is not known has no derivative
                moving[at_length + k][q] = if row.lengths[*at] < 0.0 { 0.0 } else { s.lengths[*at] };
            }
        }
        self.alone.carry();
        let (done, sh) = (&self.alone.done, &self.alone.shape);
        for (q, s) in to.iter_mut().enumerate() {
            for (slot, force) in self.slots.iter().zip(done) {
                s.f[*slot] = if sums.is_some() { force[q] } else { s.f[*slot] + force[q] };
            }
            for (at, v) in mems.clone().zip(&done[sh.slots..]) {
                s.mem[at] = v[q];
            }
            for (k, (p, at)) in sh.ports.iter().zip(&self.lengths).enumerate() {
                if p.follows {
                    s.lengths[*at] = done[sh.slots + sh.mem + k][q];
                }
            }
            if let (Some(t), Some(v)) = (self.tap, done.last()) {
                s.tap[t] = v[q];
            }
        }
    }
}
