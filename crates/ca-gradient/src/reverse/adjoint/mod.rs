//! Plays a scene backwards, one tick at a time.
//!
//! A tick of linear links and masses on a line is d' = P d + Q x + C (f − K x − Z d), x' = x + d', with K and Z
//! symmetric. The adjoint of d', times C, obeys the same equation from the last tick to the first, where f holds the
//! adjoints of positions. So the scene without its constant forces plays it: the same passes, the same layout, as fast.
//! Links evaluated alone add to f as they do forwards. The adjoint of a motion d = x − x₋ is added to the adjoint of x
//! and subtracted from the adjoint of x₋, the position one tick before.
//!
//! In the backward state, x is ν = C times the adjoint of d', and d is its change; both are 0 where no force moves a
//! slot. The adjoint of the sum of the forces on a slot is ν, except where an output or a link reads that sum
//! ([`Parts::summed`]): there it grows while links are evaluated.

mod end;

use crate::error::Error;
use crate::parts::record::{Record, Row, whole_lines};
use crate::parts::rows::Rows;
use crate::parts::small_passes::Small;
use crate::parts::{Basis, Link, Parts, number, unknown};
use crate::reverse::outputs::{OutputAdjoint, Outputs};
use crate::reverse::single::{Adjoints, Pairs, Single};
use crate::reverse::sums::{Links, Masses, Seen, TICKS, Ticks};
use crate::reverse::tapped_links::TappedLink;
use ca_core::internal::numeric::Aligned;
use ca_core::internal::op::Op;
use ca_core::internal::op::layout::Layout;
use ca_core::{Dual, Scene, State};

pub struct Adjoint<'a> {
    scene: &'a Scene,
    parts: &'a Parts,
    /// Layout without constant elongations.
    layout: Layout,
    a: State,
    /// Passes with few links or masses, other passes of linear links, and other passes of motion.
    small: Small,
    linear: Vec<&'a Op>,
    moves: Vec<&'a Op>,
    pub outputs: Outputs,
    links: Vec<Single>,
    sets: Vec<Pairs>,
    last: Vec<Single>,
    tapped: Vec<TappedLink>,
    /// Adjoints of tapped link forces, by tap.
    taps: Vec<f64>,
    /// Sums of linear links: listed ones, and rows.
    listed: Vec<Links>,
    rows: Vec<Links>,
    masses: Masses,
    /// Adjoints of forces in the `unsummed` ticks, in order of time and filled from the end (any x slots).
    nu: Aligned,
    /// The same for listed links, where sums of forces are read and their adjoints grow.
    more: Aligned,
    unsummed: usize,
    /// Adjoints of motions at this tick and at the next.
    motion: [Vec<f64>; 2],
    /// Slots whose motion may have an adjoint.
    moved: Vec<usize>,
    /// Adjoints of the sums of forces at the next tick, as [`Parts::summed`].
    sums: Vec<f64>,
    /// Position and motion of the backward state at these slots, restored after the links.
    before: Vec<[f64; 2]>,
    mem: Vec<f64>,
    lengths: Vec<f64>,
    /// Adjoints of motions at the first tick.
    first: Vec<f64>,
    /// The scene with each number replaced by its index.
    place: &'a Scene,
    pub of_numbers: Vec<f64>,
    /// Adjoints of the values that port-driven coefficients have at the current tick.
    pub driven: Vec<f64>,
    /// Adjoints of inputs at the current tick, for a device as if it sent a value in each tick.
    pub inputs: Vec<f64>,
}

impl<'a> Adjoint<'a> {
    /// Begins after the last tick. `place` is the scene with each number replaced by its index; `needed` marks the
    /// numbers that some parameter changes.
    pub fn new(
        scene: &'a Scene,
        parts: &'a Parts,
        dual: &Scene<Dual>,
        place: &'a Scene,
        needed: &[bool],
    ) -> Result<Adjoint<'a>, Error> {
        let mut layout = scene.layout.clone();
        layout.links.e0.fill(0.0);
        let mut a = scene.state();
        for all in [&mut a.x, &mut a.d, &mut a.f] {
            all.fill(0.0);
        }
        let is_needed = |v: f64| needed[number(v)];
        let (coef, e0) = (&place.initial.coef, &place.layout.links.e0);
        let needs = |of: &Rows, k: usize| coef[of.coef + k * of.n..][..of.n].iter().any(|v| is_needed(*v));
        let wanted = |of: Rows| {
            let elongations = e0[of.first..][..of.n].iter().any(|v| is_needed(*v));
            let coefficients: Vec<bool> = (0..of.basis.0.len()).map(|k| needs(&of, k)).collect();
            Links::for_changes(of, &coefficients, elongations)
        };
        let listed = |(k, basis): &(usize, Basis)| wanted(Rows::listed(scene, &scene.passes.forces[*k], basis));
        let solved = |k: &usize| {
            wanted(Rows::listed(scene, &scene.passes.forces[*k], &Basis::implicit())).map(Links::for_implicit)
        };
        let of_row = |(k, basis): &(usize, Basis)| Rows::integrated(&scene.passes.moves[*k], basis);
        let n = scene.layout.counts.n_mat;
        let own = [0, 1, 2].map(|k| coef[k * n..][..n].iter().any(|v| is_needed(*v)));
        let no = |op: usize| unknown(&scene.passes.forces[op]);
        let single =
            |link: &Link| Single::new(scene, link, dual, place, &is_needed, &parts.driven).ok_or_else(|| no(link.op()));
        let pairs =
            |k: &usize| Pairs::new(scene, &scene.passes.forces[*k], dual, place, &is_needed).ok_or_else(|| no(*k));
        let singles = |all: &[Link]| all.iter().map(single).collect::<Result<Vec<_>, _>>();
        let outputs = Outputs::of(scene);
        let (small, mut linear, mut moves) = Small::of(scene, parts);
        linear.extend(parts.implicit.iter().map(|k| &scene.passes.forces[*k]));
        moves.retain(|op| op.name() != "flush");
        let mut adjoint = Adjoint {
            links: singles(&parts.links)?,
            last: singles(&parts.last)?,
            sets: parts.sets.iter().map(pairs).collect::<Result<_, _>>()?,
            listed: parts.linear.iter().filter_map(listed).chain(parts.implicit.iter().filter_map(solved)).collect(),
            rows: parts.rows.iter().flat_map(of_row).filter_map(wanted).collect(),
            masses: Masses::new(n, own, scene.initial.coef[n..2 * n].iter().any(|q| *q != 0.0)),
            nu: Aligned::zeros(0),
            more: Aligned::zeros(0),
            unsummed: 0,
            motion: [vec![0.0; n], vec![0.0; n]],
            moved: Vec::new(),
            sums: vec![0.0; parts.summed.len()],
            before: Vec::new(),
            mem: vec![0.0; scene.initial.links.mem.len()],
            lengths: vec![0.0; scene.initial.links.lengths.len()],
            first: vec![0.0; n],
            of_numbers: vec![0.0; needed.len()],
            inputs: vec![0.0; scene.inputs.len()],
            driven: vec![0.0; parts.driven.len()],
            taps: vec![0.0; scene.layout.counts.n_tap],
            tapped: TappedLink::all(scene, parts, place),
            layout,
            a,
            small,
            linear,
            moves,
            outputs,
            scene,
            parts,
            place,
        };
        adjoint.moved = adjoint.motions();
        let scratch = |wanted: bool| Aligned::zeros(if wanted { TICKS * whole_lines(n) } else { 0 });
        let own = !adjoint.rows.is_empty() || !adjoint.masses.is_idle();
        let differs = !parts.summed.is_empty() || !scene.layout.places.moving_points.is_empty();
        adjoint.more = scratch(differs && !adjoint.listed.is_empty());
        adjoint.nu = scratch(own || (!differs && !adjoint.listed.is_empty()));
        Ok(adjoint)
    }

    fn motions(&self) -> Vec<usize> {
        let l = &self.scene.layout;
        let output_slots = l.out.outputs.iter().filter_map(|o| match o.tap {
            ca_core::internal::op::layout::Tap::Position(m) => Some(m as usize),
            _ => None,
        });
        let links = self.links.iter().chain(&self.last).flat_map(|s| s.slots().iter().copied());
        let sets = self.sets.iter().flat_map(|s| s.slots(self.scene));
        let nodes = l.places.nodes.iter().map(|m| *m as usize);
        let mut all: Vec<usize> =
            output_slots.chain(links).chain(sets).chain(nodes).chain(self.tapped.iter().flat_map(|h| h.ends)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Returns whether the ticks have to be summed before the next one.
    pub fn is_full(&self) -> bool {
        self.unsummed == TICKS
    }

    /// Sums the ticks that are not summed yet; the last of them is tick `k` of the stretch.
    pub fn sum(&mut self, record: &Record, k: usize) {
        let (n, ticks) = (whole_lines(self.a.x.len()), self.unsummed);
        let more = if self.more.is_empty() { &self.nu } else { &self.more };
        let e0 = &self.scene.layout.links.e0[..];
        for (all, links, masses) in [(more, &mut self.listed, None), (&self.nu, &mut self.rows, Some(&mut self.masses))]
        {
            // adjoints are filled from the end, since the last tick came first
            let adjoint = all.get((TICKS - ticks) * n..).unwrap_or_default();
            let (rows, width, d) = record.rows(k, ticks + 1);
            let seen = Seen { rows, width, d, adjoint, slots: n.max(1) };
            Ticks { links, masses: masses.filter(|m| !m.is_idle()), seen, e0 }.add();
        }
        self.unsummed = 0;
    }

    /// Goes back over tick `tick`, which began with `row`; `adjoint` holds the adjoints of its samples (outputs).
    pub fn back(&mut self, tick: usize, row: Row, adjoint: &[f64]) {
        let (a, of_numbers, place) = (&mut self.a, &mut self.of_numbers, self.place);
        let [now, late] = &mut self.motion;
        // the adjoint of a force on a modal mass, or a moving point, is a weighted sum over its modes or nodes
        if let Some([read, _]) = self.parts.modal {
            let op = &self.scene.passes.reads[read];
            (op.kernel)(op, &self.layout, a);
        }
        let points = &self.scene.layout.places.moving_points;
        let cells = || points.iter().map(|p| p.mat as usize).zip(row.cells.chunks_exact(8));
        // the adjoint of a point is summed below
        cells().for_each(|(m, _)| a.x[m] = 0.0);
        // outputs
        let (taps, summed) = (&mut self.taps, &self.parts.summed);
        self.before.clear();
        self.before.extend(summed.iter().map(|m| [a.x[*m], a.d[*m]]));
        let gains = |at: usize, v: f64| of_numbers[number(place.initial.coef[at])] += v;
        let (x, f, mut high_passes) = (&mut a.x, &mut a.f, Vec::new());
        let to = |adjoint: OutputAdjoint| match adjoint {
            OutputAdjoint::Place(m, v) => f[m] += v,
            OutputAdjoint::Motion(m, v) => now[m] += v,
            OutputAdjoint::Sum(m, v) => x[m] += v,
            OutputAdjoint::Force(t, v) => taps[t] += v,
            OutputAdjoint::HighPass(k, by) => high_passes.push((k, by)),
        };
        self.outputs.back(tick, adjoint, &row, to, gains);
        for (k, [r, g]) in high_passes {
            of_numbers[number(place.layout.out.blockers[k].r)] += r;
            of_numbers[number(place.layout.out.blockers[k].g)] += g;
        }
        self.driven.fill(0.0);
        // links that depend on sums of forces first: they add to the adjoints of these sums, which all other links read
        let mut adjoints = Adjoints {
            a,
            now,
            taps,
            mem: &mut self.mem,
            lengths: &mut self.lengths,
            of_numbers,
            driven: &mut self.driven,
        };
        let mut sums = row.sums;
        for s in &mut self.last {
            let (own, others) = sums.split_at(s.slots().len() + 1);
            s.back(&row, Some(own), &mut adjoints);
            sums = others;
        }
        for (later, m) in self.sums.iter_mut().zip(summed) {
            adjoints.a.d[*m] = adjoints.a.x[*m] - *later;
            *later = adjoints.a.x[*m];
        }
        for (m, cell) in cells() {
            let parts: f64 = parts_of(cell).map(|(node, weight)| weight * adjoints.a.x[node]).sum();
            adjoints.a.x[m] += parts;
        }
        self.links.iter_mut().for_each(|s| s.back(&row, None, &mut adjoints));
        self.sets.iter_mut().for_each(|s| s.back(self.scene, &row, &mut adjoints));
        let Adjoints { a, now, taps, of_numbers, .. } = adjoints;
        for (m, cell) in cells() {
            for (node, weight) in parts_of(cell) {
                let (force, motion) = (a.f[m], now[m]);
                a.f[node] += weight * force;
                now[node] += weight * motion;
            }
            (a.f[m], now[m]) = (0.0, 0.0);
        }
        for h in &self.tapped {
            let phi = std::mem::take(&mut taps[h.tap]);
            if phi != 0.0 {
                h.back(&row, phi, a, now, of_numbers);
            }
        }
        // weights and force ports, which depend on nothing else
        for k in &self.parts.weights {
            let op = &self.scene.passes.forces[*k];
            for (k, m) in self.scene.layout.weighed[..op.n].iter().enumerate() {
                of_numbers[number(place.initial.coef[op.coef + k])] += a.x[*m as usize];
            }
        }
        self.inputs.fill(0.0);
        for p in &self.scene.layout.ports.enf {
            self.inputs[p.input as usize] += a.x[p.mat as usize];
        }
        let at = (TICKS - 1 - self.unsummed) * whole_lines(a.x.len());
        if let Some(to) = self.more.get_mut(at..).and_then(|to| to.get_mut(..a.x.len())) {
            to.copy_from_slice(&a.x);
        }
        let mut forced = (tick == 0).then(|| {
            let mut b = a.clone();
            (b.d, b.x) = (b.x, b.d);
            b.x.fill(0.0);
            b.f.fill(0.0);
            b
        });
        let layout = &self.layout;
        for s in [Some(&mut *a), forced.as_mut()].into_iter().flatten() {
            self.small.pull(s);
            for op in &self.linear {
                (op.kernel)(op, layout, s);
            }
        }
        for ([x, d], m) in self.before.iter().copied().zip(summed) {
            (a.x[*m], a.d[*m]) = (x, d);
        }
        if let Some(to) = self.nu.get_mut(at..).and_then(|to| to.get_mut(..a.x.len())) {
            to.copy_from_slice(&a.x);
        }
        self.unsummed += 1;
        for m in &self.moved {
            a.f[*m] += now[*m] - late[*m];
            if let Some(b) = &mut forced {
                b.f[*m] += now[*m];
            }
        }
        if let Some([_, share]) = self.parts.modal {
            let op = &self.scene.passes.forces[share];
            for ((p, other), force) in
                self.scene.layout.places.modal.iter().zip(&place.layout.places.modal).zip(row.modal)
            {
                let (m, first, n) = (p.mat as usize, p.first as usize, p.n as usize);
                // at the first tick, the motion is not a difference of two positions
                let start = forced.as_ref().map_or(0.0, |b| b.f[m]);
                for (k, share) in place.layout.places.shares[other.share as usize..][..n].iter().enumerate() {
                    let q = first + k;
                    of_numbers[number(*share)] += a.f[m] * row.x[q] + start * (row.d[q] - row.x[q]) + a.x[q] * force;
                }
            }
            (op.kernel)(op, layout, a);
            if let Some(b) = &mut forced {
                (op.kernel)(op, layout, b);
            }
        }
        // at the first tick, the motion of a port is 0
        let to_port = |mat: u32| a.f[mat as usize] - forced.as_ref().map_or(0.0, |b| b.f[mat as usize]);
        for (p, other) in self.scene.layout.ports.enx.iter().zip(&place.layout.ports.enx) {
            self.inputs[p.input as usize] += to_port(p.mat);
            of_numbers[number(other.rest)] -= to_port(p.mat);
        }
        for p in &self.scene.layout.ports.tgr {
            self.inputs[p.input as usize] += to_port(p.mat);
        }
        for k in &self.parts.solves {
            let op = &self.scene.passes.forces[*k];
            (op.kernel)(op, layout, a);
            if let Some(b) = &mut forced {
                (op.kernel)(op, layout, b);
            }
        }
        for m in &self.parts.held {
            a.f[*m] = 0.0;
        }
        if let Some(mut b) = forced {
            for m in &self.parts.held {
                b.f[*m] = 0.0;
            }
            b.d.copy_from_slice(&a.x);
            for op in &self.moves {
                (op.kernel)(op, layout, &mut b);
            }
            self.small.integrate(&mut b);
            self.first.copy_from_slice(&b.d);
        }
        for op in &self.moves {
            (op.kernel)(op, layout, a);
        }
        self.small.integrate(a);
        for m in &self.moved {
            late[*m] = std::mem::take(&mut now[*m]);
        }
    }
}

/// Nodes and weights under a moving point.
fn parts_of(cell: &[f64]) -> impl Iterator<Item = (usize, f64)> + '_ {
    let (nodes, weights) = cell.split_at(4);
    nodes.iter().zip(weights).filter(|(_, w)| **w != 0.0).map(|(node, w)| (*node as usize, *w))
}
