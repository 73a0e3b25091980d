//! Tests `ca sweep`: reproducible runs, complete chunks, and rows for failed runs.

use crate::sandbox::{Sandbox, blocks, from_root};
use ca_sweep::{Column, RunTable};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

pub fn plan() -> String {
    let page = fs::read_to_string(from_root("docs/sweep.md")).unwrap();
    blocks(&page, "toml")[0].1.to_owned()
}

#[test]
fn the_plan_of_the_help_is_a_plan() {
    let sandbox = Sandbox::new();
    let help = sandbox.ca(&["sweep", "--help"]).is(0).out;
    let plan = help.split_once("A plan:\n").unwrap().1.split("It may also have").next().unwrap();
    sandbox.put("help.sweep.toml", plan).ca(&["sweep", "help.sweep.toml", "--dry-run"]).is(0).says(&["200"]);
}

const SMALL: &str = r#"
model = "struck.ca.toml"
seconds = 0.05
runs = 23
seed = 5
audio = "flac"
chunk = 5
[set]
"model.title" = "small"
[vary]
"#;

fn small() -> String {
    format!("{SMALL}{VARIED}")
}

const STRUCK: &str = r#"
[STRING]
low = { n = 20, k = "4 kN/m", m = "1 g", z = "1 mN s/m", t60 = "1 s" }
[MAS]
hammer = { m = "20 g", x = "-5 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[8]"], k = "8 kN/m", z = "0.2 N s/m" }
[SOX]
out = { from = "low[3]", gain = 50 }
"#;

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    sandbox
}

const VARIED: &str = r#"
"low.k" = { from = "1 kN/m", to = "9 kN/m", log = true }
"low.n" = [10, 20, 40]
"#;

fn files(root: &Path) -> BTreeMap<String, Vec<u8>> {
    fn walk(root: &Path, at: &Path, all: &mut BTreeMap<String, Vec<u8>>) {
        for file in fs::read_dir(at).unwrap().flatten() {
            if file.path().is_dir() {
                walk(root, &file.path(), all);
            } else {
                let name = file.path().strip_prefix(root).unwrap().to_string_lossy().into_owned();
                all.insert(name, fs::read(file.path()).unwrap());
            }
        }
    }
    let mut all = BTreeMap::new();
    walk(root, root, &mut all);
    all
}

/// Files that do not contain times.
fn same_every_time(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let timed = |name: &str| name.ends_with("rows.parquet") || name == "times.parquet";
    files(root).into_iter().filter(|(name, _)| !timed(name)).collect()
}

fn texts(t: &RunTable, name: &str) -> Vec<Option<String>> {
    match t.column(name) {
        Some(Column::Text(v)) => v.clone(),
        other => panic!("{name}: {other:?}"),
    }
}

fn numbers(t: &RunTable, name: &str) -> Vec<Option<f64>> {
    match t.column(name) {
        Some(Column::Number(v)) => v.clone(),
        other => panic!("{name}: {other:?}"),
    }
}

fn manifest(sandbox: &Sandbox, folder: &str) -> RunTable {
    RunTable::read(&sandbox.path(folder).join("manifest.parquet")).unwrap()
}

#[test]
fn threads_parts_and_resumption_give_the_same_files() {
    let sandbox = sandbox();
    sandbox.put("s.sweep.toml", &small());
    let ran = sandbox.ca(&["sweep", "s.sweep.toml", "--threads", "1"]).is(0);
    assert!(ran.out.contains("23 of 23 runs") && ran.out.contains("23 ok"), "{}", ran.out);
    let one = same_every_time(&sandbox.path("s"));
    assert_eq!(one.keys().filter(|k| k.contains(".flac")).count(), 23);
    assert!(one.contains_key("manifest.parquet") && one.contains_key("runs-000020/000022.flac"));

    sandbox.ca(&["sweep", "s.sweep.toml", "--threads", "3", "-o", "three"]).is(0);
    assert_eq!(same_every_time(&sandbox.path("three")), one);

    // in parts, the last first; only the complete set has a manifest
    let part = |k: &str| sandbox.ca(&["sweep", "s.sweep.toml", "-o", "parts", "--shard", k]).is(0).out;
    assert!(part("3/3").contains("other parts are not done yet"));
    assert!(!sandbox.path("parts/manifest.parquet").exists());
    part("1/3");
    assert!(part("2/3").contains("all runs are done"));
    assert_eq!(same_every_time(&sandbox.path("parts")), one);

    // only a missing chunk is computed again
    fs::remove_dir_all(sandbox.path("parts/runs-000010")).unwrap();
    fs::create_dir(sandbox.path("parts/.runs-000010.gone1-0.part")).unwrap();
    let again = sandbox.ca(&["sweep", "s.sweep.toml", "-o", "parts", "--json"]).is(0).out;
    let again: serde_json::Value = serde_json::from_str(&again).unwrap();
    assert_eq!((again["played"].as_u64(), again["complete"].as_bool()), (Some(5), Some(true)));
    assert_eq!(same_every_time(&sandbox.path("parts")), one, "and what was left half done is gone");
    let nothing = sandbox.ca(&["sweep", "s.sweep.toml", "-o", "parts"]).is(0).out;
    assert!(nothing.contains("0 of 23"), "{nothing}");
}

#[test]
fn a_run_is_a_render() {
    let sandbox = sandbox();
    sandbox.put("s.sweep.toml", &small().replace("flac", "wav"));
    sandbox.ca(&["sweep", "s.sweep.toml"]).is(0);
    let table = manifest(&sandbox, "s");
    let (k, n) = (numbers(&table, "low.k"), numbers(&table, "low.n"));
    let (peaks, files) = (numbers(&table, "peak"), texts(&table, "file"));
    assert!(k.iter().flatten().all(|k| (1e3..9e3).contains(k)));
    for run in [0, 7, 22] {
        let set = [format!("low.k={:?}", k[run].unwrap()), format!("low.n={}", n[run].unwrap())];
        let mut args = vec!["render", "struck.ca.toml", "--seconds", "0.05", "-o", "r.wav", "--json", "--no-fade"];
        args.extend(set.iter().flat_map(|s| ["--set", s]));
        let reported: serde_json::Value = serde_json::from_str(&sandbox.ca(&args).is(0).out).unwrap();
        let mine = fs::read(sandbox.path("s").join(files[run].as_ref().unwrap())).unwrap();
        assert_eq!(mine, fs::read(sandbox.path("r.wav")).unwrap(), "run {run}: the same bytes");
        let loudest = reported["channels"].as_array().unwrap().iter().map(|c| c["peak"].as_f64().unwrap());
        let (mine, loudest) = (peaks[run].unwrap(), loudest.fold(0.0, f64::max));
        // the JSON parser may round the last digit
        assert!((mine / loudest - 1.0).abs() < 1e-15, "{mine} {loudest}");
    }
}

#[test]
fn a_bad_run_is_a_row() {
    let sandbox = sandbox();
    let axis = r#""low.k" = [-1, "4 kN/m", "4 m", 1e9]"#;
    sandbox.put("b.sweep.toml", &format!("model = \"struck.ca.toml\"\nseconds = 0.1\nenergy = true\n[vary]\n{axis}\n"));
    let ran = sandbox.ca(&["sweep", "b.sweep.toml"]).is(0);
    let table = manifest(&sandbox, "b");
    let status: Vec<String> = texts(&table, "status").into_iter().flatten().collect();
    let message: Vec<String> = texts(&table, "message").into_iter().flatten().collect();
    assert_eq!(status, ["invalid", "ok", "invalid", "unstable"], "{message:?} {}", ran.out);
    assert!(message[0].contains('E') && message[1].is_empty() && message[3].contains("diverged"), "{message:?}");
    assert!(numbers(&table, "failed")[3].is_some_and(|t| t < 0.1));
    assert!(texts(&table, "module")[3].as_ref().is_some_and(|m| m.contains("low")), "{table:?}");
    assert_eq!(texts(&table, "file")[0], None);
    assert!(numbers(&table, "residual")[1].is_some_and(|r| r < 1e-9));
    let k: Vec<f64> = numbers(&table, "low.k").into_iter().flatten().collect();
    assert_eq!(k, [-1.0, 4e3, 4.0, 1e9], "in SI units, whatever units they are");
    // a pitch is missing for a diverged run
    assert!(numbers(&table, "partial")[1].is_some_and(|f| f > 20.0) && numbers(&table, "partial")[3].is_none());
}

#[test]
fn folders_that_were_left_or_shared_go_on() {
    let sandbox = sandbox();
    // the folder is beside the plan and named like it
    sandbox.put(
        "plucked_string.sweep.toml",
        "model = \"plucked_string\"\nseconds = 0.01\n[vary]\n\"low.f\" = [\"110 Hz\"]\n",
    );
    for _ in 0..2 {
        sandbox.ca(&["sweep", "plucked_string.sweep.toml"]).is(0).says(&[]);
    }
    // two processes share the work
    sandbox.put("s.sweep.toml", &small().replace("runs = 23", "runs = 200").replace("seconds = 0.05", "seconds = 0.5"));
    let both: Vec<_> = (0..2).map(|_| sandbox.start(&["sweep", "s.sweep.toml", "--threads", "1"])).collect();
    for child in both {
        assert!(child.wait_with_output().unwrap().status.success());
    }
    let whole = same_every_time(&sandbox.path("s"));
    assert_eq!(whole.len(), 200 + 2);
    // truncated and missing rows are computed again
    fs::write(sandbox.path("s/runs-000000/rows.parquet"), b"PAR1").unwrap();
    fs::remove_file(sandbox.path("s/runs-000010/rows.parquet")).unwrap();
    let again = sandbox.ca(&["sweep", "s.sweep.toml"]).is(0).out;
    assert!(again.contains("10 of 200 runs"), "{again}");
    assert_eq!(same_every_time(&sandbox.path("s")), whole);
    // a number and its text are different plans
    sandbox.put("n.sweep.toml", "model = \"struck.ca.toml\"\nseconds = 0.01\n[vary]\n\"low.n\" = [10, 20]\n");
    sandbox.ca(&["sweep", "n.sweep.toml"]).is(0);
    sandbox.put("n.sweep.toml", "model = \"struck.ca.toml\"\nseconds = 0.01\n[vary]\n\"low.n\" = [\"10\", \"20\"]\n");
    sandbox.ca(&["sweep", "n.sweep.toml"]).is(2).says(&["another sweep"]);
}

#[test]
fn without_a_number_every_combination_is_played() {
    let sandbox = sandbox();
    let axes = "\"low.n\" = [10, 20]\n\"low.k\" = { from = 1000, to = 4000, steps = 3, log = true }";
    sandbox.put(
        "g.sweep.toml",
        &format!("model = \"struck.ca.toml\"\nseconds = 0.01\naudio = \"none\"\n[vary]\n{axes}\n"),
    );
    sandbox.ca(&["sweep", "g.sweep.toml"]).is(0);
    let table = manifest(&sandbox, "g");
    let n: Vec<f64> = numbers(&table, "low.n").into_iter().flatten().collect();
    let k: Vec<f64> = numbers(&table, "low.k").into_iter().flatten().collect();
    assert_eq!(n, [10.0, 10.0, 10.0, 20.0, 20.0, 20.0]);
    assert_eq!(k, [1000.0, 2000.0, 4000.0, 1000.0, 2000.0, 4000.0]);
    assert!(table.column("file").is_none() && files(&sandbox.path("g")).keys().all(|f| !f.ends_with("flac")));
}

#[test]
fn what_makes_no_sense_is_said_with_its_line() {
    let sandbox = sandbox();
    let says = |plan: &str, what: &[&str]| {
        sandbox.put("p.sweep.toml", plan);
        sandbox.ca(&["sweep", "p.sweep.toml"]).is(2).says(what);
    };
    says("modle = \"rattle\"\n", &["p.sweep.toml:1", "did you mean `model`"]);
    says("seed = 1\n", &["`model` is missing"]);
    says("model = \"ratle\"\n[vary]\na = [1]\n", &["p.sweep.toml:1", "did you mean `rattle`"]);
    says("model = \"rattle\"\n", &["`[vary]` is missing"]);
    says("model = \"rattle\"\nruns = 0\n[vary]\n", &["1 to"]);
    says("model = \"rattle\"\nruns = \"many\"\n[vary]\n", &["p.sweep.toml:2", "whole number"]);
    says("model = \"struck.ca.toml\"\n[vary]\n\"lwo.k\" = [1]\n", &["p.sweep.toml:3", "did you mean `low.k`"]);
    says("model = \"struck.ca.toml\"\n[vary]\n\"low.k\" = { from = 1, to = 2 }\n", &["`runs`", "`steps`"]);
    says("model = \"struck.ca.toml\"\n[vary]\n\"low.k\" = { from = 1 }\n", &["p.sweep.toml:3", "to = "]);
    says(
        "model = \"struck.ca.toml\"\n[vary]\n\"low.k\" = { from = -1, to = 2, log = true, steps = 3 }\n",
        &["above 0"],
    );
    says("model = \"struck.ca.toml\"\n[vary]\n\"low.k\" = []\n", &["p.sweep.toml:3", "0 values"]);
    says("model = \"struck.ca.toml\"\n[vary\n", &["p.sweep.toml:2"]);
    says("model = \"struck.ca.toml\"\naudio = \"mp3\"\n[vary]\n\"low.k\" = [1]\n", &["p.sweep.toml:2", "flac"]);
    says("model = \"struck.ca.toml\"\n[vary]\n\"rate.sound\" = [44100]\n", &["one rate"]);
    says(
        "model = \"struck.ca.toml\"\nruns = 1000000000000\nchunk = 1\n[vary]\n\"low.k\" = [1000]\n",
        &["make `chunk` larger"],
    );
    sandbox.put(
        "p.sweep.toml",
        "model = \"struck.ca.toml\"\n[vary]\n\"low.k\" = { from = \"1 m\", to = \"2 m\", steps = 2 }\n",
    );
    sandbox.ca(&["sweep", "p.sweep.toml"]).is(1).says(&["E008", "N/m"]);
    sandbox.ca(&["sweep", "no.sweep.toml"]).is(1).says(&["no.sweep.toml", "cannot be read"]);
    sandbox.put("p.sweep.toml", &small());
    sandbox.ca(&["sweep", "p.sweep.toml", "--shard", "3/2"]).is(2).says(&["1/2"]);

    fs::create_dir(sandbox.path("mine")).unwrap();
    sandbox.put("mine/a.txt", "");
    sandbox.ca(&["sweep", "p.sweep.toml", "-o", "mine"]).is(2).says(&["not empty"]);
    sandbox.ca(&["sweep", "p.sweep.toml"]).is(0);
    sandbox.put("p.sweep.toml", &small().replace("seed = 5", "seed = 6"));
    sandbox.ca(&["sweep", "p.sweep.toml"]).is(2).says(&["another sweep", "sweep.toml"]);
}

/// Units are checked as in a model, and an error names one place.
#[test]
fn units_and_places_of_a_plan_are_said_as_of_a_model() {
    let sandbox = sandbox();
    let says = |plan: &str, code: i32, what: &[&str]| {
        sandbox.put("p.sweep.toml", &format!("model = \"struck.ca.toml\"\n{plan}"));
        let ran = sandbox.ca(&["sweep", "p.sweep.toml"]).is(code).says(what);
        assert_eq!(ran.err.matches("p.sweep.toml:").count(), 1, "{}", ran.err);
    };
    for (line, is) in [
        ("seconds = \"0.1 kg\"", "`seconds` must be in s, not in kg"),
        ("seconds = \"0.1 Hz\"", "`seconds` must be in s, not in Hz"),
        ("seconds = \"0.1 s s\"", "`seconds` must be in s, not in"),
        ("gesture_rate = \"100 g\"", "`gesture_rate` must be in Hz, not in kg"),
        ("rate = \"44100 g\"", "`rate` must be in Hz, not in kg"),
        ("[set]\n\"low.z\" = \"1 s\"", "`z` of `low` must be in N s/m, not in s"),
    ] {
        let at = if line.starts_with('[') { "p.sweep.toml:3:" } else { "p.sweep.toml:2:" };
        says(&format!("{line}\n[vary]\n\"low.k\" = [1000]\n"), 1, &["E008", is, at]);
    }
    says("seconds = -1\n[vary]\n", 1, &["E009", "p.sweep.toml:2:"]);
    says("seconds = \"long\"\n[vary]\n", 2, &["p.sweep.toml:2: `seconds` must be a number of seconds"]);
    let range = "{ from = \"1 kN/m\", to = \"2 m\", steps = 2 }";
    says(&format!("[vary]\n\"low.k\" = {range}\n"), 1, &["E008", "p.sweep.toml:3:", "in N/m, not in m"]);
    says("runs = 0\n[vary]\n\"low.k\" = [1000]\n", 2, &["p.sweep.toml:2: `runs` must be a whole number from 1 to"]);
    let range = "{ from = 1, to = 2, steps = 1e9 }";
    says(&format!("[vary]\n\"low.k\" = {range}\n"), 2, &["p.sweep.toml:3: `steps` must be a whole number"]);
    says("[vary]\n\"low.k\" = { from = 1, to = 2 }\n", 2, &["p.sweep.toml:3: ", "`runs`"]);
    says("[vary]\n\"rate.sound\" = [44100]\n", 2, &["p.sweep.toml:3: ", "one rate"]);
    // a name with a dot, without quotes
    says("[vary]\nlow.k = [1, 2]\n", 2, &["p.sweep.toml:3: ", "write `\"low.k\" = …`"]);
    says("[set]\nlow.k = 1\n[vary]\n", 2, &["p.sweep.toml:3: ", "write `\"low.k\" = …`"]);
    let twice = "[set]\n\"low.k\" = 1000\n[vary]\n\"low.k\" = [1000, 2000]\n";
    says(twice, 2, &["p.sweep.toml:3: `low.k` is set here and varied in line 5"]);
    assert!(!sandbox.path("p").exists());
}

#[cfg(unix)]
#[test]
fn what_is_stopped_goes_on() {
    let sandbox = sandbox();
    let plan = small().replace("runs = 23", "runs = 400").replace("seconds = 0.05", "seconds = 0.5");
    sandbox.put("s.sweep.toml", &plan);
    for signal in ["INT", "KILL"] {
        let child = sandbox.start(&["sweep", "s.sweep.toml", "--threads", "2"]);
        let end = std::time::Instant::now() + std::time::Duration::from_secs(60);
        // temporary files appear and disappear meanwhile
        let count = || {
            fs::read_dir(sandbox.path("s"))
                .unwrap()
                .flatten()
                .filter(|f| f.file_name().to_string_lossy().starts_with("runs-"))
                .count()
        };
        let before = if sandbox.path("s").exists() { count() } else { 0 };
        while !sandbox.path("s").exists() || count() < before + 2 {
            assert!(std::time::Instant::now() < end, "nothing was written");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        sandbox.sh(&format!("kill -{signal} {}", child.id()));
        let ended = child.wait_with_output().unwrap();
        let status = ended.status;
        assert!(!status.success());
        if signal == "INT" {
            assert_eq!(status.code(), Some(130));
            let said = String::from_utf8(ended.stderr).unwrap();
            let (there, _) = said.split_once(" of 400 runs are kept in `s`").unwrap_or_else(|| panic!("{said}"));
            let there: usize = there.rsplit(' ').next().unwrap().parse().unwrap();
            assert!(there > 0 && there < 400 && said.contains("run the same command again to continue"), "{said}");
            assert!(files(&sandbox.path("s")).keys().all(|f| !f.contains(".part")), "what is not finished is gone");
        }
        assert!(!sandbox.path("s/manifest.parquet").exists());
    }
    sandbox.ca(&["sweep", "s.sweep.toml"]).is(0).says(&[]);
    sandbox.ca(&["sweep", "s.sweep.toml", "-o", "whole"]).is(0);
    assert_eq!(same_every_time(&sandbox.path("s")), same_every_time(&sandbox.path("whole")));
}
