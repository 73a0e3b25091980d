//! The energy ledger: what is stored, lost and received, and the error of the scheme, per module, every tick.
//!
//! Decides to keep the exact discrete identity of the scheme (docs/numerics.md §2) rather than an estimate: for linear
//! modules the ledgers balance to rounding, so the residual is a test of the engine; for any other link the difference
//! is its own account, which names the module that makes energy. Sample n is entered when x_{n+1} is known of ports too,
//! that is at the beginning of tick n+1, before changes. A scene that does not ask has no pass, array or test of this.

use super::layout::{Account, Layout, MeasureKind};
use super::links::{measure, pair_set};
use super::{Op, wave};
use crate::numeric::{Real, VerletList, wide};
use crate::state::{Ledger, State};

/// Link `i` of a batch around the tick being entered, where `d0` is the motion into that tick: its elongations before,
/// at and after, and how far its ends moved along its force in the two ticks together.
fn elongations(layout: &Layout, s: &State, d0: &[Real], a: &Account, i: usize) -> ([Real; 3], Real) {
    if a.ports.measure == MeasureKind::Line && a.ports.onto.is_none() {
        let [p, q] = layout.ends[a.first + i].map(|m| m as usize);
        let after = s.x[q] - s.x[p] + layout.e0[a.first + i];
        let at = after - (s.d[q] - s.d[p]);
        let e = [at - (d0[q] - d0[p]), at, after];
        return (e, e[2] - e[0]);
    }
    let (mut e, mut moved) = ([layout.e0[a.first + i]; 3], 0.0);
    for (measure, ends, reach) in measure::ports(layout, &a.ports, a.first, i) {
        let (part, along) = measure::around(measure, &s.x, &s.d, d0, ends, &reach);
        (0..3).for_each(|k| e[k] += part[k]);
        moved += along;
    }
    (e, moved)
}

/// Coefficients of link `i`, gathered from their columns into `room`.
fn coefs<'r>(s: &State, room: &'r mut [Real], a: &Account, i: usize) -> &'r [Real] {
    for (k, c) in room.iter_mut().enumerate().take(a.coefs) {
        *c = s.coef[a.coef + k * a.n + i];
    }
    &room[..a.coefs]
}

/// Energy of the MATs and of weight between the last two ticks: (kinetic, stored, heat of that tick).
fn mats(layout: &Layout, s: &State, d0: &[Real]) -> (f64, f64, f64) {
    let n = layout.n_mat;
    let (mut kinetic, mut stored, mut lost) = (0.0, 0.0, 0.0);
    for (i, d0) in d0.iter().enumerate() {
        let [p, q, c] = [i, n + i, 2 * n + i].map(|k| wide(s.coef[k]));
        if c == 0.0 {
            continue;
        }
        let [x, d, d0] = [s.x[i], s.d[i], *d0].map(wide);
        kinetic += 0.5 * d * d / c;
        let z = (1.0 - p) / c;
        stored += 0.5 * (-q / c) * x * (x - d) - 0.25 * z * d * d;
        lost += 0.25 * z * (d + d0) * (d + d0);
    }
    let weight = layout.ledger.as_ref().map_or(0, |l| l.weight);
    for (k, m) in layout.weighed.iter().enumerate() {
        let (x, d) = (wide(s.x[*m as usize]), wide(s.d[*m as usize]));
        stored -= wide(s.coef[weight + k]) * (x - 0.5 * d);
    }
    (kinetic, stored, lost)
}

/// What a link holds after the tick being entered, its heat in that tick, and the work of its force on its ends.
struct Entry {
    stored: f64,
    heat: f64,
    work: f64,
}

/// Visits every link: its batch, its number in the ledger and its energies.
fn links(
    layout: &Layout,
    s: &State,
    near: &mut [VerletList],
    room: &mut [Real],
    d0: &[Real],
    mut visit: impl FnMut(&Account, usize, Entry),
) {
    for a in layout.ledger.iter().flat_map(|p| &p.accounts) {
        if let Some(at) = a.ports.pair_set {
            visit(a, a.first, set(layout, s, &mut near[at], coefs(s, room, a, 0), d0, a, at));
            continue;
        }
        for i in 0..a.n {
            let c = coefs(s, room, a, i);
            let (e, moved) = elongations(layout, s, d0, a, i);
            let mem = &s.mem[a.mem + i * a.mems..][..a.mems];
            let stored = wide((a.stored)(c, mem, &layout.tables, e[1], e[2]));
            let heat = wide((a.lost)(c, mem, &layout.tables, e));
            let work = if a.linear { 0.0 } else { wide(-s.tap[a.tap + i] * 0.5 * moved) };
            visit(a, a.first + i, Entry { stored, heat, work });
        }
    }
}

/// All pairs of a set together; its work is that of what it did to each of its members.
fn set(layout: &Layout, s: &State, near: &mut VerletList, c: &[Real], d0: &[Real], a: &Account, at: usize) -> Entry {
    let (mut stored, mut heat) = (0.0, 0.0);
    pair_set::touched(layout, s, near, d0, at, (a.idle)(c), |e| {
        stored += wide((a.stored)(c, &[], &layout.tables, e[1], e[2]));
        heat += wide((a.lost)(c, &[], &layout.tables, e));
    });
    let pushed = layout.pair_sets[at].members.iter().zip(s.tap[a.tap..].chunks(3));
    let moved = |i: usize| 0.5 * (s.d[i] + d0[i]);
    let work = pushed.map(|(m, f)| (0..3).map(|k| wide(f[k] * moved(*m as usize + k))).sum::<f64>()).sum();
    Entry { stored, heat, work }
}

/// Recomputes what everything holds with the present coefficients; returns the total.
fn store(layout: &Layout, s: &State, near: &mut [VerletList], l: &mut Ledger) -> f64 {
    let (kinetic, mut h, _) = mats(layout, s, &s.d);
    l.kinetic = kinetic;
    h += kinetic + wave::energy(layout, s, &s.d).0;
    links(layout, s, near, &mut l.room, &s.d, |_, k, entry| {
        l.stored[k] = entry.stored;
        h += entry.stored;
    });
    h
}

/// Records the tick that has just been completed by reading the inputs of the next.
pub fn ledger(_op: &Op, layout: &Layout, s: &mut State) {
    let Some(mut l) = s.ledger.take() else { return };
    let mut near = core::mem::take(&mut s.near);
    if s.tick == 0 {
        l.h0 = store(layout, s, &mut near, &mut l);
        s.near = near;
        l.h = l.h0;
        l.peak = l.h0.abs();
        s.ledger = Some(l);
        return;
    }
    let before = l.h;
    let (mut work, mut lost, mut scheme_error) = (0.0, 0.0, 0.0);
    let moved = |m: u32, d0: &[Real]| 0.5 * wide(s.d[m as usize] + d0[m as usize]);
    for (k, p) in layout.enx.iter().chain(&layout.tgr).enumerate() {
        let w = -l.port[k] * moved(p.mat, &l.d0);
        l.work[k] += w;
        work += w;
    }
    for (k, p) in (layout.enx.len() + layout.tgr.len()..).zip(&layout.enf) {
        let w = l.port[k] * moved(p.mat, &l.d0);
        l.work[k] += w;
        work += w;
    }
    if s.tick == 1 {
        let given: f64 = l.kick.iter().zip(0..).map(|(f, m)| wide(*f) * moved(m, &l.d0)).sum();
        l.changed += given;
        work += given;
    }
    let (kinetic, mut h, heat) = mats(layout, s, &l.d0);
    let (waves, beside) = wave::energy(layout, s, &l.d0);
    l.kinetic = kinetic;
    l.lost_mats += heat + beside;
    lost += heat + beside;
    h += kinetic + waves;
    links(layout, s, &mut near, &mut l.room, &l.d0, |a, k, Entry { stored, heat, work }| {
        if !a.linear {
            let error = stored - l.stored[k] + work + heat;
            l.scheme_error[k] += error;
            scheme_error += error;
        }
        l.stored[k] = stored;
        l.lost[k] += heat;
        lost += heat;
        h += stored;
    });
    l.h = h;
    l.worst = l.worst.max((h - before - work + lost - scheme_error).abs());
    l.heat += lost.abs();
    l.peak = l.peak.max(h.abs() + l.heat);
    s.near = near;
    s.ledger = Some(l);
}

/// After changes of parameters or of moving points: what they brought in.
pub fn ledger_changes(_op: &Op, layout: &Layout, s: &mut State) {
    let Some(mut l) = s.ledger.take() else { return };
    let mut near = core::mem::take(&mut s.near);
    let h = store(layout, s, &mut near, &mut l);
    s.near = near;
    l.changed += h - l.h;
    l.h = h;
    s.ledger = Some(l);
}

/// At the end of the forces: keeps what the next tick overwrites.
pub fn keep(_op: &Op, layout: &Layout, s: &mut State) {
    let Some(l) = &mut s.ledger else { return };
    l.d0.copy_from_slice(&s.d);
    for (k, p) in layout.enx.iter().chain(&layout.tgr).enumerate() {
        l.port[k] = wide(s.f[p.mat as usize]);
    }
    for (k, p) in (layout.enx.len() + layout.tgr.len()..).zip(&layout.enf) {
        let v = s.input[p.input as usize];
        l.port[k] = if v.is_finite() { v } else { 0.0 };
    }
}
