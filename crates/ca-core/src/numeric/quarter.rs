//! Quarter powers: x^(n/4), its mean between two places, and where to begin to look for its root.
//!
//! Decides on exponents that are multiples of 1/4, since products and square roots give the same bits on every machine
//! and `powf` does not.

use super::Real;

/// A number of quarters, at most 255: it is a coefficient, and a loop over it must end soon.
#[inline(always)]
fn whole<R: Real>(n: R) -> u32 {
    u32::from(n.wide() as u8)
}

/// x^(n/4) for x ≥ 0 by products and square roots only, so that every IEEE machine gives the same bits.
#[inline(always)]
pub fn quarter_power<R: Real>(x: R, n: R) -> R {
    let n = whole(n);
    let mut y = R::of(1.0);
    for _ in 0..n / 4 {
        y *= x;
    }
    if n & 3 != 0 {
        let r = x.sqrt();
        if n & 2 != 0 {
            y *= r;
        }
        if n & 1 != 0 {
            y *= r.sqrt();
        }
    }
    y
}

/// (s^(n/4) − a^(n/4)) / (s − a) for s > 0 and a > 0: with the fourth roots of both (or the square roots, or themselves,
/// as n allows) it is the quotient of two sums without a difference.
pub fn quarter_mean<R: Real>(s: R, a: R, n: R) -> R {
    let (mut n, mut parts, mut u, mut v) = (whole(n), 1, s, a);
    while n % (4 / parts) != 0 {
        (parts, u, v) = (2 * parts, u.sqrt(), v.sqrt());
    }
    n /= 4 / parts;
    // Σ uⁱ vʲ with i + j = n − 1
    let sum = |n: u32| (0..n).fold((R::ZERO, R::of(1.0)), |(sum, w), _| (sum * u + w, w * v)).0;
    sum(n) / sum(parts)
}

/// x^(4/n) for x ≥ 0 to within an eighth, where an iteration is to begin: the bits of a number are nearly its
/// logarithm, so this is the same on every IEEE machine.
pub fn quarter_root<R: Real>(x: R, n: R) -> R {
    let one = 1f64.to_bits() as i64;
    // wraps for what is not x ≥ 0 with n ≥ 4
    let part = (x.wide().to_bits() as i64).wrapping_sub(one) / i64::from(whole(n).max(1));
    R::of(f64::from_bits(one.wrapping_add(part.wrapping_mul(4)) as u64))
}
