//! What a page sees and hears of a performance.
//!
//! Decides that nothing is drawn or sent where nobody looks or listens, and that sound goes in blocks of 5 ms: a message a
//! gesture frame would cost the page more than it plays.

use super::energy::KineticEnergy;
use ca_core::Scene;
use ca_haptic::serve::{Notice, Sink, SinkStreams, StatsSnapshot};
use ca_haptic::version::Version;
use ca_io::FileError;
use ca_play::Feed;
use ca_session::protocol::{Message, binary};
use ca_view::Drawing;
use std::sync::{Arc, Mutex, PoisonError};

/// Samples of a block, for each channel.
const BLOCK: usize = 256;

/// Pictures for each word on energy.
const ENERGIES: u64 = 3;

/// The last statistics of the engine, as the page shows them.
#[derive(Clone, Default)]
pub(crate) struct Stats(Arc<Mutex<Option<StatsSnapshot>>>);

impl Stats {
    pub(super) fn get(&self) -> Option<StatsSnapshot> {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A drawing, and of which version of the scene.
type Drawn = (u32, Arc<Drawing>);

/// The drawing of a version of the scene that is on its way, from the desk to the sink.
#[derive(Clone, Default)]
pub(crate) struct Coming(Arc<Mutex<Option<Drawn>>>);

impl Coming {
    pub(super) fn put(&self, generation: u32, drawing: Arc<Drawing>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some((generation, drawing));
    }
}

/// Feeds a page.
pub(crate) struct PageSink {
    feed: Feed,
    drawing: Arc<Drawing>,
    channels: usize,
    stats: Stats,
    /// the drawing of the version that comes next
    coming: Coming,
    /// which version is drawn, and since when
    generation: u32,
    since: u64,
    /// tick of the first sample of `samples`
    tick: u64,
    samples: Vec<f64>,
    message: Vec<u8>,
    energy: KineticEnergy,
    /// time of a sample \[s\]
    sample: f64,
    pictures: u64,
}

impl PageSink {
    pub(super) fn new(feed: Feed, drawing: Arc<Drawing>, scene: &Scene) -> PageSink {
        PageSink {
            feed,
            drawing,
            channels: scene.channels,
            energy: KineticEnergy::new(scene),
            sample: scene.sample_dt,
            pictures: 0,
            stats: Stats::default(),
            coming: Coming::default(),
            generation: 1,
            since: 0,
            tick: 0,
            samples: Vec::new(),
            message: Vec::new(),
        }
    }

    pub(super) fn coming(&self) -> Coming {
        self.coming.clone()
    }

    pub(super) fn stats(&self) -> Stats {
        self.stats.clone()
    }
}

impl Sink for PageSink {
    fn streams(&self) -> SinkStreams {
        SinkStreams { sound: true, views: true, stats: true, ..SinkStreams::WORDS }
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        if !self.feed.is_heard() {
            self.samples.clear();
            return Ok(());
        }
        let next = self.tick + (self.samples.len() / self.channels.max(1)) as u64;
        if self.samples.is_empty() || tick != next {
            // what is missing is missing: the page sees it by the tick
            self.samples.clear();
            self.tick = tick;
        }
        self.samples.extend_from_slice(frames);
        if self.samples.len() >= BLOCK * self.channels {
            binary::sound(&mut self.message, self.channels as u32, self.tick as f64, &self.samples);
            self.feed.sound(&self.message);
            self.samples.clear();
        }
        Ok(())
    }

    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        // pictures of the version before are none of this one
        if self.feed.is_seen() && tick >= self.since {
            binary::view(&mut self.message, self.generation, tick as f64);
            self.drawing.view(x, &mut self.message);
            self.feed.view(&self.message);
        }
        Ok(())
    }

    fn motion(&mut self, tick: u64, d: &[f64]) -> Result<(), FileError> {
        if self.feed.is_seen() && tick >= self.since {
            self.pictures += 1;
            if self.pictures.is_multiple_of(ENERGIES) {
                let seconds = tick as f64 * self.sample;
                let joules = self.energy.of(d);
                self.feed.tell_all(&Message::Energy { seconds, motion: joules });
            }
        }
        Ok(())
    }

    fn swapped(&mut self, tick: u64, version: &Arc<Version>) -> Result<(), FileError> {
        self.energy = KineticEnergy::new(&version.scene);
        let coming = self.coming.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some((generation, drawing)) = coming {
            (self.generation, self.drawing, self.since) = (generation, drawing, tick);
        }
        Ok(())
    }

    fn snapshot(&mut self, snapshot: &StatsSnapshot) -> Result<(), FileError> {
        *self.stats.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(*snapshot);
        Ok(())
    }

    fn said(&mut self, notice: &Notice) -> Result<(), FileError> {
        self.feed.tell_all(&Message::Said { bad: notice.bad, text: notice.text.clone() });
        Ok(())
    }
}
