//! Sound straight to whatever plays it: a JACK server ([`jack`]), a PulseAudio server ([`pulse`]), or a sound device of the system
//! (`device`, feature `audio`).
//!
//! Decides that neither server needs anything when `ca` is built: libjack is loaded at run time, and PulseAudio is spoken to by its
//! socket; a machine without them runs the same program. `ca play` takes the first that is there and plays the model as it is,
//! unasked, while it says nothing of those that are not.

#[cfg(feature = "audio")]
mod device;
mod jack;
mod pulse;

use super::inputs::events::EventReader;
use crate::args::ServeArgs;
use crate::outcome::Failure;
use crate::term;
use ca_core::Scene;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::Recorder;
use ca_haptic::serve::audio::{Counts, Follow};
use ca_lab::gesture::port_maps;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// What is in the ring at the end is waited for at most so long, besides the time it takes to play.
const LATE: Duration = Duration::from_millis(200);

/// No server is waited for longer than this, whatever it says of its latency.
const FAR: Duration = Duration::from_secs(1);

/// Something that plays.
pub(super) struct Playing {
    output: Output,
    counts: Arc<Counts>,
    words: Receiver<String>,
    name: String,
    host: &'static str,
    /// MIDI that it brings
    events: Option<EventReader>,
}

enum Output {
    Jack(Box<jack::Output>),
    Pulse(pulse::PulseStream),
    #[cfg(feature = "audio")]
    Device(device::Output),
}

/// Opens what was asked for, or a server that is there where `plays` says that nobody needs to ask, and hands the engine's
/// side of it to engine and recorder; `None` where nothing was. A thread of its own asks the system for `request`.
pub(super) fn open(
    args: &ServeArgs,
    scene: &Scene,
    recorder: &mut Recorder,
    plays: bool,
    request: RtRequest,
) -> Result<Option<(Playing, Follow)>, Failure> {
    // in a page a controller may be bound to a parameter of any model
    let midi = plays || !port_maps(scene).is_empty();
    match args.audio.as_deref() {
        Some("page") if plays => Ok(None),
        Some("page") => Err(Failure::Usage("--audio page: `ca serve` has no page; `ca play` does".into())),
        Some("jack") => named("jack", jack::open(scene, args.audio_buffer, midi, recorder)),
        Some("pulse") => named("pulse", pulse::open(scene, args.audio_buffer, recorder, request)),
        Some(wanted) => device(wanted, args, scene, recorder).map(Some),
        None if plays && scene.channels > 0 && args.clock == crate::args::ClockKind::Monotonic => {
            Ok(there(jack::open(scene, None, midi, recorder))
                .or_else(|| there(pulse::open(scene, None, recorder, request))))
        }
        None => Ok(None),
    }
}

/// A server that plays this, if it is there.
fn there(opened: Result<(Playing, Follow), Failure>) -> Option<(Playing, Follow)> {
    match opened {
        Ok(playing) => return Some(playing),
        Err(Failure::Usage(why)) => term::note(&why),
        // no server: what most machines are
        Err(_) => {}
    }
    None
}

/// One that was asked for by name.
fn named(name: &str, opened: Result<(Playing, Follow), Failure>) -> Result<Option<(Playing, Follow)>, Failure> {
    match opened {
        Err(Failure::Usage(why)) => Err(Failure::Failed(format!("--audio {name}: {why}"))),
        opened => opened.map(Some),
    }
}

#[cfg(feature = "audio")]
fn device(
    wanted: &str,
    args: &ServeArgs,
    scene: &Scene,
    recorder: &mut Recorder,
) -> Result<(Playing, Follow), Failure> {
    device::open(wanted, args.audio_buffer, scene, recorder)
}

#[cfg(not(feature = "audio"))]
fn device(wanted: &str, _: &ServeArgs, _: &Scene, _: &mut Recorder) -> Result<(Playing, Follow), Failure> {
    let wanted = if wanted.is_empty() { "--audio".into() } else { format!("--audio {wanted}") };
    Err(Failure::Failed(format!(
        "{wanted}: this `ca` plays by a JACK or a PulseAudio server (`--audio jack`, `--audio pulse`), and is built \
         without other sound devices; `cargo install --path crates/ca-cli --features audio` builds one with them (on \
         Linux with the headers of ALSA: libasound2-dev)"
    )))
}

impl Playing {
    /// From now on it asks.
    pub(super) fn start(&mut self) -> Result<(), Failure> {
        let started = match &mut self.output {
            Output::Jack(output) => output.start().map_err(|e| e.to_string()),
            // it counts time from its first word on
            Output::Pulse(_) => Ok(()),
            #[cfg(feature = "audio")]
            Output::Device(output) => output.start().map_err(|e| e.to_string()),
        };
        started.map_err(|e| Failure::Failed(format!("`{}` does not start: {e}", self.name)))
    }

    /// What plays, for a page.
    pub(super) fn host(&self) -> &'static str {
        self.host
    }

    /// MIDI that it brings, for whoever asks first.
    pub(super) fn events(&mut self) -> Option<EventReader> {
        self.events.take()
    }

    /// What it complains of.
    pub(super) fn turn(&self, recorder: &mut Recorder) {
        for text in self.words.try_iter() {
            recorder.say(true, format!("{}: {text}", self.name));
        }
    }

    /// Lets what the engine left be heard.
    pub(super) fn end(self, rate: f64) {
        let left = 2.0 * self.counts.lead.load(Relaxed) as f64 / rate;
        let end = Instant::now() + LATE + Duration::from_secs_f64(left);
        let is_over = || matches!(&self.output, Output::Pulse(pulse) if pulse.is_over());
        while !self.counts.done.load(Relaxed) && !is_over() && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(1));
        }
        let is_over = is_over();
        match self.output {
            // a server that is gone would be waited for without end
            Output::Jack(output) => {
                if !self.counts.done.load(Relaxed) {
                    output.leave();
                }
            }
            // what it has queued is heard
            Output::Pulse(_) => {
                // from what was given last, which is as long as what is asked for at once
                let last = Duration::from_secs_f64(self.counts.buffer.load(Relaxed) as f64 / rate);
                let queued = Duration::from_nanos(self.counts.delay.load(Relaxed)) + last;
                std::thread::sleep(if is_over { Duration::ZERO } else { queued.min(FAR) });
            }
            #[cfg(feature = "audio")]
            Output::Device(_) => {}
        }
    }
}
