//! Tests MIDI files in `ca render`. Each file in `tests/data/midi` shows one property of real files.

use crate::sandbox::{Sandbox, from_root, peak};

/// A bar pushed by two notes, C3 and D3.
const KEYS: &str = r#"
[model]
seconds = 0.3
[CEL]
bar = { m = "2 g", f = "440 Hz", t60 = "0.2 s" }
[ENF]
low = { to = "bar", midi = { note = "C3", to = "1 N", attack = "1 ms", release = "1 ms" } }
high = { to = "bar", midi = { note = "D3", to = "1 N", attack = "1 ms", release = "1 ms" } }
[SOX]
out = { from = "bar", gain = 2000 }
"#;

fn file(name: &str) -> String {
    from_root("tests/data/midi").join(name).display().to_string()
}

#[test]
fn files_that_other_players_read_are_read() {
    let sandbox = Sandbox::new();
    sandbox.put("keys.ca.toml", KEYS);
    let render = |name: &str| {
        let r = sandbox.ca(&["render", "keys.ca.toml", "--gesture", &file(name), "--seconds", "1", "--no-fade"]).is(0);
        (r, sandbox.wav("keys.wav").1)
    };
    for (name, remark) in [
        ("m01_rs_after_meta.mid", "running status continues once after a meta"),
        ("m02_rs_after_sysex.mid", "running status continues once after a meta or system-exclusive event"),
        ("m10b_announced_fewer.mid", "its header announces 1 of its 2 tracks"),
    ] {
        let (r, sound) = render(name);
        assert!(peak(&sound) > 0.1, "{name}");
        assert!(r.err.contains("note:") && r.err.contains(remark), "{name}: {}", r.err);
    }
    let (r, plain) = render("kar.kar");
    assert!(!r.err.contains("note:") && peak(&plain) > 0.1, "{}", r.err);
    for name in ["m05_rmid.mid", "rmi.rmi"] {
        assert!(render(name).1 == plain, "{name}");
    }
}

/// A string with a plectrum whose note is a parameter of the part around both.
const PLUCKED: &str = r#"
[model]
seconds = 0.2
[part.v.param]
n = "D3"
[part.v.STRING]
low = { n = 20, f = "D3", t60 = "1 s", m = "1 g" }
[part.v.use]
pick = { part = "plectrum", with = { on = "low[4]", note = "n" } }
[use]
v = { part = "v", n = 2, with = { n = ["D3", "E3"] } }
[SOX]
out = { from = "v[0].low[3]", gain = 100 }
"#;

#[test]
fn a_note_that_is_passed_on_is_used_and_keys_with_notes_share_a_degree_of_freedom() {
    let sandbox = Sandbox::new();
    sandbox.put("plucked.ca.toml", PLUCKED);
    let check = sandbox.ca(&["check", "plucked.ca.toml"]).is(0);
    assert!(!check.err.contains("W109") && !check.err.contains("N204"), "{}", check.err);
    let render = sandbox.ca(&["render", "plucked.ca.toml", "-q"]).is(0);
    assert!(!render.err.contains("W109"), "{}", render.err);
    sandbox.ca(&["check", "plucked.ca.toml"]).says(&["v[0..2].pick.key", "notes D3, E3"]);
    // a parameter of an inner part without a use is still reported
    let unused =
        PLUCKED.replace("[part.v.use]", "[part.w.param]\nx = 1\n[part.w.MAS]\nm = { m = \"1 g\" }\n[part.v.use]");
    sandbox.put(
        "unused.ca.toml",
        &unused
            .replace("[use]\n", "idle = { part = \"w\", with = { x = \"k\" } }\n[use]\n")
            .replace("n = \"D3\"\n", "n = \"D3\"\nk = 1\n"),
    );
    sandbox.ca(&["check", "unused.ca.toml"]).is(0).says(&["W109", "`v[0].k` is not used"]);
}

#[test]
fn the_pedal_holds_a_key_and_what_else_nothing_follows_is_told() {
    let sandbox = Sandbox::new();
    sandbox.put("keys.ca.toml", KEYS);
    // the key is released at 0.25 s, the pedal at 1.25 s
    let file = file("m16_pedal.mid");
    let r =
        sandbox.ca(&["render", "keys.ca.toml", "--gesture", &file, "--seconds", "2", "--probe", "bar=bar.csv"]).is(0);
    assert!(!r.err.contains("follows"), "the pedal is no longer ignored: {}", r.err);
    let csv = std::fs::read_to_string(sandbox.path("bar.csv")).unwrap();
    let at = |time: f64| -> f64 {
        csv.lines().nth(1 + (time * 48_000.0) as usize).unwrap().split(',').nth(1).unwrap().parse().unwrap()
    };
    // a static force on a spring after its motion has died away
    let pushed = 100.0 / 127.0 / (2e-3 * (std::f64::consts::TAU * 440.0_f64).powi(2));
    assert!((at(1.2) / pushed - 1.0).abs() < 5e-3, "{} {pushed}", at(1.2));
    assert!(at(1.8).abs() < 1e-3 * pushed, "{}", at(1.8));
    // a model that binds the pedal itself does not sustain notes by it
    sandbox.put("own.ca.toml", &KEYS.replace("[SOX]", "damp = { to = \"bar\", midi = { cc = 64, to = 0 } }\n[SOX]"));
    sandbox.ca(&["render", "own.ca.toml", "--gesture", &file, "--seconds", "2", "--probe", "bar=bar.csv"]).is(0);
    let csv = std::fs::read_to_string(sandbox.path("bar.csv")).unwrap();
    let line = csv.lines().nth(1 + 48_000).unwrap();
    assert!(line.split(',').nth(1).unwrap().parse::<f64>().unwrap().abs() < 1e-3 * pushed, "{line}");
    let mut bytes = b"MThd\0\0\0\x06\0\0\0\x01\x01\xe0MTrk\0\0\0\x1c".to_vec();
    bytes.extend([0, 0xb0, 7, 100, 0, 0x90, 48, 100, 0, 0x90, 60, 1, 0, 0xe0, 0, 0, 0, 0xd0, 9]);
    bytes.extend([0x83, 0x60, 0x80, 48, 0, 0, 0xff, 0x2f, 0]);
    std::fs::write(sandbox.path("more.mid"), bytes).unwrap();
    sandbox.ca(&["render", "keys.ca.toml", "--gesture", "more.mid", "-q"]).is(0).says(&[
        "1 note moves no port: 60 on channel 1",
        "no port follows controller 7, pitch bend and channel pressure on channel 1",
    ]);
}

#[test]
fn a_midi_file_is_played_until_its_last_note_has_died_away() {
    let sandbox = Sandbox::new();
    let frames = |model: &str, more: &[&str]| {
        sandbox.put("keys.ca.toml", model);
        sandbox.ca(&[&["render", "keys.ca.toml", "-q"], more].concat()).is(0);
        sandbox.wav("keys.wav").1.len() as f64 / 48_000.0
    };
    let midi = file("m16_pedal.mid");
    let midi = ["--gesture", midi.as_str()];
    assert_eq!(frames(KEYS, &[]), 0.3);
    // the port is at rest at 1.251 s and the bar decays by 60 dB within 0.2 s; the end is half a second later
    let length = frames(KEYS, &midi);
    assert!((1.751..2.0).contains(&length), "{length}");
    assert_eq!(frames(KEYS, &[&midi[..], &["--seconds", "0.5"]].concat()), 0.5);
    // an undamped sound ends 10 s after the last event
    let long = frames(&KEYS.replace("t60 = \"0.2 s\"", "t60 = \"1000 s\""), &midi);
    assert!((long - 11.251).abs() < 1e-3, "{long}");
}

/// A piano has 88 keys, and a device frame has 32 degrees of freedom.
#[test]
fn a_device_may_have_fewer_keys_than_the_model() {
    let sandbox = Sandbox::new();
    let list = |from: usize| (from..from + 88).map(|n| n.to_string()).collect::<Vec<_>>().join(", ");
    let model = format!(
        "[model]\nseconds = 0.1\n[part.key.param]\ndof = 0\nnote = 60\n[part.key.CEL]\nbar = {{ m = \"2 g\", f = \"440 Hz\", t60 = \"0.1 s\" }}\n\
         [part.key.TGR]\nkey = {{ device = \"keys\", dof = \"dof\", midi = {{ note = \"note\", to = \"1 mm\", attack = \"1 ms\" }} }}\n\
         [part.key.RES]\nshank = {{ between = [\"key\", \"bar\"], k = 100 }}\n\
         [use]\nkey = {{ part = \"key\", n = 88, with = {{ dof = [{}], note = [{}] }} }}\n[SOX]\nout = {{ from = \"key[87].bar\", gain = 1e4 }}\n",
        list(0),
        list(21)
    );
    sandbox.put("piano.ca.toml", &model);
    sandbox.ca(&["check", "piano.ca.toml"]).is(0);
    let mut bytes = b"MThd\0\0\0\x06\0\0\0\x01\x01\xe0MTrk\0\0\0\x0d".to_vec();
    bytes.extend([0, 0x90, 108, 127, 0x83, 0x60, 0x80, 108, 0, 0, 0xff, 0x2f, 0]);
    std::fs::write(sandbox.path("top.mid"), bytes).unwrap();
    sandbox.ca(&["render", "piano.ca.toml", "--gesture", "top.mid", "-q"]).is(0);
    assert!(peak(&sandbox.wav("piano.wav").1) > 0.01);
    let r = sandbox.ca(&["serve", "piano.ca.toml", "--seconds", "0.05"]).is(0);
    r.says(&["`keys`: a device has at most 32 degrees of freedom; only MIDI and gestures move 56 ports from `key[32].key` on"]);
    // the limit of MIDI still applies
    let far = model.replace("dof = [0, ", "dof = [128, ");
    sandbox.put("piano.ca.toml", &far).ca(&["check", "piano.ca.toml"]).is(1).says(&["E009", "127"]);
}
