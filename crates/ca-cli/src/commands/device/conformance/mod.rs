//! `ca device conformance`: whether a device process keeps what the engine relies on.
//!
//! Decides to look only at what the device says on its lines, since that is all an engine has: no driver is opened, no
//! code of the device is linked. The script plays a whole life: silence, an engine at rest, small forces, an engine that
//! dies, another one, one that was never at rest, frames that are not for it. Forces go through the real guard, with the
//! device's own numbers as limits. What the device does not tell (measured forces are optional) is not held against it.

mod bench;
mod forced;
mod quiet;
mod table;

use crate::args::ConformanceArgs;
use crate::outcome::{Failure, Outcome};
use crate::{store, term};
use bench::Bench;
use ca_haptic::host::Site;
use ca_haptic::rt::{self, RtRequest};
use ca_model::quantity::short;
use table::CheckTable;

/// Runs the command.
pub fn run(args: &ConformanceArgs) -> Outcome {
    if !(args.force >= 0.0 && args.force.is_finite()) {
        return Err(Failure::Usage("--force is 0 or more newtons".into()));
    }
    let other = args.profile.iter().find(|g| g.split_once('=').is_some_and(|(device, _)| device != args.name));
    if let Some(given) = other {
        return Err(Failure::Usage(format!("--profile {given}: the device is `{}`", args.name)));
    }
    let calibration = store::calibration_of(&args.name, &[])?;
    let mut bench = Bench::open(&Site::of_user()?, &args.name, calibration)?;
    rt::ask(RtRequest { priority: Some(70), ..RtRequest::default() });
    let mut table = CheckTable::default();
    if let Some(about) = quiet::presented(&mut bench, &mut table)? {
        let mut profile = quiet::profile(&about);
        let force = args.force.min(0.05 * profile.force) / f64::from(profile.axes);
        // nothing of the guard's own is stronger: no edge, and a brake that is as weak as the pull
        profile.guard.edge = 0.0;
        profile.guard.brake = force / profile.guard.speed;
        if force > 0.0 && !args.json {
            term::note(&format!("`{}` is given forces of up to {} N", args.name, short(force)));
        }
        quiet::alive(&mut bench, &about, &mut table);
        quiet::served(&mut bench, args, &about, &mut table)?;
        let mut player = bench.player(&profile)?;
        quiet::rest(&mut bench, &mut player, &mut table);
        let on = forced::forces(&mut bench, &mut player, &mut profile, force, &mut table)?;
        if on {
            forced::spring(&mut bench, &mut player, &mut profile, force, &mut table)?;
            forced::silence(&mut bench, &mut player, &mut profile, force, &about, &mut table)?;
        }
        forced::another(&mut bench, &mut profile, force, &mut table)?;
        quiet::strangers(&mut bench, &mut table);
    }
    table.print(args)
}
