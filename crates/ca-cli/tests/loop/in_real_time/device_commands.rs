//! Tests `ca device list`, `doctor` and `calibrate`, and the examples in the help.

use crate::sandbox::{Sandbox, until};
use ca_haptic::calibration::Calibration;
use ca_haptic::host::Site;

#[test]
fn list_shows_who_speaks_and_what_there_is() {
    let sandbox = Sandbox::shared();
    sandbox.ca(&["device", "list"]).is(0).says(&["no running device", "falcon", "one key (yours)"]);
    let device = sandbox.key(&["--script", "hold", "--name", "left"]);
    until("it is listed", || sandbox.ca(&["device", "list"]).is(0).out.starts_with("left: one key"));
    let v = sandbox.ca(&["device", "list", "--json"]).is(0).json();
    let d = &v["devices"][0];
    assert_eq!((&d["device"], &d["rate"], &d["dof"]), (&"left".into(), &3000.into(), &1.into()));
    assert!((d["force"][0].as_f64().unwrap() - 10.0).abs() < 1e-6);
    assert!(v["profiles"].as_array().unwrap().iter().any(|p| p["own"] == true && p["profile"]["name"] == "key"));
    // SIGTERM ends it like Ctrl-C
    device.signal("TERM");
    device.end().is(0).says(&["left: ", "DISCONNECT"]);
    assert_eq!(sandbox.ca(&["device", "list", "--json"]).json()["devices"].as_array().unwrap().len(), 0);
}

#[test]
fn the_doctor_tries_shared_memory_and_finds_who_is_there() {
    let sandbox = Sandbox::shared();
    let v = sandbox.ca(&["device", "doctor", "--json"]).is(0).json();
    let row = |v: &serde_json::Value, name: &str| {
        let rows = v["rows"].as_array().unwrap();
        rows.iter().find(|r| r["what"] == name).unwrap_or_else(|| panic!("no `{name}` in {v:#}")).clone()
    };
    assert_eq!((&v["usable"], &row(&v, "memory")["state"]), (&true.into(), &"good".into()));
    assert_eq!(v["late_us"]["n"], 3000);
    assert!(row(&v, "server")["found"].as_str().unwrap().contains("none is running"));
    // every row that is not good gives advice
    for r in v["rows"].as_array().unwrap() {
        assert_eq!(r["state"] == "good", r["fix"] == "", "{r}");
    }
    let _server = sandbox.serve("key.ca.toml", &["--quiet"]);
    let _device = sandbox.key(&["--script", "hold"]);
    until("it is found", || {
        let v = sandbox.ca(&["device", "doctor", "--json"]).is(0).json();
        row(&v, "server")["found"].as_str().unwrap().contains("gesture frames") && row(&v, "devices")["found"] == "key"
    });
    // a folder that others can write to is refused
    let open = sandbox.path("open");
    std::fs::create_dir(&open).unwrap();
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o777);
    std::fs::set_permissions(&open, mode).unwrap();
    assert!(Site::at(&open).is_err());
    let line = format!("CA_SHM_ROOT={} ca device doctor", open.display());
    sandbox.sh(&line).is(1).says(&["bad", "place", "chmod 700", "cannot be played"]);
}

#[test]
fn a_device_in_lock_step_ends_without_a_server() {
    let sandbox = Sandbox::shared();
    let r = sandbox.ca(&["device", "sim", "--profile", "key", "--lockstep", "--seconds", "0.1"]);
    r.is(0).says(&["no server answered frame "]);
}

#[test]
fn calibrate_writes_what_serve_reads() {
    let sandbox = Sandbox::shared();
    sandbox
        .ca(&["device", "calibrate", "key", "--low", "100", "--high", "4100"])
        .is(0)
        .says(&["c/calibration/key.toml"]);
    let c = Calibration::read(&sandbox.read("c/calibration/key.toml"), "key").unwrap();
    // the calibration of another device would give wrong positions and forces
    sandbox.put("falcon.toml", &c.write().replace("\"key\"", "\"falcon\""));
    let other = sandbox.ca(&["serve", "key.ca.toml", "--seconds", "0.1", "--calibration", "key=falcon.toml"]);
    other.is(1).says(&["falcon.toml", "this calibration is for `falcon`, not for `key`"]);
    let far = c.write().replace("force = 1.0", "force = 1e300");
    sandbox.put("far.toml", &far);
    let far = sandbox.ca(&["serve", "key.ca.toml", "--seconds", "0.1", "--calibration", "key=far.toml"]);
    far.is(1).says(&["far.toml", "axis 0", "`force`", "1e9"]);
    let a = c.axis[0];
    assert!((a.scale * 100.0 + a.offset + 0.01).abs() < 1e-15 && (a.scale * 4100.0 + a.offset - 0.01).abs() < 1e-15);
    // a device that reports counts instead of metres: 2600 is 2.5 mm
    let watch = crate::force_watcher::ForceWatcher::of(&sandbox.site, "key");
    sandbox.put("far.ca.toml", &crate::sandbox::KEY.replace("0.9 mm", "3.2 mm"));
    let _server = sandbox.serve("far.ca.toml", &["--quiet"]);
    let _device = crate::faulty_device::FaultyDevice::moving(&sandbox.site, "key", |_, f| {
        f.pos[0] = 2600.0;
        f.status &= !ca_haptic::frame::status::CALIBRATED;
    });
    sandbox.on();
    // 0.7 mm of 500 N/m
    until("the force is that of metres", || (watch.last().unwrap().force[0] - 0.35).abs() < 1e-4);
    assert_eq!(watch.last().unwrap().calibration, c.id());
    for (args, word) in [
        (&["--low", "1", "--high", "1"][..], "two different numbers"),
        (&["--low", "1,2", "--high", "3"], "give 1 or 1"),
        (&[], "the readings cannot be asked for"),
    ] {
        let ran = sandbox.ca(&[&["device", "calibrate", "key"], args].concat());
        assert!(matches!(ran.code, Some(1 | 2)) && ran.err.contains(word), "{args:?}: {}", ran.err);
    }
    assert_eq!(
        Calibration::read(&sandbox.read("c/calibration/key.toml"), "key").unwrap(),
        c,
        "nothing is half written"
    );
}

#[test]
fn what_makes_no_sense_is_refused() {
    let sandbox = Sandbox::shared();
    for (args, word) in [
        (&["--profile", "falcn"][..], "did you mean `falcon`?"),
        (&["--script", "file"], "--gesture"),
        (&["--script", "bow", "--push", "1"], "`--script push`"),
        (&["--name", "a name that is far too long"], "1 to 16"),
        (&["--force-log", "no/where.csv"], "`no/where.csv`"),
        (&["--rate", "fast"], "starts with a number"),
    ] {
        let ran = sandbox.ca(&[&["device", "sim", "--seconds", "0.1"], args].concat());
        assert!(matches!(ran.code, Some(1 | 2)) && ran.err.contains(word), "{args:?}: {:?} {}", ran.code, ran.err);
    }
}

#[test]
fn examples_of_device_helps_run() {
    let sandbox = Sandbox::shared();
    let mut ran = 0;
    let help = sandbox.ca(&["device", "--help"]).is(0).out;
    let general = sandbox.ca(&["--help"]).is(0).out;
    assert!(general.contains(help.lines().next().unwrap()), "two things are said of it:\n{help}\n{general}");
    let (_, examples) = help.split_once("Examples:\n").unwrap();
    for line in examples.lines().filter(|l| !l.trim().is_empty()) {
        // a conformance test may fail if the machine stalls; the device has ended before the next attempt
        let tries = if line.contains("conformance") { 10 } else { 1 };
        let whole = line.replace("; kill $!", " && r=0 || r=$?; kill $!; wait || true; exit $r");
        let fine = (0..tries).any(|_| {
            let r = sandbox.sh(&whole);
            eprintln!("$ {line}\n{}{}", r.out, r.err);
            r.code == Some(0)
        });
        assert!(fine, "{line}");
        ran += 1;
    }
    assert!(ran >= 6, "only {ran} examples were found");
}
