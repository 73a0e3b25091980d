//! `ca device calibrate`: reads the stops of a device with the help of a user, or from options, and writes the
//! calibration.

use super::CalibrateArgs;
use crate::outcome::{Ended, Failure, Outcome};
use crate::{load, term};
use ca_device_tools::calibrate::{self, Reader, StopReading};
use ca_device_tools::store;
use ca_haptic::calibration::Calibration;
use ca_haptic::frame::DOF;
use ca_haptic::host::services::check_name;
use ca_model::quantity::short;
use std::io::{BufRead as _, IsTerminal as _, Write as _};

/// Runs the command.
pub fn run(args: &CalibrateArgs) -> Outcome {
    // the name becomes a file name
    check_name(&args.name)?;
    let given: Vec<String> = args.profile.iter().cloned().collect();
    let profile = store::profile_of(&args.name, &given, &mut term::message)?;
    let profile = calibrate::described(&args.name, profile)?;
    let n = (profile.dof as usize).min(DOF);
    let path = args.output.clone().unwrap_or_else(|| store::calibration_file(&args.name));
    let old = if path.is_file() {
        Calibration::read(&load::text(&path)?, &path.display().to_string())?
    } else {
        Calibration::default()
    };
    let stops = if args.low.is_empty() {
        asked(&args.name, n)?
    } else {
        let pairs = each(&args.low, n, "--low")?.into_iter().zip(each(&args.high, n, "--high")?);
        pairs.map(|(low, high)| Some([low, high])).collect()
    };
    let by = std::env::var("USER").unwrap_or_else(|_| "somebody".into());
    let c = calibrate::calibration(&args.name, format!("{by}, with `ca device calibrate`"), &stops, &profile, &old)?;
    store::write(&path, &c)?;
    let mut out = std::io::stdout().lock();
    if args.json {
        let v =
            serde_json::json!({"file": path.display().to_string(), "id": format!("{:x}", c.id()), "calibration": c});
        writeln!(out, "{v:#}")?;
    } else {
        for (k, a) in c.axis.iter().enumerate() {
            writeln!(out, "axis {k}: {} m per unit, {} m at 0", short(a.scale), short(a.offset))?;
        }
        writeln!(out, "{}: calibration {:x} of `{}`", path.display(), c.id(), c.device)?;
    }
    Ok(Ended::Well)
}

/// Expands a single number to all axes, or checks that there is one per axis.
fn each(given: &[f64], n: usize, what: &str) -> Result<Vec<f64>, Failure> {
    match given.len() {
        1 => Ok(vec![given[0]; n]),
        len if len == n => Ok(given.to_vec()),
        len => Err(Failure::Usage(format!("{what}: {len} readings for {n} degrees of freedom; give 1 or {n}"))),
    }
}

/// Asks the user to move each axis of a running device to both stops. A skipped axis is `None`.
fn asked(name: &str, n: usize) -> Result<Vec<Option<[f64; 2]>>, Failure> {
    if !std::io::stdin().is_terminal() {
        let fix = "run it in a terminal, or give the readings with `--low` and `--high`";
        return Err(Failure::Usage(format!(
            "standard input is not a terminal, so the readings cannot be asked for; {fix}"
        )));
    }
    let mut reader = Reader::open(name)?;
    term::note(
        "forces are off. Move each axis to its stops and hold it there. Enter reads it, `s` and Enter skip the axis",
    );
    let mut stops = Vec::new();
    for k in 0..n {
        stops.push(loop {
            let Some(low) = stop(&mut reader, k, "low")? else { break None };
            let Some(high) = stop(&mut reader, k, "high")? else { break None };
            if let Some(stops) = calibrate::stops(low, high) {
                break Some(stops);
            }
            term::warning(&format!(
                "axis {k}: it moved during a reading, or did not move between the stops; read both stops again"
            ));
        });
    }
    Ok(stops)
}

/// Reads axis `k` at a stop. Returns `None` if the user skips it.
fn stop(reader: &mut Reader, k: usize, which: &str) -> Result<Option<StopReading>, Failure> {
    eprint!("axis {k}, {which} stop: ");
    let mut answer = String::new();
    let got = std::io::stdin().lock().read_line(&mut answer);
    if got.map_err(|e| Failure::Failed(format!("stdin: {}", load::reason(&e))))? == 0 {
        return Err(Failure::Interrupted("interrupted: nothing was written".into()));
    }
    if answer.trim() == "s" {
        return Ok(None);
    }
    Ok(Some(reader.stop(k)?))
}
