//! `ca device list`: lists the running devices and the profiles for `--profile`.

use crate::outcome::{Ended, Outcome};
use ca_device_tools::store;
use ca_haptic::frame::{About, text};
use ca_haptic::host::Site;
use ca_haptic::host::gateway::list_devices;
use ca_model::quantity::short;
use serde_json::json;
use std::io::Write as _;
use std::time::Duration;

/// Wait for devices, which announce themselves once per second.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Runs the command.
pub fn run(asked: bool) -> Outcome {
    let site = Site::of_user()?;
    let devices = list_devices(&site, PATIENCE)?;
    let profiles = store::profiles()?;
    let mut out = std::io::stdout().lock();
    if asked {
        let devices: Vec<_> = devices.iter().map(value).collect();
        let profiles: Vec<_> = profiles.iter().map(|(p, own)| json!({"own": own, "profile": p})).collect();
        let v = json!({"root": site.root().display().to_string(), "devices": devices, "profiles": profiles});
        writeln!(out, "{v:#}")?;
        return Ok(Ended::Well);
    }
    if devices.is_empty() {
        writeln!(out, "no running device at {}; `ca device sim` starts a simulated one", site.root().display())?;
    }
    for a in &devices {
        let n = a.n as usize;
        writeln!(
            out,
            "{}: {}, {} degrees of freedom, {} frames per second",
            text(&a.device),
            text(&a.model),
            n,
            a.rate
        )?;
        let [low, high] = [&a.low, &a.high].map(|r| short(1e3 * f64::from(r[0])));
        let force = short(f64::from(a.force[0]));
        writeln!(out, "  first axis: {low} to {high} mm, at most {force} N; firmware {}", text(&a.firmware))?;
    }
    writeln!(out, "\nprofiles")?;
    for (p, own) in &profiles {
        let travel = short(1e3 * (p.range[1] - p.range[0]));
        let own = if *own { " (yours)" } else { "" };
        let (force, rate) = (short(p.force), p.rate);
        writeln!(out, "  {:<17}{:>2} x {travel:>4} mm {force:>5} N {rate:>4} Hz  {}{own}", p.name, p.dof, p.title)?;
    }
    Ok(Ended::Well)
}

fn value(a: &About) -> serde_json::Value {
    let n = (a.n as usize).min(a.low.len());
    json!({
        "device": text(&a.device), "session": format!("{:x}", a.session), "model": text(&a.model),
        "serial": text(&a.serial), "firmware": text(&a.firmware), "calibration": format!("{:x}", a.calibration),
        "rate": a.rate, "dof": n, "axes": a.axes, "low": a.low[..n], "high": a.high[..n], "force": a.force[..n],
        "continuous": a.continuous[..n], "stiffness": a.stiffness[..n], "damping": a.damping[..n],
    })
}
