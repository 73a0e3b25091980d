//! Error against run time of a model, as `ca accuracy` measures it.
//!
//! The run times are those of WebAssembly on this machine. The module that measures is compiled like the engine, so
//! that they are the times of the engine in a browser.

use crate::compiler::{Answer, Source, compiled, failed, finished, refused};
use ca_accuracy::timing::Clock;
use ca_accuracy::{AccuracyOptions, Reported, heard, measured};
use ca_lab::Failure;
use serde::Deserialize;
use serde_json::Value;
use std::time::Duration;

/// Largest step of the clock in a browser, which makes it coarse on purpose.
pub const CLOCK_STEP: Duration = Duration::from_millis(1);

/// Longest sound to compare \[s\].
const LONGEST: f64 = 10.0;

/// Maximum number of samples, over all compared modules; several such sounds are in memory at once.
const MOST: f64 = 1e7;

/// Maximum multiple of the rate, and ends of the range of the multiple for the reference.
const TIMES: u32 = 1024;
const REFERENCES: std::ops::RangeInclusive<u32> = 4..=4096;

/// A request of a page.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Ask {
    /// Measures a model. The answer has a page with plot and table as bytes.
    Accuracy {
        #[serde(flatten)]
        source: Source,
        #[serde(flatten)]
        options: Options,
    },
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct Options {
    /// Duration \[s\].
    seconds: Option<f64>,
    /// Multiples of the rate.
    times: Vec<u32>,
    /// Multiple of the rate for the reference.
    reference: Option<u32>,
    /// Modules to compare; the outputs if empty.
    probes: Vec<String>,
    /// Relative RMS error for which the fastest row is wanted.
    error: Option<f64>,
}

/// Answers a request, a JSON text: an object, which has the JSON of `ca accuracy --json` or the reason of a refusal, and
/// the page of `ca accuracy -o`. `clock` gives the run times. `progress` receives the numbers of finished steps and of
/// all steps; false ends the measurement.
pub fn answer(request: &[u8], clock: Clock, progress: &mut dyn FnMut(u64, u64) -> bool) -> (Value, Vec<u8>) {
    finished(match serde_json::from_slice(request) {
        Ok(Ask::Accuracy { source, options }) => accuracy(&source, &options, clock, progress),
        Err(why) => Err(refused(format!("the request cannot be read: {why}"))),
    })
}

fn accuracy(source: &Source, options: &Options, clock: Clock, progress: &mut dyn FnMut(u64, u64) -> bool) -> Answer {
    let Options { seconds, times, reference, probes, error } = options;
    check(options).map_err(refused)?;
    let (loaded, compiled) = compiled(source)?;
    let probes = if probes.is_empty() { heard(&loaded.model) } else { probes.clone() };
    if probes.is_empty() {
        let what = format!("`{}` has no output to compare", loaded.name);
        return Err(refused(format!("{what}; add a `[SOX]`, or choose modules to compare with `probes`")));
    }
    let samples = seconds.unwrap_or(1.0) * compiled.scene.rate * probes.len() as f64;
    if samples > MOST {
        let n = probes.len();
        return Err(refused(format!(
            "{n} modules at {} Hz are too much to compare here; give fewer `seconds`, or fewer `probes`",
            compiled.scene.rate
        )));
    }
    let mut ask = AccuracyOptions {
        rate: None,
        probes: &probes,
        seconds: *seconds,
        times: Some(&times[..]).filter(|times| !times.is_empty()),
        reference: *reference,
        remedy: "play longer with `seconds`, or compare other modules with `probes`",
        clock,
        progress,
    };
    let found = measured(&loaded, &mut ask).map_err(|why| match why {
        Failure::Stopped => refused("the measurement was stopped"),
        other => failed(other),
    })?;
    let reported = Reported::new(&loaded.name, &found, *error, "");
    Ok((reported.json(), reported.page(&loaded.model).html().into_bytes()))
}

fn check(options: &Options) -> Result<(), String> {
    let Options { seconds, times, reference, error, .. } = options;
    match (seconds, error) {
        (Some(s), _) if !(*s > 0.0 && *s <= LONGEST) => {
            return Err(format!("`seconds` is {s}; it must be above 0 and at most {LONGEST}"));
        }
        (_, Some(e)) if !(*e > 0.0 && e.is_finite()) => {
            return Err(format!("`error` is {e}; it must be above 0, such as 1e-3"));
        }
        _ => {}
    }
    if let Some(n) = times.iter().find(|n| !(1..=TIMES).contains(*n)) {
        return Err(format!("`times` has {n}; multiples of the rate are from 1 to {TIMES}"));
    }
    match reference {
        Some(n) if !REFERENCES.contains(n) => {
            Err(format!("`reference` is {n}; it must be from {} to {}", REFERENCES.start(), REFERENCES.end()))
        }
        _ => Ok(()),
    }
}
