//! Tests `ca device conformance`: a correct device passes, and the row for each fault finds it.

use crate::faulty_device::{DeviceFault, FaultyDevice};
use crate::sandbox::{RunOutput, Sandbox, until};
use serde_json::Value;
use std::sync::RwLock;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

/// Limit on conformance tests at a time; each takes about a fifth of a core.
const AT_ONCE: usize = 6;
/// Attempts while other tests run.
const FEW: usize = 6;

fn row(v: &Value, name: &str) -> (bool, String) {
    let rows = v["rows"].as_array().unwrap();
    let r = rows.iter().find(|r| r["name"] == name).unwrap_or_else(|| panic!("no row `{name}` in {v:#}"));
    (r["pass"].as_bool().unwrap(), r["found"].as_str().unwrap().to_owned())
}

fn tested(sandbox: &Sandbox, name: &str) -> RunOutput {
    sandbox.ca(&["device", "conformance", name, "--json"])
}

/// Repeats the test until it passes. Measurements depend on a possibly busy machine, and forces come on only if nothing
/// stalls for 100 ms.
fn passes(sandbox: &Sandbox, name: &str) -> Value {
    let mut last = Value::Null;
    for _ in 0..30 {
        let ran = tested(sandbox, name);
        last = ran.json();
        if ran.code == Some(0) {
            assert_eq!(last["pass"], true);
            return last;
        }
    }
    panic!("{last:#}");
}

#[test]
fn simulated_devices_pass() {
    let each = |name: &str| {
        let sandbox = Sandbox::shared();
        let device = sandbox.spawn(&["device", "sim", "--profile", name, "--script", "hold"]);
        let v = passes(&sandbox, name);
        assert!(v["rows"].as_array().unwrap().len() >= 20, "{v:#}");
        let (pass, found) = row(&v, "watchdog");
        assert!(pass && found.contains("WATCHDOG_OUT"), "{found}");
        assert!(row(&v, "measured").1.contains("N requested"), "{v:#}");
        // with the profile of the device, and on a spring of known stiffness
        assert!(row(&v, "serve").1.contains(&format!("profile `{name}`")), "{v:#}");
        assert!(row(&v, "spring").1.contains("N of the spring"), "{v:#}");
        let seen = device.stop().is(0);
        assert!(seen.says(&["WATCHDOG_OUT", "the engine changed"]).out.contains(name));
    };
    std::thread::scope(|scope| {
        scope.spawn(|| each("falcon"));
        scope.spawn(|| each("key"));
    });
}

#[test]
fn a_device_without_our_client_passes() {
    let sandbox = Sandbox::shared();
    let _device = FaultyDevice::new(&sandbox.site, "key", DeviceFault::None);
    passes(&sandbox, "key");
}

/// The option suggested for a device without a profile exists in this command.
#[test]
fn a_device_without_a_profile_is_given_one_as_suggested() {
    let sandbox = Sandbox::shared();
    let device = sandbox.spawn(&["device", "sim", "--profile", "key", "--name", "other", "--script", "hold"]);
    let with = |more: &[&str]| sandbox.ca(&[&["device", "conformance", "other", "--force", "0"][..], more].concat());
    until("it speaks", || sandbox.ca(&["device", "list"]).out.contains("other"));
    with(&[]).says(&["--profile other=NAME", "profile `unknown`"]);
    with(&["--profile", "other=key"]).says(&["profile `key`"]);
    with(&["--profile", "another=key"]).is(2).says(&["the tested device is `other`"]);
    drop(device);
}

#[test]
fn a_device_that_cannot_be_had_is_an_error() {
    let sandbox = Sandbox::new();
    sandbox.ca(&["device", "conformance", "nobody"]).is(1).says(&["no running device `nobody`", "ca device list"]);
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let _device = sandbox.key(&["--script", "hold"]);
    until("it speaks", || sandbox.state().2 > 100);
    sandbox.ca(&["device", "conformance", "key"]).is(1).says(&["already has a server"]);
}

/// Repeats the test of a faulty device until the row `name` appears; a busy machine may fail an earlier row first.
/// After a few attempts, it runs without other tests at the same time.
fn found(fault: DeviceFault, name: &str, beside: &RwLock<()>) {
    let sandbox = Sandbox::shared();
    let _device = FaultyDevice::new(&sandbox.site, "key", fault);
    let mut last = Value::Null;
    for try_of_it in 0..30 {
        let with_others = (try_of_it < FEW).then(|| beside.read().expect("nobody panics with it"));
        let by_itself = (try_of_it >= FEW).then(|| beside.write().expect("nobody panics with it"));
        let ran = tested(&sandbox, "key");
        drop((with_others, by_itself));
        if ran.err.contains("no running device `key`") {
            // the device announces itself twice per second, if the machine allows it
            std::thread::sleep(Duration::from_millis(500));
            continue;
        }
        last = ran.json();
        assert_eq!((ran.code, last["pass"].as_bool()), (Some(1), Some(false)));
        if last["rows"].as_array().unwrap().iter().any(|r| r["name"] == name) {
            break;
        }
    }
    let (pass, said) = row(&last, name);
    assert!(!pass, "{fault:?}: {last:#}");
    if name == "spring" {
        let [still, sign] = ["hold it still", "same sign"].map(|words| said.contains(words));
        assert_eq!([still, sign], [fault == DeviceFault::Moves, fault == DeviceFault::Sign], "{fault:?}: {said}");
    }
    if fault == DeviceFault::NoForce {
        let rows = last["rows"].as_array().unwrap();
        assert!(rows.iter().all(|r| r["name"] != "watchdog"), "{last:#}");
    }
}

/// Tests all faults, a few at a time, because a conformance test mostly waits.
#[test]
fn lies_are_found() {
    let lies = [
        (DeviceFault::Numbers, "numbers"),
        (DeviceFault::Rate, "rate"),
        (DeviceFault::Positions, "positions"),
        (DeviceFault::Session, "session"),
        (DeviceFault::Ack, "ack"),
        (DeviceFault::Measured, "measured"),
        (DeviceFault::Layout, "layout"),
        (DeviceFault::Sign, "spring"),
        (DeviceFault::Moves, "spring"),
        (DeviceFault::Watchdog, "watchdog"),
        // a device that never applies a force fails earlier than at its end
        (DeviceFault::NoForce, "arms again"),
        (DeviceFault::GoesOn, "goes on"),
        (DeviceFault::Restart, "restart"),
        (DeviceFault::Unrested, "unrested"),
    ];
    let (next, beside) = (AtomicUsize::new(0), RwLock::new(()));
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                while let Some((fault, name)) = lies.get(next.fetch_add(1, Relaxed)) {
                    found(*fault, name, &beside);
                }
            });
        }
    });
}
