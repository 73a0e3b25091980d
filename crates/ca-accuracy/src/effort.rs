//! Limits the run time of a measurement: chooses duration, rates and reference if the caller names none.

use super::{AccuracyOptions, BUDGET};
use ca_core::Scene;
use ca_io::perform::Performance;
use ca_lab::Failure;
use std::time::Instant;

/// Ticks by which the run time is estimated.
const TICKS: u64 = 1000;

/// Multiples of the rate, and run time of all methods at all rates, in runs of the model as written.
const TIMES: [u32; 4] = [1, 2, 4, 8];
const METHODS: f64 = 16.0;

/// Multiples of the rate for the reference, and run time of both references, in runs at that rate.
const REFERENCES: [u32; 4] = [64, 32, 16, 8];
const RUNS: f64 = 6.0;

/// Estimates the run time of a second of sound \[s\].
pub fn share_of_real_time(scene: &Scene) -> Result<f64, Failure> {
    let mut p = Performance::new(scene, None)?;
    let begin = Instant::now();
    p.until(TICKS, 1);
    let samples = TICKS as f64 / f64::from(scene.oversample());
    Ok(begin.elapsed().as_secs_f64() * scene.rate / samples)
}

/// Returns the multiples of the rate, each once, and the multiple for the reference. `run` is the run time of the model
/// as written \[s\].
pub fn chosen(ask: &AccuracyOptions, run: f64) -> (Vec<u32>, u32) {
    let fits = |last: usize| f64::from(TIMES[..=last].iter().sum::<u32>()) * METHODS * run <= BUDGET;
    let few = || TIMES[..=(1..TIMES.len()).rev().find(|n| fits(*n)).unwrap_or(0)].to_vec();
    let mut times = ask.times.map_or_else(few, <[u32]>::to_vec);
    times.sort_unstable();
    times.dedup();
    let largest = || REFERENCES.into_iter().find(|n| f64::from(*n) * RUNS * run <= BUDGET).unwrap_or(8);
    (times, ask.reference.unwrap_or_else(largest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_gets_fewer_rates_and_a_coarser_reference() {
        let go_on = &mut |_, _| true;
        let mut ask = AccuracyOptions {
            rate: None,
            probes: &[],
            seconds: None,
            times: None,
            reference: None,
            remedy: "",
            progress: go_on,
        };
        assert_eq!(chosen(&ask, 1e-3), (vec![1, 2, 4, 8], 64));
        assert_eq!(chosen(&ask, 0.1), (vec![1, 2], 16));
        assert_eq!(chosen(&ask, 100.0), (vec![1], 8));
        (ask.times, ask.reference) = (Some(&[4, 1, 4][..]), Some(12));
        assert_eq!(chosen(&ask, 100.0), (vec![1, 4], 12));
    }
}
