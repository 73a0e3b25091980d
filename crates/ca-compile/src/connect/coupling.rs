//! Virtual coupling: a mass between a device port and its links, with a spring and a damper to the port.
//!
//! It is for devices that cannot render the links of a key (`ca_haptic::coupling`). It consists of ordinary modules and
//! needs no law at the rate boundary: the tick, the certificate, the ledger and groups at the gesture rate treat a
//! coupled port like any other, and the energy at the port stays exact. Scenes without a coupling pay nothing. Outputs
//! and moving points that refer to the port stay at the port, since that is the position of the hand.

use crate::net::{End, LiaNode, MatNode, MatRole, Measure, Medium, NetItem, Wired};
use alloc::format;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::kind::PortRole;
use ca_core::internal::mat::MAS;
use ca_core::internal::phi::REF;
use ca_core::internal::scene::Coupling;
use ca_core::internal::tuning::Method;
use ca_core::{Kind, Name, Role};

/// Adds the modules of these couplings to the network.
pub fn couple(net: &mut Wired, couplings: &[Coupling]) {
    let (Role::Mat(mas), Role::Lia(law)) = (MAS.role, REF.role) else { return };
    let tgr = |m: &MatNode| matches!(m.role, MatRole::Port(PortRole::Tgr, _));
    let mut medium = None;
    for c in couplings {
        let Some(at) = net.mats.iter().position(|m| tgr(m) && m.name == *c.port.as_str()) else { continue };
        let (port, mass) = (net.mats[at].clone(), net.mats.len() as u32);
        let at = End::Mat(at as u32);
        for l in &mut net.lias {
            follow(l, at, mass);
        }
        // A medium without gravity and friction.
        let group = *medium.get_or_insert_with(|| {
            let method = if net.is_composed() { Method::Pefrl } else { Method::Ca };
            // Before the last medium, which is for modules without a group.
            let n = net.media.len().saturating_sub(1);
            net.media.insert(n, Medium { method, ..Medium::default() });
            n as u32
        });
        let model = net.items[port.item as usize].model;
        let mut item = |kind: &'static Kind, what: &str, numbers: &[(&str, f64)]| {
            let mut slots = alloc::vec![None; kind.params.len()];
            for (name, v) in numbers {
                if let Some(i) = kind.param(name) {
                    slots[i] = Some(*v);
                }
            }
            let name: Arc<str> = format!("{} ({what})", c.port).into();
            let (args, follows, dim) = (Vec::new(), Vec::new(), port.axes);
            let id = net.items.len() as u32;
            net.items.push(NetItem { name: name.clone(), kind, model, group: Some(group), dim, args, follows, slots });
            (id, name)
        };
        let (own, name) = item(&MAS, "coupled", &[("m", c.m)]);
        let (link, link_name) = item(&REF, "coupling", &[("k", c.k), ("z", c.z)]);
        let node = MatNode {
            name: Name::from(&name),
            code: MAS.code,
            role: MatRole::Mat(mas),
            values: net.own_values(MAS.params.len()),
            dx0: [0.0; 3],
            v: [0.0; 3],
            group: Some(group),
            item: own,
            ..port
        };
        let axes = node.axes;
        net.add(node);
        let values = net.own_values(REF.params.len());
        let mut made = Vec::new();
        for k in 0..axes {
            let axis = (axes > 1).then_some(k);
            made.push(net.lias.len() as u32);
            net.lias.push(LiaNode {
                name: Name { axis, ..Name::from(&link_name) },
                kind: &REF,
                law,
                values: values.clone(),
                ends: [at, End::Mat(mass)],
                measure: Measure::Line([k, k]),
                onto: None,
                sets: None,
                l0: None,
                soften: 0.0,
                item: link,
            });
        }
        net.families.insert_links(&link_name, made);
    }
}

/// Moves the ends of a link from `port` to `mass`.
fn follow(l: &mut LiaNode, port: End, mass: u32) {
    let onto = l.onto.as_mut().map(|o| o.ends.iter_mut());
    for end in l.ends.iter_mut().chain(onto.into_iter().flatten()).filter(|end| **end == port) {
        *end = End::Mat(mass);
    }
    if let (Some(sets), End::Mat(port)) = (&mut l.sets, port) {
        if sets.iter().flatten().any(|m| *m == port) {
            for m in Arc::make_mut(sets).iter_mut().flatten().filter(|m| **m == port) {
                *m = mass;
            }
        }
    }
}
