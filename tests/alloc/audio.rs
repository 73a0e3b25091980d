//! Checks that the engine and the callback of a sound device allocate nothing per frame.
//!
//! Each runs on its own thread. The start and end of a run take the same number of allocator calls whatever its length.

use super::calls;
use ca_compile::{Options as Compile, compile};
use ca_haptic::engine::{Engine, Options};
use ca_haptic::rt::now_ns;
use ca_haptic::serve::audio::{PlaybackDevice, link, outlet};
use ca_haptic::serve::{Clock, Live, RecordIntervals, Shared, rings};
use ca_model::read;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

const TEXT: &str = "[CEL]\nbar = { m = \"1 g\", f = \"220 Hz\", dx0 = \"1 mm\" }\n[SOX]\nout = { from = \"bar\" }\n";

/// Allocator calls of the engine and of the device thread in a run of `frames` frames. The device pauses now and then.
/// With `change`, another device is linked before the first frame.
fn run(frames: u64, change: bool) -> (u64, u64) {
    let catalog = ca_tests::catalog();
    let (model, _) = read::read(TEXT, "bar.ca.toml", &catalog);
    let scene = Arc::new(compile(&model, &catalog, &Compile::default()).expect("it compiles").scene);
    let engine = Engine::new(scene.clone(), vec![], Options::default());
    let (mut ends, _gateway, _recorder) = rings(&scene, 0, 0);
    let who = PlaybackDevice { rate: 48_000, channels: 2, ..PlaybackDevice::default() };
    let before = link(scene.counts.channels, scene.rates.ratio, who.clone(), 64);
    let (follow, mut player, watch) = link(scene.counts.channels, scene.rates.ratio, who, 64);
    let patch = if change {
        let (outlet, mut patch) = outlet(Some(before.0));
        assert!(patch.put(Some(follow)));
        ends.audio = Some(outlet);
        patch
    } else {
        let (outlet, patch) = outlet(Some(follow));
        ends.audio = Some(outlet);
        patch
    };
    let counts = watch.counts.clone();
    let device = std::thread::spawn(move || {
        let mut out = [0.0; 128];
        let (mut fills, mut n) = (0, 0);
        while !counts.done.load(Relaxed) {
            std::thread::sleep(Duration::from_micros(1300));
            // regularly pauses for 150 ms, then asks twice in a row
            if fills % 100 == 99 {
                std::thread::sleep(Duration::from_millis(150));
                n += calls(|| player.fill(&mut out, 2, now_ns()));
            }
            n += calls(|| player.fill(&mut out, 2, now_ns()));
            fills += 1;
        }
        n
    });
    let live = Live::new(engine, ends, Arc::new(Shared::default()), Clock::Audio, RecordIntervals::default());
    let n = calls(|| assert_eq!(live.run(Some(frames)).counts.frames, frames + 1));
    let device = device.join().expect("no panic");
    // frees what the engine returned
    drop(patch);
    (n, device)
}

#[test]
fn a_sound_device_allocates_nothing() {
    let (short, long) = (run(3, false), run(3000, false));
    assert_eq!(short.0, run(3, true).0, "a change of the device");
    assert_eq!(short.0, long.0, "the engine");
    assert_eq!((short.1, long.1), (0, 0), "the device");
}
