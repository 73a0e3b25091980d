//! Ordering: the order of the MATs in the state. A module's document number and its storage place are different things,
//! tied by one permutation.
//!
//! Decides to walk along links from each MAT to its next, so that chains stand in a row whatever order they were
//! written in, and kernels can run through them without indices. What already stands in a row is left as it is.

use crate::net::{End, Pruned};
use alloc::vec::Vec;
use ca_core::Role;

/// Storage order.
pub struct Storage {
    /// document numbers of the MATs that stay, as they stand in the state
    pub order: Vec<u32>,
    /// true where arithmetic 2 had another order, that of a row turning into the next at the corner of a mesh
    pub sorted: bool,
}

/// As the document has them.
pub fn document(net: &Pruned) -> Storage {
    let order = (0..net.mats.len() as u32).filter(|m| net.alive[*m as usize]).collect();
    Storage { order, sorted: false }
}

/// As `document`, with chains in a row.
pub fn storage(net: &Pruned) -> Storage {
    // neighbours in document order of the links, as (start, list)
    let n = net.mats.len();
    let pairs = || {
        net.lias.iter().filter_map(|l| match l.ends {
            [End::Mat(a), End::Mat(b)] if !l.is_radial() => Some((a as usize, b as usize)),
            _ => None,
        })
    };
    let mut start = alloc::vec![0usize; n + 1];
    pairs().for_each(|(a, b)| {
        start[a + 1] += 1;
        start[b + 1] += 1;
    });
    for i in 0..n {
        start[i + 1] += start[i];
    }
    let mut fill = start.clone();
    let mut next = alloc::vec![0usize; start[n]];
    pairs().for_each(|(a, b)| {
        next[fill[a]] = b;
        next[fill[b]] = a;
        fill[a] += 1;
        fill[b] += 1;
    });
    let mut seen = alloc::vec![false; n];
    let (mut order, mut sorted) = (Vec::with_capacity(n), false);
    let degree = |m: usize| start[m + 1] - start[m];
    for first in 0..n {
        let mut at = first;
        while net.alive[at] && !seen[at] {
            seen[at] = true;
            order.push(at as u32);
            let around = &next[start[at]..start[at + 1]];
            // the one written next, if it is linked; else the first neighbour that is not yet placed and written by
            // hand, inside a chain: what a generator made stands as it should, and does not turn at the rim of a mesh
            let by_hand = |m: usize| matches!(net.items[net.mats[m].item as usize].kind.role, Role::Mat(_));
            let follower = if around.contains(&(at + 1)) && !seen[at + 1] {
                Some(at + 1)
            } else if by_hand(at) {
                let chain = around.iter().copied().find(|m| !seen[*m] && by_hand(*m) && degree(*m) <= 2);
                // the corner of a mesh is between two others that are in no chain
                let others = |m: usize| next[start[m]..start[m + 1]].iter().filter(move |o| **o != at);
                let corner = |m: usize| degree(at) > 2 && others(m).any(|o| degree(*o) > 2);
                sorted |= chain.is_some_and(corner);
                chain.filter(|m| !corner(*m))
            } else {
                None
            };
            match follower {
                Some(m) => at = m,
                None => break,
            }
        }
    }
    Storage { order, sorted }
}
