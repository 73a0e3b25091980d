//! Real: the number a tick computes with, `f64`, or `f32` where the crate is built with `cfg(single)`.
//!
//! Decides that the precision belongs to the build and not to the types: laws, passes and methods are written once, in
//! plain numbers, and `ca-core-single` is these very files with the other alias. A type parameter through all of them
//! would say the same in every signature. Only what a tick reads and writes is `Real`; all that is computed at load,
//! and by changes while playing, is `f64` and rounded once, where it becomes a coefficient. What a caller gives and
//! takes (inputs, outputs, device ports), time, and the accounts of energy stay `f64`.
//!
//! In single precision a second of sound is known to 1e-4 or so, the energy ledger balances to 1e-7 in a tick, and a scene
//! is refused that has a distance in space, an implicit link with more than 100 times the inertia of its ends,
//! or a number that becomes nothing or infinite.

// one of the two builds casts a number to what it is
#![allow(clippy::unnecessary_cast)]

/// The number of the tick.
#[cfg(not(single))]
pub type Real = f64;
/// The number of the tick.
#[cfg(single)]
pub type Real = f32;

/// True in the build of single precision.
pub const SINGLE: bool = cfg!(single);
/// Far above what is denormal and slow, far below what is heard.
pub const TINY: Real = if SINGLE { 1e-30 } else { 1e-270 as Real };
/// The largest number, which stands for none where a place is meant.
pub const NONE: f64 = Real::MAX as f64;

/// A number computed at load, rounded to that of the tick.
#[inline(always)]
pub const fn real(v: f64) -> Real {
    v as Real
}

/// A number of the tick as one of the outside.
#[inline(always)]
pub const fn wide(v: Real) -> f64 {
    v as f64
}

/// The square root.
#[inline(always)]
pub fn sqrt(v: Real) -> Real {
    #[cfg(not(single))]
    return libm::sqrt(v);
    #[cfg(single)]
    return libm::sqrtf(v);
}
