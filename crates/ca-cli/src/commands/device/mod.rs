//! `ca device`: device processes, simulated and tested.

mod calibrate;
mod conformance;
mod doctor;
mod list;
mod sim;

use crate::args::{DeviceArgs, DeviceCommand};
use crate::outcome::Outcome;
use ca_haptic::frame::{About, DOF};
use ca_haptic::profile::Profile;

/// Runs the command.
pub fn run(args: &DeviceArgs) -> Outcome {
    match &args.what {
        DeviceCommand::Sim(a) => sim::run(a),
        DeviceCommand::List { json } => list::run(*json),
        DeviceCommand::Doctor { json } => doctor::run(*json),
        DeviceCommand::Calibrate(a) => calibrate::run(a),
        DeviceCommand::Conformance(a) => conformance::run(a),
    }
}

/// What a device of this profile says of itself.
fn about(name: &str, p: &Profile) -> About {
    let mut about = About { axes: p.axes as u16, ..About::new(name, p.rate.round() as u32, p.dof as usize) };
    for k in 0..(p.dof as usize).min(DOF) {
        (about.low[k], about.high[k]) = (p.range[0] as f32, p.range[1] as f32);
        (about.force[k], about.continuous[k]) = (p.force as f32, p.continuous() as f32);
        (about.stiffness[k], about.damping[k]) = (p.stiffness.unwrap_or(0.0) as f32, p.damping.unwrap_or(0.0) as f32);
    }
    write(&mut about.model, &p.title);
    write(&mut about.firmware, concat!("ca ", env!("CARGO_PKG_VERSION")));
    about
}

/// A text into a place of fixed length, zeros after it, cut between letters.
fn write(to: &mut [u8], text: &str) {
    let end = text.char_indices().map(|(at, c)| at + c.len_utf8()).take_while(|e| *e <= to.len()).last();
    let end = end.unwrap_or(0);
    to[..end].copy_from_slice(&text.as_bytes()[..end]);
}
