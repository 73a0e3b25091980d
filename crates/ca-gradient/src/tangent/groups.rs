//! Groups: the forces that changed numbers of many links or masses add to derivatives, by vectors over all slots.
//!
//! Decides to find them once for all parameters that change the numbers of a list by multiples of the same: mass, pitch and decay of
//! a string all do so.

use crate::parts::record::{Row, whole_lines};
use crate::parts::rows::Rows;
use ca_core::numeric::Aligned;
use ca_core_dual::numeric::TANGENTS;
use pulp::Arch;

/// What is added, per number: to the force of a link per e, per w and by itself, or to that on a mass per d, x and d'; empty where
/// it is 0 throughout (links or slots, or none).
pub type Terms = [Aligned; 3];

/// What some parameters add, each its share.
struct Group {
    shares: [f64; TANGENTS],
    /// by list
    links: Vec<(usize, Terms)>,
    masses: Terms,
    /// for each tick, the forces (ticks x slots)
    forces: Aligned,
}

/// What is added to some forces.
pub struct Groups {
    lists: Vec<Rows>,
    all: Vec<Group>,
    /// of each parameter, the groups it has a share in
    of: [Vec<(usize, f64)>; TANGENTS],
    /// forces of links, in passing
    room: Aligned,
}

/// How many times `base` the numbers are, if they are so to rounding.
fn multiple(of: &[f64], base: &[f64]) -> Option<f64> {
    let (v, b) = of.iter().zip(base).find(|(_, b)| **b != 0.0)?;
    let by = v / b;
    let near = |(v, b): (&f64, &f64)| (v - by * b).abs() <= 4.0 * f64::EPSILON * v.abs();
    of.iter().zip(base).all(near).then_some(by)
}

/// What the terms of all parameters are multiples of, and how many times it each is.
fn bases<'a>(by: impl Iterator<Item = &'a Aligned>) -> Vec<(&'a Aligned, [f64; TANGENTS])> {
    let mut all: Vec<(&Aligned, [f64; TANGENTS])> = Vec::new();
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
    /// None yet, of these lists.
    pub fn new(lists: Vec<Rows>) -> Groups {
        let room = Aligned::zeros(lists.iter().map(|l| l.n).max().unwrap_or(0));
        Groups { lists, all: Vec::new(), of: Default::default(), room }
    }

    /// Adds the terms of each parameter, for the links of a list or for masses (`None`).
    pub fn put(&mut self, list: Option<usize>, by: &[Terms]) {
        for kind in 0..3 {
            for (base, shares) in bases(by.iter().map(|terms| &terms[kind])) {
                let at = self.with(shares, list, kind);
                self.all[at].terms(list)[kind].clone_from(base);
            }
        }
    }

    /// The group of these shares whose terms of a kind are free, a new one where there is none.
    fn with(&mut self, shares: [f64; TANGENTS], list: Option<usize>, kind: usize) -> usize {
        let free = |g: &mut Group| g.shares == shares && g.terms(list)[kind].is_empty();
        self.all.iter_mut().position(free).unwrap_or_else(|| {
            let (links, masses, forces) = (Vec::new(), Terms::default(), Aligned::default());
            self.all.push(Group { shares, links, masses, forces });
            self.all.len() - 1
        })
    }

    /// Makes room for so many ticks at a time of so many slots, when all is put.
    pub fn begin(&mut self, ticks: usize, slots: usize) {
        for (k, group) in self.all.iter_mut().enumerate() {
            group.forces = Aligned::zeros(ticks * whole_lines(slots));
            for (of, share) in self.of.iter_mut().zip(group.shares).filter(|(_, share)| *share != 0.0) {
                of.push((k, share));
            }
        }
    }

    /// Finds the forces of tick `k`, with the widest vectors of this processor.
    pub fn measure(&mut self, e0: &[f64], k: usize, row: &Row, next: &[f64]) {
        if !self.all.is_empty() {
            let Groups { lists, all: groups, room, .. } = self;
            Arch::new().dispatch(Tick { lists, groups, k, row, next, e0, room });
        }
    }

    /// Adds the forces of tick `k` to the derivatives by parameter `q`.
    pub fn add(&self, k: usize, q: usize, f: &mut [f64]) {
        let of = &self.of[q][..];
        if !of.is_empty() {
            Arch::new().dispatch(Shares { groups: &self.all, of, k, f });
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
            let f = &mut forces[k * whole_lines(n)..][..n];
            match (by_d.get(..n), by_next.get(..n)) {
                (Some(by_d), Some(by_next)) => put_both(f, [by_d, by_next], [row.d, next]),
                (Some(by_d), None) => put_products(f, by_d, row.d),
                (None, Some(by_next)) => put_products(f, by_next, next),
                (None, None) => f.fill(0.0),
            }
            add_products(f, by_x, row.x);
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
        }
    }
}

/// The shares of a parameter in one tick.
struct Shares<'a> {
    groups: &'a [Group],
    of: &'a [(usize, f64)],
    k: usize,
    f: &'a mut [f64],
}

impl pulp::WithSimd for Shares<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Shares { groups, of, k, f } = self;
        let n = f.len();
        let at = k * whole_lines(n);
        let (pairs, single) = of.as_chunks::<2>();
        for [(a, share), (b, other)] in pairs {
            add_shares(f, [*share, *other], [&groups[*a].forces[at..][..n], &groups[*b].forces[at..][..n]]);
        }
        for (a, share) in single {
            add_share(f, *share, &groups[*a].forces[at..][..n]);
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
fn put_both(to: &mut [f64], [a, b]: [&[f64]; 2], [u, v]: [&[f64]; 2]) {
    for ((((to, a), b), u), v) in to.iter_mut().zip(a).zip(b).zip(u).zip(v) {
        *to = a * u + b * v;
    }
}

#[inline(always)]
fn put_products(to: &mut [f64], a: &[f64], b: &[f64]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to = a * b;
    }
}

#[inline(always)]
fn add_products(to: &mut [f64], a: &[f64], b: &[f64]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to += a * b;
    }
}

#[inline(always)]
fn add_shares(to: &mut [f64], [u, v]: [f64; 2], [a, b]: [&[f64]; 2]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to += u * a + v * b;
    }
}

#[inline(always)]
fn add_share(to: &mut [f64], share: f64, of: &[f64]) {
    for (to, of) in to.iter_mut().zip(of) {
        *to += share * of;
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
