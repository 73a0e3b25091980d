//! Accumulate: what pulls at each mass, added up.
//!
//! Decides that a method with another limit than 4 is judged as heavier masses would be by the explicit one
//! ([`crate::net::Resolved::limit_ratio`]): `scaled_mobility` is T²/m times that, and everything compared with
//! 4 goes by it, while rules about one contact go by T²/m itself.

use crate::certify::negative::Negative;
use crate::certify::reach::{Reached, reached};
use crate::net::worst::{WorstMat, worst_bounds, worst_mats};
use crate::net::{End, LiaNode, Pruned};
use alloc::vec::Vec;
use ca_core::Bound;

/// The sums at one MAT, each of h = T²k + 2Tz over T² \[N/m\].
#[derive(Clone, Copy, Default)]
pub struct Sums {
    /// of all links that are certainly there, as steep as that
    pub certain: f64,
    /// of all links that may be
    pub all: f64,
    /// the same with links between masses counted twice, as in the disc of Gershgorin
    pub disc: f64,
    /// of the stiffest that is certainly there
    pub most: f64,
    /// of those below 0
    pub negative: f64,
    /// true where some of them are radial, so that they act in different directions
    pub radial: bool,
    /// T²/m \[m/N\]; 0 of what does not move
    pub c: f64,
    /// T²/m by which a sum is compared with the limit 4 \[m/N\]
    pub scaled_mobility: f64,
    /// stiffness of its own \[N/m\]
    #[cfg_attr(not(feature = "analysis"), allow(dead_code))]
    pub k: f64,
    /// viscosity of its own and of its medium \[N per m/tick\]
    pub z: f64,
}

impl Sums {
    fn new(m: WorstMat, limit_ratio: f64) -> Sums {
        let own = m.k + 2.0 * m.z;
        Sums {
            certain: own,
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
    /// of each MAT
    pub mats: Vec<Sums>,
    /// of each LIA, at the worst corner of what may change; of what hardens, where it is steepest within reach
    pub links: Vec<Bound>,
    /// that place
    pub reached: Vec<Option<Reached>>,
    /// springs between pairs of masses, by sign
    pub springs: Negative,
}

/// Adds up.
pub fn accumulate(net: &Pruned) -> Accumulated {
    let limit_ratio = net.limit_ratio();
    // what is left out does not move
    let sums = |(m, alive): (WorstMat, &bool)| if *alive { Sums::new(m, limit_ratio) } else { Sums::default() };
    let worst = worst_mats(net);
    let mut links = worst_bounds(net);
    let reached = reached(net, &worst, &links);
    for (b, r) in links.iter_mut().zip(&reached) {
        if let Some(r) = r.filter(|_| !b.contact) {
            let floor = b.k - b.loose;
            let k = if b.hardens { b.k.max(r.k) } else { r.k };
            *b = Bound { k, loose: k - floor, ..*b };
        }
    }
    let mut mats: Vec<Sums> = worst.into_iter().zip(&net.alive).map(sums).collect();
    let mut springs = Negative::default();
    // where none is negative, nobody asks what covers it
    let negative = links.iter().any(|b| b.k < 0.0);
    for (l, b) in net.lias.iter().zip(&links) {
        link(net, l, b, &mut mats);
        // what is not always there covers nothing
        if let ([End::Mat(i), End::Mat(j)], true) = (l.ends, negative && !b.contact) {
            springs.add(i, j, b.k);
        }
    }
    Accumulated { mats, links, reached, springs }
}

fn link(net: &Pruned, l: &LiaNode, b: &Bound, mats: &mut [Sums]) {
    // an implicit contact is passive whatever it holds, and no part of the linear network; others are judged by rule
    if !l.law.stage.is_explicit() || (b.contact && !b.linear) {
        return;
    }
    let h = b.h();
    let sure = fixed_share(b);
    // ends that move: the row of the link at each of them holds so many entries
    let moving = |ids: &[u32]| ids.iter().any(|m| mats[*m as usize].c > 0.0);
    let entries: f64 = l.all_ends().map(|e| if moving(&net.under(e)) { net.reach(e) } else { 0.0 }).sum();
    let others = (entries - 1.0).max(0.0);
    for (end, m) in l.all_ends().flat_map(|end| net.under(end).into_iter().map(move |m| (end, m))) {
        let s = &mut mats[m as usize];
        // what raises the limit is left out of what no mass may pass
        s.all += if b.lift > 0.0 { h.max(0.0) } else { h };
        s.disc += h + others * h.abs();
        if matches!(end, End::Mat(_)) {
            s.certain += sure;
            s.most = s.most.max(sure);
            s.negative += sure.min(0.0);
            s.radial |= l.is_radial();
        }
    }
}

/// The part of [`Bound::h`] that a link has wherever its ends are \[N/m\].
fn fixed_share(b: &Bound) -> f64 {
    // of a curve of friction the slope is one that it has somewhere
    (if b.curve { b.k } else { b.h() }) - b.loose
}
