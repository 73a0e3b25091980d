//! Tests suspended, killed and restarted processes: H5 to H8 through shared memory, counted in frames.

use crate::force_watcher::{ForceWatcher, key};
use crate::sandbox::{KEY, Sandbox, until};
use ca_haptic::frame::{Cause, ForceFrame, Mode, flag};
use ca_haptic::host::control::Request;

/// Number of frames in a time at 3 kHz, rounded up.
fn frames(seconds: f64) -> u64 {
    (3000.0 * seconds).ceil() as u64
}

/// Frames after the last device frame, with their minimum age in frames.
fn aged(frames: &[ForceFrame]) -> impl Iterator<Item = (u64, &ForceFrame)> {
    let last = frames.last().unwrap();
    let silent = frames.iter().filter(move |f| (f.session, f.ack) == (last.session, last.ack));
    // the frame that first used the last position has age 0; if it was not seen, true ages are larger
    let first = silent.clone().next().unwrap().seq;
    silent.map(move |f| (f.seq - first, f))
}

#[test]
fn h5_a_hand_inside_a_wall_waits() {
    let sandbox = Sandbox::new();
    let watch = ForceWatcher::of(&sandbox.site, "key");
    // 5 mm into 500 N/m: 2.5 N
    sandbox.put("wall.ca.toml", &KEY.replace("0.9 mm", "5 mm"));
    let _server = sandbox.serve("wall.ca.toml", &["--quiet", "--arm"]);
    let _device = sandbox.key(&["--script", "hold"]);
    until("it waits", || {
        sandbox.armed("it waits", |mode, cause| mode == "off" && cause == "NONE");
        watch.count() > 6000
    });
    let seen = watch.end(&key());
    assert!(seen.frames.iter().all(|f| f.force[0] == 0.0 && Mode::read(f.mode) != Mode::On));
    let waits = seen.frames.iter().filter(|f| f.flags & flag::WAIT_CLEAR != 0).count();
    assert!(waits > 1000, "{waits}");
}

#[test]
fn h6_h8_a_suspended_device_is_zero_force_and_stays_so() {
    let sandbox = Sandbox::new();
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let server = sandbox.serve("key.ca.toml", &["--json"]);
    let device = sandbox.key(&["--script", "hold"]);
    // on a stalled machine, another fault may come first
    let noticed = (0..5).any(|_| {
        sandbox.on();
        device.signal("STOP");
        until("the server notices", || sandbox.state().0 == "fault");
        let noticed = sandbox.state().1 == "WATCHDOG_IN";
        if !noticed {
            device.signal("CONT");
        }
        noticed
    });
    assert!(noticed, "{:?}", sandbox.state());
    let count = watch.count();
    until("it goes on without", || watch.count() > count + 600);
    let silent = watch.last().unwrap();
    // the device resumes, and no order to arm is given
    let before = sandbox.state().2;
    device.signal("CONT");
    // takes all values from one answer, because the next request may fail on a stalled machine
    let mut state = sandbox.state();
    until("it speaks again", || {
        state = sandbox.state();
        state.2 > before + 900
    });
    let (mode, cause, _) = state;
    assert_eq!((mode.as_str(), cause.as_str()), ("fault", "WATCHDOG_IN"));
    sandbox.on();
    let seen = watch.end(&key());
    let end = seen.frames.iter().position(|f| f.seq == silent.seq).unwrap() + 1;
    let zero = frames(key().guard.zero);
    let old = aged(&seen.frames[..end]).filter(|(age, _)| *age >= zero).collect::<Vec<_>>();
    assert!(old.len() > 200, "{}", old.len());
    for (age, f) in old {
        assert!(Mode::read(f.mode) == Mode::Fault && f.force[0] == 0.0, "{age} frames after the last position: {f:?}");
        assert_eq!(Cause::read(f.cause), Cause::WatchdogIn);
    }
    // frames of the resumed device do not change the fault
    let back = &seen.frames[end..];
    let fresh = back.iter().filter(|f| f.ack > silent.ack && Mode::read(f.mode) == Mode::Fault).count();
    assert!(fresh > 300, "{fresh} frames at fault with a device that speaks");
    assert!(server.stop().json()["faults"].as_array().unwrap().iter().any(|f| f["cause"] == "WATCHDOG_IN"));
}

#[test]
fn h8_a_killed_device_is_another_one_when_it_comes_back() {
    let sandbox = Sandbox::new();
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let device = sandbox.key(&["--script", "hold"]);
    sandbox.on();
    device.kill();
    until("the server notices", || sandbox.state().0 == "fault");
    let dead = watch.last().unwrap();
    let before = sandbox.state().2;
    let _device = sandbox.key(&["--script", "hold"]);
    until("another one speaks", || sandbox.state().2 > before + 900);
    assert_eq!(sandbox.state().0, "fault", "its coming back arms nothing");
    sandbox.on();
    let seen = watch.end(&key());
    let other = seen.frames.iter().find(|f| f.ack > 0 && f.ack_session != dead.ack_session).unwrap().ack_session;
    let mut of_other = seen.frames.iter().filter(|f| f.ack_session == other);
    let off = of_other.clone().take_while(|f| Mode::read(f.mode) == Mode::Fault).count();
    assert!(off > 300, "{off}");
    assert!(of_other.any(|f| f.force[0] != 0.0), "armed, it is played");
}

/// Lines of the device log: sequence number of the force, mode, cause, and applied force.
fn log(text: &str) -> Vec<(u64, String, String, f64)> {
    text.lines()
        .skip(1)
        .map(|l| {
            let c: Vec<&str> = l.split(',').collect();
            (c[2].parse().unwrap(), c[4].into(), c[5].into(), c[8].parse().unwrap())
        })
        .collect()
}

#[test]
fn h7_a_killed_server_is_zero_force_at_the_device_and_the_next_one_is_taken() {
    let sandbox = Sandbox::new();
    let device = sandbox.key(&["--script", "hold", "--force-log", "felt.csv"]);
    let server = sandbox.serve("key.ca.toml", &["--quiet"]);
    sandbox.on();
    let noticed = || device.stderr().matches("WATCHDOG_OUT").count();
    let ones = noticed();
    server.kill();
    until("the device notices", || noticed() > ones);
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let before = sandbox.state().2;
    until("the same device plays", || sandbox.state().2 > before + 300);
    assert_eq!(sandbox.state().0, "off");
    sandbox.on();
    let before = sandbox.state().2;
    until("for a while", || sandbox.state().2 > before + 300);
    device.stop().is(0).says(&["the engine changed 1 times", "WATCHDOG_OUT"]);
    let log = log(&sandbox.read("felt.csv"));
    // the last force of the first server; sequence numbers then restart
    let new = log.windows(2).position(|w| w[1].0 < w[0].0).unwrap() + 1;
    let last = log[..new].iter().rposition(|l| l.0 != log[new - 1].0).unwrap() + 1;
    let felt = log[last..new].iter().rposition(|l| l.3 != 0.0).map_or(0, |k| k + 1);
    // a force that expires is still held to the end of its frame
    assert!(felt as u64 <= frames(key().guard.ttl) + 2, "{felt} frames of force after the last word of the server");
    assert!(log[last..new].iter().any(|l| l.2 == "WATCHDOG_OUT"));
    assert!(log[..last].iter().any(|l| l.3 != 0.0), "there were forces before");
    assert!(log[new..].iter().any(|l| l.3 != 0.0), "and with the next server");
    // the next server begins at rest
    let first = log[new..].iter().position(|l| l.3 != 0.0).unwrap();
    assert!(first > 30, "{first}");
}

#[test]
fn disarm_is_zero_at_once_and_arm_fades_in() {
    let sandbox = Sandbox::new();
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let _device = sandbox.key(&["--script", "hold"]);
    for _ in 0..2 {
        sandbox.on();
        sandbox.ca(&["disarm", "key"]).is(0).says(&["key", "forces off"]);
        until("forces are off", || sandbox.state().0 == "off" && sandbox.state().1 == "DISARMED");
        let count = watch.count();
        until("for a while", || watch.count() > count + 100);
    }
    sandbox.ca(&["arm", "kye"]).is(1).says(&["no device `kye`", "`key`"]);
    sandbox.ca(&["arm"]).is(0);
    let seen = watch.end(&key());
    let ramp = seen.of(Mode::Ramp).count();
    assert!(ramp > 100, "{ramp} frames of two ramps of 300 were seen");
    assert!(seen.of(Mode::On).any(|f| (f.force[0] - 0.45).abs() < 0.1), "about 0.45 N once on");
}

#[test]
fn a_second_server_and_a_second_device_are_refused() {
    let sandbox = Sandbox::new();
    let server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let busy = sandbox.ca(&["serve", "key.ca.toml", "--seconds", "1"]).is(1);
    busy.says(&["a server is already running at", &server.id().to_string(), "CA_SHM_ROOT"]);
    let device = sandbox.key(&["--script", "hold"]);
    until("it speaks", || sandbox.state().2 > 100);
    let busy = sandbox.key(&["--seconds", "1"]).end().is(1);
    busy.says(&["already has a device", &device.id().to_string()]);
    let frames = sandbox.state().2;
    until("the first ones go on", || sandbox.state().2 > frames + 300);
}

/// Three models with devices are open at the same time. The device plays with the first and then with the second.
#[test]
fn a_second_page_plays_beside_the_first_and_gets_the_device_when_that_one_ends() {
    let sandbox = Sandbox::new();
    let play = |model: &str| {
        let page = sandbox.spawn(&["play", model, "--no-open", "--port", "0", "--audio", "page"]);
        until("the page is there", || page.stderr().contains("play it at http"));
        page
    };
    let first = play("hammer_piano");
    let second = play("piano_key");
    let third = play("key.ca.toml");
    assert!(
        second.stderr().contains("`ca arm` and `ca disarm` cannot control this performance"),
        "{}",
        second.stderr()
    );
    drop(third);
    let device = sandbox.spawn(&["device", "sim", "--profile", "tgr12", "--seconds", "600"]);
    until("the first has it", || first.stderr().contains("tgr12: connected"));
    until("the second says so", || second.stderr().contains("`tgr12` already has a server"));
    assert!(second.stderr().contains(&format!("process {}", first.id())), "{}", second.stderr());
    assert!(!second.stderr().contains("tgr12: connected"), "{}", second.stderr());
    let told = first.stop();
    assert!(!told.err.contains("already has a server"), "{}", told.err);
    until("then the second has it", || second.stderr().contains("tgr12: connected"));
    drop((device, second));
}

#[test]
fn several_parameters_change_in_one_tick() {
    let sandbox = Sandbox::new();
    // two springs to opposite sides: the forces cancel while the stiffnesses are equal
    sandbox.put(
        "two.ca.toml",
        r#"
[param]
up = { value = 100, unit = "N/m", live = true, min = 10, max = 1000 }
down = { value = 100, unit = "N/m", live = true, min = 10, max = 1000 }
[TGR]
key = { device = "key", dof = 0 }
[SOL]
high = { x = "1 mm" }
low = { x = "-1 mm" }
[RES]
a = { between = ["key", "high"], k = "up", l0 = 0 }
b = { between = ["key", "low"], k = "down", l0 = 0 }
"#,
    );
    // without noise and forces, a bare device does not move
    let quiet = crate::sandbox::PROFILE.replace("[guard]", "step = 0\nnoise = 0\n[guard]");
    sandbox.put("c/profiles/key.toml", &quiet);
    let watch = ForceWatcher::of(&sandbox.site, "key");
    let _server = sandbox.serve("two.ca.toml", &["--quiet"]);
    let _device = sandbox.key(&["--script", "hold"]);
    sandbox.on();
    for k in [300, 20, 500, 700, 100] {
        let (up, down) = (format!("up={k}"), format!("down={k} N/m"));
        sandbox.ca(&["set", &up, &down]).is(0);
    }
    // if one value is refused, none is set
    sandbox.ca(&["set", "up=200", "down=2000"]).is(1);
    sandbox.ca(&["set"]).is(0).says(&["up = 100", "down = 100"]);
    let last = watch.last().unwrap().seq;
    until("frames pass", || watch.last().unwrap().seq > last + 100);
    let before = watch.last().unwrap().seq;
    sandbox.ca(&["set", "up=200"]).is(0);
    until("one alone is felt", || watch.last().unwrap().force[0] > 0.05);
    let params = sandbox.ask(&Request::Status).unwrap().fields["params"].clone();
    assert!(params.as_array().unwrap().iter().any(|p| p["name"] == "up" && p["value"] == 200.0), "{params}");
    let seen = watch.end(&key());
    let together = seen.of(Mode::On).filter(|f| f.seq <= before);
    // two equal forces of up to 0.7 N cancel except for rounding
    let most = together.map(|f| f.force[0].abs()).fold(0.0, f32::max);
    assert!(most < 1e-9, "{most} N while both were set together");
}
