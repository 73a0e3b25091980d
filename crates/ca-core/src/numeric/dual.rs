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

use super::{Precision, Real};
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
    /// Of 0 with tangents 0.
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
    /// The number, and its tangents where one is not 0.
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

/// In place.
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
