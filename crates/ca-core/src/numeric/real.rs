//! Real: the number a tick computes with, `f64`; `f32` where the crate is built with `cfg(single)`, and a number with its
//! derivatives, `Dual`, with `cfg(dual)`.
//!
//! Decides that the number belongs to the build and not to the types: laws, passes and methods are written once, in
//! plain numbers, and `ca-core-single` and `ca-core-dual` are these very files with another alias. A type parameter through all of
//! them would say the same in every signature. Only what a tick reads and writes is `Real`; all that is computed at load,
//! and by changes while playing, is `f64` and rounded once, where it becomes a coefficient. What a caller gives and
//! takes (inputs, outputs, device ports), time, and the accounts of energy stay `f64`; but outputs, and what else must not
//! lose its derivatives there, is `Outer`, which is `f64` in both precisions and `Dual` in the build of that.
//!
//! In single precision a second of sound is known to 1e-4 or so, the energy ledger balances to 1e-7 in a tick, and a scene
//! is refused that has a distance in space, an implicit link with more than 100 times the inertia of its ends,
//! or a number that becomes nothing or infinite.

// one of the builds casts a number to what it is
#![allow(clippy::unnecessary_cast)]

#[cfg(dual)]
use super::Dual;

/// The number of the tick.
#[cfg(not(any(single, dual)))]
pub type Real = f64;
/// The number of the tick.
#[cfg(single)]
pub type Real = f32;
/// The number of the tick.
#[cfg(dual)]
pub type Real = Dual;

/// A number of the tick without derivatives: what decides which numbers are computed, and is none of them.
#[cfg(not(single))]
pub type Value = f64;
/// A number of the tick without derivatives: what decides which numbers are computed, and is none of them.
#[cfg(single)]
pub type Value = f32;

/// A number beside the tick that has its derivatives: an output, or what is computed at load and is not rounded.
#[cfg(not(dual))]
pub type Outer = f64;
/// A number beside the tick that has its derivatives: an output, or what is computed at load and is not rounded.
#[cfg(dual)]
pub type Outer = Dual;

/// True in the build of single precision.
pub const SINGLE: bool = cfg!(single);
/// True in the build of dual numbers.
pub const DUAL: bool = cfg!(dual);
/// Far above what is denormal and slow, far below what is heard.
pub const TINY: Real = real(if SINGLE { 1e-30 } else { 1e-270 });
/// The largest number, which stands for none where a place is meant.
pub const NONE: f64 = wide(Real::MAX);

/// A number computed at load, rounded to that of the tick.
#[inline(always)]
pub const fn real(v: f64) -> Real {
    #[cfg(not(dual))]
    return v as Real;
    #[cfg(dual)]
    return Dual::constant(v);
}

/// A number of the tick as one of the outside.
#[inline(always)]
pub const fn wide(v: Real) -> f64 {
    #[cfg(not(dual))]
    return v as f64;
    #[cfg(dual)]
    return v.value();
}

/// A number of the tick without its derivatives.
#[inline(always)]
pub const fn value(v: Real) -> Value {
    #[cfg(not(dual))]
    return v;
    #[cfg(dual)]
    return v.value();
}

/// A number of the tick as one beside it, with its derivatives.
#[inline(always)]
pub const fn outer(v: Real) -> Outer {
    #[cfg(not(dual))]
    return v as Outer;
    #[cfg(dual)]
    return v;
}

/// A number beside the tick as one of it, with its derivatives.
#[inline(always)]
pub const fn inner(v: Outer) -> Real {
    #[cfg(not(dual))]
    return v as Real;
    #[cfg(dual)]
    return v;
}

/// What is computed at load, as a number beside the tick.
#[inline(always)]
pub const fn lift(v: f64) -> Outer {
    #[cfg(not(dual))]
    return v;
    #[cfg(dual)]
    return Dual::constant(v);
}

/// A number beside the tick without its derivatives.
#[inline(always)]
pub const fn bare(v: Outer) -> f64 {
    #[cfg(not(dual))]
    return v;
    #[cfg(dual)]
    return v.value();
}

/// The square root.
#[inline(always)]
pub fn sqrt(v: Real) -> Real {
    #[cfg(not(dual))]
    return value_sqrt(v);
    #[cfg(dual)]
    return v.sqrt();
}

/// The square root of what decides. That of `std` is an instruction among its neighbours, in as many lanes as these have; that of
/// `libm` is one of SSE by itself, in no lanes, which stalls between those of AVX. Both are correctly rounded.
#[inline(always)]
pub fn value_sqrt(v: Value) -> Value {
    #[cfg(feature = "std")]
    return v.sqrt();
    #[cfg(all(not(feature = "std"), not(single)))]
    return libm::sqrt(v);
    #[cfg(all(not(feature = "std"), single))]
    return libm::sqrtf(v);
}
