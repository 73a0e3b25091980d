//! Sends the records of the engine to the sinks, and commands from people to the engine.

mod device_monitor;
mod manual;
mod refused;
mod swap;

use super::audio::{AudioSummary, Outputs, Watch};
use super::sink::{Notice, Sink, missing};
use super::summary::{Fault, StatsSnapshot, Summary};
use super::{FrameTiming, RecorderEnds, Shared};
use crate::block_ring::take;
use crate::engine::{Change, Engine, EngineCommand, Port, Refit, Retired, Setup};
use crate::frame::{Cause, Mode};
use crate::guard::Order;
use crate::record::Record;
use crate::stats::Times;
use crate::version::Version;
use ca_core::{Controls, Scene};
use ca_io::FileError;
use device_monitor::DeviceMonitor;
pub use refused::Refused;
use std::sync::Arc;
use std::sync::atomic::Ordering::{Relaxed, Release};

/// Measurements since the last snapshot.
#[derive(Default)]
struct Second {
    frames: Times,
    late: Times,
    loops: Times,
    /// Computing time \[ns\].
    took: u64,
}

/// Reads the rings of a running engine, and sends it commands.
pub struct Recorder {
    ends: RecorderEnds,
    shared: Arc<Shared>,
    scene: Arc<Scene>,
    controls: Controls,
    sinks: Vec<Box<dyn Sink>>,
    monitors: Vec<DeviceMonitor>,
    frame_times: Times,
    late_times: Times,
    second: Second,
    frames: u64,
    tick: u64,
    /// Gesture frames per second, rounded.
    rate: u64,
    faults: Vec<Fault>,
    notices: Vec<Notice>,
    block: Vec<f64>,
    broken: Vec<FileError>,
    audio: Option<Watch>,
    /// Sound devices that played before.
    before: Vec<AudioSummary>,
    outputs: Outputs,
    manual: manual::ManualProgress,
    /// Version of the scene on its way to the engine, with its parameters.
    pending: Option<(Arc<Version>, Controls)>,
    versions: u32,
    /// Last report of losses in full rings, and the gesture frame at which it was made.
    reported: ([u64; 3], u64),
}

impl Recorder {
    /// Makes a recorder for an engine with these ports, which sends records to `sinks`.
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
            monitors: ports.iter().map(DeviceMonitor::new).collect(),
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
            manual: manual::ManualProgress::new(&scene),
            pending: None,
            versions: 0,
            reported: ([0; 3], 0),
            scene,
        }
    }

    /// Sets the sound device that plays from now on, if any.
    pub fn set_audio(&mut self, audio: Option<Watch>) {
        self.before.extend(self.audio.take().map(|a| a.summary()));
        self.audio = audio;
    }

    /// Returns the outputs of the sound, for the front end that opens them and for requests.
    pub fn outputs(&mut self) -> &mut Outputs {
        &mut self.outputs
    }

    /// Returns the description of the sound device, and its latency \[ms\] as far as it is known yet.
    pub fn audio_output(&self) -> Option<(String, f64)> {
        let a = self.audio.as_ref()?.summary();
        Some((format!("{} ({}), {} Hz", a.playback.device, a.playback.host, a.playback.rate), a.latency_ms))
    }

    /// Adds a message, which the next poll sends to all sinks.
    pub fn say(&mut self, bad: bool, text: String) {
        self.notices.push(Notice { tick: self.tick, device: None, bad, text });
    }

    /// Sends everything in the rings to the sinks. Call it every few milliseconds, and once after the engine has ended.
    pub fn poll(&mut self) {
        // measured before records are read, so that these come first
        let mut heard = self.ends.sound.slots();
        while let Ok(record) = self.ends.records.pop() {
            self.look(&record);
            self.for_each_sink(|s| s.record(&record));
        }
        let mut block = std::mem::take(&mut self.block);
        while heard > 0 {
            let Some(tick) = take(&mut self.ends.sound, &mut block) else { break };
            heard = heard.saturating_sub(block.len() + 2);
            self.for_each_sink(|s| s.sound(tick, &block));
        }
        while let Some(tick) = self.ends.views.as_mut().and_then(|v| take(v, &mut block)) {
            let (x, d) = block.split_at(block.len() / 2);
            self.for_each_sink(|s| s.view(tick, x).and_then(|()| s.motion(tick, d)));
        }
        self.block = block;
        while let Ok(timing) = self.ends.timings.pop() {
            self.timing(timing);
        }
        self.apply_gesture_params();
        self.missing();
        for (bad, text) in self.sinks.iter_mut().filter_map(|s| s.poll_notice()).collect::<Vec<_>>() {
            self.say(bad, text);
        }
        for text in self.audio.as_mut().map(Watch::take_messages).unwrap_or_default() {
            self.say(true, text);
        }
        // a failing sink adds a message for the others
        while !self.notices.is_empty() {
            for h in std::mem::take(&mut self.notices) {
                self.for_each_sink(|s| s.notice(&h));
            }
        }
    }

    /// Reports losses in full rings: at once, then once a second while they continue.
    fn missing(&mut self) {
        let (lost, (reported, at)) = (self.shared.lost(), self.reported);
        if lost != reported && (reported == [0; 3] || self.frames - at >= self.rate) {
            self.reported = (lost, self.frames);
            let why = "this process was paused for longer than its buffers last";
            self.say(true, format!("all files: {} lost so far, because {why}", missing(lost)));
        }
    }

    /// Calls `f` with each sink. A sink that fails is reported once and dropped.
    fn for_each_sink(&mut self, mut f: impl FnMut(&mut dyn Sink) -> Result<(), FileError>) {
        let mut broken = Vec::new();
        self.sinks.retain_mut(|s| f(s.as_mut()).map_err(|e| broken.push(e)).is_ok());
        for e in broken {
            self.say(true, e.to_string());
            self.broken.push(e);
        }
    }

    /// Returns the errors of the sinks that failed.
    pub fn broken(&self) -> &[FileError] {
        &self.broken
    }

    fn timing(&mut self, timing: FrameTiming) {
        self.frames += 1;
        if self.monitors.is_empty() {
            // without devices, no force frame carries the tick
            self.tick = (self.frames - 1) * u64::from(self.scene.rates.ratio);
        }
        self.frame_times.add(timing.compute_ns);
        self.late_times.add(timing.start.late);
        self.second.frames.add(timing.compute_ns);
        self.second.late.add(timing.start.late);
        self.second.took += timing.compute_ns;
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
            self.for_each_sink(|s| s.snapshot(&snapshot));
        }
    }

    /// Returns the records, sound samples and pictures lost in full rings or on the way to a sink.
    fn left_out(&self) -> [u64; 3] {
        let add = |a: [u64; 3], b: [u64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        self.sinks.iter().map(|s| s.lost()).fold(self.shared.lost(), add)
    }

    /// Returns the number of records, sound samples, pictures, forces and timings lost so far.
    pub fn lost(&self) -> u64 {
        let s = &self.shared;
        self.left_out().iter().sum::<u64>() + s.lost_forces.load(Relaxed) + s.lost_timings.load(Relaxed)
    }

    fn look(&mut self, record: &Record) {
        match record {
            Record::Device { port, frame } => {
                let Some(monitors) = self.monitors.get_mut(*port as usize) else { return };
                if let Some(ns) = monitors.sent(frame) {
                    self.second.loops.add(ns);
                }
            }
            Record::Force { port, frame } => {
                self.tick = frame.tick;
                let Some(monitors) = self.monitors.get_mut(*port as usize) else { return };
                self.faults.extend(monitors.force(frame, &mut self.notices));
            }
            Record::Order { tick, port, order } => {
                let meant = |k: usize| port.is_none_or(|p| p as usize == k);
                let all = self.monitors.iter_mut().enumerate();
                all.filter(|(k, _)| meant(*k)).for_each(|(_, monitors)| monitors.order(*tick, *order));
            }
            Record::Retired { retired: Retired::State(_), .. } => self.manual.reset(),
            Record::Manual { tick, event, .. } => self.manual.apply(*tick, event),
            Record::Swapped { tick, .. } => self.swapped(*tick),
            Record::Waiting { tick, port, wait } => {
                let Some(monitors) = self.monitors.get_mut(*port as usize) else { return };
                self.notices.extend(monitors.waits(*tick, wait, &self.scene));
            }
            _ => {}
        }
    }

    fn command(&mut self, act: EngineCommand) -> Result<(), Refused> {
        // a command made for one scene is not valid for the next
        if self.is_swapping() && !matches!(act, EngineCommand::Order(..) | EngineCommand::Mark) {
            return Err(Refused::Swapping);
        }
        let disarms = self.shared.disarms.load(Relaxed);
        self.ends.commands.push((disarms, act)).map_err(|_| Refused::Busy)
    }

    /// Sets several live parameters (SI units) in one tick. If one of them is refused, none changes.
    ///
    /// # Errors
    /// If a parameter does not exist or is out of range (reports the first), or the engine does not take commands now.
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

    /// Requests a [`Record::Marked`], which comes after the records of all earlier commands.
    ///
    /// # Errors
    /// If the engine does not take commands now.
    pub fn mark(&mut self) -> Result<(), Refused> {
        self.command(EngineCommand::Mark)
    }

    /// Returns the live parameters with their present values.
    pub fn controls(&self) -> &Controls {
        &self.controls
    }

    /// Arms or disarms a device, or all for `None`. Arming first reloads a model that has diverged.
    ///
    /// # Errors
    /// If the device does not exist, or the engine does not take commands now.
    pub fn order(&mut self, device: Option<&str>, order: Order) -> Result<(), Refused> {
        let which = match device {
            None => None,
            Some(name) => {
                let Some(k) = self.monitors.iter().position(|s| s.name == name) else {
                    return Err(Refused::Device(name.into(), self.monitors.iter().map(|s| s.name.clone()).collect()));
                };
                Some(k as u32)
            }
        };
        if order == Order::Disarm {
            // the count first, so that each earlier arm command is void
            self.shared.disarms.fetch_add(1, Relaxed);
            self.shared.disarm.fetch_or(which.map_or(u64::MAX, |k| 1 << k.min(63)), Release);
            return Ok(());
        }
        if order == Order::Arm && self.shared.diverged.load(Relaxed) {
            self.reload()?;
        }
        self.command(EngineCommand::Order(which, order))
    }

    /// Replaces the setup of device number `which` from the next gesture frame on.
    ///
    /// # Errors
    /// If the engine does not take commands now.
    pub fn refit(&mut self, which: u32, setup: Setup) -> Result<(), Refused> {
        self.command(EngineCommand::Refit(Box::new(Refit::new(&self.scene, which, setup))))
    }

    /// Resets the scene and all parameters to their values at load, and turns forces off.
    ///
    /// # Errors
    /// If the engine does not take commands now.
    pub fn reload(&mut self) -> Result<(), Refused> {
        self.command(EngineCommand::Reload(Box::new(self.scene.state())))?;
        self.controls = self.scene.controls();
        Ok(())
    }

    /// Returns name, mode, cause and number of frames of each device.
    pub fn devices(&self) -> impl Iterator<Item = (&str, Mode, Cause, u64)> {
        self.monitors.iter().map(|s| (s.name.as_str(), s.mode, s.cause, s.frames))
    }

    /// Returns the name of each armed device that waits, and the reason.
    pub fn waiting(&self) -> impl Iterator<Item = (&str, &str)> {
        self.monitors.iter().filter_map(|s| Some((s.name.as_str(), s.waiting()?)))
    }

    /// Returns the number of gesture frames so far, and the present sound sample.
    pub fn progress(&self) -> (u64, u64) {
        (self.frames, self.tick)
    }

    /// Returns the summary, once the engine has ended.
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
                .monitors
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
