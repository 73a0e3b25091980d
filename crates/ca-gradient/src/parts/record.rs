//! Record of a stretch of ticks: the numbers from which their derivatives are computed.

use crate::parts::{Link, Parts};
use ca_core::internal::numeric::Aligned;
use ca_core::internal::op::Op;
use ca_core::internal::op::layout::Tap;
use ca_core::{Scene, State};
use std::ops::Range;

/// State at the beginning of a tick, after its ports were read.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    /// Positions and motions (slots).
    pub x: &'a [f64],
    pub d: &'a [f64],
    pub mem: &'a [f64],
    pub lengths: &'a [f64],
    /// For each link of [`Parts::last`]: the sum of forces on its ends, then the size of what it adds (any).
    pub sums: &'a [f64],
    /// Forces read by outputs, as [`Parts::force_taps`].
    pub output_forces: &'a [f64],
    /// Nodes and weights under each moving point (points x 8).
    pub cells: &'a [f64],
    /// Coefficients driven by ports, as [`Parts::driven`].
    pub driven: &'a [f64],
    /// Forces on masses that go by their modes, as [`Places::modal`](ca_core::internal::op::layout::Places::modal).
    pub modal: &'a [f64],
    /// Last input and output of each high pass, where some parameter changes one (any x 2).
    pub passed: &'a [f64],
}

/// Rounds up to whole cache lines; otherwise each vector of the next array is read from two lines.
pub fn whole_lines(n: usize) -> usize {
    n.next_multiple_of(8)
}

/// Rows of consecutive ticks, and the positions and motions after the last.
pub struct Record {
    /// Ranges within a row, in the order of [`Row`].
    kinds: [Range<usize>; 10],
    /// Numbers per row.
    width: usize,
    all: Aligned,
    writes: bool,
}

impl Record {
    /// Allocates rows for `ticks` ticks. Outputs are computed if their `filters` are stored or `outputs` is set.
    pub fn new(scene: &Scene, parts: &Parts, ticks: usize, [filters, outputs]: [bool; 2]) -> Record {
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
            parts.force_taps.len(),
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
        Record { kinds, width, all: Aligned::zeros((ticks + 1) * width), writes: filters || outputs }
    }

    pub fn row(&self, k: usize) -> Row<'_> {
        let row = &self.all[k * self.width..][..self.width];
        let [x, d, mem, lengths, sums, output_forces, cells, driven, modal, passed] = &self.kinds;
        let of = |kind: &Range<usize>| &row[kind.start..kind.end];
        Row {
            x: of(x),
            d: of(d),
            mem: of(mem),
            lengths: of(lengths),
            sums: of(sums),
            output_forces: of(output_forces),
            cells: of(cells),
            driven: of(driven),
            modal: of(modal),
            passed: of(passed),
        }
    }

    /// Motions at the beginning of tick `k`; the row after the last tick has those at its end.
    pub fn motions(&self, k: usize) -> &[f64] {
        &self.all[k * self.width..][self.kinds[1].clone()]
    }

    /// Rows of `n` ticks from `k`, the numbers per row, and the offset of motions; positions are first.
    pub fn rows(&self, k: usize, n: usize) -> (&[f64], usize, usize) {
        (&self.all[k * self.width..][..n * self.width], self.width, self.kinds[1].start)
    }

    /// Plays a stretch on from `s` with the inputs `given` (ticks x inputs); `on_outputs` receives computed outputs. This is
    /// not a `ca_io::player::Player`, since it stores numbers between the passes of a tick.
    pub fn play(
        &mut self,
        scene: &Scene,
        parts: &Parts,
        s: &mut State,
        given: &[f64],
        ticks: usize,
        mut on_outputs: impl FnMut(usize, &[f64]),
    ) {
        let run = |list: &[Op], s: &mut State| {
            for op in list {
                (op.kernel)(op, &scene.layout, s);
            }
        };
        let last = parts.last.first().map_or(scene.passes.summed().len(), Link::op);
        let (before, behind) = scene.passes.summed().split_at(last);
        let output_links = scene.passes.writes.iter().find(|op| op.name() == "heard links");
        let inputs = scene.inputs.len();
        let [x, d, mem, lengths, sums, forces_at, cells, driven, modal, passed] = self.kinds.clone();
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
            if !forces_at.is_empty() {
                if let Some(op) = output_links {
                    (op.kernel)(op, &scene.layout, s);
                }
                for (to, tap) in row[forces_at.clone()].iter_mut().zip(&parts.force_taps) {
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
                on_outputs(k, &s.output);
            }
            run(&scene.passes.moves, s);
            s.tick += 1;
        }
        let row = &mut self.all[ticks * self.width..][..self.width];
        row[x].copy_from_slice(&s.x);
        row[d].copy_from_slice(&s.d);
    }
}
