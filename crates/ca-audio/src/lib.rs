//! Sound output of a scene in real time: a JACK server (`jack`), a PulseAudio server (`pulse`), or a sound device of
//! the system (`device`, feature `devices`).
//!
//! Neither server is needed at build time: libjack is loaded at run time, and PulseAudio is reached through its socket.
//! The same program runs on a machine without them. The clock of the engine follows the output
//! ([`ca_haptic::serve::audio`]). A scene is never resampled. [`Switch`] changes the output while the model plays.

#[cfg(feature = "devices")]
mod device;
mod jack;
mod midi_events;
mod pulse;
mod switch;

use ca_core::Scene;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::audio::{Counts, DeviceClock, Watch};
pub use midi_events::EventReader;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};
pub use switch::{OnChange, PAGE, Switch, SwitchOptions};

/// Name of the JACK server.
pub const JACK: &str = "jack";
/// Name of the PulseAudio server.
pub const PULSE: &str = "pulse";
/// Name of the default sound device.
pub const DEFAULT: &str = "default";

/// Longest wait at the end for the ring of the engine, besides its playing time.
const LATE: Duration = Duration::from_millis(200);
/// Longest wait for a server.
const FAR: Duration = Duration::from_secs(1);

/// Reason why an output cannot be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AudioError {
    /// It cannot play the scene as it is: another rate, too few channels.
    Unfit(String),
    /// It is absent or does not work.
    Failed(String),
}

impl fmt::Display for AudioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (AudioError::Unfit(why) | AudioError::Failed(why)) = self;
        f.write_str(why)
    }
}

impl std::error::Error for AudioError {}

/// Request for an output.
#[derive(Clone)]
pub struct AudioRequest {
    /// Scene, for the rate \[Hz\] and the channels.
    pub scene: Arc<Scene>,
    /// Frames per call; the output chooses if `None`.
    pub buffer: Option<u32>,
    /// Also opens a MIDI port, if the output has one.
    pub midi: bool,
    /// Priority of the thread of a PulseAudio stream.
    pub thread: RtRequest,
}

/// An open output.
pub struct OpenOutput {
    output: Output,
    counts: Arc<Counts>,
    words: Receiver<String>,
    name: String,
    host: &'static str,
    events: Option<EventReader>,
}

enum Output {
    Jack(Box<jack::Output>),
    Pulse(pulse::PulseStream),
    #[cfg(feature = "devices")]
    Device(device::Output),
}

/// An open output, with the ends for the engine and the recorder.
pub type Opened = (OpenOutput, DeviceClock, Watch);

/// Opens an output by name: [`JACK`], [`PULSE`], [`DEFAULT`], or a device of [`names`].
///
/// # Errors
/// If it is absent, or cannot play the scene as it is.
pub fn open(name: &str, wants: &AudioRequest) -> Result<Opened, AudioError> {
    match name {
        JACK => jack::open(&wants.scene, wants.buffer, wants.midi),
        PULSE => pulse::open(&wants.scene, wants.buffer, wants.thread),
        DEFAULT => device("", wants),
        other => device(other, wants),
    }
}

/// Opens the first running server, and returns its name too. `unfit` receives the reasons of running servers that
/// cannot play the scene.
pub fn first(wants: &AudioRequest, mut unfit: impl FnMut(String)) -> Option<(&'static str, Opened)> {
    [JACK, PULSE].into_iter().find_map(|name| match open(name, wants) {
        Ok(opened) => Some((name, opened)),
        Err(AudioError::Unfit(why)) => {
            unfit(why);
            None
        }
        Err(AudioError::Failed(_)) => None,
    })
}

/// Returns the outputs known without searching for devices.
pub fn servers() -> impl Iterator<Item = &'static str> {
    [JACK, PULSE].into_iter().chain(cfg!(feature = "devices").then_some(DEFAULT))
}

/// Returns the names of all outputs, which may take seconds; in a build without devices only [`servers`].
pub fn names() -> Vec<String> {
    #[cfg(feature = "devices")]
    let devices = device::names();
    #[cfg(not(feature = "devices"))]
    let devices = Vec::new();
    servers().map(Into::into).chain(devices).collect()
}

#[cfg(feature = "devices")]
fn device(wanted: &str, wants: &AudioRequest) -> Result<Opened, AudioError> {
    device::open(wanted, wants.buffer, &wants.scene)
}

#[cfg(not(feature = "devices"))]
fn device(_: &str, _: &AudioRequest) -> Result<Opened, AudioError> {
    Err(AudioError::Failed(
        "this build of `ca` plays only through a JACK or PulseAudio server (`--audio jack`, `--audio pulse`); for \
         other sound devices, build it with `cargo install --path crates/ca-cli --features audio` (on Linux this needs \
         the ALSA headers: libasound2-dev)"
            .into(),
    ))
}

impl OpenOutput {
    /// Returns true if the output reports that it will request nothing more.
    pub fn is_over(&self) -> bool {
        matches!(&self.output, Output::Pulse(pulse) if pulse.is_over())
    }

    /// Closes the output, without a reply from a `lost` server.
    pub fn close(self, lost: bool) {
        match self.output {
            Output::Jack(output) if lost => output.leave(),
            other => drop(other),
        }
    }

    /// Starts the output.
    ///
    /// # Errors
    /// If it does not start.
    pub fn start(&mut self) -> Result<(), AudioError> {
        let started = match &mut self.output {
            Output::Jack(output) => output.start().map_err(|e| e.to_string()),
            // a PulseAudio stream starts when it is opened
            Output::Pulse(_) => Ok(()),
            #[cfg(feature = "devices")]
            Output::Device(output) => output.start().map_err(|e| e.to_string()),
        };
        started.map_err(|e| AudioError::Failed(format!("cannot start `{}`: {e}", self.name)))
    }

    /// Returns the counters of requested and delivered samples.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Returns the name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the type of server or device.
    pub fn host(&self) -> &'static str {
        self.host
    }

    /// Returns the MIDI port, once.
    pub fn events(&mut self) -> Option<EventReader> {
        self.events.take()
    }

    /// Returns its error messages since the last call.
    pub fn complaints(&self) -> impl Iterator<Item = String> {
        self.words.try_iter()
    }

    /// Plays the samples left in the ring of the engine, at `rate` \[Hz\], and closes the output.
    pub fn end(self, rate: f64) {
        let left = 2.0 * self.counts.lead.load(Relaxed) as f64 / rate;
        let end = Instant::now() + LATE + Duration::from_secs_f64(left);
        while !self.counts.done.load(Relaxed) && !self.is_over() && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(1));
        }
        let is_over = self.is_over();
        match self.output {
            // closing a client of a dead server would never return
            Output::Jack(output) => {
                if !self.counts.done.load(Relaxed) {
                    output.leave();
                }
            }
            // plays the samples queued in the server
            Output::Pulse(_) => {
                // counted from the last message, which is as long as one request
                let last = Duration::from_secs_f64(self.counts.buffer.load(Relaxed) as f64 / rate);
                let queued = Duration::from_nanos(self.counts.delay.load(Relaxed)) + last;
                std::thread::sleep(if is_over { Duration::ZERO } else { queued.min(FAR) });
            }
            #[cfg(feature = "devices")]
            Output::Device(_) => {}
        }
    }
}
