//! Link: one that is run alone, with the derivatives of all that it reads.

use crate::parts::placed::Placed;
use crate::parts::record::Row;
use crate::parts::{Link, number};
use ca_core::{Scene, State};

/// A link that is run alone.
pub struct Moving(Placed);

impl Moving {
    /// A link of a scene; the rest as for [`Added`](super::added::Added).
    pub fn new(
        scene: &Scene,
        link: &Link,
        dual: &ca_core_dual::Scene,
        place: &Scene,
        columns: &[&[f64]],
    ) -> Option<Moving> {
        let mut link = Placed::new(scene, link, dual, place)?;
        for (k, at) in &link.numbers {
            for (to, column) in link.alone.moving[*k].iter_mut().zip(columns) {
                *to = column[number(*at)];
            }
        }
        Some(Moving(link))
    }

    /// How many slots its ends have.
    pub fn slots(&self) -> usize {
        self.0.slots.len()
    }

    /// The link in one tick, which began with `row`, and its derivatives, added to those of all else, `to`; `sums` as for
    /// [`Placed::is_idle`].
    pub fn play(&mut self, row: &Row, sums: Option<&[f64]>, to: &mut [State]) {
        if self.0.is_idle(row, sums) {
            // then memory is written anew
            for s in to {
                s.mem[self.0.mem.clone()].fill(0.0);
                self.0.tap.into_iter().for_each(|t| s.tap[t] = 0.0);
            }
            return;
        }
        self.0.read(row, sums);
        let Placed { alone, slots, mem, lengths, tap, .. } = &mut self.0;
        let (moving, sh) = (&mut alone.moving, &alone.shape);
        let (at_d, at_f, at_mem, at_length) = (sh.d(), sh.f(), sh.memory(), sh.length());
        for (q, s) in to.iter().enumerate() {
            for (k, slot) in slots.iter().enumerate() {
                (moving[k][q], moving[at_d + k][q]) = (s.x[*slot], s.d[*slot]);
                if sums.is_some() {
                    moving[at_f + k][q] = s.f[*slot];
                }
            }
            for (k, at) in mem.clone().enumerate() {
                moving[at_mem + k][q] = s.mem[at];
            }
            for (k, (_, at)) in sh.ports.iter().zip(&*lengths).enumerate().filter(|(_, (p, _))| p.follows) {
                // what is not known has no derivative
                moving[at_length + k][q] = if row.lengths[*at] < 0.0 { 0.0 } else { s.lengths[*at] };
            }
        }
        alone.carry();
        let (done, sh) = (&alone.done, &alone.shape);
        for (q, s) in to.iter_mut().enumerate() {
            for (slot, force) in slots.iter().zip(done) {
                s.f[*slot] = if sums.is_some() { force[q] } else { s.f[*slot] + force[q] };
            }
            for (at, v) in mem.clone().zip(&done[sh.slots..]) {
                s.mem[at] = v[q];
            }
            for (k, (_, at)) in sh.ports.iter().zip(&*lengths).enumerate().filter(|(_, (p, _))| p.follows) {
                s.lengths[*at] = done[sh.slots + sh.mem + k][q];
            }
            if let (Some(t), Some(v)) = (*tap, done.last()) {
                s.tap[t] = v[q];
            }
        }
    }
}
