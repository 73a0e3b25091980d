//! Real: the number that a tick computes with: `f64`, `f32`, or a number with its derivatives, [`Dual`](super::Dual).
//!
//! Only what a tick reads and writes is generic over it. The compiler and changes while playing compute in `f64`, and each number
//! is rounded once, where it becomes a coefficient. Inputs, device ports, time and the sizes of energy accounts stay `f64`.
//! Outputs and energy accounts are [`Real::Outer`], which is `f64` in both precisions and keeps the derivatives of `Dual`.
//!
//! `ca-core` makes the passes over `f64`; the crates that bind a scene to another number make those
//! ([`Scene::bind`](crate::Scene::bind)).
//!
//! In single precision a second of sound is known to 1e-4 or so, the energy ledger balances to 1e-7 in a tick, and a scene
//! is refused that has a distance in space, an implicit link with more than 100 times the inertia of its ends,
//! or a number that becomes nothing or infinite.

use core::fmt::Debug;
use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use num_traits::{One, Zero};

/// Which number a tick computes with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// `f64`
    #[default]
    Double,
    /// `f32`
    Single,
    /// [`Dual`](super::Dual)
    Dual,
}

/// The number of the tick. Comparisons look at the value alone, without derivatives.
pub trait Real:
    Copy
    + Default
    + Debug
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + Zero
    + One
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + Sum
    + for<'a> Sum<&'a Self>
    + 'static
{
    /// An output, or an account of energy.
    type Outer: Real<Outer = Self::Outer>;
    /// Which number it is.
    const PRECISION: Precision;
    /// 0.
    const ZERO: Self;
    /// The least number above 0 with all its digits.
    const MIN_POSITIVE: Self;
    /// Positive infinity.
    const INFINITY: Self;
    /// Negative infinity.
    const NEG_INFINITY: Self;
    /// Far above what is denormal and slow, far below what is heard.
    const TINY: Self;

    /// A number computed at load, rounded to the number of the tick.
    fn of(v: f64) -> Self;
    /// The value as `f64`.
    fn wide(self) -> f64;
    /// As an output, with its derivatives.
    fn outer(self) -> Self::Outer;
    /// From an output, with its derivatives.
    fn inner(v: Self::Outer) -> Self;
    /// A function of this number, by its value and its slope here. So a law takes any function of `libm`, whose bits are the same
    /// on every processor: `let x = e.wide(); e.chain(libm::log1p(x), 1.0 / (1.0 + x))`.
    #[must_use]
    fn chain(self, value: f64, slope: f64) -> Self;
    /// The square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Without its sign.
    #[must_use]
    fn abs(self) -> Self;
    /// With the sign of another.
    #[must_use]
    fn copysign(self, sign: Self) -> Self;
    /// The larger.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// The smaller.
    #[must_use]
    fn min(self, other: Self) -> Self;

    /// True where the value is finite.
    #[inline(always)]
    fn is_finite(self) -> bool {
        self.wide().is_finite()
    }
}

/// A number whose bits a plan can hold ([`Scene::to_bytes`](crate::Scene::to_bytes)): `f64`.
#[cfg(feature = "bytes")]
pub trait Stored:
    Real<Outer: serde::Serialize + serde::de::DeserializeOwned> + serde::Serialize + serde::de::DeserializeOwned
{
}

#[cfg(feature = "bytes")]
impl Stored for f64 {}

/// Both precisions; roots of `std` are an instruction among its neighbours, in as many lanes as these have. That of `libm` is one
/// of SSE by itself, in no lanes, and stalls between instructions of AVX. Both are correctly rounded.
macro_rules! plain {
    ($($number:ident $precision:ident $tiny:literal $sqrt:ident;)*) => {
        $(
            impl Real for $number {
                type Outer = f64;
                const PRECISION: Precision = Precision::$precision;
                const ZERO: $number = 0.0;
                const MIN_POSITIVE: $number = $number::MIN_POSITIVE;
                const INFINITY: $number = $number::INFINITY;
                const NEG_INFINITY: $number = $number::NEG_INFINITY;
                const TINY: $number = $tiny;

                #[inline(always)]
                #[allow(clippy::unnecessary_cast, reason = "one of both is f64")]
                fn of(v: f64) -> $number {
                    v as $number
                }
                #[inline(always)]
                fn wide(self) -> f64 {
                    f64::from(self)
                }
                #[inline(always)]
                fn outer(self) -> f64 {
                    f64::from(self)
                }
                #[inline(always)]
                #[allow(clippy::unnecessary_cast, reason = "one of both is f64")]
                fn inner(v: f64) -> $number {
                    v as $number
                }
                #[inline(always)]
                #[allow(clippy::unnecessary_cast, reason = "one of both is f64")]
                fn chain(self, value: f64, _: f64) -> $number {
                    value as $number
                }
                #[inline(always)]
                fn sqrt(self) -> $number {
                    #[cfg(feature = "std")]
                    return $number::sqrt(self);
                    #[cfg(not(feature = "std"))]
                    return libm::$sqrt(self);
                }
                #[inline(always)]
                fn abs(self) -> $number {
                    $number::abs(self)
                }
                #[inline(always)]
                fn copysign(self, sign: $number) -> $number {
                    $number::copysign(self, sign)
                }
                #[inline(always)]
                fn max(self, other: $number) -> $number {
                    $number::max(self, other)
                }
                #[inline(always)]
                fn min(self, other: $number) -> $number {
                    $number::min(self, other)
                }
            }
        )*
    };
}

plain! {
    f64 Double 1e-270 sqrt;
    f32 Single 1e-30 sqrtf;
}

/// The largest number, which stands for none where a place is meant.
pub const NONE: f64 = f64::MAX;
