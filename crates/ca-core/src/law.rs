//! The shape of a law of interaction.
//!
//! Decides that a law is written **once**, as a [`Phi`]: a force from the elongation `e = x_j − x_i + e₀` and its change
//! per tick `w = d_j − d_i`, F > 0 pulling the ends together. Every form of the law (gather and run here, 3-D and LPR
//! elsewhere), the energy ledger and the stability bounds call these functions; a law never sees positions, so it
//! cannot depend on a dimension. Coefficients are an array of fixed size, read column-wise by the kernels, so that a
//! homogeneous pass vectorises.

use crate::numeric::{Real, Table};
use core::ops::{Add, Mul, Sub};

/// What a linear law is computed in: a number, or a vector of them with a link in each lane.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Number for T {}

/// Linear bound of a law: its largest slopes, `k` \[N/m\] against elongation and `z` \[N/(m/tick)\] against change of
/// elongation. Exact for linear laws and for contacts of constant stiffness; of laws that stiffen without end
/// (`hardens`) it is the slope at rest, and [`Phi::steepest`] has that at an elongation. Both ≥ 0 except for springs that are
/// negative on purpose. `contact` marks laws that switch.
// six answers to six questions, any of which may be yes
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bound {
    /// largest slope against elongation \[N/m\]
    pub k: f64,
    /// the part of `k` that the law has at some elongations only, as of a table or of a spring that softens \[N/m\]
    pub loose: f64,
    /// largest slope against change of elongation per tick \[N per m/tick\]
    pub z: f64,
    /// true where the force switches on and off with distance
    pub contact: bool,
    /// true where the law is linear and the bound therefore exact
    pub linear: bool,
    /// true where `z` is the steepest place of a curve against speed, as of dry friction
    pub curve: bool,
    /// true where a slope grows without end with elongation; `k` and `z` are then those at rest
    pub hardens: bool,
    /// of a contact that grows with a power of its depth, η^p: the factor \[N/m^p\] and p; 0 of all others
    pub power: (f64, f64),
    /// true where the law can feed energy in by itself
    pub active: bool,
    /// part of four times `k` that is taken from the time to come, so that stability does not count it: 4θk
    /// (docs/numerics.md §1.3, eq. 1′)
    pub lift: f64,
    /// true where `z` is a centred difference, which never destabilises
    pub centred: bool,
}

impl Bound {
    /// What counts against the limit of 4: h = T²k + 2Tz of what is explicit, over T² \[N/m\]. Below 0 where the link makes
    /// the rest more stable.
    pub fn h(&self) -> f64 {
        self.k - self.lift + if self.centred { 0.0 } else { 2.0 * self.z }
    }
}

/// A law of interaction. `C` coefficients per link, `M` numbers of memory per link.
pub trait Phi<const C: usize, const M: usize> {
    /// True where force is linear in `e` and `w`: the ledger identity then holds exactly.
    const LINEAR: bool = false;

    /// True where [`Phi::linear`] is the law in vectors; only of linear laws without memory. Long rows then run folded.
    const WIDE: bool = false;

    /// The force \[N\] as [`Phi::force`] has it, in the same order of operations, for laws that are [`Phi::WIDE`]; others are
    /// never asked.
    #[inline(always)]
    fn linear<N: Number>(_c: &[N; C], e: N, _w: N) -> N {
        e
    }

    /// True where the law has no force on one side of a threshold, which [`Phi::idle`] then says. There a law without memory
    /// is not called; one with memory is, so that it may forget or relax.
    const CONTACT: bool = false;

    /// The elongations from … to at which there is no force, for [`Phi::CONTACT`]; kernels in space then skip the square
    /// root, of laws without memory. The finite end is where the slopes of [`Phi::bound`] are those at rest.
    fn idle<R: Real>(_c: &[R; C]) -> (R, R) {
        (R::INFINITY, R::NEG_INFINITY)
    }

    /// Coefficients per tick from the parameters in SI (in the order of `Kind::params`) and the tick, `tick_dt` \[s\].
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; C];

    /// Memory at load, for elongation `e`.
    fn start<R: Real>(_c: &[R; C], _e: R) -> [R; M] {
        [R::ZERO; M]
    }

    /// The force \[N\], F > 0 pulls the ends together.
    fn force<R: Real>(c: &[R; C], mem: &mut [R; M], tables: &[Table<R>], e: R, w: R) -> R;

    /// Potential energy \[J\] at elongation `e`. This, `stored` and `lost` get the memory as the force of the tick left it.
    #[inline(always)]
    fn potential<R: Real>(_c: &[R; C], _mem: &[R; M], _tables: &[Table<R>], _e: R) -> R {
        R::ZERO
    }

    /// Energy stored between two ticks \[J\] (docs/numerics.md §2.2); linear laws override it with the exact product
    /// form.
    #[inline(always)]
    fn stored<R: Real>(c: &[R; C], mem: &[R; M], tables: &[Table<R>], e0: R, e1: R) -> R {
        R::of(0.5) * (Self::potential(c, mem, tables, e0) + Self::potential(c, mem, tables, e1))
    }

    /// Energy turned to heat during a tick \[J\], ≥ 0, from the elongations at the tick before, at it, and after. The force was
    /// that at `e[1]`, with `w = e[1] − e[0]`. Of a law with memory it includes what `stored` gives up as memory changes at
    /// that tick, which such a law remembers.
    #[inline(always)]
    fn lost<R: Real>(_c: &[R; C], _mem: &[R; M], _tables: &[Table<R>], _e: [R; 3]) -> R {
        R::ZERO
    }

    /// Linear bounds, for the certificate.
    fn bound(c: &[f64; C], tables: &[Table]) -> Bound;

    /// The largest slopes between two elongations \[m\]: against elongation \[N/m\] and against its change \[N per m/tick\]. Only laws
    /// whose bound hangs on the elongation say more than [`Phi::bound`].
    fn steepest(c: &[f64; C], tables: &[Table], _between: [f64; 2]) -> [f64; 2] {
        let b = Self::bound(c, tables);
        [b.k, b.z]
    }
}

/// Memory of a link at load: coefficients, elongation and its change per tick, memory.
pub type Start<R = f64> = fn(&[R], [R; 2], &mut [R]);
/// The force of a link: coefficients, memory, tables, elongation, change of elongation per tick.
pub type Force<R = f64> = fn(&[R], &mut [R], &[Table<R>], R, R) -> R;
/// Energy stored by a link: coefficients, memory, tables, elongations before and after.
pub type Stored<R = f64> = fn(&[R], &[R], &[Table<R>], R, R) -> R;
/// Heat of a link: coefficients, memory, tables, the elongations before, at and after the tick.
pub type Lost<R = f64> = fn(&[R], &[R], &[Table<R>], [R; 3]) -> R;
/// Where a contact has no force: coefficients; the elongations from … to (see [`Phi::idle`]).
pub type Idle<R = f64> = fn(&[R]) -> (R, R);
/// Largest slopes of a link between two elongations: coefficients, tables, the elongations (see [`Phi::steepest`]).
pub type Steepest = fn(&[f64], &[Table], [f64; 2]) -> [f64; 2];
