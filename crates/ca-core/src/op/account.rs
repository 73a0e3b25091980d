//! Energy of the links of a batch around a tick, for the ledger: stored energy and heat, one block of links at a time.
//!
//! Elongations, laws and sums are separate loops over a block, so that all three vectorise. Link by link, through the
//! function pointers of a law, the ledger of a string took twenty times its tick. Sums run in eight lanes, which rounds
//! less than one running sum and is the same for vectors of any width.
//!
//! Laws are called link by link if their method keeps the energy in memory, or if they measure in space.

use super::layout::{Account, Layout, MeasureKind};
use super::links::measure;
use super::wide;
use crate::law::{Lost, Phi, Stored};
use crate::numeric::{Precision, Real, Table};
use crate::state::State;
use crate::state::ledger::{BLOCK, Block, LedgerScratch};
use core::marker::PhantomData;
use pulp::{Simd, WithSimd};

/// Largest number of coefficients of a link whose energies a method computes.
const COEFS: usize = 8;

pub(super) const LANES: usize = 8;
/// Eight partial sums.
pub type Lanes<O = f64> = [O; LANES];

/// Energy functions of a law.
#[derive(Clone, Copy)]
pub struct Energies<R: Real = f64> {
    /// see [`Phi::stored`]
    pub stored: Stored<R>,
    /// see [`Phi::lost`]
    pub lost: Lost<R>,
    /// the potential at an elongation \[J\], if `stored` is an auxiliary variable that only follows it
    potential: Option<Potential<R>>,
    /// both for a block; none if the method keeps the energies
    block: Option<ByBlock<R>>,
}

type Potential<R = f64> = fn(&[R], R) -> R;

type ByBlock<R = f64> = fn(&Links<R>, Elongations<R>, &mut [Block<R>; 2]);

impl<R: Real> Energies<R> {
    /// Makes the functions of a [`Phi`].
    pub const fn of<P: Phi<C, M> + 'static, const C: usize, const M: usize>() -> Energies<R> {
        Energies {
            stored: |c, mem, tables, e0, e1| P::stored(&numbers(c), &numbers(mem), tables, e0, e1),
            lost: |c, mem, tables, e| P::lost(&numbers(c), &numbers(mem), tables, e),
            potential: None,
            // a dual number fills a vector by itself, so blocks would gain nothing
            block: if matches!(R::PRECISION, Precision::Dual) {
                None
            } else {
                Some(|links, e, out| {
                    wide::plain(links.layout, ByLaw::<R, P, C, M> { links, e, out, law: PhantomData });
                })
            },
        }
    }

    /// Makes the functions of a method that keeps its energies.
    pub(crate) const fn kept(stored: Stored<R>, lost: Lost<R>) -> Energies<R> {
        Energies { stored, lost, potential: None, block: None }
    }

    /// Makes the functions of a method whose stored energy is a number that only follows the potential.
    pub(crate) const fn followed(stored: Stored<R>, lost: Lost<R>, potential: Potential<R>) -> Energies<R> {
        Energies { stored, lost, potential: Some(potential), block: None }
    }
}

#[inline(always)]
pub(crate) fn numbers<T: Copy + Default, const N: usize>(s: &[T]) -> [T; N] {
    s.first_chunk::<N>().copied().unwrap_or([T::default(); N])
}

/// A block of links of an account.
#[derive(Clone, Copy)]
pub struct Links<'a, R: Real> {
    layout: &'a Layout<R>,
    s: &'a State<R>,
    account: &'a Account<R>,
    /// first link, and number of links
    from: usize,
    n: usize,
}

impl<'a, R: Real> Links<'a, R> {
    #[inline(always)]
    fn column(&self, k: usize) -> &'a [R] {
        let a = self.account;
        &self.s.coef[a.coef + k * a.n + self.from..][..self.n]
    }

    #[inline(always)]
    fn memory(&self) -> &'a [R] {
        let a = self.account;
        &self.s.links.mem[a.mem + self.from * a.law.mem..][..self.n * a.law.mem]
    }

    fn tables(&self) -> &'a [Table<R>] {
        &self.layout.tables
    }
}

struct ByLaw<'a, R: Real, P, const C: usize, const M: usize> {
    links: &'a Links<'a, R>,
    e: Elongations<'a, R>,
    out: &'a mut [Block<R>; 2],
    law: PhantomData<P>,
}

/// Source of the elongations before, at and after the tick.
#[derive(Clone, Copy)]
pub enum Elongations<'a, R: Real> {
    /// measured before
    Measured(&'a [Block<R>; 3]),
    /// computed where used, for a row whose first link has these ends, from the motion into the tick
    Row([usize; 2], &'a [R]),
}

impl<R: Real, P: Phi<C, M>, const C: usize, const M: usize> WithSimd for ByLaw<'_, R, P, C, M> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Links { layout, s, account: a, from, n } = *self.links;
        let columns: [&[R]; C] = core::array::from_fn(|k| self.links.column(k));
        let [stored, lost] = self.out.each_mut().map(|o| &mut o[..n.min(BLOCK)]);
        match self.e {
            Elongations::Measured(e) => {
                let [before, at, after] = e.each_ref().map(|e| &e[..n.min(BLOCK)]);
                let (tables, memory) = (self.links.tables(), self.links.memory());
                each::<R, P, C, M>(tables, columns, memory, stored, lost, |i| [before[i], at[i], after[i]]);
            }
            Elongations::Row([p, q], d0) => {
                let e0 = &layout.links.e0[a.first + from..][..n];
                let [x, d, d0] = [&s.x[..], &s.d[..], d0].map(|v| [&v[p..][..n], &v[q..][..n]]);
                each::<R, P, C, M>(self.links.tables(), columns, &[], stored, lost, |i| {
                    let after = x[1][i] - x[0][i] + e0[i];
                    let at = after - (d[1][i] - d[0][i]);
                    [at - (d0[1][i] - d0[0][i]), at, after]
                });
            }
        }
    }
}

#[inline(always)]
fn each<R: Real, P: Phi<C, M>, const C: usize, const M: usize>(
    tables: &[Table<R>],
    columns: [&[R]; C],
    memory: &[R],
    stored: &mut [R],
    lost: &mut [R],
    e: impl Fn(usize) -> [R; 3],
) {
    let n = stored.len();
    let (columns, lost) = (columns.map(|c| &c[..n]), &mut lost[..n]);
    for i in 0..n {
        let c = core::array::from_fn(|k| columns[k][i]);
        // laws without memory must avoid a bounds check, which would prevent vectorisation
        let mem = if M == 0 { [R::ZERO; M] } else { numbers(&memory[i * M..]) };
        let e = e(i);
        stored[i] = P::stored(&c, &mem, tables, e[1], e[2]);
        lost[i] = P::lost(&c, &mem, tables, e);
    }
}

/// Entries written for each link of an account: stored energy, heat, and energy made by the scheme \[J\].
pub struct Entries<'a, R: Real> {
    /// energy stored at the last tick; not used for linear links
    pub stored: &'a mut [R::Outer],
    /// heat so far
    pub lost: &'a mut [R::Outer],
    /// energy made so far
    pub error: &'a mut [R::Outer],
}

/// Sums over links \[J\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums<R: Real = f64> {
    /// stored energy
    pub stored: R::Outer,
    /// heat of the tick
    pub heat: R::Outer,
    /// energy made in the tick
    pub error: R::Outer,
    /// energy of auxiliary variables outside of the range that their potentials had in the tick
    pub strayed: f64,
}

/// The state before the tick that is entered.
#[derive(Clone, Copy)]
pub struct Before<'a, R: Real> {
    /// positions at the tick; none if no tick has passed, and only the stored energy has changed
    pub x: Option<&'a [R]>,
    /// motion into the tick
    pub d: &'a [R],
}

impl<'a, R: Real> Before<'a, R> {
    /// Returns the present state, in which no tick has passed.
    pub fn now(s: &'a State<R>) -> Before<'a, R> {
        Before { x: None, d: &s.d }
    }
}

/// Enters an account.
pub struct Enter<'a, R: Real> {
    /// arrays that the passes read
    pub layout: &'a Layout<R>,
    /// the state after the tick
    pub s: &'a State<R>,
    /// state before the tick
    pub before: Before<'a, R>,
    /// links to enter
    pub account: &'a Account<R>,
    /// destination
    pub entries: Entries<'a, R>,
    /// working memory
    pub scratch: &'a mut LedgerScratch<R>,
}

impl<R: Real> WithSimd for Enter<'_, R> {
    type Output = Sums<R>;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Sums<R> {
        let Enter { layout, s, before: was, account, entries, scratch } = self;
        let tick = was.x.is_some();
        let (mut sums, mut from) = (Sums::default(), 0);
        let LedgerScratch { e, moved, out, .. } = scratch;
        let [mut stored_all, mut lost]: [Lanes<R::Outer>; 2] = [Lanes::<R::Outer>::default(); 2];
        while from < account.n {
            let [first, second] = account.rows;
            let (row, end) = match from {
                _ if from < first.len => (Some(first.ends.map(|m| m + from)), first.len),
                _ if from - first.len < second.len => {
                    (Some(second.ends.map(|m| m + from - first.len)), first.len + second.len)
                }
                _ => (None, account.n),
            };
            let n = BLOCK.min(end - from);
            let links = Links { layout, s, account, from, n };
            match (account.fns.energies.block, row) {
                // a linear law needs no more than the elongations
                (Some(block), Some(ends)) if account.linear => block(&links, Elongations::Row(ends, was.d), out),
                (block, _) => {
                    elongations(&links, was, e, moved);
                    match block {
                        Some(block) => block(&links, Elongations::Measured(e), out),
                        None => sums.strayed += one_by_one(&links, e, out),
                    }
                }
            }
            let range = from..from + n;
            let [stored, heat] = out.each_ref().map(|o| &o[..n]);
            if !account.linear {
                let (error, before) = (&mut entries.error[range.clone()], &mut entries.stored[range.clone()]);
                for i in 0..n {
                    let now = stored[i].outer();
                    if tick {
                        let work = (-s.links.tap[account.tap + from + i] * R::of(0.5) * moved[i]).outer();
                        let made = now - before[i] + work + heat[i].outer();
                        error[i] += made;
                        sums.error += made;
                    }
                    before[i] = now;
                }
            }
            add(&mut stored_all, stored);
            if tick {
                entries.lost[range].iter_mut().zip(heat).for_each(|(lost, heat)| *lost += heat.outer());
                add(&mut lost, heat);
            }
            from += n;
        }
        Sums { stored: stored_all.iter().sum(), heat: lost.iter().sum(), ..sums }
    }
}

/// Enters links one by one, and returns the energy of auxiliary variables outside of their range \[J\].
fn one_by_one<R: Real>(links: &Links<R>, e: &[Block<R>; 3], [stored, lost]: &mut [Block<R>; 2]) -> f64 {
    let a = links.account;
    let mut scratch = [R::ZERO; COEFS];
    let c = a.law.coefs.min(COEFS);
    let mut strayed = 0.0;
    for i in 0..links.n {
        scratch.iter_mut().enumerate().take(c).for_each(|(k, v)| *v = links.column(k)[i]);
        let mem = &links.memory()[i * a.law.mem..][..a.law.mem];
        let around = [e[0][i], e[1][i], e[2][i]];
        stored[i] = (a.fns.energies.stored)(&scratch[..c], mem, links.tables(), around[1], around[2]);
        lost[i] = (a.fns.energies.lost)(&scratch[..c], mem, links.tables(), around);
        if let Some(potential) = a.fns.energies.potential {
            let [stored, at, after] =
                [stored[i], potential(&scratch[..c], e[1][i]), potential(&scratch[..c], e[2][i])].map(R::wide);
            strayed += (stored - at.max(after)).max(at.min(after) - stored).max(0.0);
        }
    }
    strayed
}

/// Computes elongations before, at and after the tick, and the motion of the ends along the force over both intervals.
#[inline(always)]
fn elongations<R: Real>(links: &Links<R>, was: Before<R>, e: &mut [Block<R>; 3], moved: &mut Block<R>) {
    let Links { layout, s, account: a, from, n } = *links;
    if a.ports.measure != MeasureKind::Line || a.ports.onto.is_some() {
        return measured(links, was, e, moved);
    }
    let (e0, n) = (&layout.links.e0[a.first + from..][..n], n.min(BLOCK));
    let [before, at, after] = e.each_mut().map(|e| &mut e[..n]);
    let ends = &layout.links.ends[a.first + from..][..n];
    let (x, d) = (&s.x[..], &s.d[..]);
    for i in 0..n {
        let [p, q] = ends[i].map(|m| m as usize);
        after[i] = x[q] - x[p] + e0[i];
        at[i] = after[i] - (d[q] - d[p]);
        before[i] = at[i] - (was.d[q] - was.d[p]);
    }
    if !a.linear {
        for i in 0..n {
            moved[i] = after[i] - before[i];
        }
    }
}

#[inline(always)]
fn measured<R: Real>(links: &Links<R>, was: Before<R>, e: &mut [Block<R>; 3], moved: &mut Block<R>) {
    let Links { layout, account: a, from, n, .. } = *links;
    let n = n.min(BLOCK);
    let e0 = &layout.links.e0[a.first + from..][..n];
    for e in e.iter_mut() {
        e[..n].copy_from_slice(e0);
    }
    moved[..n].fill(R::ZERO);
    port(links, was, (a.ports.measure, &layout.links.ends, a.first, a.ports.reach), e, moved);
    if let Some((measure, first, reach)) = a.ports.onto {
        port(links, was, (measure, &layout.links.onto, first, reach), e, moved);
    }
}

/// Adds one port of each link. The tuple is its kind, all ends, its first end and its first entry of `reach`.
#[inline(always)]
fn port<R: Real>(
    links: &Links<R>,
    was: Before<R>,
    (kind, ends, first, reach): (MeasureKind, &[[u32; 2]], usize, usize),
    e: &mut [Block<R>; 3],
    moved: &mut Block<R>,
) {
    let Links { layout, s, from, n, .. } = *links;
    let n = n.min(BLOCK);
    let (ends, none) = (&ends[first + from..][..n], [[R::ZERO; 4]; BLOCK]);
    let reach = if kind == MeasureKind::Line { &none[..n] } else { &layout.links.reach[reach + from..][..n] };
    let [before, at, after] = e.each_mut().map(|e| &mut e[..n]);
    // one loop per measure, without a branch inside; a closure would not be compiled for the vectors of the machine
    macro_rules! each {
        ($kind:expr) => {
            for i in 0..n {
                let (part, along) = measure::around($kind, (&s.x, &s.d), was, ends[i], &reach[i]);
                before[i] += part[0];
                at[i] += part[1];
                after[i] += part[2];
                moved[i] += along;
            }
        };
    }
    match kind {
        MeasureKind::Line => each!(MeasureKind::Line),
        MeasureKind::Along => each!(MeasureKind::Along),
        MeasureKind::Radial => each!(MeasureKind::Radial),
    }
}

/// Adds numbers to eight partial sums, so that the total does not depend on the width of a vector.
#[inline(always)]
pub(crate) fn add<R: Real>(lanes: &mut Lanes<R::Outer>, all: &[R]) {
    let mut sums = *lanes;
    let (whole, rest) = all.as_chunks::<LANES>();
    for eight in whole {
        for k in 0..LANES {
            sums[k] += eight[k].outer();
        }
    }
    for (sum, v) in sums.iter_mut().zip(rest) {
        *sum += v.outer();
    }
    *lanes = sums;
}
