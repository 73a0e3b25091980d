//! The springs on each device key: what a device must bear to stay passive (docs/numerics.md §5.2).
//!
//! Decides to add up the slopes of all links at a key, as if all contacts were closed and all live parameters at their
//! stiffest, and in space pulled in one direction. What hangs behind these links does not matter: it is passive by the rest of the certificate.

use crate::net::{End, MatRole, Pruned};
use alloc::string::ToString;
use alloc::vec::Vec;
use ca_core::kind::PortRole;
use ca_core::law::Bound;
use ca_core::scene::certificate::Key;

/// A row for each key that something stiff holds, in the order of the document.
pub fn keys(net: &Pruned, bounds: &[Bound]) -> Vec<Key> {
    let key = |m: &crate::net::MatNode| matches!(m.role, MatRole::Port(PortRole::Tgr, _));
    if !net.mats.iter().any(key) {
        return Vec::new();
    }
    let mut held: Vec<Vec<(u32, f64)>> = alloc::vec![Vec::new(); net.mats.len()];
    for (l, b) in net.lias.iter().zip(bounds) {
        for e in l.all_ends() {
            let End::Mat(m) = e else { continue };
            let links = &mut held[m as usize];
            match links.last_mut().filter(|(item, _)| *item == l.item) {
                Some((_, k)) => *k += b.k.max(0.0),
                None => links.push((l.item, b.k.max(0.0))),
            }
        }
    }
    let mut keys = Vec::new();
    for (m, links) in net.mats.iter().zip(held) {
        let k: f64 = links.iter().map(|l| l.1).sum();
        if k > 0.0 && key(m) {
            let links = links.into_iter().map(|(item, k)| (net.items[item as usize].name.to_string(), k)).collect();
            keys.push(Key { name: m.name.to_string(), k, links });
        }
    }
    keys
}
