//! Plays a scene in real time: the engine on its thread, rings to other threads, and the recorder.
//!
//! ```text
//! devices ⇄ gateway ⇄ rings ⇄ engine thread ─► rings ─► recorder ─► sound file, take, terminal
//!                                   │▲───────── commands ─────┘
//!                                   └──► ring ─► device that plays sound, where there is one
//! ```
//!
//! The engine thread uses only rings. [`rings`] makes both sides, and the caller connects the other side to shared
//! memory or to a test. The caller also polls the recorder every few milliseconds, so that a program can embed it in
//! its loop.

#[cfg(feature = "system")]
mod async_sink;
pub mod audio;
mod clock;
mod live;
mod loop_latency;
mod recorder;
mod sink;
mod summary;
#[cfg(feature = "mcap")]
mod take_sink;
#[cfg(feature = "mcap")]
mod temporary_take;
#[cfg(feature = "system")]
mod wav_sink;

#[cfg(feature = "system")]
pub use async_sink::{AsyncSink, BufferLimits, SinkHandle};
pub use clock::{Clock, Start};
pub use live::{FrameTiming, Live, RecordIntervals, Rings, Shared};
pub use recorder::{Recorder, Refused};
pub use sink::{Notice, Sink, SinkStreams};
pub use summary::{DeviceSummary, Fault, StatsSnapshot, Summary};
#[cfg(feature = "mcap")]
pub use temporary_take::TemporaryTake;
#[cfg(feature = "system")]
pub use wav_sink::WavSink;

use crate::engine::EngineCommand;
use crate::frame::{DeviceFrame, ForceFrame};
use crate::record::Record;
use ca_core::Scene;
use rtrb::{Consumer, Producer, RingBuffer};

/// The gateway's side of the rings.
pub struct GatewayEnds {
    /// Device frames, with the number of the device.
    pub frames: Producer<(u32, DeviceFrame)>,
    /// Force frames, with the number of the device.
    pub forces: Consumer<(u32, ForceFrame)>,
}

/// The recorder's side of the rings.
pub struct RecorderEnds {
    /// Commands, each with the number of disarm requests before it.
    pub commands: Producer<(u64, EngineCommand)>,
    /// Records.
    pub records: Consumer<Record>,
    /// Sound of each gesture frame: first tick, number of samples, interleaved samples.
    pub sound: Consumer<f64>,
    /// Timing of each gesture frame.
    pub timings: Consumer<FrameTiming>,
    /// Pictures; `None` without a viewer.
    pub views: Option<Consumer<f64>>,
}

/// Longest interval between two polls of the recorder without loss \[s\].
const AWAY: f64 = 4.0;

/// Maximum number of waiting commands; the engine takes all of them in each gesture frame.
const COMMANDS: usize = 1024;

/// Returns the length of a picture: displacements, motion and a head of two numbers.
fn picture(scene: &Scene) -> usize {
    2 * scene.counts.n_mat + 2
}

/// Makes the rings for a scene with this number of devices and of `pictures` per second (0 for none). For a sound
/// device, `audio::link` and `audio::outlet` make them.
pub fn rings(scene: &Scene, devices: usize, pictures: u32) -> (Rings, GatewayEnds, RecorderEnds) {
    let rate = scene.rate / f64::from(scene.rates.ratio);
    let frames = (AWAY * rate) as usize;
    // the gateway always runs, but a device may send in bursts, e.g. after it was suspended
    let (frames_in, frames_out) = RingBuffer::new(64 * devices.max(1));
    let (forces_in, forces_out) = RingBuffer::new(64 * devices.max(1));
    let (acts_in, acts_out) = RingBuffer::new(COMMANDS);
    let (records_in, records_out) = RingBuffer::new(frames * (2 * devices + 1) + 256);
    let (sound_in, sound_out) = RingBuffer::new((AWAY * scene.rate) as usize * scene.counts.channels + 2 * frames);
    let (beats_in, beats_out) = RingBuffer::new(frames);
    let (views_in, views_out) = if pictures > 0 {
        let places = picture(scene);
        let (a, b) = RingBuffer::new(places * (AWAY * f64::from(pictures)).max(2.0) as usize);
        (Some(a), Some(b))
    } else {
        (None, None)
    };
    (
        Rings {
            frames: frames_out,
            forces: forces_in,
            commands: acts_out,
            records: records_in,
            sound: sound_in,
            timings: beats_in,
            views: views_in,
            #[cfg(feature = "system")]
            audio: None,
        },
        GatewayEnds { frames: frames_in, forces: forces_out },
        RecorderEnds {
            commands: acts_in,
            records: records_out,
            sound: sound_out,
            timings: beats_out,
            views: views_out,
        },
    )
}
