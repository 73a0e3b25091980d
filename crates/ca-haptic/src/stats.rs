//! Distributions of the times of a loop, as percentiles.
//!
//! It uses HDR histograms: three digits over any range, fixed memory, and percentiles that do not depend on how many
//! samples are stored. The recorder fills them, never the real-time thread.

use hdrhistogram::Histogram;
use serde::Serialize;

/// A distribution of times.
#[derive(Clone, Debug)]
pub struct Times(Histogram<u64>);

/// Summary of a distribution \[µs\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Percentiles {
    /// Number of times.
    pub n: u64,
    /// Median.
    pub p50: f64,
    /// 99th percentile.
    pub p99: f64,
    /// 99.9th percentile.
    pub p999: f64,
    /// Maximum.
    pub max: f64,
}

impl Default for Times {
    fn default() -> Times {
        Times::new()
    }
}

impl Times {
    /// Makes an empty distribution. Times above 100 s count as 100 s.
    pub fn new() -> Times {
        // the library accepts these constants
        Times(Histogram::new_with_bounds(1, 100_000_000_000, 3).unwrap_or_else(|_| unreachable!()))
    }

    /// Adds a time \[ns\].
    pub fn add(&mut self, ns: u64) {
        self.0.saturating_record(ns.max(1));
    }

    /// Returns the summary; all zeros without samples.
    pub fn percentiles(&self) -> Percentiles {
        if self.0.is_empty() {
            return Percentiles::default();
        }
        let at = |q: f64| self.0.value_at_quantile(q) as f64 * 1e-3;
        Percentiles { n: self.0.len(), p50: at(0.5), p99: at(0.99), p999: at(0.999), max: self.0.max() as f64 * 1e-3 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_a_known_distribution() {
        let mut t = Times::new();
        assert_eq!(t.percentiles(), Percentiles::default());
        for k in 1..=1000_u64 {
            t.add(k * 1000);
        }
        let reported = t.percentiles();
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * b;
        assert!(reported.n == 1000 && near(reported.p50, 500.0) && near(reported.p99, 990.0), "{reported:?}");
        assert!(near(reported.p999, 999.0) && near(reported.max, 1000.0), "{reported:?}");
        t.add(u64::MAX);
        assert!(near(t.percentiles().max, 1e8), "{:?}", t.percentiles());
    }
}
