//! Builds an engine with its devices from a scene and the device options.

use crate::request::{DeviceOptions, Listener};
use ca_core::Scene;
use ca_device_tools::{Message, ToolError, store};
use ca_haptic::engine::{Engine, Options, Port, Setup};
use ca_haptic::frame::DOF;
use ca_haptic::host::{HostError, HostErrorKind};
use ca_haptic::profile::Profile;
use ca_lab::Failure;
use ca_lab::load::ticked;
use ca_take::{beyond, devices, dofs};
use std::sync::Arc;

/// Returns the setup of each device, and the limits of each device without a profile.
pub(crate) fn setups(
    options: &DeviceOptions,
    scene: &Scene,
    listener: &dyn Listener,
) -> Result<(Vec<Setup>, Vec<Option<Profile>>), Failure> {
    let names = devices(scene);
    for given in options.profiles.iter().chain(&options.calibrations) {
        if let Some((device, _)) = given.split_once('=') {
            if !names.iter().any(|n| n == device) {
                if names.is_empty() {
                    let what = format!("`{given}`: the model does not use devices; leave out this option");
                    return Err(Failure::Usage(what));
                }
                let all = ticked(names.iter().map(String::as_str));
                let what = format!("`{given}`: the model does not use a device `{device}`");
                return Err(Failure::Usage(format!("{what}; it uses {all}")));
            }
        }
    }
    let (mut setups, mut unknown) = (Vec::new(), Vec::new());
    for device in names {
        let mut profile = store::profile_of(&device, &options.profiles, &mut |message| match message {
            Message::Note(text) => listener.note(&text),
            Message::Warning(text) => listener.warning(&text),
        })
        .map_err(failure)?;
        let calibration = store::calibration_of(&device, &options.calibrations).map_err(failure)?;
        let wanted = dofs(scene, &device);
        let far: Vec<&str> = beyond(scene, &device).map(|i| i.name.as_str()).collect();
        if let Some(first) = far.first() {
            let keys =
                if far.len() == 1 { format!("`{first}`") } else { format!("{} ports from `{first}` on", far.len()) };
            listener.note(&format!(
                "`{device}`: a device has at most {DOF} degrees of freedom; only MIDI and gestures move {keys}"
            ));
        }
        unknown.push(profile.is_unknown().then(|| profile.clone()));
        if profile.is_unknown() {
            // the description comes from the device, which may connect later
            profile = profile.undescribed(wanted);
        } else if wanted > profile.dof {
            if profile.axes > 1 {
                let what = format!("the model uses degree of freedom {} (counted from 0) of `{device}`", wanted - 1);
                let fix = format!("choose another profile with `--profile {device}=NAME`");
                return Err(Failure::Failed(format!("{what}, but a {} has {}; {fix}", profile.title, profile.dof)));
            }
            let what = format!("the model uses {wanted} keys of `{device}`, but its profile has {}", profile.dof);
            let more =
                "only MIDI and gestures move the others; if the device has more keys, increase `dof` in its profile";
            listener.note(&format!("{what}: {more}"));
        }
        let gains = ca_haptic::equivalence::gains(scene, &device);
        setups.push(Setup { device, profile, calibration, gains });
    }
    Ok((setups, unknown))
}

fn failure(e: ToolError) -> Failure {
    match e {
        ToolError::Usage(what) => Failure::Usage(what),
        ToolError::Host(e) => host_failure(&e),
        ToolError::File(e) => e.into(),
        ToolError::Failed(what) => Failure::Failed(what),
    }
}

pub(crate) fn host_failure(e: &HostError) -> Failure {
    match e.kind {
        HostErrorKind::Site | HostErrorKind::Name => Failure::Usage(e.to_string()),
        _ => Failure::Failed(e.to_string()),
    }
}

pub(crate) fn engine(scene: Arc<Scene>, setups: &[Setup], session: u64) -> Engine {
    let ports = setups.iter().map(|s| Port::new(&scene, s.clone())).collect();
    Engine::new(scene, ports, Options { session, ..Options::default() })
}
