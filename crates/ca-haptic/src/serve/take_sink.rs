//! Implements [`Sink`] for a take.

use super::sink::{Notice, Sink};
use super::summary::StatsSnapshot;
use crate::record::Record;
use crate::take::{Level, Rt, TakeWriter};
use crate::version::Version;
use ca_io::error::FileError;
use std::sync::Arc;

impl Sink for TakeWriter {
    fn record(&mut self, record: &Record) -> Result<(), FileError> {
        TakeWriter::record(self, record)
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        TakeWriter::sound(self, tick, frames)
    }

    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        TakeWriter::view(self, tick, x)
    }

    fn swapped(&mut self, tick: u64, version: &Arc<Version>) -> Result<(), FileError> {
        TakeWriter::swapped(self, tick, version)
    }

    fn snapshot(&mut self, p: &StatsSnapshot) -> Result<(), FileError> {
        self.stats(&Rt {
            tick: p.tick,
            frames: p.frames,
            missed: p.missed,
            stale: p.stale,
            dropped: p.dropped,
            faults: p.faults,
            clipped: p.clipped,
            late_p50: p.late_us.p50,
            late_p99: p.late_us.p99,
            late_max: p.late_us.max,
            busy: p.load,
            underruns: p.underruns,
            audio_ppm: p.ppm,
        })
    }

    fn notice(&mut self, h: &Notice) -> Result<(), FileError> {
        // the frames contain modes and causes of devices
        if h.device.is_some() {
            return Ok(());
        }
        self.log(h.tick, if h.bad { Level::Warning } else { Level::Info }, "serve", &h.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::{KEY, setup};
    use crate::engine::{Engine, Options};
    use crate::frame::DeviceFrame;
    use crate::rt::RtRequest;
    use crate::serve::{AsyncSink, BufferLimits, Clock, Live, RecordIntervals, Recorder, Shared, rings};
    use crate::take::{Event, Header, Replay, Take};
    use ca_compile::compile;
    use ca_core::Scene;
    use ca_model::read;
    use std::sync::{Mutex, PoisonError};

    /// Returns the header of a take, the scene of a key and its engine.
    fn key() -> (Header, Arc<Scene>, Engine) {
        let (model, _) = read::read(KEY, "key.ca.toml", &ca_model::catalog());
        let options = ca_compile::Options::default();
        let scene = Arc::new(compile(&model, &ca_model::catalog(), &options).expect("it compiles").scene);
        let header = Header::new(&model, vec![], options, &scene, vec![setup()], Options::default());
        let engine = header.engine(&ca_model::catalog()).expect("an engine");
        (header, scene, engine)
    }

    #[test]
    fn what_finds_no_room_is_counted_and_told_where_it_is_missing() {
        let dir = tempfile::tempdir().expect("a directory");
        let path = dir.path().join("a.mcap");
        let (header, scene, engine) = key();
        let (ends, mut gateway, recorder_ends) = rings(&scene, 1, 60);
        let shared = Arc::new(Shared::default());
        let take = TakeWriter::create(&path, &header, &scene).expect("a file");
        let (line, take) =
            AsyncSink::start("take", take, BufferLimits::of(&scene), RtRequest::default()).expect("a thread");
        let mut recorder = Recorder::new(recorder_ends, shared.clone(), scene, &engine.ports, vec![Box::new(line)]);
        let every = RecordIntervals { energy: 0, view: 50, hash: 3000 };
        let mut live = Live::new(engine, ends, shared, Clock::Device { patience: 0 }, every);
        let mut play = |live: &mut Live, frames: std::ops::Range<u64>| {
            for n in frames {
                let mut frame = DeviceFrame::new("key", 1);
                (frame.session, frame.seq, frame.pos[0]) = (1, n, 1e-3 * (n as f64 * 0.01).sin());
                gateway.frames.push((0, frame)).expect("capacity");
                live.frame();
                while gateway.forces.pop().is_ok() {}
            }
        };
        // The rings hold 4 s, the ring of records up to 6 s. The recorder is absent for 8 s, and commands still fit.
        play(&mut live, 1..24_000);
        recorder.set(&[]).expect("asked");
        play(&mut live, 24_000..24_001);
        recorder.poll();
        play(&mut live, 24_001..24_101);
        recorder.poll();
        // absent again until the end
        play(&mut live, 24_101..42_001);
        let engine = live.run(Some(0));
        recorder.poll();
        let s = recorder.summary(&engine, vec![]);
        assert!(!s.is_faithful() && s.lost_records > 8000 && s.lost_sound > 80_000 && s.lost_views > 60, "{s:?}");
        let lost = [s.lost_records, s.lost_sound, s.lost_views];
        let reported = take.end().expect("no failure").expect("a take").finish(lost).expect("finished");
        assert_eq!(reported.lost, s.lost_records + s.lost_sound);

        let take = Take::open(&path).expect("a take");
        assert_eq!(take.summary().expect("a summary").lost, lost);
        // the first gap is directly before the change, which is recorded
        let events: Vec<Event> = take.events().expect("open").map(|e| e.expect("read")).collect();
        let hole = events.iter().position(|e| matches!(e, Event::Lost(l) if l.records > 0)).expect("a hole");
        let change = events.iter().position(|e| matches!(e, Event::Change(..))).expect("the change");
        let is_frame = |e: &Event| matches!(e, Event::Device(..) | Event::Force(..));
        assert!(hole < change && !events[hole..change].iter().any(is_frame));
        // a replay verifies everything before the gap
        let mut r = Replay::new(&take, &ca_model::catalog()).expect("an engine");
        let v = r.run(&take, &mut |_| (), &mut |_| Ok(())).expect("replayed");
        assert!(v.difference.is_none() && !v.is_identical(), "{v:?}");
        let before = events[..hole].iter().filter(|e| matches!(e, Event::Force(..))).count() as u64;
        assert!(v.forces == before && before > 12_000, "{v:?}");
        assert!(v.hole.is_some_and(|t| t > 5.0 && t < 8.1), "{v:?}");
    }

    /// A take on a disk that blocks while the lock is held.
    struct Slow(TakeWriter, Arc<Mutex<()>>);

    impl Sink for Slow {
        fn record(&mut self, record: &Record) -> Result<(), FileError> {
            let _still = self.1.lock().unwrap_or_else(PoisonError::into_inner);
            self.0.record(record)
        }
        fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
            self.0.sound(tick, frames)
        }
    }

    #[test]
    fn what_a_stalled_writer_loses_is_reported_where_it_is_missing() {
        let dir = tempfile::tempdir().expect("a directory");
        let path = dir.path().join("a.mcap");
        let (header, scene, engine) = key();
        let (ends, mut gateway, recorder_ends) = rings(&scene, 1, 0);
        let shared = Arc::new(Shared::default());
        let still = Arc::new(Mutex::new(()));
        let slow = Slow(TakeWriter::create(&path, &header, &scene).expect("a file"), still.clone());
        let limits = BufferLimits { seconds: 1.0, ..BufferLimits::of(&scene) };
        let (line, take) = AsyncSink::start("take", slow, limits, RtRequest::default()).expect("a thread");
        let mut recorder = Recorder::new(recorder_ends, shared.clone(), scene, &engine.ports, vec![Box::new(line)]);
        let mut live = Live::new(engine, ends, shared, Clock::Device { patience: 0 }, RecordIntervals::default());
        // plays 3 s, of which 1 s may wait
        let held = still.lock().expect("nobody panics");
        for _ in 0..9000 {
            live.frame();
            while gateway.forces.pop().is_ok() {}
            recorder.poll();
        }
        assert_eq!(recorder.lost(), take.lost().iter().sum::<u64>());
        let engine = live.run(Some(0));
        recorder.poll();
        drop(held);
        let (s, lost) = (recorder.summary(&engine, vec![]), take.lost());
        assert_eq!((lost, s.is_faithful()), ([s.lost_records, s.lost_sound, 0], false));
        take.end().expect("no failure").expect("a take").0.finish(lost).expect("finished");

        let take = Take::open(&path).expect("a take");
        assert_eq!(take.summary().expect("a summary").lost, lost);
        let mut r = Replay::new(&take, &ca_model::catalog()).expect("an engine");
        let v = r.run(&take, &mut |_| (), &mut |_| Ok(())).expect("replayed");
        // 3000 frames of 16 samples: all of the first second, and none after it
        assert!(v.difference.is_none() && v.forces == 3000 && v.hole.is_some(), "{v:?}");
        assert_eq!(lost[0], 9001 - v.forces);
    }
}
