//! Modes of a linear network: frequencies with and without the scheme, decay, and shapes.
//!
//! With a = ω²T² and b = zT/m of a mode, the poles of the scheme are the roots of w² − (2 − a − b) w + (1 − b). The
//! pitch is (fs/2π) arg w, and the decay per sample is |w| = √(1 − b) (docs/numerics.md §1.2, §1.4). Without the scheme
//! the mode has the frequency √(ω² − s²) and the decay e^(−st), s = b/2T.
//!
//! The modes come from one symmetric eigenproblem, of T² M^-½ K M^-½, so that they are orthogonal and complete. Damping
//! that is not proportional couples them, by the amount in [`Mode::coupled`]. Up to [`EXACT`] dofs the poles are then
//! computed from the whole scheme.

use crate::analysis::linear::{Linear, Network};
use alloc::vec::Vec;
use ca_core::internal::method::pefrl::explicit;
use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};

pub use crate::MOST_MODES as LARGEST;
/// Largest number of dofs for which coupled poles are computed.
pub const EXACT: usize = 400;
/// Coupling by damping above this is more than rounding.
const COUPLED: f64 = 1e-9;

/// One mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// ω²T².
    pub a: f64,
    /// zT/m of the mode.
    pub b: f64,
    /// Frequency without the scheme \[Hz\]; 0 if it does not oscillate.
    pub f: f64,
    /// Frequency with the scheme \[Hz\]; 0 if it does not oscillate.
    pub heard: f64,
    /// Time to decay by 60 dB with the scheme \[s\]; infinite without damping.
    pub t60: f64,
    /// Time to decay by 60 dB without the scheme \[s\].
    pub t60_free: f64,
    /// True if it grows by the scheme, so that the scene is unstable.
    pub grows: bool,
    /// Largest coupling to another mode by damping: their common damping over the sum of their distance and own
    /// damping.
    pub coupled: f64,
    /// Displacement of each dof \[1/√kg\], for a modal mass of 1 kg.
    pub shape: Vec<f64>,
}

/// All modes of a network.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// Modes, lowest first.
    pub list: Vec<Mode>,
    /// True if the figures ignore the coupling by damping: each mode is taken by itself.
    pub approximate: bool,
}

impl Mode {
    /// Returns the shift of its pitch by the scheme \[cents\]; 0 if it does not oscillate.
    pub fn cents(&self) -> f64 {
        if self.f > 0.0 && self.heard > 0.0 { 1200.0 * libm::log2(self.heard / self.f) } else { 0.0 }
    }

    /// Returns its displacement `t` ticks after displacement `x` and speed `v` per tick, without the scheme.
    pub fn free(&self, x: f64, v: f64, t: f64) -> f64 {
        let s = 0.5 * self.b;
        let (square, v) = (self.a - s * s, v + s * x);
        // e^(−s t) multiplies each part, so that none overflows.
        if square > 0.0 {
            let w = libm::sqrt(square);
            let (sin, cos) = libm::sincos(w * t);
            return libm::exp(-s * t) * (x * cos + v / w * sin);
        }
        let g = libm::sqrt(-square);
        let (slow, fast) = (libm::exp((g - s) * t), libm::exp((-g - s) * t));
        let turned = if g > 0.0 { 0.5 * (slow - fast) / g } else { t * libm::exp(-s * t) };
        0.5 * x * (slow + fast) + v * turned
    }

    /// Returns the displacement of a port by the mode \[1/√kg\].
    pub fn at(&self, port: &[(u32, f64)]) -> f64 {
        port.iter().map(|(i, w)| w * self.shape.get(*i as usize).copied().unwrap_or(0.0)).sum()
    }
}

/// Returns T² M^-½ K M^-½ and T M^-½ C M^-½, and the inertia that implicit methods add, scaled alike, if they add any.
fn matrices(linear: &Linear) -> (Mat<f64>, Mat<f64>, Option<Mat<f64>>) {
    let n = linear.dofs.len();
    let root: Vec<f64> = linear.dofs.iter().map(|p| libm::sqrt(p.c)).collect();
    let (mut k, mut z) = (Mat::<f64>::zeros(n, n), Mat::<f64>::zeros(n, n));
    let some = linear.dofs.iter().any(|p| p.implicit != 0.0) || linear.rows.iter().any(|r| r.implicit != 0.0);
    let mut implicit = some.then(|| Mat::<f64>::zeros(n, n));
    for (i, p) in linear.dofs.iter().enumerate() {
        k[(i, i)] += p.c * p.k;
        z[(i, i)] += p.c * p.z;
        if let Some(a) = &mut implicit {
            a[(i, i)] += p.c * p.implicit;
        }
    }
    for row in &linear.rows {
        let entries = linear.entries(row);
        for (i, a) in entries {
            for (j, b) in entries {
                let (i, j) = (*i as usize, *j as usize);
                let both = a * root[i] * (b * root[j]);
                k[(i, j)] += row.k * both;
                z[(i, j)] += row.z * both;
                if let Some(m) = &mut implicit {
                    m[(i, j)] += row.implicit * both;
                }
            }
        }
    }
    (k, z, implicit)
}

/// Returns ω²T² and zT/m of a mode from its shape, which is scaled by the roots of the masses.
///
/// Both are sums over links of squared elongations. A low mode bends each link little, and its eigenvalue would only be
/// accurate to the rounding of the highest one.
fn rayleigh(linear: &Linear, u: impl Fn(u32) -> f64) -> (f64, f64) {
    let (mut a, mut b, mut whole) = (0.0, 0.0, 0.0);
    for (p, i) in linear.dofs.iter().zip(0..) {
        let square = u(i) * u(i);
        a += p.c * p.k * square;
        b += p.c * p.z * square;
        whole += square;
    }
    for row in &linear.rows {
        let at = |i: &u32| u(*i) * libm::sqrt(linear.dofs[*i as usize].c);
        let e: f64 = linear.entries(row).iter().map(|(i, w)| w * at(i)).sum();
        a += row.k * e * e;
        b += row.z * e * e;
    }
    (a / whole, b / whole)
}

/// Returns the modes of a network; `None` if it is too large or the computation fails.
pub fn modes(network: &Network) -> Option<Modes> {
    let n = network.linear.dofs.len();
    if n > LARGEST {
        return None;
    }
    if n == 0 {
        return Some(Modes { list: Vec::new(), approximate: false });
    }
    let tick_dt = network.tick_dt;
    let (mut k, mut z, implicit) = matrices(&network.linear);
    let found = k.self_adjoint_eigen(Side::Lower).ok()?;
    let (u, values) = (found.U(), found.S());
    let damping = u.transpose() * &z * u;
    let heavier = implicit.as_ref().map(|a| u.transpose() * a * u);
    let top = (0..n).map(|j| values[j]).fold(0.0, f64::max);
    let mut list: Vec<Mode> = Vec::with_capacity(n);
    for j in 0..n {
        // A free motion, except for rounding.
        let free = values[j].abs() <= 1e-13 * top;
        let (a, b) = rayleigh(&network.linear, |i| u[(i as usize, j)]);
        let (a, b) = (if free { 0.0 } else { a }, b.max(0.0));
        let coupled = (0..n)
            .filter(|i| *i != j)
            .map(|i| {
                damping[(i, j)].abs() / ((values[i] - values[j]).abs() + damping[(i, i)].max(b)).max(f64::MIN_POSITIVE)
            })
            .fold(0.0, f64::max);
        let dofs = &network.linear.dofs;
        let shape = (0..n).map(|i| u[(i, j)] * libm::sqrt(dofs[i].c) / tick_dt).collect();
        let mut mode = Mode {
            a,
            b,
            f: 0.0,
            heard: 0.0,
            t60: f64::INFINITY,
            t60_free: f64::INFINITY,
            grows: false,
            coupled,
            shape,
        };
        mode.compute_uncoupled(tick_dt, 1.0 + heavier.as_ref().map_or(0.0, |h| h[(j, j)]), network.composed);
        if network.modal {
            (mode.heard, mode.t60, mode.grows) = (mode.f, mode.t60_free, false);
        }
        list.push(mode);
    }
    let coupled = !network.modal && (implicit.is_some() || list.iter().any(|m| m.coupled > COUPLED));
    if coupled && n <= EXACT {
        if let Some(mut a) = implicit {
            (0..n).for_each(|i| a[(i, i)] += 1.0);
            let a = a.partial_piv_lu();
            (k, z) = (a.solve(&k), a.solve(&z));
        }
        poles(&k, &z, u, tick_dt, &mut list)?;
    }
    Some(Modes { list, approximate: coupled && n > EXACT })
}

const TURN: f64 = core::f64::consts::TAU;

/// Returns the time for 60 dB at a rate of decay \[1/s\]. It is infinite if the loss per tick is within `known` times
/// its rounding.
fn t60(s: f64, tick_dt: f64, known: f64) -> f64 {
    if s * tick_dt > known * f64::EPSILON { 3.0 * core::f64::consts::LN_10 / s } else { f64::INFINITY }
}

impl Mode {
    /// Computes pitch and decay of the mode by itself, with the inertia of implicit methods or by the `composed`
    /// method.
    fn compute_uncoupled(&mut self, tick_dt: f64, heavier: f64, composed: bool) {
        let (a, b) = (self.a, self.b);
        // Continuous: ω² = a/T², s = b/2T.
        let (square, s) = (a - 0.25 * b * b, 0.5 * b / tick_dt);
        let t60 = |s: f64| t60(s, tick_dt, 1.0);
        self.f = if square > 0.0 && a > 0.0 { libm::sqrt(square) / (TURN * tick_dt) } else { 0.0 };
        self.t60_free = match () {
            () if a == 0.0 => t60(2.0 * s),
            () if square >= 0.0 => t60(s),
            () => t60(s - libm::sqrt(-square) / tick_dt),
        };
        let (a, b) = (if composed { explicit(a) } else { a / heavier }, b / heavier);
        // The two poles of the scheme have the mean 1 − (a + b)/2; their distance is twice the root of `off`.
        let half = 1.0 - 0.5 * (a + b);
        let off = a - 0.25 * (a + b) * (a + b);
        if off > 0.0 && a > 0.0 {
            self.heard = libm::atan2(libm::sqrt(off), half) / (TURN * tick_dt);
            self.t60 = t60(-0.5 * libm::log1p(-b) / tick_dt);
        } else {
            let slowest = half.abs() + libm::sqrt((-off).max(0.0));
            self.grows = a > 0.0 && slowest > 1.0;
            self.t60 = if a == 0.0 { t60(-libm::log1p(-b) / tick_dt) } else { t60(-libm::log(slowest) / tick_dt) };
        }
    }
}

/// Computes the poles of the whole scheme and assigns them to the modes with the most similar shapes.
fn poles(k: &Mat<f64>, z: &Mat<f64>, u: faer::MatRef<'_, f64>, tick_dt: f64, list: &mut [Mode]) -> Option<()> {
    let n = list.len();
    let mut map = Mat::<f64>::zeros(2 * n, 2 * n);
    for i in 0..n {
        for j in 0..n {
            let one = if i == j { 1.0 } else { 0.0 };
            map[(i, j)] = 2.0 * one - k[(i, j)] - z[(i, j)];
            map[(i, n + j)] = z[(i, j)] - one;
        }
        map[(n + i, i)] = 1.0;
    }
    let found = map.eigen().ok()?;
    let (vectors, values) = (found.U(), found.S());
    let swings: Vec<usize> = (0..2 * n).filter(|p| values[*p].im > 1e-12).collect();
    // Share of each mode in the shape of each pole.
    let mut pairs: Vec<(f64, usize, usize)> = Vec::with_capacity(swings.len() * n);
    for p in swings {
        let mut dots = alloc::vec![(0.0, 0.0); n];
        let mut whole = 0.0;
        for (j, dot) in dots.iter_mut().enumerate() {
            for i in 0..n {
                dot.0 += u[(i, j)] * vectors[(i, p)].re;
                dot.1 += u[(i, j)] * vectors[(i, p)].im;
            }
            whole += dot.0 * dot.0 + dot.1 * dot.1;
        }
        pairs.extend(dots.iter().enumerate().map(|(j, d)| ((d.0 * d.0 + d.1 * d.1) / whole, j, p)));
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut given, mut taken) = (alloc::vec![false; n], alloc::vec![false; 2 * n]);
    for (_, j, p) in pairs {
        if given[j] || taken[p] || list[j].heard == 0.0 {
            continue;
        }
        (given[j], taken[p]) = (true, true);
        let w = values[p];
        list[j].heard = libm::atan2(w.im, w.re) / (TURN * tick_dt);
        // The matrix has 2n rows, whose rounding limits the accuracy of a pole.
        list[j].t60 = t60(-libm::log(libm::hypot(w.re, w.im)) / tick_dt, tick_dt, 8.0 * n as f64);
    }
    Some(())
}
