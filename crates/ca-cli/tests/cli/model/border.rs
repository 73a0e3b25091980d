//! Tests the output of commands about the rate boundary and the output stage, and the options for them.

use crate::sandbox::{KEY, STRUCK, Sandbox, peak};

#[test]
fn check_tells_delays_and_what_a_key_asks_of_a_device() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let r = sandbox.ca(&["check", "struck.ca.toml"]).is(0);
    r.says(&["gesture to force 0.333 ms, gesture to sound 0.333 ms\n", "interpolated linearly over the frame"])
        .says(&["`key`: sum of springs 2 kN/m; to stay passive, the device needs a friction of 0.667 N s/m"])
        .says(&["a friction of 1 N s/m allows 3 kN/m, or 1.5 kN/m if the device applies each force a frame later"]);
    let set = ["check", "struck.ca.toml", "--latency", "2", "--border", "hold", "--set", "rate.filter=18 kHz"];
    let r = sandbox.ca(&set).is(0);
    r.says(&["gesture to force 1.00 ms, gesture to sound 1.50 ms", "2 frames from", "0.500 ms from the output filter"])
        .says(&["held over the frame", "needs a friction of 2.00 N s/m", "1 N s/m allows 1 kN/m"]);
    let j = sandbox.ca(&[&set[..], &["--json"]].concat()).is(0).json();
    let of = |path: &str| j["summary"]["latency"].pointer(path).cloned().unwrap();
    for (path, want) in [
        ("/gesture_to_force_ms", 1.0),
        ("/gesture_to_sound_ms", 1.5),
        ("/filter_ms", 0.5),
        ("/border/spring_delay_ms", 1.0),
        ("/border/stiffest_per_friction", 1000.0),
        ("/border/keys/0/k", 2000.0),
        ("/border/keys/0/friction", 2.0),
    ] {
        let is = of(path).as_f64().unwrap();
        assert!((is / want - 1.0).abs() < 1e-9, "{path}: {is}");
    }
    assert_eq!((of("/border/shape"), of("/border/latency")), ("hold".into(), 2.into()));
    let r = sandbox.ca(&["check", "struck.ca.toml", "--no-feedback"]).is(0).says(&["no force feedback"]);
    assert!(!r.out.contains("passive"), "{}", r.out);
    let one = ["check", "struck.ca.toml", "--set", "rate.gesture=48 kHz"];
    sandbox.ca(&one).is(0).says(&["the force of the tick", "0.0208 N s/m"]);
}

/// Oversampling is reported. Its sound is the plain one delayed by the filter, apart from the error of the scheme.
#[test]
fn finer_ticks_are_reported_and_heard() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK).put("key.csv", KEY);
    let four = ["--set", "rate.oversample=4"];
    let check = |more: &[&str]| sandbox.ca(&[&["check", "struck.ca.toml"], &four[..], more].concat()).is(0);
    check(&[])
        .says(&["rates      sound 48 kHz (4 ticks per sample), gesture 3 kHz, 64 ticks per frame"])
        .says(&["gesture to force 0.333 ms", "0.854 ms from the output filter"]);
    check(&["--schedule"]).says(&["ticks between", "to samples", "to ticks", "low pass", "whole tick"]);
    assert_eq!(check(&["--json"]).json()["summary"]["oversample"], 4);
    let r = sandbox.ca(&["check", "struck.ca.toml", "--schedule"]).is(0).says(&["one tick per sample"]);
    assert!(!r.out.contains("ticks between") && !r.out.contains("(1 tick"), "{}", r.out);
    let modes = sandbox.ca(&[&["modes", "struck.ca.toml"], &four[..]].concat()).is(0);
    modes.says(&["at 48000 Hz (4 ticks per sample)"]);
    let bad = sandbox.ca(&["check", "struck.ca.toml", "--set", "rate.oversample=65"]).is(1);
    assert!(bad.err.contains("use a value from 1 to 64"), "{}", bad.err);
    let play = |more: &[&str]| {
        let args = ["render", "struck.ca.toml", "--gesture", "key.csv", "--seconds", "200 ms", "-q"];
        sandbox.ca(&[&args[..], more].concat()).is(0);
        sandbox.wav("struck.wav").1
    };
    let (plain, fine) = (play(&[]), play(&four));
    assert_eq!(plain.len(), fine.len());
    let off = fine[2 * 41..].iter().zip(&plain).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 0.1 * peak(&plain) && off > 1e-6 * peak(&plain), "{off} of {}", peak(&plain));
}

#[test]
fn a_render_is_late_without_a_force_or_filtered() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK).put("key.csv", KEY);
    let play = |more: &[&str]| {
        let args = ["render", "struck.ca.toml", "--gesture", "key.csv", "--seconds", "500 ms", "-q", "--no-fade"];
        sandbox.ca(&[&args[..], more].concat()).is(0);
        sandbox.wav("struck.wav").1
    };
    let plain = play(&[]);
    assert!(peak(&plain) > 0.1);
    assert!(play(&["--no-feedback"]) == plain);
    let late = play(&["--latency", "30"]);
    // two channels, sixteen ticks per frame
    assert!(late[2 * 16 * 30..] == plain[..plain.len() - 2 * 16 * 30]);
    assert!(play(&["--border", "hold"]) != plain);
    // 24 ticks late, and otherwise equal below the edge
    let filtered = play(&["--set", "rate.filter=18 kHz"]);
    let off = filtered[48..].iter().zip(&plain).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-3 * peak(&plain), "{off}");
}

#[test]
fn the_report_says_how_late_and_what_each_hand_gave() {
    let sandbox = Sandbox::new();
    sandbox.put("struck.ca.toml", STRUCK);
    let args = ["render", "struck.ca.toml", "--latency", "1", "--energy"];
    let r =
        sandbox.ca(&args).is(0).says(&["latency    gesture to force 0.667 ms", "through `key`", "given by its hand"]);
    assert!(r.err.is_empty(), "{}", r.err);
    let ledger = |more: &[&str]| {
        let args = ["render", "struck.ca.toml", "--energy", "--json"];
        let j = sandbox.ca(&[&args[..], more].concat()).is(0).json();
        let of = |key: &str| j["energy"]["hands"][0][key].as_f64().unwrap();
        (of("received"), of("given"), of("leak"), j["latency"]["gesture_to_sound_ms"].as_f64().unwrap())
    };
    let now = ledger(&[]);
    assert!((now.0 - now.1 - now.2).abs() < 1e-12 && now.0 > 0.0 && now.2 != 0.0);
    let numb = ledger(&["--no-feedback", "--latency", "2"]);
    assert!(numb.1 == 0.0 && numb.2 == numb.0 && (numb.3 - 1.0).abs() < 1e-9);
}

#[test]
fn what_is_asked_of_a_border_that_is_not_there_is_said() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", crate::sandbox::BAR);
    for verb in ["check", "render"] {
        sandbox.ca(&[verb, "bar.ca.toml", "--latency", "3"]).is(0).says(&["no device key", "have no effect"]);
        let r = sandbox.ca(&[verb, "bar.ca.toml"]).is(0);
        assert!(r.err.is_empty() && !r.out.contains("latency"), "{}{}", r.out, r.err);
    }
    sandbox
        .ca(&["check", "bar.ca.toml", "--set", "rate.filter=18 kHz"])
        .says(&["the output filter delays the sound by 0.500 ms"]);
    sandbox.ca(&["check", "bar.ca.toml", "--latency", "-1"]).is(2);
    sandbox.ca(&["check", "bar.ca.toml", "--border", "cubic"]).is(2).says(&["linear", "hold"]);
}

#[test]
fn a_group_at_the_gesture_rate_is_reported() {
    let sandbox = Sandbox::new();
    sandbox.put(
        "slow.ca.toml",
        "[slow]\nrate = \"gesture\"\n[slow.STRING]\nlow = { n = 200, k = \"5 kN/m\", m = \"10 g\" }\n[MAS]\nbob = { m = \"1 g\", dx0 \
         = \"1 mm\" }\n[RES]\ntie = { between = [\"slow.low[50]\", \"bob\"], k = 100 }\n[SOX]\nout = { from = \"bob\" }\n",
    );
    let r = sandbox.ca(&["check", "slow.ca.toml", "--schedule"]).is(0);
    r.says(&["group      200 masses and 201 links once per frame; links to the rest act on 1 axes, exact\n"]).says(&[
        "gesture group",
        "the group: 200 masses and 201 links take",
        "once in 16 ticks",
        "proven",
    ]);
    let j = sandbox.ca(&["check", "slow.ca.toml", "--schedule", "--json"]).is(0).json();
    assert_eq!(
        j["summary"]["slow"],
        serde_json::json!({"masses": 200, "links": 201, "coupled": 1, "compensated": false})
    );
    assert!(j["schedule"]["ns_of_group_per_frame"].as_f64().unwrap() > 0.0);
    sandbox.put("struck.ca.toml", STRUCK);
    assert!(sandbox.ca(&["check", "struck.ca.toml", "--json"]).is(0).json()["summary"]["slow"].is_null());
}

/// A rate boundary that may make energy is reported with the energy it made. For an exact boundary, this line is
/// absent.
#[test]
fn a_compensated_border_has_an_account() {
    let sandbox = Sandbox::new();
    let model = "[hammer]\nrate = \"gesture\"\nborder = \"compensated\"\n[hammer.MAS]\nhead = { m = \"50 g\", x = \"5 mm\", v = \"-1 m/s\" \
                 }\n[CEL]\nbar = { m = \"20 g\", f = \"330 Hz\", t60 = \"2 s\" }\n[BUT]\nstrike = { between = [\"bar\", \
                 \"hammer.head\"], k = \"20 kN/m\" }\n[SOX]\nout = { from = \"bar\", gain = 100 }\n";
    sandbox.put("hit.ca.toml", model);
    sandbox.ca(&["check", "hit.ca.toml"]).is(0).says(&[
        "W107",
        "stability  not proven",
        "links to the rest act on 1 axes, compensated:",
    ]);
    sandbox.put("light.ca.toml", &model.replace("50 g", "2 g"));
    sandbox
        .ca(&["check", "light.ca.toml"])
        .is(0)
        .says(&["W107", "`hammer.head` is too light for its links to the sound: T²K/M is 1.11"]);
    let render = ["render", "hit.ca.toml", "--energy", "--seconds", "0.5"];
    sandbox.ca(&render).is(0).says(&["of it by the compensated border of groups at the gesture rate"]);
    let j = sandbox.ca(&[&render[..], &["--json"]].concat()).is(0).json();
    let of = |key: &str| j["energy"][key].as_f64().unwrap();
    assert!(of("made_at_border") != 0.0 && of("made_at_border").abs() < 0.02 * of("peak"), "{j:#}");
    assert!(of("relative_residual") < 1e-9, "{j:#}");
    sandbox.put("hit.ca.toml", &model.replace("BUT", "RES"));
    let j = sandbox.ca(&[&render[..], &["--json"]].concat()).is(0).json();
    assert!(j["energy"]["made_at_border"].is_null(), "{j:#}");
}
