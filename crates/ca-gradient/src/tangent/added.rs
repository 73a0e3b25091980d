//! Added: the forces that changed numbers of linear links, of masses and of weight add to a derivative.
//!
//! With Ḟ for the derivative of F by a parameter, F = Σ c (α e + β w) gives Ḟ = Σ ċ (α e + β w) + … , where the rest is what
//! the link does to the derivatives of its ends. A mass moves by d' = P d + Q x + C f, so that Ṗ d + Q̇ x + Ċ f is added, as a
//! force after division by C. Decides to find these forces for some ticks before any derivative is played, and once for all parameters that
//! change the numbers of a list by multiples of the same: mass, pitch and decay of a string all do so.

use crate::parts::record::Row;
use crate::parts::rows::Rows;
use crate::parts::{Parts, number};
use ca_core::{Scene, State};
use ca_core_dual::numeric::TANGENTS;
use pulp::Arch;

/// What is added, per number: to the force of a link per e, per w and by itself, or to that on a mass per d, x and d'; empty where
/// it is 0 throughout (links or slots, or none).
type Terms = [Vec<f64>; 3];

/// What some parameters add, each its share.
struct Group {
    shares: [f64; TANGENTS],
    /// by list
    links: Vec<(usize, Terms)>,
    masses: Terms,
    /// for each tick, the forces (ticks x slots)
    forces: Vec<f64>,
}

/// What is added to some forces.
#[derive(Default)]
struct Groups {
    lists: Vec<Rows>,
    groups: Vec<Group>,
}

/// All of a scene.
pub struct Added {
    /// of links whose forces are summed by themselves; of those of rows that integrate, and of masses
    sums: Groups,
    moves: Groups,
    /// of parameters that change few masses, these: parameter, slot, and what is added per d, x and d'; the forces (ticks x few)
    few: Vec<(usize, usize, [f64; 3])>,
    few_forces: Vec<f64>,
    /// for each parameter, slots and weight that is added
    weight: Vec<Vec<(usize, f64)>>,
    /// forces of links, in passing
    room: Vec<f64>,
}

/// As many masses as are taken one by one.
const FEW: usize = 4;

/// Only what is not 0 everywhere.
fn some(all: Vec<f64>) -> Vec<f64> {
    if all.iter().any(|v| *v != 0.0) { all } else { Vec::new() }
}

/// How many times `base` the numbers are, if they are so to rounding.
fn multiple(of: &[f64], base: &[f64]) -> Option<f64> {
    let (v, b) = of.iter().zip(base).find(|(_, b)| **b != 0.0)?;
    let by = v / b;
    let near = |(v, b): (&f64, &f64)| (v - by * b).abs() <= 4.0 * f64::EPSILON * v.abs();
    of.iter().zip(base).all(near).then_some(by)
}

/// What the terms of all parameters are multiples of, and how many times it each is.
fn bases<'a>(by: impl Iterator<Item = &'a Vec<f64>>) -> Vec<(&'a Vec<f64>, [f64; TANGENTS])> {
    let mut all: Vec<(&Vec<f64>, [f64; TANGENTS])> = Vec::new();
    for (q, of) in by.enumerate().filter(|(_, of)| !of.is_empty()) {
        let known = all.iter_mut().find_map(|(base, shares)| Some((multiple(of, base)?, shares)));
        if let Some((share, shares)) = known {
            shares[q] = share;
        } else {
            let mut shares = [0.0; TANGENTS];
            shares[q] = 1.0;
            all.push((of, shares));
        }
    }
    all
}

impl Group {
    /// Those of the links of a list, or of masses (`None`).
    fn terms(&mut self, list: Option<usize>) -> &mut Terms {
        let Some(list) = list else { return &mut self.masses };
        let known = self.links.iter().position(|(l, _)| *l == list).unwrap_or_else(|| {
            self.links.push((list, Terms::default()));
            self.links.len() - 1
        });
        &mut self.links[known].1
    }
}

impl Groups {
    /// Adds the terms of each parameter, for the links of a list or for masses (`None`).
    fn put(&mut self, list: Option<usize>, by: &[Terms]) {
        for kind in 0..3 {
            for (base, shares) in bases(by.iter().map(|terms| &terms[kind])) {
                let at = self.with(shares, list, kind);
                self.groups[at].terms(list)[kind].clone_from(base);
            }
        }
    }

    /// The group of these shares whose terms of a kind are free, a new one where there is none.
    fn with(&mut self, shares: [f64; TANGENTS], list: Option<usize>, kind: usize) -> usize {
        let free = |g: &mut Group| g.shares == shares && g.terms(list)[kind].is_empty();
        self.groups.iter_mut().position(free).unwrap_or_else(|| {
            let (links, masses, forces) = (Vec::new(), Terms::default(), Vec::new());
            self.groups.push(Group { shares, links, masses, forces });
            self.groups.len() - 1
        })
    }

    /// Finds the forces of tick `k`, with the widest vectors of this processor.
    fn measure(&mut self, scene: &Scene, k: usize, row: &Row, next: &[f64], room: &mut [f64]) {
        if !self.groups.is_empty() {
            let (Groups { lists, groups }, e0) = (self, &scene.layout.e0[..]);
            Arch::new().dispatch(Tick { lists, groups, k, row, next, e0, room });
        }
    }

    /// Adds the forces of tick `k` to the derivatives by parameter `q`.
    fn add(&self, k: usize, q: usize, f: &mut [f64]) {
        if self.groups.iter().any(|g| g.shares[q] != 0.0) {
            Arch::new().dispatch(Shares { groups: &self.groups, k, q, f });
        }
    }
}

impl Added {
    /// Of the parameters whose derivatives of the numbers are `columns`; `place` is the scene with each number replaced by its place
    /// among them; for so many ticks at a time.
    pub fn new(scene: &Scene, parts: &Parts, place: &Scene, columns: &[&[f64]], ticks: usize) -> Added {
        let (coef, own) = (&place.initial.coef, &scene.initial.coef);
        let terms = |links: &Rows| -> Vec<Terms> {
            let by = |column: &&[f64]| {
                let sum = |i: usize, which: usize| {
                    let each = links.basis.0.iter().enumerate();
                    let of = |(k, basis): (usize, &[f64; 2])| {
                        basis[which] * column[number(coef[links.coef + k * links.n + i])]
                    };
                    each.map(of).sum::<f64>()
                };
                let constant = |i: usize| {
                    let [slope, _] = links.basis.slopes(|k| own[links.coef + k * links.n + i]);
                    slope * column[number(place.layout.e0[links.first + i])]
                };
                let all = 0..links.n;
                let by_e: Vec<f64> = all.clone().map(|i| sum(i, 0)).collect();
                [some(by_e), some(all.clone().map(|i| sum(i, 1)).collect()), some(all.map(constant).collect())]
            };
            columns.iter().map(by).collect()
        };
        let all = |lists: Vec<Rows>| {
            let mut all = Groups { lists, groups: Vec::new() };
            for i in 0..all.lists.len() {
                let by = terms(&all.lists[i]);
                all.put(Some(i), &by);
            }
            all
        };
        let listed = parts.linear.iter().map(|(k, basis)| Rows::listed(scene, &scene.forces[*k], basis));
        let rows = parts.rows.iter().flat_map(|(k, basis)| Rows::integrated(&scene.moves[*k], basis));
        let (mut sums, mut moves) = (all(listed.collect()), all(rows.collect()));
        let n = scene.layout.n_mat;
        let of_masses = |column: &[f64]| {
            let mass = |m: usize| {
                let [p, q, c] = [0, 1, 2].map(|k| own[k * n + m]);
                let [by_p, by_q, by_c] = [0, 1, 2].map(|k| column[number(coef[k * n + m])]);
                // what no force moves has no C
                if c == 0.0 { [0.0; 3] } else { [by_p - by_c * p / c, by_q - by_c * q / c, by_c / c].map(|v| v / c) }
            };
            (0..n).map(mass).collect::<Vec<[f64; 3]>>()
        };
        let (mut few, mut many) = (Vec::new(), Vec::new());
        for (q, column) in columns.iter().enumerate() {
            let all = of_masses(column);
            let changed = || all.iter().enumerate().filter(|(_, by)| **by != [0.0; 3]);
            if changed().count() <= FEW {
                few.extend(changed().map(|(m, by)| (q, m, *by)));
                many.push(Terms::default());
            } else {
                many.push([0, 1, 2].map(|k| some(all.iter().map(|v| v[k]).collect())));
            }
        }
        moves.put(None, &many);
        for group in sums.groups.iter_mut().chain(&mut moves.groups) {
            group.forces = vec![0.0; ticks * n];
        }
        let weighed = |column: &&[f64]| {
            let ops = parts.weights.iter().map(|k| &scene.forces[*k]);
            let each = ops.flat_map(|op| scene.layout.weighed[..op.n].iter().zip(op.coef..));
            let by = each.map(|(m, at)| (*m as usize, column[number(coef[at])]));
            by.filter(|(_, v)| *v != 0.0).collect()
        };
        let most = sums.lists.iter().chain(&moves.lists).map(|l| l.n).max().unwrap_or(0);
        let weight = columns.iter().map(weighed).collect();
        Added { few_forces: vec![0.0; ticks * few.len()], few, sums, moves, weight, room: vec![0.0; most] }
    }

    /// Finds what is added in tick `k` of those at a time, which began with `row`; `next` are the motions behind it.
    pub fn measure(&mut self, scene: &Scene, k: usize, row: &Row, next: &[f64]) {
        for groups in [&mut self.sums, &mut self.moves] {
            groups.measure(scene, k, row, next, &mut self.room);
        }
        for ((_, m, by), force) in self.few.iter().zip(&mut self.few_forces[k * self.few.len()..]) {
            *force = by[0] * row.d[*m] + by[1] * row.x[*m] + by[2] * next[*m];
        }
    }

    /// Adds to the derivatives by parameter `q` in tick `k` what links that are summed by themselves and weight do.
    pub fn add_to_sums(&self, k: usize, q: usize, to: &mut State) {
        for (m, v) in &self.weight[q] {
            to.f[*m] += v;
        }
        self.sums.add(k, q, &mut to.f);
    }

    /// Adds what links of rows and masses do.
    pub fn add_to_moves(&self, k: usize, q: usize, to: &mut State) {
        self.moves.add(k, q, &mut to.f);
        for ((_, m, _), force) in self.few.iter().zip(&self.few_forces[k * self.few.len()..]).filter(|of| of.0.0 == q) {
            to.f[*m] += force;
        }
    }
}

/// One tick, with the widest vectors of this processor; what it calls must be inlined into it.
struct Tick<'a> {
    lists: &'a [Rows],
    groups: &'a mut [Group],
    k: usize,
    row: &'a Row<'a>,
    next: &'a [f64],
    e0: &'a [f64],
    room: &'a mut [f64],
}

impl pulp::WithSimd for Tick<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Tick { lists, groups, k, row, next, e0, room } = self;
        let n = row.x.len();
        for Group { links: terms, masses: [by_d, by_x, by_next], forces, .. } in groups {
            let f = &mut forces[k * n..][..n];
            f.fill(0.0);
            for (list, [by_e, by_w, constant]) in &*terms {
                let links = &lists[*list];
                let (e0, force) = (&e0[links.first..][..links.n], &mut room[..links.n]);
                let mut from = 0;
                for (n, [a, b]) in &links.runs {
                    let force = &mut force[from..][..*n];
                    let [xa, xb] = [&row.x[*a..][..*n], &row.x[*b..][..*n]];
                    let [da, db] = [&row.d[*a..][..*n], &row.d[*b..][..*n]];
                    let e0 = &e0[from..][..*n];
                    match (by_e.get(from..from + n), by_w.get(from..from + n)) {
                        (Some(by_e), Some(by_w)) => both([by_e, by_w], e0, [xa, xb], [da, db], force),
                        (Some(by_e), None) => elongations(by_e, e0, [xa, xb], force),
                        (None, Some(by_w)) => differences(by_w, [da, db], force),
                        (None, None) => force.fill(0.0),
                    }
                    if let Some(constant) = constant.get(from..from + n) {
                        add(force, constant);
                    }
                    pull(f, [*a, *b], force);
                    from += n;
                }
                for (i, [a, b]) in links.ends.iter().enumerate() {
                    let (a, b) = (*a as usize, *b as usize);
                    let of = |by: &[f64], v: f64| by.get(i).map_or(0.0, |by| by * v);
                    let e = row.x[b] - row.x[a] + e0[i];
                    let force = of(by_e, e) + of(by_w, row.d[b] - row.d[a]) + of(constant, 1.0);
                    f[a] += force;
                    f[b] -= force;
                }
            }
            if by_d.len() == by_next.len() {
                add_both(f, [by_d, by_next], [row.d, next]);
            } else {
                add_products(f, by_d, row.d);
                add_products(f, by_next, next);
            }
            add_products(f, by_x, row.x);
        }
    }
}

/// The shares of a parameter in one tick.
struct Shares<'a> {
    groups: &'a [Group],
    k: usize,
    q: usize,
    f: &'a mut [f64],
}

impl pulp::WithSimd for Shares<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Shares { groups, k, q, f } = self;
        let n = f.len();
        for Group { shares, forces, .. } in groups {
            let share = shares[q];
            if share == 0.0 {
                continue;
            }
            for (to, of) in f.iter_mut().zip(&forces[k * n..][..n]) {
                *to += share * of;
            }
        }
    }
}

/// The forces of a row of links whose first has these ends, on one end and the opposite on the other.
#[inline(always)]
fn pull(f: &mut [f64], [a, b]: [usize; 2], force: &[f64]) {
    let (n, step) = (force.len(), b.saturating_sub(a));
    if b <= a || step >= n {
        add(&mut f[a..][..n], force);
        subtract(&mut f[b..][..n], force);
        return;
    }
    add(&mut f[a..b], &force[..step]);
    // what lies between is the second end of one and the first of another
    let between = &mut f[b..][..n - step];
    for ((to, next), last) in between.iter_mut().zip(&force[step..]).zip(force) {
        *to += next - last;
    }
    subtract(&mut f[a + n..][..step], &force[n - step..]);
}

// each a function of its own, so that the compiler knows that what is written is none of what is read

#[inline(always)]
fn both([by_e, by_w]: [&[f64]; 2], e0: &[f64], [xa, xb]: [&[f64]; 2], [da, db]: [&[f64]; 2], to: &mut [f64]) {
    let each = to.iter_mut().zip(by_e).zip(by_w).zip(e0).zip(xa).zip(xb).zip(da).zip(db);
    for (((((((to, by_e), by_w), e0), xa), xb), da), db) in each {
        *to = by_e * (xb - xa + e0) + by_w * (db - da);
    }
}

#[inline(always)]
fn elongations(by: &[f64], e0: &[f64], [a, b]: [&[f64]; 2], to: &mut [f64]) {
    for ((((to, by), e0), a), b) in to.iter_mut().zip(by).zip(e0).zip(a).zip(b) {
        *to = by * (b - a + e0);
    }
}

#[inline(always)]
fn differences(by: &[f64], [a, b]: [&[f64]; 2], to: &mut [f64]) {
    for (((to, by), a), b) in to.iter_mut().zip(by).zip(a).zip(b) {
        *to = by * (b - a);
    }
}

#[inline(always)]
fn add_both(to: &mut [f64], [a, b]: [&[f64]; 2], [u, v]: [&[f64]; 2]) {
    for ((((to, a), b), u), v) in to.iter_mut().zip(a).zip(b).zip(u).zip(v) {
        *to += a * u + b * v;
    }
}

#[inline(always)]
fn add_products(to: &mut [f64], a: &[f64], b: &[f64]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to += a * b;
    }
}

#[inline(always)]
fn add(to: &mut [f64], by: &[f64]) {
    for (to, by) in to.iter_mut().zip(by) {
        *to += by;
    }
}

#[inline(always)]
fn subtract(to: &mut [f64], by: &[f64]) {
    for (to, by) in to.iter_mut().zip(by) {
        *to -= by;
    }
}
