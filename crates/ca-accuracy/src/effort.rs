//! Limits the run time of a measurement: chooses duration, rates and reference if the caller names none.

use super::timing::Clock;
use super::{AccuracyOptions, BUDGET};
use ca_core::Scene;
use ca_io::perform::Performance;
use ca_lab::Failure;

/// Ticks by which the run time is estimated.
const TICKS: u64 = 1000;

/// Multiples of the rate, and run time of all methods at all rates, in runs of the model as written.
const TIMES: [u32; 4] = [1, 2, 4, 8];
const METHODS: f64 = 16.0;

/// Multiples of the rate for the reference, and run time of both references, in runs at that rate.
const REFERENCES: [u32; 4] = [64, 32, 16, 8];
const RUNS: f64 = 6.0;

/// Longest default duration \[s\], and the shortest for a model that takes long.
const LONGEST: f64 = 1.0;
const SHORTEST: f64 = 0.2;

/// Run time of the model as written that shortens the default duration \[s\].
const LONG_RUN: f64 = 0.08;

/// Returns duration \[s\], multiples of the rate, and multiple for the reference. The run time of the scene is measured
/// if one of them is not given.
pub fn chosen(ask: &AccuracyOptions, scene: &Scene) -> Result<(f64, Vec<u32>, u32), Failure> {
    if let (Some(seconds), Some(times), Some(reference)) = (ask.seconds, ask.times, ask.reference) {
        return Ok((seconds, each_once(times), reference));
    }
    let share = share_of_real_time(scene, ask.clock)?;
    let all = scene.about.seconds.unwrap_or(LONGEST).min(LONGEST);
    let seconds = ask.seconds.unwrap_or(all.min((LONG_RUN / share).max(SHORTEST)));
    let (times, reference) = rates(seconds * share);
    Ok((seconds, ask.times.map_or(times, each_once), ask.reference.unwrap_or(reference)))
}

fn each_once(times: &[u32]) -> Vec<u32> {
    let mut times = times.to_vec();
    times.sort_unstable();
    times.dedup();
    times
}

/// Estimates the run time of a second of sound \[s\].
fn share_of_real_time(scene: &Scene, clock: Clock) -> Result<f64, Failure> {
    let mut p = Performance::new(scene, None)?;
    let (begin, mut ticks) = ((clock.now)(), 0);
    let ns = loop {
        ticks += TICKS;
        p.until(ticks, 1);
        let ns = clock.since(begin);
        if ns >= clock.least() {
            break ns;
        }
    };
    let samples = ticks as f64 / f64::from(scene.oversample());
    Ok(1e-9 * ns * scene.rate / samples)
}

/// Returns the multiples of the rate, and the multiple for the reference. `run` is the run time of the model as written
/// \[s\].
fn rates(run: f64) -> (Vec<u32>, u32) {
    let fits = |last: usize| f64::from(TIMES[..=last].iter().sum::<u32>()) * METHODS * run <= BUDGET;
    let last = (1..TIMES.len()).rev().find(|n| fits(*n)).unwrap_or(0);
    let largest = REFERENCES.into_iter().find(|n| f64::from(*n) * RUNS * run <= BUDGET).unwrap_or(8);
    (TIMES[..=last].to_vec(), largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_gets_fewer_rates_and_a_coarser_reference() {
        assert_eq!(rates(1e-3), (vec![1, 2, 4, 8], 64));
        assert_eq!(rates(0.1), (vec![1, 2], 16));
        assert_eq!(rates(100.0), (vec![1], 8));
        assert_eq!(each_once(&[4, 1, 4]), [1, 4]);
    }
}
