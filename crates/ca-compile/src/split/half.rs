//! Half: the network of one half, from that of the whole.

use crate::net::{End, MatRole, OutputTap, Pruned};
use crate::split::cut::{Cut, moves, moving};
use alloc::collections::BTreeMap;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::kind::Role;
use ca_core::mat::SOL;
use ca_core::scene::{Half, Scene};

/// What became of the whole.
pub struct Kept {
    /// for each output that stays its channel here and in the whole
    pub channels: Vec<(u32, u32)>,
    /// MATs that move here by themselves, by document number
    pub own: Vec<u32>,
    /// MATs of the other half that links of this one, or its outputs, look at
    pub ghosts: Vec<u32>,
}

/// Links across a cut.
pub fn across(net: &Pruned, cut: &Cut) -> usize {
    let cuts = |l: &&crate::net::LiaNode| {
        let mut sides = moving(net, l).map(|m| cut.second[m as usize]);
        sides.next().is_some_and(|first| sides.any(|s| s != first))
    };
    net.lias.iter().filter(cuts).count()
}

/// For each channel whether the second half writes it: where more of what it hears moves.
fn writers(net: &Pruned, cut: &Cut) -> BTreeMap<u32, bool> {
    let mut votes: BTreeMap<u32, i64> = BTreeMap::new();
    for o in &net.outs {
        let vote = votes.entry(o.channel).or_default();
        let mut side = |m: u32, weight: i64| {
            if moves(net, m) {
                *vote += if cut.second[m as usize] { weight } else { -weight };
            }
        };
        // a force says where, and none of the same channel says otherwise
        let sure = net.outs.len() as i64;
        match o.tap {
            OutputTap::Position(End::Mat(m)) => side(m, 1),
            OutputTap::Position(e) => net.under(e).iter().take(1).for_each(|m| side(*m, sure)),
            OutputTap::ForceOf(l) => moving(net, &net.lias[l as usize]).take(1).for_each(|m| side(m, sure)),
            OutputTap::ForceOn(e) => {
                let pulls = |l: &&crate::net::LiaNode| l.all_ends().any(|end| end == e);
                let mut at = net.under(e).iter().copied().find(|m| moves(net, *m));
                at = at.or_else(|| net.lias.iter().filter(pulls).find_map(|l| moving(net, l).next()));
                if let Some(m) = at {
                    side(m, sure);
                }
            }
        }
    }
    votes.into_iter().map(|(channel, v)| (channel, v > 0)).collect()
}

/// Leaves of the network what the second half needs, or the first.
pub fn keep(net: &mut Pruned, cut: &Cut, second: bool) -> Kept {
    let own = |net: &Pruned, m: u32| moves(net, m) && cut.second[m as usize] == second;
    let all = 0..net.mats.len() as u32;
    let mine: Vec<u32> = all.clone().filter(|m| own(net, *m)).collect();
    let writers = writers(net, cut);
    net.outs.retain(|o| writers[&o.channel] == second);
    let pushed = |net: &Pruned, e: End| net.under(e).iter().any(|m| own(net, *m));
    let pushes = core::mem::take(&mut net.pushes);
    net.pushes = pushes.into_iter().filter(|p| pushed(net, p.end)).collect();
    // what moves nothing is between fixed points and ports, and heard at the most
    let fixed_alone = |l: &crate::net::LiaNode| moving(net, l).next().is_none();
    let stays: Vec<bool> = net.lias.iter().map(|l| moving(net, l).any(|m| own(net, m)) || fixed_alone(l)).collect();
    // ports stand in both halves, and read the same input
    let mut alive: Vec<bool> = all.clone().map(|m| own(net, m)).collect();
    for (alive, (m, was)) in alive.iter_mut().zip(net.mats.iter().zip(&net.alive)) {
        *alive |= *was && matches!(m.role, MatRole::Port(..));
    }
    let mut need = |e: End| net.under(e).iter().for_each(|m| alive[*m as usize] |= net.alive[*m as usize]);
    for (l, _) in net.lias.iter().zip(&stays).filter(|(_, stays)| **stays) {
        l.all_ends().for_each(&mut need);
    }
    for o in &net.outs {
        if let OutputTap::Position(e) | OutputTap::ForceOn(e) = o.tap {
            need(e);
        }
    }
    let ghosts: Vec<u32> = all.filter(|m| alive[*m as usize] && moves(net, *m) && !own(net, *m)).collect();
    for m in &ghosts {
        let m = &mut net.mats[*m as usize];
        let Role::Mat(spec) = SOL.role else { continue };
        (m.role, m.values) = (MatRole::Mat(spec), Arc::from([]));
    }
    let was: Vec<u32> = net.outs.iter().map(|o| o.channel).collect();
    let lias = core::mem::take(&mut net.lias);
    net.drop_links(lias, &stays);
    net.alive = alive;
    let channels = net.outs.iter().zip(was).map(|(o, was)| (o.channel, was)).collect();
    Kept { channels, own: mine, ghosts }
}

/// A half as it is played: `place` says where each MAT stands in the whole scene, `shared` which the other half has ghosts of.
pub fn half(net: &Pruned, kept: &Kept, scene: Scene, place: &BTreeMap<u32, u32>, shared: &[u32]) -> Half {
    let alive = (0..net.mats.len() as u32).filter(|m| net.alive[*m as usize]);
    let here: BTreeMap<u32, u32> = alive.zip(scene.symbols.places().iter().copied()).collect();
    let axes = |m: u32, at: u32| at..at + net.mats[m as usize].slots();
    let list = |all: &[u32]| all.iter().flat_map(|m| axes(*m, here[m])).collect();
    let both = |(m, at): (&u32, &u32)| axes(*m, *at).zip(axes(*m, place[m])).map(|(a, b)| [a, b]).collect::<Vec<_>>();
    let mut outputs = alloc::vec![None; scene.n_out];
    for (own, whole) in &kept.channels {
        outputs[*own as usize] = Some(*whole);
    }
    Half {
        places: here.iter().flat_map(both).collect(),
        own: kept.own.iter().map(|m| (m, &here[m])).flat_map(both).collect(),
        shared: list(shared),
        ghosts: list(&kept.ghosts),
        outputs,
        scene,
    }
}
