//! Forward derivatives of a mostly linear scene, played by its own passes.
//!
//! Over dual numbers, every number of a long string carries seven derivatives, and no pass runs as in a render. But
//! linear parts act on derivatives as on positions, so their passes play the derivatives by each parameter as a
//! separate state, in the same layout and as fast. Links that are not linear are evaluated alone over dual numbers
//! ([`link`]). If a parameter changes numbers of linear links, derivatives get added forces ([`added`]). Both are
//! computed for several ticks beforehand, and each state is then played over these ticks by itself, so that it stays in
//! the nearest cache. Scenes that this does not support, that are small or that have many nonlinear links use dual
//! numbers.

mod added;
mod few;
mod gains;
mod groups;
mod link;

use crate::Error;
use crate::parts::link_in_scene::Placed;
use crate::parts::numbers::Numbers;
use crate::parts::outputs::listed;
use crate::parts::record::Record;
use crate::parts::small_passes::Small;
use crate::parts::{Link, Parts, number, unknown};
use crate::play_io::diverged;
use added::Added;
use ca_core::internal::numeric::Aligned;
use ca_core::internal::op::layout::Layout;
use ca_core::{Dual, Scene, State};
use ca_io::perform::DIVERGED;
use gains::Gains;
use link::Moving;

/// Minimum of masses in a scene, and per link evaluated alone; with fewer, dual numbers are as fast.
const MASSES: usize = 32;
const MASSES_FOR_LINK: usize = 8;

/// Ticks played with the derivatives by one parameter before those by the next.
const TICKS: usize = 32;

pub struct Tangent {
    parts: Parts,
    dual: Scene<Dual>,
    numbers: Numbers,
    /// Layout of the scene, without constant elongations.
    layout: Layout,
}

impl Tangent {
    /// Returns whether dual numbers for the whole tick would take longer.
    pub fn is_worth(scene: &Scene, parts: &Parts) -> bool {
        let single_links: usize = parts.links.iter().chain(&parts.last).map(|l| l.members.len()).sum();
        scene.layout.counts.n_mat >= MASSES.max(MASSES_FOR_LINK * single_links)
    }

    /// Returns the parts of a scene, if all are supported here.
    pub fn parts(scene: &Scene) -> Option<Parts> {
        let parts = Parts::of(scene).ok()?;
        let l = &scene.layout;
        let known = scene.before.is_none()
            && l.places.moving_points.is_empty()
            && parts.modal.is_none()
            && parts.solves.is_empty()
            && parts.sets.is_empty()
            && parts.driven.is_empty();
        known.then_some(parts)
    }

    /// Makes it for a scene with these `numbers`; `None` where a parameter changes a number that is not supported here.
    pub fn new(scene: &Scene, parts: Parts, dual: Scene<Dual>, numbers: Numbers) -> Option<Tangent> {
        let mut layout = scene.layout.clone();
        layout.links.e0.fill(0.0);
        layout.out.links.iter_mut().for_each(|h| h.e0 = 0.0);
        let tangent = Tangent { parts, dual, numbers, layout };
        tangent.knows_all(scene)?.then_some(tangent)
    }

    /// Returns whether all numbers that parameters change are supported; `None` where a link lacks a dual law.
    fn knows_all(&self, scene: &Scene) -> Option<bool> {
        let place = &self.numbers.place;
        let (start, l) = (&place.initial, &place.layout);
        let mut known = vec![false; self.numbers.count];
        let mut know = |all: &[f64]| all.iter().for_each(|v| known[number(*v)] = true);
        for all in [&start.x, &start.d] {
            know(all);
        }
        // only sets read rest positions, and there are none
        know(&l.places.rest);
        know(&start.links.mem);
        know(&start.links.lengths);
        know(&start.coef[..3 * l.counts.n_mat]);
        listed(scene).filter(|o| o.high_pass.is_none()).for_each(|o| know(&start.coef[o.gain..][..1]));
        for k in &self.parts.weights {
            let op = &scene.passes.forces[*k];
            know(&start.coef[op.coef..][..op.n]);
        }
        // numbers of tapped links are read by more than their passes
        let sums = self.parts.linear.iter().map(|(k, _)| &scene.passes.forces[*k]).filter(|op| !op.form.tap);
        let unread = |op: &&ca_core::internal::op::Op| l.out.links.is_empty() || op.law.is_none();
        let rows = self.parts.rows.iter().map(|(k, _)| &scene.passes.moves[*k]).filter(unread);
        for op in sums.chain(rows) {
            let passes = if op.form.band == ca_core::internal::op::Band::None { 1 } else { 2 };
            know(&start.coef[op.coef..][..op.law?.coefs * op.n * passes]);
            know(&l.links.e0[op.first..][..op.n * passes]);
        }
        for link in self.parts.links.iter().chain(&self.parts.last) {
            let link = Placed::new(scene, link, &self.dual, place)?;
            link.numbers.iter().for_each(|(_, at)| know(&[*at]));
        }
        let changes = |i: usize| self.numbers.derivatives.iter().any(|d| d[i] != 0.0);
        Some(known.iter().enumerate().all(|(i, known)| *known || !changes(i)))
    }

    /// Plays the inputs `given` (frames x inputs) with the derivatives by `some` parameters, at most seven. `on_sample`
    /// receives the outputs of each sample, in a state with no other content, and may stop the play by an error.
    pub fn play(
        &self,
        scene: &Scene,
        (given, frames): (&[f64], usize),
        some: std::ops::Range<usize>,
        on_sample: &mut impl FnMut(usize, &State<Dual>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let columns: Vec<&[f64]> = self.numbers.derivatives[some].iter().map(Vec::as_slice).collect();
        let place = &self.numbers.place;
        let mut added = Added::new(scene, &self.parts, place, &columns, TICKS);
        let gains = Gains::new(scene, place, &columns);
        let one = |link: &Link| {
            let found = Moving::new(scene, link, &self.dual, place, &columns, TICKS);
            found.ok_or_else(|| unknown(&scene.passes.forces[link.op()]))
        };
        let links_of = |all: &[Link]| all.iter().map(one).collect::<Result<Vec<_>, _>>();
        let (mut links, mut last) = (links_of(&self.parts.links)?, links_of(&self.parts.last)?);
        let (small, linear, moves) = Small::of(scene, &self.parts);
        let mut states: Vec<State> = columns.iter().map(|column| started(scene, place, column)).collect();
        // shared by all states, since no derivative changes them
        let mut coefs = scene.initial.coef.clone();
        let mut record = Record::new(scene, &self.parts, TICKS, [false, true]);
        let (mut s, inputs) = (scene.state(), scene.inputs.len());
        let mut sample = State::<Dual>::default();
        sample.output = vec![Dual::default(); scene.counts.n_out];
        let mut outputs = vec![vec![Dual::default(); scene.counts.n_out]; TICKS];
        for first in (0..frames).step_by(TICKS) {
            let ticks = TICKS.min(frames - first);
            let given = &given[first * inputs..][..ticks * inputs];
            record.play(scene, &self.parts, &mut s, given, ticks, |k, output| {
                outputs[k].iter_mut().zip(output).for_each(|(to, v)| *to = Dual::constant(*v));
            });
            if s.tick.is_multiple_of(64) && !s.is_bounded(DIVERGED) {
                return Err(diverged());
            }
            for k in 0..ticks {
                let row = record.row(k);
                added.measure(k, &row, record.motions(k + 1));
                for l in &mut links {
                    l.measure(k, &row, None);
                }
                let mut sums = row.sums;
                for l in &mut last {
                    let (own, others) = sums.split_at(l.slots() + 1);
                    l.measure(k, &row, Some(own));
                    sums = others;
                }
            }
            for (q, a) in states.iter_mut().enumerate() {
                std::mem::swap(&mut a.coef, &mut coefs);
                for (k, output) in outputs[..ticks].iter_mut().enumerate() {
                    added.begin(k, q, a);
                    for l in &mut links {
                        l.add(k, q, a);
                    }
                    small.pull(a);
                    for op in &linear {
                        (op.kernel)(op, &self.layout, a);
                    }
                    for l in &mut last {
                        l.add(k, q, a);
                    }
                    for op in &scene.passes.writes {
                        (op.kernel)(op, &self.layout, a);
                        if !gains.is_idle() && op.name() == "outputs" {
                            gains.add(&record.row(k), q, a);
                        }
                    }
                    output.iter_mut().zip(&a.output).for_each(|(to, v)| to.tangents_mut()[q] = *v);
                    // outputs do not read the added forces of rows and masses
                    added.add_behind(k, q, a);
                    self.parts.held.iter().for_each(|m| a.f[*m] = 0.0);
                    for op in &moves {
                        (op.kernel)(op, &self.layout, a);
                    }
                    small.integrate(a);
                    a.tick += 1;
                }
                std::mem::swap(&mut a.coef, &mut coefs);
            }
            for (k, output) in outputs[..ticks].iter().enumerate() {
                sample.output.copy_from_slice(output);
                on_sample(first + k, &sample)?;
            }
        }
        Ok(())
    }
}

/// State at load with each number replaced by its derivative.
fn started(scene: &Scene, place: &Scene, column: &[f64]) -> State {
    let mut a = scene.state();
    let start = &place.initial;
    let put = |to: &mut [f64], from: &[f64]| {
        to.iter_mut().zip(from).for_each(|(to, v)| *to = column[number(*v)]);
    };
    put(&mut a.x, &start.x);
    put(&mut a.d, &start.d);
    put(&mut a.links.mem, &start.links.mem);
    put(&mut a.links.lengths, &start.links.lengths);
    a.coef = Aligned::default();
    a.f.fill(0.0);
    a
}
