//! What the test binaries share: every model there is, how to play one by its own gesture, and a key. The suite is in
//! `suite/`. Below stands the README, so that its Rust is compiled and run.
#![doc = include_str!("../../README.md")]

pub mod long_form;
pub mod skipped;

use ca_core::{Catalog, Scene, State};
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::Setup;
use ca_haptic::profile::Profile;
use std::path::Path;

/// All kinds there are.
pub fn catalog() -> Catalog {
    ca_model::catalog().with(ca_lpr::KINDS)
}

/// Name and text of every model: the examples of the catalog, `models/` without its parts, and `tests/models/`.
pub fn texts() -> Vec<(String, String)> {
    let mut all: Vec<_> = catalog().iter().map(|k| (format!("example of {}", k.code), k.example.into())).collect();
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in [here.join("models"), here.join("../models")] {
        let mut found = Vec::new();
        collect(&folder, &mut found);
        found.sort();
        all.extend(found);
    }
    all
}

fn collect(folder: &Path, found: &mut Vec<(String, String)>) {
    for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()) {
        if path.is_dir() && !path.ends_with("parts") {
            collect(&path, found);
        } else if path.to_string_lossy().ends_with(".ca.toml") {
            if let Ok(text) = std::fs::read_to_string(&path) {
                found.push((path.file_name().unwrap_or_default().to_string_lossy().into(), text));
            }
        }
    }
}

/// Value at time `t` \[s\] of breakpoints, held outside.
pub fn follow(points: &[[f64; 2]], t: f64) -> f64 {
    let i = points.partition_point(|p| p[0] <= t);
    match (i.checked_sub(1).map(|i| points[i]), points.get(i).copied()) {
        (Some([t0, v0]), Some([t1, v1])) => v0 + (v1 - v0) * ((t - t0) / (t1 - t0)),
        (Some([_, v]), None) | (None, Some([_, v])) => v,
        (None, None) => 0.0,
    }
}

/// Puts on the ports what the scene's own gesture says for the next tick. Live parameters stay as they are.
pub fn gesture(scene: &Scene, s: &mut State) {
    let t = s.tick as f64 * scene.rates.sample_dt;
    for (name, points) in &scene.about.gestures {
        if let Some(i) = scene.inputs.iter().position(|input| input.name == *name) {
            s.input[i] = follow(points, t);
        }
    }
}

/// A key on a spring of 500 N/m.
pub const KEY: &str = r#"
[TGR]
key = { device = "key", dof = 0 }
[SOL]
wall = {}
[RES]
spring = { between = ["key", "wall"], k = 500 }
[SOX]
out = { from = "key" }
"#;

/// One key of the TGR, with whatever a test changes.
///
/// # Panics
/// Where the profile is not shipped any more.
pub fn profile(change: impl FnOnce(&mut Profile)) -> Profile {
    let mut profile = Profile::shipped("tgr12").unwrap_or_else(|| panic!("no profile `tgr12`"));
    profile.dof = 1;
    change(&mut profile);
    profile
}

/// A device as its profile says, neither calibrated nor weighed against the model.
pub fn setup(device: &str, profile: Profile) -> Setup {
    Setup { device: device.into(), profile, calibration: Calibration::default(), gains: vec![] }
}
