//! Link evaluated alone, with its derivatives by everything it reads.
//!
//! A link reads only a few numbers of the state. Its derivatives by each of them are computed for several ticks
//! beforehand, so that the derivatives by one parameter can be played over all these ticks without the others.

use crate::parts::link_in_scene::Placed;
use crate::parts::record::Row;
use crate::parts::single_link::Port;
use crate::parts::{Link, number};
use ca_core::{Dual, Scene, State, TANGENTS};

/// Number of the state that a link reads; the second slot is subtracted where only the difference of two ends counts.
enum Read {
    Place(usize, Option<usize>),
    Motion(usize, Option<usize>),
    Force(usize),
    Memory(usize),
    Length(usize),
}

enum Write {
    Force(usize),
    Memory(usize),
    Length(usize),
    Tap(usize),
}

pub struct Moving {
    link: Placed,
    /// Values read: index into the values given to [`SingleLink`](crate::parts::single_link::SingleLink), and source in the state.
    reads: Vec<(usize, Read)>,
    /// Values written: index into the results, and destination in the state.
    writes: Vec<(usize, Write)>,
    /// Numbers that a parameter changes: index into the values read, and derivatives.
    numbers: Vec<(usize, [f64; TANGENTS])>,
    /// For each tick, whether it gives no force.
    idle: Vec<bool>,
    /// Derivatives of the values written by those read (ticks x writes x reads), and by parameters (ticks x writes).
    by: Vec<f64>,
    own: Vec<[f64; TANGENTS]>,
    /// Buffer for the derivatives of the values read (reads).
    scratch: Vec<f64>,
}

impl Moving {
    /// Makes a link, for `ticks` ticks at a time; the other arguments as for [`Added`](super::added::Added).
    pub fn new(
        scene: &Scene,
        link: &Link,
        dual: &Scene<Dual>,
        place: &Scene,
        columns: &[&[f64]],
        ticks: usize,
    ) -> Option<Moving> {
        let link = Placed::new(scene, link, dual, place)?;
        let (sh, slots) = (&link.single.shape, &link.slots);
        let (mut reads, mut writes) = (Vec::new(), Vec::new());
        let places = |p: Port| p.second().map(move |k| (k, Some(slots[k - p.axes])));
        let all = (0..sh.slots).map(|k| (k, None));
        let read: Vec<_> = if sh.last { all.collect() } else { sh.ports.iter().copied().flat_map(places).collect() };
        for (k, less) in read {
            reads.push((k, Read::Place(slots[k], less)));
            reads.push((sh.d() + k, Read::Motion(slots[k], less)));
        }
        for (k, slot) in slots.iter().enumerate() {
            if sh.last {
                reads.push((sh.f() + k, Read::Force(*slot)));
            }
            writes.push((k, Write::Force(*slot)));
        }
        for (k, at) in link.mem.iter().enumerate() {
            reads.push((sh.memory() + k, Read::Memory(*at)));
            writes.push((sh.slots + k, Write::Memory(*at)));
        }
        for (k, (_, at)) in sh.ports.iter().zip(&link.lengths).enumerate().filter(|(_, (p, _))| p.follows) {
            reads.push((sh.length() + k, Read::Length(*at)));
            writes.push((sh.slots + sh.mem + k, Write::Length(*at)));
        }
        let tapped = link.taps.iter().enumerate().filter_map(|(k, tap)| Some((k, (*tap)?)));
        writes.extend(tapped.map(|(k, t)| (sh.slots + sh.mem + sh.ports.len() + k, Write::Tap(t))));
        let changed = |(k, at): &(usize, f64)| {
            let mut by = [0.0; TANGENTS];
            by.iter_mut().zip(columns).for_each(|(to, column)| *to = column[number(*at)]);
            by.iter().any(|v| *v != 0.0).then_some((*k, by))
        };
        let numbers: Vec<_> = link.numbers.iter().filter_map(changed).collect();
        let all = ticks * writes.len();
        Some(Moving {
            idle: vec![false; ticks],
            by: vec![0.0; all * reads.len()],
            own: vec![[0.0; TANGENTS]; all],
            scratch: vec![0.0; reads.len()],
            link,
            reads,
            writes,
            numbers,
        })
    }

    pub fn slots(&self) -> usize {
        self.link.slots.len()
    }

    /// Computes its derivatives in the stored tick `k`, which began with `row`; `sums` as for [`Placed::is_idle`].
    pub fn measure(&mut self, k: usize, row: &Row, sums: Option<&[f64]>) {
        self.idle[k] = self.link.is_idle(row, sums);
        if self.idle[k] {
            return;
        }
        self.link.read(row, sums);
        let (single, reads, writes) = (&mut self.link.single, &self.reads, &self.writes);
        let by = &mut self.by[k * writes.len() * reads.len()..];
        for (chunk, some) in reads.chunks(TANGENTS).enumerate() {
            for (lane, (at, read)) in some.iter().enumerate() {
                // the derivative of a length that is not known is 0
                let known = !matches!(read, Read::Length(at) if row.lengths[*at] < 0.0);
                single.moving[*at][lane] = f64::from(u8::from(known));
            }
            single.carry();
            for (lane, (at, _)) in some.iter().enumerate() {
                single.moving[*at][lane] = 0.0;
                for ((from, _), by) in writes.iter().zip(by.chunks_exact_mut(reads.len())) {
                    by[chunk * TANGENTS + lane] = single.done[*from][lane];
                }
            }
        }
        if !self.numbers.is_empty() {
            self.numbers.iter().for_each(|(at, by)| single.moving[*at] = *by);
            single.carry();
            self.numbers.iter().for_each(|(at, _)| single.moving[*at].fill(0.0));
            for ((from, _), own) in writes.iter().zip(&mut self.own[k * writes.len()..]) {
                *own = single.done[*from];
            }
        }
    }

    /// Adds its derivatives by parameter `q` in tick `k` to the state.
    pub fn add(&mut self, k: usize, q: usize, s: &mut State) {
        if self.idle[k] {
            // an idle link overwrites its memory
            self.link.mem.iter().for_each(|m| s.links.mem[*m] = 0.0);
            self.link.taps.iter().flatten().for_each(|t| s.links.tap[*t] = 0.0);
            return;
        }
        for (to, (_, read)) in self.scratch.iter_mut().zip(&self.reads) {
            let less = |all: &[f64], at: &Option<usize>| at.map_or(0.0, |at| all[at]);
            *to = match read {
                Read::Place(at, first) => s.x[*at] - less(&s.x, first),
                Read::Motion(at, first) => s.d[*at] - less(&s.d, first),
                Read::Force(at) => s.f[*at],
                Read::Memory(at) => s.links.mem[*at],
                Read::Length(at) => s.links.lengths[*at],
            };
        }
        let (n, last) = (self.writes.len(), self.link.single.shape.last);
        let by = self.by[k * n * self.scratch.len()..].chunks_exact(self.scratch.len());
        for (((_, write), own), by) in self.writes.iter().zip(&self.own[k * n..]).zip(by) {
            let v = by.iter().zip(&self.scratch).fold(own[q], |sum, (by, v)| sum + by * v);
            match write {
                Write::Force(at) if last => s.f[*at] = v,
                Write::Force(at) => s.f[*at] += v,
                Write::Memory(at) => s.links.mem[*at] = v,
                Write::Length(at) => s.links.lengths[*at] = v,
                Write::Tap(at) => s.links.tap[*at] = v,
            }
        }
    }
}
