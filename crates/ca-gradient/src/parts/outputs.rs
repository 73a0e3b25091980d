//! Outputs: what each of a scene hears, and how.

use ca_core::Scene;
use ca_core::internal::op::layout::{Output, Tap};

/// An output of a scene.
pub struct Listed {
    pub channel: usize,
    pub tap: Tap,
    /// index of its gain into the coefficients
    pub gain: usize,
    /// it hears motion
    pub motion: bool,
    /// number of its high pass
    pub high_pass: Option<usize>,
    /// how many before it hear forces
    pub forces: usize,
}

/// The outputs of a scene, in its order.
pub fn listed(scene: &Scene) -> impl Iterator<Item = Listed> + '_ {
    let l = &scene.layout;
    let gains = scene.passes.writes.iter().find(|op| op.name() == "outputs").map_or(0, |op| op.coef);
    let [motion, passed] = l.out.of_motion;
    let (n, high) = (l.out.outputs.len(), l.out.blockers.len());
    let mut forces = 0;
    l.out.outputs.iter().enumerate().map(move |(k, o): (usize, &Output)| {
        let before = forces;
        forces += usize::from(!matches!(o.tap, Tap::Position(_)));
        Listed {
            channel: o.channel as usize,
            tap: o.tap,
            gain: gains + k,
            motion: k >= n - passed || (n - high - motion..n - high).contains(&k),
            high_pass: k.checked_sub(n - high),
            forces: before,
        }
    })
}
