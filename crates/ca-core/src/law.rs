//! The shape of a law of interaction.
//!
//! A law is written **once**, as a [`Phi`]: a force from the elongation `e = x_j − x_i + e₀` and its change per tick
//! `w = d_j − d_i`, where F > 0 pulls the ends together. All forms of the law (here and in LPR), the energy ledger and
//! the stability bounds call it. A law never sees positions, so it does not depend on the dimension.
//!
//! Coefficients are an array of fixed size. The kernels read it by columns, so that a homogeneous pass vectorises.

use crate::numeric::{Real, Table};
use core::ops::{Add, Mul, Sub};

/// Number type of a linear law: a number, or a vector with one link in each lane.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Number for T {}

/// Linear bound of a law: its largest slopes, `k` \[N/m\] against elongation and `z` \[N/(m/tick)\] against its change.
///
/// The bound is exact for linear laws and for contacts of constant stiffness. For laws that stiffen without limit
/// (`hardens`) it is the slope at rest; see [`Phi::steepest`]. Both are ≥ 0 except for springs that are negative on
/// purpose.
// six independent flags
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bound {
    /// largest slope against elongation \[N/m\]
    pub k: f64,
    /// part of `k` that the law has at some elongations only, such as a table or a softening spring \[N/m\]
    pub varying: f64,
    /// largest slope against change of elongation per tick \[N per m/tick\]
    pub z: f64,
    /// true where the force switches on and off with distance
    pub contact: bool,
    /// true where the law is linear and the bound is therefore exact
    pub linear: bool,
    /// true where `z` is the steepest slope of a curve against speed, such as dry friction
    pub curve: bool,
    /// true where a slope grows without limit with elongation; `k` and `z` are then those at rest
    pub hardens: bool,
    /// factor \[N/m^p\] and p of a contact that grows with a power of its depth, η^p; 0 for all others
    pub power: (f64, f64),
    /// true where the law itself can add energy
    pub active: bool,
    /// part of 4`k` taken from the next position, which stability does not count: 4θk (docs/numerics.md §1.3, eq. 1′)
    pub lift: f64,
    /// true where `z` is a centred difference, which never destabilises
    pub centred: bool,
}

impl Bound {
    /// Returns h = T²k + 2Tz of the explicit part, over T² \[N/m\], which counts against the limit of 4. Negative h
    /// stabilises.
    pub fn h(&self) -> f64 {
        self.k - self.lift + if self.centred { 0.0 } else { 2.0 * self.z }
    }
}

/// A law of interaction with `C` coefficients and `M` numbers of memory per link.
pub trait Phi<const C: usize, const M: usize> {
    /// True where the force is linear in `e` and `w`. The ledger identity then holds exactly.
    const LINEAR: bool = false;

    /// True where [`Phi::linear`] is the law in vectors, for linear laws without memory. Long rows then run folded.
    const WIDE: bool = false;

    /// Returns the force \[N\] of a [`Phi::WIDE`] law, with the operations of [`Phi::force`] in the same order.
    #[inline(always)]
    fn linear<N: Number>(_c: &[N; C], e: N, _w: N) -> N {
        e
    }

    /// True where the law exerts no force on one side of a threshold, given by [`Phi::idle`].
    ///
    /// On that side a law without memory is not called. A law with memory is called, so that its memory can change.
    const CONTACT: bool = false;

    /// Returns the elongations from … to at which a [`Phi::CONTACT`] exerts no force. For laws without memory the
    /// kernels in space then skip the square root. At the finite end the slopes of [`Phi::bound`] are those at rest.
    fn idle<R: Real>(_c: &[R; C]) -> (R, R) {
        (R::INFINITY, R::NEG_INFINITY)
    }

    /// Computes the coefficients from the parameters in SI (in the order of `Kind::params`) and the tick, `tick_dt`
    /// \[s\].
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; C];

    /// Returns the memory at load, for elongation `e`.
    fn start<R: Real>(_c: &[R; C], _e: R) -> [R; M] {
        [R::ZERO; M]
    }

    /// Returns the force \[N\]; F > 0 pulls the ends together.
    fn force<R: Real>(c: &[R; C], mem: &mut [R; M], tables: &[Table<R>], e: R, w: R) -> R;

    /// Returns the potential energy \[J\] at elongation `e`. This, `stored` and `lost` get the memory as the force of
    /// the tick left it.
    #[inline(always)]
    fn potential<R: Real>(_c: &[R; C], _mem: &[R; M], _tables: &[Table<R>], _e: R) -> R {
        R::ZERO
    }

    /// Returns the energy stored between two ticks \[J\] (docs/numerics.md §2.2); exact product form for linear laws.
    #[inline(always)]
    fn stored<R: Real>(c: &[R; C], mem: &[R; M], tables: &[Table<R>], e0: R, e1: R) -> R {
        R::of(0.5) * (Self::potential(c, mem, tables, e0) + Self::potential(c, mem, tables, e1))
    }

    /// Returns the heat of a tick \[J\], ≥ 0, from the elongations one tick before, at, and one tick after it.
    ///
    /// The force acted at `e[1]`, with `w = e[1] − e[0]`. For a law with memory the heat includes what `stored` loses
    /// when the memory changes at that tick; such a law must remember it.
    #[inline(always)]
    fn lost<R: Real>(_c: &[R; C], _mem: &[R; M], _tables: &[Table<R>], _e: [R; 3]) -> R {
        R::ZERO
    }

    /// Returns the linear bounds, for the certificate.
    fn bound(c: &[f64; C], tables: &[Table]) -> Bound;

    /// Returns the largest slopes between two elongations \[m\]: against elongation \[N/m\] and against its change \[N
    /// per m/tick\]. Only laws whose bound depends on the elongation override it; the others give [`Phi::bound`].
    fn steepest(c: &[f64; C], tables: &[Table], _between: [f64; 2]) -> [f64; 2] {
        let b = Self::bound(c, tables);
        [b.k, b.z]
    }
}

/// Sets the memory of a link at load: coefficients, elongation and its change per tick, memory.
pub type Start<R = f64> = fn(&[R], [R; 2], &mut [R]);
/// Force of a link: coefficients, memory, tables, elongation, its change per tick.
pub type Force<R = f64> = fn(&[R], &mut [R], &[Table<R>], R, R) -> R;
/// Energy stored by a link: coefficients, memory, tables, elongations before and after.
pub type Stored<R = f64> = fn(&[R], &[R], &[Table<R>], R, R) -> R;
/// Heat of a link: coefficients, memory, tables, the elongations before, at and after the tick.
pub type Lost<R = f64> = fn(&[R], &[R], &[Table<R>], [R; 3]) -> R;
/// Elongations from … to at which a contact exerts no force, by its coefficients (see [`Phi::idle`]).
pub type Idle<R = f64> = fn(&[R]) -> (R, R);
/// Largest slopes of a link between two elongations: coefficients, tables, elongations (see [`Phi::steepest`]).
pub type Steepest = fn(&[f64], &[Table], [f64; 2]) -> [f64; 2];
