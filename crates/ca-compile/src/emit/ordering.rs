//! Ordering: the order of the MATs in the state, a permutation of their document numbers.
//!
//! The order follows links from each MAT to the next, so that kernels can run through chains without indices, in
//! whatever order they were written. MATs that are already in a row stay as they are.

use crate::net::{End, Pruned};
use alloc::vec::Vec;
use ca_core::Role;

/// Order of the MATs in the state.
pub struct Storage {
    /// Document numbers of the MATs that stay, in their order in the state.
    pub order: Vec<u32>,
    /// True if arithmetic 2 had another order, in which a row turned into the next at the corner of a mesh.
    pub sorted: bool,
}

/// Returns the order of the document.
pub fn document(net: &Pruned) -> Storage {
    let order = (0..net.mats.len() as u32).filter(|m| net.alive[*m as usize]).collect();
    Storage { order, sorted: false }
}

/// Returns the order of the document, with chains in a row.
pub fn storage(net: &Pruned) -> Storage {
    // Neighbours in document order of the links, as (start, list).
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
            // The MAT written next, if it is linked; else the first free neighbour in a chain, if both were written one
            // by one. MATs of generators keep their order, and do not turn at the rim of a mesh.
            let by_hand = |m: usize| matches!(net.items[net.mats[m].item as usize].kind.role, Role::Mat(_));
            let follower = if around.contains(&(at + 1)) && !seen[at + 1] {
                Some(at + 1)
            } else if by_hand(at) {
                let chain = around.iter().copied().find(|m| !seen[*m] && by_hand(*m) && degree(*m) <= 2);
                // The corner of a mesh lies between two MATs outside any chain.
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
