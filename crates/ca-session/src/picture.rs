//! Pictures, sound and news for the pages.
//!
//! Without a page nothing is drawn or sent. Sound is sent in blocks of 5 ms, because a message for each gesture frame
//! would cost the page more than playing the sound.

use crate::energy::KineticEnergy;
use crate::pages::Pages;
use crate::protocol::{Message, binary};
use ca_core::Scene;
use ca_haptic::serve::{Notice, Sink, SinkStreams, StatsSnapshot};
use ca_haptic::version::Version;
use ca_io::FileError;
use ca_view::Drawing;
use std::sync::{Arc, Mutex, PoisonError};

/// Samples per block and channel.
const BLOCK: usize = 256;

/// Pictures per message `energy`.
const ENERGIES: u64 = 3;

/// Last statistics of the engine.
#[derive(Clone, Default)]
pub(crate) struct Stats(Arc<Mutex<Option<StatsSnapshot>>>);

impl Stats {
    pub(crate) fn get(&self) -> Option<StatsSnapshot> {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A drawing with the version of the scene that it shows.
type Drawn = (u32, Arc<Drawing>);

/// Passes the drawing of the next version of the scene from the session to the sink.
#[derive(Clone, Default)]
pub(crate) struct NextDrawing(Arc<Mutex<Option<Drawn>>>);

impl NextDrawing {
    pub(crate) fn put(&self, generation: u32, drawing: Arc<Drawing>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some((generation, drawing));
    }
}

/// Sends pictures, sound and news to the pages.
pub struct PageSink {
    pages: Box<dyn Pages>,
    drawing: Arc<Drawing>,
    channels: usize,
    stats: Stats,
    /// Drawing of the next version.
    next_drawing: NextDrawing,
    /// Version that is drawn, and its first tick.
    generation: u32,
    since: u64,
    /// Tick of the first sample of `samples`.
    tick: u64,
    samples: Vec<f64>,
    message: Vec<u8>,
    energy: KineticEnergy,
    /// Time per sample \[s\].
    sample: f64,
    pictures: u64,
}

impl PageSink {
    /// Makes a sink for `pages`, which shows `scene` in `drawing`.
    pub fn new(pages: Box<dyn Pages>, drawing: Arc<Drawing>, scene: &Scene) -> PageSink {
        PageSink {
            pages,
            drawing,
            channels: scene.counts.channels,
            energy: KineticEnergy::new(scene),
            sample: scene.rates.sample_dt,
            pictures: 0,
            stats: Stats::default(),
            next_drawing: NextDrawing::default(),
            generation: 1,
            since: 0,
            tick: 0,
            samples: Vec::new(),
            message: Vec::new(),
        }
    }

    pub(crate) fn next_drawing(&self) -> NextDrawing {
        self.next_drawing.clone()
    }

    pub(crate) fn stats(&self) -> Stats {
        self.stats.clone()
    }
}

impl Sink for PageSink {
    fn streams(&self) -> SinkStreams {
        SinkStreams { sound: true, views: true, stats: true, ..SinkStreams::MESSAGES }
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        if !self.pages.is_heard() {
            self.samples.clear();
            return Ok(());
        }
        let next = self.tick + (self.samples.len() / self.channels.max(1)) as u64;
        if self.samples.is_empty() || tick != next {
            // the page recognises a gap by the tick
            self.samples.clear();
            self.tick = tick;
        }
        self.samples.extend_from_slice(frames);
        if self.samples.len() >= BLOCK * self.channels {
            binary::sound(&mut self.message, self.channels as u32, self.tick as f64, &self.samples);
            self.pages.sound(&self.message);
            self.samples.clear();
        }
        Ok(())
    }

    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        // skips pictures of the previous version
        if self.pages.is_seen() && tick >= self.since {
            binary::view(&mut self.message, self.generation, tick as f64);
            self.drawing.view(x, &mut self.message);
            self.pages.view(&self.message);
        }
        Ok(())
    }

    fn motion(&mut self, tick: u64, d: &[f64]) -> Result<(), FileError> {
        if self.pages.is_seen() && tick >= self.since {
            self.pictures += 1;
            if self.pictures.is_multiple_of(ENERGIES) {
                let seconds = tick as f64 * self.sample;
                let joules = self.energy.of(d);
                self.pages.send_all(&Message::Energy { seconds, motion: joules });
            }
        }
        Ok(())
    }

    fn swapped(&mut self, tick: u64, version: &Arc<Version>) -> Result<(), FileError> {
        self.energy = KineticEnergy::new(&version.scene);
        let next_drawing = self.next_drawing.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some((generation, drawing)) = next_drawing {
            (self.generation, self.drawing, self.since) = (generation, drawing, tick);
        }
        Ok(())
    }

    fn snapshot(&mut self, snapshot: &StatsSnapshot) -> Result<(), FileError> {
        *self.stats.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(*snapshot);
        Ok(())
    }

    fn notice(&mut self, notice: &Notice) -> Result<(), FileError> {
        self.pages.send_all(&Message::Said { bad: notice.bad, text: notice.text.clone() });
        Ok(())
    }
}
