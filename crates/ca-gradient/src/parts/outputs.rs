//! Outputs of a scene: what each one reads, and how.

use ca_core::Scene;
use ca_core::internal::op::layout::{Output, Tap};

pub struct Listed {
    pub channel: usize,
    pub tap: Tap,
    /// Index of its gain into the coefficients.
    pub gain: usize,
    pub motion: bool,
    /// Index of its high pass.
    pub high_pass: Option<usize>,
    /// Number of outputs before it that read forces.
    pub forces: usize,
}

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
