//! Tests sounds through pipes, FLAC, and models from standard input.

use crate::sandbox::{BAR, STRUCK, Sandbox};
use std::fs;
use std::process::{Command, Stdio};

#[cfg(unix)]
#[test]
fn a_pipe_gets_the_sound_of_the_file() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    for more in ["", "--format 24", "--format flac", "--format flac16", "--normalize -3dBFS", "--format 16 --ceiling"] {
        let name = if more.contains("flac") { "a.flac" } else { "a.wav" };
        let r = sandbox.sh(&format!("ca render bar.ca.toml {more} -o {name}")).is(0);
        assert!(r.out.contains(name) && !r.err.contains("margin"), "{}", r.out);
        let whole = fs::read(sandbox.path(name)).unwrap();
        assert!(whole.len() > 1000, "{more}");
        for line in [
            "ca render bar.ca.toml MORE -o - | cat > p",
            "ca render bar.ca.toml MORE -o /dev/stdout | cat > p",
            "ca render bar.ca.toml MORE -o - > p",
            "mkfifo f; cat f > p & ca render bar.ca.toml MORE -o f > said; wait; cat said >&2; rm f said",
        ] {
            let r = sandbox.sh(&line.replace("MORE", more)).is(0);
            assert!(fs::read(sandbox.path("p")).unwrap() == whole, "{line} {more}");
            // the summary is not mixed into the sound
            assert_eq!(r.out, "");
            r.says(&["0.100 s", "margin"]);
        }
        // existing content is kept
        sandbox.sh(&format!("printf before > p; ca render bar.ca.toml {more} -o - >> p 2> said; rm said")).is(0);
        assert!(fs::read(sandbox.path("p")).unwrap() == [b"before", &whole[..]].concat(), "{more}");
    }
    let r = sandbox.sh("ca render bar.ca.toml --json -o - > p").is(0);
    let (_, json) = r.err.split_once('\n').unwrap();
    assert_eq!(serde_json::from_str::<serde_json::Value>(json).unwrap()["file"], "-");
    // a probe works too, although its header contains the length
    sandbox.sh("ca render bar.ca.toml -q --probe bar=b.npy; mkfifo f.npy; cat f.npy > p & ca render bar.ca.toml -q --probe bar=f.npy; wait")
        .is(0);
    assert!(fs::read(sandbox.path("b.npy")).unwrap() == fs::read(sandbox.path("p")).unwrap());
    // a performance needs standard output for its summary
    sandbox
        .sh("ca serve bar.ca.toml -o - --seconds 1 | cat; ca serve bar.ca.toml -o /dev/stdout --seconds 1 || exit $?")
        .is(2)
        .says(&["standard output is used for the summary"]);
}

#[cfg(unix)]
#[test]
fn a_listener_who_goes_away_is_no_failure() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    let mut child = Command::new(env!("CARGO_BIN_EXE_ca"))
        .args(["render", "bar.ca.toml", "-o", "-", "-q"])
        .current_dir(&sandbox.0)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let o = child.wait_with_output().unwrap();
    assert_eq!((o.status.code(), String::from_utf8(o.stderr).unwrap()), (Some(0), String::new()));
}

/// An independent decoder reads the integers of the WAV file.
#[test]
fn flac_holds_the_samples_of_wav() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let render = |args: &[&str]| sandbox.ca(&[&["render", "struck.ca.toml", "--seconds", "300 ms"], args].concat());
    for (file, format, bits) in [
        ("a.flac", None, 24),
        ("a.flac", Some("16"), 16),
        ("a.flac", Some("flac"), 24),
        ("struck.flac", Some("flac16"), 16),
    ] {
        let format: Vec<&str> = format.map_or(vec![], |f| vec!["--format", f]);
        let output = if file == "a.flac" { vec!["-o", file] } else { vec![] };
        let json = render(&[&format[..], &output[..], &["--json"]].concat()).is(0).json();
        assert_eq!(json["format"], format!("{bits}-bit FLAC"));
        render(&["-q", "-o", "a.wav", "--format", &bits.to_string()]).is(0);
        let (info, samples) = sandbox.flac(file);
        assert_eq!((info, samples.len()), ([48_000, 2, bits], 28_800));
        assert!(samples == sandbox.wav("a.wav").1, "{file} {bits}");
        assert!(crate::sandbox::peak(&samples) > 0.1);
    }
    for (args, word) in [
        (&["-o", "a.flac", "--format", "f32"][..], "FLAC cannot store floats"),
        (&["-o", "a.wav", "--format", "flac"], "the extension is `.wav`"),
        (&["-o", "a.mp3"], "`.wav` or `.flac`"),
        (&["-o", "b.flac", "--rate", "699 kHz"], "655350 Hz"),
    ] {
        render(args).is(2).says(&[word]);
    }
    assert_eq!(sandbox.files(), ["a.flac", "a.wav", "struck.ca.toml", "struck.flac"]);
}

#[cfg(unix)]
#[test]
fn a_model_comes_from_standard_input() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    sandbox.sh("ca render bar.ca.toml -q; ca render - -q < bar.ca.toml; cmp bar.wav stdin.wav").is(0);
    sandbox.sh("cat bar.ca.toml | ca check - --set loud=100").is(0);
    sandbox.sh("sed s/CEL/CELL/ bar.ca.toml | ca check -").is(1).says(&["stdin:7:", "`CEL`"]);
    sandbox.sh("printf 'caf\\351' | ca check -").is(1).says(&["`stdin`", "UTF-8"]);
    sandbox.sh("ca render - -q -o - < bar.ca.toml | cmp - bar.wav").is(0);
    sandbox.sh("ca tune - bar=A3 --in-place < bar.ca.toml || exit $?").is(2).says(&["cannot be changed in place"]);
    sandbox.sh("ca tune - bar=A3 --write a3.ca.toml < bar.ca.toml").is(0);
    sandbox.sh("ca check - --watch < bar.ca.toml || exit $?").is(2).says(&["`-` is a bundled model or standard input"]);
}

#[test]
fn words_of_other_programs_are_understood_or_lead_to_ours() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    for (rate, hertz) in [("96k", 96_000), ("44.1k", 44_100), ("96 kHz", 96_000), ("48000", 48_000)] {
        sandbox.ca(&["render", "bar.ca.toml", "-q", "--rate", rate]).is(0);
        assert_eq!(sandbox.wav("bar.wav").0.sample_rate, hertz, "{rate}");
    }
    for (rate, word) in [("96kk", "`kk`"), ("k", "starts with a number"), ("96 km", "a quantity in Hz")] {
        sandbox.ca(&["render", "bar.ca.toml", "--rate", rate]).is(2).says(&[word]);
    }
    for (other, ours) in [
        ("--bits", "--format"),
        ("--bit-depth", "--format"),
        ("--duration", "--seconds"),
        ("--length", "--seconds"),
        ("--sample-rate", "--rate"),
    ] {
        sandbox.ca(&["render", "bar.ca.toml", other, "24"]).is(2).says(&["unexpected argument", &format!("'{ours}'")]);
    }
    let help = sandbox.ca(&["render", "--help"]).is(0).out;
    assert!(!help.contains("--bits") && !help.contains("--duration"), "{help}");
}
