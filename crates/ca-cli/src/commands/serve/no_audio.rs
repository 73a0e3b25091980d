//! In place of `audio.rs` in a build without the feature `audio`: says so.

use crate::Failure;
use crate::args::ServeArgs;
use ca_core::Scene;
use ca_haptic::serve::Recorder;
use ca_haptic::serve::audio::Follow;

/// There is none.
pub(super) enum Playing {}

/// Refuses.
pub(super) fn open(args: &ServeArgs, _: &Scene, _: &mut Recorder) -> Result<Option<(Playing, Follow)>, Failure> {
    match args.audio {
        None => Ok(None),
        Some(_) => Err(Failure::Failed(
            "--audio: this `ca` is built without sound devices; `cargo install --path crates/ca-cli --features audio` \
             builds one with them (on Linux with the headers of ALSA and JACK: libasound2-dev, libjack-jackd2-dev)"
                .into(),
        )),
    }
}

impl Playing {
    pub(super) fn start(&self) -> Result<(), Failure> {
        match *self {}
    }

    pub(super) fn turn(&self, _: &mut Recorder) {
        match *self {}
    }

    pub(super) fn end(self, _: f64) {
        match self {}
    }
}
