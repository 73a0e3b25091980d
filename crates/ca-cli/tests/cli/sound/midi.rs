//! MIDI files as `ca render` plays them. Each file in `tests/data/midi` shows one property of files that people have.

use crate::desk::{Desk, from_root, peak};

/// A bar that is pushed by two notes, C3 and D3.
const KEYS: &str = r#"
[model]
seconds = 0.3
[CEL]
bar = { m = "2 g", f = "440 Hz", t60 = "0.2 s" }
[ENF]
low = { to = "bar", midi = { note = "C3", to = "1 N", attack = "1 ms", release = "1 ms" } }
high = { to = "bar", midi = { note = "D3", to = "1 N", attack = "1 ms", release = "1 ms" } }
[SOX]
out = { from = "bar", gain = 1000 }
"#;

/// A file of `tests/data/midi`.
fn file(name: &str) -> String {
    from_root("tests/data/midi").join(name).display().to_string()
}

#[test]
fn files_that_other_players_read_are_read() {
    let desk = Desk::new();
    desk.put("keys.ca.toml", KEYS);
    let render = |name: &str| {
        let r = desk.ca(&["render", "keys.ca.toml", "--gesture", &file(name), "--seconds", "1", "--no-fade"]).is(0);
        (r, desk.wav("keys.wav").1)
    };
    for (name, remark) in [
        ("m01_rs_after_meta.mid", "running status goes on 1 times after a meta"),
        ("m02_rs_after_sysex.mid", "running status goes on 1 times after a meta or system-exclusive event"),
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
