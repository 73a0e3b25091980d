//! Replays a take and finds the first difference.
//!
//! The records alone drive the engine, in their order. Before a frame or an action of tick n the engine runs until n is
//! due. Every force frame, stretch of sound and hash in the file is compared with the engine's, byte for byte, so that
//! its output is checked, not only its input. A hole in the take ends the comparison, because what follows may depend
//! on the missing records.
//!
//! A take of another arithmetic ([`Header::is_exact`](super::Header::is_exact)) is compared to a tolerance: forces and
//! sound may differ by [`TOLERANCE`] of their peak, and hashes are not compared. Such a replay runs to the end, because
//! only then is the peak known.

mod verdict;

use super::header::Header;
use super::next_version::NextModel;
use super::read::{Event, Take};
use super::source::End;
use crate::engine::{Change, Engine, EngineCommand, Refit, Retired, Setup, Swap};
use crate::frame::{DeviceFrame, ForceFrame};
use crate::version;
use ca_core::Catalog;
use ca_core::internal::state::shape;
use ca_io::error::FileError;
use std::collections::VecDeque;
use std::sync::Arc;
use verdict::{Deviation, which};
pub use verdict::{Difference, ReplayVerdict};
use zerocopy::IntoBytes;

/// Largest number of force frames stored for comparison, per device.
const MADE: usize = 65_536;

/// Largest difference with another arithmetic, as a part of the peak; forces may differ by rounding to 32 bits besides.
pub const TOLERANCE: f64 = 1e-9;

/// A replay under way.
pub struct Replay {
    /// The engine; its scene changes with each version of the model in the take.
    pub engine: Engine,
    header: Header,
    catalog: Catalog,
    /// Setups of the header, with profiles that devices reported later.
    setups: Vec<Setup>,
    rate: f64,
    channels: usize,
    /// Result so far.
    pub verdict: ReplayVerdict,
    /// Force frames not compared yet, of each device.
    made: Vec<VecDeque<ForceFrame>>,
    /// Sound not compared yet, and the tick of its first sample.
    sound: VecDeque<f64>,
    sound_tick: u64,
    /// False once a minute of sound is waiting: the take holds none.
    heard: bool,
    /// Differences of forces and sound, if the comparison is to a tolerance.
    deviations: Option<[Deviation; 2]>,
}

impl Replay {
    /// Builds the engine of a take, at rest.
    ///
    /// # Errors
    /// As [`Header::engine`](super::Header::engine).
    pub fn new(take: &Take, catalog: &Catalog) -> Result<Replay, FileError> {
        let engine = take.header.engine(catalog).map_err(|e| e.file(take.path.display()))?;
        let deviations = if take.header.is_exact(&engine.scene) { None } else { Some(Default::default()) };
        let tolerance = if deviations.is_some() { TOLERANCE } else { 0.0 };
        Ok(Replay {
            header: take.header.clone(),
            catalog: catalog.clone(),
            deviations,
            setups: take.header.setups.clone(),
            rate: engine.scene.rate,
            channels: engine.scene.counts.channels,
            verdict: ReplayVerdict { tolerance, versions: 1, ..ReplayVerdict::default() },
            made: engine.ports.iter().map(|_| VecDeque::new()).collect(),
            sound: VecDeque::new(),
            sound_tick: 0,
            heard: true,
            engine,
        })
    }

    /// Replays the whole of `take`; the engine stays as it ended.
    ///
    /// `each` is called in every gesture frame before the masses of its last tick move, then `sound` with its sound.
    ///
    /// # Errors
    /// If the take cannot be read, a version of its model cannot be played, or `sound` fails.
    pub fn run(
        &mut self,
        take: &Take,
        each: &mut dyn FnMut(&Engine),
        sound: &mut dyn FnMut(&[f64]) -> Result<(), FileError>,
    ) -> Result<ReplayVerdict, FileError> {
        let mut events = take.events()?;
        for event in events.by_ref() {
            self.step(event?, each, sound)?;
            if self.verdict.difference.is_some() || self.verdict.hole.is_some() {
                break;
            }
        }
        self.verdict.seconds = self.engine.due() as f64 / self.rate;
        let beyond = self.deviations.take().and_then(|[forces, sound]| {
            forces.beyond(TOLERANCE + f64::from(f32::EPSILON)).or_else(|| sound.beyond(TOLERANCE))
        });
        self.verdict.difference = self.verdict.difference.take().or(beyond);
        self.verdict.cut = events.end().and_then(End::early).map(|(why, _)| why.to_owned());
        if let Some(End::Damaged(..)) = events.end() {
            // unlike a truncated file, a damaged one held more records
            self.verdict.damaged = true;
            self.verdict.hole.get_or_insert(self.verdict.seconds);
        }
        Ok(std::mem::take(&mut self.verdict))
    }

    fn step(
        &mut self,
        event: Event,
        each: &mut dyn FnMut(&Engine),
        sound: &mut dyn FnMut(&[f64]) -> Result<(), FileError>,
    ) -> Result<(), FileError> {
        // tick until which the engine must have run before this event
        let due = match &event {
            Event::Device(_, f) => f.tick,
            Event::Change(tick, _)
            | Event::Order(tick, ..)
            | Event::Hand(tick, _)
            | Event::Model(tick, _)
            | Event::Profile(tick, ..) => *tick,
            Event::Reload(r) => r.tick,
            Event::Hash(h) => h.tick,
            Event::Force(_, f) => f.tick + 1,
            Event::Sound(tick, samples) => tick + (samples.len() / self.channels.max(1)) as u64,
            Event::Energy(_) | Event::Rt(_) | Event::Lost(_) | Event::View => 0,
        };
        while self.engine.due() < due {
            self.frame(each, sound)?;
        }
        let now = self.engine.due();
        let late = |what: &str, tick: u64| (what.to_owned(), format!("at tick {tick}"), format!("due at {now}"));
        let odd = match event {
            Event::Device(_, f) if f.tick != now => Some(late("a device frame at a wrong tick", f.tick)),
            Event::Change(tick, _)
            | Event::Order(tick, ..)
            | Event::Hand(tick, _)
            | Event::Model(tick, _)
            | Event::Profile(tick, ..)
                if tick != now =>
            {
                Some(late("a command at a wrong tick", tick))
            }
            Event::Reload(r) if r.tick != now => Some(late("a reload at a wrong tick", r.tick)),
            Event::Hash(h) if h.tick != now => Some(late("a hash at a wrong tick", h.tick)),
            Event::Device(k, frame) => {
                self.device(k, &frame);
                None
            }
            Event::Change(_, change) => {
                self.change(change);
                None
            }
            Event::Order(_, port, order) => {
                self.engine.command(EngineCommand::Order(port, order));
                None
            }
            Event::Hand(_, event) => {
                // an action that this scene lacks shows in later frames and hashes
                if let Some(input) = event.to_input(&self.engine.scene) {
                    self.engine.command(EngineCommand::Manual(input));
                }
                None
            }
            Event::Model(_, next) => {
                self.swap(&next)?;
                None
            }
            Event::Profile(_, k, profile) => {
                if let Some(setup) = self.setups.get_mut(k) {
                    setup.profile = *profile;
                    let refit = Refit::new(&self.engine.scene, k as u32, setup.clone());
                    self.engine.command(EngineCommand::Refit(Box::new(refit)));
                }
                None
            }
            Event::Reload(r) => {
                let mine = shape(&self.engine.state).map(|n| n as u32);
                if mine == [r.places, r.coefs] {
                    let fresh = Box::new(self.engine.scene.state());
                    match self.engine.command(EngineCommand::Reload(fresh)) {
                        Some(Retired::State(old)) if self.deviations.is_none() && old.bits() != r.bits => {
                            let bits = |b: u64| format!("{b:016x}");
                            Some(("the state before a reload".into(), bits(r.bits), bits(old.bits())))
                        }
                        _ => None,
                    }
                } else {
                    // refused when it was recorded, too
                    None
                }
            }
            // meaningless for another arithmetic
            Event::Hash(_) if self.deviations.is_some() => None,
            Event::Hash(h) => {
                self.verdict.hashes += 1;
                let bits = self.engine.state.bits();
                let hex = |b: u64| format!("{b:016x}");
                (bits != h.bits).then(|| ("the hash of the state".into(), hex(h.bits), hex(bits)))
            }
            Event::Force(k, was) => self.force(k, &was),
            Event::Sound(tick, samples) => {
                self.compare(tick, &samples);
                None
            }
            Event::Lost(l) => {
                if l.records > 0 {
                    self.verdict.hole = Some(l.tick as f64 / self.rate);
                }
                None
            }
            Event::Energy(_) | Event::Rt(_) | Event::View => None,
        };
        if let Some((what, was, is)) = odd {
            self.differs(now, what, was, is);
        }
        Ok(())
    }

    fn frame(
        &mut self,
        each: &mut dyn FnMut(&Engine),
        sound: &mut dyn FnMut(&[f64]) -> Result<(), FileError>,
    ) -> Result<(), FileError> {
        for (made, f) in self.made.iter_mut().zip(self.engine.answer()) {
            // limits memory for a take without force topics
            if made.len() == MADE {
                made.pop_front();
            }
            made.push_back(*f);
        }
        each(&self.engine);
        let heard = self.engine.finish();
        if self.heard {
            self.sound.extend(heard);
        }
        sound(heard)?;
        self.verdict.frames += 1;
        // limits memory for a take without sound
        if self.sound.len() > 60 * self.rate as usize * self.channels.max(1) {
            self.heard = false;
            self.sound = VecDeque::new();
        }
        Ok(())
    }

    fn device(&mut self, k: usize, frame: &DeviceFrame) {
        let mut frame = *frame;
        frame.tick = 0;
        self.engine.take(k, &mut frame);
        self.verdict.taken += 1;
    }

    fn swap(&mut self, next: &NextModel) -> Result<(), FileError> {
        let header = self.header.version(next);
        let scene = Arc::new(header.scene(&self.catalog)?.scene);
        if self.deviations.is_none() && !header.is_exact(&scene) {
            (self.deviations, self.verdict.tolerance) = (Some(Default::default()), TOLERANCE);
        }
        let (state, _) = version::begin(&scene, &next.moved);
        let swap = Swap::new(&self.engine.scene, scene, state, &self.setups, (self.verdict.versions, next.restart));
        self.verdict.versions += 1;
        let swap =
            swap.map_err(|why| FileError::content(format!("the take loads another version of its model: {why}")))?;
        self.engine.command(EngineCommand::Swap(Box::new(swap)));
        Ok(())
    }

    fn change(&mut self, mut change: Change) {
        // a take does not name scenes: the patch is for the present one
        change.patches.iter_mut().for_each(|p| p.scene = self.engine.scene.identity());
        self.engine.command(EngineCommand::Set(Box::new(change)));
    }

    fn force(&mut self, k: usize, was: &ForceFrame) -> Option<(String, String, String)> {
        self.verdict.forces += 1;
        let name = self.engine.ports.get(k)?.name.clone();
        let made = self.made.get_mut(k)?;
        while made.front().is_some_and(|f| f.tick < was.tick) {
            made.pop_front();
        }
        let Some(is) = made.pop_front() else {
            let what = format!("a force frame of `{name}`");
            return Some((what, format!("number {}", was.seq), "none".into()));
        };
        // the frame was published later, at a time that the engine does not know
        let mut is = ForceFrame { t_host_ns: was.t_host_ns, ..is };
        if let Some([forces, _]) = &mut self.deviations {
            for (k, (was_n, is_n)) in was.force.iter().zip(&is.force).enumerate() {
                forces.see(f64::from(*was_n), f64::from(*is_n), || Difference {
                    tick: was.tick,
                    time: was.tick as f64 / self.rate,
                    what: format!("the force at degree of freedom {k} in force frame {} of `{name}`", was.seq),
                    was: format!("{was_n:e} N"),
                    is: format!("{is_n:e} N"),
                });
            }
            // these follow from the forces and round as they do
            (is.force, is.inject) = (was.force, was.inject);
        }
        if is.as_bytes() == was.as_bytes() {
            return None;
        }
        let (field, a, b) = which(was, &is);
        Some((format!("{field} of force frame {} of `{name}`", was.seq), a, b))
    }

    fn compare(&mut self, tick: u64, samples: &[f64]) {
        let channels = self.channels.max(1);
        if !self.heard {
            return;
        }
        // skips missing stretches: no later result depends on sound
        while self.sound_tick < tick && self.sound.len() >= channels {
            self.sound.drain(..channels);
            self.sound_tick += 1;
        }
        for (i, was) in samples.iter().enumerate() {
            let Some(is) = self.sound.pop_front() else { break };
            self.verdict.samples += 1;
            let what = || format!("sound of channel {}", i % channels);
            if let Some([_, sound]) = &mut self.deviations {
                let tick = tick + (i / channels) as u64;
                let (time, show) = (tick as f64 / self.rate, |v: f64| format!("{v:e}"));
                sound.see(*was, is, || Difference { tick, time, what: what(), was: show(*was), is: show(is) });
                continue;
            }
            if is.to_bits() != was.to_bits() && self.verdict.difference.is_none() {
                self.differs(tick + (i / channels) as u64, what(), format!("{was:e}"), format!("{is:e}"));
            }
        }
        self.sound_tick = tick + (samples.len() / channels) as u64;
    }

    fn differs(&mut self, tick: u64, what: String, was: String, is: String) {
        let time = tick as f64 / self.rate;
        self.verdict.difference.get_or_insert(Difference { tick, time, what, was, is });
    }
}
