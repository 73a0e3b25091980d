//! Added forces ([`added`](super::added)) of many links or masses, computed by vectors over all slots.
//!
//! They are computed once for parameters that change numbers by multiples of one vector, as mass, pitch and decay do.

use crate::parts::record::Row;
use crate::parts::rows::Rows;
use ca_core::TANGENTS;
use ca_core::internal::numeric::Aligned;
use pulp::{Arch, Simd};

/// Factors of added forces (links or slots): of a link per e, per w and constant; of a mass per d, x, d'. Empty if 0.
pub type Terms = [Aligned; 3];

/// Added forces of several parameters, each with its own factor.
struct Group {
    shares: [f64; TANGENTS],
    /// Terms of links, by index of their list.
    links: Vec<(usize, Terms)>,
    masses: Terms,
    /// Buffer for the forces of a tick (slots).
    forces: Aligned,
}

/// Added forces of one parameter.
#[derive(Default)]
struct Own {
    /// Groups it belongs to, and its factor in each.
    shares: Vec<(usize, f64)>,
    /// Forces of each tick (slots); empty where it belongs to none.
    forces: Vec<Aligned>,
}

pub struct Groups {
    arch: Arch,
    /// Lists of links with their constant elongations, which are empty where all are 0.
    lists: Vec<(Rows, Aligned)>,
    all: Vec<Group>,
    of: [Own; TANGENTS],
    /// Buffer for forces of links.
    scratch: Aligned,
}

/// Returns the ratio of the numbers to `base`, if it is the same for all up to rounding.
fn multiple(of: &[f64], base: &[f64]) -> Option<f64> {
    let (v, b) = of.iter().zip(base).find(|(_, b)| **b != 0.0)?;
    let by = v / b;
    let near = |(v, b): (&f64, &f64)| (v - by * b).abs() <= 4.0 * f64::EPSILON * v.abs();
    of.iter().zip(base).all(near).then_some(by)
}

/// Returns base vectors, and the factor of each parameter whose terms are a multiple of that base.
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
    /// Terms of the links of a list, or of masses (`None`).
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
    pub fn new(lists: Vec<Rows>, e0: &[f64]) -> Groups {
        let scratch = Aligned::zeros(lists.iter().map(|l| l.n).max().unwrap_or(0));
        let with_own = |l: Rows| {
            let own = &e0[l.first..][..l.n];
            let any = own.iter().any(|v| *v != 0.0);
            let own = Aligned::from(if any { own } else { &[] });
            (l, own)
        };
        let lists = lists.into_iter().map(with_own).collect();
        Groups { arch: Arch::new(), lists, all: Vec::new(), of: Default::default(), scratch }
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

    /// Returns the group with these shares whose terms of this kind are free, adding one if there is none.
    fn with(&mut self, shares: [f64; TANGENTS], list: Option<usize>, kind: usize) -> usize {
        let free = |g: &mut Group| g.shares == shares && g.terms(list)[kind].is_empty();
        self.all.iter_mut().position(free).unwrap_or_else(|| {
            let (links, masses, forces) = (Vec::new(), Terms::default(), Aligned::default());
            self.all.push(Group { shares, links, masses, forces });
            self.all.len() - 1
        })
    }

    /// Allocates the forces of `ticks` ticks once all terms are put.
    pub fn begin(&mut self, ticks: usize, slots: usize) {
        for (k, group) in self.all.iter_mut().enumerate() {
            group.forces = Aligned::zeros(slots);
            for (of, share) in self.of.iter_mut().zip(group.shares).filter(|(_, share)| *share != 0.0) {
                of.shares.push((k, share));
                of.forces.resize_with(ticks, || Aligned::zeros(slots));
            }
        }
    }

    /// Computes the forces of tick `k`, with the widest vectors of this processor.
    pub fn measure(&mut self, k: usize, row: &Row, next: &[f64]) {
        if !self.all.is_empty() {
            let Groups { arch, lists, all: groups, scratch, of } = self;
            arch.dispatch(Tick { lists, groups, of, k, row, next, scratch });
        }
    }

    /// Swaps the forces of tick `k` into the derivatives by parameter `q`, whose forces are all 0; nothing is copied.
    pub fn give(&mut self, k: usize, q: usize, f: &mut Aligned) {
        if let Some(own) = self.of[q].forces.get_mut(k) {
            core::mem::swap(own, f);
        }
    }

    /// Adds the forces of tick `k` to the derivatives by parameter `q`.
    pub fn add(&self, k: usize, q: usize, f: &mut [f64]) {
        if let Some(own) = self.of[q].forces.get(k) {
            f.iter_mut().zip(own).for_each(|(f, own)| *f += own);
        }
    }
}

/// One tick, with the widest vectors of this processor; all that it calls must be inlined.
struct Tick<'a> {
    lists: &'a [(Rows, Aligned)],
    groups: &'a mut [Group],
    of: &'a mut [Own],
    k: usize,
    row: &'a Row<'a>,
    next: &'a [f64],
    scratch: &'a mut [f64],
}

impl pulp::WithSimd for Tick<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Tick { lists, groups, of, k, row, next, scratch } = self;
        let n = row.x.len();
        for Group { links: terms, masses: [by_d, by_x, by_next], forces, .. } in &mut *groups {
            let f = &mut forces[..n];
            match by_d.get(..n) {
                Some(by_d) => put_products(simd, f, [by_d, row.d]),
                None => f.fill(0.0),
            }
            for (by, of) in [(by_x, row.x), (by_next, next)] {
                if let Some(by) = by.get(..n) {
                    add_products(simd, f, [by, of]);
                }
            }
            for (list, [by_e, by_w, constant]) in &*terms {
                let (links, e0) = &lists[*list];
                let force = &mut scratch[..links.n];
                let mut from = 0;
                for (n, [a, b]) in &links.runs {
                    let force = &mut force[from..][..*n];
                    let x = [&row.x[*a..][..*n], &row.x[*b..][..*n]];
                    let d = [&row.d[*a..][..*n], &row.d[*b..][..*n]];
                    let own = from..from + n;
                    let e0 = e0.get(own.clone());
                    match (by_e.get(own.clone()), by_w.get(own.clone())) {
                        (Some(by_e), Some(by_w)) => {
                            elongations(simd, force, by_e, e0, x);
                            add_differences(simd, force, by_w, d);
                        }
                        (Some(by_e), None) => elongations(simd, force, by_e, e0, x),
                        (None, Some(by_w)) => differences(simd, force, by_w, d),
                        (None, None) => force.fill(0.0),
                    }
                    if let Some(constant) = constant.get(own) {
                        add(simd, force, constant);
                    }
                    pull(simd, f, [*a, *b], force);
                    from += n;
                }
                for (i, [a, b]) in links.ends.iter().enumerate() {
                    let (a, b) = (*a as usize, *b as usize);
                    let of = |by: &[f64], v: f64| by.get(i).map_or(0.0, |by| by * v);
                    let e = row.x[b] - row.x[a] + e0.get(i).unwrap_or(&0.0);
                    let force = of(by_e, e) + of(by_w, row.d[b] - row.d[a]) + of(constant, 1.0);
                    f[a] += force;
                    f[b] -= force;
                }
            }
        }
        for Own { shares, forces } in of {
            let Some(f) = forces.get_mut(k) else { continue };
            let (f, of) = (&mut f[..n], |(g, share): &(usize, f64)| (*share, &groups[*g].forces[..n]));
            let rest = match &shares[..] {
                [a, b, rest @ ..] => {
                    put_shares(simd, f, [of(a), of(b)]);
                    rest
                }
                [a, rest @ ..] => {
                    put_share(simd, f, of(a));
                    rest
                }
                [] => &[],
            };
            for one in rest {
                add_share(simd, f, of(one));
            }
        }
    }
}

/// Adds the forces of a run of links to first ends (from `a`) and subtracts them from second ends (from `b`).
#[inline(always)]
fn pull<S: Simd>(simd: S, f: &mut [f64], [a, b]: [usize; 2], force: &[f64]) {
    let (n, step) = (force.len(), b.saturating_sub(a));
    if b <= a || step >= n {
        add(simd, &mut f[a..][..n], force);
        subtract(simd, &mut f[b..][..n], force);
        return;
    }
    add(simd, &mut f[a..b], &force[..step]);
    add_between(simd, &mut f[b..][..n - step], [&force[step..], force]);
    subtract(simd, &mut f[a + n..][..step], &force[n - step..]);
}

/// Computes an array from its old values and other arrays by vectors. A loop over numbers would check in each tick
/// whether arrays overlap, and have a remainder.
macro_rules! each {
    ($simd:ident, $to:ident = $sum:expr; $($of:ident)*) => {{
        let n = $to.len();
        $(let $of = S::as_simd_f64s(&$of[..n]);)*
        let (vectors, last) = S::as_mut_simd_f64s($to);
        for (i, to) in vectors.iter_mut().enumerate() {
            $(let $of = $of.0[i];)*
            let $to = *to;
            *to = $sum;
        }
        if !last.is_empty() {
            $(let $of = $simd.partial_load_f64s($of.1);)*
            let $to = $simd.partial_load_f64s(last);
            $simd.partial_store_f64s(last, $sum);
        }
    }};
}

#[inline(always)]
fn elongations<S: Simd>(simd: S, to: &mut [f64], by: &[f64], e0: Option<&[f64]>, [a, b]: [&[f64]; 2]) {
    if let Some(e0) = e0 {
        each!(simd, to = { _ = to; simd.mul_f64s(by, simd.add_f64s(simd.sub_f64s(b, a), e0)) }; by a b e0);
    } else {
        differences(simd, to, by, [a, b]);
    }
}

#[inline(always)]
fn differences<S: Simd>(simd: S, to: &mut [f64], by: &[f64], [a, b]: [&[f64]; 2]) {
    each!(simd, to = { _ = to; simd.mul_f64s(by, simd.sub_f64s(b, a)) }; by a b);
}

#[inline(always)]
fn add_differences<S: Simd>(simd: S, to: &mut [f64], by: &[f64], [a, b]: [&[f64]; 2]) {
    each!(simd, to = simd.add_f64s(to, simd.mul_f64s(by, simd.sub_f64s(b, a))); by a b);
}

#[inline(always)]
fn put_products<S: Simd>(simd: S, to: &mut [f64], [a, b]: [&[f64]; 2]) {
    each!(simd, to = { _ = to; simd.mul_f64s(a, b) }; a b);
}

#[inline(always)]
fn add_products<S: Simd>(simd: S, to: &mut [f64], [a, b]: [&[f64]; 2]) {
    each!(simd, to = simd.add_f64s(to, simd.mul_f64s(a, b)); a b);
}

#[inline(always)]
fn put_share<S: Simd>(simd: S, to: &mut [f64], (share, of): (f64, &[f64])) {
    let share = simd.splat_f64s(share);
    each!(simd, to = { _ = to; simd.mul_f64s(share, of) }; of);
}

#[inline(always)]
fn add_share<S: Simd>(simd: S, to: &mut [f64], (share, of): (f64, &[f64])) {
    let share = simd.splat_f64s(share);
    each!(simd, to = simd.add_f64s(to, simd.mul_f64s(share, of)); of);
}

#[inline(always)]
fn put_shares<S: Simd>(simd: S, to: &mut [f64], [(u, a), (v, b)]: [(f64, &[f64]); 2]) {
    let [u, v] = [u, v].map(|share| simd.splat_f64s(share));
    each!(simd, to = { _ = to; simd.add_f64s(simd.mul_f64s(u, a), simd.mul_f64s(v, b)) }; a b);
}

#[inline(always)]
fn add<S: Simd>(simd: S, to: &mut [f64], by: &[f64]) {
    each!(simd, to = simd.add_f64s(to, by); by);
}

#[inline(always)]
fn subtract<S: Simd>(simd: S, to: &mut [f64], by: &[f64]) {
    each!(simd, to = simd.sub_f64s(to, by); by);
}

/// Adds where the second end of one link is the first end of another.
#[inline(always)]
fn add_between<S: Simd>(simd: S, to: &mut [f64], [next, last]: [&[f64]; 2]) {
    each!(simd, to = simd.add_f64s(to, simd.sub_f64s(next, last)); next last);
}
