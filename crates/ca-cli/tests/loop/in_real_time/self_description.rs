//! Tests devices without a profile: they describe themselves, with one or three degrees of freedom, before or after the
//! server starts. A key that presses while it is armed is named.

use crate::faulty_device::{DeviceFault, FaultyDevice};
use crate::sandbox::{Sandbox, until};
use ca_haptic::frame::{About, DOF, DeviceFrame};
use ca_haptic::host::{DeviceClient, Site};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A spring of 500 N/m from the initial position of the finger.
const FINGER: &str = r#"
[TGR]
key = { device = "finger", dof = 0 }
[SOL]
wall = {}
[RES]
spring = { between = ["key", "wall"], k = 500, l0 = 0 }
[SOX]
out = { from = "key" }
"#;

/// A device that moves as requested and stores its forces, through the client of this project.
struct TestDevice {
    stop: Arc<AtomicBool>,
    /// True to go to the end of the motion, false to go back.
    goes: Arc<AtomicBool>,
    /// Largest force so far and present force \[uN\].
    forces: Arc<[AtomicU64; 2]>,
    thread: Option<JoinHandle<()>>,
}

/// Length \[m\] and duration \[s\] of the motion.
const DEPTH: f64 = 1.5e-3;
const TIME: f64 = 0.5;

impl TestDevice {
    fn new(site: &Site, n: usize, axes: u16) -> TestDevice {
        let (stop, goes) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let forces = Arc::new([AtomicU64::new(0), AtomicU64::new(0)]);
        let (site, end, go, to) = (site.clone(), stop.clone(), goes.clone(), forces.clone());
        let thread = std::thread::spawn(move || {
            let about = About {
                axes,
                low: [-0.02; DOF],
                high: [0.02; DOF],
                force: [10.0; DOF],
                ..About::new("finger", 1000, n)
            };
            let mut device = DeviceClient::open(&site, about).unwrap();
            let (mut frame, mut way) = (DeviceFrame::new("finger", n), 0.0);
            let (start, mut due) = (Instant::now(), Instant::now());
            while !end.load(Relaxed) {
                let step = if go.load(Relaxed) { 1e-3 } else { -1e-3 };
                way = (way + step / TIME).clamp(0.0, 1.0);
                // begins and ends at rest
                frame.pos[0] = DEPTH * way * way * (3.0 - 2.0 * way);
                frame.t_device_ns = start.elapsed().as_nanos() as u64;
                device.send(&mut frame).unwrap();
                let force = device.safe_force();
                let size = (force[..n].iter().map(|f| f * f).sum::<f64>().sqrt() * 1e6) as u64;
                to[0].fetch_max(size, Relaxed);
                to[1].store(size, Relaxed);
                // after a stall, continues at its rate
                due = (due + Duration::from_millis(1)).max(Instant::now());
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
            }
        });
        TestDevice { stop, goes, forces, thread: Some(thread) }
    }

    fn forces(&self) -> [f64; 2] {
        [0, 1].map(|k| self.forces[k].load(Relaxed) as f64 * 1e-6)
    }
}

impl Drop for TestDevice {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            assert!(ended.is_ok() || std::thread::panicking());
        }
    }
}

/// Moves the finger until it receives the force of its spring.
fn press(sandbox: &Sandbox, finger: &TestDevice) {
    until("it is held", || {
        if sandbox.state().0 != "on" {
            // after a stall, forces return only while the hand presses nothing
            finger.goes.store(false, Relaxed);
            sandbox.on();
        }
        finger.goes.store(true, Relaxed);
        (finger.forces()[1] - 500.0 * DEPTH).abs() < 1e-3
    });
}

/// Keeps forces on while this machine stalls for a while, because watchdogs are not tested here.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    let unknown = include_str!("../../../../ca-haptic/profiles/unknown.toml");
    let patient = format!("{unknown}\n[guard]\nclear_time = 0.025\nramp = 0.1\nhold = 0.05\nzero = 0.09\nttl = 0.06\n");
    sandbox.put("c/profiles/unknown.toml", &patient).put("finger.ca.toml", FINGER);
    sandbox
}

#[test]
fn a_key_without_a_profile_is_felt_whoever_comes_first() {
    for server_first in [true, false] {
        let sandbox = sandbox();
        let mut finger = (!server_first).then(|| TestDevice::new(&sandbox.site, 1, 1));
        let server = sandbox.serve("finger.ca.toml", &["--json", "--log", "take.mcap"]);
        let finger = finger.get_or_insert_with(|| TestDevice::new(&sandbox.site, 1, 1));
        press(&sandbox, finger);
        let most = finger.forces()[0];
        assert!(most < 1.1 * 500.0 * DEPTH, "{most} N where the spring gives {} N", 500.0 * DEPTH);
        let ran = server.stop();
        let reported = ran.json();
        assert_eq!(reported["devices"][0]["dropped"], 0, "{reported:#}");
        assert!(ran.err.contains("finger: it reports: ") && ran.err.contains("1 degrees of freedom"), "{}", ran.err);
        // the take contains the description
        sandbox.ca(&["replay", "take.mcap", "--verify"]).is(0);
        sandbox.ca(&["report", "take.mcap", "-o", "take.html"]).is(0);
        assert!(sandbox.read("take.html").contains("1 degrees of freedom, at most 2 N"));
    }
}

#[test]
fn three_axes_of_a_device_without_a_profile_are_one_force() {
    let sandbox = sandbox();
    // 4 N on each axis, once the parameter is set
    let mut model = String::from("[param]\nk = { value = 0, unit = \"N/m\", live = true, min = 0, max = 10 }\n[TGR]\n");
    for d in 0..3 {
        model = format!("{model}p{d} = {{ device = \"finger\", dof = {d} }}\n");
    }
    model += "[SOL]\nfar = { x = \"1 m\" }\n[RES]\ns = { between = [[\"p0\", \"p1\", \"p2\"], \"far\"], k = \"k\", l0 = 0 }\n";
    sandbox.put("stylus.ca.toml", &model);
    let _server = sandbox.serve("stylus.ca.toml", &["--quiet"]);
    let finger = TestDevice::new(&sandbox.site, 3, 3);
    until("all it gives", || {
        if sandbox.state().0 != "on" {
            sandbox.ca(&["set", "k=0 N/m"]).is(0);
            sandbox.on();
            sandbox.ca(&["set", "k=4 N/m"]).is(0);
        }
        finger.forces()[1] > 1.99
    });
    assert!(finger.forces()[0] <= 2.0 + 1e-6, "{} N of a vector", finger.forces()[0]);
}

#[test]
fn a_device_with_too_little_is_reported_of_and_gives_nothing() {
    let sandbox = sandbox();
    sandbox.put("two.ca.toml", &FINGER.replace("dof = 0", "dof = 1"));
    let server = sandbox.serve("two.ca.toml", &["--arm", "--seconds", "2"]);
    let finger = TestDevice::new(&sandbox.site, 1, 1);
    let ran = server.end();
    ran.says(&["finger: the model needs 2 degrees of freedom, but the device has 1; the device is not used"]);
    assert_eq!(finger.forces()[0], 0.0);
    drop(finger);
    // with a profile, the device is refused too
    let server = sandbox.serve("two.ca.toml", &["--profile", "finger=falcon", "--arm", "--seconds", "2"]);
    let _finger = TestDevice::new(&sandbox.site, 1, 1);
    server.end().says(&["its profile `falcon` has 3: its frames are ignored", "`dof = 1`"]);
}

#[test]
fn a_device_plays_the_keys_it_has() {
    let sandbox = sandbox();
    let keys = FINGER.replace("[TGR]", "[TGR]\nother = { device = \"finger\", dof = 1 }");
    sandbox.put("keys.ca.toml", &keys);
    let server = sandbox.serve("keys.ca.toml", &[]);
    let finger = TestDevice::new(&sandbox.site, 1, 1);
    press(&sandbox, &finger);
    let ran = server.stop();
    ran.says(&["finger: it reports: ", "keys for 2 degrees of freedom; only MIDI and gestures play the others"]);
    drop(finger);
    let one = "name = \"one\"\ntitle = \"a key\"\nsource = \"none\"\ndof = 1\naxes = 1\nrange = [-0.05, 0.05]\nforce = 2\nrate = 1000\n";
    sandbox.put("c/profiles/one.toml", one);
    let server = sandbox.serve("keys.ca.toml", &["--profile", "finger=one", "--seconds", "1"]);
    server
        .end()
        .says(&["the model uses 2 keys of `finger`, but its profile has 1", "only MIDI and gestures move the others"]);
}

#[test]
fn conformance_asks_whether_it_would_be_served() {
    let sandbox = Sandbox::new();
    let row = |v: &serde_json::Value, name: &str| {
        let rows = v["rows"].as_array().unwrap();
        let r = rows.iter().find(|r| r["name"] == name).unwrap_or_else(|| panic!("no row `{name}` in {v:#}"));
        (r["pass"].as_bool().unwrap(), r["found"].as_str().unwrap().to_owned())
    };
    {
        // without a profile, its description applies
        let _device = FaultyDevice::new(&sandbox.site, "finger", DeviceFault::None);
        let (pass, found) = row(&sandbox.ca(&["device", "conformance", "finger", "--json"]).json(), "serve");
        assert!(pass && found.contains("profile `unknown`, at most 2 N"), "{found}");
    }
    // the bundled profile of this name has twelve keys, and the device has one
    let _device = FaultyDevice::new(&sandbox.site, "tgr12", DeviceFault::None);
    let ran = sandbox.ca(&["device", "conformance", "tgr12", "--json"]).is(1);
    let (pass, found) = row(&ran.json(), "serve");
    assert!(!pass && found.contains("needs 12 degrees of freedom, the device has 1; no frame is used"), "{found}");
}

#[test]
fn a_key_that_presses_while_somebody_arms_is_named_again_and_again() {
    let sandbox = Sandbox::new();
    // 1.5 N at the rest of the key; up to 0.5 N of 10 N count as nothing
    let model = crate::sandbox::KEY.replace("0.9 mm", "3 mm");
    assert!(model.contains("3 mm"));
    sandbox.put("presses.ca.toml", &model);
    let device = sandbox.key(&["--script", "hold"]);
    let server = sandbox.serve("presses.ca.toml", &["--arm", "--log", "t.mcap"]);
    let says =
        "key: armed, forces still off: the model pushes on `key` with 1.5 N; move it to where the force is below 0.5 N";
    until("it is said twice", || server.stderr().matches(says).count() >= 2);
    let status = sandbox.ca(&["status"]).is(0);
    status.says(&["the model pushes on `key` with 1.5 N"]);
    let ran = server.stop();
    assert!(ran.out.contains("key: off to the end; armed, but the model pushes on `key` with 1.5 N"), "{}", ran.out);
    device.stop().is(0);
    // a disarmed device does not report what it waits for
    let server = sandbox.serve("presses.ca.toml", &["--seconds", "1"]).end();
    assert!(server.out.contains("key: off to the end") && !server.out.contains("armed, but"), "{}", server.out);
}
