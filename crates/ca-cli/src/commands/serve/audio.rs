//! The sound of `ca serve` and `ca play`: outputs of [`ca_audio`] by the words of `--audio`.
//!
//! `ca play` takes the first server that runs and plays the model as it is, unasked, and does not mention servers that are absent.

use crate::args::{ClockKind, ServeArgs};
use crate::outcome::Failure;
use crate::term;
use ca_audio::{AudioError, AudioRequest, DEFAULT, Opened, PAGE, Switch, SwitchOptions};
use ca_core::Scene;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::Recorder;
use ca_haptic::serve::audio::Outlet;
use ca_io::gesture::port_maps;
use std::sync::Arc;

/// Opens the output of `--audio`, or with a `page` a server that runs. Gives the engine's end too, if an output can be chosen.
pub(super) fn open(
    args: &ServeArgs,
    scene: &Arc<Scene>,
    recorder: &mut Recorder,
    page: bool,
    thread: RtRequest,
) -> Result<(Switch, Option<Outlet>), Failure> {
    let wants = request(args, scene, page, thread);
    let found = first(args, &wants, page)?;
    let open = scene.channels > 0 && args.clock == ClockKind::Monotonic;
    let options = SwitchOptions { page, open, devices: page || args.audio.is_some() };
    let (switch, outlet) = Switch::new(wants, found, options, recorder);
    Ok((switch, (open || args.audio.is_some()).then_some(outlet)))
}

fn request(args: &ServeArgs, scene: &Arc<Scene>, page: bool, thread: RtRequest) -> AudioRequest {
    // in a page a controller may be bound to a parameter of any model
    let midi = page || !port_maps(scene).is_empty();
    AudioRequest { scene: scene.clone(), buffer: args.audio_buffer, midi, thread }
}

/// Opens the output of `--audio` and gives its name. Without `--audio` and with `plays`, it opens a server that runs; `None` if
/// there is none.
fn first(args: &ServeArgs, wants: &AudioRequest, plays: bool) -> Result<Option<(String, Opened)>, Failure> {
    match args.audio.as_deref() {
        Some(PAGE) if plays => Ok(None),
        Some(PAGE) => Err(Failure::Usage("--audio page: `ca serve` does not have a page; `ca play` does".into())),
        Some(wanted) => {
            let name = if wanted.is_empty() { DEFAULT } else { wanted };
            let opened = ca_audio::open(name, wants).map_err(|e| Failure::Failed(format!("--audio {name}: {e}")))?;
            Ok(Some((name.into(), opened)))
        }
        None if plays && wants.scene.channels > 0 && args.clock == ClockKind::Monotonic => {
            Ok(ca_audio::first(wants, |why| term::note(&why)).map(|(name, opened)| (name.to_owned(), opened)))
        }
        None => Ok(None),
    }
}

impl From<AudioError> for Failure {
    fn from(e: AudioError) -> Failure {
        Failure::Failed(e.to_string())
    }
}
