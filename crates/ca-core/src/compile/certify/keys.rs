//! The springs on each device key: what a device must bear to stay passive (numerics 5.2).
//!
//! Decides to add up the slopes of all links at a key, as if all contacts were closed and all live parameters at their
//! stiffest, and in space pulled in one direction. What hangs behind these links does not matter: it is passive by the rest of the certificate.

use crate::certificate::Key;
use crate::compile::net::{End, MatRole, Net};
use crate::kind::PortRole;
use crate::law::Bound;
use alloc::vec::Vec;

/// A row for each key that something stiff holds, in the order of the document.
pub fn keys(net: &Net, bounds: &[Bound]) -> Vec<Key> {
    let mut sums = alloc::vec![0.0; net.mats.len()];
    for (l, b) in net.lias.iter().zip(bounds) {
        for e in l.all_ends() {
            if let End::Mat(m) = e {
                sums[m as usize] += b.k.max(0.0);
            }
        }
    }
    let held = net.mats.iter().zip(sums).filter(|(m, k)| matches!(m.role, MatRole::Port(PortRole::Tgr, _)) && *k > 0.0);
    held.map(|(m, k)| Key { name: m.name.clone(), k }).collect()
}
