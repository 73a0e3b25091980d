//! Added forces, which act on derivatives where a parameter changes numbers of linear links, masses or weight.
//!
//! With Ḟ for the derivative of F by a parameter, F = Σ c (α e + β w) gives Ḟ = Σ ċ (α e + β w) + … , where the rest is
//! the action of the link on the derivatives of its ends. A mass moves by d' = P d + Q x + C f, so Ṗ d + Q̇ x + Ċ f is
//! added, as a force after division by C. These forces are computed for several ticks before any derivative is played:
//! by vectors where many numbers change ([`groups`](super::groups)), one by one where few do ([`few`](super::few)).

use super::few::{Few, On};
use super::groups::{Groups, Terms};
use crate::parts::record::Row;
use crate::parts::rows::Rows;
use crate::parts::small_passes::FEW;
use crate::parts::{Parts, number};
use ca_core::{Scene, State};

pub struct Added {
    /// At the beginning of a tick: links whose forces are summed by themselves.
    first: (Groups, Few),
    /// After all sums that are read: links of rows that integrate, and masses. In `first` too, if no sum is read.
    behind: (Groups, Few),
    /// Slots and added weight, per parameter.
    weight: Vec<Vec<(usize, f64)>>,
}

/// Returns the factors of all of a list, by kind; empty where all are 0.
fn terms(all: &[[f64; 3]]) -> Terms {
    [0, 1, 2].map(|kind| {
        let any = all.iter().any(|by| by[kind] != 0.0);
        all.iter().filter(|_| any).map(|by| by[kind]).collect()
    })
}

struct Changes<'a> {
    scene: &'a Scene,
    /// The scene with each number replaced by its index.
    place: &'a Scene,
    /// Derivatives of the numbers, per parameter.
    columns: &'a [&'a [f64]],
    ticks: usize,
}

impl Changes<'_> {
    /// Returns the force that a parameter adds on each link of a list, per e, per w and constant.
    fn of_links(&self, links: &Rows, column: &[f64]) -> Vec<[f64; 3]> {
        let (coef, own) = (&self.place.initial.coef, &self.scene.initial.coef);
        let of = |i: usize| {
            let [by_e, by_w] = links.basis.slopes(|k| column[number(coef[links.coef + k * links.n + i])]);
            let [slope, _] = links.basis.slopes(|k| own[links.coef + k * links.n + i]);
            [by_e, by_w, slope * column[number(self.place.layout.links.e0[links.first + i])]]
        };
        (0..links.n).map(of).collect()
    }

    /// Returns the force that it adds on each mass, per d, x and d'.
    fn of_masses(&self, column: &[f64]) -> Vec<[f64; 3]> {
        let (coef, own, n) = (&self.place.initial.coef, &self.scene.initial.coef, self.scene.layout.counts.n_mat);
        let of = |m: usize| {
            let [p, q, c] = [0, 1, 2].map(|k| own[k * n + m]);
            let [by_p, by_q, by_c] = [0, 1, 2].map(|k| column[number(coef[k * n + m])]);
            // C is 0 for a slot that forces do not move
            if c == 0.0 { [0.0; 3] } else { [by_p - by_c * p / c, by_q - by_c * q / c, by_c / c].map(|v| v / c) }
        };
        (0..n).map(of).collect()
    }

    /// Returns the terms of each parameter for the targets `on`; where few are nonzero, they go to `few` instead.
    fn split(&self, few: &mut Few, on: &[On], of: impl Fn(&[f64]) -> Vec<[f64; 3]>) -> Vec<Terms> {
        let mut many = Vec::new();
        for (q, column) in self.columns.iter().enumerate() {
            let all = of(column);
            let changed = || on.iter().zip(&all).filter(|(_, by)| **by != [0.0; 3]);
            if changed().count() > FEW {
                many.push(terms(&all));
            } else {
                changed().for_each(|(on, by)| few.put(q, *on, *by, self.ticks));
                many.push(Terms::default());
            }
        }
        many
    }

    fn lists(&self, lists: Vec<Rows>) -> (Groups, Few) {
        let mut few = Few::new(self.columns.len());
        let of = |links: &Rows| {
            let e0 = &self.scene.layout.links.e0[links.first..];
            let on: Vec<On> = links.slots().zip(e0).map(|(slots, e0)| On::Link(slots, *e0)).collect();
            self.split(&mut few, &on, |column| self.of_links(links, column))
        };
        let many: Vec<Vec<Terms>> = lists.iter().map(of).collect();
        let mut groups = Groups::new(lists, &self.scene.layout.links.e0);
        many.iter().enumerate().for_each(|(list, by)| groups.put(Some(list), by));
        (groups, few)
    }
}

impl Added {
    /// Makes the forces for `ticks` ticks at a time. `columns` holds the derivatives of the numbers for each parameter,
    /// `place` the scene with each number replaced by its index.
    pub fn new(scene: &Scene, parts: &Parts, place: &Scene, columns: &[&[f64]], ticks: usize) -> Added {
        let changes = Changes { scene, place, columns, ticks };
        let mut first: Vec<Rows> =
            parts.linear.iter().map(|(k, basis)| Rows::listed(scene, &scene.passes.forces[*k], basis)).collect();
        let mut behind: Vec<Rows> =
            parts.rows.iter().flat_map(|(k, basis)| Rows::integrated(&scene.passes.moves[*k], basis)).collect();
        let read = !parts.summed.is_empty();
        if !read {
            first.append(&mut behind);
        }
        let (mut first, mut behind) = (changes.lists(first), changes.lists(behind));
        let of_masses = if read { &mut behind } else { &mut first };
        let masses: Vec<On> = (0..scene.layout.counts.n_mat).map(On::Mass).collect();
        let many = changes.split(&mut of_masses.1, &masses, |column| changes.of_masses(column));
        of_masses.0.put(None, &many);
        for (groups, _) in [&mut first, &mut behind] {
            groups.begin(ticks, scene.layout.counts.n_mat);
        }
        let weighed = |column: &&[f64]| {
            let ops = parts.weights.iter().map(|k| &scene.passes.forces[*k]);
            let each = ops.flat_map(|op| scene.layout.weighed[..op.n].iter().zip(op.coef..));
            let by = each.map(|(m, at)| (*m as usize, column[number(place.initial.coef[at])]));
            by.filter(|(_, v)| *v != 0.0).collect()
        };
        Added { first, behind, weight: columns.iter().map(weighed).collect() }
    }

    /// Computes the forces of the stored tick `k`, which began with `row`; `next` holds the motions after it.
    pub fn measure(&mut self, k: usize, row: &Row, next: &[f64]) {
        for (groups, few) in [&mut self.first, &mut self.behind] {
            groups.measure(k, row, next);
            few.measure(k, row, next);
        }
    }

    /// Begins tick `k` of the derivatives by parameter `q`, whose forces are 0.
    pub fn begin(&mut self, k: usize, q: usize, to: &mut State) {
        let (groups, few) = &mut self.first;
        groups.give(k, q, &mut to.f);
        few.add(k, q, &mut to.f);
        for (m, v) in &self.weight[q] {
            to.f[*m] += v;
        }
    }

    /// Adds the forces that come after all sums that are read.
    pub fn add_behind(&self, k: usize, q: usize, to: &mut State) {
        let (groups, few) = &self.behind;
        groups.add(k, q, &mut to.f);
        few.add(k, q, &mut to.f);
    }
}
