//! Ordering: the order of the MATs in the state. A module's document number and its storage place are different things,
//! tied by one permutation.
//!
//! Decides to walk along links from each MAT to its next, so that chains stand in a row whatever order they were
//! written in, and kernels can run through them without indices. What already stands in a row is left as it is.

use crate::net::{End, Pruned};
use alloc::vec::Vec;
use ca_core::kind::Role;

/// Storage order: document numbers of the MATs that stay, as they stand in the state.
pub fn document(net: &Pruned) -> Vec<u32> {
    (0..net.mats.len() as u32).filter(|m| net.alive[*m as usize]).collect()
}

/// As `document`, with chains in a row.
pub fn storage(net: &Pruned) -> Vec<u32> {
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
    let mut order = Vec::with_capacity(n);
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
                around.iter().copied().find(|m| !seen[*m] && by_hand(*m) && start[m + 1] - start[*m] <= 2)
            } else {
                None
            };
            match follower {
                Some(m) => at = m,
                None => break,
            }
        }
    }
    order
}
