//! Derivatives of a loss by the numbers of linear links and of masses, summed over all ticks.
//!
//! With φ the adjoint of the force of a link, F = Σ c (α e + β w) gives c the adjoint φ(α e + β w): this takes the sums
//! of φe and φw. A mass moves by d' = P d + Q x + C f: with ν = C times the adjoint of d', it takes νd, νx and νd'.
//!
//! Several ticks are summed at once: eight links or masses stay in registers over all of them, since reading and
//! writing their sums in each tick takes longer than the tick. Only numbers that some parameter changes are summed.

use crate::parts::rows::Rows;
use pulp::Arch;
use std::ops::Range;

/// Links of a pass, with sums of products of the adjoints of their forces.
pub struct Links {
    pub of: Rows,
    /// Sums of φe and φw, each where some coefficient needs it.
    pub products: [Vec<f64>; 2],
    /// For implicit links, sums of φ times the change of elongation in the next tick.
    pub next_products: Vec<f64>,
    /// Sums of φ, where constant elongations need them.
    pub elongation_sums: Vec<f64>,
}

impl Links {
    /// Makes the sums for these changed coefficients and constant elongations; `None` where nothing changes.
    pub fn for_changes(of: Rows, coefficients: &[bool], elongations: bool) -> Option<Links> {
        let sums = |wanted: bool| vec![0.0; if wanted { of.n } else { 0 }];
        let each = || of.basis.0.iter().zip(coefficients).filter(|(_, wanted)| **wanted);
        let products = [0, 1].map(|k| sums(each().any(|(basis, _)| basis[k] != 0.0)));
        let elongation_sums = sums(elongations);
        (each().next().is_some() || elongations).then(|| Links {
            of,
            products,
            next_products: Vec::new(),
            elongation_sums,
        })
    }

    /// Makes all sums, for implicit links: k needs all three products, z and θ need φw and the one with the next tick.
    pub fn for_implicit(mut self) -> Links {
        let sums = || vec![0.0; self.of.n];
        (self.products, self.next_products) = ([sums(), sums()], sums());
        self
    }

    /// Adds some ticks of the links of rows whose first ends are among these slots.
    #[inline(always)]
    fn add(&mut self, ticks: &Seen, e0: &[f64], slots: &Range<usize>) {
        match self.products.each_ref().map(Vec::is_empty) {
            [false, true] => self.add_runs::<true, false>(ticks, e0, slots),
            [true, false] => self.add_runs::<false, true>(ticks, e0, slots),
            _ => self.add_runs::<true, true>(ticks, e0, slots),
        }
    }

    /// As `add`, with sums of φe (`E`) and of φw (`W`).
    #[inline(always)]
    fn add_runs<const E: bool, const W: bool>(&mut self, ticks: &Seen, e0: &[f64], slots: &Range<usize>) {
        let e0 = &e0[self.of.first..][..self.of.n];
        let mut from = 0;
        for row in 0..self.of.runs.len() {
            let (n, [a, b]) = self.of.runs[row];
            let mut i = slots.start.saturating_sub(a).next_multiple_of(LANES);
            while i < n && a + i < slots.end {
                if n < LANES {
                    for i in 0..n {
                        self.some::<1, E, W>(ticks, e0, [a + i, b + i], from + i, 0);
                    }
                } else {
                    // the last block begins earlier, so that it is whole
                    let at = i.min(n - LANES);
                    self.some::<LANES, E, W>(ticks, e0, [a + at, b + at], from + at, i - at);
                }
                i += LANES;
            }
            from += n;
        }
    }

    #[inline(always)]
    fn add_listed(&mut self, ticks: &Seen, e0: &[f64]) {
        let e0 = &e0[self.of.first..][..self.of.n];
        for i in 0..self.of.ends.len() {
            self.some::<1, true, true>(ticks, e0, self.of.ends[i].map(|m| m as usize), i, 0);
        }
    }

    /// Adds some ticks of `N` links of a row, from the one with these ends and index `at`, leaving out the first `but`.
    #[inline(always)]
    fn some<const N: usize, const E: bool, const W: bool>(
        &mut self,
        ticks: &Seen,
        e0: &[f64],
        [a, b]: [usize; 2],
        at: usize,
        but: usize,
    ) {
        let Some(e0) = lanes::<N>(e0, at) else { return };
        let [mut by_e, mut by_w] = [[0.0; N]; 2];
        for [now, _, adjoint] in ticks.each() {
            let (Some(oa), Some(ob)) = (lanes::<N>(adjoint, a), lanes::<N>(adjoint, b)) else { break };
            if E {
                let (Some(xa), Some(xb)) = (lanes::<N>(now, a), lanes::<N>(now, b)) else { break };
                for i in 0..N {
                    by_e[i] += (oa[i] - ob[i]) * (xb[i] - xa[i] + e0[i]);
                }
            }
            if W {
                let (Some(da), Some(db)) = (lanes::<N>(now, ticks.d + a), lanes::<N>(now, ticks.d + b)) else { break };
                for i in 0..N {
                    by_w[i] += (oa[i] - ob[i]) * (db[i] - da[i]);
                }
            }
        }
        let [to_e, to_w] = &mut self.products;
        put(to_e, at, by_e, but);
        put(to_w, at, by_w, but);
        if !self.elongation_sums.is_empty() {
            let mut elongation_sums = [0.0; N];
            for [_, _, adjoint] in ticks.each() {
                let (Some(oa), Some(ob)) = (lanes::<N>(adjoint, a), lanes::<N>(adjoint, b)) else { break };
                for i in 0..N {
                    elongation_sums[i] += oa[i] - ob[i];
                }
            }
            put(&mut self.elongation_sums, at, elongation_sums, but);
        }
        if !self.next_products.is_empty() {
            let mut ahead = [0.0; N];
            for [_, next, adjoint] in ticks.each() {
                let (Some(oa), Some(ob)) = (lanes::<N>(adjoint, a), lanes::<N>(adjoint, b)) else { break };
                let (Some(na), Some(nb)) = (lanes::<N>(next, ticks.d + a), lanes::<N>(next, ticks.d + b)) else {
                    break;
                };
                for i in 0..N {
                    ahead[i] += (oa[i] - ob[i]) * (nb[i] - na[i]);
                }
            }
            put(&mut self.next_products, at, ahead, but);
        }
    }
}

#[inline(always)]
fn lanes<const N: usize>(of: &[f64], at: usize) -> Option<&[f64; N]> {
    of.get(at..)?.first_chunk()
}

/// Adds numbers to sums, if there are any, except for the first `but`.
#[inline(always)]
fn put<const N: usize>(sums: &mut [f64], at: usize, by: [f64; N], but: usize) {
    if let Some(sums) = sums.get_mut(at..).and_then(|sums| sums.first_chunk_mut::<N>()) {
        let mut kept = [1.0; N];
        for first in kept.iter_mut().take(but) {
            *first = 0.0;
        }
        for i in 0..N {
            sums[i] += kept[i] * by[i];
        }
    }
}

/// Sums over masses: νd, νx and νd', each where some coefficient needs it.
pub struct Masses {
    pub sums: [Vec<f64>; 3],
}

impl Masses {
    /// Makes the sums for P, Q and C of `n` slots. C also needs the sum of P, and the sum of Q where some slot `has_q`.
    pub fn new(n: usize, [p, q, c]: [bool; 3], has_q: bool) -> Masses {
        let n = |wanted: bool| vec![0.0; if wanted { n } else { 0 }];
        Masses { sums: [n(p || c), n(q || (c && has_q)), n(c)] }
    }

    pub fn is_idle(&self) -> bool {
        self.sums.iter().all(Vec::is_empty)
    }

    #[inline(always)]
    fn add(&mut self, ticks: &Seen, slots: &Range<usize>) {
        let n = self.sums.iter().map(Vec::len).max().unwrap_or(0);
        let mut i = slots.start;
        while i < n && i < slots.end {
            if n < LANES {
                for i in 0..n {
                    self.some::<1>(ticks, i, 0);
                }
            } else {
                let at = i.min(n - LANES);
                self.some::<LANES>(ticks, at, i - at);
            }
            i += LANES;
        }
    }

    #[inline(always)]
    fn some<const N: usize>(&mut self, ticks: &Seen, at: usize, but: usize) {
        let [mut by_d, mut by_next] = [[0.0; N]; 2];
        for [now, next, adjoint] in ticks.each() {
            let Some(nu) = lanes::<N>(adjoint, at) else { break };
            let (Some(d), Some(next)) = (lanes::<N>(now, ticks.d + at), lanes::<N>(next, ticks.d + at)) else { break };
            for i in 0..N {
                by_d[i] += nu[i] * d[i];
                by_next[i] += nu[i] * next[i];
            }
        }
        let [to_d, to_x, to_next] = &mut self.sums;
        put(to_d, at, by_d, but);
        put(to_next, at, by_next, but);
        if !to_x.is_empty() {
            let mut by_x = [0.0; N];
            for [now, _, adjoint] in ticks.each() {
                let (Some(nu), Some(x)) = (lanes::<N>(adjoint, at), lanes::<N>(now, at)) else { break };
                for i in 0..N {
                    by_x[i] += nu[i] * x[i];
                }
            }
            put(to_x, at, by_x, but);
        }
    }
}

/// Block of slots that all sums process before the next, so that their rows stay in the nearest cache.
const SLOTS: usize = 64;
/// Ticks summed at once.
pub const TICKS: usize = 16;
/// Links or masses side by side.
const LANES: usize = 8;

/// Several consecutive ticks, each with the same count of numbers, so that offsets are computed once.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// Positions and motions, including those after the last tick (ticks + 1).
    pub rows: &'a [f64],
    /// Numbers per tick in `rows`, and the offset of motions.
    pub width: usize,
    pub d: usize,
    /// Adjoints of the forces on slots (ticks).
    pub adjoint: &'a [f64],
    /// Numbers per tick in `adjoint`.
    pub slots: usize,
}

impl<'a> Seen<'a> {
    /// Each tick: its positions and motions, those after it, and its adjoints.
    #[inline(always)]
    fn each(&self) -> impl Iterator<Item = [&'a [f64]; 3]> + use<'a> {
        let rows = self.rows.chunks_exact(self.width);
        let behind = rows.clone().skip(1);
        rows.zip(behind).zip(self.adjoint.chunks_exact(self.slots)).map(|((now, next), adjoint)| [now, next, adjoint])
    }
}

/// Sums some ticks with the widest vectors of this processor. All that it calls must be inlined, or it stays narrow.
pub struct Ticks<'a> {
    pub links: &'a mut [Links],
    pub masses: Option<&'a mut Masses>,
    pub seen: Seen<'a>,
    pub e0: &'a [f64],
}

impl Ticks<'_> {
    #[inline]
    pub fn add(self) {
        if !self.links.is_empty() || self.masses.is_some() {
            Arch::new().dispatch(self);
        }
    }
}

impl pulp::WithSimd for Ticks<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Ticks { links, mut masses, seen: ticks, e0 } = self;
        for first in (0..ticks.slots).step_by(SLOTS) {
            let slots = first..first + SLOTS;
            for l in links.iter_mut() {
                l.add(&ticks, e0, &slots);
            }
            if let Some(m) = &mut masses {
                m.add(&ticks, &slots);
            }
        }
        for l in links {
            l.add_listed(&ticks, e0);
        }
    }
}
