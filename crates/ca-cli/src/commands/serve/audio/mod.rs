//! The sound of `ca serve` and `ca play`: outputs of [`ca_audio`] by the words of `--audio`.
//!
//! `ca play` takes the first server that runs and plays the model as it is, unasked, and does not mention servers that are absent.

mod switch;

use crate::args::{ClockKind, ServeArgs};
use crate::outcome::Failure;
use crate::term;
use ca_audio::{AudioError, AudioRequest, DEFAULT, Opened};
use ca_core::Scene;
use ca_haptic::rt::RtRequest;
use ca_io::gesture::port_maps;
use std::sync::Arc;
use std::sync::mpsc::Receiver;
pub(super) use switch::Switch;

fn request(args: &ServeArgs, scene: &Arc<Scene>, page: bool, thread: RtRequest) -> AudioRequest {
    // in a page a controller may be bound to a parameter of any model
    let midi = page || !port_maps(scene).is_empty();
    AudioRequest { scene: scene.clone(), buffer: args.audio_buffer, midi, thread }
}

/// Opens the output of `--audio` and gives its name. Without `--audio` and with `plays`, it opens a server that runs; `None` if
/// there is none.
fn open(args: &ServeArgs, wants: &AudioRequest, plays: bool) -> Result<Option<(String, Opened)>, Failure> {
    match args.audio.as_deref() {
        Some(switch::PAGE) if plays => Ok(None),
        Some(switch::PAGE) => {
            Err(Failure::Usage("--audio page: `ca serve` does not have a page; `ca play` does".into()))
        }
        Some(wanted) => {
            let name = if wanted.is_empty() { DEFAULT } else { wanted };
            let opened = ca_audio::open(name, wants).map_err(|e| Failure::Failed(format!("--audio {name}: {e}")))?;
            Ok(Some((name.into(), opened)))
        }
        None if plays && wants.scene.counts.channels > 0 && args.clock == ClockKind::Monotonic => {
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

/// Names that can be chosen without a look at the machine.
fn servers(page: bool) -> Vec<String> {
    page.then_some(switch::PAGE).into_iter().chain(ca_audio::servers()).map(Into::into).collect()
}

/// The same and all sound devices, which a new thread finds; `None` in a build without them.
fn choices(page: bool) -> Option<Receiver<Vec<String>>> {
    if !cfg!(feature = "audio") {
        return None;
    }
    let (tell, all) = std::sync::mpsc::channel();
    let look = move || {
        let page = page.then(|| switch::PAGE.to_owned());
        let _ = tell.send(page.into_iter().chain(ca_audio::names()).collect());
    };
    std::thread::Builder::new().name("ca looks for sound".into()).spawn(look).ok().map(|_| all)
}
