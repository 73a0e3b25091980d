//! The recorder: takes what the engine leaves behind to those who want it, and what people ask to the engine.

mod hand;
mod refused;
mod seen;
mod swap;

use super::audio::{AudioSummary, Outputs, Watch};
use super::sink::{Notice, Sink, missing};
use super::summary::{Fault, StatsSnapshot, Summary};
use super::{FrameTiming, RecorderEnds, Shared};
use crate::blocks::take;
use crate::engine::{Change, Engine, EngineCommand, Port, Refit, Retired, Setup};
use crate::frame::{Cause, Mode};
use crate::guard::Order;
use crate::record::Record;
use crate::stats::Times;
use crate::version::Version;
use ca_core::{Controls, Scene};
use ca_io::FileError;
pub use refused::Refused;
use seen::Seen;
use std::sync::Arc;
use std::sync::atomic::Ordering::{Relaxed, Release};

/// What was measured since the last snapshot.
#[derive(Default)]
struct Second {
    frames: Times,
    late: Times,
    loops: Times,
    /// computing time \[ns\]
    took: u64,
}

/// Looks after a running engine.
pub struct Recorder {
    ends: RecorderEnds,
    shared: Arc<Shared>,
    scene: Arc<Scene>,
    controls: Controls,
    sinks: Vec<Box<dyn Sink>>,
    seen: Vec<Seen>,
    frame_times: Times,
    late_times: Times,
    /// since the last snapshot
    second: Second,
    frames: u64,
    tick: u64,
    /// gesture frames a second, rounded
    rate: u64,
    faults: Vec<Fault>,
    notices: Vec<Notice>,
    block: Vec<f64>,
    broken: Vec<FileError>,
    audio: Option<Watch>,
    /// devices that played before
    before: Vec<AudioSummary>,
    /// what may play the sound
    outputs: Outputs,
    hand: hand::Hand,
    /// a version of the scene that the engine is to play, with its parameters; and how many came before
    coming: Option<(Arc<Version>, Controls)>,
    versions: u32,
    /// what was reported as left out for want of room in the rings of the engine, and at which gesture frame
    reported: ([u64; 3], u64),
}

impl Recorder {
    /// A recorder for an engine with these ports; what it learns goes to `sinks`.
    pub fn new(
        ends: RecorderEnds,
        shared: Arc<Shared>,
        scene: Arc<Scene>,
        ports: &[Port],
        sinks: Vec<Box<dyn Sink>>,
    ) -> Recorder {
        Recorder {
            ends,
            shared,
            controls: scene.controls(),
            sinks,
            seen: ports.iter().map(Seen::new).collect(),
            frame_times: Times::new(),
            late_times: Times::new(),
            second: Second::default(),
            frames: 0,
            tick: 0,
            rate: ((scene.rate / f64::from(scene.rates.ratio)).round() as u64).max(1),
            faults: Vec::new(),
            notices: Vec::new(),
            block: Vec::new(),
            broken: Vec::new(),
            audio: None,
            before: Vec::new(),
            outputs: Outputs::default(),
            hand: hand::Hand::new(&scene),
            coming: None,
            versions: 0,
            reported: ([0; 3], 0),
            scene,
        }
    }

    /// Sound goes to a device, too, from now on; to none where there is none.
    pub fn hears(&mut self, audio: Option<Watch>) {
        self.before.extend(self.audio.take().map(|a| a.summary()));
        self.audio = audio;
    }

    /// Outputs of the sound, for the front end that opens them and for requests.
    pub fn outputs(&mut self) -> &mut Outputs {
        &mut self.outputs
    }

    /// The device that plays the sound, by name, and how late that is heard \[ms\], as far as is known yet.
    pub fn heard(&self) -> Option<(String, f64)> {
        let a = self.audio.as_ref()?.summary();
        Some((format!("{} ({}), {} Hz", a.playback.device, a.playback.host, a.playback.rate), a.latency_ms))
    }

    /// Something people should know, and a take: reported at the next turn.
    pub fn say(&mut self, bad: bool, text: String) {
        self.notices.push(Notice { tick: self.tick, device: None, bad, text });
    }

    /// Takes everything that lies in the rings; to be called every few milliseconds, and once the engine has ended.
    pub fn poll(&mut self) {
        // what there is now, so that records come first
        let mut heard = self.ends.sound.slots();
        while let Ok(record) = self.ends.records.pop() {
            self.look(&record);
            self.tell(|s| s.record(&record));
        }
        let mut block = std::mem::take(&mut self.block);
        while heard > 0 {
            let Some(tick) = take(&mut self.ends.sound, &mut block) else { break };
            heard = heard.saturating_sub(block.len() + 2);
            self.tell(|s| s.sound(tick, &block));
        }
        while let Some(tick) = self.ends.views.as_mut().and_then(|v| take(v, &mut block)) {
            let (x, d) = block.split_at(block.len() / 2);
            self.tell(|s| s.view(tick, x).and_then(|()| s.motion(tick, d)));
        }
        self.block = block;
        while let Ok(timing) = self.ends.timings.pop() {
            self.timing(timing);
        }
        self.turn_gesture();
        self.missing();
        for (bad, text) in self.sinks.iter_mut().filter_map(|s| s.news()).collect::<Vec<_>>() {
            self.say(bad, text);
        }
        for text in self.audio.as_mut().map(Watch::news).unwrap_or_default() {
            self.say(true, text);
        }
        // a sink that fails meanwhile is news for those left
        while !self.notices.is_empty() {
            for h in std::mem::take(&mut self.notices) {
                self.tell(|s| s.said(&h));
            }
        }
    }

    /// Says that something found no room in the rings, while that happens: at once, then once a second.
    fn missing(&mut self) {
        let (lost, (reported, at)) = (self.shared.lost(), self.reported);
        if lost != reported && (reported == [0; 3] || self.frames - at >= self.rate) {
            self.reported = (lost, self.frames);
            let why = "this process did not run for longer than the rings of the engine hold";
            self.say(true, format!("all files: {} are missing so far; {why}", missing(lost)));
        }
    }

    /// A sink that fails is reported once, and left out from then on; playing goes on.
    fn tell(&mut self, mut f: impl FnMut(&mut dyn Sink) -> Result<(), FileError>) {
        let mut broken = Vec::new();
        self.sinks.retain_mut(|s| f(s.as_mut()).map_err(|e| broken.push(e)).is_ok());
        for e in broken {
            self.say(true, e.to_string());
            self.broken.push(e);
        }
    }

    /// Why sinks failed, one each.
    pub fn broken(&self) -> &[FileError] {
        &self.broken
    }

    fn timing(&mut self, timing: FrameTiming) {
        self.frames += 1;
        if self.seen.is_empty() {
            // nobody is sent a force that says how far it is
            self.tick = (self.frames - 1) * u64::from(self.scene.rates.ratio);
        }
        self.frame_times.add(timing.took);
        self.late_times.add(timing.start.late);
        self.second.frames.add(timing.took);
        self.second.late.add(timing.start.late);
        self.second.took += timing.took;
        if self.frames.is_multiple_of(self.rate) {
            let frame = self.rate as f64 / (self.scene.rate / f64::from(self.scene.rates.ratio));
            let audio = self.audio.as_ref().map(Watch::summary);
            let snapshot = StatsSnapshot {
                tick: self.tick,
                frames: self.frames,
                frame_us: self.second.frames.percentiles(),
                late_us: self.second.late.percentiles(),
                loop_us: self.second.loops.percentiles(),
                missed: self.shared.missed.load(Relaxed),
                dropped: self.shared.dropped.load(Relaxed),
                stale: self.shared.stale.load(Relaxed),
                faults: self.faults.len() as u64,
                clipped: self.shared.clipped.load(Relaxed),
                lost: self.lost(),
                load: self.second.took as f64 * 1e-9 / frame,
                underruns: audio.as_ref().map_or(0, |a| a.underruns + a.xruns),
                ppm: audio.map_or(0.0, |a| a.ppm),
            };
            self.second = Second::default();
            self.tell(|s| s.snapshot(&snapshot));
        }
    }

    /// Records, sound samples and pictures that found no room in the rings or on their way to a sink.
    fn left_out(&self) -> [u64; 3] {
        let add = |a: [u64; 3], b: [u64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        self.sinks.iter().map(|s| s.lost()).fold(self.shared.lost(), add)
    }

    /// Records, sounds, pictures, forces and times lost so far.
    pub fn lost(&self) -> u64 {
        let s = &self.shared;
        self.left_out().iter().sum::<u64>() + s.lost_forces.load(Relaxed) + s.lost_timings.load(Relaxed)
    }

    fn look(&mut self, record: &Record) {
        match record {
            Record::Device { port, frame } => {
                let Some(seen) = self.seen.get_mut(*port as usize) else { return };
                if let Some(ns) = seen.sent(frame) {
                    self.second.loops.add(ns);
                }
            }
            Record::Force { port, frame } => {
                self.tick = frame.tick;
                let Some(seen) = self.seen.get_mut(*port as usize) else { return };
                self.faults.extend(seen.force(frame, &mut self.notices));
            }
            Record::Order { tick, port, order } => {
                let meant = |k: usize| port.is_none_or(|p| p as usize == k);
                let all = self.seen.iter_mut().enumerate();
                all.filter(|(k, _)| meant(*k)).for_each(|(_, seen)| seen.order(*tick, *order));
            }
            Record::Retired { retired: Retired::State(_), .. } => self.hand.let_go(),
            Record::Touched { tick, touched, .. } => self.hand.touched(*tick, touched),
            Record::Swapped { tick, .. } => self.swapped(*tick),
            Record::Waiting { tick, port, wait } => {
                let Some(seen) = self.seen.get_mut(*port as usize) else { return };
                self.notices.extend(seen.waits(*tick, wait, &self.scene));
            }
            _ => {}
        }
    }

    fn command(&mut self, act: EngineCommand) -> Result<(), Refused> {
        // what is made for a scene is not for the one after it
        if self.is_swapping() && !matches!(act, EngineCommand::Order(..) | EngineCommand::Mark) {
            return Err(Refused::Swapping);
        }
        let disarms = self.shared.disarms.load(Relaxed);
        self.ends.commands.push((disarms, act)).map_err(|_| Refused::Busy)
    }

    /// Sets several live parameters \[SI\] in one tick. Nothing changes where one of them is refused.
    ///
    /// # Errors
    /// For the first parameter that does not exist or is out of range; nothing has changed then.
    pub fn set(&mut self, values: &[(String, f64)]) -> Result<(), Refused> {
        let mut controls = self.controls.clone();
        let mut change = Change::default();
        for (name, value) in values {
            let patch = controls.set(name, *value)?;
            let place = controls.params().iter().position(|p| p.name == *name).unwrap_or_default();
            change.params.push((place as u32, *value));
            change.patches.push(patch);
        }
        self.command(EngineCommand::Set(Box::new(change)))?;
        self.controls = controls;
        Ok(())
    }

    /// Asks for a [`Record::Marked`], which comes after the records of everything that was asked before.
    ///
    /// # Errors
    /// If the engine takes no command.
    pub fn mark(&mut self) -> Result<(), Refused> {
        self.command(EngineCommand::Mark)
    }

    /// The live parameters with their present values.
    pub fn controls(&self) -> &Controls {
        &self.controls
    }

    /// Arms or disarms a device, or all. A model that diverged is loaded again first.
    ///
    /// # Errors
    /// If the device does not exist, or the engine does not take orders.
    pub fn order(&mut self, device: Option<&str>, order: Order) -> Result<(), Refused> {
        let which = match device {
            None => None,
            Some(name) => {
                let Some(k) = self.seen.iter().position(|s| s.name == name) else {
                    return Err(Refused::Device(name.into(), self.seen.iter().map(|s| s.name.clone()).collect()));
                };
                Some(k as u32)
            }
        };
        if order == Order::Disarm {
            // first the count, so that no arming of before slips through
            self.shared.disarms.fetch_add(1, Relaxed);
            self.shared.disarm.fetch_or(which.map_or(u64::MAX, |k| 1 << k.min(63)), Release);
            return Ok(());
        }
        if order == Order::Arm && self.shared.diverged.load(Relaxed) {
            self.reload()?;
        }
        self.command(EngineCommand::Order(which, order))
    }

    /// Device number `which` is what `setup` says from the next gesture frame on.
    ///
    /// # Errors
    /// If the engine takes no order.
    pub fn refit(&mut self, which: u32, setup: Setup) -> Result<(), Refused> {
        self.command(EngineCommand::Refit(Box::new(Refit::new(&self.scene, which, setup))))
    }

    /// The scene as at load, with all parameters as at load, and forces off.
    ///
    /// # Errors
    /// If the engine takes no order.
    pub fn reload(&mut self) -> Result<(), Refused> {
        self.command(EngineCommand::Reload(Box::new(self.scene.state())))?;
        self.controls = self.scene.controls();
        Ok(())
    }

    /// Mode and cause of each device, by name.
    pub fn devices(&self) -> impl Iterator<Item = (&str, Mode, Cause, u64)> {
        self.seen.iter().map(|s| (s.name.as_str(), s.mode, s.cause, s.frames))
    }

    /// What armed devices wait for, by name, in words.
    pub fn waiting(&self) -> impl Iterator<Item = (&str, &str)> {
        self.seen.iter().filter_map(|s| Some((s.name.as_str(), s.waiting()?)))
    }

    /// Gesture frames so far, and the sound sample they came to.
    pub fn progress(&self) -> (u64, u64) {
        (self.frames, self.tick)
    }

    /// The account, once the engine has ended.
    pub fn summary(&mut self, engine: &Engine, granted: Vec<(String, String)>) -> Summary {
        let (s, ratio) = (&self.shared, u64::from(self.scene.rates.ratio));
        let [lost_records, lost_sound, lost_views] = self.left_out();
        Summary {
            seconds: engine.state.tick as f64 / self.scene.rate,
            frames: engine.counts.frames,
            period_us: 1e6 * f64::from(self.scene.rates.ratio) * self.scene.rates.sample_dt,
            frame_us: self.frame_times.percentiles(),
            late_us: self.late_times.percentiles(),
            missed: self.shared.missed.load(Relaxed),
            stale: engine.counts.stale,
            dropped: engine.counts.dropped,
            lost_forces: s.lost_forces.load(Relaxed),
            lost_records,
            lost_sound,
            lost_views,
            lost_timings: s.lost_timings.load(Relaxed),
            clipped: engine.counts.clipped,
            refused: engine.counts.refused,
            unstable: engine.has_diverged(),
            devices: self
                .seen
                .iter()
                .zip(&engine.ports)
                .map(|(s, p)| s.summary(p, &engine.scene, engine.state.tick, ratio))
                .collect(),
            faults: std::mem::take(&mut self.faults),
            broken: self.broken.iter().map(ToString::to_string).collect(),
            granted,
            audio: self.audio.as_ref().map(Watch::summary),
            audio_before: std::mem::take(&mut self.before),
        }
    }
}

#[cfg(all(test, feature = "system"))]
mod tests;
