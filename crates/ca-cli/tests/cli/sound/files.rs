//! Tests that files are written completely or not at all, and that endless files are refused.

use crate::sandbox::{BAR, Sandbox};
use std::fs;

/// On a full disk, existing files stay and no partial file remains. A limit on the file size simulates the full disk.
#[cfg(unix)]
#[test]
fn what_does_not_fit_on_the_disk_replaces_nothing() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", &format!("{BAR}# {}\n", "long ".repeat(200)));
    let short = "--seconds 0.01 --times 1 --reference 4";
    for line in [
        "report bar.ca.toml --seconds 1 --accuracy 0 -o x.html",
        &format!("accuracy bar.ca.toml {short} -o x.html"),
        "equiv bar.ca.toml --write x.ca.toml --force",
        "new x.ca.toml --force",
        "modes bar.ca.toml --shapes x.csv",
    ] {
        let name = ["x.html", "x.ca.toml", "x.csv"].into_iter().find(|n| line.contains(n)).unwrap();
        sandbox.put(name, "good");
        let blocks = i32::from(name != "x.csv");
        let r = sandbox.sh(&format!("ulimit -f {blocks}; trap '' XFSZ; ca {line}")).is(1);
        assert!(r.err.contains(name) && r.err.contains("cannot be written"), "{line}: {}", r.err);
        assert_eq!(fs::read_to_string(sandbox.path(name)).unwrap(), "good", "{line}");
        fs::remove_file(sandbox.path(name)).unwrap();
        sandbox.sh(&format!("ulimit -f {blocks}; trap '' XFSZ; ca {}", line.trim_end_matches(" --force"))).is(1);
        assert_eq!(sandbox.files(), ["bar.ca.toml"], "{line} leaves nothing");
    }
    // the model fits, but not the schema beside it
    sandbox.sh("ulimit -f 20; trap '' XFSZ; ca new y.ca.toml").is(1).says(&["ca.schema.json"]);
    assert_eq!(sandbox.files(), ["bar.ca.toml", "y.ca.toml"]);
    sandbox.ca(&["equiv", "bar.ca.toml", "--write", "y.ca.toml"]).is(1).says(&["`y.ca.toml` exists", "--force"]);
}

/// Endless files and binary files are refused at once, and files that are too large by their size.
#[cfg(unix)]
#[test]
fn nothing_is_read_without_end() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    let sparse = |name: &str, bytes: u64| fs::File::create(sandbox.path(name)).unwrap().set_len(bytes).unwrap();
    sparse("big.ca.toml", 3_000_000_000);
    sparse("big.csv", 3_000_000_000);
    sparse("big.wav", 3_000_000_000);
    sparse("nul.csv", 300_000_000);
    sparse("nul.mdl", 1000);
    sparse("nul.toml", 1000);
    // a memory limit makes the test fail if a large file is read
    let ca = |line: &str| sandbox.sh(&format!("ulimit -v 2000000; ca {line}")).is(1);
    ca("check /dev/zero").says(&["`/dev/zero`", "byte 0 is NUL", "saved as UTF-8"]);
    ca("check big.ca.toml").says(&["`big.ca.toml`", "larger than 256 MB", "STRING"]);
    for name in ["big.csv", "big.wav"] {
        ca(&format!("render bar.ca.toml --gesture {name}")).says(&[name, "larger than 1000 MB", "cut it into parts"]);
    }
    let r = ca("render bar.ca.toml --gesture nul.csv").says(&["`nul.csv`", "byte 0 is NUL"]);
    assert!(!r.err.contains('\0') && r.err.len() < 1000, "{}", r.err);
    ca("import nul.mdl").says(&["byte 0 is NUL"]);
    ca("sweep nul.toml").says(&["byte 0 is NUL"]);
}

/// A part must be a regular file below the folder of the model. A FIFO is refused without waiting for it.
#[cfg(unix)]
#[test]
fn a_part_is_a_file_beside_its_model() {
    let sandbox = Sandbox::new();
    let outside = Sandbox::new();
    outside.put("secret.ca.toml", "[MAS]\nm = { m = 1 }\n");
    std::os::unix::fs::symlink(outside.path("secret.ca.toml"), sandbox.path("link.ca.toml")).unwrap();
    sandbox.put("own.ca.toml", "[MAS]\nm = { m = 1 }\n");
    std::os::unix::fs::symlink(sandbox.path("own.ca.toml"), sandbox.path("inside.ca.toml")).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(sandbox.path("pipe.ca.toml")).status().unwrap().success());
    for (file, code, says) in [
        ("link.ca.toml", 1, "outside the folder of the model"),
        ("pipe.ca.toml", 1, "it is not a regular file"),
        ("none.ca.toml", 1, "no such file"),
        ("inside.ca.toml", 0, ""),
    ] {
        sandbox.put("model.ca.toml", &format!("[use]\nx = \"{file}\"\n[SOX]\no = {{ from = \"x.m\" }}\n"));
        sandbox.ca(&["check", "model.ca.toml"]).is(code).says(&[says]);
    }
}

#[test]
fn a_name_of_many_instances_is_set_and_probed_in_each() {
    let sandbox = Sandbox::new();
    let render = |set: &str, to: &str| {
        let probe = format!("tine[*].thumb={to}");
        sandbox.ca(&["render", "kalimba", "-q", "--seconds", "0.2", "--set", set, "--probe", &probe]).is(0);
        std::fs::read_to_string(sandbox.path(to)).expect(to)
    };
    let (plain, heavy) = (render("tine[2..5].thumb.m=1 g", "plain.csv"), render("tine[*].thumb.m=3 g", "heavy.csv"));
    let head = plain.lines().next().expect("a head");
    assert!(head.contains("tine[0].thumb") && head.contains("tine[6].thumb"), "{head}");
    assert_ne!(plain, heavy, "the thumb of 1 g, as it is, and one of 3 g");
    sandbox.ca(&["render", "kalimba", "--set", "tine[9].thumb.m=3 g"]).is(2).says(&["`tine[9].thumb.m`"]);
    sandbox.ca(&["render", "kalimba", "--set", "tine[*].tumb.m=3 g"]).is(2).says(&["did you mean"]);
}

/// A MIDI file with one note of each velocity, one second apart.
fn strokes(note: u8, velocities: &[u8]) -> Vec<u8> {
    let mut track = Vec::new();
    for (i, v) in velocities.iter().enumerate() {
        // ticks since the previous event, 480 per half second; 720 is 85 50 as a variable-length quantity
        track.extend(if i == 0 { vec![0] } else { vec![0x85, 0x50] });
        track.extend([0x90, note, *v, 0x81, 0x70, 0x80, note, 0]);
    }
    track.extend([0, 0xff, 0x2f, 0]);
    let mut file = b"MThd\0\0\0\x06\0\0\0\x01\x01\xe0MTrk".to_vec();
    file.extend((track.len() as u32).to_be_bytes());
    file.extend(track);
    file
}

#[test]
fn velocity_is_how_loud_a_pluck_is() {
    let sandbox = Sandbox::new();
    for (model, note) in [("kalimba", 64), ("plucked_string", 50), ("natural_harmonic", 45), ("pinched_string", 45)] {
        std::fs::write(sandbox.path("strokes.mid"), strokes(note, &[20, 60, 120])).expect("written");
        sandbox.ca(&["render", model, "-q", "--seconds", "2.9", "--gesture", "strokes.mid", "-o", "x.wav"]).is(0);
        let (spec, sound) = sandbox.wav("x.wav");
        let second = spec.sample_rate as usize * usize::from(spec.channels);
        // peak in the first 0.2 s after each stroke
        let loud: Vec<f64> =
            (0..3).map(|i| crate::sandbox::peak(&sound[i * second..i * second + second / 5])).collect();
        assert!(loud[1] > 1.3 * loud[0] && loud[2] > 1.3 * loud[1], "{model}: {loud:?}");
    }
}

/// Dangling links: an output is written to the target, and an input is not suggested.
#[cfg(unix)]
#[test]
fn links_to_files_that_are_not_there() {
    use std::os::unix::fs::symlink;
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    symlink("new.wav", sandbox.path("link.wav")).unwrap();
    sandbox.ca(&["render", "bar.ca.toml", "-o", "link.wav", "--seconds", "0.1"]).is(0);
    assert!(sandbox.path("link.wav").is_symlink() && sandbox.path("new.wav").is_file());
    symlink("round.wav", sandbox.path("round.wav")).unwrap();
    let r = sandbox.ca(&["render", "bar.ca.toml", "-o", "round.wav", "--seconds", "0.1"]).is(1);
    r.says(&["its symbolic links form a loop"]);
    assert!(sandbox.path("round.wav").is_symlink());
    symlink("loop.ca.toml", sandbox.path("loop.ca.toml")).unwrap();
    let r = sandbox.ca(&["check", "loop.ca.toml"]).is(2).says(&["a symbolic link that does not lead to a file"]);
    assert!(!r.err.contains("did you mean"), "{}", r.err);
    // nor is it suggested for a similar word
    let r = sandbox.ca(&["check", "lop.ca.toml"]).is(2);
    assert!(!r.err.contains("loop"), "{}", r.err);
}
