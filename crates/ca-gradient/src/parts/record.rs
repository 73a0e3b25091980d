//! Record: a stretch of ticks, played once more for the way back.

use crate::parts::{Link, Parts};
use ca_core::internal::numeric::Aligned;
use ca_core::internal::op::Op;
use ca_core::internal::op::layout::Tap;
use ca_core::{Scene, State};
use std::ops::Range;

/// What a tick began with, after its ports were read.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    /// places and motions (slots)
    pub x: &'a [f64],
    pub d: &'a [f64],
    /// memory of laws
    pub mem: &'a [f64],
    /// last lengths
    pub lengths: &'a [f64],
    /// for each link that goes by the sum of the forces, that on its ends, and how much the link adds (any)
    pub sums: &'a [f64],
    /// what outputs hear of forces, as [`Parts::hears`]
    pub heard: &'a [f64],
    /// nodes and weights under each moving point (points x 8)
    pub cells: &'a [f64],
    /// coefficients that ports drive, as [`Parts::driven`]
    pub driven: &'a [f64],
    /// forces on masses that go by modes, as [`Places::modal`](ca_core::internal::op::layout::Places::modal)
    pub modal: &'a [f64],
    /// what high passes heard last and gave, where some parameter changes them (any x 2)
    pub passed: &'a [f64],
}

/// So many numbers that what comes behind them begins at a cache line too: else each vector is read from two.
pub fn whole_lines(n: usize) -> usize {
    n.next_multiple_of(8)
}

/// So many ticks one after the other, and the places and motions behind the last.
pub struct Record {
    /// where the numbers of each kind stand in those of a tick, in the order of [`Row`]
    kinds: [Range<usize>; 10],
    /// numbers of a tick
    width: usize,
    all: Aligned,
    /// outputs are played too
    writes: bool,
}

impl Record {
    /// Room for so many ticks of a scene; with what its `filters` hold. Outputs are played where these are, or where they are `heard`.
    pub fn new(scene: &Scene, parts: &Parts, ticks: usize, [filters, heard]: [bool; 2]) -> Record {
        let (l, start) = (&scene.layout, &scene.initial);
        let remembers = !parts.links.is_empty() || !parts.last.is_empty();
        let (mem, lengths) = if remembers { (start.links.mem.len(), start.links.lengths.len()) } else { (0, 0) };
        let sums = parts.last.iter().map(|l| l.slots.len() + 1).sum();
        let passed = if filters { 2 * l.out.blockers.len() } else { 0 };
        let (cells, driven) = (8 * l.places.moving_points.len(), parts.driven.len());
        let mut width = 0;
        let kinds = [
            l.counts.n_mat,
            l.counts.n_mat,
            mem,
            lengths,
            sums,
            parts.hears.len(),
            cells,
            driven,
            l.places.modal.len(),
            passed,
        ]
        .map(|n| {
            let first = width;
            width += whole_lines(n);
            first..first + n
        });
        Record { kinds, width, all: Aligned::zeros((ticks + 1) * width), writes: filters || heard }
    }

    /// What tick `k` of the stretch began with.
    pub fn row(&self, k: usize) -> Row<'_> {
        let row = &self.all[k * self.width..][..self.width];
        let [x, d, mem, lengths, sums, heard, cells, driven, modal, passed] = &self.kinds;
        let of = |kind: &Range<usize>| &row[kind.start..kind.end];
        Row {
            x: of(x),
            d: of(d),
            mem: of(mem),
            lengths: of(lengths),
            sums: of(sums),
            heard: of(heard),
            cells: of(cells),
            driven: of(driven),
            modal: of(modal),
            passed: of(passed),
        }
    }

    /// The motions that tick `k` began with; behind the last those that it made.
    pub fn motions(&self, k: usize) -> &[f64] {
        &self.all[k * self.width..][self.kinds[1].clone()]
    }

    /// All numbers of `n` ticks from `k` on, how many a tick has, and where its motions stand; its places come first.
    pub fn rows(&self, k: usize, n: usize) -> (&[f64], usize, usize) {
        (&self.all[k * self.width..][..n * self.width], self.width, self.kinds[1].start)
    }

    /// No `ca_io::player::Player`: numbers are kept between the passes of a tick.
    /// Plays a stretch on from `s`; `given` is what the ports get (ticks x inputs). Each tick is heard by `hears`, if outputs are played.
    pub fn play(
        &mut self,
        scene: &Scene,
        parts: &Parts,
        s: &mut State,
        given: &[f64],
        ticks: usize,
        mut hears: impl FnMut(usize, &[f64]),
    ) {
        let run = |list: &[Op], s: &mut State| {
            for op in list {
                (op.kernel)(op, &scene.layout, s);
            }
        };
        let last = parts.last.first().map_or(scene.passes.summed().len(), Link::op);
        let (before, behind) = scene.passes.summed().split_at(last);
        let heard = scene.passes.writes.iter().find(|op| op.name() == "heard links");
        let inputs = scene.inputs.len();
        let [x, d, mem, lengths, sums, heard_forces, cells, driven, modal, passed] = self.kinds.clone();
        for k in 0..ticks {
            s.input.copy_from_slice(&given[k * inputs..][..inputs]);
            run(&scene.passes.reads, s);
            let row = &mut self.all[k * self.width..][..self.width];
            row[x.clone()].copy_from_slice(&s.x);
            row[d.clone()].copy_from_slice(&s.d);
            row[mem.clone()].copy_from_slice(&s.links.mem[..mem.len()]);
            row[lengths.clone()].copy_from_slice(&s.links.lengths[..lengths.len()]);
            for (to, c) in row[driven.clone()].iter_mut().zip(&parts.driven) {
                *to = s.coef[*c];
            }
            for (to, c) in row[cells.clone()].chunks_exact_mut(8).zip(&s.links.cells) {
                for q in 0..4 {
                    (to[q], to[4 + q]) = (f64::from(c.node[q]), if q < c.n { c.weight[q] } else { 0.0 });
                }
            }
            run(before, s);
            let row = &mut self.all[k * self.width..][..self.width];
            let sums = &mut row[sums.clone()];
            let mut at = 0;
            for l in &parts.last {
                for slot in &l.slots {
                    sums[at] = s.f[*slot];
                    at += 1;
                }
                at += 1;
            }
            run(behind, s);
            at = 0;
            for l in &parts.last {
                let added =
                    l.slots.iter().zip(&sums[at..]).fold(0.0, |most: f64, (m, f)| most.max((s.f[*m] - f).abs()));
                at += l.slots.len();
                sums[at] = added;
                at += 1;
            }
            if !heard_forces.is_empty() {
                if let Some(op) = heard {
                    (op.kernel)(op, &scene.layout, s);
                }
                for (to, tap) in row[heard_forces.clone()].iter_mut().zip(&parts.hears) {
                    *to = match tap {
                        Tap::Position(m) => s.x[*m as usize],
                        Tap::ForceOn(m) => s.f[*m as usize],
                        Tap::ForceOf(t) => s.links.tap[*t as usize],
                    };
                }
            }
            for (to, p) in row[modal.clone()].iter_mut().zip(&scene.layout.places.modal) {
                *to = s.f[p.mat as usize];
            }
            if !passed.is_empty() {
                row[passed.clone()].copy_from_slice(s.ports.blocked.as_flattened());
            }
            if self.writes {
                run(&scene.passes.writes, s);
                hears(k, &s.output);
            }
            run(&scene.passes.moves, s);
            s.tick += 1;
        }
        let row = &mut self.all[ticks * self.width..][..self.width];
        row[x].copy_from_slice(&s.x);
        row[d].copy_from_slice(&s.d);
    }
}
