//! Dual: a number with its derivatives by several parameters, its tangents.
//!
//! Decides for forward mode by arithmetic: each operation of a tick also applies the rule of its derivative, so that laws,
//! passes and methods are those of `ca-core`, and no law has a derivative written by hand. Against a tape that is walked
//! backwards: it would have to keep every tick. A number and [`TANGENTS`] tangents fill one cache line, which is one
//! vector of the widest processors: sums and products are loops over all eight, the number itself included, whose result is then
//! written over by that of plain arithmetic. The numbers have therefore the bits of `f64`, whatever the tangents are.
//!
//! Where a function has no derivative, a finite one is defined: 0 of a square root at 0; of `abs` and `copysign` that of the side
//! the sign says, of -0 too; of `max` and `min` that of the number taken, the first where both are equal. Comparisons look
//! at the number alone, so that the derivative is that of the branch that was taken.

use core::cmp::Ordering;
use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Parameters of which a number knows its derivatives.
pub const TANGENTS: usize = 7;
/// The same, and the number.
const ALL: usize = TANGENTS + 1;

/// All eight, computed by a loop that is always inlined: so it has the vectors of the pass it stands in, which `core::array`'s
/// functions, not being inlined there, have not.
#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> [f64; ALL] {
    let mut all = [0.0; ALL];
    for (k, v) in all.iter_mut().enumerate() {
        *v = f(k);
    }
    all
}

/// A number and its tangents. The default is 0, a constant.
#[derive(Clone, Copy, Default)]
#[repr(align(64))]
pub struct Dual {
    /// the number, then its tangents
    all: [f64; ALL],
}

impl Dual {
    /// The largest number.
    pub const MAX: Dual = Dual::constant(f64::MAX);
    /// The least number above 0 with all its digits.
    pub const MIN_POSITIVE: Dual = Dual::constant(f64::MIN_POSITIVE);
    /// Positive infinity.
    pub const INFINITY: Dual = Dual::constant(f64::INFINITY);
    /// Negative infinity.
    pub const NEG_INFINITY: Dual = Dual::constant(f64::NEG_INFINITY);

    /// A number that depends on no parameter.
    #[inline(always)]
    pub const fn constant(v: f64) -> Dual {
        let mut all = [0.0; ALL];
        all[0] = v;
        Dual { all }
    }

    /// A number and its derivatives.
    #[inline(always)]
    pub fn new(v: f64, tangents: [f64; TANGENTS]) -> Dual {
        let mut all = [v; ALL];
        all[1..].copy_from_slice(&tangents);
        Dual { all }
    }

    /// The number.
    #[inline(always)]
    pub const fn value(self) -> f64 {
        self.all[0]
    }

    /// Its derivatives.
    #[inline(always)]
    pub fn tangents(&self) -> &[f64; TANGENTS] {
        self.all.last_chunk().unwrap_or(&[0.0; TANGENTS])
    }

    /// Its derivatives, to be written.
    #[inline(always)]
    pub fn tangents_mut(&mut self) -> &mut [f64] {
        &mut self.all[1..]
    }

    /// `value`, with the tangents of this one by `slope`.
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Dual {
        let mut all = each(|k| slope * self.all[k]);
        all[0] = value;
        Dual { all }
    }

    /// The square root; of 0 with tangents 0.
    #[inline(always)]
    #[must_use]
    pub fn sqrt(self) -> Dual {
        let root = super::real::value_sqrt(self.all[0]);
        self.chain(root, if root > 0.0 { 0.5 / root } else { 0.0 })
    }

    /// Without its sign.
    #[inline(always)]
    #[must_use]
    pub fn abs(self) -> Dual {
        if self.all[0].is_sign_negative() { -self } else { self }
    }

    /// With the sign of another.
    #[inline(always)]
    #[must_use]
    pub fn copysign(self, sign: impl Into<Dual>) -> Dual {
        if self.all[0].is_sign_negative() == sign.into().all[0].is_sign_negative() { self } else { -self }
    }

    /// The larger.
    #[inline(always)]
    #[must_use]
    pub fn max(self, other: impl Into<Dual>) -> Dual {
        let other = other.into();
        if other.all[0] > self.all[0] || self.all[0].is_nan() { other } else { self }
    }

    /// The smaller.
    #[inline(always)]
    #[must_use]
    pub fn min(self, other: impl Into<Dual>) -> Dual {
        let other = other.into();
        if other.all[0] < self.all[0] || self.all[0].is_nan() { other } else { self }
    }

    /// True where the value is finite; its tangents are not asked.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.all[0].is_finite()
    }

    /// True where the value is NaN.
    #[inline(always)]
    pub fn is_nan(self) -> bool {
        self.all[0].is_nan()
    }

    /// In the order of all numbers.
    #[inline(always)]
    pub fn total_cmp(&self, other: &Dual) -> Ordering {
        self.all[0].total_cmp(&other.all[0])
    }
}

impl core::fmt::Debug for Dual {
    /// The number, and its tangents where one is not 0.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.all[0].fmt(f)?;
        if self.tangents().iter().any(|t| *t != 0.0) { write!(f, "+ε{:?}", self.tangents()) } else { Ok(()) }
    }
}

impl From<f64> for Dual {
    #[inline(always)]
    fn from(v: f64) -> Dual {
        Dual::constant(v)
    }
}

impl From<Dual> for f64 {
    #[inline(always)]
    fn from(v: Dual) -> f64 {
        v.all[0]
    }
}

impl PartialEq for Dual {
    #[inline(always)]
    fn eq(&self, other: &Dual) -> bool {
        self.all[0] == other.all[0]
    }
}

impl PartialEq<f64> for Dual {
    #[inline(always)]
    fn eq(&self, other: &f64) -> bool {
        self.all[0] == *other
    }
}

impl PartialOrd for Dual {
    #[inline(always)]
    fn partial_cmp(&self, other: &Dual) -> Option<Ordering> {
        self.all[0].partial_cmp(&other.all[0])
    }
}

impl PartialOrd<f64> for Dual {
    #[inline(always)]
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.all[0].partial_cmp(other)
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
    // the rule of products
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

impl Add<f64> for Dual {
    type Output = Dual;
    #[inline(always)]
    fn add(mut self, other: f64) -> Dual {
        self.all[0] += other;
        self
    }
}

impl Sub<f64> for Dual {
    type Output = Dual;
    #[inline(always)]
    fn sub(mut self, other: f64) -> Dual {
        self.all[0] -= other;
        self
    }
}

impl Mul<f64> for Dual {
    type Output = Dual;
    #[inline(always)]
    fn mul(self, other: f64) -> Dual {
        Dual { all: each(|k| self.all[k] * other) }
    }
}

impl Div<f64> for Dual {
    type Output = Dual;
    #[inline(always)]
    fn div(self, other: f64) -> Dual {
        Dual { all: each(|k| self.all[k] / other) }
    }
}

impl Add<Dual> for f64 {
    type Output = Dual;
    #[inline(always)]
    fn add(self, mut other: Dual) -> Dual {
        other.all[0] += self;
        other
    }
}

impl Sub<Dual> for f64 {
    type Output = Dual;
    #[inline(always)]
    fn sub(self, other: Dual) -> Dual {
        let mut all = each(|k| -other.all[k]);
        all[0] = self - other.all[0];
        Dual { all }
    }
}

impl Mul<Dual> for f64 {
    type Output = Dual;
    #[inline(always)]
    fn mul(self, other: Dual) -> Dual {
        Dual { all: each(|k| self * other.all[k]) }
    }
}

impl Div<Dual> for f64 {
    type Output = Dual;
    #[inline(always)]
    fn div(self, other: Dual) -> Dual {
        Dual::constant(self) / other
    }
}

/// The forms that plain numbers have too: by reference, and in place.
macro_rules! forms {
    ($($op:ident $f:ident $assign:ident $g:ident;)*) => {
        $(
            impl $op<&Dual> for Dual {
                type Output = Dual;
                #[inline(always)]
                fn $f(self, other: &Dual) -> Dual {
                    $op::$f(self, *other)
                }
            }
            impl $op<Dual> for &Dual {
                type Output = Dual;
                #[inline(always)]
                fn $f(self, other: Dual) -> Dual {
                    $op::$f(*self, other)
                }
            }
            impl $op<&Dual> for &Dual {
                type Output = Dual;
                #[inline(always)]
                fn $f(self, other: &Dual) -> Dual {
                    $op::$f(*self, *other)
                }
            }
            impl $assign for Dual {
                #[inline(always)]
                fn $g(&mut self, other: Dual) {
                    *self = $op::$f(*self, other);
                }
            }
            impl $assign<&Dual> for Dual {
                #[inline(always)]
                fn $g(&mut self, other: &Dual) {
                    *self = $op::$f(*self, *other);
                }
            }
            impl $assign<f64> for Dual {
                #[inline(always)]
                fn $g(&mut self, other: f64) {
                    *self = $op::$f(*self, other);
                }
            }
        )*
    };
}

forms! {
    Add add AddAssign add_assign;
    Sub sub SubAssign sub_assign;
    Mul mul MulAssign mul_assign;
    Div div DivAssign div_assign;
}

impl Sum for Dual {
    /// From -0 on, as sums of `f64`.
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
