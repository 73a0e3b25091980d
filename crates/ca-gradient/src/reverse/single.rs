//! Backward pass over links evaluated alone, one tick at a time.

use crate::parts::link_in_scene::Placed;
use crate::parts::record::Row;
use crate::parts::single_link::{LinkAdjoints, Port, SingleLink};
use crate::parts::{Link, number};
use ca_core::internal::op::{MeasureKind, Op};
use ca_core::{Dual, Scene, State};

pub struct Adjoints<'w> {
    /// The backward state: its positions are adjoints of forces, its forces adjoints of positions.
    pub a: &'w mut State,
    /// Adjoints of motions at this tick (slots).
    pub now: &'w mut [f64],
    /// Adjoints of tapped link forces, by tap.
    pub taps: &'w mut [f64],
    pub mem: &'w mut [f64],
    pub lengths: &'w mut [f64],
    pub of_numbers: &'w mut [f64],
    /// Adjoints of the values that port-driven coefficients have at this tick.
    pub driven: &'w mut [f64],
}

pub struct Single {
    link: Placed,
    /// Values read that some parameter changes: index into the values read, and into the numbers.
    numbers: Vec<(usize, usize)>,
    /// Values read that a port drives: index into them, and into [`Parts::driven`](crate::parts::Parts::driven).
    driven: Vec<(usize, usize)>,
    /// Values read whose adjoint is computed: usually, and in ticks where last lengths are not stored.
    wanted: [Vec<usize>; 2],
    /// Buffers for the adjoints of the forces on its ends, its memory and its own force.
    force: Vec<f64>,
    memory: Vec<f64>,
    taps: Vec<f64>,
}

impl Single {
    /// Makes a link of a scene; `place` and `needed` as for [`Adjoint`](super::adjoint::Adjoint).
    pub fn new(
        scene: &Scene,
        link: &Link,
        dual: &Scene<Dual>,
        place: &Scene,
        needed: &impl Fn(f64) -> bool,
        driven: &[usize],
    ) -> Option<Single> {
        let mut link = Placed::new(scene, link, dual, place)?;
        let sh = &link.single.shape;
        let own = sh.own()..sh.coef();
        let used = |k: usize| sh.last || !own.contains(&k);
        let changed = link.numbers.iter().filter(|(k, at)| used(*k) && needed(*at));
        let numbers: Vec<(usize, usize)> = changed.map(|(k, at)| (*k, number(*at))).collect();
        let of_port = |k: usize| Some((sh.coef() + k, driven.binary_search(&link.coefs[k]).ok()?));
        let driven: Vec<(usize, usize)> = (0..sh.coefs).filter_map(of_port).collect();
        // driven coefficients have their adjoints from the port
        let numbers: Vec<(usize, usize)> = numbers.into_iter().filter(|n| driven.iter().all(|d| d.0 != n.0)).collect();
        let known = || numbers.iter().chain(&driven).map(|n| n.0);
        let wanted = [false, true].map(|motions| sh.carried(motions).into_iter().chain(known()).collect());
        if !driven.is_empty() {
            // a driven coefficient may change where the force is 0
            link.idle = None;
        }
        let [force, memory, taps] = [link.slots.len(), link.mem.len(), link.taps.len()].map(|n| vec![0.0; n]);
        Some(Single { link, numbers, driven, wanted, force, memory, taps })
    }

    pub fn slots(&self) -> &[usize] {
        &self.link.slots
    }

    /// Propagates adjoints back over the link in one tick; `sums` as for [`Placed::is_idle`].
    pub fn back(&mut self, row: &Row, sums: Option<&[f64]>, adjoints: &mut Adjoints) {
        for (to, tap) in self.taps.iter_mut().zip(&self.link.taps) {
            *to = tap.map_or(0.0, |t| std::mem::take(&mut adjoints.taps[t]));
        }
        if self.link.is_idle(row, sums) {
            // adjoints of the sums are unchanged, and the memory is overwritten
            self.link.mem.iter().for_each(|m| adjoints.mem[*m] = 0.0);
            return;
        }
        self.force.iter_mut().zip(&self.link.slots).for_each(|(to, slot)| *to = adjoints.a.x[*slot]);
        self.memory.iter_mut().zip(&self.link.mem).for_each(|(to, m)| *to = adjoints.mem[*m]);
        self.link.read(row, sums);
        let Placed { single, slots, mem, lengths: at_lengths, .. } = &mut self.link;
        let (at_d, at_f, at_mem, at_length) =
            (single.shape.d(), single.shape.f(), single.shape.memory(), single.shape.length());
        for (k, at) in &self.driven {
            single.given[*k] = row.driven[*at];
        }
        let (mut motions, mut lengths) = (false, [0.0; 2]);
        for (k, (_, at)) in single.shape.ports.iter().zip(&*at_lengths).enumerate().filter(|(_, (p, _))| p.follows) {
            lengths[k] = adjoints.lengths[*at];
            motions |= row.lengths[*at] < 0.0;
        }
        let adjoint = LinkAdjoints { force: &self.force, tap: &self.taps, memory: &self.memory, lengths };
        single.pull_back(&adjoint, &self.wanted[usize::from(motions)]);
        let (adjoint, sh) = (&single.adjoint, &single.shape);
        if sh.last {
            for (k, slot) in slots.iter().enumerate() {
                adjoints.a.f[*slot] += adjoint[k];
                adjoints.now[*slot] += adjoint[at_d + k];
                adjoints.a.x[*slot] = adjoint[at_f + k];
            }
        } else {
            for p in &sh.ports {
                pull(p, slots, adjoint, motions || !p.follows, at_d, adjoints);
            }
        }
        mem.iter().zip(&adjoint[at_mem..]).for_each(|(m, by)| adjoints.mem[*m] = *by);
        for (k, (p, at)) in sh.ports.iter().zip(&*at_lengths).enumerate() {
            if p.follows {
                adjoints.lengths[*at] = if single.given[at_length + k] < 0.0 { 0.0 } else { adjoint[at_length + k] };
            }
        }
        for (k, at) in &self.numbers {
            adjoints.of_numbers[*at] += adjoint[*k];
        }
        for (k, at) in &self.driven {
            adjoints.driven[*at] += adjoint[*k];
        }
    }
}

/// Adds the adjoints of the second end of a port, and their negatives to the first.
fn pull(p: &Port, slots: &[usize], adjoint: &[f64], motions: bool, at_d: usize, adjoints: &mut Adjoints) {
    for (first, second) in p.slots().zip(p.second()) {
        let (a, b) = (slots[first], slots[second]);
        adjoints.a.f[b] += adjoint[second];
        adjoints.a.f[a] -= adjoint[second];
        if motions {
            adjoints.now[b] += adjoint[at_d + second];
            adjoints.now[a] -= adjoint[at_d + second];
        }
    }
}

/// Links between all pairs of two sets that touch, evaluated one after the other.
pub struct Pairs {
    single: SingleLink,
    /// Index into [`LinkArrays::pair_sets`](ca_core::internal::op::layout::LinkArrays::pair_sets).
    set: usize,
    near: ca_core::internal::numeric::VerletList,
    idle: (f64, f64),
    numbers: Vec<(usize, usize)>,
    /// Indices of the rest positions, where some parameter changes them (any).
    rest: Vec<usize>,
    wanted: Vec<usize>,
}

impl Pairs {
    pub fn new(
        scene: &Scene,
        op: &Op,
        dual: &Scene<Dual>,
        place: &Scene,
        needed: &impl Fn(f64) -> bool,
    ) -> Option<Pairs> {
        let set = op.ports.pair_set?;
        // pairs do not store a last distance: they are measured anew in each tick
        let one = Op { form: ca_core::internal::op::Form { measure: MeasureKind::Radial, ..op.form }, ..*op };
        let mut single = SingleLink::new(&one, dual)?;
        let sh = &single.shape;
        let coefs = sh.coef()..sh.coef() + sh.coefs;
        single.given[coefs.clone()].copy_from_slice(&scene.initial.coef[op.coef..][..coefs.len()]);
        let idle = (op.law?.fns.idle)(&single.given[coefs.clone()]);
        let at = |k: usize| place.initial.coef[op.coef + k];
        let numbers: Vec<(usize, usize)> =
            (0..coefs.len()).filter(|k| needed(at(*k))).map(|k| (coefs.start + k, number(at(k)))).collect();
        let pairs = &scene.layout.links.pair_sets[set];
        let moves =
            pairs.members.iter().flat_map(|m| &place.layout.places.rest[*m as usize..][..3]).any(|v| needed(*v));
        let rest = if moves { place.layout.places.rest.iter().map(|v| number(*v)).collect() } else { Vec::new() };
        let reach = if moves { sh.reach()..sh.reach() + 3 } else { 0..0 };
        let wanted = sh.carried(true).into_iter().chain(numbers.iter().map(|n| n.0)).chain(reach).collect();
        let near = ca_core::internal::numeric::VerletList::new(pairs.members.len(), pairs.rows, pairs.columns);
        Some(Pairs { single, set, near, idle, numbers, rest, wanted })
    }

    /// Propagates adjoints back over all pairs that touch.
    pub fn back(&mut self, scene: &Scene, row: &Row, adjoints: &mut Adjoints) {
        let (set, rest) = (&scene.layout.links.pair_sets[self.set], &scene.layout.places.rest);
        let three = |v: &[f64], m: u32| [v[m as usize], v[m as usize + 1], v[m as usize + 2]];
        let square = |[x, y, z]: [f64; 3]| x * x + y * y + z * z;
        let (from, to) = (self.idle.0.max(0.0), self.idle.1.max(0.0));
        let radius = if self.idle.1 < f64::INFINITY { f64::INFINITY } else { from };
        self.near.place(|k| [three(rest, set.members[k]), three(row.x, set.members[k])]);
        self.near.renew(radius, |k| square(three(row.d, set.members[k])));
        let sh = &self.single.shape;
        let (at_d, at_reach) = (sh.d(), sh.reach());
        let (single, numbers, rests, wanted) = (&mut self.single, &self.numbers, &self.rest, &self.wanted);
        self.near.each(radius, |i, j| {
            let ends = [set.members[i], set.members[j]];
            let [p, q] = ends.map(|m| three(rest, m));
            let reach = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
            let [a, b] = ends.map(|m| three(row.x, m));
            let l = square([0, 1, 2].map(|k| reach[k] + (b[k] - a[k])));
            if l >= from * from && l <= to * to {
                return;
            }
            let [a, b] = ends.map(|m| m as usize);
            let slots = [a, a + 1, a + 2, b, b + 1, b + 2];
            for (k, slot) in slots.into_iter().enumerate() {
                (single.given[k], single.given[at_d + k]) = (row.x[slot], row.d[slot]);
            }
            single.given[at_reach..][..3].copy_from_slice(&reach);
            let force = slots.map(|slot| adjoints.a.x[slot]);
            single.pull_back(&LinkAdjoints { force: &force, tap: &[], memory: &[], lengths: [0.0; 2] }, wanted);
            pull(&single.shape.ports[0], &slots, &single.adjoint, true, at_d, adjoints);
            for (k, at) in numbers {
                adjoints.of_numbers[*at] += single.adjoint[*k];
            }
            if !rests.is_empty() {
                for k in 0..3 {
                    adjoints.of_numbers[rests[b + k]] += single.adjoint[at_reach + k];
                    adjoints.of_numbers[rests[a + k]] -= single.adjoint[at_reach + k];
                }
            }
        });
    }

    pub fn slots<'a>(&self, scene: &'a Scene) -> impl Iterator<Item = usize> + 'a {
        scene.layout.links.pair_sets[self.set].members.iter().flat_map(|m| *m as usize..*m as usize + 3)
    }
}
