//! Tests `ca render` with exit code 3: divergence and clipping.

use crate::sandbox::{BAR, KEY, STRUCK, Sandbox, peak};

pub const UNSTABLE: &str = r#"
[SOL]
wall = {}
[MAS]
bob = { m = "1 g", dx0 = "1 mm" }
[REF]
spring = { between = ["wall", "bob"], k = "20 MN/m", z = "1 mN s/m" }
[SOX]
out = { from = "bob", gain = 100 }
"#;

/// Two walls much too hard for the bar between them.
const RATTLE: &str = r#"
[CEL]
bar = { m = "2 g", f = "330 Hz", t60 = "1 s" }
[SOL]
wall = { x = "1 mm" }
floor = { x = "-1 mm" }
[BUT]
up = { between = ["bar", "wall"], k = "40 MN/m" }
down = { between = ["floor", "bar"], k = "40 MN/m" }
[ENF]
push = { to = "bar" }
[SOX]
out = { from = "bar", gain = 100 }
[gesture]
push = [[0, 0], [0.01, "200 N"], [0.02, 0]]
"#;

/// The audited first half second is at rest; a port moves the model later.
#[test]
fn a_model_that_diverges_after_its_audit_is_not_told_a_time_that_nobody_saw() {
    let sandbox = Sandbox::new();
    sandbox.put(
        "late.ca.toml",
        "[ENX]\nhand = {}\n[MAS]\nbob = { m = \"1 g\" }\n[REF]\nspring = { between = [\"hand\", \"bob\"], k = \"10 MN/m\" }\n[SOX]\nout \
         = { from = \"bob\" }\n[gesture]\nhand = [[0, 0], [1.5, 0], [1.6, \"1 mm\"]]\n",
    );
    let r = sandbox.ca(&["render", "late.ca.toml", "--seconds", "2"]).is(3);
    assert!(r.out.contains("out of range after 0.5000 s") && r.out.contains("`--energy` shows when"), "{}", r.out);
    let r = sandbox.ca(&["render", "late.ca.toml", "--seconds", "2", "--energy"]).is(3);
    assert!(r.out.contains("out of range at 1.5"), "{}", r.out);
}

#[test]
fn an_unstable_model_is_named_and_silenced() {
    let sandbox = Sandbox::new();
    sandbox.put("bad.ca.toml", UNSTABLE).put("rattle.ca.toml", RATTLE);
    let cases = [("bad", &["bob"][..], "keep `k` of `spring`"), ("rattle", &["up", "down"], "keep `k` below")];
    for (model, guilty, advice) in cases {
        let file = format!("{model}.ca.toml");
        let r = sandbox.ca(&["render", &file, "--seconds", "1"]).is(3);
        let module = guilty.iter().find(|m| r.err.contains(&format!("`{m}`: "))).unwrap_or_else(|| panic!("{}", r.err));
        assert!(r.err.contains("diverged at 0.00") && r.err.contains(advice), "{}", r.err);
        let (_, samples) = sandbox.wav(&format!("{model}.wav"));
        assert_eq!(samples.len(), 48_000);
        assert!(samples.iter().all(|s| s.is_finite() && s.abs() <= 1.0));
        assert!(peak(&samples) > 0.01 && peak(&samples[4800..]) == 0.0);
        // the ledger stops in time and names the same module
        let j = sandbox.ca(&["render", &file, "--seconds", "1", "--energy", "--json"]).is(3).json();
        assert_eq!(j["blown_up"]["module"].as_str(), Some(*module));
        assert!(j["energy"]["relative_residual"].as_f64().unwrap() < 1e-9, "{j:#}");
        assert!(j["energy"]["seconds"].as_f64().unwrap() < 0.01);
    }
    sandbox.ca(&["check", "bad.ca.toml"]).is(3).says(&["W103", "unstable"]);
    let contacts = "an impact may add energy at any value; a lossless ball between two walls, played at kT²/m near ";
    sandbox.ca(&["check", "rattle.ca.toml"]).is(0).says(&["W117", "`up` is the stiffest", contacts]);
    // between the cheap bounds, a factorisation decides, and on request reports the distance from the limit
    let r = sandbox.ca(&["check", "harmonic_chain", "--exact"]).is(0);
    for word in ["stability  proven", "decided by a factorisation", "largest eigenvalue 3.99"] {
        assert!(r.out.contains(word), "{}", r.out);
    }
    // a linearised certificate reports the largest rise in energy: λ = 0.2, 0.4/3.8
    sandbox.put(
        "room.ca.toml",
        "[room]\ndim = 3\n[room.SOL]\na = { x = [-1, 0, 0] }\nb = { x = [1, 0, 0] }\n[room.MAS]\nm = { m = 1e-3, \
         x = [0, 0, 0] }\n[REF]\ns = { between = [[\"room.a\", \"room.b\"], \"room.m\"], k = 230400, l0 = 0.5 }\n[SOX]\n\
         out = { from = \"room.m\", along = \"x\" }\n",
    );
    let r = sandbox.ca(&["check", "room.ca.toml"]).is(0);
    assert!(r.out.contains("linear part proven") && r.out.contains("rises by at most 10.5 %"), "{}", r.out);
    let j = sandbox.ca(&["check", "room.ca.toml", "--json"]).is(0).json();
    assert!((j["summary"]["stability"]["ripple"].as_f64().unwrap() - 0.4 / 3.8).abs() < 1e-12, "{j:#}");
    let proven = sandbox.ca(&["check", "harmonic_chain", "--json"]).is(0).json()["summary"]["stability"].clone();
    assert!(proven["level"] == "proven" && proven["ripple"].is_null(), "{proven:#}");
}

/// A mass of one gram with a speed, on a table that is steep beyond one millimetre.
fn table(v: f64) -> String {
    format!(
        "[SOL]\nw = {{}}\n[MAS]\nb = {{ m = 1e-3, v = {v:?} }}\n[LNL]\nc = {{ between = [\"w\", \"b\"], spring = [[-0.01, -1e5], [-0.001, -1], [0.001, \
         1], [0.01, 1e5]] }}\n[SOX]\no = {{ from = \"b\" }}\n"
    )
}

/// A render compares the energy made by a table with the energy received, not with a peak made by the table. A table is
/// not reported as unstable if the energy does not reach its steep part.
#[test]
fn energy_that_is_made_is_compared_with_what_was_received() {
    let sandbox = Sandbox::new();
    sandbox.put("steep.ca.toml", &table(1.0)).put("soft.ca.toml", &table(0.01));
    for more in [&["--seconds", "3", "--energy"][..], &["--seconds", "1", "--energy"], &["--seconds", "3"]] {
        let r = sandbox.ca(&[&["render", "steep.ca.toml"], more].concat()).is(3);
        assert!(r.err.contains("`c` created") && r.err.contains("more than the"), "{}", r.err);
        sandbox.ca(&[&["render", "soft.ca.toml"], more].concat()).is(0);
    }
    sandbox.ca(&["check", "soft.ca.toml"]).is(0).says(&["rule of thumb, decided by `c`"]);
    sandbox.ca(&["check", "steep.ca.toml"]).is(0).says(&["W107", "decisive: a slope of up to"]);
    // weight gives energy that is not present at load
    sandbox.put(
        "falls.ca.toml",
        "[g]\ngravity = 9.81\n[g.SOL]\nfloor = {}\n[g.MAS]\nball = { m = \"10 g\", x = \"1 cm\" }\n[BUT]\nhit = { between = [\"g.floor\", \"g.ball\"], \
         k = \"1 MN/m\" }\n[SOX]\nout = { from = \"g.ball\" }\n",
    );
    sandbox.ca(&["render", "falls.ca.toml", "--seconds", "2", "--energy"]).is(0);
}

#[test]
fn what_is_cut_off_is_counted_and_the_gain_fits() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    let loud = ["render", "bar.ca.toml", "--set", "loud=1500"];
    let j = sandbox.ca(&[&loud[..], &["--json", "--ceiling"]].concat()).is(3).json();
    assert!(j["clipped"]["samples"].as_u64().unwrap() > 100 && j["blown_up"].is_null());
    assert!((j["channels"][0]["peak"].as_f64().unwrap() - 1.5).abs() < 0.01);
    assert_eq!(peak(&sandbox.wav("bar.wav").1), 1.0);
    let fits = 1500.0 * j["clipped"]["gain"].as_f64().unwrap();
    sandbox.ca(&["render", "bar.ca.toml", "--set", &format!("loud={fits}")]).is(0);
    assert!(peak(&sandbox.wav("bar.wav").1) > 0.99);
    sandbox.ca(&[&loud[..], &["--format", "16"]].concat()).is(3).says(&["beyond full scale, cut off", "0.66"]);
}

#[test]
fn floats_hold_what_is_beyond_full_scale_and_a_level_may_be_asked_for() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    let loud = ["render", "bar.ca.toml", "--set", "loud=1500"];
    sandbox.ca(&loud).is(0).says(&["beyond full scale, kept in 32-bit floats", "0.66"]);
    let (_, all) = sandbox.wav("bar.wav");
    assert!((peak(&all) - 1.5).abs() < 0.01, "{}", peak(&all));
    let j = sandbox.ca(&[&loud[..], &["--normalize", "-1dBFS", "--json", "--no-fade"]].concat()).is(0).json();
    let (_, same) = sandbox.wav("bar.wav");
    let (to, gain) = (10.0_f64.powf(-1.0 / 20.0), j["gain"].as_f64().unwrap());
    assert!((peak(&same) - to).abs() < 1e-6 && j["clipped"].is_null() && j["faded"] == false);
    assert!((gain * 1.5 / to - 1.0).abs() < 0.01, "{gain}");
    let levels = sandbox.ca(&["check", "bar.ca.toml", "--set", "loud=1500", "--levels", "--json"]).is(0).json();
    let row = &levels["levels"][0];
    assert!((row["peak"].as_f64().unwrap() * row["gain_factor"].as_f64().unwrap() - 0.5).abs() < 1e-12, "{levels:#}");
    for wrong in ["3", "loud", "-201dBFS", "nan"] {
        sandbox.ca(&["render", "bar.ca.toml", "--normalize", wrong]).is(2).says(&["dBFS"]);
    }
}

#[test]
fn a_body_that_drifts_is_named_and_a_sound_that_goes_on_is_faded() {
    let sandbox = Sandbox::new();
    sandbox.put("drift.ca.toml", "[MAS]\nloose = { m = \"1 g\", v = \"0.1 m/s\" }\n[CEL]\nbar = { m = \"1 g\", f = \"A4\", t60 = 9, dx0 = \"1 mm\" }\n\
         [SOX]\nout = { from = \"loose\" }\nbar_x = { from = \"bar\", gain = 500 }\n");
    let r = sandbox.ca(&["render", "drift.ca.toml", "--seconds", "2"]).is(0);
    let r = r.says(&["of the power of `out` is below 5 Hz", "`loose` is furthest from rest"]);
    assert!(r.out.contains("the last 20 ms are faded"), "{}", r.out);
    let (_, faded) = sandbox.wav("drift.wav");
    assert_eq!(faded[faded.len() - 1], 0.0);
    sandbox.ca(&["render", "drift.ca.toml", "--seconds", "2", "--no-fade"]).is(0);
    let (_, plain) = sandbox.wav("drift.wav");
    assert!(plain[..plain.len() - 2 * 960] == faded[..plain.len() - 2 * 960] && plain[plain.len() - 1] != 0.0);
}

#[test]
fn what_blows_is_reported_with_the_command_that_shows_why() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    sandbox.put("key.csv", KEY);
    let args = ["render", "struck.ca.toml", "--set", "strike.k=1e15 N/m", "--gesture", "key.csv"];
    let r = sandbox.ca(&args).is(3).says(&["findings", "`ca check struck.ca.toml --set 'strike.k=1e15 N/m'`"]);
    assert!(!r.err.contains("multiply the gain"), "{}", r.err);
    sandbox.ca(&["check", "struck.ca.toml", "--set", "strike.k=1e15 N/m"]).says(&["W117", "`strike`"]);
    // the slope of a power law is taken at a depth; for an absurd stiffness that depth is too small for any blow
    let hard = |k: &str| {
        let r =
            sandbox.ca(&["check", "hammered_string", "--set", "model.method=ca", "--set", k, "--json"]).is(0).json();
        let depth = &r["summary"]["stability"]["depth"];
        assert_eq!(depth["contact"], "strike", "{r:#}");
        depth["m"].as_f64().unwrap()
    };
    let ratio = hard("strike.k=1e30") / hard("strike.k=4e12");
    assert!((ratio / (4e12_f64 / 1e30).sqrt() - 1.0).abs() < 1e-9, "{ratio}");
    let words = "stiffens with depth: slope·T²/m is 1 at ";
    let explicit = ["hammered_string", "--set", "model.method=ca"];
    sandbox.ca(&[&["check"], &explicit[..]].concat()).says(&["`strike` ", words]);
    sandbox.ca(&[&["report"], &explicit[..], &["-o", "string.html"]].concat()).is(0);
    assert!(std::fs::read_to_string(sandbox.path("string.html")).unwrap().contains(words));
}
