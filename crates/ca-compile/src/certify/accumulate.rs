//! Accumulates the stiffness and viscosity at each mass. A method with a limit other than 4 is judged like the explicit
//! one with heavier masses ([`crate::net::Resolved::limit_ratio`]): sums compared with 4 use `scaled_mobility`. Rules
//! about a single contact use T²/m itself.

use crate::certify::max_elongation::{MaxElongation, is_open, max_elongations};
use crate::certify::negative::Negative;
use crate::net::worst::{WorstMat, worst_bounds, worst_mats};
use crate::net::{End, LiaNode, Pruned};
use alloc::vec::Vec;
use ca_core::Bound;

/// Sums at one MAT of h = T²k + 2Tz, over T² \[N/m\].
#[derive(Clone, Copy, Default)]
pub struct Sums {
    /// Explicit links that are always present, with the slopes that they always have.
    pub certain: f64,
    /// True if a solved link may hold the mass, or a live parameter changes it or its links: no sum of links then shows
    /// that it is unstable.
    pub unsure: bool,
    /// Part of `certain` by viscosity.
    pub viscous: f64,
    /// All links that may be present.
    pub all: f64,
    /// All links, with links between masses counted twice (Gershgorin).
    pub disc: f64,
    /// The stiffest link that is always present.
    pub most: f64,
    /// Links below 0.
    pub negative: f64,
    /// True if some of the links are radial and so act in different directions.
    pub radial: bool,
    /// T²/m \[m/N\]; 0 if it does not move.
    pub c: f64,
    /// T²/m for comparison of a sum with the limit 4 \[m/N\].
    pub scaled_mobility: f64,
    /// Own stiffness \[N/m\].
    #[cfg_attr(not(feature = "analysis"), allow(dead_code))]
    pub k: f64,
    /// Own viscosity plus the viscosity of its medium \[N per m/tick\].
    pub z: f64,
}

impl Sums {
    fn new(m: WorstMat, limit_ratio: f64) -> Sums {
        let own = m.k + 2.0 * m.z;
        Sums {
            certain: own,
            viscous: 2.0 * m.z,
            all: own,
            disc: own,
            c: m.c,
            scaled_mobility: m.c * limit_ratio,
            k: m.k,
            z: m.z,
            ..Sums::default()
        }
    }
}

/// The network as sums.
pub struct Accumulated {
    /// Sums of each MAT.
    pub mats: Vec<Sums>,
    /// Slopes of each LIA at the worst corner of its live parameters; for a hardening law at the steepest point within
    /// reach.
    pub links: Vec<Bound>,
    /// The steepest point within reach of each LIA.
    pub reached: Vec<Option<MaxElongation>>,
    /// Springs between pairs of masses, by sign.
    pub springs: Negative,
}

/// Accumulates the network.
pub fn accumulate(net: &Pruned) -> Accumulated {
    let limit_ratio = net.limit_ratio();
    // Modules that were dropped do not move.
    let sums = |(m, alive): (WorstMat, &bool)| if *alive { Sums::new(m, limit_ratio) } else { Sums::default() };
    let worst = worst_mats(net);
    let mut links = worst_bounds(net);
    let reached = max_elongations(net, &worst, &links);
    for (b, r) in links.iter_mut().zip(&reached) {
        if let Some(r) = r.filter(|_| !b.contact) {
            let floor = b.k - b.varying;
            let k = if b.hardens { b.k.max(r.k) } else { r.k };
            *b = Bound { k, varying: k - floor, ..*b };
        }
    }
    let mut mats: Vec<Sums> = worst.into_iter().zip(&net.alive).map(sums).collect();
    net.mats.iter().zip(&mut mats).for_each(|(m, sums)| sums.unsure = net.is_live(m.item));
    let mut springs = Negative::default();
    // Only negative springs need others that cover them.
    let negative = links.iter().any(|b| b.k < 0.0);
    for (l, b) in net.lias.iter().zip(&links) {
        link(net, l, b, &mut mats);
        let solved = !l.law.stage.is_explicit();
        if net.is_live(l.item) || solved && !(b.contact && is_open(net, l)) {
            l.all_ends().flat_map(|e| net.under(e)).for_each(|m| mats[m as usize].unsure = true);
        }
        // A contact covers nothing, since it may be open.
        if let ([End::Mat(i), End::Mat(j)], true) = (l.ends, negative && !b.contact) {
            springs.add(i, j, b.k);
        }
    }
    Accumulated { mats, links, reached, springs }
}

fn link(net: &Pruned, l: &LiaNode, b: &Bound, mats: &mut [Sums]) {
    // Implicit contacts are passive at any slope and not part of the linear network; other contacts are judged by rule.
    if !l.law.stage.is_explicit() || (b.contact && !b.linear) {
        return;
    }
    let h = b.h();
    let sure = fixed_share(b);
    let viscous = if b.curve || b.centred { 0.0 } else { 2.0 * b.z };
    // Number of entries in the row of the link, counted at ends that move.
    let moving = |ids: &[u32]| ids.iter().any(|m| mats[*m as usize].c > 0.0);
    let entries: f64 = l.all_ends().map(|e| if moving(&net.under(e)) { net.reach(e) } else { 0.0 }).sum();
    let others = (entries - 1.0).max(0.0);
    for (end, m) in l.all_ends().flat_map(|end| net.under(end).into_iter().map(move |m| (end, m))) {
        let s = &mut mats[m as usize];
        // Links that raise the limit must not count in a sum that bounds each mass.
        s.all += if b.lift > 0.0 { h.max(0.0) } else { h };
        s.disc += h + others * h.abs();
        if matches!(end, End::Mat(_)) {
            let sure = repeated(l, end, sure);
            s.certain += sure;
            s.viscous += viscous;
            s.most = s.most.max(sure);
            s.negative += sure.min(0.0);
            s.radial |= l.is_radial();
        }
    }
}

/// Returns what a link certainly adds at an end. A quadripole may act at several of its ends on one mass, and its forces
/// there may cancel or add up.
fn repeated(l: &LiaNode, end: End, sure: f64) -> f64 {
    let times = if l.onto.is_some() { l.all_ends().filter(|e| *e == end).count() } else { 1 };
    if times > 1 { (times as f64 * sure).min(0.0) } else { sure }
}

/// Returns the part of [`Bound::h`] that a link has at all elongations \[N/m\].
fn fixed_share(b: &Bound) -> f64 {
    // The slope of a friction curve exists only at some speed.
    (if b.curve { b.k } else { b.h() }) - b.varying
}
