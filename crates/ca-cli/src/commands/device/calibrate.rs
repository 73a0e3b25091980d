//! `ca device calibrate`: from what a device says to metres.
//!
//! Decides on two readings a degree of freedom, at the stops, whose distance the profile knows: a line through two
//! points says scale, offset and direction at once. The device is asked on the lines of a server, of which there is one:
//! while we have them nobody can give forces, and we give none. A reading is the median of what the device says while
//! the hand holds it still; one that moves is asked for again. Axes that somebody skips keep the calibration they had.

use crate::args::CalibrateArgs;
use crate::outcome::{Ended, Failure, Outcome};
use crate::{load, store, term};
use ca_haptic::calibration::{Axis, Calibration};
use ca_haptic::frame::{DOF, DeviceFrame, text};
use ca_haptic::host::gateway::list_devices;
use ca_haptic::host::{Gateway, Site};
use ca_haptic::profile::Profile;
use ca_model::quantity::short;
use std::io::{BufRead as _, IsTerminal as _, Write as _};
use std::path::Path;
use std::time::{Duration, Instant};

/// Frames of a reading.
const READING: usize = 100;
/// How long a device may take for them.
const PATIENCE: Duration = Duration::from_secs(5);
/// How much a stop may move while it is read, as part of the way between the stops.
const STILL: f64 = 0.02;

/// Runs the command.
pub fn run(args: &CalibrateArgs) -> Outcome {
    let given: Vec<String> = args.profile.iter().cloned().collect();
    let mut profile = store::profile_of(&args.name, &given)?;
    if profile.is_unknown() {
        // one that speaks says itself how many axes it has and how far its stops are apart
        let heard = Site::of_user().and_then(|site| list_devices(&site, PATIENCE)).unwrap_or_default();
        if let Some(about) = heard.iter().find(|a| text(&a.device) == args.name) {
            profile = profile.described(about).map_err(|e| Failure::Failed(format!("`{}`: {e}", args.name)))?;
        }
    }
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
    let mut axes = Vec::new();
    for (k, stops) in stops.iter().enumerate() {
        axes.push(match stops {
            Some(stops) => {
                axis(*stops, &profile, old.axis.get(k)).map_err(|e| Failure::Failed(format!("axis {k}: {e}")))?
            }
            None => *old.axis.get(k).ok_or_else(|| {
                Failure::Failed(format!("axis {k} was skipped and has no calibration to keep; nothing is written"))
            })?,
        });
    }
    let by = std::env::var("USER").unwrap_or_else(|_| "somebody".into());
    let c = Calibration { device: args.name.clone(), by: format!("{by}, with `ca device calibrate`"), axis: axes };
    put(&path, &c.write())?;
    let mut out = std::io::stdout().lock();
    if args.json {
        let v =
            serde_json::json!({"file": path.display().to_string(), "id": format!("{:x}", c.id()), "calibration": c});
        writeln!(out, "{v:#}")?;
    } else {
        for (k, a) in c.axis.iter().enumerate() {
            writeln!(out, "axis {k}: {} m a unit, {} m at 0", short(a.scale), short(a.offset))?;
        }
        writeln!(out, "{}: calibration {:x} of `{}`", path.display(), c.id(), c.device)?;
    }
    Ok(Ended::Well)
}

/// One number for all, or one for each.
fn each(given: &[f64], n: usize, what: &str) -> Result<Vec<f64>, Failure> {
    match given.len() {
        1 => Ok(vec![given[0]; n]),
        len if len == n => Ok(given.to_vec()),
        len => Err(Failure::Usage(format!("{what}: {len} readings for {n} degrees of freedom; give 1 or {n}"))),
    }
}

/// The line through two stops; the factor of forces stays.
fn axis([low, high]: [f64; 2], profile: &Profile, old: Option<&Axis>) -> Result<Axis, String> {
    let [a, b] = profile.range;
    let scale = (b - a) / (high - low);
    if !(scale.is_finite() && low.is_finite() && scale != 0.0) {
        return Err(format!(
            "it says {low} at its low stop and {high} at its high one: two different numbers are needed"
        ));
    }
    Ok(Axis { scale, offset: a - scale * low, force: old.map_or(1.0, |o| o.force) })
}

fn put(path: &Path, text: &str) -> Result<(), Failure> {
    let failed =
        |e: &std::io::Error| Failure::Failed(format!("`{}` cannot be written: {}", path.display(), load::reason(e)));
    if let Some(folder) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(|e| failed(&e))?;
    }
    // whole or not at all: half a calibration would be a force in the wrong place
    Ok(ca_io::atomic_file::write(path, text.as_bytes())?)
}

/// Both stops of each axis, of a running device and a person; `None` where the person skips.
fn asked(name: &str, n: usize) -> Result<Vec<Option<[f64; 2]>>, Failure> {
    if !std::io::stdin().is_terminal() {
        let fix = "run it in a terminal, or say what the device says with `--low` and `--high`";
        return Err(Failure::Usage(format!("nobody can be asked here; {fix}")));
    }
    let mut lines = Gateway::open(&Site::of_user()?, &[name])?;
    reading(&mut lines, name)?;
    term::note("forces are off. Bring each axis to its stops and hold it there; Enter reads it, `s` skips the axis");
    let mut stops = Vec::new();
    for k in 0..n {
        stops.push(loop {
            let Some(low) = stop(&mut lines, name, k, "low")? else { break None };
            let Some(high) = stop(&mut lines, name, k, "high")? else { break None };
            let way = (high.0 - low.0).abs();
            if way > 0.0 && low.1.max(high.1) <= STILL * way {
                break Some([low.0, high.0]);
            }
            term::warning(&format!("axis {k}: it moved while it was read, or not in between; once more"));
        });
    }
    Ok(stops)
}

/// What axis `k` says at a stop, and how much it moved; `None` where the person skips it.
fn stop(lines: &mut Gateway, name: &str, k: usize, which: &str) -> Result<Option<(f64, f64)>, Failure> {
    eprint!("axis {k}, {which} stop: ");
    let mut answer = String::new();
    let got = std::io::stdin().lock().read_line(&mut answer);
    if got.map_err(|e| Failure::Failed(format!("stdin: {}", load::reason(&e))))? == 0 {
        return Err(Failure::Interrupted("interrupted: nothing was written".into()));
    }
    if answer.trim() == "s" {
        return Ok(None);
    }
    // what lies in the queue is of before
    lines.poll(&mut |_, _| {});
    let mut x: Vec<f64> = reading(lines, name)?.iter().map(|f| f.pos[k]).collect();
    x.sort_by(f64::total_cmp);
    Ok(Some((x[x.len() / 2], x[x.len() - 1] - x[0])))
}

/// What the device says from now on.
fn reading(lines: &mut Gateway, name: &str) -> Result<Vec<DeviceFrame>, Failure> {
    let (mut frames, end) = (Vec::new(), Instant::now() + PATIENCE);
    while frames.len() < READING {
        lines.poll(&mut |_, f| frames.push(f));
        if Instant::now() > end {
            let what = format!("`{name}` sent {} frames in {PATIENCE:?}; {READING} are needed", frames.len());
            return Err(Failure::Failed(format!("{what}; start the device, `ca device list` shows those that speak")));
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    Ok(frames)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_stops_make_a_line_in_either_direction() {
        let p = Profile::shipped("tgr12").expect("shipped");
        for stops in [[0.0, 4095.0], [4095.0, 0.0], [-0.3, 0.7]] {
            let a = axis(stops, &p, Some(&Axis { force: 3.0, ..Axis::default() })).expect("a line");
            for (s, x) in stops.iter().zip(p.range) {
                assert!((a.scale * s + a.offset - x).abs() < 1e-15, "{stops:?}");
            }
            assert_eq!(a.force, 3.0);
        }
        for bad in [[1.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            assert!(axis(bad, &p, None).is_err(), "{bad:?}");
        }
    }
}
