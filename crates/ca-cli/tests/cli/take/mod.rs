//! Takes: what is written comes back, and a replay is the same to the bit.

pub mod performer;

use ca_haptic::take::{Event, Replay, Take, Verdict};
use performer::{DUO, Performer, catalog, duo};
use std::path::Path;

fn replay(path: &Path) -> Verdict {
    let take = Take::open(path).unwrap();
    Replay::new(&take, &catalog()).unwrap().run(&take, &mut |_| (), &mut |_| Ok(())).unwrap()
}

#[test]
fn a_replay_is_the_same_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    for threaded in [false, true] {
        let path = dir.path().join(format!("{threaded}.mcap"));
        let mut p = Performer::new(DUO, &path, threaded);
        p.play(2500);
        let told = p.finish();
        assert_eq!(told.lost, 0);
        assert!(p.sound.iter().any(|x| x.abs() > 0.01), "it is heard");
        let v = replay(&path);
        assert_eq!((v.difference.clone(), v.hole, v.cut.clone()), (None, None, None), "{v:?}");
        assert!(v.is_identical());
        assert_eq!((v.frames, v.forces, v.taken), (2500, 5000, p.engine.counts.taken + p.engine.counts.dropped));
        assert_eq!((v.samples, v.hashes), (p.sound.len() as u64, 8));
        assert_eq!(v.seconds, p.engine.due() as f64 / 48_000.0);
        // all that can happen did happen
        let take = Take::open(&path).unwrap();
        let count = |f: &dyn Fn(&Event) -> bool| take.events().unwrap().filter(|e| f(e.as_ref().unwrap())).count();
        assert_eq!(count(&|e| matches!(e, Event::Change(..))), 2);
        assert_eq!(count(&|e| matches!(e, Event::Order(..))), 4);
        assert_eq!(count(&|e| matches!(e, Event::Reload(_))), 1);
        assert_eq!(count(&|e| matches!(e, Event::Energy(_))), 8);
        let on = |e: &Event| matches!(e, Event::Force(0, f) if f.mode == 2 && f.force[0].abs() > 0.1);
        assert!(count(&on) > 100, "forces were felt");
    }
}
