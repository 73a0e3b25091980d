//! Cut: which half each MAT goes to.
//!
//! Decides for a prefix of an order: the MATs as they are stored, where neighbours stand near each other and rows of a mesh
//! stay whole, or, where that cuts too much, by their distance in links from a far end of the network. The cut is where the
//! larger half has least to do, links across it counted in both. A general partitioner would find better cuts of irregular
//! networks, and leave rows of regular ones in pieces.

use crate::net::disjoint::Sets;
use crate::net::{End, LiaNode, MatRole, OutputTap, Pruned};
use alloc::collections::{BTreeMap, BTreeSet, VecDeque};
use alloc::vec::Vec;

/// What a link between distances costs, beside one on a line.
const RADIAL: f64 = 6.0;
/// What it costs to hand the places of one link over.
const EXCHANGE: f64 = 2.0;
/// A cut by distance is worth its broken rows where it saves this part of the work.
const WORTH: f64 = 0.1;

/// A cut.
pub struct Cut {
    /// by document number: true in the second half
    pub second: Vec<bool>,
    /// share of the work in the larger half
    pub share: f64,
}

/// Why a scene is not cut.
pub fn obstacle(net: &Pruned) -> Option<&'static str> {
    let still = net.lias.iter().all(|l| moving(net, l).next().is_none());
    let implicit = net.lias.iter().any(|l| l.law.implicit);
    match () {
        () if net.oversample > 1 => Some("`oversample` runs several ticks in a sample"),
        () if net.is_composed() => Some("`pefrl` sums forces several times in a tick"),
        () if net.media.iter().any(|m| m.slow) => Some("a group at the gesture rate takes forces of all of a frame"),
        () if !net.lines.is_empty() => Some("a waveguide is one module"),
        () if net.as_milib => Some("its first two samples are those of mi.lib"),
        () if implicit && !net.params.is_empty() => {
            Some("a live parameter changes at once what follows it, where links are implicit")
        }
        () if still => Some("no link moves anything in it"),
        () => None,
    }
}

/// True for a MAT that stays and that forces move.
pub fn moves(net: &Pruned, m: u32) -> bool {
    net.alive[m as usize] && !net.mats[m as usize].is_fixed()
}

/// The MATs under all ends of a link that forces move.
pub fn moving<'n>(net: &'n Pruned, l: &'n LiaNode) -> impl Iterator<Item = u32> + 'n {
    l.all_ends().flat_map(|e| net.under(e)).filter(|m| moves(net, *m))
}

/// Finds the cut; `order` is that of storage. `None` where all of it belongs together.
pub fn cut(net: &Pruned, order: &[u32]) -> Option<Cut> {
    let atoms = Atoms::of(net, order);
    let stored: Vec<u32> = (0..atoms.work.len() as u32).collect();
    let first = atoms.best(&stored)?;
    let far = atoms.by_distance();
    let second = atoms.best(&far).filter(|b| b.1 < (1.0 - WORTH) * first.1);
    let (list, (at, work)) = second.map_or((&stored, first), |b| (&far, b));
    let mut late = alloc::vec![false; atoms.work.len()];
    list[at..].iter().for_each(|a| late[*a as usize] = true);
    let in_second = |a: &u32| late.get(*a as usize).copied().unwrap_or(false);
    Some(Cut { second: atoms.of.iter().map(in_second).collect(), share: work / atoms.work.iter().sum::<f64>() })
}

/// What stays together, numbered as it is stored.
struct Atoms {
    /// MAT → atom; `u32::MAX` for what no force moves
    of: Vec<u32>,
    /// what each costs in a tick
    work: Vec<f64>,
    /// links between atoms, and what each costs if it is cut
    links: Vec<(u32, u32, f64)>,
}

impl Atoms {
    fn of(net: &Pruned, order: &[u32]) -> Atoms {
        let mut sets = together(net);
        let mut number: BTreeMap<usize, u32> = BTreeMap::new();
        let mut of = alloc::vec![u32::MAX; net.mats.len()];
        let mut work = Vec::new();
        for m in order.iter().copied().filter(|m| moves(net, *m)) {
            let next = number.len() as u32;
            let atom = *number.entry(sets.root(m as usize)).or_insert(next);
            if atom == next {
                work.push(0.0);
            }
            of[m as usize] = atom;
            work[atom as usize] += f64::from(net.mats[m as usize].slots());
        }
        let mut links = Vec::new();
        for l in &net.lias {
            let pairs = l.sets.as_ref().map_or(1, |s| s[0].len() + s[1].len());
            let cost = pairs as f64 * if l.is_radial() { RADIAL } else { 1.0 };
            let mut ends = moving(net, l).map(|m| of[m as usize]);
            let Some(a) = ends.next() else { continue };
            match ends.find(|b| *b != a) {
                // the two halves of what it costs, which are whole where it is cut
                Some(b) => {
                    work[a as usize] += 0.5 * cost;
                    work[b as usize] += 0.5 * cost;
                    links.push((a, b, 0.5 * cost + EXCHANGE));
                }
                None => work[a as usize] += cost,
            }
        }
        Atoms { of, work, links }
    }

    /// Where to cut the list, and what the larger half then has to do.
    fn best(&self, list: &[u32]) -> Option<(usize, f64)> {
        let mut place = alloc::vec![0; list.len()];
        list.iter().enumerate().for_each(|(i, a)| place[*a as usize] = i);
        // what is cut between place i and the next, as changes
        let mut across = alloc::vec![0.0; list.len()];
        for (a, b, cost) in &self.links {
            let (a, b) = (place[*a as usize], place[*b as usize]);
            across[a.min(b)] += cost;
            across[a.max(b)] -= cost;
        }
        let whole: f64 = self.work.iter().sum();
        let (mut before, mut cut) = (0.0, 0.0);
        let mut cuts = (1..list.len()).map(|at| {
            before += self.work[list[at - 1] as usize];
            cut += across[at - 1];
            (at, f64::max(before, whole - before) + cut)
        });
        let first = cuts.next()?;
        Some(cuts.fold(first, |best, c| if c.1 < best.1 { c } else { best }))
    }

    /// The atoms by their distance in links from one that is far from others; parts without links to each other follow.
    fn by_distance(&self) -> Vec<u32> {
        let n = self.work.len();
        let mut start = alloc::vec![0usize; n + 1];
        self.links.iter().flat_map(|l| [l.0, l.1]).for_each(|a| start[a as usize + 1] += 1);
        (0..n).for_each(|i| start[i + 1] += start[i]);
        let (mut fill, mut around) = (start.clone(), alloc::vec![0u32; start[n]]);
        for (a, b) in self.links.iter().flat_map(|l| [(l.0, l.1), (l.1, l.0)]) {
            around[fill[a as usize]] = b;
            fill[a as usize] += 1;
        }
        let mut seen = alloc::vec![false; n];
        let walk = |from: u32, seen: &mut [bool], to: &mut Vec<u32>| {
            let mut next = VecDeque::from([from]);
            seen[from as usize] = true;
            while let Some(a) = next.pop_front() {
                to.push(a);
                for b in &around[start[a as usize]..start[a as usize + 1]] {
                    if !seen[*b as usize] {
                        seen[*b as usize] = true;
                        next.push_back(*b);
                    }
                }
            }
        };
        let (mut probe, mut list) = (Vec::new(), Vec::with_capacity(n));
        let mut probed = seen.clone();
        for from in 0..n as u32 {
            if seen[from as usize] {
                continue;
            }
            // the last that is reached is far from the first
            probe.clear();
            walk(from, &mut probed, &mut probe);
            let far = probe.last().copied().unwrap_or(from);
            walk(far, &mut seen, &mut list);
        }
        list
    }
}

/// Which MATs stand in one half.
fn together(net: &Pruned) -> Sets {
    let n = net.mats.len();
    // one place more, for what is solved at once
    let mut sets = Sets::new(n + 1);
    let mut join = |all: &mut dyn Iterator<Item = u32>, hub: Option<usize>| {
        let Some(first) = hub.or_else(|| all.next().map(|m| m as usize)) else { return };
        all.for_each(|m| sets.join(first, m as usize));
    };
    let under = |e: End| net.under(e).into_iter().filter(|m| moves(net, *m));
    for p in 0..net.points.len() {
        join(&mut under(End::Point(p as u32)), None);
    }
    // the force on a fixed point is summed in one half
    let mut summed: BTreeMap<u32, Option<usize>> = BTreeMap::new();
    for o in &net.outs {
        if let OutputTap::ForceOn(End::Mat(m)) = o.tap {
            if !moves(net, m) {
                summed.insert(m, None);
            }
        }
    }
    let solved = |l: &LiaNode| l.law.implicit || l.law.is_staged();
    // a port that such a link holds is under way at the first tick, to all others too
    let port = |m: u32| matches!(net.mats[m as usize].role, MatRole::Port(..));
    let held = net.lias.iter().filter(|l| solved(l)).flat_map(LiaNode::all_ends).flat_map(|e| net.under(e));
    let held: BTreeSet<u32> = held.filter(|m| port(*m)).collect();
    for l in &net.lias {
        if solved(l) || l.all_ends().any(|e| matches!(e, End::Mat(m) if held.contains(&m))) {
            join(&mut moving(net, l), Some(n));
        }
        let point = |e: End| matches!(e, End::Point(_));
        if l.sets.is_some() || l.onto.is_some() || l.all_ends().any(point) {
            join(&mut moving(net, l), None);
        }
        for e in l.all_ends() {
            let End::Mat(m) = e else { continue };
            if let Some(hub) = summed.get_mut(&m) {
                *hub = hub.or_else(|| moving(net, l).next().map(|m| m as usize));
                join(&mut moving(net, l), *hub);
            }
        }
    }
    // one half writes a channel: positions are those of ghosts where need be, forces are not
    let mut channels: BTreeMap<u32, Option<usize>> = BTreeMap::new();
    for o in &net.outs {
        let hub = channels.entry(o.channel).or_default();
        let mut all: Vec<u32> = match o.tap {
            OutputTap::Position(End::Mat(_)) => Vec::new(),
            OutputTap::ForceOn(End::Mat(m)) if summed.contains_key(&m) => {
                summed[&m].map(|m| m as u32).into_iter().collect()
            }
            OutputTap::Position(e) | OutputTap::ForceOn(e) => under(e).collect(),
            OutputTap::ForceOf(l) => moving(net, &net.lias[l as usize]).collect(),
        };
        *hub = hub.or_else(|| all.first().map(|m| *m as usize));
        join(&mut all.drain(..), *hub);
    }
    sets
}
