//! The energy book: what is held, lost, received and made, per module, every tick.
//!
//! Decides to keep the exact discrete identity of the scheme (numerics 2) rather than an estimate: for linear modules
//! the books close to rounding, so the residual is a test of the engine; for any other link the difference is its own
//! account, which names the module that makes energy. Sample n is booked when x_{n+1} is known of ports too, that is
//! at the beginning of tick n+1, before changes. A scene that does not ask has no pass, array or test of this.

use crate::op::Op;
use crate::scene::Scene;
use crate::state::State;
use alloc::vec::Vec;

/// Where the ledger finds the links of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LedgerPlan {
    /// for each op of [`Scene::forces`], the first of its links in the ledger's arrays
    pub first: Vec<usize>,
    /// for each weighed MAT, its coefficient
    pub weight: usize,
}

/// The accounts \[J\]. `h = h0 + work − lost + source + changed + residual`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    /// energy at load
    pub h0: f64,
    /// energy now, between the last tick and the one before
    pub h: f64,
    /// its part in motion
    pub kinetic: f64,
    /// largest |h| + Σ|lost| so far, the scale of the residual
    pub peak: f64,
    /// heat of MATs with dampers of their own
    pub lost_mats: f64,
    /// heat of each link (n_lia)
    pub lost: Vec<f64>,
    /// energy made (+) or swallowed (−) by the scheme in each link (n_lia); 0 for linear ones
    pub source: Vec<f64>,
    /// work received from each port: position ports, device ports, force ports
    pub work: Vec<f64>,
    /// energy that came in by changing parameters or moving interaction points
    pub changed: f64,
    /// largest imbalance of a single tick
    pub worst: f64,
    /// d of the tick being booked (n_mat)
    d0: Vec<f64>,
    /// force on position and device ports, force given by force ports (ports)
    port: Vec<f64>,
    /// energy held by each link at the last booking (n_lia)
    held: Vec<f64>,
}

/// Sums of the books, for people.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// energy at load \[J\]
    pub h0: f64,
    /// energy now \[J\]
    pub h: f64,
    /// heat \[J\]
    pub lost: f64,
    /// made by non-linear links \[J\]
    pub source: f64,
    /// received from ports \[J\]
    pub work: f64,
    /// received by changes \[J\]
    pub changed: f64,
    /// what does not add up \[J\]
    pub residual: f64,
    /// scale of the residual \[J\]
    pub peak: f64,
}

impl Ledger {
    /// An empty book for `n_mat` MATs, `n_lia` links and `ports` ports.
    pub(crate) fn new(n_mat: usize, n_lia: usize, ports: usize) -> Ledger {
        Ledger {
            lost: alloc::vec![0.0; n_lia],
            source: alloc::vec![0.0; n_lia],
            held: alloc::vec![0.0; n_lia],
            d0: alloc::vec![0.0; n_mat],
            port: alloc::vec![0.0; ports],
            work: alloc::vec![0.0; ports],
            ..Ledger::default()
        }
    }

    /// The sums.
    pub fn balance(&self) -> Balance {
        let (lost, source) = (self.lost_mats + self.lost.iter().sum::<f64>(), self.source.iter().sum::<f64>());
        let work = self.work.iter().sum::<f64>();
        let residual = self.h - self.h0 - work + lost - source - self.changed;
        Balance { h0: self.h0, h: self.h, lost, source, work, changed: self.changed, residual, peak: self.peak }
    }

    /// The link that made the most energy, with its account; `None` where none made any.
    pub fn culprit(&self) -> Option<(usize, f64)> {
        let (i, s) = self.source.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
        (*s > 0.0).then_some((i, *s))
    }
}

/// Elongations of link `i` of `op` before, at and after the tick being booked, where `d0` is the motion into that tick.
fn elongations(scene: &Scene, s: &State, d0: &[f64], op: &Op, i: usize) -> [f64; 3] {
    let [a, b] = scene.ends[op.first + i].map(|m| m as usize);
    let after = s.x[b] - s.x[a] + scene.e0[op.first + i];
    let at = after - (s.d[b] - s.d[a]);
    [at - (d0[b] - d0[a]), at, after]
}

/// Coefficients of link `i` of `op`, gathered from their columns. Eight is more than any law has.
fn coefs(s: &State, op: &Op, i: usize, out: &mut [f64; 8]) -> usize {
    let n = op.law.map_or(0, |l| l.coefs);
    for (k, c) in out[..n].iter_mut().enumerate() {
        *c = s.coef[op.coef + k * op.n + i];
    }
    n
}

/// Energy of the MATs and of weight between the last two ticks: (kinetic, held, heat of the tick booked).
fn mats(scene: &Scene, s: &State, d0: &[f64]) -> (f64, f64, f64) {
    let n = scene.n_mat;
    let (mut kinetic, mut held, mut lost) = (0.0, 0.0, 0.0);
    for i in 0..n {
        let (p, q, c) = (s.coef[i], s.coef[n + i], s.coef[2 * n + i]);
        if c == 0.0 {
            continue;
        }
        let (x, d) = (s.x[i], s.d[i]);
        kinetic += 0.5 * d * d / c;
        let z = (1.0 - p) / c;
        held += 0.5 * (-q / c) * x * (x - d) - 0.25 * z * d * d;
        lost += 0.25 * z * (d + d0[i]) * (d + d0[i]);
    }
    let weight = scene.ledger.as_ref().map_or(0, |l| l.weight);
    for (k, m) in scene.weighed.iter().enumerate() {
        let (x, d) = (s.x[*m as usize], s.d[*m as usize]);
        held -= s.coef[weight + k] * (x - 0.5 * d);
    }
    (kinetic, held, lost)
}

/// Visits every link: number in the ledger, op, position.
fn links(scene: &Scene, mut visit: impl FnMut(usize, &Op, usize)) {
    let Some(plan) = &scene.ledger else { return };
    for (op, first) in scene.forces.iter().zip(&plan.first) {
        if op.law.is_some() {
            (0..op.n).for_each(|i| visit(first + i, op, i));
        }
    }
}

/// Recomputes what everything holds with the present coefficients; returns the total.
fn hold(scene: &Scene, s: &State, l: &mut Ledger) -> f64 {
    let (kinetic, mut h, _) = mats(scene, s, &s.d);
    l.kinetic = kinetic;
    h += kinetic;
    links(scene, |k, op, i| {
        let Some(law) = op.law else { return };
        let mut c = [0.0; 8];
        let n = coefs(s, op, i, &mut c);
        let e = elongations(scene, s, &s.d, op, i);
        l.held[k] = (law.stored)(&c[..n], &s.mem[op.mem + i * law.mem..][..law.mem], &scene.tables, e[1], e[2]);
        h += l.held[k];
    });
    h
}

/// Books the tick that has just been completed by reading the inputs of the next.
pub fn book(_op: &Op, scene: &Scene, s: &mut State) {
    let Some(mut l) = s.ledger.take() else { return };
    if s.tick == 0 {
        l.h0 = hold(scene, s, &mut l);
        l.h = l.h0;
        l.peak = l.h0.abs();
        s.ledger = Some(l);
        return;
    }
    let before = l.h;
    let (mut work, mut lost, mut source) = (0.0, 0.0, 0.0);
    let moved = |m: u32, d0: &[f64]| 0.5 * (s.d[m as usize] + d0[m as usize]);
    for (k, p) in scene.enx.iter().chain(&scene.tgr).enumerate() {
        let w = -l.port[k] * moved(p.mat, &l.d0);
        l.work[k] += w;
        work += w;
    }
    for (k, p) in (scene.enx.len() + scene.tgr.len()..).zip(&scene.enf) {
        let w = l.port[k] * moved(p.mat, &l.d0);
        l.work[k] += w;
        work += w;
    }
    let (kinetic, mut h, heat) = mats(scene, s, &l.d0);
    l.kinetic = kinetic;
    l.lost_mats += heat;
    lost += heat;
    h += kinetic;
    links(scene, |k, op, i| {
        let Some(law) = op.law else { return };
        let mut c = [0.0; 8];
        let n = coefs(s, op, i, &mut c);
        let e = elongations(scene, s, &l.d0, op, i);
        let mem = &s.mem[op.mem + i * law.mem..][..law.mem];
        let held = (law.stored)(&c[..n], mem, &scene.tables, e[1], e[2]);
        let heat = (law.lost)(&c[..n], mem, &scene.tables, e);
        if !law.linear {
            let work = -s.tap[op.tap + i] * 0.5 * (e[2] - e[0]);
            let made = held - l.held[k] + work + heat;
            l.source[k] += made;
            source += made;
        }
        l.held[k] = held;
        l.lost[k] += heat;
        lost += heat;
        h += held;
    });
    l.h = h;
    l.worst = l.worst.max((h - before - work + lost - source).abs());
    l.peak = l.peak.max(h.abs() + l.lost_mats + l.lost.iter().map(|v| v.abs()).sum::<f64>());
    s.ledger = Some(l);
}

/// After changes of parameters or of moving points: what they brought in.
pub fn rebook(_op: &Op, scene: &Scene, s: &mut State) {
    let Some(mut l) = s.ledger.take() else { return };
    let h = hold(scene, s, &mut l);
    l.changed += h - l.h;
    l.h = h;
    s.ledger = Some(l);
}

/// At the end of the forces: keeps what the next tick overwrites.
pub fn keep(_op: &Op, scene: &Scene, s: &mut State) {
    let Some(l) = &mut s.ledger else { return };
    l.d0.copy_from_slice(&s.d);
    for (k, p) in scene.enx.iter().chain(&scene.tgr).enumerate() {
        l.port[k] = s.f[p.mat as usize];
    }
    for (k, p) in (scene.enx.len() + scene.tgr.len()..).zip(&scene.enf) {
        let v = s.input[p.input as usize];
        l.port[k] = if v.is_finite() { v } else { 0.0 };
    }
}
