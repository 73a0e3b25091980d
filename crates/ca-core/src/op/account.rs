//! Account: what the links of a batch store and lose around a tick, for the ledger, a block of links at a time.
//!
//! Decides that elongations, laws and sums are each a loop of their own over a block, so that all three run in vectors: link
//! by link, through the pointers of a law, the ledger of a string took twenty times its tick. Sums are made by halves, which
//! rounds less than one after the other and is the same for vectors of any width. A law whose method keeps its energy in
//! memory is asked link by link, and so is one that measures in space: there the square roots are what takes time.

use super::layout::{Account, Layout, MeasureKind};
use super::links::measure;
use super::wide;
use crate::law::{Lost, Phi, Stored};
use crate::numeric::{Precision, Real, Table};
use crate::state::State;
use crate::state::ledger::{BLOCK, Block, Room};
use core::marker::PhantomData;
use pulp::{Simd, WithSimd};

/// Most coefficients of a link whose energies are kept by a method.
const COEFS: usize = 8;

/// Sums side by side.
pub(super) const LANES: usize = 8;
/// Eight of them.
pub type Lanes<O = f64> = [O; LANES];

/// The energies of a law.
#[derive(Clone, Copy)]
pub struct Energies<R: Real = f64> {
    /// see [`Phi::stored`]
    pub stored: Stored<R>,
    /// see [`Phi::lost`]
    pub lost: Lost<R>,
    /// both for a block; none where a method keeps them by its own account
    block: Option<ByBlock<R>>,
}

type ByBlock<R = f64> = fn(&Links<R>, Elongations<R>, &mut [Block<R>; 2]);

impl<R: Real> Energies<R> {
    /// Those of a [`Phi`].
    pub const fn of<P: Phi<C, M> + 'static, const C: usize, const M: usize>() -> Energies<R> {
        Energies {
            stored: |c, mem, tables, e0, e1| P::stored(&numbers(c), &numbers(mem), tables, e0, e1),
            lost: |c, mem, tables, e| P::lost(&numbers(c), &numbers(mem), tables, e),
            // a number and its derivatives fill a vector by themselves, so that blocks would gain nothing: link by link
            block: if matches!(R::PRECISION, Precision::Dual) {
                None
            } else {
                Some(|links, e, out| {
                    wide::plain(links.layout, ByLaw::<R, P, C, M> { links, e, out, law: PhantomData });
                })
            },
        }
    }

    /// Those a method keeps.
    pub(crate) const fn kept(stored: Stored<R>, lost: Lost<R>) -> Energies<R> {
        Energies { stored, lost, block: None }
    }
}

/// The first numbers of a slice.
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
    /// the first, and how many
    from: usize,
    n: usize,
}

impl<'a, R: Real> Links<'a, R> {
    /// One column of their coefficients.
    #[inline(always)]
    fn column(&self, k: usize) -> &'a [R] {
        let a = self.account;
        &self.s.coef[a.coef + k * a.n + self.from..][..self.n]
    }

    /// Their memory, one link after the other.
    #[inline(always)]
    fn memory(&self) -> &'a [R] {
        let a = self.account;
        &self.s.links.mem[a.mem + self.from * a.law.mem..][..self.n * a.law.mem]
    }

    fn tables(&self) -> &'a [Table<R>] {
        &self.layout.tables
    }
}

/// The energies of a block by a law, from elongations that were measured, or from the two ends of a row.
struct ByLaw<'a, R: Real, P, const C: usize, const M: usize> {
    links: &'a Links<'a, R>,
    e: Elongations<'a, R>,
    out: &'a mut [Block<R>; 2],
    law: PhantomData<P>,
}

/// Where elongations before, at and after the tick come from.
#[derive(Clone, Copy)]
pub enum Elongations<'a, R: Real> {
    /// they were measured
    Measured(&'a [Block<R>; 3]),
    /// of a row whose first link has these ends, from the motion into the tick: measured where they are used, which saves
    /// to write and read them
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

/// The law for each of some links.
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
        // laws without memory must not carry a bounds check that keeps the loop from being vectorised
        let mem = if M == 0 { [R::ZERO; M] } else { numbers(&memory[i * M..]) };
        let e = e(i);
        stored[i] = P::stored(&c, &mem, tables, e[1], e[2]);
        lost[i] = P::lost(&c, &mem, tables, e);
    }
}

/// What is written for each link of an account: what it stores, what it has lost, and what the scheme made in it \[J\].
pub struct Entries<'a, R: Real> {
    /// stored at the last tick; of linear links nobody asks for it
    pub stored: &'a mut [R::Outer],
    /// heat so far
    pub lost: &'a mut [R::Outer],
    /// made so far
    pub error: &'a mut [R::Outer],
}

/// Sums over links \[J\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums<R: Real = f64> {
    /// stored
    pub stored: R::Outer,
    /// heat of the tick
    pub heat: R::Outer,
    /// made in the tick
    pub error: R::Outer,
}

/// Enters an account: `d0` is the motion into the tick; `tick` says whether a tick has passed, or only what is stored has
/// changed.
pub struct Enter<'a, R: Real> {
    /// what passes read
    pub layout: &'a Layout<R>,
    /// the state after the tick
    pub s: &'a State<R>,
    /// its motion before
    pub d0: &'a [R],
    /// which links
    pub account: &'a Account<R>,
    /// whether heat and work are entered too
    pub tick: bool,
    /// where it is written
    pub entries: Entries<'a, R>,
    /// numbers in passing
    pub room: &'a mut Room<R>,
}

impl<R: Real> WithSimd for Enter<'_, R> {
    type Output = Sums<R>;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Sums<R> {
        let Enter { layout, s, d0, account, tick, entries, room } = self;
        let (mut sums, mut from) = (Sums::default(), 0);
        let Room { e, moved, out, .. } = room;
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
                // the law is linear, so that it asks for no more
                (Some(block), Some(ends)) if account.linear => block(&links, Elongations::Row(ends, d0), out),
                (block, _) => {
                    elongations(&links, d0, e, moved);
                    match block {
                        Some(block) => block(&links, Elongations::Measured(e), out),
                        None => one_by_one(&links, e, out),
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

/// Link by link, by the functions of the law.
fn one_by_one<R: Real>(links: &Links<R>, e: &[Block<R>; 3], [stored, lost]: &mut [Block<R>; 2]) {
    let a = links.account;
    let mut room = [R::ZERO; COEFS];
    let c = a.law.coefs.min(COEFS);
    for i in 0..links.n {
        room.iter_mut().enumerate().take(c).for_each(|(k, v)| *v = links.column(k)[i]);
        let mem = &links.memory()[i * a.law.mem..][..a.law.mem];
        let around = [e[0][i], e[1][i], e[2][i]];
        stored[i] = (a.fns.energies.stored)(&room[..c], mem, links.tables(), around[1], around[2]);
        lost[i] = (a.fns.energies.lost)(&room[..c], mem, links.tables(), around);
    }
}

/// Elongations of a block before, at and after the tick, and how far its ends `moved` along their force in the two ticks
/// together.
#[inline(always)]
fn elongations<R: Real>(links: &Links<R>, d0: &[R], e: &mut [Block<R>; 3], moved: &mut Block<R>) {
    let Links { layout, s, account: a, from, n } = *links;
    if a.ports.measure != MeasureKind::Line || a.ports.onto.is_some() {
        return measured(links, d0, e, moved);
    }
    let (e0, n) = (&layout.links.e0[a.first + from..][..n], n.min(BLOCK));
    let [before, at, after] = e.each_mut().map(|e| &mut e[..n]);
    let ends = &layout.links.ends[a.first + from..][..n];
    let (x, d) = (&s.x[..], &s.d[..]);
    for i in 0..n {
        let [p, q] = ends[i].map(|m| m as usize);
        after[i] = x[q] - x[p] + e0[i];
        at[i] = after[i] - (d[q] - d[p]);
        before[i] = at[i] - (d0[q] - d0[p]);
    }
    if !a.linear {
        for i in 0..n {
            moved[i] = after[i] - before[i];
        }
    }
}

/// The same of links that measure in space or at two ports.
#[inline(always)]
fn measured<R: Real>(links: &Links<R>, d0: &[R], e: &mut [Block<R>; 3], moved: &mut Block<R>) {
    let Links { layout, account: a, from, n, .. } = *links;
    let n = n.min(BLOCK);
    let e0 = &layout.links.e0[a.first + from..][..n];
    for e in e.iter_mut() {
        e[..n].copy_from_slice(e0);
    }
    moved[..n].fill(R::ZERO);
    port(links, d0, (a.ports.measure, &layout.links.ends, a.first, a.ports.reach), e, moved);
    if let Some((measure, first, reach)) = a.ports.onto {
        port(links, d0, (measure, &layout.links.onto, first, reach), e, moved);
    }
}

/// Adds what one port of each link measures: the measure, all ends, the first of its own, the first of its reach.
#[inline(always)]
fn port<R: Real>(
    links: &Links<R>,
    d0: &[R],
    (kind, ends, first, reach): (MeasureKind, &[[u32; 2]], usize, usize),
    e: &mut [Block<R>; 3],
    moved: &mut Block<R>,
) {
    let Links { layout, s, from, n, .. } = *links;
    let n = n.min(BLOCK);
    let (ends, none) = (&ends[first + from..][..n], [[R::ZERO; 4]; BLOCK]);
    let reach = if kind == MeasureKind::Line { &none[..n] } else { &layout.links.reach[reach + from..][..n] };
    let [before, at, after] = e.each_mut().map(|e| &mut e[..n]);
    // a loop for each, so that none asks which it is; a closure would not be compiled for the vectors of the machine
    macro_rules! each {
        ($kind:expr) => {
            for i in 0..n {
                let (part, along) = measure::around($kind, &s.x, &s.d, d0, ends[i], &reach[i]);
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

/// Adds numbers to eight sums side by side, so that the total is the same whatever the width of a vector.
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
