//! Tests `ca check`, `ca list`, `ca new` and `ca import`.

use crate::sandbox::{STRUCK, Sandbox, mims, peak};
use std::fs;

#[test]
fn check_tells_what_it_knows() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let r = sandbox.ca(&["check", "struck.ca.toml", "--schedule"]).is(0);
    let r = r.says(&[
        "45 MAT",
        "key",
        "3 kHz",
        "rule of thumb",
        "ns/tick",
        "predicted",
        "measured here",
        "no gravity",
        "run",
    ]);
    let place = |w: &str| r.out.find(w).unwrap_or_else(|| panic!("no {w}"));
    assert!(place("  reads") < place("  forces"));
    assert!(place("  forces") < place("  writes") && place("  writes") < place("  moves"));
    let j = sandbox.ca(&["check", "struck.ca.toml", "--schedule", "--json", "--set", "low.n=20"]).is(0).json();
    assert_eq!(j["summary"]["modules"]["CEL"], 20);
    let passes = j["schedule"]["passes"].as_array().unwrap();
    assert!(passes.iter().any(|p| p["pass"] == "REF" && p["stride"] == 1 && p["modules"] == 21));
    assert!(passes.iter().all(|p| p["ns_per_tick"].as_f64().is_some()));
    // each pass and the tick have predictions in ns and in instructions
    let of = |j: &serde_json::Value, key: &str| j[key].as_f64().unwrap_or_else(|| panic!("no {key} in {j}"));
    let each = of(&j["schedule"], "ns_per_instruction");
    for p in passes.iter().chain([&j["schedule"]]) {
        assert!((of(p, "ns_predicted") / of(p, "instructions_predicted") / each - 1.0).abs() < 1e-9, "{p}");
    }
    let sum: f64 = passes.iter().map(|p| of(p, "instructions_predicted")).sum();
    assert!(of(&j["schedule"], "instructions_predicted") > sum);
    // filters of a waveguide: without `t60_high` the gain of a round trip, and no filter without losses
    assert_eq!(j["schedule"]["waveguide_filters"], serde_json::json!([]));
    let string = "[WAVEGUIDE]\nw = { f = 440, t60 = 2, z = 1, at = 0.3, m = 1e-12 }\n[SOX]\no = { from = \"w[0]\" }\n";
    sandbox.put("wave.ca.toml", string);
    let r = sandbox.ca(&["check", "wave.ca.toml", "--schedule"]).is(0).says(&["Waveguide filters", "from w[0]"]);
    assert!(r.out.contains("b 0.000000000000"), "{}", r.out);
    let waves = sandbox.ca(&["check", "wave.ca.toml", "--schedule", "--json"]).is(0).json();
    let filter = &waves["schedule"]["waveguide_filters"][0];
    assert!((of(filter, "a") / 10f64.powf(-3.0 / (440.0 * 2.0)) - 1.0).abs() < 1e-6, "{filter}");
    // a mesh is one pass with all its links
    let mesh = "[MESH]\nm = { nx = 20, ny = 20, m = 1e-3, k = 1e3 }\n[MAS]\nh = { m = 1e-3, v = 1 }\n[BUT]\nb = { between = \
                [\"h\", \"m[3,3]\"], k = 1e3 }\n[SOX]\no = { from = \"m[7,7]\" }\n";
    sandbox.put("mesh.ca.toml", mesh);
    let j = sandbox.ca(&["check", "mesh.ca.toml", "--schedule", "--json"]).is(0).json();
    let links: Vec<_> = j["schedule"]["passes"].as_array().unwrap().iter().filter(|p| !p["stride"].is_null()).collect();
    let [contact, mesh] = links[..] else { panic!("{links:?}") };
    assert_eq!((&contact["modules"], &mesh["modules"]), (&1.into(), &j["summary"]["modules"]["RES"]));
    // a high pass of motion is listed as a high pass
    sandbox.put(
        "speed.ca.toml",
        "[CEL]\nc = { m = 1e-3, f = 200, v = 1 }\n[SOX]\no = { from = \"c\", hear = \"speed\", dc = \"20 Hz\" }\n",
    );
    let r = sandbox.ca(&["check", "speed.ca.toml", "--schedule"]).is(0).says(&["high pass of motion", "no low-pass"]);
    assert!(!r.out.contains("no high pass"), "{}", r.out);
    // an implicit contact comes after all explicit forces
    let r = sandbox.ca(&["check", "struck.ca.toml", "--schedule", "--set", "strike.method=stable"]).is(0);
    let place = |w: &str| r.out.rfind(w).unwrap_or_else(|| panic!("no {w}"));
    assert!(place("REF") < place("BUT stable") && place("BUT stable") < place("writes"));
    sandbox.put("a.ca.toml", "[MAS]\nbob = { m = \"20 s\" }\n");
    let j = sandbox.ca(&["check", "a.ca.toml", "--json"]).is(1).json();
    assert!(j["summary"].is_null() && j["schedule"].is_null());
    assert_eq!((&j["diagnostics"][0]["code"], &j["diagnostics"][0]["line"]), (&"E008".into(), &2.into()));
}

#[test]
fn list_shows_kinds_models_and_pages() {
    let sandbox = Sandbox::new();
    let j = sandbox.ca(&["list", "--json"]).is(0).json();
    let codes: Vec<&str> = j["kinds"].as_array().unwrap().iter().map(|k| k["code"].as_str().unwrap()).collect();
    assert!(codes.contains(&"BUT") && codes.contains(&"STRING"));
    let table = sandbox.ca(&["list", "--markdown"]).is(0).out;
    let text = sandbox.ca(&["list"]).is(0).out;
    for code in &codes {
        let page = sandbox.ca(&["list", &code.to_lowercase()]).is(0).says(&["Example", "Sources"]);
        // a part of the same name comes first
        assert!(page.out.starts_with(code) || page.out.contains(&format!("\n\n{code}  ")), "{}", page.out);
        assert!(text.contains(code) && table.contains(&format!("| {code} | ")));
        let page = sandbox.ca(&["list", code, "--json"]).is(0).json();
        assert!(page["sources"].as_array().unwrap().iter().all(|s| s["reference"].as_str().unwrap().len() > 20));
        sandbox.put("example.ca.toml", page["example"].as_str().unwrap());
        sandbox.ca(&["render", "example.ca.toml", "--seconds", "500 ms", "-q"]).is(0);
        assert!(peak(&sandbox.wav("example.wav").1) > 0.001, "the example of {code} is silent");
    }
    // cells do not contain an unescaped bar, so every row has as many as the head
    let bars = |l: &str| l.replace("\\|", "").matches('|').count();
    assert!(table.lines().filter(|l| l.starts_with('|')).all(|l| bars(l) == 6), "{table}");
    sandbox.ca(&["list", "BUT"]).is(0).says(&["[N/m] ≥ 0", "outside | inside", "hal-01089222", "hammer"]);
    let schema = sandbox.ca(&["list", "--schema"]).is(0).json();
    assert!(schema["properties"]["BUT"].is_object());
}

#[test]
fn the_page_of_each_part_is_shown() {
    let sandbox = Sandbox::new();
    let j = sandbox.ca(&["list", "parts", "--json"]).is(0).json();
    let names: Vec<&str> = j.as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"bow") && names.contains(&"piano_key"));
    for name in names {
        let r = sandbox.ca(&["list", name]).is(0).says(&["Parameters", &format!("{name} = {{ part = \"{name}\"")]);
        assert!(r.out.starts_with(&format!("{name}: ")), "{}", r.out);
        let j = sandbox.ca(&["list", name, "--json"]).is(0).json();
        let first = if j.is_array() { &j[0] } else { &j };
        assert!(first["params"].as_array().is_some_and(|p| !p.is_empty()), "{j}");
    }
    // other pages with the name follow; the exact name of the kind finds only that kind
    sandbox.ca(&["list", "piano_key"]).is(0).says(&["ca render piano_key"]);
    sandbox.ca(&["list", "bow"]).is(0).says(&["\n\nBOW  "]);
    assert!(sandbox.ca(&["list", "BOW"]).is(0).out.starts_with("BOW  "));
}

#[test]
fn bundled_models_have_a_title_and_no_errors() {
    let sandbox = Sandbox::new();
    let j = sandbox.ca(&["list", "models", "--json"]).is(0).json();
    assert!(!j.as_array().unwrap().is_empty());
    for model in j.as_array().unwrap() {
        let (name, title) = (model["name"].as_str().unwrap(), model["title"].as_str().unwrap());
        assert!(!title.is_empty());
        sandbox.ca(&["list", name]).is(0).says(&[title, "ca render"]);
        // some models exist to demonstrate divergence
        let r = sandbox.ca(&["check", name, "--json"]);
        assert!(r.code == 0 || r.code == 3, "{name}: {}", r.out);
    }
}

#[test]
fn the_list_of_models_says_how_each_is_played() {
    let sandbox = Sandbox::new();
    let list = sandbox.ca(&["list", "models"]).is(0).says(&["docs/instruments.md"]).out;
    let j = sandbox.ca(&["list", "models", "--json"]).is(0).json();
    let by = |name: &str| j.as_array().unwrap().iter().find(|m| m["name"] == name).unwrap()["played"].clone();
    assert_eq!(by("hammer_piano"), serde_json::json!(["TGR keys", "MIDI", "gesture"]));
    assert_eq!(by("jack"), serde_json::json!(["by itself"]));
    let line = list.lines().find(|l| l.contains(" hammer_piano ")).unwrap();
    assert!(line.contains("TGR keys, MIDI, gesture"), "{line}");
}

#[test]
fn a_new_model_checks_and_sounds() {
    let sandbox = Sandbox::new();
    sandbox.ca(&["new", "mine.ca.toml"]).is(0).says(&["ca render mine.ca.toml"]);
    let r = sandbox.ca(&["check", "mine.ca.toml"]).is(0);
    assert_eq!(r.err, "", "the first model of a newcomer has no findings");
    sandbox.ca(&["render", "mine.ca.toml"]).is(0);
    assert!(peak(&sandbox.wav("mine.wav").1) > 0.05);
    sandbox.put("mine.ca.toml", "precious");
    sandbox.ca(&["new", "mine.ca.toml"]).is(1).says(&["--force"]);
    assert_eq!(fs::read(sandbox.path("mine.ca.toml")).unwrap(), b"precious");
    sandbox.ca(&["new", "mine.ca.toml", "--from", "hammered_string", "--force"]).is(0);
    sandbox.ca(&["check", "mine.ca.toml"]).is(0).says(&["1 BUT", "key"]);
}

#[test]
fn a_mims_model_is_imported_and_compiled() {
    let sandbox = Sandbox::new();
    sandbox.put("string.mdl", &mims("string.mdl")).put("odd.mdl", "@a mass one 0. 0.\n");
    sandbox.ca(&["import", "string.mdl"]).is(0).says(&["N201", "string.mdl:6:2", "it compiles", "9 MAT"]);
    let first = fs::read(sandbox.path("string.ca.toml")).unwrap();
    sandbox.ca(&["import", "string.mdl"]).is(1).says(&["--force"]);
    sandbox.ca(&["import", "string.mdl", "-o", "gut.ca.toml"]).is(0);
    assert_eq!(first, fs::read(sandbox.path("gut.ca.toml")).unwrap());
    sandbox.ca(&["render", "string.mdl", "-q"]).is(0);
    assert_eq!(sandbox.wav("string.wav").0.sample_rate, 44_100);
    // as saved by an old editor: Latin-1, with lines that end in a carriage return
    let old = [b"# corde fix\xe9e\r".to_vec(), b"@g ground 0\r@a mass 1 0 0\r@r spring @g @a 0.1\r".to_vec()].concat();
    fs::write(sandbox.path("old.mdl"), [&old[..], b"@o posOutput @a\r"].concat()).unwrap();
    sandbox.ca(&["import", "old.mdl"]).is(0).says(&["lines from 5", "it compiles", "2 MAT"]);
    fs::write(sandbox.path("wrong.mdl"), [&old[..], b"@o posOutput @b\r"].concat()).unwrap();
    sandbox.ca(&["import", "wrong.mdl"]).is(1).says(&["wrong.mdl:5:14", "unknown name: `b`"]);
    // an invalid value is refused with its place in the original file, and nothing is written
    sandbox.put("light.mdl", "@a mass -1 0 0\n@o posOutput @a\n");
    sandbox.ca(&["import", "light.mdl"]).is(1).says(&["light.mdl:1:9", "`M` of `a` is out of range: -1"]);
    assert!(!sandbox.path("light.ca.toml").exists());
    let r = sandbox.ca(&["import", "odd.mdl"]).is(1).says(&["odd.mdl:1:"]);
    assert_eq!(r.out, "");
    sandbox.ca(&["render", "odd.mdl"]).is(1).says(&["odd.mdl:1:"]);
    sandbox.ca(&["import", "no.mdl"]).is(1);
}

/// Commands that change a model file refuse a foreign one at once. A copy may be written beside it.
#[test]
fn a_mims_model_is_not_changed() {
    let sandbox = Sandbox::new();
    sandbox.put("string.mdl", &mims("string.mdl"));
    sandbox.ca(&["tune", "string.mdl", "str=A2"]).is(2).says(&["a MIMS file cannot be tuned", "ca import"]);
    sandbox.ca(&["render", "string.mdl", "-q"]).is(0);
    sandbox
        .ca(&["fit", "string.mdl", "--to", "string.wav", "--vary", "str.k", "--write", "fitted.ca.toml"])
        .is(2)
        .says(&["a MIMS file cannot be written", "ca import"]);
    sandbox
        .ca(&["equiv", "string.mdl", "--set", "mass=20 g:1 g", "--in-place"])
        .is(2)
        .says(&["a MIMS file cannot store equivalences"]);
    sandbox.ca(&["equiv", "string.mdl", "--set", "mass=20 g:1 g", "--write", "heavy.ca.toml"]).is(0);
    sandbox.ca(&["check", "heavy.ca.toml"]).is(0);
}

/// Endless files are refused as takes, and a calibration stays in its folder.
#[cfg(unix)]
#[test]
fn a_take_is_a_file_and_a_device_has_a_plain_name() {
    let sandbox = Sandbox::new();
    std::os::unix::fs::symlink("/dev/zero", sandbox.path("zero.mcap")).unwrap();
    for args in [
        &["log", "info", "zero.mcap"][..],
        &["replay", "zero.mcap"],
        &["render", "hammered_string", "--gesture", "zero.mcap"],
    ] {
        sandbox.ca(args).is(1).says(&["zero.mcap", "not a regular file"]);
    }
    for name in ["../../x", ""] {
        let r = sandbox.ca(&["device", "calibrate", name, "--low", "0", "--high", "1"]);
        assert_ne!(r.code, 0, "{}", r.err);
        r.says(&["invalid device name", "a-z"]);
    }
}
