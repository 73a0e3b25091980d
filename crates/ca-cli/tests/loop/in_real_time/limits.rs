//! Tests limits of the guard on the forces sent: H4, H11, H13, and each cause of H14 that a device can report, through
//! shared memory. Positions are functions of the frame number, so the `ack` of a force gives its expected value in
//! closed form.

use crate::faulty_device::FaultyDevice;
use crate::force_watcher::{ForceWatcher, Seen};
use crate::sandbox::{PROFILE, Sandbox, until};
use ca_haptic::frame::{Cause, DeviceFrame, Mode, flag, status};
use ca_haptic::profile::Profile;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// A spring from the key to a distant point, with a live stiffness that begins at zero.
fn spring(far: &str, most: f64) -> String {
    format!(
        "[param]\nk = {{ value = 0, unit = \"N/m\", live = true, min = 0, max = {most} }}\n\
         [TGR]\nkey = {{ device = \"key\", dof = 0 }}\n[SOL]\nfar = {{ x = \"{far}\" }}\n\
         [RES]\ns = {{ between = [\"key\", \"far\"], k = \"k\", l0 = 0 }}\n"
    )
}

/// A sandbox with that model and a key with additional profile entries.
fn sandbox(model: &str, root: &str, guard: &str) -> (Sandbox, Profile) {
    let sandbox = Sandbox::new();
    let text = PROFILE.replace("dof = 1", &format!("dof = 1\n{root}")) + guard;
    sandbox.put("c/profiles/key.toml", &text).put("key.ca.toml", model);
    (sandbox, Profile::read(&text, "key").unwrap())
}

/// Frames in mode on, with a fresh position and a flag.
fn with(seen: &Seen, bit: u32) -> Vec<(u64, f64)> {
    seen.of(Mode::On).filter(|f| f.flags & (bit | flag::STALE) == bit).map(|f| (f.ack, f64::from(f.force[0]))).collect()
}

#[test]
fn h4_motors_stay_within_their_rating() {
    let (sandbox, p) = sandbox(&spring("1 m", 20.0), "continuous = 3.0", "");
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let _device = FaultyDevice::moving(&sandbox.site, "key", |_, _| {});
    let count = watch.count();
    until("four seconds of it", || {
        // time at rest is harmless if forces went off meanwhile
        if sandbox.state().0 != "on" {
            sandbox.ca(&["set", "k=0 N/m"]).is(0);
            sandbox.on();
            sandbox.ca(&["set", "k=10 N/m"]).is(0);
        }
        watch.count() > count + 15_000
    });
    let seen = watch.end(&p);
    // computed independently: exponential mean square over one second of the forces sent
    let (mut heat, mut worst, mut last) = (0.0_f64, 0.0_f64, None);
    for f in &seen.frames {
        let apart = last.map_or(1, |s: u64| f.seq.saturating_sub(s));
        heat += (1.0 - (-(apart as f64) / 3000.0).exp()) * (f64::from(f.force[0]).powi(2) - heat);
        (worst, last) = (worst.max(heat.sqrt()), Some(f.seq));
    }
    assert!(worst <= 3.0 * (1.0 + 1e-3), "{worst} N r.m.s. over a second");
    assert!(worst > 2.9, "it was never warm: {worst} N");
    assert!(seen.frames.iter().any(|f| f.force[0] > 9.99), "full force for a moment");
    assert!(with(&seen, flag::THERMAL).len() > 1000);
}

#[test]
fn h11_the_edge_of_the_travel_is_soft() {
    let (sandbox, p) = sandbox(&spring("0 m", 20.0), "", "passivity = false\ncoupling = false\n");
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let place = |n: u64| 0.0099 * (std::f64::consts::TAU * 0.2 * n as f64 / 3000.0).sin();
    let _device = FaultyDevice::moving(&sandbox.site, "key", move |n, f| f.pos[0] = place(n));
    until("both edges are felt", || {
        sandbox.on();
        let edges = with(&watch.so_far(), flag::EDGE);
        edges.iter().any(|f| f.1 > 8.0) && edges.iter().any(|f| f.1 < -8.0)
    });
    let seen = watch.end(&p);
    // ten newtons over the last millimetre
    for (ack, force) in with(&seen, flag::EDGE) {
        let x = place(ack);
        let want = -1e4 * (x.abs() - 0.009).max(0.0) * x.signum();
        assert!((force - want).abs() < 1e-3, "at {x} m: {force} N, not {want} N");
    }
    let free: Vec<f32> = seen.of(Mode::On).filter(|f| f.flags & flag::EDGE == 0).map(|f| f.force[0]).collect();
    assert!(free.len() > 1000 && free.iter().all(|f| *f == 0.0));
}

#[test]
fn h13_an_oscillation_is_weakened() {
    let (sandbox, p) = sandbox(&spring("0 m", 9000.0), "", "passivity = false\ncoupling = false\n");
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    // one second at rest, then half a second at 60 Hz: 0.38 m/s, and 5 N with 5 kN/m
    let burst = |n: u64| (n % 4500).checked_sub(3000);
    let place = move |n: u64| burst(n).map_or(0.0, |b| 1e-3 * (std::f64::consts::TAU * b as f64 / 50.0).sin());
    let _device = FaultyDevice::moving(&sandbox.site, "key", move |n, f| f.pos[0] = place(n));
    sandbox.on();
    sandbox.ca(&["set", "k=5 kN/m"]).is(0);
    // the end of a burst, long after its detection
    let late = |f: &&(u64, f64)| burst(f.0).is_some_and(|b| b > 600);
    until("it is noticed", || {
        sandbox.on();
        with(&watch.so_far(), flag::OSCILLATION).iter().filter(late).count() > 600
    });
    let seen = watch.end(&p);
    let weak: Vec<_> = with(&seen, flag::OSCILLATION).into_iter().filter(|f| late(&f)).collect();
    // the force of a frame is its mean, close to the mean of two positions; on a busy machine, positions may be older
    let mean = |ack: u64| -0.3 * 5e3 * 0.5 * (place(ack) + place(ack - 1));
    let near = weak.iter().filter(|(ack, f)| (0..3).any(|late| (f - mean(ack - late)).abs() < 0.1)).count();
    assert!(near * 4 >= weak.len() * 3, "{near} of {}", weak.len());
    assert!(weak.iter().all(|f| f.1.abs() < 0.3 * 5.0 * 1.001), "none is stronger");
    let before = seen.of(Mode::On).filter(|f| f.flags & flag::OSCILLATION == 0);
    assert!(before.map(|f| f.force[0].abs()).fold(0.0, f32::max) > 4.9, "it was felt before");
}

/// Changes the state that a device reports.
type Say = fn(&mut DeviceFrame);

#[test]
fn h14_what_a_device_says_of_itself_ends_forces_with_its_cause() {
    const SAID: [(Say, Cause); 7] = [
        (|f| f.status |= status::DEADMAN, Cause::Deadman),
        (|f| f.status |= status::THERMAL, Cause::Thermal),
        (|f| f.status &= !status::CONNECTED, Cause::Disconnect),
        (|f| f.status &= !status::CALIBRATED, Cause::Implausible),
        (|f| f.cause = Cause::Button as u16, Cause::Button),
        (|f| f.cause = Cause::Software as u16, Cause::Software),
        (|f| f.cause = Cause::Velocity as u16, Cause::Velocity),
    ];
    let sandbox = Sandbox::new();
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let says = Arc::new(AtomicUsize::new(SAID.len()));
    let what = says.clone();
    let good = DeviceFrame::new("key", 1);
    let _device = FaultyDevice::moving(&sandbox.site, "key", move |_, f| {
        (f.status, f.cause) = (good.status, good.cause);
        if let Some((say, _)) = SAID.get(what.load(Relaxed)) {
            say(f);
        }
    });
    for (k, (_, cause)) in SAID.iter().enumerate() {
        until(cause.name(), || {
            says.store(SAID.len(), Relaxed);
            sandbox.on();
            says.store(k, Relaxed);
            until("forces are off", || sandbox.state().0 == "fault");
            sandbox.state().1 == cause.name()
        });
        // the fault persists after the device recovers
        says.store(SAID.len(), Relaxed);
        let frames = sandbox.state().2;
        until("frames come", || sandbox.state().2 > frames + 300);
        let (mode, now, _) = sandbox.state();
        assert_eq!((mode.as_str(), now.as_str()), ("fault", cause.name()));
    }
    let seen = watch.end(&crate::force_watcher::key());
    for (_, cause) in SAID {
        assert!(seen.faults().contains(&cause), "{cause:?}: {:?}", seen.faults());
    }
}
