//! Checks that a gesture frame of the engine thread allocates nothing, whether its rings are full or not.

use super::calls;
use super::engine::engine;
use ca_haptic::engine::{Change, EngineCommand};
use ca_haptic::frame::DeviceFrame;
use ca_haptic::serve::{Clock, Live, RecordIntervals, Shared, rings};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

#[test]
fn handing_over_allocates_nothing() {
    let (engine, ..) = engine(true, false);
    let (ends, mut gateway, mut recorder) = rings(&engine.scene, 1, 60);
    let shared = Arc::new(Shared::default());
    let every = RecordIntervals { energy: 30, view: 50, hash: 3000 };
    let mut live = Live::new(engine, ends, shared.clone(), Clock::Device { patience: 0 }, every);
    let mut frame = DeviceFrame::new("hand", 2);
    frame.session = 1;
    let mut lost = 0;
    // the rings hold four seconds and nothing reads them: the first run fits, the second does not
    for frames in [1000, 24_000] {
        let n = calls(|| {
            for _ in 0..frames {
                frame.seq += 1;
                let _ = gateway.frames.push((0, frame));
                live.frame();
                while gateway.forces.pop().is_ok() {}
            }
        });
        assert_eq!(n, 0, "{frames} frames");
        assert_eq!(lost, 0, "the first thousand had room");
        lost = [&shared.lost_records, &shared.lost_sound, &shared.lost_views].map(|n| n.load(Relaxed)).iter().sum();
    }
    assert!(lost > 100_000, "nothing was too much");
    // more commands than the ring holds: boxes come back or wait, and are not freed here
    for _ in 0..3 {
        while recorder.commands.push((0, EngineCommand::Set(Box::<Change>::default()))).is_ok() {}
        assert_eq!(calls(|| live.frame()), 0, "boxes are freed elsewhere");
    }
}
