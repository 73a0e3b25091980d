//! Tests `ca equiv` and `ca check --device`: the scale of a model in the hand, shown, written, and compared with a
//! device.

use crate::sandbox::{STRUCK, Sandbox};
use std::fs;

/// A model in per-sample units at 44.1 kHz, with comments to be kept.
const PAPER: &str = r#"# mine
[model]
units = "alg"             # as in GENESIS
reference_rate = "44.1 kHz"

[TGR]
key3 = { device = "tgr12", dof = 3 }   # the good one
key4 = { device = "tgr12", dof = 14 }

[CEL]
bar = { m = 1, k = 1e-3 }
[RES]
shank = { between = [["key3", "key4"], "bar"], k = 2e-4 }
[SOX]
out = { from = "bar" }
"#;

#[track_caller]
fn factor(j: &serde_json::Value, row: &str) -> f64 {
    let rows = j["rows"].as_array().unwrap();
    rows.iter().find(|r| r["name"] == row).unwrap()["factor"].as_f64().unwrap()
}

#[track_caller]
fn near(is: f64, want: f64) {
    assert!((is / want - 1.0).abs() < 1e-12, "{is} is not {want}");
}

#[test]
fn a_row_is_set_and_the_others_follow() {
    let sandbox = Sandbox::new();
    sandbox.put("paper.ca.toml", PAPER);
    let both = ["equiv", "paper.ca.toml", "--set", "mass=20g:1.0", "--set", "position=20 mm:1"];
    let j = sandbox.ca(&[&both[..], &["--json"]].concat()).is(0).json();
    for (row, want) in [("position", 0.02), ("force", 777_924.0), ("mass", 0.02), ("stiffness", 38_896_200.0)] {
        near(factor(&j, row), want);
    }
    let shown = sandbox.ca(&both).is(0).says(&["per sample of 44.1 kHz", "777924 N", "15558.5 J"]);
    assert!(!shown.out.contains("alpha"), "{}", shown.out);
    sandbox.ca(&[&both[..], &["--verbose"]].concat()).is(0).says(&["alpha 50 ", "beta 777924"]);
    assert_eq!(fs::read_to_string(sandbox.path("paper.ca.toml")).unwrap(), PAPER);
}

#[test]
fn a_file_is_changed_there_and_nowhere_else() {
    let sandbox = Sandbox::new();
    sandbox.put("paper.ca.toml", PAPER);
    let read = || fs::read_to_string(sandbox.path("paper.ca.toml")).unwrap();
    let table = || sandbox.ca(&["equiv", "paper.ca.toml", "--json"]).is(0).json();
    let go = |args: &[&str]| sandbox.ca(&[&["equiv", "paper.ca.toml", "--in-place"], args].concat()).is(0);
    go(&["--set", "position=20 mm:1"]);
    assert!(read().starts_with(PAPER), "{}", read());
    assert!(read().ends_with("[equivalence]\nposition = [\"20 mm\", 1.0]\n"), "{}", read());
    near(factor(&table(), "stiffness"), 1.0);
    // the travel stays while the weight is set
    go(&["--set", "mass=20 g:1"]);
    near(factor(&table(), "position"), 0.02);
    near(factor(&table(), "force"), 777_924.0);
    // the weight stays while the travel is set; then the energy is set with the weight as the anchor
    go(&["--set", "position=10 mm:1"]);
    near(factor(&table(), "mass"), 0.02);
    near(factor(&table(), "position"), 0.01);
    go(&["--set", "energy=1 J:1", "--anchor", "viscosity"]);
    near(factor(&table(), "mass"), 0.02);
    near(factor(&table(), "energy"), 1.0);
    // a new anchor alone changes no number, and applies to later changes
    let before = table();
    go(&["--anchor", "force"]);
    assert_eq!(table()["rows"], before["rows"]);
    let force = factor(&before, "force");
    go(&["--set", "mass=1 g:1"]);
    near(factor(&table(), "force"), force);
    near(factor(&table(), "mass"), 0.001);
    go(&["--key", "key3", "--lever", "2"]);
    go(&["--key", "key4", "--position", "2", "--force-factor", "3"])
        .says(&["`key3` is a lever", "`key4` is an energy amplifier, not a lever"]);
    let j = table();
    near(j["keys"][0]["factors"]["stiffness"].as_f64().unwrap(), 4.0 * factor(&j, "stiffness"));
    assert_eq!((&j["keys"][0]["lever"], &j["keys"][1]["energy_gain"]), (&true.into(), &1.5.into()));
    assert!(read().starts_with(PAPER), "{}", read());
    // other commands report the key in units at the hand
    sandbox.ca(&["check", "paper.ca.toml"]).is(0).says(&["`key3`: sum of springs"]);
}

#[test]
fn what_does_not_fit_is_refused() {
    let sandbox = Sandbox::new();
    sandbox.put("paper.ca.toml", PAPER).put("struck.ca.toml", STRUCK);
    for (args, word) in [
        (&["--set", "mass=20g:1", "--set", "stiffness=1:1"][..], "with `mass`, set one of `position`"),
        (&["--set", "mass=20g:1", "--anchor", "stiffness"], "are the same equivalence"),
        (&["--set", "mass=1:1", "--set", "force=1:1", "--set", "energy=1:1"], "two equivalences determine"),
        (&["--set", "mas=20g:1"], "did you mean `mass`?"),
        (&["--set", "mass=20mm:1"], "`20mm` must be in kg, not in m"),
        (&["--set", "mass=20g"], "the real and the simulated value"),
        (&["--set", "mass=0:1"], "above 0"),
        (&["--set", "time=1:1"], "the clock determines it"),
        (&["--anchor", "impedence"], "did you mean `impedance`?"),
        (&["--key", "key3"], "--lever"),
        (&["--key", "key3", "--lever", "2", "--position", "2"], "cannot be used with"),
        (&["--lever", "2"], "--key"),
    ] {
        sandbox.ca(&[&["equiv", "paper.ca.toml"], args].concat()).is(2).says(&[word]);
    }
    sandbox.ca(&["equiv", "paper.ca.toml", "--key", "key5", "--lever", "2"]).is(1).says(&["E013", "did you mean `key"]);
    sandbox.ca(&["equiv", "piano_key", "--in-place"]).is(2).says(&["--write"]);
    sandbox.ca(&["equiv", "paper.ca.toml", "--write", "struck.ca.toml"]).is(1).says(&["--force"]);
    assert_eq!(sandbox.files(), ["paper.ca.toml", "struck.ca.toml"]);
}

#[test]
fn check_says_what_a_device_cannot_render() {
    let sandbox = Sandbox::new();
    sandbox.put("paper.ca.toml", PAPER);
    // K = 2e-4 at 20 g and 20 mm is 7779.24 N/m; a TGR of 2 N s/m is passive up to 2 / (2 · frame)
    let set = ["equiv", "paper.ca.toml", "--set", "mass=20g:1", "--set", "position=20 mm:1", "--in-place"];
    sandbox.ca(&set).is(0);
    let j = sandbox.ca(&["check", "paper.ca.toml", "--device", "tgr12", "--json"]).is(3).json();
    let key = &j["device"]["keys"][0];
    near(key["certified"].as_f64().unwrap(), 7779.24);
    assert!(
        (key["steepest"].as_f64().unwrap() / 7779.24 - 1.0).abs() < 1e-9,
        "the measured slope is that of the spring"
    );
    near(j["device"]["passive"].as_f64().unwrap(), 2.0 / (2.0 / 3000.0));
    assert_eq!((&key["beyond_stiffness"], &key["beyond_passive"]), (&false.into(), &true.into()));
    // from rest in the middle: 10 N at 10/7779.24 m, to within a step of the travel
    let x = key["saturates"].as_f64().unwrap();
    assert!((x - 10.0 / 7779.24).abs() < 0.02 / 2000.0 + 1e-12, "{x}");
    near(key["force"].as_f64().unwrap(), 7779.24 * 0.01);
    // the second key needs a degree of freedom beyond the twelve keys
    assert_eq!(j["device"]["keys"][1]["there"], false);
    let reported = sandbox.ca(&["check", "paper.ca.toml", "--device", "tgr12"]).is(3);
    reported.says(&["2.59 × the passive limit", "`shank`", "a degree of freedom beyond the 12", "not on this device"]);
    // a user profile, stiffer and slower
    let own = "name = \"mine\"\ntitle = \"Mine\"\nsource = \"me\"\ndof = 15\nrange = [-0.01, 0.01]\nforce = 100\nstiffness = 5000\nrate = 1000\n[body]\nfriction = 20\n";
    sandbox.put("mine.toml", own);
    let reported = sandbox.ca(&["check", "paper.ca.toml", "--device", "mine.toml"]).is(3);
    reported.says(&["the model needs 3 kHz, the device has 1 kHz", "1.56 × what it can render"]);
    let j = sandbox.ca(&["check", "paper.ca.toml", "--device", "mine.toml", "--json"]).is(3).json();
    near(j["device"]["passive"].as_f64().unwrap(), 20.0 / (2.0 / 1000.0));
    sandbox.ca(&["check", "paper.ca.toml", "--device", "tgr21"]).is(2).says(&["did you mean `tgr12`?"]);
    sandbox.put("bad.toml", "name = 3\n");
    sandbox.ca(&["check", "paper.ca.toml", "--device", "bad.toml"]).is(1).says(&["bad.toml"]);
    sandbox.ca(&["check", "hammer_piano", "--device", "tgr12"]).is(0).says(&["rendered up to 10", "the force reaches"]);
    sandbox.ca(&["check", "hammered_string", "--device", "mouse"]).says(&["On "]);
}

#[test]
fn check_compares_what_the_gesture_asks_for_with_the_travel() {
    let sandbox = Sandbox::new();
    // as written, 90 mm of the model are 20 mm at the hand, and the gesture needs 40 mm of the model
    let asks = |file: &str, code: i32| {
        let j = sandbox.ca(&["check", file, "--device", "tgr12", "--json"]).is(code).json();
        let key = &j["device"]["keys"][0];
        assert_eq!(key["name"], "key_x");
        ([0, 1].map(|i| key["asks"][i].as_f64().unwrap()), key["beyond_travel"].as_bool().unwrap())
    };
    let (span, beyond) = asks("rattle", 0);
    near(span[0], -0.04 * 20.0 / 90.0);
    near(span[1], 0.04 * 20.0 / 90.0);
    assert!(!beyond);
    // at scale 1, the gesture exceeds the travel
    sandbox.ca(&["equiv", "rattle", "--set", "position=1 m:1 m", "--write", "plain.ca.toml"]).is(0);
    let reported = sandbox.ca(&["check", "plain.ca.toml", "--device", "tgr12"]).is(3);
    let reported = reported.says(&["`key_x` needs -40 mm to 40 mm, the device has -10 mm to 10 mm"]);
    reported.says(&["beyond its travel", "ca equiv MODEL --set position="]);
    let (span, beyond) = asks("plain.ca.toml", 3);
    near(span[0], -0.04);
    near(span[1], 0.04);
    assert!(beyond);
    // the gesture fits up to the exact scale of the travel
    for (real, fits) in [("10 mm", true), ("9.9 mm", true), ("10.1 mm", false)] {
        let set = format!("position={real}:40 mm");
        sandbox.ca(&["equiv", "rattle", "--set", &set, "--write", "small.ca.toml", "--force"]).is(0);
        let (span, beyond) = asks("small.ca.toml", if fits { 0 } else { 3 });
        assert_eq!(beyond, !fits, "{real}: {span:?}");
    }
    // a key with a rest position outside the range of the device
    sandbox.put("far.ca.toml", "[TGR]\nkey = { device = \"tgr12\", x = \"11 mm\" }\n[SOX]\nout = { from = \"key\" }\n");
    sandbox.ca(&["check", "far.ca.toml", "--device", "tgr12"]).is(3).says(&["`key` needs 11 mm to 11 mm"]);
}

#[test]
fn a_law_that_stiffens_is_measured() {
    // k = 0 at rest, F = c e^3: the slope at the end of the travel is 3 c e^2
    let sandbox = Sandbox::new();
    let hard = "[TGR]\nkey = { device = \"tgr12\" }\n[SOL]\nwall = {}\n[CUB]\nhard = { between = [\"key\", \"wall\"], k = 1, k3 = 1e7 }\n[SOF]\nout = { from = \"hard\" }\n";
    sandbox.put("hard.ca.toml", hard);
    let j = sandbox.ca(&["check", "hard.ca.toml", "--device", "tgr12", "--json"]).json();
    let k = j["device"]["keys"][0]["steepest"].as_f64().unwrap_or_else(|| panic!("{j:#}"));
    assert!((k / (3.0 * 1e7 * 1e-4) - 1.0).abs() < 2e-3, "{k}");
}
