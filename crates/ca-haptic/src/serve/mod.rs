//! A scene played in real time: the engine on its thread, rings to its neighbours, and the recorder that looks after it.
//!
//! ```text
//! devices ⇄ gateway ⇄ rings ⇄ engine thread ─► rings ─► recorder ─► sound file, take, terminal
//!                                   │▲───────── commands ─────┘
//!                                   └──► ring ─► device that plays sound, where there is one
//! ```
//!
//! Decides that the engine thread knows rings only. Who fills them (shared memory, a test) and where records end is the
//! caller's: [`rings`] makes both sides. The recorder is no thread of its own but a turn to be taken every few milliseconds
//! by the caller, so that a program embeds it in the loop it has.

#[cfg(feature = "system")]
mod async_sink;
pub mod audio;
mod clock;
#[cfg(feature = "mcap")]
mod kept;
mod live;
mod loops;
mod recorder;
mod sink;
mod summary;
#[cfg(feature = "mcap")]
mod taken;
#[cfg(feature = "system")]
mod wav_sink;

#[cfg(feature = "system")]
pub use async_sink::{AsyncSink, BufferLimits, SinkHandle};
pub use clock::{Clock, Start};
#[cfg(feature = "mcap")]
pub use kept::Kept;
pub use live::{FrameTiming, Live, RecordIntervals, Rings, Shared};
pub use recorder::{Recorder, Refused};
pub use sink::{Notice, Sink, SinkStreams};
pub use summary::{DeviceSummary, Fault, StatsSnapshot, Summary};
#[cfg(feature = "system")]
pub use wav_sink::WavSink;

use crate::engine::EngineCommand;
use crate::frame::{DeviceFrame, ForceFrame};
use crate::record::Record;
use ca_core::Scene;
use rtrb::{Consumer, Producer, RingBuffer};

/// The gateway's ends of the rings.
pub struct GatewayEnds {
    /// frames of devices, by number
    pub frames: Producer<(u32, DeviceFrame)>,
    /// frames of forces, by number
    pub forces: Consumer<(u32, ForceFrame)>,
}

/// The recorder's ends of the rings.
pub struct RecorderEnds {
    /// what is asked
    pub commands: Producer<(u64, EngineCommand)>,
    /// what happened
    pub records: Consumer<Record>,
    /// sound of gesture frames: first tick, how many samples, and they, interleaved
    pub sound: Consumer<f64>,
    /// how each frame went
    pub timings: Consumer<FrameTiming>,
    /// pictures; none where nobody looks
    pub views: Option<Consumer<f64>>,
}

/// How long the recorder may be away \[s\] before something is lost, and counted.
const AWAY: f64 = 4.0;

/// Commands that wait for the engine at most: it takes all of them in each gesture frame.
const COMMANDS: usize = 1024;

/// Numbers of a picture: displacements and motion, and the head.
fn picture(scene: &Scene) -> usize {
    2 * scene.counts.n_mat + 2
}

/// Rings for a scene with so many devices; `pictures` a second, 0 for none. What plays sound at once comes from
/// `audio::link`, by way of `audio::outlet`.
pub fn rings(scene: &Scene, devices: usize, pictures: u32) -> (Rings, GatewayEnds, RecorderEnds) {
    let rate = scene.rate / f64::from(scene.rates.ratio);
    let frames = (AWAY * rate) as usize;
    // the gateway is never away: a device that sends in bursts, or one that is suspended and comes back
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
