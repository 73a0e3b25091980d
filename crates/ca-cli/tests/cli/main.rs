//! Tests the built binary in an empty directory, as users run it.

mod documents;
#[path = "../../../../tests/src/long_form.rs"]
mod long_form;
mod model;
mod sandbox;
mod session;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;
mod sound;

use sandbox::{BAR, KEY, Sandbox, mims};
use std::fs;
use std::process::{Command, Stdio};

#[test]
fn what_is_misspelt_gets_an_answer() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    sandbox.ca(&["render", "hammred_string"]).is(2).says(&["did you mean `hammered_string`?"]);
    sandbox.ca(&["render", "bra.ca.toml"]).is(2).says(&["no such file", "did you mean `bar.ca.toml`?"]);
    sandbox.ca(&["check", "bar"]).is(2).says(&["did you mean `bar.ca.toml`?"]);
    sandbox.ca(&["render", "bar.ca.toml", "--set", "laud=1"]).is(2).says(&["did you mean `loud`?"]);
    sandbox.ca(&["render", "bar.ca.toml", "--set", "bar.t6=1"]).is(2).says(&["did you mean `bar.t60`?"]);
    sandbox.ca(&["render", "bar.ca.toml", "--set", "bra.m=1"]).is(2).says(&["did you mean `bar.m`?"]);
    sandbox.ca(&["render", "bar.ca.toml", "--probe", "bat"]).is(1).says(&["E013", "`bat`", "`bar`"]);
    sandbox.ca(&["explain", "e13"]).is(2).says(&["did you mean `E013`?"]);
    sandbox.ca(&["list", "BTU"]).is(2).says(&["did you mean `BUT`?"]);
    sandbox.ca(&["list", "parts"]).is(0).says(&["  plectrum ", "  a key that plucks a string"]);
    sandbox.ca(&["list", "plectrum"]).is(0).says(&[
        "on ",
        "required",
        "plectrum = { part = \"plectrum\", with = { on = …",
    ]);
    sandbox.ca(&["list", "plectrun"]).is(2).says(&["did you mean `plectrum`?"]);
    sandbox.ca(&["new", "x.ca.toml", "--from", "strin"]).is(2).says(&["did you mean `string`?"]);
    sandbox.ca(&["rendr"]).is(2).says(&["render"]);
    assert_eq!(sandbox.files(), ["bar.ca.toml"]);
}

#[test]
fn usage_is_refused_before_anything_is_written() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR).put("bar.csv", "time,bar\n0,1\n").put("bar.wav", "mine");
    for (args, word) in [
        (&["render"][..], "MODEL"),
        (&["render", "bar.ca.toml", "-o", "x.mp3"], "`.wav` or `.flac`"),
        (&["render", "bar.ca.toml", "--seconds", "4 kg"], "quantity in s"),
        (&["render", "bar.ca.toml", "--seconds", "0"], "between"),
        (&["render", "bar.ca.toml", "--rate", "fast"], "starts with a number"),
        (&["render", "bar.ca.toml", "--set", "loud"], "hammer.m"),
        (&["render", "bar.ca.toml", "--format", "8"], "f32"),
        (&["render", "bar.ca.toml", "--probe", "bar", "--probe", "bar"], "twice"),
        (&["render", "bar.ca.toml", "--probe", "bar=a.npy", "--probe", "out=a.npy"], "twice"),
        (&["render", "bar.ca.toml", "--probe", "bar=x.mat"], "`.npy` or `.csv`"),
        (&["render", "bar.ca.toml", "--gesture", "bar.csv"], "`bar` is not a port or live parameter"),
        (&["render", "bar.ca.toml", "--gesture", "bar.wav"], "overwritten"),
        (&["report", "bar.ca.toml", "-o", "x.pdf"], "`.html`"),
        (&["accuracy", "bar.ca.toml", "-o", "x.pdf"], "`.html`"),
        (&["report", "bar.ca.toml", "--gesture", "bar.csv"], "`bar` is not a port or live parameter"),
        (&["new", "x.toml"], "x.ca.toml"),
    ] {
        sandbox.ca(args).is(2).says(&[word]);
    }
    sandbox.ca(&["render", "bar.ca.toml", "-o", "no/x.wav"]).is(1).says(&["make the directory first"]);
    sandbox.ca(&["render", "bar.ca.toml", "--gesture", "no.csv"]).is(1).says(&["`no.csv`"]);
    assert_eq!(sandbox.files(), ["bar.ca.toml", "bar.csv", "bar.wav"]);
    assert_eq!(fs::read(sandbox.path("bar.wav")).unwrap(), b"mine");
}

#[test]
fn errors_of_a_model_point_at_their_places() {
    let sandbox = Sandbox::new();
    let two = "[MAS]\nbill = { m = \"20 s\", dx1 = 3 }\nbob = { m = 1 }\n[RES]\nr = { between = [\"bob\", \"bib\"], k = 1 }\n";
    sandbox.put("a.ca.toml", two);
    for command in ["render", "check"] {
        let r =
            sandbox.ca(&[command, "a.ca.toml"]).is(1).says(&["E004", "E008", "a.ca.toml:2:", "did you mean `bob`?"]);
        assert_eq!(r.out, "");
    }
    sandbox.put("mute.ca.toml", "[CEL]\nbar = { m = 1, f = 9, dx0 = 1 }\n");
    sandbox.ca(&["render", "mute.ca.toml"]).is(1).says(&["no output", "SOX"]);
    fs::write(sandbox.path("odd.ca.toml"), b"[CEL]\n# caf\xe9\n").unwrap();
    sandbox.ca(&["render", "odd.ca.toml"]).is(1).says(&["UTF-8", "line 2, column 6"]);
    sandbox.ca(&["render", "."]).is(1);
    assert_eq!(sandbox.files(), ["a.ca.toml", "mute.ca.toml", "odd.ca.toml"]);
}

/// A negative number is the value of the preceding option, which refuses it.
#[test]
fn negative_numbers_are_judged_as_any_other() {
    let sandbox = Sandbox::new();
    for line in [
        "render x --seconds -1",
        "render x --rate -1",
        "render x --latency -1",
        "render x --gesture g.csv --gesture-rate -3",
        "accuracy x --error -1",
        "accuracy x --times -1",
        "accuracy x --reference -1",
        "modes x --modes -1",
        "modes x -n -1",
        "tune x a=A3 --a4 -1",
        "tune x a=A3 --mode -1",
        "fit x --to t.wav --vary a.f --seconds -1",
        "fit x --to t.wav --vary a.f --renders -1",
        "equiv x --key a --lever -2",
        "report x --accuracy -1",
        "serve x --cpu -1",
        "serve x --priority -1",
        "serve x --audio --audio-buffer -1",
        "sweep x --threads -1",
        "device sim --rate -1",
        "device sim --speed -1",
        "device sim --seed -1",
        "device sim --delay -1",
    ] {
        let ran = sandbox.ca(&line.split(' ').collect::<Vec<_>>()).is(2).says(&["invalid value '-"]);
        assert!(!ran.err.contains("tip"), "{line}: {}", ran.err);
    }
}

/// An error about `--set` refers to the option, not to a line of the file.
#[test]
fn what_is_set_is_told_from_what_is_written() {
    let sandbox = Sandbox::new();
    sandbox.put(
        "room.ca.toml",
        "[param]\nstiff = { value = \"1 kN/m\", live = true, min = \"0.5 kN/m\", max = \"2 kN/m\" }\n[room]\ndim = 2\n\
         gravity = \"9.81 m/s^2\"\n[room.MAS]\na = { m = \"1 g\", x = [0, 0] }\n[CEL]\nb = { m = \"1 g\", k = \"stiff\" }\n\
         [SOX]\nout = { from = \"b\" }\nalso = { from = \"room.a\", along = \"x\" }\n",
    );
    let set = |what: &str| sandbox.ca(&["check", "room.ca.toml", "--set", what]);
    sandbox.ca(&["check", "room.ca.toml"]).is(0);
    set("room.gravity=1").is(2).says(&["--set: `gravity` of the group `room`", "room.ca.toml:5"]);
    set("room.friction=1").is(2).says(&["add it below `[room]`, room.ca.toml:3"]);
    set("room.a.x=[1,2]").is(2).says(&["--set: `room.a.x`: a list", "room.ca.toml:7"]);
    set("room.a.x[1]=2 mm").is(0);
    set("room.a.x[7]=2 mm").is(2).says(&["the model has no `room.a.x[7]`"]);
    set("model.title=[1,2]").is(0);
    let ran = set("stiff=1 kg").is(1).says(&["E008", "in kg", "`min` is in N/m", "set the value in the unit"]);
    assert!(!ran.err.contains("room.ca.toml:2"), "{}", ran.err);
    set("stiff=99999").is(1).says(&["E009", "99999 N/m", "from 500 N/m to 2000 N/m"]);
    set("stiff=1500").is(0);
    set("stiff=1.5 kN/m").is(0);
}

/// Commands whose examples run in other tests: those for a running server (`session/serve.rs`), for devices (`--test
/// loop verbs`), and `ca bench`, which takes minutes (`sound/bench.rs` runs a shorter one).
const RUN_ELSEWHERE: &[&str] = &["set", "audio", "arm", "disarm", "status", "stop", "device", "bench"];

fn commands(general: &str) -> Vec<&str> {
    let list = general.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let commands: Vec<&str> =
        list.lines().filter_map(|l| l.split_whitespace().next()).filter(|c| *c != "help").collect();
    assert!(commands.len() >= 20, "{commands:?}");
    commands
}

#[cfg(unix)]
#[test]
fn examples_of_command_help_run() {
    let mut ran = 0;
    let general = Sandbox::new().ca(&["--help"]).is(0).out;
    for command in commands(&general).into_iter().filter(|c| !RUN_ELSEWHERE.contains(c)) {
        let sandbox = Sandbox::new();
        if ["replay", "log", "report"].contains(&command) {
            session::take::performer::tgr12(&sandbox.path("take.mcap"));
        }
        if command == "export" {
            sandbox.put("mine.ca.toml", ca_lab::load::STARTER);
        }
        sandbox
            .put("key.csv", KEY)
            .put("string.mdl", &mims("string.mdl"))
            .put("plucked.sweep.toml", &sound::sweep::plan());
        let help = sandbox.ca(&[command, "--help"]).is(0).out;
        assert!(
            general.contains(help.lines().next().unwrap()),
            "{command} says two things of itself:\n{help}\n{general}"
        );
        let (_, examples) = help.split_once("Examples:\n").unwrap_or_else(|| panic!("{command} has no examples"));
        for line in examples.lines().filter(|l| !l.trim().is_empty()) {
            let done = sandbox.sh(line);
            // real-time commands report degradation on a busy machine
            let late = ["play", "serve"].contains(&command) && done.code == 3;
            // pages for browsers need a build with the engine (`model/export.rs`)
            let lacks = ["export", "site"].contains(&command) && ca_site::modules().is_none();
            done.is(if late { 3 } else { i32::from(lacks) });
            ran += 1;
        }
    }
    assert!(ran >= 45, "only {ran} examples were found");
}

/// The help of a command says more than its line in the list: what it does, its rules, and how it ends.
#[test]
fn every_command_explains_itself() {
    let sandbox = Sandbox::new();
    let general = sandbox.ca(&["--help"]).is(0).out;
    for command in commands(&general) {
        let help = sandbox.ca(&[command, "--help"]).is(0).out;
        let about = help.split("Usage:").next().unwrap();
        let paragraphs = about.split("\n\n").filter(|p| !p.trim().is_empty()).count();
        assert!(paragraphs >= 2, "ca {command} --help says no more than the list:\n{help}");
    }
    // help of commands that may move a hand mentions the safety switch
    for command in [&["serve"][..], &["device", "conformance"]] {
        sandbox.ca(&[command, &["--help"]].concat()).is(0).says(&["a switch that cuts the power of the motors"]);
    }
}

#[test]
fn a_reader_who_goes_away_is_no_failure() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_ca"))
        .args(["list", "--schema"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let o = child.wait_with_output().unwrap();
    assert_eq!((o.status.code(), o.stderr.len()), (Some(0), 0));
}
