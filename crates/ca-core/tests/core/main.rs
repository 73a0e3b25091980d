//! Tests of the run-time by itself: laws, scenes built by hand, solvers and lists. The workspace suite tests models.
#![allow(clippy::unwrap_used)]

mod laws;
mod parts;
mod scenes;

/// A small random number generator, the same on every machine: Knuth's linear congruence, in 0 … 1.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}
