//! Stiffness and viscosity at each device key, which its device must bear to stay passive (docs/numerics.md §5.2).
//!
//! They are the sums of the slopes of all links at a key, with all contacts closed and live parameters at their
//! stiffest; in space, as if all pulled in one direction. The model behind these links is passive by the rest of the
//! certificate.

use crate::certify::rules::method;
use crate::net::{End, MatRole, Pruned};
use alloc::string::ToString;
use alloc::vec::Vec;
use ca_core::Bound;
use ca_core::internal::kind::PortRole;
use ca_core::internal::scene::certificate::Key;

/// Stiffness and viscosity of the links of one item at a key.
struct LinkAtKey {
    item: u32,
    k: f64,
    z: f64,
    sticks: bool,
}

/// Returns a row per key with stiffness, viscosity or sticking friction, in document order.
pub fn keys(net: &Pruned, bounds: &[Bound]) -> Vec<Key> {
    let key = |m: &crate::net::MatNode| matches!(m.role, MatRole::Port(PortRole::Tgr, _));
    if !net.mats.iter().any(key) {
        return Vec::new();
    }
    let mut held: Vec<Vec<LinkAtKey>> = net.mats.iter().map(|_| Vec::new()).collect();
    for (l, b) in net.lias.iter().zip(bounds) {
        let (k, z) = (b.k.max(0.0), b.z.max(0.0) * net.tick_dt);
        let sticks = method(net, l) == "set-valued";
        for e in l.all_ends() {
            let End::Mat(m) = e else { continue };
            let links = &mut held[m as usize];
            match links.last_mut().filter(|h| h.item == l.item) {
                Some(h) => (h.k, h.z) = (h.k + k, h.z + z),
                None => links.push(LinkAtKey { item: l.item, k, z, sticks }),
            }
        }
    }
    let mut keys = Vec::new();
    for (m, links) in net.mats.iter().zip(held) {
        let sum = |of: fn(&LinkAtKey) -> f64| links.iter().map(of).sum::<f64>();
        let (k, z, sticks) = (sum(|h| h.k), sum(|h| h.z), links.iter().any(|h| h.sticks));
        if (k > 0.0 || z > 0.0 || sticks) && key(m) {
            let links = links.into_iter().map(|h| (net.items[h.item as usize].name.to_string(), h.k)).collect();
            keys.push(Key { name: m.name.to_string(), k, z, sticks, links });
        }
    }
    keys
}
