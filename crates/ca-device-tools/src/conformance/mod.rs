//! Conformance: tests that a device process does what the engine relies on.
//!
//! The tests use only the frames of the device, since these are all that an engine has: they open no driver and link no
//! code of the device. The script covers a whole life: silence, an engine at rest, small forces, an engine that dies,
//! another one, one that was never at rest, frames for other devices. Forces pass through the real guard, with limits
//! from the device's own description. Optional data that the device does not send, such as measured forces, are not a
//! failure.

mod bench;
mod forced;
mod quiet;
mod table;

use crate::{Message, ToolError, store};
use bench::Bench;
use ca_haptic::host::Site;
use ca_haptic::rt::{self, RtRequest};
use ca_model::quantity::short;
pub use table::{CheckRow, CheckTable};

/// Options of a test of a running device process.
#[derive(Clone, Debug)]
pub struct Conformance {
    /// Name of the device.
    pub name: String,
    /// Profiles to choose from, as in [`store::profile_of`].
    pub profile: Vec<String>,
    /// Largest force \[N\], at most a twentieth of the device's own limit; 0 tests without forces.
    pub force: f64,
}

/// Tests a device.
///
/// # Errors
/// If no device of that name is running, or a profile or calibration cannot be read.
pub fn run(asked: &Conformance, say: &mut dyn FnMut(Message)) -> Result<CheckTable, ToolError> {
    let calibration = store::calibration_of(&asked.name, &[])?;
    let mut bench = Bench::open(&Site::of_user()?, &asked.name, calibration)?;
    rt::ask(RtRequest { priority: Some(70), ..RtRequest::default() });
    let mut table = CheckTable::default();
    if let Some(about) = quiet::presented(&mut bench, &mut table)? {
        let mut profile = quiet::profile(&about);
        let force = asked.force.min(0.05 * profile.force) / f64::from(profile.axes);
        // no force of the guard itself is stronger: no edge, and a brake as weak as the pull
        profile.guard.edge = 0.0;
        profile.guard.brake = force / profile.guard.speed;
        if force > 0.0 {
            say(Message::Note(format!("the test applies forces of up to {1} N to `{0}`", asked.name, short(force))));
        }
        quiet::alive(&mut bench, &about, &mut table);
        quiet::served(&mut bench, asked, &about, &mut table, say)?;
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
    Ok(table)
}
