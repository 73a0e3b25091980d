//! Tests that very large and very small numbers have an exponent in all output.

use crate::sandbox::{RunOutput, Sandbox};

/// Longest run of digits and points.
fn longest(r: &RunOutput) -> usize {
    let all = format!("{} {}", r.out, r.err);
    all.split(|c: char| !c.is_ascii_digit() && c != '.').map(str::len).max().unwrap_or(0)
}

#[test]
fn no_number_has_more_digits_than_a_float_has() {
    let sandbox = Sandbox::new();
    for k in ["1e99", "1e-99"] {
        let text = format!(
            "[param]\np = {{ value = {k}, live = true, max = {k}, unit = \"N/m\" }}\n\
             [TGR]\nkey = {{ device = \"tgr12\", dof = 0 }}\n\
             [MAS]\nbob = {{ m = \"10 g\", v = \"1 m/s\" }}\n[SOL]\nwall = {{}}\n\
             [RES]\na = {{ between = [\"key\", \"bob\"], k = {k} }}\nc = {{ between = [\"wall\", \"bob\"], k = \"p\" }}\n\
             [BUT]\nb = {{ between = [\"wall\", \"bob\"], k = {k} }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
        );
        sandbox.put("far.ca.toml", &text);
        let [low, high] = [format!("a.k=-{k}"), format!("wall.x={k}")];
        for args in [
            &["check", "far.ca.toml"][..],
            &["check", "far.ca.toml", "--device", "tgr12"],
            &["render", "far.ca.toml", "--seconds", "0.01"],
            &["render", "far.ca.toml", "--seconds", k],
            &["render", "far.ca.toml", "--seconds", "0.01", "--set", &low],
            &["render", "far.ca.toml", "--seconds", "0.01", "--set", &high],
            &["render", "far.ca.toml", "--seconds", "0.01", "--rate", k],
            &["equiv", "far.ca.toml", "--set", "mass=20g:1.0"],
            &["equiv", "far.ca.toml", "--set", &format!("mass={k}:1.0")],
            &["equiv", "far.ca.toml", "--set", &format!("mass=1.0:{k}")],
        ] {
            let r = sandbox.ca(args);
            assert!(!r.out.is_empty() || !r.err.is_empty(), "{args:?} says nothing");
            assert!(longest(&r) <= 18, "{args:?}\n{}\n{}", r.out, r.err);
        }
        sandbox.put("far.ca.toml", &text);
    }
    // the numbers do appear in the output
    sandbox.ca(&["equiv", "far.ca.toml", "--set", "mass=1e99:1.0"]).is(1).says(&["[1e99, 1.0]"]);
    sandbox.ca(&["render", "far.ca.toml", "--set", "a.k=1e99"]).says(&["too stiff for its mass", "e91"]);
}

/// Computed values have six digits and a unit: rates that do not divide, and values drawn in a sweep.
#[test]
fn what_was_computed_has_six_digits_and_its_unit() {
    let sandbox = Sandbox::new();
    let hammer = &["check", "hammer_piano", "--rate", "50021"][..];
    for args in [hammer, &["check", "hammer_piano", "--rate", "50021", "--device", "tgr12"]] {
        let r = sandbox.ca(args);
        assert!(r.out.contains("2942.41 Hz") && longest(&r) <= 10, "{args:?}\n{}", r.out);
    }
    let plan = "model = \"plucked_string\"\nseconds = 0.01\nruns = 2000000\nseed = 1\naudio = \"none\"\n[vary]\n\
                \"pick.k\" = { from = \"1 kN/m\", to = \"9 kN/m\", log = true }\n\"low.t60\" = { from = \"0.3 s\", to = \"3 s\" }\n\
                \"low.f\" = [\"110 Hz\", \"123.1 Hz\"]\n";
    sandbox.put("drawn.sweep.toml", plan);
    let r = sandbox.ca(&["sweep", "drawn.sweep.toml", "--dry-run"]).is(0);
    let line = |name: &str| r.out.lines().find(|l| l.contains(name)).unwrap_or_else(|| panic!("{name}: {}", r.out));
    for (name, unit) in [("pick.k = ", " N/m in the first"), ("low.t60 = ", " s in the first"), ("low.f = ", " Hz in")]
    {
        assert!(line(name).contains(unit) && longest(&r) <= 8, "{}", r.out);
    }
    // two million runs of a few milliseconds take hours
    let whole = line("all runs would take ").split("all runs would take ").nth(1).unwrap_or_default();
    assert!([" min", " h", " days"].iter().any(|unit| whole.contains(unit)), "{whole}");
}

#[test]
fn levels_beyond_any_loudspeaker_are_words() {
    let sandbox = Sandbox::new();
    let text = |k: f64| {
        format!(
            "[SOL]\nw = {{}}\n[MAS]\na = {{ m = \"1 mg\", dx0 = \"1 mm\" }}\n[REF]\nl = {{ between = [\"w\", \"a\"], k = {k:?}, z = 1e-6 }}\n\
             [SOX]\nfaint = {{ from = \"a\", gain = 1e-13 }}\nout = {{ from = \"a\" }}\nhuge = {{ from = \"a\", gain = 1e15 }}\n"
        )
    };
    sandbox.put("model.ca.toml", &text(100.0));
    let r = sandbox.ca(&["render", "model.ca.toml", "--seconds", "0.1"]).is(0);
    assert!(r.out.contains("peak       faint silent, out -60.0 dBFS, huge over 200 dBFS"), "{}", r.out);
    sandbox.put("model.ca.toml", &text(1e8));
    let r = sandbox.ca(&["render", "model.ca.toml", "--seconds", "0.1"]).is(3);
    assert!(r.out.contains("out diverged") && r.out.contains("huge diverged"), "{}", r.out);
    sandbox.put("model.ca.toml", &text(100.0).replace("out = ", "# ").replace("huge = ", "# "));
    sandbox.ca(&["render", "model.ca.toml", "--seconds", "0.1"]).is(0).says(&["faint silent", "is silent", "`gain`"]);
}

/// A link that makes energy is named, and the exit code is 3. Energy of a falling mass comes from its weight and is not
/// reported.
#[test]
fn a_link_that_makes_most_of_the_energy_is_named() {
    let sandbox = Sandbox::new();
    let model = |k: &str| {
        format!(
            "[MAS]\nball = {{ m = \"1 g\" }}\nbob = {{ m = \"20 g\", x = \"-5.01 mm\", v = \"1 m/s\" }}\n\
             [BUT]\nhit = {{ between = [\"bob\", \"ball\"], k = {k} }}\n[SOX]\nout = {{ from = \"ball\", gain = 1e-9 }}\n"
        )
    };
    let falls = "[model]\ngravity = \"9.81 m/s^2\"\n[SOL]\nfloor = { x = \"-5 mm\" }\n[MAS]\nball = { m = \"1 g\" }\n\
                 [BUT]\nbounce = { between = [\"floor\", \"ball\"], k = \"8 kN/m\" }\n[SOX]\nout = { from = \"ball\" }\n";
    for (text, code) in [
        (model("\"8 kN/m\""), 0),
        (model("\"1e12 N/m\""), 3),
        (model("\"1e12 N/m\", method = \"stable\""), 0),
        (falls.into(), 0),
    ] {
        sandbox.put("model.ca.toml", &text);
        let r = sandbox.ca(&["render", "model.ca.toml", "--seconds", "0.1"]).is(code);
        let named = r.err.contains("`hit` created ")
            && r.err.contains("of energy, more than the")
            && r.err.contains("`method = \"stable\"`");
        assert_eq!(named, code == 3, "{}", r.err);
    }
}

/// An unstable pluck makes hundreds of joules from millijoules while it holds, and its viscosity removes a part of
/// them.
#[test]
fn energy_that_viscosity_takes_again_is_not_received() {
    let sandbox = Sandbox::new();
    for z in [97, 200, 300] {
        let text = format!(
            "[MAS]\na = {{ m = \"1 g\", x = \"1 mm\", v = \"-1 m/s\" }}\n[SOL]\ng = {{}}\n\
             [PLK]\nc = {{ between = [\"g\", \"a\"], k = \"1 kN/m\", z = {z}, d = \"1 cm\" }}\n\
             [SOX]\no = {{ from = \"a\", gain = 0.001 }}\n"
        );
        sandbox.put("model.ca.toml", &text);
        sandbox.ca(&["render", "model.ca.toml", "--seconds", "2"]).is(3).says(&["`c` created ", "of energy, more"]);
    }
}

#[test]
fn what_was_not_judged_and_what_has_no_limit_is_said() {
    let sandbox = Sandbox::new();
    let text = "[SOL]\nw = {}\n[MAS]\na = { m = \"1 g\", x = \"1 mm\", v = \"-1 m/s\" }\nlost = { m = \"1 mg\" }\n[RES]\nj = { between = [\"lost\", \"w\"], k = \"1 GN/m\" }\n\
                [BUT]\nl = { between = [\"w\", \"a\"], k = \"23.04 MN/m\" }\n[SOX]\nout = { from = \"a\" }\n";
    sandbox.put("model.ca.toml", text);
    let r = sandbox.ca(&["check", "model.ca.toml"]).is(0);
    assert!(
        r.out.contains("margin 0.100") && r.out.contains("not judged, no output depends on it: `lost`"),
        "{}",
        r.out
    );
    let j = sandbox.ca(&["check", "model.ca.toml", "--json"]).is(0).json();
    assert_eq!(j["summary"]["stability"]["not_judged"][0], "lost");
    sandbox.put("model.ca.toml", &text.replace("23.04 MN/m\"", "23.04 MN/m\", method = \"stable\""));
    let r = sandbox.ca(&["check", "model.ca.toml"]).is(0);
    assert!(r.out.contains("rule of thumb, no limit") || r.out.contains("proven, no limit"), "{}", r.out);
    assert!(!r.out.contains("inf"), "{}", r.out);
}
