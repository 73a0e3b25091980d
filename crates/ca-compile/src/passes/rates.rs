//! Splits the network into the groups at the gesture rate and the sound side.

use crate::net::{End, MatRole, Pruned, Push};
use crate::passes::gesture_rate::SlowPart;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::equivalence::Gains;
use ca_core::internal::op::layout::Crossing;
use ca_core::{Input, InputRole};

/// Reduces the network to the sound side, where masses of the groups are moved from outside.
pub fn sound(net: &mut Pruned, part: &SlowPart) {
    for (m, _) in net.mats.iter_mut().zip(&part.slow).filter(|(_, slow)| **slow) {
        (m.role, m.values) = (MatRole::Slow, Arc::from([]));
    }
    let stays: Vec<bool> = part.inner.iter().map(|inner| !inner).collect();
    let lias = core::mem::take(&mut net.lias);
    net.drop_links(lias, &stays);
}

/// Reduces the network to the groups, whose tick is a frame; forces of links across are external forces.
pub fn group(net: &mut Pruned, part: &SlowPart) {
    for (alive, slow) in net.alive.iter_mut().zip(&part.slow) {
        *alive &= *slow;
    }
    net.outs.clear();
    net.channels.clear();
    net.points.clear();
    let lias = core::mem::take(&mut net.lias);
    for l in lias.iter().zip(&part.inner).filter(|(_, inner)| **inner).map(|(l, _)| l) {
        l.all_ends().for_each(|e| {
            if let End::Mat(m) = e {
                net.alive[m as usize] = true;
            }
        });
    }
    net.drop_links(lias, &part.inner);
    net.tick_dt = net.frame_dt();
    net.rate = 1.0 / net.tick_dt;
    net.slow = true;
    (net.oversample, net.ratio, net.crossing) = (1, 1, Crossing::default());
    net.lowpass.clear();
    net.lines.clear();
    net.params.clear();
    net.driven.clear();
    net.gestures.clear();
    net.items.iter_mut().for_each(|i| i.follows.clear());
    let input = |_: &_| Input {
        name: "border".into(),
        role: InputRole::Force,
        rest: 0.0,
        midi: None,
        device: None,
        gains: Gains::default(),
    };
    net.inputs = part.coupled.iter().map(input).collect();
    let pushes = (0..).zip(&part.coupled).map(|(input, (m, axis))| Push { input, end: End::Mat(*m), axis: *axis });
    net.pushes = pushes.collect();
}
