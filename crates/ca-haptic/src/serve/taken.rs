//! The take as a sink.

use super::desk::{Happened, Sink};
use super::summary::Pulse;
use crate::error::FileError;
use crate::record::Record;
use crate::take::{Level, Rt, TakeWriter};

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

    fn pulse(&mut self, p: &Pulse) -> Result<(), FileError> {
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

    fn said(&mut self, h: &Happened) -> Result<(), FileError> {
        // modes and causes of devices are told by the frames themselves
        if h.device.is_some() {
            return Ok(());
        }
        self.log(h.tick, if h.bad { Level::Warning } else { Level::Info }, "serve", &h.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Options;
    use crate::engine::tests::{KEY, setup};
    use crate::frame::DeviceFrame;
    use crate::serve::{Aside, Clock, Desk, Every, Live, Shared, rings};
    use crate::take::{Event, Header, Replay, Take};
    use ca_core::model::read;
    use ca_core::{Catalog, compile};
    use std::sync::Arc;

    #[test]
    fn what_finds_no_room_is_counted_and_told_where_it_is_missing() {
        let dir = tempfile::tempdir().expect("a directory");
        let path = dir.path().join("a.mcap");
        let (model, _) = read::read(KEY, "key.ca.toml", &Catalog::core());
        let options = ca_core::Options::default();
        let scene = Arc::new(compile(&model, &Catalog::core(), &options).expect("it compiles"));
        let header = Header::new(&model, vec![], options, &scene, vec![setup()], Options::default());
        let engine = header.engine(&Catalog::core()).expect("an engine");
        let (ends, mut gateway, desk_ends) = rings(&scene, 1, 60);
        let shared = Arc::new(Shared::default());
        let take = TakeWriter::create(&path, &header, &scene).expect("a file");
        let (line, take) = Aside::start("take", take).expect("a thread");
        let mut desk = Desk::new(desk_ends, shared.clone(), scene, &engine.ports, vec![Box::new(line)]);
        let every = Every { energy: 0, view: 50, hash: 3000 };
        let mut live = Live::new(engine, ends, shared, Clock::Device { patience: 0 }, every);
        let mut play = |live: &mut Live, frames: std::ops::Range<u64>| {
            for n in frames {
                let mut frame = DeviceFrame::new("key", 1);
                (frame.session, frame.seq, frame.pos[0]) = (1, n, 1e-3 * (n as f64 * 0.01).sin());
                gateway.frames.push((0, frame)).expect("room");
                live.frame();
                while gateway.forces.pop().is_ok() {}
            }
        };
        // rings hold two seconds: the desk is away for four, and what is asked of the engine still finds room
        play(&mut live, 1..12_000);
        desk.set(&[]).expect("asked");
        play(&mut live, 12_000..12_001);
        desk.turn();
        play(&mut live, 12_001..12_101);
        desk.turn();
        // and away again until the end
        play(&mut live, 12_101..24_001);
        let engine = live.run(Some(0));
        desk.end();
        let s = desk.summary(&engine, vec![]);
        assert!(!s.is_faithful() && s.lost_records > 8000 && s.lost_sound > 80_000 && s.lost_views > 60, "{s:?}");
        let lost = [s.lost_records, s.lost_sound, s.lost_views];
        let told = take.end().expect("no failure").expect("a take").finish(lost).expect("finished");
        assert_eq!(told.lost, s.lost_records + s.lost_sound);

        let take = Take::open(&path).expect("a take");
        assert_eq!(take.summary().expect("a summary").lost, lost);
        // the first hole stands right before the change, which is there
        let events: Vec<Event> = take.events().expect("open").map(|e| e.expect("read")).collect();
        let hole = events.iter().position(|e| matches!(e, Event::Lost(l) if l.records > 0)).expect("a hole");
        let change = events.iter().position(|e| matches!(e, Event::Change(..))).expect("the change");
        let is_frame = |e: &Event| matches!(e, Event::Device(..) | Event::Force(..));
        assert!(hole < change && !events[hole..change].iter().any(is_frame));
        // and a replay stands by what is before it
        let mut r = Replay::new(&take, &Catalog::core()).expect("an engine");
        let v = r.run(&take, &mut |_| (), &mut |_| Ok(())).expect("replayed");
        assert!(v.difference.is_none() && !v.is_identical(), "{v:?}");
        let before = events[..hole].iter().filter(|e| matches!(e, Event::Force(..))).count() as u64;
        assert!(v.forces == before && before > 6000, "{v:?}");
        assert!(v.hole.is_some_and(|t| t > 3.0 && t < 4.1), "{v:?}");
    }
}
