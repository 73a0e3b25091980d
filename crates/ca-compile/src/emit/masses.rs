//! Masses: initial state, coefficients and weight of MATs and moving points, slot by slot.

use crate::emit::layout_builder::LayoutBuilder;
use crate::net::{End, MatRole};
use alloc::vec::Vec;
use ca_core::internal::live::Loader;

/// Initial state of MATs and moving points, slot by slot.
pub struct Masses {
    /// Displacement from rest \[m\].
    pub x: Vec<f64>,
    /// Speed \[m/s\].
    pub v: Vec<f64>,
    /// Rest position \[m\].
    pub rest: Vec<f64>,
}

/// Sets positions and coefficients of MATs, and rest positions of moving points.
pub fn masses(builder: &mut LayoutBuilder) -> Masses {
    let net = builder.net;
    let n_mat = builder.coef.len() / 3;
    let zero = alloc::vec![0.0; n_mat];
    let mut all = Masses { x: zero.clone(), v: zero.clone(), rest: zero };
    for (i, m) in net.mats.iter().enumerate() {
        let at = builder.slot[i] as usize;
        if at == u32::MAX as usize {
            continue;
        }
        for k in 0..m.slots() as usize {
            (all.x[at + k], all.v[at + k], all.rest[at + k]) = (m.dx0[k], m.v[k], m.rest[k]);
        }
        if let MatRole::Port(_, inputs) = m.role {
            // P = 1: until its next input a port continues its motion.
            (0..3).filter(|k| inputs[*k].is_some()).for_each(|k| builder.coef[at + k] = 1.0);
        }
        if let MatRole::Mat(spec) = m.role {
            let loader = Loader::Mat(spec, if spec.fixed { 0.0 } else { net.medium(m).friction });
            // A frozen axis has the coefficients 0, 0, 0 of a fixed point.
            for at in at..at + m.axes as usize {
                builder.load(loader, m.item, &m.values, &[at, n_mat + at, 2 * n_mat + at]);
            }
        }
    }
    for (p, at) in builder.point.iter().enumerate() {
        if *at != u32::MAX {
            all.rest[*at as usize] = net.rest(End::Point(p as u32))[0];
        }
    }
    all
}

/// Returns the index of the first weight coefficient, and the slots of MATs under gravity.
pub fn weigh(builder: &mut LayoutBuilder) -> (usize, Vec<u32>) {
    let net = builder.net;
    let first = builder.coef.len();
    let mut weighed = Vec::new();
    for (i, m) in net.mats.iter().enumerate() {
        if m.is_fixed() || builder.slot[i] == u32::MAX {
            continue;
        }
        for (k, g) in net.medium(m).gravity[..m.axes as usize].iter().enumerate().filter(|(_, g)| **g != 0.0) {
            weighed.push(builder.slot[i] + k as u32);
            builder.coef.push(0.0);
            let to = builder.coef.len() - 1;
            builder.load(Loader::Times(*g), m.item, &m.values, &[to]);
        }
    }
    (first, weighed)
}
