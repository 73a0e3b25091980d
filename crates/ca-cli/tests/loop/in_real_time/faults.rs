//! Tests faulty models and devices through shared memory. A watcher checks every force on the line.

use crate::faulty_device::FaultyDevice;
use crate::force_watcher::{ForceWatcher, key};
use crate::long_form::long_form;
use crate::random_device::RandomDevice;
use crate::sandbox::{KEY, Sandbox, until};
use ca_haptic::frame::{Cause, Mode};
use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

#[test]
fn h9_a_throw_brakes_and_ends() {
    let sandbox = Sandbox::new();
    // a weak spring, so nothing pushes at either end
    sandbox.put("weak.ca.toml", &KEY.replace("0.9 mm", "0 mm").replace("k = 500", "k = 10"));
    // 15 mm in 20 ms every 1.5 s: half as fast again as the trip limit, but below the implausible speed. Some throws
    // happen with forces on.
    let mut throws = String::from("time,key\n0,-0.0075\n");
    for k in 0..40 {
        let t = 1.5 * f64::from(k) + 3.0;
        let [a, b] = if k % 2 == 0 { [-0.0075, 0.0075] } else { [0.0075, -0.0075] };
        writeln!(throws, "{t},{a}\n{},{b}", t + 0.02).unwrap();
    }
    sandbox.put("throw.csv", &throws);
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let server = sandbox.serve("weak.ca.toml", &["--json"]);
    let _device = sandbox.key(&["--script", "file", "--gesture", "throw.csv"]);
    sandbox.armed("it trips", |mode, cause| mode == "fault" && cause == "VELOCITY");
    let count = watch.count();
    until("it stays so", || watch.count() > count + 300);
    assert_eq!(sandbox.state().1, "VELOCITY");
    let reported = server.stop().json();
    assert!(reported["faults"].as_array().unwrap().iter().any(|f| f["cause"] == "VELOCITY"), "{reported:#}");
    let seen = watch.end(&key());
    // The brake lasts 200 ms with 5 N s/m against 0.5 m/s; most of its 600 frames are seen. Uses the last brake,
    // because another fault may have ended an earlier one.
    let modes = seen.frames.iter().rev().map(|f| (Mode::read(f.mode), f.force[0].abs()));
    let braking = modes.skip_while(|m| m.0 != Mode::Damp).take_while(|m| m.0 == Mode::Damp);
    let brake: Vec<f32> = braking.map(|m| m.1).collect();
    assert!(brake.len() > 100 && brake.len() <= 600, "{} frames of brake", brake.len());
    assert!(brake.iter().copied().fold(0.0, f32::max) > 2.0, "{brake:?}");
}

#[test]
fn h1_a_model_that_gives_no_number_is_no_force() {
    let sandbox = Sandbox::new();
    // no force within 13 cm, and beyond it forces near the largest float, whose sum over a frame overflows
    let wild = r#"
[TGR]
key = { device = "key", dof = 0 }
[SOL]
wall = {}
[LNL]
cliff = { between = ["wall", "key"], spring = [[-1, -1.4e308], [-0.13, 0], [0.13, 0], [1, 1.4e308]] }
"#;
    // without a coupling, which this cliff would need
    let long = crate::sandbox::PROFILE.replace("0.01", "0.5") + "coupling = false\n";
    sandbox.put("wild.ca.toml", wild).put("c/profiles/key.toml", &long);
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _server = sandbox.serve("wild.ca.toml", &["--quiet"]);
    // three seconds at rest, then out to 30 cm and back at 0.3 m/s, repeated
    let _device = FaultyDevice::moving(&sandbox.site, "key", |n, f| {
        let t = (n % 18_000) as f64 / 3000.0;
        f.pos[0] = (0.3 * (t - 3.0)).min(0.3 * (6.0 - t)).clamp(0.0, 0.3);
    });
    sandbox.armed("it trips", |mode, cause| mode == "fault" && (cause == "NONFINITE" || cause == "MODEL_UNSTABLE"));
    assert_eq!(sandbox.state().1, "NONFINITE");
    let p = ca_haptic::profile::Profile::read(&long, "key").unwrap();
    let seen = watch.end(&p);
    assert!(seen.faults().contains(&Cause::Nonfinite), "{:?}", seen.faults());
    // on the way, the force reached ten newtons
    let most = seen.of(Mode::On).map(|f| f.force[0].abs()).fold(0.0, f32::max);
    assert!(most > 9.9, "{most}");
}

#[test]
fn h15_h16_a_model_that_explodes_leaves_hand_and_ear() {
    let sandbox = Sandbox::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/models/exploding_resonator.ca.toml");
    sandbox.put("bang.ca.toml", &std::fs::read_to_string(root).unwrap());
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _device = sandbox.key(&["--script", "hold"]);
    let server = sandbox.serve("bang.ca.toml", &["--json", "-o", "bang.wav"]);
    // on a stalled machine, it diverged before forces were on; arming loads it again
    sandbox.armed("it diverges with forces on", |mode, cause| {
        mode == "fault" && cause == "MODEL_UNSTABLE" && watch.so_far().of(Mode::Ramp).next().is_some()
    });
    let count = watch.count();
    until("it stays so", || watch.count() > count + 300);
    let reported = server.stop().is(3).json();
    assert_eq!(reported["unstable"], true);
    let seen = watch.end(&key());
    assert_eq!(seen.frames.last().map(|f| Mode::read(f.mode)), Some(Mode::Off), "the last word of a server");
    let samples: Vec<f32> =
        hound::WavReader::open(sandbox.path("bang.wav")).unwrap().samples::<f32>().map(Result::unwrap).collect();
    let peak = samples.iter().fold(0.0_f32, |a, b| a.max(b.abs()));
    assert!(peak > 0.1 && peak <= 1.0, "{peak}");
    // silence until the end, at least 100 ms
    assert!(samples[samples.len() - 2400..].iter().all(|s| *s == 0.0));
}

#[test]
fn h10_no_frame_of_a_device_moves_a_force_beyond_its_limits() {
    let all: u64 = if long_form("nine of ten frames") { 1_000_000 } else { 100_000 };
    let sandbox = Sandbox::new();
    sandbox.put("key.ca.toml", &KEY.replace("k = 500", "k = 20000").replace("0.9 mm", "0 mm"));
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let server = sandbox.serve("key.ca.toml", &["--json"]);
    let mut device = RandomDevice::of(&sandbox.site, "key", all);
    let end = std::time::Instant::now() + Duration::from_secs(600);
    while device.sent() < all {
        assert!(std::time::Instant::now() < end && device.is_running(), "{} frames were sent", device.sent());
        sandbox.arm();
        std::thread::sleep(Duration::from_millis(100));
    }
    // after the invalid frames, the device can be played again
    sandbox.on();
    device.end();
    let reported = server.stop().json();
    let seen = watch.end(&key());
    let causes = seen.faults();
    assert!(causes.contains(&Cause::Implausible), "{causes:?}");
    let number = |k: &str| reported["traffic"][k].as_u64().unwrap();
    let (received, foreign, dropped) = (number("received"), number("foreign"), reported["dropped"].as_u64().unwrap());
    // frames overwritten in the queue are not received, but most must be
    assert!(received > all / 4 && foreign > all / 100 && dropped > all / 100, "{reported:#}");
    let (sent, watched) = (number("sent"), seen.frames.len() as u64);
    eprintln!(
        "{all} frames of anything: {received} received, {foreign} foreign, {dropped} dropped; \
         {watched} of {sent} forces seen, {} missed by number; {causes:?}",
        seen.unseen
    );
    assert!(watched <= sent && watched + seen.unseen <= reported["frames"].as_u64().unwrap(), "{reported:#}");
    // a stall of up to a third of a second is tolerated; none is expected here, so one percent is a wide margin
    assert!(watched >= sent - sent / 100, "{watched} of {sent} forces were seen");
}

#[test]
fn h8_another_session_is_another_device() {
    let sandbox = Sandbox::new();
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    // the device is replaced every two seconds within a frame
    let device = FaultyDevice::moving(&sandbox.site, "key", |n, f| {
        if n % 6000 == 0 {
            (f.session, f.seq) = (f.session + 1, 1);
        }
    });
    sandbox.armed("it is noticed", |mode, cause| mode == "fault" && cause == "DISCONNECT");
    drop(device);
    assert!(watch.end(&key()).faults().contains(&Cause::Disconnect));
}

#[test]
fn h10_forces_end_with_the_reason_that_is_true() {
    type Wrong = fn(u64, &mut ca_haptic::frame::DeviceFrame);
    let sandbox = Sandbox::new();
    let cases: [(&str, &str, Wrong); 2] = [
        ("jumps of 2 m", "IMPLAUSIBLE", |n, f| f.pos[0] = if n % 2 == 0 { 2.0 } else { 4.0 }),
        ("no position is valid", "IMPLAUSIBLE", |_, f| f.mask = 0),
    ];
    for (name, cause, wrong) in cases {
        let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
        // wrong for half a second in every four
        let _device = FaultyDevice::moving(&sandbox.site, "key", move |n, f| {
            if n % 12_000 >= 10_500 {
                wrong(n, f);
            }
        });
        sandbox.armed(name, |mode, why| mode == "fault" && why == cause);
    }
}

#[test]
fn what_is_wrong_with_frames_is_said_and_no_version_blamed() {
    type Wrong = fn(&mut ca_haptic::frame::DeviceFrame);
    let sandbox = Sandbox::new();
    let cases: [(&str, Wrong); 4] = [
        ("of another layout", |f| f.layout ^= 1),
        ("of version 9", |f| f.version = 9),
        ("have 0 degrees of freedom", |f| f.n = 0),
        ("are for `kex`", |f| f.device[2] = b'x'),
    ];
    for (want, wrong) in cases {
        let server = sandbox.serve("key.ca.toml", &[]);
        let _device = FaultyDevice::moving(&sandbox.site, "key", move |_, f| wrong(f));
        until(want, || server.stderr().contains(want));
        let said = server.stderr();
        assert_eq!(said.contains("of version 9"), want == "of version 9", "{said}");
    }
}
