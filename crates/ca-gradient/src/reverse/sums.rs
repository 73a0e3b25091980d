//! Sums: what a loss owes to the numbers of linear links and of masses, summed over all ticks.
//!
//! With φ what it owes to the force of a link, F = Σ c (α e + β w) makes it owe φ(α e + β w) to c: the sums of φe and of φw are
//! all that is kept. A mass moves by d' = P d + Q x + C f, so that with ν, which is C times what the loss owes to d', the
//! sums of νd, νx and νd' are. Decides to sum over rows of links as over whole vectors, since no other part takes as long; and only
//! what some parameter changes.

use crate::reverse::parts::Basis;
use ca_core::Scene;
use ca_core::op::{Band, Op};
use ca_core::state::Fold;
use pulp::Arch;

/// What is owed to the force of the links of a pass, and its products.
pub struct Links {
    /// what its law is made of
    pub basis: Basis,
    /// rows of links: how many, and the slots of the two ends of the first; none where ends are looked up
    rows: Vec<(usize, [usize; 2])>,
    /// index of its first coefficient, and of its first constant elongation
    pub coef: usize,
    pub first: usize,
    /// links
    pub n: usize,
    /// slots of the ends of links that are in no row
    ends: Vec<[u32; 2]>,
    /// sums of φe and φw, where a coefficient is to have its due
    pub products: [Vec<f64>; 2],
    /// of implicit links, sums of φ with the change of elongation in the tick that follows
    pub ahead: Vec<f64>,
    /// sums of φ, where a constant elongation is
    pub alone: Vec<f64>,
}

impl Links {
    /// Those of a pass that sums forces.
    pub fn listed(scene: &Scene, op: &Op, basis: &Basis) -> Links {
        let (rows, ends) = match op.form.stride {
            0 => (Vec::new(), scene.layout.ends[op.first..][..op.n].to_vec()),
            stride => (vec![(op.n, [op.mat, op.mat + stride])], Vec::new()),
        };
        Links { ends, ..Links::new(basis, op.n, rows, (op.coef, op.first)) }
    }

    /// Those of a pass that integrates, along it and across.
    pub fn row(op: &Op, basis: &Basis) -> Vec<Links> {
        let (n, at, coefs) = (op.n, op.mat, basis.0.len());
        if !op.form.folded {
            return vec![Links::new(basis, n, vec![(n, [at, at + 1])], (op.coef, op.first))];
        }
        // of the last vectors the neighbours stand in the next lane, at the beginning; behind the last lane there is no link
        let folded = |step: usize, at_numbers: (usize, usize)| {
            let rows = vec![(n - step, [at, at + step]), (step, [at + n - step, at + 1])];
            Links::new(basis, n, rows, at_numbers)
        };
        let along = folded(Fold::LANES, (op.coef, op.first));
        let Band::Along(width) = op.form.band else { return vec![along] };
        vec![along, folded(width * Fold::LANES, (op.coef + coefs * n, op.first + n))]
    }

    fn new(basis: &Basis, n: usize, rows: Vec<(usize, [usize; 2])>, (coef, first): (usize, usize)) -> Links {
        let (products, ahead, alone) = Default::default();
        Links { basis: basis.clone(), rows, coef, first, n, ends: Vec::new(), products, ahead, alone }
    }

    /// Sums what some parameter changes.
    pub fn want(&mut self, coefficients: bool, elongations: bool) {
        let n = |wanted: bool| if wanted { self.n } else { 0 };
        self.products = [vec![0.0; n(coefficients)], vec![0.0; n(coefficients)]];
        self.alone = vec![0.0; n(elongations)];
    }

    /// The same of links that are solved for.
    pub fn want_ahead(&mut self) {
        self.ahead = vec![0.0; self.products[0].len()];
    }

    /// True where nothing is summed.
    pub fn is_idle(&self) -> bool {
        self.products[0].is_empty() && self.alone.is_empty()
    }

    /// Adds a tick: `owed` to the force on each slot, places and motions at it.
    #[inline(always)]
    fn add(&mut self, owed: &[f64], x: &[f64], [d, next]: [&[f64]; 2], e0: &[f64]) {
        let e0 = &e0[self.first..][..self.n];
        let [by_e, by_w] = &mut self.products;
        let (products, alone) = (!by_e.is_empty(), !self.alone.is_empty());
        let ahead = &mut self.ahead;
        let mut from = 0;
        for (n, [a, b]) in &self.rows {
            let (a, b, some) = (*a..*a + n, *b..*b + n, from..from + n);
            let phi = [&owed[a.clone()], &owed[b.clone()]];
            if products {
                if !ahead.is_empty() {
                    for (i, sum) in ahead[some.clone()].iter_mut().enumerate() {
                        *sum += (phi[0][i] - phi[1][i]) * (next[b.start + i] - next[a.start + i]);
                    }
                }
                let ends = [&x[a.clone()], &x[b.clone()], &d[a], &d[b]];
                row(phi, ends, &e0[some.clone()], [&mut by_e[some.clone()], &mut by_w[some.clone()]]);
            }
            if alone {
                differences(phi, &mut self.alone[some]);
            }
            from += n;
        }
        for (i, [a, b]) in self.ends.iter().enumerate() {
            let (a, b) = (*a as usize, *b as usize);
            let phi = owed[a] - owed[b];
            if products {
                by_e[i] += phi * (x[b] - x[a] + e0[i]);
                by_w[i] += phi * (d[b] - d[a]);
                if let Some(sum) = ahead.get_mut(i) {
                    *sum += phi * (next[b] - next[a]);
                }
            }
            if alone {
                self.alone[i] += phi;
            }
        }
    }
}

/// A row of links; a function of its own, so that the compiler knows that what is written is none of what is read.
#[inline(always)]
fn row([oa, ob]: [&[f64]; 2], [xa, xb, da, db]: [&[f64]; 4], e0: &[f64], [by_e, by_w]: [&mut [f64]; 2]) {
    let n = by_e.len();
    let (oa, ob, xa, xb, da, db) = (&oa[..n], &ob[..n], &xa[..n], &xb[..n], &da[..n], &db[..n]);
    let (e0, by_w) = (&e0[..n], &mut by_w[..n]);
    for i in 0..n {
        let phi = oa[i] - ob[i];
        by_e[i] += phi * (xb[i] - xa[i] + e0[i]);
        by_w[i] += phi * (db[i] - da[i]);
    }
}

#[inline(always)]
fn differences([a, b]: [&[f64]; 2], sums: &mut [f64]) {
    for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
        *sum += a - b;
    }
}

/// Sums of masses: νd, νx and νd', each where a coefficient is to have its due.
pub struct Masses {
    pub sums: [Vec<f64>; 3],
}

impl Masses {
    /// Of so many slots, those of P, Q and C that are wanted.
    pub fn new(n: usize, [p, q, c]: [bool; 3]) -> Masses {
        let n = |wanted: bool| vec![0.0; if wanted { n } else { 0 }];
        // that of C takes the others
        Masses { sums: [n(p || c), n(q || c), n(c)] }
    }

    /// True where nothing is summed.
    pub fn is_idle(&self) -> bool {
        self.sums.iter().all(Vec::is_empty)
    }

    /// Adds a tick: ν, then d, x and d' of all slots.
    #[inline(always)]
    fn add(&mut self, nu: &[f64], d: &[f64], x: &[f64], next: &[f64]) {
        let [by_d, by_x, by_next] = &mut self.sums;
        let n = nu.len();
        if by_d.len() == n && by_x.len() == n && by_next.len() == n {
            masses(nu, [d, x, next], [by_d, by_x, by_next]);
            return;
        }
        if by_d.len() == n {
            products(nu, d, by_d);
        }
        if by_x.len() == n {
            products(nu, x, by_x);
        }
    }
}

/// All three; a function of its own, so that the compiler knows that what is written is none of what is read.
#[inline(always)]
fn masses(nu: &[f64], [d, x, next]: [&[f64]; 3], [by_d, by_x, by_next]: [&mut [f64]; 3]) {
    let n = nu.len();
    let (d, x, next) = (&d[..n], &x[..n], &next[..n]);
    let (by_d, by_x, by_next) = (&mut by_d[..n], &mut by_x[..n], &mut by_next[..n]);
    for i in 0..n {
        by_d[i] += nu[i] * d[i];
        by_x[i] += nu[i] * x[i];
        by_next[i] += nu[i] * next[i];
    }
}

#[inline(always)]
fn products(nu: &[f64], of: &[f64], sums: &mut [f64]) {
    let n = nu.len();
    let (of, sums) = (&of[..n], &mut sums[..n]);
    for i in 0..n {
        sums[i] += nu[i] * of[i];
    }
}

/// One tick, of links and of masses, with the widest vectors of this processor. Everything it calls must be inlined into it, or it
/// stays narrow.
pub struct Tick<'a> {
    /// links, each list with what is owed to the force on each slot
    pub links: &'a mut [Links],
    pub masses: Option<&'a mut Masses>,
    /// what is owed to the forces on slots
    pub owed: &'a [f64],
    pub x: &'a [f64],
    pub d: &'a [f64],
    /// motions behind the tick
    pub next: &'a [f64],
    pub e0: &'a [f64],
}

impl Tick<'_> {
    /// Adds it to all sums.
    #[inline]
    pub fn add(self) {
        if !self.links.is_empty() || self.masses.is_some() {
            Arch::new().dispatch(self);
        }
    }
}

impl pulp::WithSimd for Tick<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for l in self.links {
            l.add(self.owed, self.x, [self.d, self.next], self.e0);
        }
        if let Some(m) = self.masses {
            m.add(self.owed, self.d, self.x, self.next);
        }
    }
}
