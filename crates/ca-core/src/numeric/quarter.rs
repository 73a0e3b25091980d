//! Quarter powers x^(n/4), their divided difference, and a first guess for x^(4/n).
//!
//! Exponents are multiples of 1/4: products and square roots give the same bits on every machine, `powf` does not.

use super::Real;

/// Returns the number of quarters, limited to 255. It is a coefficient, and the limit keeps a loop over it short.
#[inline(always)]
fn whole<R: Real>(n: R) -> u32 {
    u32::from(n.wide() as u8)
}

/// Returns x^(n/4) for x ≥ 0. It uses only products and square roots, so every IEEE machine gives the same bits.
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

/// Returns (s^(n/4) − a^(n/4)) / (s − a) for s > 0 and a > 0.
///
/// It divides two sums of powers of the fourth (or square) roots of both, where nothing cancels.
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

/// Returns x^(4/n) for x ≥ 0 to within an eighth, as the start of an iteration.
///
/// The bits of a number are nearly its logarithm, so the result is the same on every IEEE machine.
pub fn quarter_root<R: Real>(x: R, n: R) -> R {
    let one = 1f64.to_bits() as i64;
    // wraps unless x ≥ 0 and n ≥ 4
    let part = (x.wide().to_bits() as i64).wrapping_sub(one) / i64::from(whole(n).max(1));
    R::of(f64::from_bits(one.wrapping_add(part.wrapping_mul(4)) as u64))
}
