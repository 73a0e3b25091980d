//! Strings of travelling waves in textbook form: a shift register for each direction, one wave in and one out.
//!
//! Delays and end filters come from the compiler's own tuning, whose poles are tested elsewhere. Propagation and
//! junctions are written here a second time.

use super::expand::{Family, mat};
use super::network::{Mat, Network};
use super::numbers::{Numbers, entry, list};
use ca_core::internal::tuning::wave::{HighDecay, Loss, WaveguideSpec, tune};
use ca_model::Item;
use std::collections::VecDeque;

/// A string: junction j receives waves from the left through way 2j and from the right through way 2j + 1.
pub struct Line {
    /// Masses of the junctions.
    mats: Vec<usize>,
    /// Wave impedance of a side \[N per m/tick\].
    z: f64,
    /// Waves in transit, oldest first.
    ways: Vec<VecDeque<f64>>,
    /// Filters of the near and the far end, and the memories of their allpasses.
    ends: [Option<Loss>; 2],
    memory: [f64; 2],
    /// Waves that arrived in this tick, by way.
    arrived: Vec<f64>,
    /// Motion of the junctions before the tick \[m\].
    before: Vec<f64>,
}

/// A WAVEGUIDE whose junctions have an explicit mass.
pub fn string(numbers: &Numbers, net: &mut Network, i: &Item) -> Family {
    let tick_dt = numbers.tick_dt;
    let num = |key: &str| numbers.maybe(i, key);
    let z = num("z").unwrap_or_else(|| (numbers.num(i, "tension") * numbers.num(i, "mu")).sqrt());
    let at = entry(&i.args, "at").expect("at");
    let at: Vec<f64> = match list(at) {
        [] => vec![numbers.value(at, 0.0)],
        many => many.iter().map(|e| numbers.value(&e.value, 0.0)).collect(),
    };
    let high = num("t60_high").map(|t60| [num("f_high").unwrap_or(5000.0), t60]);
    let (m, n) = (num("m").expect("a written mass"), at.len());
    let asked =
        WaveguideSpec { f: num("f").expect("f"), t60: num("t60").unwrap_or(f64::INFINITY), high, z, at, m: Some(m) };
    let tuned = tune(&asked, &vec![m; n], tick_dt, HighDecay::Pole).expect("a string");
    let cell = m + z * tick_dt;
    let masses: Vec<usize> = (0..n).map(|_| mat(numbers, net, i, cell, 1.0 - 2.0 * z * tick_dt / cell, -0.0)).collect();
    // waves reach junction j from the junction before it on the left, and from the next on the right
    let way = |k: usize| match k {
        0 => tuned.delays[0] + usize::from(tuned.near.is_some()),
        _ if k == 2 * n - 1 => tuned.delays[n] + 3,
        _ => tuned.delays[k.div_ceil(2)],
    };
    net.lines.push(Line {
        mats: masses.clone(),
        z: z / tick_dt,
        ways: (0..2 * n).map(|k| vec![0.0; way(k)].into()).collect(),
        ends: [tuned.near, Some(tuned.loss)],
        memory: [0.0; 2],
        arrived: vec![0.0; 2 * n],
        before: vec![0.0; n],
    });
    Family { masses, size: [1, 1], ..Family::default() }
}

impl Line {
    /// Takes the waves that arrive and adds their forces.
    pub fn arrive(&mut self, mats: &mut [Mat]) {
        let last = self.ways.len() - 1;
        for (k, way) in self.ways.iter().enumerate() {
            let end = usize::from(k == last);
            self.arrived[k] = match self.ends[end] {
                _ if k > 0 && k < last => way[0],
                None => -way[0],
                Some(loss) => {
                    let u = loss.a * way[2] + loss.b * (way[3] + way[1]);
                    let y = loss.c * u + self.memory[end];
                    self.memory[end] = u - loss.c * y;
                    -y
                }
            };
        }
        for (j, m) in self.mats.iter().enumerate() {
            mats[*m].f[0] += 2.0 * self.z * (self.arrived[2 * j] + self.arrived[2 * j + 1]);
            self.before[j] = mats[*m].d[0];
        }
    }

    /// Sends the outgoing waves.
    pub fn depart(&mut self, mats: &[Mat]) {
        let last = self.ways.len() - 1;
        for k in 0..=last {
            // a wave leaving a junction to the left reaches the one before from its right; at the ends it returns
            let from = match k {
                0 => 0,
                _ if k == last => last,
                _ if k % 2 == 0 => k - 1,
                _ => k + 1,
            };
            let v = 0.5 * (mats[self.mats[from / 2]].d[0] + self.before[from / 2]);
            self.ways[k].pop_front();
            self.ways[k].push_back(v - self.arrived[from]);
        }
    }
}
