//! Gestures generated from a few numbers: values against closed forms, and refused ones.

use crate::play::{TURN, scene, within};
use ca_compile::{Options, load};
use ca_core::Scene;
use ca_model::render;
use ca_tests::{catalog, follow};

fn with(gestures: &str) -> String {
    format!(
        "[model]\nseconds = 2\n[param]\ndeep = '3 mm'\n[ENX]\nhand = {{}}\nother = {{}}\n[CEL]\nbar = {{ m = '1 g', f = 'A3', \
         t60 = 1 }}\n[REF]\ntie = {{ between = [['hand', 'other'], 'bar'], k = 100 }}\n[SOX]\nout = {{ from = 'bar' }}\n\
         [gesture]\n{gestures}\n"
    )
}

fn points<'s>(scene: &'s Scene, name: &str) -> &'s [[f64; 2]] {
    &scene.about.gestures.iter().find(|g| g.0 == name).unwrap_or_else(|| panic!("no gesture `{name}`")).1
}

#[test]
fn a_sine_is_one() {
    // a point per gesture frame, or per sample if that is too coarse
    for (f, per_second) in [(3.0, 3000.0), (440.0, 48_000.0)] {
        let text =
            with(&format!("hand = {{ sine = '2 mm', f = {f}, phase = 0.25, offset = '1 mm', from = 0.5, to = 1.5 }}"));
        let made = scene(&text).scene;
        let p = points(&made, "hand");
        assert_eq!(p.len(), per_second as usize + 1);
        for t in [0.5, 0.61, 0.9, 1.3, 1.5] {
            let want = 1e-3 + 2e-3 * (TURN * (f * (t - 0.5) + 0.25)).sin();
            // a chord of a circle of n points is 1 − cos(π/n) from its arc
            within(
                &format!("a sine of {f} Hz at {t} s"),
                (follow(p, t) - want).abs(),
                2e-3 * 4.94 * (f / per_second).powi(2) + 1e-15,
            );
        }
    }
}

#[test]
fn noise_is_even_within_its_bounds_and_the_same_everywhere() {
    let made =
        scene(&with("hand = { noise = '1 mm', f = 500, seed = 7 }\nother = { noise = '1 mm', f = 500, seed = 8 }"))
            .scene;
    let (a, b) = (points(&made, "hand"), points(&made, "other"));
    assert_eq!(a.len(), 2001);
    let mean = |p: &[[f64; 2]]| p.iter().map(|q| q[1]).sum::<f64>() / p.len() as f64;
    let power = |p: &[[f64; 2]]| p.iter().map(|q| q[1] * q[1]).sum::<f64>() / p.len() as f64;
    assert!(a.iter().all(|q| q[1].abs() <= 1e-3));
    // uniform in ±1: mean 0 and power 1/3, each within four standard deviations
    within("mean of noise", mean(a).abs() / 1e-3, 4.0 * (1.0_f64 / 3.0 / 2001.0).sqrt());
    within("power of noise", (power(a) / 1e-6 - 1.0 / 3.0).abs(), 4.0 * (4.0_f64 / 45.0 / 2001.0).sqrt());
    let together = a.iter().zip(b).map(|(a, b)| a[1] * b[1]).sum::<f64>() / 2001.0;
    within("two seeds", together.abs() / 1e-6, 4.0 / 3.0 / 2001.0_f64.sqrt());
    // the same bits on every machine: SplitMix64 from seed 7
    assert_eq!(a[0][1], 1e-3 * (2.0 * (0x63cb_e1e4_5932_0dd7_u64 as f64 / 18_446_744_073_709_551_616.0) - 1.0));
}

#[test]
fn pulses_loops_and_what_follows() {
    let made = scene(&with(
        "hand = { pulse = 'deep', offset = '-2 mm', at = [0.1, 0.5], rise = '10 ms', hold = '20 ms' }\n\
         other = { follow = 'hand', delay = '0.2 s', gain = -2, offset = '1 mm' }",
    ))
    .scene;
    let (p, q) = (points(&made, "hand"), points(&made, "other"));
    let near = |a: f64, b: f64| (a - b).abs() < 1e-15;
    for (t, want) in
        [(0.0, -2e-3), (0.105, -0.5e-3), (0.12, 1e-3), (0.135, -0.5e-3), (0.3, -2e-3), (0.52, 1e-3), (1.9, -2e-3)]
    {
        assert!(near(follow(p, t), want), "{t} s: {}", follow(p, t));
        assert!((follow(q, t + 0.2) - (1e-3 - 2.0 * want)).abs() < 1e-14, "{t} s: {}", follow(q, t + 0.2));
    }
    let made = scene(&with(
        "hand = { points = [[0, 0], [0.1, '1 mm'], [0.2, 0]], every = 0.5, to = 1.2 }\nother = { pulse = 0.001, every = 0.5, hold = 0.25, to = 1 }",
    ))
    .scene;
    let (p, q) = (points(&made, "hand"), points(&made, "other"));
    for (t, want) in [(0.1, 1e-3), (0.3, 0.0), (0.6, 1e-3), (1.1, 1e-3), (1.4, 0.0)] {
        assert!(near(follow(p, t), want), "{t} s: {}", follow(p, t));
    }
    for (t, want) in [(0.1, 1e-3), (0.3, 0.0), (0.6, 1e-3), (0.8, 0.0), (1.1, 0.0)] {
        assert!(near(follow(q, t), want), "{t} s: {}", follow(q, t));
    }
}

#[test]
fn a_sum_is_the_sum_of_its_members_jumps_included() {
    let made = scene(&with(
        "hand = { sum = [[[0, 0], [1, '1 mm'], [1, '5 mm']], { ramp = [0, '2 mm'], to = 2 }, { sine = '1 mm', f = 2, to = 2 }] }",
    ))
    .scene;
    let p = points(&made, "hand");
    let want = |t: f64| {
        let step = if t < 1.0 { 1e-3 * t } else { 5e-3 };
        step + 1e-3 * t + 1e-3 * (TURN * 2.0 * t).sin()
    };
    for t in [0.0, 0.25, 0.5, 0.999, 1.0, 1.25, 2.0] {
        within(&format!("a sum at {t} s"), (follow(p, t) - want(t)).abs(), 1e-8);
    }
}

#[test]
fn what_makes_no_gesture_says_why() {
    for (gesture, code, says) in [
        ("[[0, 0], [1e300, 1]]", "E009", "a point beyond a day"),
        ("{ sine = '1 mm' }", "E005", "needs `f`"),
        ("{ sine = '1 g', f = 2 }", "E008", "must be in m"),
        ("{ sine = '1 mm', f = 2, sed = 3 }", "E004", "a sine has no `sed`"),
        ("{ sine = '1 mm', f = '30 kHz' }", "E009", "out of range"),
        ("{ sine = '1 mm', f = 2, pulse = 1 }", "E019", "more than one"),
        ("{ noise = '1 mm', f = 20000, to = 86400 }", "E027", "more than"),
        ("{ points = [[0, 0]], every = 1e-9, to = 1000 }", "E027", "more than"),
        ("{ points = [[0, 0], [1, 1]], every = 0.5 }", "E019", "lasts 1 s, but repeats every 0.5 s"),
        ("{ pulse = 1 }", "E005", "needs `hold`"),
        ("{ pulse = 1, hold = 0.1, at = [0, 1], every = 0.5 }", "E010", "exclude each other"),
        ("{ pulse = 1, hold = 0.1, every = 0 }", "E009", "out of range"),
        ("{ sum = [[[0, 1.7e308]], [[0, 1.7e308]]] }", "E009", "finite value at 0 s"),
        ("{ pulse = 1, hold = 1, at = [] }", "E019", "has no points"),
        ("{ sum = [] }", "E019", "has no points"),
        ("{ ramp = [0, 1], from = 1, to = 0.5 }", "E019", "begins at 1 s and ends at 0.5 s"),
        ("{ pulse = 1, at = [0, 0.1], hold = 1 }", "E019", "before the previous one ends"),
        ("{ follow = 'hond' }", "E013", "no gesture `hond`"),
        ("{ follow = 'hand' }", "E019", "follows itself"),
        ("{ sum = 3 }", "E019", "must be a list"),
        ("{ ramp = [1] }", "E019", "a first and a last value"),
        ("{ points = [[1, 0], [0, 0]] }", "E019", "back in time"),
    ] {
        let text = with(&format!("hand = {gesture}"));
        let (model, result) = load(&text, "m.ca.toml", &catalog(), &Options::default());
        let Err(diags) = result else { panic!("{gesture} compiles") };
        let all = render::text(&diags, &model, false);
        assert!(all.contains(&format!("error[{code}]")) && all.contains(says), "{gesture}\n{all}");
    }
    let text = with("hand = { sine = '1 mm', f = 2 }").replace("seconds = 2", "title = 'x'");
    let (model, result) = load(&text, "m.ca.toml", &catalog(), &Options::default());
    let all = result.map(|_| ()).map_err(|d| render::text(&d, &model, false)).unwrap_err();
    assert!(all.contains("the end of gesture `hand` is missing"), "{all}");
}

/// A parameter follows a port of another unit.
#[test]
fn what_follows_may_be_counted_otherwise() {
    for gain in ["100", "'100 m^-1'"] {
        let text = with(&format!(
            "hand = {{ pulse = '3 mm', hold = 1, rise = 0.1 }}\nloud = {{ follow = 'hand', gain = {gain}, offset = 0.2 }}"
        ));
        let text = text
            .replace("deep = '3 mm'", "loud = { value = 0.5, live = true, min = 0, max = 1 }")
            .replace("from = 'bar' }", "from = 'bar', gain = 'loud' }");
        let made = scene(&text).scene;
        let p = points(&made, "loud");
        for (t, want) in [(0.0, 0.2), (0.05, 0.35), (0.5, 0.5)] {
            assert!((follow(p, t) - want).abs() < 1e-12, "{gain}: {t} s: {}", follow(p, t));
        }
    }
}

/// A curve ends at `to`, also in the middle of a period.
#[test]
fn loops_and_pulses_are_cut_at_their_end() {
    let made = scene(&with(
        "hand = { points = [[0, 0], [1, 0.001]], every = 1, to = 1.25 }\nother = { pulse = 0.001, every = 1, rise = 0.5, to = 1.1 }",
    ))
    .scene;
    for (name, values) in [
        ("hand", [(0.5, 0.5e-3), (1.0, 0.0), (1.2, 0.2e-3), (1.25, 0.25e-3), (1.9, 0.25e-3)]),
        ("other", [(0.25, 0.5e-3), (0.5, 1e-3), (1.05, 0.1e-3), (1.1, 0.2e-3), (1.9, 0.2e-3)]),
    ] {
        for (t, want) in values {
            assert!(
                (follow(points(&made, name), t) - want).abs() < 1e-12,
                "{name} at {t} s: {}",
                follow(points(&made, name), t)
            );
        }
    }
}

#[test]
fn a_gesture_that_begins_elsewhere_than_its_port_is_a_warning() {
    let model = |x: &str, tie: &str, gesture: &str| {
        format!(
            "[ENX]\nhand = {{ x = '{x}' }}\n[CEL]\nb = {{ m = '1 g', f = 200 }}\n{tie}[SOX]\no = {{ from = 'b' }}\n[gesture]\nhand = {gesture}\n"
        )
    };
    let tie = "[RES]\nr = { between = ['hand', 'b'], k = 100 }\n";
    let said = |text: &str| scene(text).findings.list.iter().any(|d| d.code == "W116");
    assert!(said(&model("-250 mm", tie, "[[0, 0], [1, '0.2 m']]")));
    assert!(said(&model("0 m", tie, "{ ramp = ['5 mm', 0], to = 1 }")));
    assert!(!said(&model("-250 mm", tie, "[[0, '-0.25 m'], [1, '0.2 m']]")));
    assert!(!said(&model("0 m", "", "[[0, '5 mm']]")), "nothing is tied to it");
    assert!(!said(&model("0 m", tie, "[[0, '0.1 mm'], [1, '0.2 m']]")), "no more than noise upon a stroke");
}

#[test]
fn keys_on_one_degree_of_freedom_are_noted() {
    let model = |dofs: &str| {
        format!(
            "[part.k.param]\nd = 0\n[part.k.TGR]\nkey = {{ device = 't', dof = 'd' }}\n[part.k.CEL]\nb = {{ m = '1 g', f = 200 }}\n[part.k.RES]\nr = {{ between = ['key', 'b'], k = 100 }}\n\
                 [use]\nk = {{ part = 'k', n = 3{dofs} }}\n[SOX]\no = {{ from = 'k[*].b', channel = 0 }}\n"
        )
    };
    let said = |text: &str| -> Vec<String> {
        scene(text).findings.list.iter().filter(|d| d.code == "N204").map(|d| d.title.clone()).collect()
    };
    assert_eq!(said(&model("")).len(), 1);
    assert!(said(&model(""))[0].contains("degree of freedom 0 of `t` moves 3 ports at once"));
    assert!(said(&model(", with = { d = [0, 1, 2] }")).is_empty());
    // keys with different notes are played by MIDI, keys with the same note by one hand
    let midi = |note: &str| {
        let text = model("").replace("dof = 'd' }", "dof = 'd', midi = { note = 'p', to = '1 mm' } }");
        text.replace("param]\nd = 0", "param]\nd = 0\np = 60")
            .replace("n = 3", &format!("n = 3, with = {{ p = {note} }}"))
    };
    assert!(said(&midi("['C4', 'D4', 'E4']")).is_empty());
    assert_eq!(said(&midi("'C4'")).len(), 1);
}

#[test]
fn a_gain_says_which_unit_turns_one_into_the_other() {
    let text = "[model]\nseconds = 1\n[param]\nlv = { value = 0.2, live = true, min = 0, max = 1 }\n[SOL]\ng = {}\n[CEL]\nb = { m = '1 g', f = 200 }\n\
                [FRO]\nq = { between = ['g', 'b'], z = 'lv' }\n[ENX]\nkey = {}\n[RES]\nr = { between = ['key', 'b'], k = 9 }\n[SOX]\no = { from = 'b' }\n\
                [gesture]\nlv = [[0, 0], [1, 1]]\nkey = { follow = 'lv', gain = '1 mm' }\n";
    let (model, result) = ca_compile::load(text, "", &ca_tests::catalog(), &ca_compile::Options::default());
    let all = ca_model::render::text(&result.unwrap_err(), &model, false);
    assert!(all.contains("must be in kg^-1 m s, not in m") && all.contains("`lv` (N s/m)"), "{all}");
}
