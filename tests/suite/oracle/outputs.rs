//! What a channel sounds in the oracle: its outputs one by one, and from sixteen on in eight sums beside each other.

use super::network::{Heard, Network};

impl Network {
    /// The sum of a channel.
    pub fn heard(&self, channel: usize) -> f64 {
        let of_channel = self.outputs.iter().filter(|(c, _, _)| *c == channel);
        let value = |heard: &Heard| match heard {
            Heard::Position(m, k) => self.mats[*m].x[*k],
            Heard::Motion(m, k) => self.mats[*m].d[*k],
            Heard::ForceOn(m, k) => self.mats[*m].f[*k],
            Heard::ForceOf(link) => self.links[*link].f,
        };
        let values: Vec<f64> = of_channel.map(|(_, gain, heard)| gain * value(heard)).collect();
        if values.len() < 16 {
            return values.iter().fold(0.0, |sum, v| sum + v);
        }
        let lane = |k: usize| values.iter().skip(k).step_by(8).fold(0.0, |sum, v| sum + v);
        ((lane(0) + lane(4)) + (lane(2) + lane(6))) + ((lane(1) + lane(5)) + (lane(3) + lane(7)))
    }
}
