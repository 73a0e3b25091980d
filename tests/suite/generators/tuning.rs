//! Pitch and decay given by `f` and `t60` are those that sound, with every method and for every tuned kind. They are
//! measured as the pole of the output.

use crate::play::{PI, scene, within};
use ca_core::{Role, tick};
use std::fmt::Write as _;

/// Pitch and decay time, in ticks, from a least-squares fit of x(n + l) = p x(n) − q x(n − l). A lag `l` of an eighth
/// of a period determines the pole best.
fn pole(x: &[f64], l: usize) -> (f64, f64) {
    let (mut aa, mut ab, mut bb, mut ay, mut by) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for w in x.windows(2 * l + 1) {
        let (b, a, y) = (w[0], w[l], w[2 * l]);
        (aa, ab, bb, ay, by) = (aa + a * a, ab + a * b, bb + b * b, ay + a * y, by + b * y);
    }
    let det = aa * bb - ab * ab;
    let (p, q) = ((ay * bb - by * ab) / det, (ay * ab - by * aa) / det);
    let l = l as f64;
    ((p / (2.0 * q.sqrt())).acos() / (2.0 * PI * l), -3.0 * 10_f64.ln() / (0.5 * q.ln() / l))
}

/// Pitch and decay of the first mode after a push of one sample. Outputs `o0`, `o1`, … are weighted by its shape.
fn played_pitch(text: &str, rate: f64, f: f64, shape: &[f64]) -> (f64, f64) {
    let scene = scene(text);
    let mut s = scene.state();
    let mut x = Vec::new();
    for n in 0..4000 {
        if let Some(push) = s.input.first_mut() {
            *push = if n == 0 { 1e-3 } else { 0.0 };
        }
        tick(&scene, &mut s);
        x.push(s.output.iter().zip(shape).map(|(o, w)| o * w).sum::<f64>());
    }
    let (f, t60) = pole(&x[4..], (rate / (8.0 * f)) as usize);
    (f * rate, t60 / rate)
}

/// All kinds that `f` tunes: section, name of mass `i`, and shape of the first mode.
///
/// If masses differ, the shape is multiplied by each mass, so that no other mode is in the sum. The first mass is
/// pushed; it moves in that mode.
fn tuned(f: f64, t60: f64) -> Vec<(String, Vec<String>, Vec<f64>)> {
    let row = |n: usize| (1..=n).map(|j| (PI * j as f64 / (n + 1) as f64).sin()).collect::<Vec<f64>>();
    let names = |n: usize| (0..n).map(|i| format!("x[{i}]")).collect::<Vec<_>>();
    let pitch = format!("f = \"{f} Hz\", t60 = \"{t60} s\", m = \"1 g\"");
    let square: Vec<f64> = row(3).iter().flat_map(|a| row(3).into_iter().map(move |b| a * b)).collect();
    let nodes = (1..4).flat_map(|i| (1..4).map(move |j| format!("x[{i},{j}]"))).collect();
    vec![
        (format!("[CEL]\nx = {{ {pitch} }}\n"), vec!["x".into()], vec![1.0]),
        (format!("[BANK]\nx = {{ {pitch} }}\n"), names(1), vec![1.0]),
        (format!("[STRING]\nx = {{ n = 7, {pitch} }}\n"), names(7), row(7)),
        (format!("[STIFFSTRING]\nx = {{ n = 7, b = 1e-3, ends = \"hinged\", {pitch} }}\n"), names(7), row(7)),
        (
            format!("[CHAIN]\nx = {{ n = 7, {pitch} }}\n"),
            names(7),
            (0..7).map(|i| (PI * (f64::from(i) + 0.5) / 7.0).cos()).collect(),
        ),
        (
            format!("[RING]\nx = {{ n = 7, {pitch} }}\n"),
            names(7),
            (0..7).map(|i| (2.0 * PI * f64::from(i) / 7.0).cos()).collect(),
        ),
        (format!("[MESH]\nx = {{ nx = 5, ny = 5, edges = \"closed\", {pitch} }}\n"), nodes, square),
    ]
}

fn whole(method: &str, rate: f64, parts: &str, names: &[String]) -> String {
    let mut text = format!(
        "[model]\n{method}[rate]\nsound = \"{rate} Hz\"\n{parts}[ENF]\npush = {{ to = \"{}\" }}\n[SOX]\n",
        names[0]
    );
    for (i, name) in names.iter().enumerate() {
        let _ = writeln!(text, "o{i} = {{ from = \"{name}\", dc = 0 }}");
    }
    text
}

/// Fails for a new kind with a pitch that has no row above. WAVEGUIDE is tested in `waveguide`.
#[test]
fn everything_that_has_a_pitch_is_in_the_table() {
    let rows = tuned(440.0, 1.0);
    for kind in ca_tests::catalog().iter().filter(|k| k.param("f").is_some() && k.code != "WAVEGUIDE") {
        let sounds = matches!(kind.role, Role::Mat(_) | Role::Generator(_));
        let is_in = rows.iter().any(|(text, ..)| text.contains(&format!("[{}]", kind.code)));
        assert!(
            !sounds || is_in,
            "{} has `f`: add it to `tuned`, with the shape of its first mode (times its masses, where they differ)",
            kind.code
        );
    }
}

#[test]
fn what_is_tuned_sounds_as_asked_by_every_method() {
    let methods = [
        "",
        "method = \"centred\"\n",
        "method = \"implicit\"\n",
        "method = \"implicit\"\ntheta = 0.25\n",
        "method = \"implicit\"\ntheta = 0.08\n",
        "method = \"modal\"\n",
    ];
    for method in methods {
        for (f, t60, rate) in [(440.0, 0.5, 48_000.0), (1000.0, 0.2, 22_050.0), (110.0, 2.0, 96_000.0)] {
            for (parts, names, shape) in tuned(f, t60) {
                let (is, falls) = played_pitch(&whole(method, rate, &parts, &names), rate, f, &shape);
                let what = format!("{method:?}, {f} Hz at {rate} Hz, {parts:?}");
                within(&format!("{what}: pitch {is}"), (is / f - 1.0).abs(), 1e-9);
                // with `theta` = 1/2 a cell has the decay of its formula, a network the decay of its fundamental
                within(&format!("{what}: decay {falls}"), (falls / t60 - 1.0).abs(), 1e-7);
            }
        }
    }
}

/// Travelling waves are exact, so the method of the rest of the model changes no bit.
#[test]
fn a_waveguide_is_the_same_by_every_method() {
    let play = |method: &str| {
        let scene = scene(&format!(
            "[model]\n{method}[WAVEGUIDE]\nlow = {{ f = \"440 Hz\", t60 = \"3 s\", z = 0.5, at = [0.13, 0.8] }}\n[ENF]\npush = {{ to = \"low[0]\" }}\n[SOX]\nout = {{ from = \"low[1]\" }}\n"
        ));
        let mut s = scene.state();
        s.input[0] = 1e-3;
        tick(&scene, &mut s);
        s.input[0] = 0.0;
        (0..2000)
            .map(|_| {
                tick(&scene, &mut s);
                s.output[0].to_bits()
            })
            .collect::<Vec<u64>>()
    };
    let plain = play("");
    assert!(plain.iter().any(|v| f64::from_bits(*v).abs() > 0.0));
    for method in ["centred", "implicit", "modal"] {
        assert_eq!(play(&format!("method = \"{method}\"\n")), plain, "{method}");
    }
}

#[test]
fn modes_of_a_modal_model_are_those_that_are_heard() {
    for (parts, names, _) in tuned(3000.0, 0.5) {
        let text = whole("method = \"modal\"\n", 22_050.0, &parts, &names);
        let model = crate::play::model(&text);
        let network =
            ca_compile::linear(&model, &ca_tests::catalog(), &ca_compile::Options::default()).expect("it is a network");
        let modes = ca_compile::analysis::modes::modes(&network).expect("it has modes");
        // modules that nothing holds have a rigid mode without a pitch
        let first = modes.list.iter().find(|m| m.heard > 0.0).expect("a pitch");
        within(&format!("{parts}: {}", first.heard), (first.heard / 3000.0 - 1.0).abs(), 1e-9);
        within(&format!("{parts}: {}", first.t60), (first.t60 / 0.5 - 1.0).abs(), 1e-7);
    }
}

#[test]
fn a_pitch_beyond_a_method_is_refused() {
    let text = "[model]\nmethod = \"implicit\"\n[STRING]\nlow = { n = 3, f = \"13 kHz\", m = \"1 g\" }\n[SOX]\no = { from = \"low[0]\" }\n";
    let model = crate::play::model(text);
    let found = ca_compile::compile(&model, &ca_tests::catalog(), &ca_compile::Options::default())
        .expect_err("it cannot sound");
    let all: Vec<String> =
        found.list.iter().map(|d| format!("{} {}", d.title, d.help.clone().unwrap_or_default())).collect();
    let all = all.join("\n");
    assert!(all.contains("13000 Hz") && all.contains("theta = 0.25"), "{all}");
    let text = text.replace("[STRING]", "theta = 0.25\n[STRING]");
    assert!(
        ca_compile::compile(&crate::play::model(&text), &ca_tests::catalog(), &ca_compile::Options::default()).is_ok()
    );
}
