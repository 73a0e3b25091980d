//! Closed form of x_{n+1} = (2 − a − b) x_n + (b − 1) x_{n−1}, a = kT²/m, b = zT/m, with derivatives by its roots.

use crate::reference::{apart, column, read, tangents};
use std::ops::{Add, Div, Mul, Sub};

/// Number with one derivative. The closed form uses these, with other formulas than the scheme.
#[derive(Clone, Copy, Debug)]
pub struct D(pub f64, pub f64);

impl Add for D {
    type Output = D;
    fn add(self, o: D) -> D {
        D(self.0 + o.0, self.1 + o.1)
    }
}
impl Sub for D {
    type Output = D;
    fn sub(self, o: D) -> D {
        D(self.0 - o.0, self.1 - o.1)
    }
}
impl Mul for D {
    type Output = D;
    // product rule
    #[allow(clippy::suspicious_arithmetic_impl)]
    fn mul(self, o: D) -> D {
        D(self.0 * o.0, self.0 * o.1 + self.1 * o.0)
    }
}
impl Div for D {
    type Output = D;
    fn div(self, o: D) -> D {
        D(self.0 / o.0, (self.1 * o.0 - self.0 * o.1) / (o.0 * o.0))
    }
}

pub const fn c(v: f64) -> D {
    D(v, 0.0)
}

/// Closed form for r² = 1 − b and 2 r cos θ = 2 − a − b: x_n = rⁿ (A cos nθ + B sin nθ), from x₀ and x₋₁.
pub fn oscillator(ticks: usize, [m, k, z, x, v]: [D; 5]) -> Vec<D> {
    let t = c(1.0 / 48_000.0);
    let (a, b) = (k * t * t / m, z * t / m);
    let (r2, twice) = (c(1.0) - b, c(2.0) - a - b);
    let r = D(r2.0.sqrt(), r2.1 / (2.0 * r2.0.sqrt()));
    let cos = twice / (c(2.0) * r);
    let theta = D(cos.0.acos(), -cos.1 / (1.0 - cos.0 * cos.0).sqrt());
    let sin = D(theta.0.sin(), theta.0.cos() * theta.1);
    // the start (docs/numerics.md §1.1): d₀ = vT − ½ of the change in one tick from (x₀, vT)
    let moved = v * t;
    let change = c(-1.0) * a * x - b * moved;
    let before = x - (moved - c(0.5) * change);
    // x₋₁ = (A cos θ − B sin θ)/r
    let (big_a, big_b) = (x, (x * cos - r * before) / sin);
    let angle = |n: f64| D(n * theta.0, n * theta.1);
    (0..ticks)
        .map(|n| {
            let n = n as f64;
            let power = D(r.0.powf(n), n * r.0.powf(n - 1.0) * r.1);
            let w = angle(n);
            let (cos, sin) = (D(w.0.cos(), -w.0.sin() * w.1), D(w.0.sin(), w.0.cos() * w.1));
            power * (big_a * cos + big_b * sin)
        })
        .collect()
}

/// d x_n by m, k, z, dx0 and v of a cell, over 2000 ticks.
#[test]
fn an_oscillator_has_the_derivatives_of_its_roots() {
    let values = [2e-3, 9e3, 0.02, 1e-3, 0.3];
    let [m, k, z, x, v] = values;
    let text = format!(
        "[CEL]\nbar = {{ m = {m:?}, k = {k:?}, z = {z:?}, dx0 = {x:?}, v = {v:?} }}\n[SOX]\nout = {{ from = \"bar\" }}\n"
    );
    let names = ["bar.m", "bar.k", "bar.z", "bar.dx0", "bar.v"];
    let t = tangents(&read(&text), 2000, &names);
    for (i, name) in names.iter().enumerate() {
        let mut given = values.map(c);
        given[i].1 = 1.0;
        let exact: Vec<f64> = oscillator(2000, given).iter().map(|d| d.1).collect();
        let off = apart(&column(&t, i), &exact);
        println!("{name}: {off:.1e}");
        assert!(off < 1e-10, "{name}: {off:e}");
    }
    let exact: Vec<f64> = oscillator(2000, values.map(c)).iter().map(|d| d.0).collect();
    assert!(apart(&t.output, &exact) < 1e-10);
}
