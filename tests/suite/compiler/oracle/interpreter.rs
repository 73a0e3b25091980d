//! The oracle plays a network module by module, tick by tick, with the textbook equations of CORDIS-ANIMA.
//! It shares no code with the compiler. To give the same bits it sums links in document order.

use super::network::{Law, Link, Network, Point};
use ca_tests::follow;

/// x to the power of quarters/4, by products and roots.
fn power(x: f64, quarters: u32) -> f64 {
    let whole = (0..quarters / 4).fold(1.0, |y, _| y * x);
    let half = if quarters & 2 == 0 { whole } else { whole * x.sqrt() };
    if quarters & 1 == 0 { half } else { half * x.sqrt().sqrt() }
}

impl Law {
    /// Force on the first end, for an elongation e [m] and its change w in the last tick [m].
    fn force(&mut self, e: f64, w: f64) -> f64 {
        match *self {
            Law::Linear { k, z } => k * e + z * w,
            Law::Cubic { k, k3, z } => (k + k3 * e * e) * e + z * w,
            Law::Power { k, q, quarters, z } => k * e + q * power(e.abs(), quarters).copysign(e) + z * w,
            Law::Buffer { d, side, .. } if side * (e - d) >= 0.0 => 0.0,
            Law::Buffer { k, z, d, side, sticky } => {
                let f = k * (e - d) + z * w;
                if sticky || side * f <= 0.0 { f } else { 0.0 }
            }
            Law::Hertz { d, side, .. } if side * (d - e) <= 0.0 => 0.0,
            Law::Hertz { k, quarters, h, d, side } => {
                -side * (k * power(side * (d - e), quarters) * (1.0 - h * side * w)).max(0.0)
            }
            Law::Attract { d, .. } if e.abs() >= d => 0.0,
            Law::Attract { k, z, d, rho } if e.abs() < rho * d => k * e + z * w,
            Law::Attract { k, z, d, rho } => (k * rho / (1.0 - rho) * (d - e.abs())).copysign(e) + z * w,
            Law::Pluck { k, z, d, side, engaged, ref mut held, ref mut last } => {
                if held.is_none() {
                    (*held, *last) = (Some(engaged && side * e >= 0.0), e);
                }
                let (rises, falls) = (*last <= 0.0 && e >= 0.0, *last >= 0.0 && e <= 0.0);
                let takes = rises && side >= 0.0 || falls && side <= 0.0;
                let holds = e.abs() < d && if *held == Some(true) { side * e >= 0.0 } else { takes };
                (*held, *last) = (Some(holds), e);
                if holds { k * e + z * w } else { 0.0 }
            }
            Law::Curves { ref spring, ref friction, tick_dt } => {
                let pull = spring.as_ref().map_or(0.0, |s| follow(s, e));
                pull + friction.as_ref().map_or(0.0, |f| follow(f, w * (1.0 / tick_dt)))
            }
            Law::Stribeck { f, v0, .. } if w.abs() < v0 => f / v0 * w,
            Law::Stribeck { f, fd, v0, v1 } => (fd + (f - fd) / (v1 - v0) * (v1 - w.abs()).max(0.0)).copysign(w),
            Law::Smooth { f, v0, ref bell } => (f * follow(bell, w.abs() * (1.0 / v0))).copysign(w),
            Law::Listed(ref mut law) => law.force(e, w),
        }
    }
}

impl Network {
    /// Nodes of a point and their weights.
    fn parts(&self, point: &Point) -> Vec<(usize, f64)> {
        let mut parts = vec![(0, 1.0)];
        for (at, n) in point.at.iter().zip(point.size) {
            let u = (self.mats[*at].x[0] + self.mats[*at].rest[0]).clamp(0.0, 1.0) * (n - 1) as f64;
            let cell = (u as usize).min(n - 2);
            let b = u - cell as f64;
            let split = |(i, a)| [(i * n + cell, a * (1.0 - b)), (i * n + cell + 1, a * b)];
            parts = parts.into_iter().flat_map(split).collect();
        }
        parts.into_iter().map(|(i, a)| (point.nodes[i], a)).collect()
    }

    /// Adds gravity, then waves, links in document order, forces on lines, and last the forces on moving points.
    fn forces(&mut self) {
        for at in 0..self.points.len() {
            let (mat, parts) = (self.points[at].mat, self.parts(&self.points[at]));
            self.mats[mat].x[0] = parts.iter().fold(0.0, |x, (node, a)| x + a * self.mats[*node].x[0]);
            self.mats[mat].d[0] = parts.iter().fold(0.0, |d, (node, a)| d + a * self.mats[*node].d[0]);
        }
        self.mats.iter_mut().for_each(|m| (0..3).for_each(|k| m.f[k] += m.weight[k]));
        self.lines.iter_mut().for_each(|l| l.arrive(&mut self.mats));
        for link in &mut self.links {
            let measured = link.measure(&self.mats);
            let sum = |of: fn(&super::measure::Measurement) -> f64| {
                measured.iter().map(of).reduce(|a, b| a + b).unwrap_or(0.0)
            };
            link.f = link.law.force(sum(|p| p.e) + link.e0, sum(|p| p.w));
            for (([a, b], measure), measured) in link.ports.iter().zip(&measured) {
                let g = measured.pull(link.f);
                for [i, j] in measure.axes() {
                    self.mats[*a].f[i] += g[i];
                    self.mats[*b].f[j] -= g[j];
                }
            }
        }
        self.pushed.drain(..).for_each(|(m, force)| self.mats[m].f[0] += force);
        for point in &self.points {
            for (node, a) in self.parts(point) {
                self.mats[node].f[0] += a * self.mats[point.mat].f[0];
            }
        }
    }

    /// Converts initial speeds v, stored as d = vT, to the motion half a tick earlier with which the scheme starts.
    pub fn start(&mut self) {
        self.forces();
        self.links.iter_mut().for_each(Link::forget);
        for m in &mut self.mats {
            let [p, q, c] = m.pqc;
            for k in 0..m.axes {
                let d = m.d[k];
                m.d[k] = if c == 0.0 { 0.0 } else { d - 0.5 * (c * m.f[k] + q * m.x[k] - (1.0 - p) * d) };
            }
            m.f = [0.0; 3];
        }
    }

    /// Runs one tick from port values to channels.
    pub fn tick(&mut self, inputs: &[f64], out: &mut [f64]) {
        for (port, value) in self.ports.iter_mut().zip(inputs) {
            let Some(period) = port.period else {
                port.to.iter().for_each(|m| self.mats[*m].push((*m, port.axis, *value), &mut self.pushed));
                continue;
            };
            let (m, phase) = (&mut self.mats[port.to[0]], (self.n.max(1) - 1) % period + 1);
            if phase == 1 {
                (port.from, port.held) = (port.held, value - m.rest[port.axis]);
            }
            let way = port.held - port.from;
            let x =
                if self.n == 0 || phase == period { port.held } else { port.from + phase as f64 / period as f64 * way };
            let last = m.x[port.axis];
            (m.d[port.axis], m.x[port.axis]) = (if self.n == 0 { 0.0 } else { x - last }, x);
        }
        self.forces();
        out.fill(0.0);
        out.iter_mut().enumerate().for_each(|(channel, sum)| *sum = self.channel(channel));
        for m in &mut self.mats {
            for k in 0..if m.pqc[2] == 0.0 { 0 } else { m.axes } {
                m.d[k] = m.pqc[0] * m.d[k] + m.pqc[1] * m.x[k] + m.pqc[2] * m.f[k];
                m.x[k] += m.d[k];
            }
            // flushes tiny numbers to zero, because denormal numbers are slow
            if self.n & 1023 == 1023 {
                let alive = |v: f64| if v.abs() < 1e-270 { 0.0 } else { v };
                (m.x, m.d) = (m.x.map(alive), m.d.map(alive));
            }
            m.f = [0.0; 3];
        }
        self.lines.iter_mut().for_each(|l| l.depart(&self.mats));
        self.n += 1;
    }
}
