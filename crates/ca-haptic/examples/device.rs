//! The smallest device: a damped finger of 100 g that the force of the engine moves.
//!
//! It sends its position 1000 times a second, moves under the force of `safe_force`, and prints statistics.
//! `cargo run -p ca-haptic --example device -- finger 3000`

use ca_haptic::frame::{About, DOF, DeviceFrame, Mode};
use ca_haptic::host::{DeviceClient, HostError, Site};
use std::time::{Duration, Instant};

/// Mass of the finger \[kg\].
const M: f64 = 0.1;
/// Viscosity of the finger \[N s/m\].
const Z: f64 = 2.0;
/// Time between frames \[s\].
const DT: f64 = 0.001;

/// Runs a finger for some frames and returns the line to print.
///
/// # Errors
/// If the name is taken, or the shared memory cannot be created.
pub fn run(name: &str, frames: u64) -> Result<String, HostError> {
    let mut about = About {
        low: [-0.02; DOF],
        high: [0.02; DOF],
        force: [10.0; DOF],
        continuous: [10.0; DOF],
        ..About::new(name, (1.0 / DT) as u32, 1)
    };
    about.model[..6].copy_from_slice(b"finger");
    let mut device = DeviceClient::open(&Site::of_user()?, about)?;
    let mut frame = DeviceFrame::new(name, 1);
    let (mut x, mut v) = (0.0, 0.0);
    let (mut seen, mut felt, mut most) = (0_u64, 0_u64, 0.0_f64);
    let start = Instant::now();
    for n in 0..frames {
        frame.pos[0] = x;
        frame.t_device_ns = start.elapsed().as_nanos() as u64;
        device.send(&mut frame)?;
        // `safe_force` is zero unless the force is fresh, for this device and switched on
        let force = device.safe_force()[0];
        v = (v + force / M * DT) / (1.0 + Z / M * DT);
        x += v * DT;
        seen = device.watchdog().last().map_or(0, |f| f.seq);
        felt += u64::from(force != 0.0);
        most = most.max(force.abs());
        let due = start + Duration::from_secs_f64((n + 1) as f64 * DT);
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    let mode = device.watchdog().last().map_or("none", |f| Mode::read(f.mode).name());
    Ok(format!("sent {frames} seen {seen} felt {felt} most {most:.3} x {x:.6} mode {mode}"))
}

#[allow(dead_code)]
fn main() -> Result<(), HostError> {
    let mut args = std::env::args().skip(1);
    let name = args.next().unwrap_or_else(|| "finger".into());
    let frames = args.next().and_then(|n| n.parse().ok()).unwrap_or(3000);
    println!("{}", run(&name, frames)?);
    Ok(())
}
