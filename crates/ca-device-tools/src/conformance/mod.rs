//! Conformance: whether a device process keeps what the engine relies on.
//!
//! Decides to look only at what the device says on its lines, since that is all an engine has: no driver is opened, no
//! code of the device is linked. The script plays a whole life: silence, an engine at rest, small forces, an engine that
//! dies, another one, one that was never at rest, frames that are not for it. Forces go through the real guard, with the
//! device's own numbers as limits. What the device does not tell (measured forces are optional) is not held against it.

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

/// A test of a running device process.
#[derive(Clone, Debug)]
pub struct Conformance {
    /// the device
    pub name: String,
    /// the profile that it is played with, as of [`store::profile_of`]
    pub profile: Vec<String>,
    /// largest force \[N\], at most a twentieth of what the device says it can give; 0 tests without forces
    pub force: f64,
}

/// Tests a device.
///
/// # Errors
/// If no device of that name speaks, or a profile or calibration cannot be read.
pub fn run(asked: &Conformance, say: &mut dyn FnMut(Message)) -> Result<CheckTable, ToolError> {
    let calibration = store::calibration_of(&asked.name, &[])?;
    let mut bench = Bench::open(&Site::of_user()?, &asked.name, calibration)?;
    rt::ask(RtRequest { priority: Some(70), ..RtRequest::default() });
    let mut table = CheckTable::default();
    if let Some(about) = quiet::presented(&mut bench, &mut table)? {
        let mut profile = quiet::profile(&about);
        let force = asked.force.min(0.05 * profile.force) / f64::from(profile.axes);
        // nothing of the guard's own is stronger: no edge, and a brake that is as weak as the pull
        profile.guard.edge = 0.0;
        profile.guard.brake = force / profile.guard.speed;
        if force > 0.0 {
            say(Message::Note(format!("`{}` is given forces of up to {} N", asked.name, short(force))));
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
