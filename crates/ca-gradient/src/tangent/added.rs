//! Added: the forces that changed numbers of linear links, of masses and of weight add to a derivative.
//!
//! With Ḟ for the derivative of F by a parameter, F = Σ c (α e + β w) gives Ḟ = Σ ċ (α e + β w) + … , where the rest is what
//! the link does to the derivatives of its ends. A mass moves by d' = P d + Q x + C f, so that Ṗ d + Q̇ x + Ċ f is added, as a
//! force after division by C. Decides to measure elongations once for all parameters, and to leave out each term that is
//! 0 for a whole list.

use crate::parts::record::Row;
use crate::parts::rows::Rows;
use crate::parts::{Parts, number};
use ca_core::{Scene, State};
use pulp::Arch;

/// What the numbers of a list of links add: for each parameter Σ ċα, Σ ċβ, and what changed constant elongations add; empty
/// where nothing is changed (links, or none).
struct List {
    links: Rows,
    by: Vec<[Vec<f64>; 3]>,
}

/// All of a scene.
pub struct Added {
    /// links whose forces are summed by themselves, and those of rows that integrate
    listed: Vec<List>,
    rows: Vec<List>,
    /// for each parameter, what is added to the force on a mass, per d, x and d' (slots, or none)
    masses: Vec<[Vec<f64>; 3]>,
    /// slots, parameters and weight that is added
    weight: Vec<(usize, usize, f64)>,
    /// elongations, their changes, and forces, in passing
    room: [Vec<f64>; 3],
}

/// Only what is not 0 everywhere.
fn some(all: Vec<f64>) -> Vec<f64> {
    if all.iter().any(|v| *v != 0.0) { all } else { Vec::new() }
}

impl Added {
    /// Of the parameters whose derivatives of the numbers are `columns`; `place` is the scene with each number replaced by its place
    /// among them.
    pub fn new(scene: &Scene, parts: &Parts, place: &Scene, columns: &[&[f64]]) -> Added {
        let (coef, own) = (&place.initial.coef, &scene.initial.coef);
        let list = |links: Rows| {
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
            let by: Vec<[Vec<f64>; 3]> = columns.iter().map(by).collect();
            by.iter().flatten().any(|v| !v.is_empty()).then_some(List { links, by })
        };
        let listed = parts.linear.iter().map(|(k, basis)| Rows::listed(scene, &scene.forces[*k], basis));
        let rows = parts.rows.iter().flat_map(|(k, basis)| Rows::integrated(&scene.moves[*k], basis));
        let (listed, rows): (Vec<List>, Vec<List>) =
            (listed.filter_map(list).collect(), rows.filter_map(list).collect());
        let n = scene.layout.n_mat;
        let of_masses = |column: &&[f64]| {
            let mass = |m: usize| {
                let [p, q, c] = [0, 1, 2].map(|k| own[k * n + m]);
                let [by_p, by_q, by_c] = [0, 1, 2].map(|k| column[number(coef[k * n + m])]);
                // what no force moves has no C
                if c == 0.0 { [0.0; 3] } else { [by_p - by_c * p / c, by_q - by_c * q / c, by_c / c].map(|v| v / c) }
            };
            let all: Vec<[f64; 3]> = (0..n).map(mass).collect();
            [0, 1, 2].map(|k| some(all.iter().map(|v| v[k]).collect()))
        };
        let mut weight = Vec::new();
        for op in parts.weights.iter().map(|k| &scene.forces[*k]) {
            for (i, m) in scene.layout.weighed[..op.n].iter().enumerate() {
                let by = columns.iter().map(|column| column[number(coef[op.coef + i])]).enumerate();
                weight.extend(by.filter(|by| by.1 != 0.0).map(|(q, v)| (*m as usize, q, v)));
            }
        }
        let most = listed.iter().chain(&rows).map(|l| l.links.n).max().unwrap_or(0);
        Added {
            weight,
            masses: columns.iter().map(of_masses).collect(),
            room: [(); 3].map(|()| vec![0.0; most]),
            listed,
            rows,
        }
    }

    /// Adds to the derivatives `to` of one tick, which began with `row`, what links that are summed by themselves and weight do.
    pub fn add_to_sums(&mut self, scene: &Scene, row: &Row, to: &mut [State]) {
        for (m, q, v) in &self.weight {
            to[*q].f[*m] += v;
        }
        if !self.listed.is_empty() {
            let (lists, e0) = (&self.listed[..], &scene.layout.e0[..]);
            Arch::new().dispatch(Tick { lists, masses: &[], row, next: &[], e0, room: &mut self.room, to });
        }
    }

    /// Adds what links of rows and masses do; `next` are the motions behind the tick.
    pub fn add_to_moves(&mut self, scene: &Scene, row: &Row, next: &[f64], to: &mut [State]) {
        let (lists, masses, e0) = (&self.rows[..], &self.masses[..], &scene.layout.e0[..]);
        Arch::new().dispatch(Tick { lists, masses, row, next, e0, room: &mut self.room, to });
    }
}

/// One tick, with the widest vectors of this processor; what it calls must be inlined into it.
struct Tick<'a> {
    lists: &'a [List],
    masses: &'a [[Vec<f64>; 3]],
    row: &'a Row<'a>,
    next: &'a [f64],
    e0: &'a [f64],
    room: &'a mut [Vec<f64>; 3],
    to: &'a mut [State],
}

impl pulp::WithSimd for Tick<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Tick { lists, masses, row, next, e0, room: [e, w, force], to } = self;
        for List { links, by } in lists {
            let n = links.n;
            let (e, w, force) = (&mut e[..n], &mut w[..n], &mut force[..n]);
            elongations(links, row, &e0[links.first..][..n], e, w);
            for (s, [by_e, by_w, constant]) in to.iter_mut().zip(by) {
                match (by_e.is_empty(), by_w.is_empty()) {
                    (true, true) if constant.is_empty() => continue,
                    (true, true) => force.fill(0.0),
                    (false, true) => products(by_e, e, force),
                    (true, false) => products(by_w, w, force),
                    (false, false) => both([by_e, by_w], [e, w], force),
                }
                if !constant.is_empty() {
                    add(force, constant);
                }
                let mut from = 0;
                for (n, ends) in &links.runs {
                    pull(&mut s.f, *ends, &force[from..][..*n]);
                    from += n;
                }
                for ([a, b], force) in links.ends.iter().zip(&*force) {
                    s.f[*a as usize] += force;
                    s.f[*b as usize] -= force;
                }
            }
        }
        for (s, [by_d, by_x, by_next]) in to.iter_mut().zip(masses) {
            if by_d.len() == by_next.len() {
                add_both(&mut s.f, [by_d, by_next], [row.d, next]);
            } else {
                add_products(&mut s.f, by_d, row.d);
                add_products(&mut s.f, by_next, next);
            }
            add_products(&mut s.f, by_x, row.x);
        }
    }
}

/// Elongations and their changes.
#[inline(always)]
fn elongations(links: &Rows, row: &Row, e0: &[f64], e: &mut [f64], w: &mut [f64]) {
    let (x, d, mut from) = (row.x, row.d, 0);
    for (n, [a, b]) in &links.runs {
        differences(&x[*a..][..*n], &x[*b..][..*n], &mut e[from..][..*n]);
        differences(&d[*a..][..*n], &d[*b..][..*n], &mut w[from..][..*n]);
        from += n;
    }
    for (i, [a, b]) in links.ends.iter().enumerate() {
        let (a, b) = (*a as usize, *b as usize);
        (e[i], w[i]) = (x[b] - x[a], d[b] - d[a]);
    }
    add(e, e0);
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
fn differences(a: &[f64], b: &[f64], to: &mut [f64]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to = b - a;
    }
}

#[inline(always)]
fn products(a: &[f64], b: &[f64], to: &mut [f64]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to = a * b;
    }
}

#[inline(always)]
fn both([a, b]: [&[f64]; 2], [e, w]: [&[f64]; 2], to: &mut [f64]) {
    for ((((to, a), b), e), w) in to.iter_mut().zip(a).zip(b).zip(e).zip(w) {
        *to = a * e + b * w;
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
