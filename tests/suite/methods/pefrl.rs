//! `method = "pefrl"`: B01, B03, orders, the limit, symmetry in time, and refusals.

use crate::laws::references::{duffing, pluck};
use crate::play::{TURN, apart, mat, model, off, scene, within};
use ca_compile::analysis::modes::modes;
use ca_compile::{Options, compile};
use ca_core::internal::method::pefrl::{LIMIT, explicit};
use ca_core::{Level, Scene, State, tick};
use ca_tests::catalog;

const HEAD: &str = "[model]\nmethod = \"pefrl\"\n";

/// A mass on a spring of a = kT²/m, T = 1, and the same as a cell.
fn oscillators(a: f64) -> [String; 2] {
    let rate = "[rate]\nsound = 1\ngesture = 1\n";
    let out = "[SOX]\nout = { from = \"bob\" }\n";
    [
        format!(
            "{HEAD}{rate}[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1, dx0 = 1 }}\n[RES]\nhold = {{ between = [\"wall\", \"bob\"], \
             k = {a:?} }}\n{out}"
        ),
        format!("{HEAD}{rate}[CEL]\nbob = {{ m = 1, k = {a:?}, dx0 = 1 }}\n{out}"),
    ]
}

/// First output over `ticks` ticks.
fn output(scene: &Scene, ticks: usize) -> Vec<f64> {
    let mut s = scene.state();
    let mut all = Vec::with_capacity(ticks);
    for _ in 0..ticks {
        tick(scene, &mut s);
        all.push(s.output[0]);
    }
    all
}

/// Error after one second of an oscillator of 20 Hz with an initial speed, at `rate` ticks a second.
fn missed(rate: f64) -> f64 {
    let w = TURN * 20.0;
    let scene = scene(&format!(
        "{HEAD}[rate]\nsound = {rate:?}\ngesture = {rate:?}\n[CEL]\nbob = {{ m = 1, k = {:?}, dx0 = 1, v = {:?} }}\n[SOX]\nout = \
         {{ from = \"bob\" }}\n",
        w * w,
        0.5 * w
    ));
    let played = output(&scene, rate as usize);
    let error = |(n, x): (usize, &f64)| {
        let t = n as f64 / rate;
        (x - (w * t).cos() - 0.5 * (w * t).sin()).abs()
    };
    played.iter().enumerate().map(error).fold(0.0, f64::max)
}

#[test]
fn it_is_of_fourth_order() {
    let order = (missed(400.0) / missed(800.0)).log2();
    within("order of an oscillator − 4", (order - 4.0).abs(), 0.1);
    let order = (duffing("pefrl", "", 48e3) / duffing("pefrl", "", 96e3)).log2();
    within("B03 order − 4", (order - 4.0).abs(), 0.1);
}

#[test]
fn b01_a_plucked_chain() {
    let (one, four, fine) = (pluck("pefrl", 1), pluck("pefrl", 4), pluck("ca", 32));
    within("B01 pefrl", one, 5e-4);
    within("B01 pefrl × 4", four, 2e-6);
    within("B01 pefrl over ca × 32", one / fine, 1.3);
}

fn step(scene: &Scene, x: f64, d: f64) -> (f64, f64) {
    let (mut s, i) = (scene.state(), mat(scene, "bob"));
    (s.x[i], s.d[i]) = (x, d);
    tick(scene, &mut s);
    (s.x[i], s.d[i])
}

/// The trace of a tick agrees with the closed form. Its determinant is 1, as for every symplectic map.
#[test]
fn a_tick_is_the_polynomial() {
    within("at the limit", off(explicit(LIMIT), 4.0), 1e-14);
    for a in [1e-3, 0.5, 4.0, 8.9] {
        for text in oscillators(a) {
            let scene = scene(&text);
            let ((xx, dx), (xd, dd)) = (step(&scene, 1.0, 0.0), step(&scene, 0.0, 1.0));
            within("trace", (2.0 - xx - dd - explicit(a)).abs(), 1e-14);
            within("determinant", (xx * dd - xd * dx - 1.0).abs(), 1e-13);
        }
    }
}

#[test]
fn modes_know_its_pitch() {
    for text in oscillators(5.0) {
        let network = ca_compile::linear(&model(&text), &catalog(), &Options::default()).expect("it compiles");
        let found = modes(&network).expect("they are found");
        let (x, d) = (step(&scene(&text), 1.0, 0.0), step(&scene(&text), 0.0, 1.0));
        let angle = (0.5 * (x.0 + d.1)).acos();
        within("heard", off(found.list[0].heard, angle / TURN), 1e-13);
        assert!(found.list[0].cents().abs() > 1.0, "a coarse tick is not exact");
    }
}

/// Largest |x| of any mass, with `first` released from 1.
fn largest(scene: &Scene, first: &str, ticks: usize) -> f64 {
    let mut s = scene.state();
    s.x[mat(scene, first)] = 1.0;
    let mut most = 0.0f64;
    for _ in 0..ticks {
        tick(scene, &mut s);
        most = s.x.iter().fold(most, |m, x| m.max(x.abs()));
        if most > 1e9 {
            return most;
        }
    }
    most
}

#[test]
fn the_limit_is_its_own() {
    for (share, level) in [(0.999, Level::Proven), (1.001, Level::Unstable)] {
        for text in oscillators(share * LIMIT) {
            let scene = scene(&text);
            assert_eq!(scene.certificate.level, level, "{text}");
            assert_eq!(largest(&scene, "bob", 50_000) > 1e3, level == Level::Unstable, "{text}");
        }
        // a chain, where a single mass gives no answer
        let n = 7;
        let shape = (0.5 * std::f64::consts::PI * f64::from(n) / f64::from(n + 1)).sin();
        let k = share * LIMIT / (4.0 * shape * shape);
        let scene = scene(&format!(
            "{HEAD}[rate]\nsound = 1\ngesture = 1\n[STRING]\ns = {{ n = {n}, m = 1, k = {k:?} }}\n[SOX]\nout = {{ from = \
             \"s[2]\" }}\n"
        ));
        assert_eq!((scene.certificate.level, scene.certificate.exact), (level, true), "{share}");
        assert_eq!(largest(&scene, "s[0]", 50_000) > 1e3, level == Level::Unstable, "{share}");
    }
}

/// A hardening spring under gravity, far from linear.
fn hard() -> Scene {
    scene(&format!(
        "{HEAD}gravity = 9.81\n[rate]\nsound = 1000\ngesture = 1000\n[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1, dx0 = 1 }}\n[CUB]\n\
         hold = {{ between = [\"wall\", \"bob\"], k = 1000, k3 = 30000 }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
    )).scene
}

#[test]
fn it_runs_backwards() {
    let scene = hard();
    let (mut s, i) = (scene.state(), mat(&scene, "bob"));
    let way = |s: &mut State| {
        (0..1000).for_each(|_| tick(&scene, s));
        s.d[i] = -s.d[i];
    };
    way(&mut s);
    assert!((s.x[i] - 1.0).abs() > 1e-3, "it went somewhere");
    way(&mut s);
    within("back where it was", (s.x[i] - 1.0).abs(), 1e-13);
}

#[test]
fn energy_does_not_drift() {
    let scene = hard();
    let (mut s, i) = (scene.state(), mat(&scene, "bob"));
    let energy = |s: &State| {
        let (x, v) = (s.x[i], s.d[i] / scene.rates.sample_dt);
        0.5 * v * v + 500.0 * x * x + 7500.0 * x.powi(4) + 9.81 * x
    };
    let start = energy(&s);
    let mut most = |ticks: usize| {
        (0..ticks).fold(0.0f64, |m, _| {
            tick(&scene, &mut s);
            m.max(off(energy(&s), start))
        })
    };
    let (first, all) = (most(1000), most(200_000));
    assert!(first > 1e-9, "a ripple is there: {first:e}");
    within("ripple", first, 5e-5);
    within("drift", all / first, 1.1);
}

/// A constant push equals gravity, a cell equals a mass on a spring, and a point on a mass equals that mass.
#[test]
fn two_ways_to_write_it() {
    let low = "[rate]\nsound = 1000\ngesture = 1000\n[SOL]\nwall = {}\n[STRING]\nlow = { n = 5, m = 1, k = 10000 }\n[MAS]\nbob = { m \
               = 1, dx0 = 1 }\n[SOX]\nout = { from = \"low[2]\" }\n";
    // five masses between two walls: the middle one is at 0.5
    let tie = |to: &str| scene(&format!("{HEAD}{low}[RES]\ntie = {{ between = [\"bob\", \"{to}\"], k = 20000 }}\n"));
    let (mass, point) = (output(&tie("low[2]"), 2000), output(&tie("low@0.5"), 2000));
    assert!(mass.iter().any(|x| x.abs() > 0.1));
    within("a point on a mass", apart(&mass, &point), 1e-13);
    let [spring, cell] = oscillators(1.3).map(|t| output(&scene(&t), 2000));
    within("a cell is a mass and a spring", apart(&spring, &cell), 1e-13);
    let bob =
        "[rate]\nsound = 1000\ngesture = 1000\n[CEL]\nbob = { m = 2, k = 5000 }\n[SOX]\nout = { from = \"bob\" }\n";
    let weight = output(&scene(&format!("{HEAD}gravity = 9.81\n{bob}")), 2000);
    let pushed = scene(&format!("{HEAD}{bob}[ENF]\npush = {{ to = \"bob\" }}\n"));
    let mut s = pushed.state();
    s.input[0] = -2.0 * 9.81;
    let push: Vec<f64> = (0..2000)
        .map(|_| {
            tick(&pushed, &mut s);
            s.output[0]
        })
        .collect();
    within("a push is a weight", apart(&weight, &push), 1e-14);
    // a non-finite input is refused once per tick, however many kicks it has
    s.input[0] = f64::NAN;
    tick(&pushed, &mut s);
    assert_eq!(s.ports.refused, 1);
}

#[test]
fn only_who_asks_has_it() {
    let names = |text: &str| scene(text).passes.moves.iter().map(ca_core::internal::op::Op::name).collect::<Vec<_>>();
    let [text, _] = oscillators(1.0);
    let all = names(&text);
    let count = |name: &str| all.iter().filter(|n| **n == name).count();
    assert_eq!((count("drift"), count("kick"), count("RES"), count("flush"), all.len()), (5, 4, 4, 1, 14));
    assert_eq!(names(&text.replace("pefrl", "ca")), ["integrate MAS", "flush"]);
}

#[test]
fn what_it_refuses() {
    let titles = |text: &str, options: &Options| -> Vec<String> {
        let found = compile(&model(text), &catalog(), options).err().map(|d| d.list).unwrap_or_default();
        found.into_iter().filter(|d| d.code == "E028").map(|d| d.title).collect()
    };
    let all = format!(
        "{HEAD}[SOL]\nw = {{}}\n[MAS]\na = {{ m = 1 }}\nb = {{ m = 1, x = 1 }}\n[RES]\nr = {{ between = [[\"w\", \"a\"], \
         [\"a\", \"b\"]], k = 1 }}\n[SOX]\no = {{ from = \"a\" }}\n"
    );
    assert!(titles(&all, &Options::default()).is_empty());
    let tie = |end: &str| format!("between = [\"a\", \"{end}\"]");
    let cell = |own: &str| format!("[g.CEL]\nx = {{ m = 1, {own} }}\n[g.SOX]\no = {{ from = \"g.x\" }}\n");
    let (motion, implicit) = ("the force of `g.x` depends on motion", "`g.x` is implicit");
    for (more, why) in [
        (format!("[g.REF]\nx = {{ {}, k = 1, z = 0.1 }}\n", tie("b")), motion),
        (format!("[g.HRZ]\nx = {{ {}, k = 1, h = 0.1 }}\n", tie("b")), motion),
        (format!("[g.FRO]\nx = {{ {}, z = 0.1 }}\n", tie("w")), motion),
        (format!("[g.PLK]\nx = {{ {}, k = 1, d = 1 }}\n", tie("b")), "the force of `g.x` depends on the past"),
        (format!("[g.BUT]\nx = {{ {}, k = 1, method = \"stable\" }}\n", tie("b")), implicit),
        (format!("[g.RES]\nx = {{ {}, k = 1, method = \"implicit\" }}\n", tie("b")), implicit),
        (cell("k = 1, method = \"implicit\""), implicit),
        (cell("k = 1, z = 1"), "`g.x` is damped"),
        (cell("f = 100"), "`g.x` is tuned to the pitch of the explicit scheme"),
        (format!("[g.ENX]\nx = {{}}\n[g.RES]\nt = {{ {}, k = 1 }}\n", tie("g.x")), "`g.x` is moved from outside"),
        (
            "[g.WAVEGUIDE]\nx = { f = 100, t60 = 1, tension = 1, mu = 0.001, at = [0.5] }\n[g.SOX]\no = { from = \"g.x[0]\" }\n".into(),
            "`g.x` is a waveguide",
        ),
        ("[g]\nfriction = 0.1\n[g.MAS]\nx = { m = 1 }\n[g.SOX]\no = { from = \"g.x\" }\n".into(), "`g.x` is damped"),
    ] {
        let text = format!("{all}{more}");
        let found = titles(&text, &Options::default());
        assert!(found.contains(&format!("`pefrl` cannot compute the model: {why}")), "{text}\n{found:?}");
    }
    let found = titles(&format!("{all}[g]\nmethod = \"modal\"\n{}", cell("k = 1")), &Options::default());
    assert_eq!(found, ["`g` has another method, but `pefrl` applies to the whole model"]);
    let kept = titles(&all, &Options { energy: true, ..Options::default() });
    assert_eq!(kept, ["`method = \"pefrl\"` does not support the energy ledger"]);
    // in a group the word is not allowed
    let group = "[g]\nmethod = \"pefrl\"\n[g.CEL]\nx = { m = 1, k = 1 }\n[SOX]\nxo = { from = \"g.x\" }\n";
    let refused = compile(&model(group), &catalog(), &Options::default()).expect_err("an error");
    assert!(refused.list.iter().any(|d| d.code == "E011"), "{:?}", refused.list);
}
