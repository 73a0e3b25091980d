//! Opens the sound output of a performance by its name, through [`ca_audio`].
//!
//! With a page and without a name, the first running server that accepts the model plays the sound. Servers that do not
//! run are not mentioned.

use crate::request::{Listener, Pace, Request};
use ca_audio::{AudioRequest, DEFAULT, Opened, PAGE, Switch, SwitchOptions};
use ca_core::Scene;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::Recorder;
use ca_haptic::serve::audio::Outlet;
use ca_io::gesture::port_maps;
use ca_lab::Failure;
use std::sync::Arc;

/// Opens the requested output or, with a page, a running server. If outputs can be switched, also returns the engine's
/// side of the connection.
///
/// # Errors
/// Fails if the output does not open.
pub(crate) fn open(
    request: &Request,
    scene: &Arc<Scene>,
    recorder: &mut Recorder,
    thread: RtRequest,
    listener: &dyn Listener,
) -> Result<(Switch, Option<Outlet>), Failure> {
    let page = request.page.is_some();
    let named = request.sound.device.is_some();
    // in a page, a controller may be bound to a parameter of any model
    let midi = page || !port_maps(scene).is_empty();
    let wants = AudioRequest { scene: scene.clone(), buffer: request.sound.buffer, midi, thread };
    let found = first(request, &wants, listener)?;
    let open = scene.counts.channels > 0 && request.devices.pace == Pace::Monotonic;
    let (switch, outlet) = Switch::new(wants, found, SwitchOptions { page, open, devices: page || named }, recorder);
    Ok((switch, (open || named).then_some(outlet)))
}

/// Opens the output that plays first, and returns it with its name.
fn first(
    request: &Request,
    wants: &AudioRequest,
    listener: &dyn Listener,
) -> Result<Option<(String, Opened)>, Failure> {
    let page = request.page.is_some();
    match request.sound.device.as_deref() {
        Some(PAGE) if page => Ok(None),
        Some(PAGE) => Err(Failure::Usage("--audio page: `ca serve` does not have a page; use `ca play`".into())),
        Some(wanted) => {
            let name = if wanted.is_empty() { DEFAULT } else { wanted };
            let opened = ca_audio::open(name, wants).map_err(|e| Failure::Failed(format!("--audio {name}: {e}")))?;
            Ok(Some((name.into(), opened)))
        }
        None if page && wants.scene.counts.channels > 0 && request.devices.pace == Pace::Monotonic => {
            Ok(ca_audio::first(wants, |why| listener.note(&why)).map(|(name, opened)| (name.to_owned(), opened)))
        }
        None => Ok(None),
    }
}
