//! Solve order: which of the implicit links may be solved by themselves, and which are computed together.
//!
//! A link that counts on the motion all other forces would cause is right only if no other link of its kind changes
//! that motion. Decides by counting at every place that moves, so a row of contacts between separate pairs stays a row
//! of closed forms, and only those that share a mass pay for a solver.

use crate::findings::no_method;
use crate::net::{End, LiaNode, Measure, Pruned};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::vec::Vec;
use ca_core::op::SolveStage;
use ca_model::Model;
use ca_model::diag::Diags;

/// Gives links that may not act alone the law that acts together; refuses those at moving points, whose motion is that
/// of several masses.
pub fn choose(model: &Model, net: &mut Pruned, diags: &mut Diags) {
    let mut count: Vec<[u32; 3]> = alloc::vec![[0; 3]; net.mats.len()];
    let mut reported = BTreeSet::new();
    for l in net.lias.iter().filter(|l| l.law.is_staged()) {
        if let Some(point) = l.ends.into_iter().find(|e| matches!(e, End::Point(_))) {
            if reported.insert(l.item) {
                let title =
                    format!("the method of `{}` does not work at a moving point, `{}`", l.name, net.end_name(point));
                let help = "use `method = \"ca\"`, or a mass such as `low[8]` in its place";
                let item = &model.items[net.items[l.item as usize].model];
                diags.push(no_method(item, title, "not at moving points", help));
            }
        }
        for (m, axis) in places(net, l) {
            count[m as usize][axis as usize] += 1;
        }
    }
    let shared = |l: &LiaNode| {
        !matches!(l.measure, Measure::Line(_))
            || places(net, l).iter().any(|(m, k)| count[*m as usize][*k as usize] > 1)
    };
    let laws: Vec<_> = net
        .lias
        .iter()
        .map(|l| match l.law.stage {
            SolveStage::Single(together) if shared(l) => together,
            _ => l.law,
        })
        .collect();
    net.lias.iter_mut().zip(laws).for_each(|(l, law)| l.law = law);
}

/// The places that a link moves: MATs and axes.
fn places(net: &Pruned, l: &LiaNode) -> Vec<(u32, u8)> {
    let mut all = Vec::new();
    for (side, end) in l.ends.into_iter().enumerate() {
        let End::Mat(m) = end else { continue };
        let mat = &net.mats[m as usize];
        match l.measure {
            _ if mat.is_fixed() => {}
            Measure::Line(axes) => all.push((m, axes[side])),
            Measure::Along(_) | Measure::Radial => all.extend((0..mat.axes).map(|k| (m, k))),
        }
    }
    all
}
