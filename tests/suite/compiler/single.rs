//! Scenes bound to single precision: closed forms, drift, contacts and bows against double precision, scale, and
//! refusals.
//!
//! Tolerances are three to five times the measured values. Blows begin away from a tick; at a tick, the last bit
//! decides in either precision whether one begins there or a tick later.

use crate::compiler::thresholds::{k, link, z};
use crate::play::{PI, TURN, case, num, off, rel_l2, within};
use ca_compile::{KernelClass, Options, load};
use ca_core::{Precision, tick};
use ca_model::diag::{Diags, Severity};
use ca_tests::follow;

type Scene = ca_core::Scene<f32>;
type State = ca_core::State<f32>;

struct Compiled {
    scene: Scene,
    findings: Diags,
}

impl std::ops::Deref for Compiled {
    type Target = Scene;
    fn deref(&self) -> &Scene {
        &self.scene
    }
}

fn with(text: &str, options: &Options) -> Result<Compiled, Diags> {
    let options = Options { precision: Precision::Single, ..options.clone() };
    let compiled = load(text, "test.ca.toml", &ca_model::catalog(), &options).1?;
    let scene = compiled.scene.bind(&cordis_anima::laws()).expect("all laws are known");
    Ok(Compiled { scene, findings: compiled.findings })
}

fn scene(text: &str) -> Compiled {
    with(text, &Options::default()).unwrap_or_else(|d| panic!("{text}\n{d}"))
}

/// Sets the ports by the model's gesture and runs a tick.
fn step(scene: &Scene, s: &mut State) {
    for (name, points) in &scene.about.gestures {
        let input = scene.input(name).expect("a port");
        s.input[input] = follow(points, s.tick as f64 * scene.rates.sample_dt);
    }
    tick(scene, s);
}

fn played(scene: &Scene, ticks: usize) -> Vec<f64> {
    let mut s = scene.state();
    let heard = (0..ticks).flat_map(|_| {
        step(scene, &mut s);
        s.output.clone()
    });
    heard.collect()
}

/// The same in double precision.
fn double(text: &str, ticks: usize) -> Vec<f64> {
    let scene = crate::play::scene(text);
    let mut s = scene.state();
    let heard = (0..ticks).flat_map(|_| {
        ca_tests::gesture(&scene, &mut s);
        ca_core::tick(&scene, &mut s);
        s.output.clone()
    });
    heard.collect()
}

/// Relative difference of single from double precision over these ticks.
fn apart(text: &str, ticks: usize) -> f64 {
    rel_l2(&played(&scene(text), ticks), &double(text, ticks))
}

fn places(scene: &Scene) -> Vec<usize> {
    (0..scene.counts.n_mat)
        .map_while(|i| (0..scene.counts.n_mat).find(|p| scene.mat_name(*p) == format!("s[{i}]")))
        .collect()
}

fn string(n: usize, k: f64) -> String {
    format!("[STRING]\ns = {{ n = {n}, m = 1e-3, k = {k:?} }}\n[SOX]\nout = {{ from = \"s[3]\" }}\n")
}

/// x = cos nθ with 2 sin(θ/2) = √a in either precision: ten seconds of 440 Hz.
#[test]
fn an_oscillator() {
    let a = (TURN * 440.0 / 48e3_f64).powi(2);
    let k = a * 1e-3 * 48e3 * 48e3;
    let text = format!(
        "[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1e-3, dx0 = 1e-3 }}\n[RES]\ns = {{ between = [\"wall\", \"bob\"], k = {k:?} }}\n[SOX]\no = {{ from = \"bob\", gain = 1000 }}\n"
    );
    let theta = 2.0 * (0.5 * a.sqrt()).asin();
    let exact: Vec<f64> = (0..480_000).map(|n| (theta * f64::from(n)).cos()).collect();
    let heard = played(&scene(&text), exact.len());
    within("one second", rel_l2(&heard[..48_000], &exact[..48_000]), 5e-5);
    within("ten seconds", rel_l2(&heard, &exact), 4e-4);
}

/// The chain of B01 against the sum of its modes in the scheme.
#[test]
fn a_plucked_chain() {
    let c = case("B01");
    let (n, a) = (num(c, "setup/N") as usize, num(c, "setup/a"));
    let scene = scene(&string(n, a * 1e-3 * 48e3 * 48e3));
    let places = places(&scene);
    let length = n as f64 + 1.0;
    let shape: Vec<f64> =
        (0..n + 2).map(|i| i as f64 / length).map(|s| 1e-3 * if s < 0.2 { s / 0.2 } else { (1.0 - s) / 0.8 }).collect();
    let mut s = scene.state();
    for (i, p) in places.iter().enumerate() {
        s.x[*p] = shape[i + 1] as f32;
        s.d[*p] = (-0.5 * a * (shape[i] - 2.0 * shape[i + 1] + shape[i + 2])) as f32;
    }
    let modes: Vec<(f64, f64)> = (1..=n)
        .map(|j| {
            let sin = |i: usize| (j as f64 * PI * i as f64 / length).sin();
            let amount = 2.0 / length * (1..=n).map(|i| sin(i) * shape[i]).sum::<f64>();
            (amount * sin(20), 2.0 * (a.sqrt() * (0.5 * PI * j as f64 / length).sin()).asin())
        })
        .collect();
    let exact: Vec<f64> =
        (0..48_000).map(|t| modes.iter().map(|(amount, theta)| amount * (theta * f64::from(t)).cos()).sum()).collect();
    let heard: Vec<f64> = (0..exact.len())
        .map(|_| {
            let x = f64::from(s.x[places[19]]);
            tick(&scene, &mut s);
            x
        })
        .collect();
    within("B01, 0.1 s", rel_l2(&heard[..4800], &exact[..4800]), 4e-6);
    within("B01, 1 s", rel_l2(&heard, &exact), 1.5e-5);
}

/// Energy of a string of masses 1 g and springs `k` between the last two ticks, in double precision.
fn energy(s: &State, places: &[usize], k: f64) -> f64 {
    let at = |v: &[f32], i: usize| i.checked_sub(1).and_then(|i| places.get(i)).map_or(0.0, |p| f64::from(v[*p]));
    let kinetic = |i: usize| 0.5e-3 * (at(&s.d, i) * 48e3).powi(2);
    let held = |i: usize| {
        let (x, d) = (at(&s.x, i + 1) - at(&s.x, i), at(&s.d, i + 1) - at(&s.d, i));
        0.5 * k * x * (x - d)
    };
    (1..=places.len()).map(kinetic).sum::<f64>() + (0..=places.len()).map(held).sum::<f64>()
}

/// Largest relative change of energy of the first mode of a string of 40 masses tuned to `f`, over `seconds`.
fn drift(f: f64, seconds: usize) -> f64 {
    let k = 1e-3 * (82.0 * f).powi(2);
    let scene = scene(&string(40, k));
    let places = places(&scene);
    let mut s = scene.state();
    for (i, p) in places.iter().enumerate() {
        s.x[*p] = (1e-3 * (PI * (i + 1) as f64 / 41.0).sin()) as f32;
    }
    tick(&scene, &mut s);
    let (before, mut worst) = (energy(&s, &places, k), 0.0_f64);
    for _ in 0..seconds * 480 {
        (0..100).for_each(|_| tick(&scene, &mut s));
        worst = worst.max(off(energy(&s, &places, k), before));
    }
    worst
}

/// docs/numerics.md §1.6 and §2.3: 1e-5 of the energy in 10 s, and 2e-5 in 60 s of 1 Hz, where a scheme that stores two
/// positions does not even move.
#[test]
fn a_slow_string_neither_drifts_nor_freezes() {
    within("40 masses at 110 Hz, 10 s", drift(110.0, 10), 2.5e-5);
    within("40 masses at 1 Hz, 60 s", drift(1.0, 60), 5e-5);
    let a = (82.0_f32 / 48e3).powi(2);
    let mut now: Vec<f32> = (0..42).map(|i| (1e-3 * (PI * f64::from(i) / 41.0).sin()) as f32).collect();
    (now[0], now[41]) = (0.0, 0.0);
    let (begin, mut before) = (now.clone(), now.clone());
    for _ in 0..48_000 {
        let next = |i: usize| 2.0 * now[i] - before[i] + a * (now[i - 1] - 2.0 * now[i] + now[i + 1]);
        let mut after = now.clone();
        (1..41).for_each(|i| after[i] = next(i));
        (before, now) = (now, after);
    }
    let moved = now.iter().zip(&begin).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(moved < 1e-4, "a string kept as two positions has moved by {moved} m in a whole period");
}

/// The ledger balances within single precision: docs/numerics.md §2.3 gives 1e-7 per tick and 5e-5 in ten seconds.
#[test]
fn the_ledger() {
    let struck = "[STRING]\ns = { n = 40, f = \"110 Hz\", t60 = \"4 s\", m = \"1 g\" }\n[MAS]\nh = { m = \"20 g\", x = \"-5.01 mm\", v = \"1 m/s\" }\n[BUT]\nb = { between = [\"h\", \"s[8]\"], k = \"8 kN/m\", z = 0.2 }\n[SOX]\no = { from = \"s[3]\" }\n";
    let scene = with(struck, &Options { energy: true, ..Options::default() }).expect("it compiles");
    let mut s = scene.state();
    (0..480_000).for_each(|_| tick(&scene, &mut s));
    let l = s.ledger.as_ref().expect("a ledger");
    let b = l.balance();
    within("in a tick", l.extremes.worst / b.peak, 4e-7);
    within("in ten seconds", b.residual.abs() / b.peak, 4e-7);
}

const STRING: &str =
    "[STRING]\ns = { n = 40, f = \"110 Hz\", t60 = \"4 s\", m = \"1 g\" }\n[SOX]\no = { from = \"s[5]\" }\n";

/// Half a second of contacts, bows, waves, modes and implicit links, against double precision.
#[test]
fn laws_and_methods() {
    let hammer = "[MAS]\nh = { m = \"20 g\", x = \"-5.01234 mm\", v = \"1 m/s\" }\n";
    for method in ["ca", "stable", "stable3d"] {
        let text = format!(
            "{STRING}{hammer}[BUT]\nb = {{ between = [\"h\", \"s[8]\"], k = \"8 kN/m\", z = 0.2, method = \"{method}\" }}\n"
        );
        within(&format!("BUT {method}"), apart(&text, 24_000), 2.5e-4);
        let text = format!(
            "{STRING}{hammer}[HRZ]\nb = {{ between = [\"h\", \"s[8]\"], k = \"1e6 N/m^1.5\", method = \"{method}\" }}\n"
        );
        within(&format!("HRZ {method}"), apart(&text, 24_000), 2.5e-4);
    }
    for method in ["ca", "secant", "newton"] {
        let rub = |name: &str| {
            format!(
                "{name} = {{ between = [\"s[8]\", \"bow\"], f = \"0.3 N\", v0 = \"50 mm/s\", method = \"{method}\" }}\n"
            )
        };
        let bow = format!("{STRING}[ENX]\nbow = {{}}\n[gesture]\nbow = [[0, 0], [5, \"1 m\"]]\n[BOW]\n{}", rub("a"));
        within(&format!("BOW {method}"), apart(&bow, 24_000), 6e-4);
        within(&format!("two BOW {method}"), apart(&format!("{bow}{}", rub("b")), 24_000), 6e-4);
    }
    for method in ["centred", "implicit", "modal"] {
        let text = format!(
            "[model]\nmethod = \"{method}\"\n{STRING}{hammer}[BUT]\nb = {{ between = [\"h\", \"s[8]\"], k = \"8 kN/m\" }}\n"
        );
        within(method, apart(&text, 24_000), 2.5e-4);
    }
    for (code, most) in
        [("WAVEGUIDE", 2e-5), ("PLK", 6e-5), ("LNL", 3e-4), ("POW", 3e-4), ("TGR", 5e-5), ("MESH", 1e-4)]
    {
        let kind = ca_model::catalog();
        let example = kind.get(code).expect("a kind").example;
        within(code, apart(example, 24_000), most);
    }
}

/// Scaling by a power of two keeps every bit, other factors keep the sound.
#[test]
fn scale() {
    let text = |by: f64| {
        format!(
            "[STRING]\ns = {{ n = 30, m = {:?}, k = {:?}, z = {:?} }}\n[MAS]\nh = {{ m = {:?}, x = -5.01e-3, v = 1 }}\n[BUT]\nb = {{ between = [\"h\", \"s[7]\"], k = {:?} }}\n[SOX]\no = {{ from = \"s[3]\" }}\n",
            1e-3 * by,
            1e5 * by,
            1e-3 * by,
            2e-2 * by,
            8e3 * by
        )
    };
    let plain = played(&scene(&text(1.0)), 4800);
    for exponent in [-60, -30, 30, 60] {
        assert_eq!(played(&scene(&text(f64::from(exponent).exp2())), 4800), plain, "2^{exponent}");
    }
    for by in [1e-9, 1e9] {
        within(&format!("{by:e}"), rel_l2(&played(&scene(&text(by)), 4800), &plain), 1e-5);
    }
}

#[test]
fn the_same_bits() {
    let text = format!(
        "{STRING}[CEL]\nc = {{ m = 1e-3, f = 440, dx0 = 1e-3 }}\n[RES]\nr = {{ between = [\"c\", \"s[4]\"], k = 1e3 }}\n"
    );
    let reference = Options { kernel: KernelClass::Reference, ..Options::default() };
    let [one, other] = [Options::default(), reference].map(|o| played(&with(&text, &o).expect("it compiles"), 9600));
    assert_eq!(one, other);
    let end = |ticks: usize| {
        let scene = scene(&text);
        let mut s = scene.state();
        (0..ticks).for_each(|_| tick(&scene, &mut s));
        s.bits()
    };
    assert_eq!(end(4800), end(4800));
    assert_ne!(end(4800), end(4801));
}

/// Everything that a tick of a string reads and writes is single.
#[test]
fn no_number_of_the_tick_is_double() {
    let s = scene(STRING).state();
    let single: [&[f32]; 7] = [&s.x, &s.d, &s.f, &s.coef, &s.links.mem, &s.links.tap, &s.ports.lowpass];
    assert!(single[..4].iter().all(|v| v.len() >= 40));
}

/// Numbers out of its range are refused and named; double precision accepts them.
#[test]
fn what_is_not_kept() {
    let cell = |what: &str| format!("[CEL]\nc = {{ {what} }}\n[SOX]\no = {{ from = \"c\" }}\n");
    let link = |what: &str| {
        format!(
            "[SOL]\nwall = {{}}\n[MAS]\na = {{ m = 1e-3, dx0 = 1e-3 }}\n[REF]\nr = {{ between = [\"wall\", \"a\"], {what} }}\n[SOX]\no = {{ from = \"a\" }}\n"
        )
    };
    let tetra = "[room]\ndim = 3\n[room.TETRA]\np = { edge = \"2 cm\", m = \"1 g\", k = \"8 kN/m\", spin = [\"3 Hz\", 0, 0] }\n[SOF]\no = { from = \"room.p.link[0]\" }\n";
    let cases = [
        (cell("m = 1e40, f = 440, dx0 = 1e-3"), "E009", "`c`"),
        (cell("m = 1e-60, f = 440, dx0 = 1e-3"), "E009", "`c`"),
        (cell("m = 1e-3, f = 440, dx0 = 1e-35"), "E009", "`c`"),
        (cell("m = 1e-3, f = 440, dx0 = 1e39"), "E009", "`c`"),
        (cell("m = 1e-3, f = 440, t60 = 1e3, dx0 = 1e-3"), "W114", "`c`"),
        (link("k = 1e-42"), "E009", "`r`"),
        (link("k = 1e10, method = \"implicit\""), "E028", "`r`"),
        (
            format!("{STRING}loud = {{ from = \"c\", gain = 1e-39 }}\n[CEL]\nc = {{ m = 1, f = 9, dx0 = 1 }}\n"),
            "E009",
            "`loud`",
        ),
        (tetra.into(), "E028", "`room.p"),
    ];
    for (text, code, name) in cases {
        let found = with(&text, &Options::default()).map_or_else(|d| d, |scene| scene.findings);
        let said = found.list.iter().find(|d| d.code == code && d.title.contains(name));
        let said = said.unwrap_or_else(|| panic!("{text}\n{found}"));
        assert_eq!(said.severity == Severity::Error, code != "W114", "{text}\n{found}");
        assert!(said.help.as_ref().is_some_and(|h| h.contains("double precision")), "{said:?}");
        let (_, scene) = ca_compile::load(&text, "test.ca.toml", &ca_model::catalog(), &ca_compile::Options::default());
        assert!(scene.is_ok_and(|s| s.findings.list.iter().all(|d| d.code != code)), "{text}");
    }
    for text in
        [cell("m = 1e-3, f = 440, t60 = 60, dx0 = 1e-28"), link("k = 1e8, method = \"implicit\""), link("k = 1e-30")]
    {
        let found = with(&text, &Options::default()).map_or_else(|d| d, |scene| scene.findings);
        assert!(!found.has_errors() && found.list.iter().all(|d| d.code != "W114"), "{text}\n{found}");
    }
}

#[test]
fn a_change_out_of_range_is_refused() {
    let text = "[param]\nk = { value = 1e3, live = true, max = 1e60 }\n[SOL]\nwall = {}\n[MAS]\na = { m = 1e-3, dx0 = 1e-3 }\n[RES]\nr = { between = [\"wall\", \"a\"], k = \"k\" }\n[SOX]\no = { from = \"a\" }\n";
    let mut controls = scene(text).controls();
    assert!(controls.set("k", 1e30).is_ok());
    let why = controls.set("k", 1e50).expect_err("out of range").to_string();
    assert!(why.contains("cannot be computed"), "{why}");
    assert!(crate::play::scene(text).controls().set("k", 1e50).is_ok());
}

/// Limits of single precision: stiffness of an implicit link, slow decay, large and small numbers.
#[test]
fn the_limits_of_single_precision_are_where_they_are_stated() {
    let found = |text: &str| {
        let (model, read) = ca_model::read::read(text, "test.ca.toml", &ca_model::catalog());
        let options = Options { precision: Precision::Single, ..Options::default() };
        let list = match ca_compile::compile(&model, &ca_model::catalog(), &options) {
            Ok(scene) => scene.findings.list,
            Err(diags) => diags.list,
        };
        let all = read.list.into_iter().chain(list);
        let lines: Vec<_> =
            all.map(|d| format!("{}: {} ({})\n", d.code, d.title, d.help.unwrap_or_default())).collect();
        lines.concat()
    };
    let stiff = |a: f64| link("RES", &format!("k = {:?}, method = \"implicit\", theta = 0.25", k(4.0 * a)));
    // 1 − zT/m lies between two single-precision numbers, at slightly more than ten times their distance from 1
    let fades = |bit: f64| {
        let z = z((10.0 + bit) * f64::from(f32::EPSILON) / 2.0);
        format!("[CEL]\nbar = {{ m = \"1 g\", k = 1, z = {z:?} }}\n[SOX]\nout = {{ from = \"bar\" }}\n")
    };
    let large = |k: f64| link("BUT", &format!("k = {k:?}"));
    let far = |x: f64| format!("[CEL]\nbar = {{ m = 1, k = 1, dx0 = {x:?} }}\n[SOX]\nout = {{ from = \"bar\" }}\n");
    let rubbed = |by: &str| {
        format!(
            "[SOL]\nw = {{}}\n[ENX]\nbelt = {{}}\n[CEL]\nm = {{ m = 1, k = 1, dx0 = 1 }}\n[BOW]\n\
             rub = {{ between = [\"{by}\", \"m\"], curve = \"coulomb\", method = \"set-valued\", f = 1 }}\n[SOX]\nout = {{ from = [\"m\", \"belt\"] }}\n"
        )
    };
    for (code, words, quiet, reported) in [
        ("E028", "cannot stick to a moving port", rubbed("w"), rubbed("belt")),
        ("E028", "too stiff for single precision", stiff(99.9), stiff(100.1)),
        ("W114", "decays too slowly", fades(0.1), fades(0.103)),
        ("E009", "out of range for single precision", large(3.40e38), large(3.41e38)),
        ("E009", "out of range for single precision", large(1.18e-38), large(1.17e-38)),
        ("E009", "out of range for single precision", far(1.01e-30), far(0.99e-30)),
    ] {
        let is = |text: &str| found(text).lines().any(|l| l.starts_with(code) && l.contains(words));
        assert!(!is(&quiet), "{code} ({words}) is reported\n{quiet}\n{}", found(&quiet));
        assert!(is(&reported), "{code} ({words}) is not reported\n{reported}\n{}", found(&reported));
    }
}
