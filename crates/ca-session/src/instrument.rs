//! A session with its engine, for programs without threads.
//!
//! `ca play` runs the engine on a real-time thread and everything else beside it. Here the caller requests gesture
//! frames, and all parts run one after the other. Time is the time of the model.

use crate::greeting::greeting;
use crate::midi::Midi;
use crate::pages::Pages;
use crate::picture::PageSink;
use crate::protocol::NumberedRequest;
use crate::session::{Parts, Session};
use ca_core::Scene;
use ca_haptic::engine::{Engine, Options};
use ca_haptic::serve::{Clock, Live, RecordIntervals, Recorder, Shared, Sink, rings};
use ca_view::Drawing;
use std::sync::Arc;
use std::time::Duration;

/// Pictures a second.
const PICTURES: u32 = 60;
/// Largest number of gesture frames between two calls of the recorder.
const TURN: u64 = 32;

/// An instrument without devices.
pub struct Instrument {
    live: Live,
    shared: Arc<Shared>,
    recorder: Recorder,
    session: Session,
    midi: Midi,
    /// Gesture frames so far, and the length of one \[s\].
    frames: u64,
    period: f64,
}

impl Instrument {
    /// Makes an instrument at rest, greets open pages, and sends pictures and sound to `pages`, and everything to
    /// `sinks`.
    pub fn new(scene: &Arc<Scene>, parts: Parts, pages: Box<dyn Pages>, sinks: Vec<Box<dyn Sink>>) -> Instrument {
        let drawing = Arc::new(Drawing::new(scene));
        let stability = parts.language.stability(scene);
        parts.pages.greet(&greeting(scene, &drawing, &parts.name, 1, stability));
        let sink = PageSink::new(pages, drawing.clone(), scene);
        let session = Session::new(parts, scene.clone(), drawing, &sink);
        let shared = Arc::new(Shared::default());
        let engine = Engine::new(scene.clone(), Vec::new(), Options::default());
        let (ends, _, recorder) = rings(scene, 0, PICTURES);
        let sinks = [Box::new(sink) as Box<dyn Sink>].into_iter().chain(sinks).collect();
        let recorder = Recorder::new(recorder, shared.clone(), scene.clone(), &engine.ports, sinks);
        let rate = scene.rate / f64::from(scene.rates.ratio);
        let view = (rate / f64::from(PICTURES)).max(1.0) as u64;
        let every = RecordIntervals { view, ..RecordIntervals::default() };
        let live = Live::new(engine, ends, shared.clone(), Clock::Monotonic, every);
        Instrument { live, shared, recorder, session, midi: Midi::new(scene), frames: 0, period: rate.recip() }
    }

    /// Returns the time of the model.
    pub fn now(&self) -> Duration {
        Duration::from_secs_f64(self.frames as f64 * self.period)
    }

    /// Plays this number of gesture frames.
    pub fn play(&mut self, frames: u64) {
        let mut left = frames;
        while left > 0 {
            let some = left.min(TURN);
            (0..some).for_each(|_| self.live.step());
            left -= some;
            self.frames += some;
            self.recorder.poll();
            let now = self.now();
            self.session.poll(&mut self.recorder, &mut self.midi, Some(&[]));
            if !self.recorder.is_swapping() {
                self.midi.poll(&mut self.recorder, now);
            }
            self.session.send_state(&mut self.recorder, &self.midi, &self.shared, now);
        }
    }

    /// Answers a request of a page. Returns true if it ends the program.
    pub fn request(&mut self, page: u64, asked: NumberedRequest) -> bool {
        let now = self.now();
        self.session.request(&mut self.recorder, &mut self.midi, (page, asked), now)
    }

    /// Ends what a closed page held.
    pub fn left(&mut self, page: u64) {
        self.session.left(&mut self.recorder, page);
    }
}
