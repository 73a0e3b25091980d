//! Waves of waveguides: those that arrive at junctions at the start of a tick, and those that leave at its end.
//!
//! Waves are velocities in \[m/tick\], like all motion. Between the two passes a junction is an ordinary MAT: `arrive`
//! adds 2 (Z/T) Σ vᵢ to the force on it, its damper takes 2 (Z/T) v, and `depart` uses v = (d′ + d)/2 after it has
//! moved (docs/numerics.md §7.2). A delay is a ring whose start follows from the tick, so waves are never copied.

use super::Op;
use crate::numeric::Real;
use crate::op::layout::{Delay, Layout, Termination};
use crate::state::State;

impl<R: Real> Delay<R> {
    /// Returns the index of the wave that left `back` ticks before `tick`; 0 gives the one that leaves in it.
    pub(crate) fn at(&self, tick: u64, back: usize) -> usize {
        let now = (tick % self.len as u64) as usize;
        self.first + if back > now { now + self.len - back } else { now - back }
    }

    /// Returns the last `way` waves that left before `tick`, as the one or two stretches of the ring that hold them.
    fn under_way<'m>(&self, mem: &'m [R], tick: u64, way: usize) -> [&'m [R]; 2] {
        let ring = &mem[self.first..][..self.len];
        let first = self.at(tick, way) - self.first;
        let whole = way.min(self.len - first);
        [&ring[first..][..whole], &ring[..way - whole]]
    }
}

/// Computes the waves that arrive now, and their force on the junctions.
pub fn arrive<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let w = &layout.waves;
    for d in &w.delays {
        let wave = match d.end {
            Termination::Open => s.links.mem[d.at(s.tick, d.len)],
            Termination::Rigid => -s.links.mem[d.at(s.tick, d.len)],
            Termination::Lossy { loss, memory } => {
                // the ring is three longer than the delay and so still holds the inputs of the taps
                let [u0, u1, u2] = [3, 2, 1].map(|less| s.links.mem[d.at(s.tick, d.len - less)]);
                let [a, b, c] = [loss.a, loss.b, loss.c].map(R::inner);
                let u = a * u1 + b * (u0 + u2);
                let y = c * u + s.links.mem[memory];
                s.links.mem[memory] = u - c * y;
                -y
            }
        };
        s.links.mem[d.to] = wave;
    }
    for j in &w.junctions {
        let m = j.mat as usize;
        s.f[m] += R::of(2.0) * R::inner(j.z) * (s.links.mem[j.memory] + s.links.mem[j.memory + 1]);
        s.links.mem[j.memory + 2] = s.d[m];
    }
}

/// Stores the waves that leave, after the junctions have moved.
pub fn depart<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for d in &layout.waves.delays {
        let j = &layout.waves.junctions[d.junction];
        let v = R::of(0.5) * (s.d[j.mat as usize] + s.links.mem[j.memory + 2]);
        s.links.mem[d.at(s.tick, 0)] = v - s.links.mem[d.from];
    }
}

/// Returns the sum of squares, in eight partial sums, which do not wait for each other.
fn squares<R: Real>(all: &[R]) -> R::Outer {
    let (whole, rest) = all.as_chunks::<8>();
    let mut sums = [R::Outer::ZERO; 8];
    for eight in whole {
        for (sum, v) in sums.iter_mut().zip(eight) {
            *sum += v.outer() * v.outer();
        }
    }
    sums.iter().sum::<R::Outer>() + rest.iter().map(|v| v.outer() * v.outer()).sum::<R::Outer>()
}

/// Returns the energy of the waves under way after a tick, and the heat of the ends in that tick less the energy that
/// the dampers of the junctions gave to the waves \[J\]. `d0` is the motion into the tick.
///
/// The taps turn at least (1 − (a+2b)²) of their input to heat if b (a+2b) of the square of their older input and
/// (a+b)(a+2b) of the newer one count as stored. An allpass of memory q stores q²/(1 − c²).
pub fn energy<R: Real>(layout: &Layout<R>, s: &State<R>, d0: &[R]) -> (R::Outer, R::Outer) {
    let w = &layout.waves;
    let (mut stored, mut heat) = (R::Outer::ZERO, R::Outer::ZERO);
    for d in &w.delays {
        let wave = |back: usize| s.links.mem[d.at(s.tick, back)].outer();
        let energy = |v: R::Outer| v * v;
        let mut sum = R::Outer::ZERO;
        let way = if let Termination::Lossy { loss, memory } = d.end {
            let way = d.len - 3;
            let [a, b, c] = [loss.a, loss.b, loss.c];
            let [u0, u1, u2] = [1, 2, 3].map(|more| wave(way + more));
            let gain = a + R::Outer::of(2.0) * b;
            let (newer, older) = (gain * (a + b), gain * b);
            let taps = |u: R::Outer, v: R::Outer| newer * energy(u) + older * energy(v);
            sum += taps(u0, u1) + energy(s.links.mem[memory].outer()) / (R::Outer::of(1.0) - c * c);
            let out = energy(a * u1 + b * (u0 + u2));
            heat += w.junctions[d.junction].z * (energy(u0) + taps(u1, u2) - out - taps(u0, u1));
            way
        } else {
            d.len
        };
        let [older, newer] = d.under_way(&s.links.mem, s.tick, way);
        sum += squares(older) + squares(newer);
        stored += w.junctions[d.junction].z * sum;
    }
    for j in &w.junctions {
        let v = R::Outer::of(0.5) * (s.d[j.mat as usize] + d0[j.mat as usize]).outer();
        heat -= R::Outer::of(2.0) * j.z * v * v;
    }
    (stored, heat)
}
