//! The number type of a tick: `f64`, `f32`, or [`Dual`](super::Dual), a number with its derivatives.
//!
//! The compiler and live changes compute in `f64`, and each number is rounded once, when it becomes a coefficient.
//! Inputs, device ports, time and the scales of the energy accounts stay `f64`. Outputs and energy accounts are
//! [`Real::Outer`], which is `f64` in both precisions and keeps the derivatives of `Dual`.
//!
//! `ca-core` instantiates the passes over `f64`; a crate that uses [`Scene::bind`](crate::Scene::bind), the others.
//! `ca-core` instantiates the passes over `f64`; a crate that binds a scene ([`crate::Scene::bind`]), the others.
//! In single precision a second of sound is accurate to about 1e-4, and the energy ledger balances to 1e-7 per tick.
//! Refused are distances in space, implicit links with more than 100 times the inertia of their ends, and numbers that
//! become zero or infinite.

use core::fmt::Debug;
use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use num_traits::{One, Zero};

/// Number type of a tick.
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

/// The number type of a tick. Comparisons use the value alone, without derivatives.
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
    /// Type of outputs and energy accounts.
    type Outer: Real<Outer = Self::Outer>;
    /// This number type as a [`Precision`].
    const PRECISION: Precision;
    /// 0.
    const ZERO: Self;
    /// Smallest positive number with full precision.
    const MIN_POSITIVE: Self;
    /// Positive infinity.
    const INFINITY: Self;
    /// Negative infinity.
    const NEG_INFINITY: Self;
    /// Limit below which numbers are cleared: far above denormal (slow) numbers and far below anything audible.
    const TINY: Self;

    /// Rounds a number computed at load to this type.
    fn of(v: f64) -> Self;
    /// Returns the value as `f64`.
    fn wide(self) -> f64;
    /// Converts to the type of an output, with derivatives.
    fn outer(self) -> Self::Outer;
    /// Converts from the type of an output, with derivatives.
    fn inner(v: Self::Outer) -> Self;
    /// Returns a function of this number, given its value and its slope here.
    ///
    /// A law can thus use any function of `libm`, whose bits are the same on every processor:
    /// `let x = e.wide(); e.chain(libm::log1p(x), 1.0 / (1.0 + x))`.
    #[must_use]
    fn chain(self, value: f64, slope: f64) -> Self;
    /// Returns the square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Returns the absolute value.
    #[must_use]
    fn abs(self) -> Self;
    /// Returns this number with the sign of `sign`.
    #[must_use]
    fn copysign(self, sign: Self) -> Self;
    /// Returns the larger number.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// Returns the smaller number.
    #[must_use]
    fn min(self, other: Self) -> Self;

    /// Returns true if the value is finite.
    #[inline(always)]
    fn is_finite(self) -> bool {
        self.wide().is_finite()
    }
}

/// A number type whose bits a plan can hold ([`Scene::to_bytes`](crate::Scene::to_bytes)): `f64`.
#[cfg(feature = "bytes")]
pub trait Stored:
    Real<Outer: serde::Serialize + serde::de::DeserializeOwned> + serde::Serialize + serde::de::DeserializeOwned
{
}

#[cfg(feature = "bytes")]
impl Stored for f64 {}

/// Implements [`Real`] for both precisions.
///
/// The square root of `std` is one instruction in the vectors around it. The one of `libm` is a scalar SSE instruction,
/// which stalls between AVX instructions. Both are correctly rounded.
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

/// Placeholder for a missing index or position: the largest number.
pub const NONE: f64 = f64::MAX;
