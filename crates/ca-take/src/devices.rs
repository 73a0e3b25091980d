//! Lists the devices that a scene names, and their ports.

use ca_core::{Input, InputRole, Scene};
use ca_haptic::frame::DOF;

/// Returns the names of the devices of a scene, in order.
pub fn devices(scene: &Scene) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for i in scene.inputs.iter().filter(|i| i.role == InputRole::Device) {
        if let Some((name, _)) = &i.device {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
    }
    names
}

/// Returns the number of degrees of freedom of a device that a scene uses: its highest index plus one, at most `DOF`.
pub fn dofs(scene: &Scene, device: &str) -> u32 {
    let all = of_device(scene, device).filter_map(|i| Some(i.device.as_ref()?.1 + 1)).max();
    all.unwrap_or(0).min(DOF as u32)
}

/// Returns the ports of a device beyond the degrees of freedom of a frame. Only MIDI and gestures move them.
pub fn beyond<'s>(scene: &'s Scene, device: &'s str) -> impl Iterator<Item = &'s Input> {
    let far = |i: &&Input| i.device.as_ref().is_some_and(|d| d.1 as usize >= DOF);
    of_device(scene, device).filter(far)
}

fn of_device<'s>(scene: &'s Scene, device: &'s str) -> impl Iterator<Item = &'s Input> {
    scene.inputs.iter().filter(move |i| i.device.as_ref().is_some_and(|d| d.0 == device))
}
