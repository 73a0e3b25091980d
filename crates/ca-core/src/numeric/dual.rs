//! Dual numbers: a number with its derivatives (tangents) by several parameters.
//!
//! Derivatives are taken in forward mode by arithmetic: each operation of a tick also applies its derivative rule. So
//! laws, passes and methods are shared with an ordinary run, and no law has a hand-written derivative. Reverse mode
//! over a recording of all operations would have to store every tick.
//!
//! A number and [`TANGENTS`] tangents fill one cache line, the widest vector. Sums and products are loops over all
//! eight, and plain arithmetic then overwrites the value, so it has the bits of `f64`, whatever the tangents are.
//!
//! A function without a derivative gets a finite one: 0 for a square root at 0; for `abs` and `copysign` the side given
//! by the sign, also of -0; for `max` and `min` the chosen number, the first if both are equal. Comparisons use the
//! value alone, so the derivative belongs to the branch that was taken.

use super::{Precision, Real};
use core::cmp::Ordering;
use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Number of tangents, one per parameter.
pub const TANGENTS: usize = 7;
const ALL: usize = TANGENTS + 1;

/// Computes all eight numbers. The loop is always inlined, unlike the functions of `core::array`, and so uses the
/// vectors of the pass around it.
#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> [f64; ALL] {
    let mut all = [0.0; ALL];
    for (k, v) in all.iter_mut().enumerate() {
        *v = f(k);
    }
    all
}

/// A number and its tangents. The default is the constant 0.
#[derive(Clone, Copy, Default)]
#[repr(align(64))]
pub struct Dual {
    /// the value, then its tangents
    all: [f64; ALL],
}

impl Dual {
    /// Makes a number that depends on no parameter.
    #[inline(always)]
    pub const fn constant(v: f64) -> Dual {
        let mut all = [0.0; ALL];
        all[0] = v;
        Dual { all }
    }

    /// Makes a number from its value and derivatives.
    #[inline(always)]
    pub fn new(v: f64, tangents: [f64; TANGENTS]) -> Dual {
        let mut all = [v; ALL];
        all[1..].copy_from_slice(&tangents);
        Dual { all }
    }

    /// Returns the value.
    #[inline(always)]
    pub const fn value(self) -> f64 {
        self.all[0]
    }

    /// Returns the derivatives.
    #[inline(always)]
    pub fn tangents(&self) -> &[f64; TANGENTS] {
        self.all.last_chunk().unwrap_or(&[0.0; TANGENTS])
    }

    /// Returns the derivatives for writing.
    #[inline(always)]
    pub fn tangents_mut(&mut self) -> &mut [f64] {
        &mut self.all[1..]
    }
}

impl Real for Dual {
    type Outer = Dual;
    const PRECISION: Precision = Precision::Dual;
    const ZERO: Dual = Dual::constant(0.0);
    const MIN_POSITIVE: Dual = Dual::constant(f64::MIN_POSITIVE);
    const INFINITY: Dual = Dual::constant(f64::INFINITY);
    const NEG_INFINITY: Dual = Dual::constant(f64::NEG_INFINITY);
    const TINY: Dual = Dual::constant(f64::TINY);

    #[inline(always)]
    fn of(v: f64) -> Dual {
        Dual::constant(v)
    }
    #[inline(always)]
    fn wide(self) -> f64 {
        self.all[0]
    }
    #[inline(always)]
    fn outer(self) -> Dual {
        self
    }
    #[inline(always)]
    fn inner(v: Dual) -> Dual {
        v
    }
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Dual {
        let mut all = each(|k| slope * self.all[k]);
        all[0] = value;
        Dual { all }
    }
    /// Gives 0 with tangents 0 at 0.
    #[inline(always)]
    fn sqrt(self) -> Dual {
        let root = Real::sqrt(self.all[0]);
        self.chain(root, if root > 0.0 { 0.5 / root } else { 0.0 })
    }
    #[inline(always)]
    fn abs(self) -> Dual {
        if self.all[0].is_sign_negative() { -self } else { self }
    }
    #[inline(always)]
    fn copysign(self, sign: Dual) -> Dual {
        if self.all[0].is_sign_negative() == sign.all[0].is_sign_negative() { self } else { -self }
    }
    #[inline(always)]
    fn max(self, other: Dual) -> Dual {
        if other.all[0] > self.all[0] || self.all[0].is_nan() { other } else { self }
    }
    #[inline(always)]
    fn min(self, other: Dual) -> Dual {
        if other.all[0] < self.all[0] || self.all[0].is_nan() { other } else { self }
    }
}

impl core::fmt::Debug for Dual {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.all[0].fmt(f)?;
        if self.tangents().iter().any(|t| *t != 0.0) { write!(f, "+ε{:?}", self.tangents()) } else { Ok(()) }
    }
}

impl PartialEq for Dual {
    #[inline(always)]
    fn eq(&self, other: &Dual) -> bool {
        self.all[0] == other.all[0]
    }
}

impl PartialOrd for Dual {
    #[inline(always)]
    fn partial_cmp(&self, other: &Dual) -> Option<Ordering> {
        self.all[0].partial_cmp(&other.all[0])
    }
}

impl Neg for Dual {
    type Output = Dual;
    #[inline(always)]
    fn neg(self) -> Dual {
        Dual { all: each(|k| -self.all[k]) }
    }
}

impl Add for Dual {
    type Output = Dual;
    #[inline(always)]
    fn add(self, other: Dual) -> Dual {
        Dual { all: each(|k| self.all[k] + other.all[k]) }
    }
}

impl Sub for Dual {
    type Output = Dual;
    #[inline(always)]
    fn sub(self, other: Dual) -> Dual {
        Dual { all: each(|k| self.all[k] - other.all[k]) }
    }
}

impl Mul for Dual {
    type Output = Dual;
    #[inline(always)]
    // product rule
    #[allow(clippy::suspicious_arithmetic_impl)]
    fn mul(self, other: Dual) -> Dual {
        let (a, b) = (self.all[0], other.all[0]);
        let mut all = each(|k| a * other.all[k] + b * self.all[k]);
        all[0] = a * b;
        Dual { all }
    }
}

impl Div for Dual {
    type Output = Dual;
    #[inline(always)]
    fn div(self, other: Dual) -> Dual {
        let quotient = self.all[0] / other.all[0];
        let per = 1.0 / other.all[0];
        let mut all = each(|k| (self.all[k] - quotient * other.all[k]) * per);
        all[0] = quotient;
        Dual { all }
    }
}

macro_rules! assign {
    ($($op:ident $f:ident $assign:ident $g:ident;)*) => {
        $(
            impl $assign for Dual {
                #[inline(always)]
                fn $g(&mut self, other: Dual) {
                    *self = $op::$f(*self, other);
                }
            }
        )*
    };
}

assign! {
    Add add AddAssign add_assign;
    Sub sub SubAssign sub_assign;
    Mul mul MulAssign mul_assign;
    Div div DivAssign div_assign;
}

impl Sum for Dual {
    /// Starts at -0, as sums of `f64` do.
    fn sum<I: Iterator<Item = Dual>>(all: I) -> Dual {
        all.fold(Dual::constant(-0.0), |sum, v| sum + v)
    }
}

impl<'a> Sum<&'a Dual> for Dual {
    fn sum<I: Iterator<Item = &'a Dual>>(all: I) -> Dual {
        all.copied().sum()
    }
}

impl num_traits::Zero for Dual {
    fn zero() -> Dual {
        Dual::constant(0.0)
    }
    fn is_zero(&self) -> bool {
        self.all[0] == 0.0
    }
}

impl num_traits::One for Dual {
    fn one() -> Dual {
        Dual::constant(1.0)
    }
}
