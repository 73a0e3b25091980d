//! Tests both sides with simulated devices. Time is a number here, so the test sets every delay.

use super::*;
use crate::serve::audio::device_clock::lead;

const RATE: f64 = 48_000.0;
const R: u64 = 16;

/// An engine and a device in simulated time.
struct FakeDevice {
    follow: DeviceClock,
    player: Player,
    watch: Watch,
    /// Frames that the device requests at once.
    call: usize,
    /// \[ns\]
    now: f64,
    /// When the engine's next frame is due and begins, and when the device asks next \[ns\].
    frame: Option<(f64, f64)>,
    ask: f64,
    /// Duration of a sample of the device \[ns\].
    dt: f64,
    /// Delay of the engine's wake-ups, and of calls \[ns\].
    late: fn(u64) -> f64,
    jitter: fn(u64) -> f64,
    calls: u64,
    frames: u64,
    sent: u64,
    heard: Vec<f32>,
    /// Start of each frame \[ns\].
    began: Vec<f64>,
    asks: bool,
}

fn none(_: u64) -> f64 {
    0.0
}

fn chance(k: u64) -> f64 {
    (k.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(1) >> 40) as f64 / f64::from(1 << 24)
}

/// Returns sample `n` of the sound; never 0.
fn sound(n: u64) -> f64 {
    0.25 + 0.5 * chance(n)
}

impl FakeDevice {
    fn new(call: u32, ppm: f64) -> FakeDevice {
        let who = PlaybackDevice { host: "paper".into(), device: "paper".into(), rate: RATE as u32, channels: 2 };
        let (follow, player, watch) = link(1, R as u32, who, call);
        FakeDevice {
            follow,
            player,
            watch,
            call: call as usize,
            now: 1e9,
            frame: None,
            ask: 1e9 + 3e5,
            dt: 1e9 / RATE / (1.0 + ppm * 1e-6),
            late: none,
            jitter: none,
            calls: 0,
            frames: 0,
            sent: 0,
            heard: Vec::new(),
            began: Vec::new(),
            asks: true,
        }
    }

    fn run(&mut self, seconds: f64) {
        let end = self.now + seconds * 1e9;
        while self.now < end {
            let frame = *self.frame.get_or_insert_with(|| {
                self.follow.read_calls(self.now as u64);
                let due = self.follow.due();
                // a frame that need not wait is not late
                (due, if due > self.now { due + (self.late)(self.frames) } else { self.now })
            });
            let call = if self.asks { self.ask + (self.jitter)(self.calls) } else { f64::MAX };
            self.now = self.now.max(frame.1.min(call));
            if frame.1 <= call {
                self.follow.begin(frame.0, self.now as u64);
                let n = if self.frames == 0 { 1 } else { R };
                let block: Vec<f64> = (self.sent..self.sent + n).map(sound).collect();
                self.follow.put(&block);
                self.sent += n;
                self.frames += 1;
                self.began.push(self.now);
                self.frame = None;
            } else {
                let mut out = vec![9.0; 2 * self.call];
                self.player.fill(&mut out, 2, self.now as u64);
                for both in out.chunks(2) {
                    assert_eq!(both[0], both[1], "one channel is heard on both sides");
                    self.heard.push(both[0]);
                }
                self.calls += 1;
                self.ask += self.call as f64 * self.dt;
            }
        }
    }

    fn first(&self) -> usize {
        self.heard.iter().position(|x| *x != 0.0).expect("something was heard")
    }

    fn reported(&mut self) -> AudioSummary {
        self.watch.take_messages();
        self.watch.summary()
    }
}

/// With another device rate, late calls and late wake-ups, each sample is played once, in order and bit for bit.
#[test]
fn a_steady_device_hears_every_sample() {
    for (call, ppm) in [(64, -800.0), (64, 90.0), (256, 1000.0), (1024, -40.0)] {
        let mut h = FakeDevice::new(call, ppm);
        h.late = |k| 3e5 * chance(k);
        h.jitter = |k| 4e5 * chance(k + 7);
        h.run(30.0);
        let reported = h.reported();
        assert!(reported.is_faithful(), "{reported:?}");
        let first = h.first();
        for (n, x) in h.heard[first..].iter().enumerate() {
            assert_eq!(*x, sound(n as u64) as f32, "{n}");
        }
        // the device is the clock: frames cover the requested samples and the lead
        let asked = h.heard.len() as f64 - first as f64;
        let ahead = h.sent as f64 - asked;
        let lead = lead(call, R as u32, RATE) as f64;
        assert_eq!(reported.lead as f64, lead);
        // between two calls: the lead, less the samples just taken, and less delays of wake-ups and calls
        assert!(ahead > lead - f64::from(call) - 64.0 && ahead < lead + 64.0, "{ahead} of {lead}");
        assert!((reported.ppm - ppm).abs() < 2.0, "{} for {ppm}", reported.ppm);
        // after the start, frames are due half to two periods apart, and wake-ups may be late
        let late = |w: &[f64]| (w[1] - w[0]) * 1e-9 * RATE / R as f64;
        assert!(h.began.windows(2).skip(100).all(|w| (-0.1..4.0).contains(&late(w))));
    }
}

/// The engine stalls for longer than the lead: the gap is counted at its sample, and sound continues bit for bit.
#[test]
fn a_gap_is_counted_and_heard_as_a_fade() {
    let mut h = FakeDevice::new(64, 0.0);
    h.late = |k| if k == 6000 { 2e7 } else { 0.0 };
    h.run(4.0);
    let reported = h.reported();
    assert_eq!(
        (reported.underruns, reported.gaps.len(), reported.skipped, reported.xruns, reported.stops),
        (1, 1, 0, 0, 0),
        "{reported:?}"
    );
    assert!(!reported.is_faithful());
    // 20 ms, less what the ring held
    assert!((640..960).contains(&reported.silent), "{reported:?}");
    let (first, gap) = (h.first(), reported.gaps[0] as usize);
    let before = &h.heard[first..first + gap];
    assert!(before.iter().enumerate().all(|(n, x)| *x == sound(n as u64) as f32));
    let silence = &h.heard[first + gap..first + gap + reported.silent as usize];
    let fade = (0.001 * RATE) as usize;
    // a linear fade from the last sample to zero
    for (k, x) in silence.iter().enumerate() {
        let want = before[gap - 1] * (1.0 - (k + 1) as f32 / fade as f32).max(0.0);
        assert!((x - want).abs() < 1e-5, "{k}: {x}, not {want}");
    }
    let after = &h.heard[first + gap + reported.silent as usize..];
    for (k, x) in after.iter().enumerate() {
        let want = sound((gap + k) as u64) as f32;
        if k < fade {
            assert!((x - want * k as f32 / fade as f32).abs() < 1e-5, "{k}");
        } else if k > fade {
            assert_eq!(*x, want, "{k}");
        }
    }
    // the lead is restored
    let ahead = h.sent as i64 - (h.heard.len() - first) as i64 + reported.silent as i64;
    assert!((64..=160).contains(&ahead), "{ahead}");
}

/// If the device stops asking, frames continue at its last rate. Then old sound is left out, and the lead is restored.
#[test]
fn forces_do_not_depend_on_a_sound_device() {
    let ppm = 500.0;
    let mut h = FakeDevice::new(64, ppm);
    h.run(5.0);
    h.asks = false;
    let (at, frames) = (h.now, h.frames);
    h.run(3.0);
    assert_eq!(h.reported().stops, 1);
    assert!(!h.watch.counts.alive.load(Relaxed));
    let rate = RATE / R as f64 * (1.0 + ppm * 1e-6);
    let want = (h.now - at) * 1e-9 * rate;
    // frames may come at half the rate for 0.1 s, until the stop is detected
    assert!(((h.frames - frames) as f64 - want).abs() < 0.06 * rate, "{} of {want}", h.frames - frames);
    let (at, frames) = (h.now, h.frames);
    h.run(1.0);
    let want = (h.now - at) * 1e-9 * rate;
    assert!(((h.frames - frames) as f64 - want).abs() < 1.5, "{} of {want}", h.frames - frames);
    (h.asks, h.ask) = (true, h.now + 1e6);
    let heard = h.heard.len();
    h.run(2.0);
    let reported = h.reported();
    assert!(h.watch.counts.alive.load(Relaxed));
    assert!(reported.skipped > 0 && reported.unheard > 0 && reported.stops == 1, "{reported:?}");
    // each sample was played, left out or did not fit; the rest is the lead, less the samples just taken
    let silent = (h.heard.len() - h.first()) as i64 - reported.silent as i64;
    let rest = h.sent as i64 - silent - (reported.skipped + reported.unheard) as i64;
    assert!((reported.lead as i64 - 128..=reported.lead as i64 + 64).contains(&rest), "{rest}: {reported:?}");
    assert!(h.heard.len() - heard > 90_000);
    let period = 1e9 / rate;
    let steps = |w: &[f64]| (w[1] - w[0]) / period;
    assert!(h.began.windows(2).skip(1).all(|w| (0.49..2.01).contains(&steps(w))), "never a jump of the frames");
}

/// The device stalls, then asks for all of that time at once: the lead stays within the ring, and sound continues.
#[test]
fn a_device_that_makes_up_for_a_stall_is_heard_again() {
    let mut h = FakeDevice::new(256, 0.0);
    h.run(2.0);
    let n = h.sent;
    h.asks = false;
    h.run(0.7);
    (h.asks, h.ask) = (true, h.now + 1e6);
    h.call = 33_600;
    let calls = h.calls;
    while h.calls == calls {
        h.run(1e-3);
    }
    (h.call, h.ask) = (256, h.now + 5e6);
    h.run(2.0);
    let unheard = h.reported().unheard;
    let heard = h.heard.len();
    h.run(2.0);
    let reported = h.reported();
    assert_eq!(reported.unheard, unheard, "all finds room again: {reported:?}");
    let mut next = (n..h.sent).find(|k| sound(*k) as f32 == h.heard[heard]).expect("it plays");
    for x in &h.heard[heard..] {
        assert_eq!(*x, sound(next) as f32, "{next}");
        next += 1;
    }
    assert!(h.sent - next <= reported.lead + 64 && reported.lead < 48_000 / 8, "{reported:?}");
}

/// Each channel of the scene goes to its channel of the device; further channels of the device get silence.
#[test]
fn channels_go_where_they_belong() {
    for (channels, wide, want) in
        [(1, 1, vec![1.0]), (1, 4, vec![1.0, 1.0, 0.0, 0.0]), (2, 2, vec![1.0, 2.0]), (3, 4, vec![1.0, 2.0, 3.0, 0.0])]
    {
        let (mut follow, mut player, _) =
            link(channels, R as u32, PlaybackDevice { rate: 48_000, ..PlaybackDevice::default() }, 8);
        let frame: Vec<f64> = (1..=channels).map(|c| c as f64).collect();
        follow.put(&frame.repeat(500));
        let mut out = vec![9.0; 8 * wide];
        player.fill(&mut out, wide, 1);
        assert_eq!(out, want.repeat(8), "{channels} on {wide}");
    }
}

/// At the end the rest is played, and the silence after it is not a gap.
#[test]
fn the_end_is_no_underrun() {
    let FakeDevice { mut follow, mut player, mut watch, .. } = FakeDevice::new(64, 0.0);
    follow.put(&[0.5; 100]);
    drop(follow);
    let mut heard = Vec::new();
    while !watch.counts.done.load(Relaxed) {
        let mut out = [9.0; 128];
        player.fill(&mut out, 2, 1);
        heard.extend_from_slice(&out);
        assert!(heard.len() < 10_000);
    }
    assert!(heard[..200].iter().all(|x| *x == 0.5) && heard[200..].iter().all(|x| x.abs() < 0.5));
    watch.take_messages();
    assert!(watch.summary().is_faithful(), "{:?}", watch.summary());
}
