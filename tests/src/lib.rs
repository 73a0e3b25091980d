//! Shared by the test binaries: all models, how to play one by its own gesture, and a model of one key. The suite is in
//! `suite/`. `docs/rust.md` is included below, so that its Rust is compiled and run.
#![doc = include_str!("../../docs/rust.md")]

pub mod long_form;
pub mod skipped;

pub use ca_conformance::models::{catalog, follow, gesture, texts};
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::Setup;
use ca_haptic::profile::Profile;

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

/// One key of the TGR, after `change`.
///
/// # Panics
/// If the profile is no longer shipped.
pub fn profile(change: impl FnOnce(&mut Profile)) -> Profile {
    let mut profile = Profile::shipped("tgr12").unwrap_or_else(|| panic!("no profile `tgr12`"));
    profile.dof = 1;
    change(&mut profile);
    profile
}

/// A device with this profile, neither calibrated nor scaled to the model.
pub fn setup(device: &str, profile: Profile) -> Setup {
    Setup { device: device.into(), profile, calibration: Calibration::default(), gains: vec![] }
}
