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
mod switch;

use super::inputs::events::EventReader;
use crate::args::ServeArgs;
use crate::outcome::Failure;
use crate::term;
use ca_core::Scene;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::Recorder;
use ca_haptic::serve::audio::{Counts, Follow, Watch};
use ca_lab::gesture::port_maps;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};
pub(super) use switch::Switch;

/// What is in the ring at the end is waited for at most so long, besides the time it takes to play.
const LATE: Duration = Duration::from_millis(200);

/// No server is waited for longer than this, whatever it says of its latency.
const FAR: Duration = Duration::from_secs(1);

/// Something that plays.
struct Playing {
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

/// Something that plays, with the engine's end of it and the recorder's.
type Opened = (Playing, Follow, Watch);

/// Arguments of all outputs. The thread of a PulseAudio stream asks the system for `request`.
#[derive(Clone)]
struct OutputOptions {
    scene: Arc<Scene>,
    buffer: Option<u32>,
    midi: bool,
    request: RtRequest,
}

impl OutputOptions {
    fn new(args: &ServeArgs, scene: &Arc<Scene>, page: bool, request: RtRequest) -> OutputOptions {
        // in a page a controller may be bound to a parameter of any model
        let midi = page || !port_maps(scene).is_empty();
        OutputOptions { scene: scene.clone(), buffer: args.audio_buffer, midi, request }
    }
}

/// Names of servers, and of the default sound device.
const JACK: &str = "jack";
const PULSE: &str = "pulse";
const DEFAULT: &str = "default";

/// Opens the output of `--audio` and gives its name. Without `--audio` and with `plays`, it opens a server that runs; `None` if
/// there is none.
fn open(args: &ServeArgs, wants: &OutputOptions, plays: bool) -> Result<Option<(String, Opened)>, Failure> {
    match args.audio.as_deref() {
        Some(switch::PAGE) if plays => Ok(None),
        Some(switch::PAGE) => Err(Failure::Usage("--audio page: `ca serve` has no page; `ca play` does".into())),
        Some(wanted) => {
            let name = if wanted.is_empty() { DEFAULT } else { wanted };
            Ok(Some((name.into(), opened(name, wants)?)))
        }
        None if plays && wants.scene.channels > 0 && args.clock == crate::args::ClockKind::Monotonic => {
            let server = |name: &str, opened| there(opened).map(|o| (name.to_owned(), o));
            Ok(server(JACK, jack::open(&wants.scene, None, wants.midi))
                .or_else(|| server(PULSE, pulse::open(&wants.scene, None, wants.request))))
        }
        None => Ok(None),
    }
}

/// A server that plays this, if it is there.
fn there(opened: Result<Opened, Failure>) -> Option<Opened> {
    match opened {
        Ok(playing) => return Some(playing),
        Err(Failure::Usage(why)) => term::note(&why),
        // no server: what most machines are
        Err(_) => {}
    }
    None
}

/// Opens an output by name.
fn opened(name: &str, wants: &OutputOptions) -> Result<Opened, Failure> {
    let opened = match name {
        JACK => jack::open(&wants.scene, wants.buffer, wants.midi),
        PULSE => pulse::open(&wants.scene, wants.buffer, wants.request),
        DEFAULT => device("", wants),
        other => device(other, wants),
    };
    opened.map_err(|e| match e {
        Failure::Usage(why) => Failure::Failed(format!("--audio {name}: {why}")),
        other => other,
    })
}

/// Names that can be chosen without a look at the machine.
fn servers(page: bool) -> Vec<String> {
    let page = page.then_some(switch::PAGE);
    let device = cfg!(feature = "audio").then_some(DEFAULT);
    page.into_iter().chain([JACK, PULSE]).chain(device).map(Into::into).collect()
}

/// The same and all sound devices, which a new thread finds; `None` in a build without them.
#[cfg(feature = "audio")]
fn choices(page: bool) -> Option<Receiver<Vec<String>>> {
    let (tell, all) = std::sync::mpsc::channel();
    let look = move || {
        let mut names = servers(page);
        names.extend(device::names());
        let _ = tell.send(names);
    };
    std::thread::Builder::new().name("ca looks for sound".into()).spawn(look).ok().map(|_| all)
}

#[cfg(not(feature = "audio"))]
fn choices(_: bool) -> Option<Receiver<Vec<String>>> {
    None
}

#[cfg(feature = "audio")]
fn device(wanted: &str, wants: &OutputOptions) -> Result<Opened, Failure> {
    device::open(wanted, wants.buffer, &wants.scene)
}

#[cfg(not(feature = "audio"))]
fn device(wanted: &str, _: &OutputOptions) -> Result<Opened, Failure> {
    let wanted = if wanted.is_empty() { "--audio".into() } else { format!("--audio {wanted}") };
    Err(Failure::Failed(format!(
        "{wanted}: this `ca` plays by a JACK or a PulseAudio server (`--audio jack`, `--audio pulse`), and is built \
         without other sound devices; `cargo install --path crates/ca-cli --features audio` builds one with them (on \
         Linux with the headers of ALSA: libasound2-dev)"
    )))
}

impl Playing {
    /// True where nothing will be asked for any more, as far as it says itself.
    fn is_over(&self) -> bool {
        matches!(&self.output, Output::Pulse(pulse) if pulse.is_over())
    }

    /// Closes it; a server that is `lost` would be waited for without end.
    fn close(self, lost: bool) {
        match self.output {
            Output::Jack(output) if lost => output.leave(),
            other => drop(other),
        }
    }

    /// From now on it asks.
    fn start(&mut self) -> Result<(), Failure> {
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
    fn host(&self) -> &'static str {
        self.host
    }

    /// MIDI that it brings, for whoever asks first.
    fn events(&mut self) -> Option<EventReader> {
        self.events.take()
    }

    /// What it complains of.
    fn turn(&self, recorder: &mut Recorder) {
        for text in self.words.try_iter() {
            recorder.say(true, format!("{}: {text}", self.name));
        }
    }

    /// Lets what the engine left be heard.
    fn end(self, rate: f64) {
        let left = 2.0 * self.counts.lead.load(Relaxed) as f64 / rate;
        let end = Instant::now() + LATE + Duration::from_secs_f64(left);
        while !self.counts.done.load(Relaxed) && !self.is_over() && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(1));
        }
        let is_over = self.is_over();
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
