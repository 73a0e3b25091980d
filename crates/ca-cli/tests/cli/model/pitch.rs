//! Tests `ca modes` and `ca tune`: modes of a model before and after tuning.

use crate::sandbox::Sandbox;
use std::fs;

/// Strings by frequency and by stiffness, a string that follows a parameter and drives a mass, a cell, and a bank.
const PARTS: &str = r#"# mine
[param]
tension = { value = "9 kN/m", unit = "N/m", live = true, min = 1, max = 1e6 }   # of the third

[STRING]
low = { n = 20, f = "110 Hz", m = "1 g", t60 = "2 s" }   # by frequency
mid = { n = 20, k = "20 kN/m", m = "1 g" }
top = { n = 10, k = "tension", m = "1 g" }

[MAS]
weight = { m = "2 g" }
hammer = { m = "10 g", x = "-5 mm", v = "1 m/s" }

[REF]
tie = { between = ["top[4]", "weight"], k = "300 N/m", z = "2 mN s/m" }

[BANK]
bell = { f = ["400 Hz", "900 Hz", "1300 Hz"], t60 = "1 s", m = "5 g" }

[BUT]
strike = { between = ["hammer", "low[4]"], k = "8 kN/m" }

[SOX]
a = { from = "low[3]" }
b = { from = "mid[3]" }
c = { from = "top[3]" }
d = { from = "bell[0]" }
e = { from = "bell[1]" }
f = { from = "bell[2]" }
"#;

fn cents(is: f64, want: f64) -> f64 {
    1200.0 * (is / want).log2().abs()
}

/// Modes of a file: heard frequency, T60, participation by port.
fn modes(sandbox: &Sandbox, file: &str) -> Vec<serde_json::Value> {
    sandbox.ca(&["modes", file, "--json"]).is(0).json()["modes"].as_array().unwrap().clone()
}

/// Frequency of the lowest mode that is much stronger at this port than at any other.
fn pitch_of(sandbox: &Sandbox, file: &str, port: &str) -> f64 {
    let list = modes(sandbox, file);
    let at = |m: &serde_json::Value, p: &str| m["ports"][p].as_f64().unwrap().abs();
    let top = list.iter().map(|m| at(m, port)).fold(0.0, f64::max);
    let mine = |m: &&serde_json::Value| {
        at(m, port) > 0.3 * top
            && ["a", "b", "c", "d", "e", "f"].iter().filter(|p| **p != port).all(|p| at(m, p) < 0.2 * at(m, port))
    };
    list.iter().find(mine).unwrap()["heard_hz"].as_f64().unwrap()
}

#[test]
fn modes_are_reported_with_pitch_decay_and_where_they_are_heard() {
    let sandbox = Sandbox::new();
    sandbox.put("parts.ca.toml", PARTS);
    let r = sandbox.ca(&["modes", "parts.ca.toml", "-n", "5"]).is(0);
    for word in ["110.0000", "`strike` (BUT)", "silent", "heard [Hz]", "more: `--modes"] {
        assert!(r.out.contains(word), "{word}\n{}", r.out);
    }
    let list = modes(&sandbox, "parts.ca.toml");
    let low = list.iter().find(|m| cents(m["heard_hz"].as_f64().unwrap().max(1e-9), 110.0) < 1e-5).expect("the string");
    assert!((low["t60_s"].as_f64().unwrap() / 2.0 - 1.0).abs() < 1e-6, "{low}");
    // the weight on the third string couples its damper to all modes
    assert!(list.iter().any(|m| m["coupled"].as_f64().unwrap() > 1e-6));
    sandbox.ca(&["modes", "parts.ca.toml", "--shapes", "shapes.csv"]).is(0);
    let csv = fs::read_to_string(sandbox.path("shapes.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + list.len());
    assert!(csv.lines().all(|l| l.split(',').count() == 1 + list.len()) && csv.contains("\"low[3]\","));
    sandbox.ca(&["modes", "jack", "-n", "4"]).is(0);
    sandbox.put("still.ca.toml", "[SOL]\nwall = {}\n[ENX]\nhand = {}\n[SOX]\nout = { from = \"hand\" }\n");
    sandbox.ca(&["modes", "still.ca.toml"]).is(1).says(&["nothing in the linear part of this model moves"]);
}

#[test]
fn parts_are_tuned_and_the_rest_of_the_file_stays() {
    let sandbox = Sandbox::new();
    sandbox.put("parts.ca.toml", PARTS);
    let args = ["tune", "parts.ca.toml", "low=A2+20", "mid=C#4", "top=300 Hz", "--a4", "442 Hz"];
    let j = sandbox.ca(&[&args[..], &["--json"]].concat()).is(0).json();
    assert_eq!(fs::read_to_string(sandbox.path("parts.ca.toml")).unwrap(), PARTS, "nothing was asked to be written");
    for (k, port) in ["a", "b", "c"].iter().enumerate() {
        let t = &j["tuned"][k];
        assert!(t["off_cents"].as_f64().unwrap().abs() < 1e-5, "{t}");
        let before = pitch_of(&sandbox, "parts.ca.toml", port);
        assert!(cents(before, t["before_hz"].as_f64().unwrap()) < 1e-6, "{t}, {before}");
    }
    sandbox.ca(&[&args[..], &["--write", "tuned.ca.toml"]].concat()).is(0);
    let want = [110.5 * (20.0f64 / 1200.0).exp2(), 442.0 * (-8.0f64 / 12.0).exp2(), 300.0];
    for (want, port) in want.iter().zip(["a", "b", "c"]) {
        assert!(cents(pitch_of(&sandbox, "tuned.ca.toml", port), *want) < 0.01, "{port}");
    }
    let text = fs::read_to_string(sandbox.path("tuned.ca.toml")).unwrap();
    for kept in ["# mine\n", "# of the third\n", "# by frequency\n", "mid = { n = 20, k = \"", "k = \"tension\""] {
        assert!(text.contains(kept), "{kept}\n{text}");
    }
    sandbox.ca(&["tune", "tuned.ca.toml", "top=300 Hz", "--in-place"]).is(0);
    assert!(cents(pitch_of(&sandbox, "tuned.ca.toml", "c"), 300.0) < 0.01);
}

#[test]
fn a_bank_takes_a_scale() {
    let sandbox = Sandbox::new();
    sandbox.put("parts.ca.toml", PARTS);
    sandbox.ca(&["tune", "parts.ca.toml", "bell", "--scale", "just", "--root", "A4", "--in-place"]).is(0);
    for (port, want) in [("d", 440.0), ("e", 495.0), ("f", 550.0)] {
        assert!(cents(pitch_of(&sandbox, "parts.ca.toml", port), want) < 0.01, "{port}");
    }
}

#[test]
fn what_cannot_be_tuned_is_reported() {
    let sandbox = Sandbox::new();
    sandbox.put("parts.ca.toml", PARTS);
    let no = |args: &[&str], code: i32, words: &[&str]| {
        sandbox.ca(&[&["tune", "parts.ca.toml"], args].concat()).is(code).says(words);
    };
    no(&["lo=A2"], 2, &["did you mean `low`?"]);
    no(&["low=H2"], 2, &["`H2` is not a pitch"]);
    no(&["low"], 2, &["expected PART=PITCH, e.g. `low=A2`"]);
    no(&["weight=A2"], 2, &["neither `f` nor `k`"]);
    no(&["bell=A2"], 2, &["3 pitches", "--scale"]);
    // two parts that share a parameter cannot have two pitches
    sandbox.put("two.ca.toml", &PARTS.replace("mid = { n = 20, k = \"20 kN/m\"", "mid = { n = 20, k = \"tension\""));
    sandbox.ca(&["tune", "two.ca.toml", "mid=100", "top=300"]).is(1).says(&["`mid`", "same parameter"]);
    no(&["low=A2", "--mode", "40"], 1, &["20 modes"]);
    no(&["low=30 kHz"], 1, &["`low`"]);
    // limits of the parameter in the file apply, and an unstable result is not written
    no(&["top=5 kHz", "--in-place"], 1, &["`tension`"]);
    no(&["mid=23.9 kHz", "--mode", "19", "--in-place"], 1, &["mid"]);
    sandbox.ca(&["tune", "hammered_string", "low=A2", "--in-place"]).is(2).says(&["a bundled model cannot be changed"]);
    assert_eq!(fs::read_to_string(sandbox.path("parts.ca.toml")).unwrap(), PARTS);
}

/// Modules without an output are not in the scene. The message gives this cause instead of missing modes.
#[test]
fn what_nothing_hears_is_said_to_be_unheard() {
    let sandbox = Sandbox::new();
    let cells = "[CEL]\nc = { m = \"1 g\", f = \"100 Hz\" }\nd = { m = \"1 g\", f = \"200 Hz\" }\n[SOX]\nout = { from = \"c\" }\n";
    sandbox.put("un.ca.toml", cells);
    sandbox.ca(&["tune", "un.ca.toml", "d=A3"]).is(1).says(&["no output depends on `d`", "`from = \"d\"`"]);
    sandbox.ca(&["modes", "un.ca.toml"]).is(0).says(&["not included, because no output depends on them: `d`"]);
    assert_eq!(sandbox.ca(&["modes", "un.ca.toml", "--json"]).is(0).json()["unheard"][0], "d");
    sandbox.ca(&["tune", "un.ca.toml", "c=A3"]).is(0);
    let bank =
        "[BANK]\nk = { f = [\"100 Hz\", \"200 Hz\", \"300 Hz\"], m = \"1 g\" }\n[SOX]\nout = { from = \"k[0]\" }\n";
    sandbox.put("bank.ca.toml", bank);
    let scale = ["tune", "bank.ca.toml", "--scale", "harmonic", "--root", "A3", "k"];
    sandbox.ca(&scale).is(1).says(&["no output depends on `k[1]`", "`from = \"k[*]\"`"]);
    sandbox
        .ca(&["modes", "bank.ca.toml"])
        .is(0)
        .says(&["not included, because no output depends on them: `k[1]`, `k[2]`"]);
    sandbox.put("bank.ca.toml", &bank.replace("k[0]", "k[*]"));
    sandbox.ca(&scale).is(0);
    sandbox
        .put("fixed.ca.toml", &cells.replace("[SOX]", "[SOL]\nw = {}\n[SOX]").replace("from = \"c\"", "from = \"w\""));
    sandbox.ca(&["modes", "fixed.ca.toml"]).is(1).says(&["nothing that reaches an output moves", "`c`, `d`"]);
}

#[test]
fn waveguides_are_left_out_and_said_to_be() {
    let sandbox = Sandbox::new();
    let wave = "[WAVEGUIDE]\nlow = { f = \"110 Hz\", z = 1, at = 0.3 }\n[SOX]\nout = { from = \"low[0]\" }\n";
    sandbox.put("wave.ca.toml", wave);
    sandbox.ca(&["modes", "wave.ca.toml"]).is(1).says(&["this model moves; not linear: `low` (WAVEGUIDE)"]);
    sandbox.ca(&["tune", "wave.ca.toml", "low=A2"]).is(2).says(&["`low` is a WAVEGUIDE", "`--set low.f=…`"]);
    let cell = "[CEL]\nbar = { m = 0.01, f = 300 }\n[RES]\ntie = { between = [\"bar\", \"low[0]\"], k = 9 }\n";
    sandbox.put("both.ca.toml", &format!("{wave}{cell}"));
    sandbox.ca(&["modes", "both.ca.toml"]).is(0).says(&["1 oscillating modes", "`low` (WAVEGUIDE)"]);
}

/// A number written as a note, which also sets the MIDI note, stays a note.
#[test]
fn a_note_stays_a_note() {
    let sandbox = Sandbox::new();
    let text = "[part.tone.param]\npitch = { unit = \"Hz\" }\n[part.tone.STRING]\ns = { n = 20, f = \"pitch\", m = \"2 g\", t60 = \"1 s\" }\n\
                [part.tone.ENX]\nkey = { midi = { note = \"pitch\", to = \"1 mm\" } }\n[part.tone.RES]\nr = { between = [\"key\", \"s[3]\"], k = 10 }\n\
                [use]\ntone = { part = \"tone\", n = 2, with = { pitch = [\"C4\", \"E4\"] } }\n[SOX]\nout = { from = \"tone[*].s[9]\", channel = 0 }\n";
    sandbox.put("t.ca.toml", text);
    let j = sandbox.ca(&["tune", "t.ca.toml", "tone[0].s=A4", "--in-place", "--json"]).is(0).json();
    let number = j["tuned"][0]["number"].as_str().unwrap();
    assert!(number.starts_with("A4"), "{number}");
    assert!(fs::read_to_string(sandbox.path("t.ca.toml")).unwrap().contains(&format!("\"{number}\"")));
    sandbox.ca(&["check", "t.ca.toml"]).is(0);
}

#[test]
fn hertz_stay_hertz() {
    let sandbox = Sandbox::new();
    sandbox.put(
        "h.ca.toml",
        "[STRING]\ns = { n = 20, f = \"250 Hz\", m = \"2 g\", t60 = \"1 s\" }\n[SOX]\nout = { from = \"s[9]\" }\n",
    );
    let j = sandbox.ca(&["tune", "h.ca.toml", "s=A4", "--json"]).is(0).json();
    assert!(j["tuned"][0]["number"].as_str().unwrap().ends_with(" Hz"), "{j}");
}
