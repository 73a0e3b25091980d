//! From a scene and what was typed to an engine with its devices.

use crate::args::ServeArgs;
use crate::outcome::Failure;
use crate::{store, term};
use ca_core::Scene;
use ca_haptic::engine::{Engine, Options, Port, Setup};
use ca_haptic::frame::DOF;
use ca_haptic::profile::Profile;
pub(crate) use ca_take::devices;
use ca_take::{beyond, dofs};
use std::sync::Arc;

/// Everything that belongs to each device; and of each that nobody has described, what it may do at most.
pub(super) fn setups(args: &ServeArgs, scene: &Scene) -> Result<(Vec<Setup>, Vec<Option<Profile>>), Failure> {
    let names = devices(scene);
    for given in args.profile.iter().chain(&args.calibration) {
        if let Some((device, _)) = given.split_once('=') {
            if !names.iter().any(|n| n == device) {
                let all = crate::load::ticked(names.iter().map(String::as_str));
                return Err(Failure::Usage(format!("`{given}`: the model has no device `{device}`; it has {all}")));
            }
        }
    }
    let (mut setups, mut unknown) = (Vec::new(), Vec::new());
    for device in names {
        let mut profile = store::profile_of(&device, &args.profile)?;
        let calibration = store::calibration_of(&device, &args.calibration)?;
        let wanted = dofs(scene, &device);
        let far: Vec<&str> = beyond(scene, &device).map(|i| i.name.as_str()).collect();
        if let Some(first) = far.first() {
            let keys =
                if far.len() == 1 { format!("`{first}`") } else { format!("{} ports from `{first}` on", far.len()) };
            term::note(&format!(
                "`{device}`: a device has at most {DOF} degrees of freedom; MIDI and gestures alone move {keys}"
            ));
        }
        unknown.push(profile.is_unknown().then(|| profile.clone()));
        if profile.is_unknown() {
            // what it is comes from the device, which may come later
            profile = profile.undescribed(wanted);
        } else if wanted > profile.dof {
            if profile.axes > 1 {
                let what = format!("the model uses dof {} of `{device}`", wanted - 1);
                return Err(Failure::Failed(format!("{what}, a {} has {}", profile.title, profile.dof)));
            }
            let what = format!("the model uses {wanted} keys of `{device}`, its profile has {}", profile.dof);
            let more =
                "MIDI and gestures alone move the others; a device with more keys needs a profile with more `dof`";
            term::note(&format!("{what}: {more}"));
        }
        let gains = ca_haptic::equivalence::gains(scene, &device);
        setups.push(Setup { device, profile, calibration, gains });
    }
    Ok((setups, unknown))
}

/// The engine.
pub(super) fn engine(scene: Arc<Scene>, setups: &[Setup], session: u64) -> Engine {
    let ports = setups.iter().map(|s| Port::new(&scene, s.clone())).collect();
    Engine::new(scene, ports, Options { session, ..Options::default() })
}
