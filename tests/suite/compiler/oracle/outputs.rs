//! Channels of the oracle. A channel sums its outputs of positions and forces one by one, from sixteen on as eight
//! parallel sums; then its outputs of motion, one by one.

use super::network::{Network, OutputSignal};

impl Network {
    pub fn channel(&self, channel: usize) -> f64 {
        let (motions, plain): (Vec<_>, Vec<_>) = self
            .outputs
            .iter()
            .filter(|(c, _, _)| *c == channel)
            .partition(|o| matches!(o.2, OutputSignal::Motion(..)));
        let value = |signal: &OutputSignal| match signal {
            OutputSignal::Position(m, k) => self.mats[*m].x[*k],
            OutputSignal::Motion(m, k) => self.mats[*m].d[*k],
            OutputSignal::ForceOn(m, k) => self.mats[*m].f[*k],
            OutputSignal::ForceOf(link) => self.links[*link].f,
        };
        let values: Vec<f64> = plain.iter().map(|(_, gain, signal)| gain * value(signal)).collect();
        let lane = |k: usize| values.iter().skip(k).step_by(8).fold(0.0, |sum, v| sum + v);
        let sum = if values.len() < 16 {
            values.iter().fold(0.0, |sum, v| sum + v)
        } else {
            ((lane(0) + lane(4)) + (lane(2) + lane(6))) + ((lane(1) + lane(5)) + (lane(3) + lane(7)))
        };
        motions.iter().fold(sum, |sum, (_, gain, signal)| sum + gain * value(signal))
    }
}
