//! The energy ledger: energy stored, lost and received, and the error of the scheme, per module, every tick.
//!
//! The ledger follows the exact discrete identity of the scheme (docs/numerics.md §2); it is not an estimate. For
//! linear modules it balances to rounding, so the residual tests the engine. For any other link the difference goes to
//! a separate account, which names the module that makes energy.
//!
//! Sample n is entered at the beginning of tick n+1, before changes, when x_{n+1} of the ports is known too. A scene
//! without a ledger contains none of these passes and arrays, and does not test for them.

use super::account::{Before, Enter, Entries, LANES, Lanes, Sums};
use super::layout::{Account, Layout, MovingPoint};
use super::links::pair_set;
use super::wide::plain as vectors;
use super::{Op, wave};
use crate::numeric::{Real, VerletList};
use crate::op::layout::Counts;
use crate::state::State;
use crate::state::ledger::{Exchange, Ledger};
use pulp::{Simd, WithSimd};

/// Returns an empty ledger for a layout.
pub fn empty_ledger<R: Real>(layout: &Layout<R>) -> Ledger<R> {
    let Counts { n_mat, n_lia, .. } = layout.counts;
    let (points, tgr) = (layout.places.moving_points.len(), layout.ports.tgr.len());
    let ports = layout.ports.enx.len() + tgr + layout.ports.enf.len();
    let accounts = layout.ledger.as_ref().map_or(0, |l| l.accounts.len());
    Ledger {
        lost: alloc::vec![R::Outer::ZERO; n_lia],
        scheme_error: alloc::vec![R::Outer::ZERO; n_lia],
        stored: alloc::vec![R::Outer::ZERO; n_lia],
        x0: alloc::vec![R::ZERO; n_mat],
        d0: alloc::vec![R::ZERO; n_mat],
        port: alloc::vec![R::Outer::ZERO; ports],
        work: alloc::vec![R::Outer::ZERO; ports],
        hands: alloc::vec![Exchange::default(); tgr],
        points: alloc::vec![[R::ZERO; 2]; points],
        stored_batches: alloc::vec![R::Outer::ZERO; accounts],
        mass: alloc::vec![R::Outer::ZERO; n_mat],
        ..Ledger::default()
    }
}

/// Energy of the MATs and of weight between the last two ticks \[J\].
#[derive(Default)]
struct MatEnergy<R: Real = f64> {
    kinetic: R::Outer,
    stored: R::Outer,
    /// heat of the last tick
    heat: R::Outer,
}

struct Mats<'a, R: Real> {
    layout: &'a Layout<R>,
    s: &'a State<R>,
    d0: &'a [R],
    mass: &'a [R::Outer],
}

impl<R: Real> WithSimd for Mats<'_, R> {
    type Output = MatEnergy<R>;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> MatEnergy<R> {
        let Mats { layout, s, d0, mass } = self;
        let n = layout.counts.n_mat;
        // eight partial sums each, as in [`super::account::add`], without storing the summands
        let mut sums = [Lanes::<R::Outer>::default(); 3];
        let of = |x: R, d: R, d0: R, p: R, q: R, m: R::Outer| {
            let [x, d, d0, p, q] = [x, d, d0, p, q].map(R::outer);
            let (z, moved) = (R::Outer::of(0.25) * (R::Outer::of(1.0) - p), d + d0);
            [
                R::Outer::of(0.5) * d * d * m,
                (R::Outer::of(-0.5) * q * x * (x - d) - z * d * d) * m,
                z * moved * moved * m,
            ]
        };
        let (p, q) = (s.coef[..n].as_chunks::<LANES>(), s.coef[n..][..n].as_chunks::<LANES>());
        let (x, d) = (s.x[..n].as_chunks::<LANES>(), s.d[..n].as_chunks::<LANES>());
        let (d0, m) = (d0[..n].as_chunks::<LANES>(), mass[..n].as_chunks::<LANES>());
        let whole = x.0.iter().zip(d.0).zip(d0.0).zip(p.0).zip(q.0).zip(m.0);
        for (((((x, d), d0), p), q), m) in whole {
            for k in 0..LANES {
                let [kinetic, stored, heat] = of(x[k], d[k], d0[k], p[k], q[k], m[k]);
                sums[0][k] += kinetic;
                sums[1][k] += stored;
                sums[2][k] += heat;
            }
        }
        let rest = x.1.iter().zip(d.1).zip(d0.1).zip(p.1).zip(q.1).zip(m.1);
        for ((((((x, d), d0), p), q), m), k) in rest.zip(0..LANES) {
            let all = of(*x, *d, *d0, *p, *q, *m);
            (0..3).for_each(|i| sums[i][k] += all[i]);
        }
        let [kinetic, stored, heat] = sums.map(|all| all.iter().sum());
        MatEnergy { kinetic, stored, heat }
    }
}

fn weigh<R: Real>(layout: &Layout<R>, s: &State<R>, mass: &mut [R::Outer]) {
    for (m, c) in mass.iter_mut().zip(&s.coef[2 * layout.counts.n_mat..]) {
        *m = if *c == R::ZERO { R::Outer::ZERO } else { R::Outer::of(1.0) / c.outer() };
    }
    // the inertia of a modal mass is in its modes
    layout.places.solved_modal.iter().for_each(|h| mass[h.mat as usize] = R::Outer::ZERO);
}

fn mats<R: Real>(layout: &Layout<R>, s: &State<R>, d0: &[R], mass: &[R::Outer]) -> MatEnergy<R> {
    let mut all = vectors(layout, Mats { layout, s, d0, mass });
    let weight = layout.ledger.as_ref().map_or(0, |l| l.weight);
    for (k, m) in layout.weighed.iter().enumerate() {
        let (x, d) = (s.x[*m as usize].outer(), s.d[*m as usize].outer());
        all.stored -= s.coef[weight + k].outer() * (x - R::Outer::of(0.5) * d);
    }
    all
}

/// Enters the energy of the links of a batch, and after a `tick` their heat and the energy they made.
fn links<R: Real>(
    layout: &Layout<R>,
    s: &State<R>,
    near: &mut [VerletList],
    before: Before<R>,
    l: &mut Ledger<R>,
    account: &Account<R>,
) -> Sums<R> {
    let range = account.first..account.first + account.n;
    let [stored, lost, error] = [&mut l.stored, &mut l.lost, &mut l.scheme_error].map(|of| &mut of[range.clone()]);
    let Some(at) = account.ports.pair_set else {
        let (entries, scratch) = (Entries { stored, lost, error }, &mut *l.scratch);
        return vectors(layout, Enter { layout, s, before, account, entries, scratch });
    };
    let (d0, tick) = (before.d, before.x.is_some());
    let Entry { stored: now, heat, work } = set(layout, s, &mut near[at], d0, account, at);
    let [heat, made] = if tick { [heat, now - stored[0] + work + heat] } else { [R::Outer::ZERO; 2] };
    stored[0] = now;
    lost[0] += heat;
    error[0] += made;
    Sums { stored: now, heat, error: made, strayed: 0.0 }
}

fn all_links<R: Real>(
    layout: &Layout<R>,
    s: &State<R>,
    near: &mut [VerletList],
    before: Before<R>,
    l: &mut Ledger<R>,
) -> Sums<R> {
    let mut all = Sums::default();
    for (k, account) in layout.ledger.iter().flat_map(|p| &p.accounts).enumerate() {
        let sums = links(layout, s, near, before, l, account);
        l.stored_batches[k] = sums.stored;
        all.stored += sums.stored;
        all.heat += sums.heat;
        all.error += sums.error;
        all.strayed += sums.strayed;
    }
    all
}

/// Stored energy of a set after a tick, its heat in the tick, and the work of its forces on its members.
struct Entry<R: Real = f64> {
    stored: R::Outer,
    heat: R::Outer,
    work: R::Outer,
}

/// Computes all pairs of a set together. Their work is the sum over the forces on the members.
fn set<R: Real>(
    layout: &Layout<R>,
    s: &State<R>,
    near: &mut VerletList,
    d0: &[R],
    a: &Account<R>,
    at: usize,
) -> Entry<R> {
    let (mut stored, mut heat) = (R::Outer::ZERO, R::Outer::ZERO);
    let c = &s.coef[a.coef..][..a.law.coefs];
    let (of, tables) = (a.fns.energies, &layout.tables);
    pair_set::for_each_contact(layout, s, near, d0, at, (a.fns.idle)(c), |e| {
        stored += (of.stored)(c, &[], tables, e[1], e[2]).outer();
        heat += (of.lost)(c, &[], tables, e).outer();
    });
    let pushed = layout.links.pair_sets[at].members.iter().zip(s.links.tap[a.tap..].chunks(3));
    let moved = |i: usize| R::of(0.5) * (s.d[i] + d0[i]);
    let work = pushed.map(|(m, f)| (0..3).map(|k| (f[k] * moved(*m as usize + k)).outer()).sum::<R::Outer>()).sum();
    Entry { stored, heat, work }
}

/// Enters the energy at load and returns it.
fn load<R: Real>(layout: &Layout<R>, s: &State<R>, near: &mut [VerletList], l: &mut Ledger<R>) -> R::Outer {
    weigh(layout, s, &mut l.mass);
    let MatEnergy { kinetic, stored, .. } = mats(layout, s, &s.d, &l.mass);
    (l.kinetic, l.stored_mats) = (kinetic, kinetic + stored);
    l.stored_mats + wave::energy(layout, s, &s.d).0 + all_links(layout, s, near, Before::now(s), l).stored
}

/// Returns the energy that changes added. It computes only modules that may change.
fn changes<R: Real>(layout: &Layout<R>, s: &State<R>, near: &mut [VerletList], l: &mut Ledger<R>) -> R::Outer {
    let Some(plan) = &layout.ledger else { return R::Outer::ZERO };
    let mut came = R::Outer::ZERO;
    if plan.live {
        weigh(layout, s, &mut l.mass);
        let MatEnergy { kinetic, stored, .. } = mats(layout, s, &s.d, &l.mass);
        came += kinetic + stored - l.stored_mats;
        (l.kinetic, l.stored_mats) = (kinetic, kinetic + stored);
    }
    for (k, account) in plan.accounts.iter().enumerate().filter(|a| a.1.live) {
        let Sums { stored, .. } = links(layout, s, near, Before::now(s), l, account);
        came += stored - l.stored_batches[k];
        l.stored_batches[k] = stored;
    }
    came
}

/// Enters the tick that has just been completed by reading the inputs of the next.
pub fn ledger<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some(mut l) = s.ledger.take() else { return };
    let mut near = core::mem::take(&mut s.links.near);
    l.turning = s.ramps.is_moving();
    for (at, p) in l.points.iter_mut().zip(&layout.places.moving_points) {
        *at = [&s.x, &s.d].map(|v| v[p.mat as usize]);
    }
    if s.tick == 0 || !l.begun {
        l.begun = true;
        l.h0 = load(layout, s, &mut near, &mut l);
        s.links.near = near;
        l.h = l.h0;
        l.extremes.peak = l.h0.wide().abs().max(l.kinetic.wide());
        l.extremes.received = l.extremes.peak;
        s.ledger = Some(l);
        return;
    }
    let before = l.h;
    let mut work = core::mem::take(&mut l.pulled);
    l.pointer += work;
    let moved = |m: u32, d0: &[R]| R::Outer::of(0.5) * (s.d[m as usize] + d0[m as usize]).outer();
    for (k, p) in layout.ports.enx.iter().chain(&layout.ports.tgr).enumerate() {
        let w = -l.port[k] * moved(p.mat, &l.d0);
        l.work[k] += w;
        work += w;
    }
    for (k, p) in (layout.ports.enx.len() + layout.ports.tgr.len()..).zip(&layout.ports.enf) {
        let w = l.port[k] * moved(p.mat, &l.d0);
        l.work[k] += w;
        work += w;
    }
    if let (Some(group), Some(slow)) = (&layout.rates.slow, &s.slow) {
        let each = group.ports.iter().zip(&slow.ports).take(group.coupled);
        let w: R::Outer = each.clone().map(|(p, b)| R::Outer::of(-b.force) * moved(p.at, &l.d0)).sum();
        work += w;
        l.crossed += w;
        if s.tick == 1 {
            // the part of this work before the pose of load belongs to the energy at load
            let before: R::Outer = each.map(|(p, b)| R::Outer::of(-b.force * 0.5) * l.d0[p.at as usize].outer()).sum();
            l.crossed -= before;
            l.h0 += before;
        }
    }
    if s.tick == 1 {
        let given: R::Outer = l.start_force.iter().zip(0..).map(|(f, m)| f.outer() * moved(m, &l.d0)).sum();
        l.changed += given;
        work += given;
    }
    let MatEnergy { kinetic, stored, heat } = mats(layout, s, &l.d0, &l.mass);
    let (waves, beside) = wave::energy(layout, s, &l.d0);
    (l.kinetic, l.stored_mats) = (kinetic, kinetic + stored);
    l.lost_mats += heat + beside;
    let [x0, d0] = [core::mem::take(&mut l.x0), core::mem::take(&mut l.d0)];
    let of_links = all_links(layout, s, &mut near, Before { x: Some(&x0), d: &d0 }, &mut l);
    (l.x0, l.d0) = (x0, d0);
    let lost = heat + beside + of_links.heat;
    let h = l.stored_mats + waves + of_links.stored;
    l.h = h;
    l.extremes.strayed = l.extremes.strayed.max(of_links.strayed);
    l.extremes.worst = l.extremes.worst.max((h - before - work + lost - of_links.error).wide().abs());
    l.heat += lost.wide().abs();
    l.net_heat += lost.wide();
    l.made += of_links.error.wide();
    // kinetic energy may come from an equally negative potential
    let [h, kinetic] = [h.wide(), kinetic.wide()];
    l.extremes.peak = l.extremes.peak.max(h.abs().max(kinetic) + l.heat);
    l.extremes.received = l.extremes.received.max(h.max(kinetic) + l.net_heat - l.made - l.groups.border.wide());
    s.links.near = near;
    s.ledger = Some(l);
}

/// Enters the energy added by changes of parameters or of moving points. Does nothing if neither moved in this tick.
pub fn ledger_changes<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let at = |p: &MovingPoint| [&s.x, &s.d].map(|v| v[p.mat as usize]);
    let moved = |l: &Ledger<R>| l.turning || !layout.places.moving_points.iter().map(at).eq(l.points.iter().copied());
    if !s.ledger.as_deref().is_some_and(moved) {
        return;
    }
    let Some(mut l) = s.ledger.take() else { return };
    let mut near = core::mem::take(&mut s.links.near);
    let came = changes(layout, s, &mut near, &mut l);
    s.links.near = near;
    l.changed += came;
    l.h += came;
    s.ledger = Some(l);
}

/// Stores what the next tick overwrites, at the end of the forces.
pub fn store_forces<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some(l) = &mut s.ledger else { return };
    l.x0.copy_from_slice(&s.x);
    l.d0.copy_from_slice(&s.d);
    for (k, p) in layout.ports.enx.iter().chain(&layout.ports.tgr).enumerate() {
        l.port[k] = s.f[p.mat as usize].outer();
    }
    for (k, p) in (layout.ports.enx.len() + layout.ports.tgr.len()..).zip(&layout.ports.enf) {
        let v = s.input[p.input as usize];
        l.port[k] = R::Outer::of(if v.is_finite() { v } else { 0.0 });
    }
}
