//! Groups with `method = "modal"`: exact to rounding, with contacts and ports like any other group, and cheap.

use crate::play::{PI, apart, audited, model, rel_l2, scene, within};
use ca_compile::{Options, compile};
use ca_core::{Level, Scene, tick};
use ca_tests::catalog;
use std::fmt::Write as _;

const N: usize = 64;

/// A string of 64 masses between walls, plucked at a fifth: T = 1, k = `a`, viscosity `z` to ground, two outputs.
fn string(method: &str, a: f64, z: f64, more: &str) -> String {
    let mut masses = String::new();
    for i in 0..N {
        let u = (i + 1) as f64 / (N + 1) as f64;
        let _ =
            writeln!(masses, "s{i} = {{ m = 1, k = 0, z = {z:?}, dx0 = {:?} }}", 1e-3 * (u / 0.2).min((1.0 - u) / 0.8));
    }
    let names = |from: usize, to: usize| (from..to).map(|i| format!("\"low.s{i}\"")).collect::<Vec<_>>().join(", ");
    format!(
        "[rate]\nsound = 1\ngesture = 1\n[low]\nmethod = \"{method}\"\n[low.SOL]\nl = {{}}\nr = {{}}\n[low.CEL]\n{masses}[low.RES]\n\
         k = {{ between = [[\"low.l\", {}], [{}, \"low.r\"]], k = {a:?} }}\n[SOX]\nout = {{ from = \"low.s12\" }}\n\
         far = {{ from = \"low.s50\" }}\n{more}",
        names(0, N),
        names(0, N),
    )
}

/// Closed form of the string: displacement of mass `i` at ticks 0 …
fn exact(a: f64, z: f64, i: usize, ticks: usize) -> Vec<f64> {
    let shape = |j: usize, i: usize| (PI * (j * (i + 1)) as f64 / (N + 1) as f64).sin();
    let mut x = vec![0.0; ticks];
    for j in 1..=N {
        let amount: f64 = (0..N)
            .map(|i| {
                let u = (i + 1) as f64 / (N + 1) as f64;
                1e-3 * (u / 0.2).min((1.0 - u) / 0.8) * shape(j, i)
            })
            .sum::<f64>()
            * 2.0
            / (N + 1) as f64;
        let w = 2.0 * a.sqrt() * (PI * j as f64 / (2 * (N + 1)) as f64).sin();
        let s = 0.5 * z;
        let damped = (w * w - s * s).sqrt();
        for (n, x) in x.iter_mut().enumerate() {
            let t = n as f64;
            *x += amount * shape(j, i) * (-s * t).exp() * ((damped * t).cos() + s / damped * (damped * t).sin());
        }
    }
    x
}

/// Outputs of `ticks` ticks, one row per output.
fn play(scene: &Scene, ticks: usize) -> Vec<Vec<f64>> {
    let mut s = scene.state();
    let mut all = vec![Vec::with_capacity(ticks); scene.counts.n_out];
    for _ in 0..ticks {
        tick(scene, &mut s);
        all.iter_mut().zip(&s.output).for_each(|(column, v)| column.push(*v));
    }
    all
}

/// docs/numerics.md §3.1: exact over 0.1 s and 1 s at 48 kHz, with and without damping. Beyond the explicit limit the
/// modes below half the rate are kept, however few.
#[test]
fn a_string_is_exact() {
    for (a, z) in [(0.25, 0.0), (0.98, 0.0), (0.25, 3e-4), (25.0, 1e-4), (1e4, 1e-4)] {
        let scene = scene(&string("modal", a, z, ""));
        assert_eq!(scene.certificate.level, Level::Proven, "{:?}", scene.certificate);
        let kept = scene.symbols.iter().filter(|s| s.code == "mode").count();
        assert!(a > 9.0 || kept == N, "{kept}");
        if a < 9.0 {
            for (ticks, most) in [(4800, 1e-11), (48_000, 1e-9)] {
                let heard = play(&scene, ticks);
                within(&format!("a = {a}, z = {z}, {ticks} ticks"), rel_l2(&heard[0], &exact(a, z, 12, ticks)), most);
                within("at the far port", rel_l2(&heard[1], &exact(a, z, 50, ticks)), most);
            }
        }
        // modes beyond half the rate are left out, so only the others are compared
        assert!(
            scene.about.left_out.iter().any(|l| l.contains("above half the sound rate")) == (a > 9.0),
            "{:?}",
            scene.about.left_out
        );
    }
    // the explicit scheme is far off, and diverges where modes do not
    let off = rel_l2(&play(&scene(&string("ca", 0.25, 0.0, "")), 4800)[0], &exact(0.25, 0.0, 12, 4800));
    assert!(off > 1e-2, "{off}");
    assert_eq!(scene(&string("ca", 25.0, 1e-4, "")).certificate.level, Level::Unstable);
}

/// Struck by a hammer, held by a damper, pushed by a force and pulled by a hand: the ledgers balance, and the motion
/// agrees with the explicit scheme at 64 times the rate.
#[test]
fn a_port_is_a_mass_to_others() {
    let touch = "[MAS]\nhammer = { m = 5, x = -2e-3, v = 4e-5 }\n[SOL]\nfelt = {}\n[ENX]\nhand = {}\n[BUT]\nhit = { between = [\"hammer\", \
                 \"low.s30\"], k = 0.01, z = 0.01 }\n[REF]\ndamp = { between = [\"felt\", \"low.s40\"], k = 0.002, z = 0.004 }\n\
                 pull = { between = [\"hand\", \"low.s20\"], k = 0.003 }\n[ENF]\npush = { to = \"low.s5\" }\n";
    let text = string("modal", 0.25, 1e-4, touch);
    let scene = audited(&text);
    assert_eq!(scene.certificate.level, Level::RuleOfThumb, "{:?}", scene.certificate);
    let mut s = scene.state();
    let [hand, push] = ["hand", "push"].map(|n| scene.input(n).expect("a port"));
    let mut heard = Vec::new();
    for n in 0..20_000 {
        s.input[hand] = 1e-4 * (1e-3 * f64::from(n)).sin();
        s.input[push] = if n < 500 { 1e-6 } else { 0.0 };
        tick(&scene, &mut s);
        heard.push(s.output[0]);
    }
    let b = s.ledger.as_ref().expect("a ledger").balance();
    within("not explained", b.residual.abs() / b.peak, 1e-12);
    let fine = compile(
        &model(&string("ca", 0.25, 1e-4, touch)),
        &catalog(),
        &Options { rate: Some(64.0), ..Options::default() },
    );
    let fine = fine.unwrap_or_else(|_| panic!("it compiles"));
    let mut s = fine.state();
    let [hand, push] = ["hand", "push"].map(|n| fine.input(n).expect("a port"));
    let mut truth = Vec::new();
    for n in 0..20_000 * 64 {
        let t = f64::from(n) / 64.0;
        s.input[hand] = 1e-4 * (1e-3 * t).sin();
        s.input[push] = if t < 500.0 { 1e-6 } else { 0.0 };
        tick(&fine, &mut s);
        if n % 64 == 0 {
            truth.push(s.output[0]);
        }
    }
    let explicit = play_driven(&string("ca", 0.25, 1e-4, touch));
    let (modal, plain) = (rel_l2(&heard, &truth), rel_l2(&explicit, &truth));
    within("struck, by modes", modal, 0.25 * plain);
    assert!(plain > 1e-2, "{plain}");
}

fn play_driven(text: &str) -> Vec<f64> {
    let scene = scene(text);
    let mut s = scene.state();
    let [hand, push] = ["hand", "push"].map(|n| scene.input(n).expect("a port"));
    (0..20_000)
        .map(|n| {
            s.input[hand] = 1e-4 * (1e-3 * f64::from(n)).sin();
            s.input[push] = if n < 500 { 1e-6 } else { 0.0 };
            tick(&scene, &mut s);
            s.output[0]
        })
        .collect()
}

/// The exact test judges a stiff spring at a port, and the scene behaves accordingly.
#[test]
fn the_certificate_sees_through_ports() {
    let held = |k: f64| {
        string(
            "modal",
            0.25,
            0.0,
            &format!("[SOL]\nw = {{}}\n[RES]\nhold = {{ between = [\"w\", \"low.s31\"], k = {k:?} }}\n"),
        )
    };
    let grows = |k: f64| play(&scene(&held(k)), 4000)[0].iter().any(|v| v.is_nan() || v.abs() > 1.0);
    let (mut low, mut high) = (0.1, 1e3);
    for _ in 0..30 {
        let k = 0.5 * (low + high);
        match scene(&held(k)).certificate.level {
            Level::Proven => low = k,
            Level::Unstable => high = k,
            other => panic!("{other} at {k}"),
        }
    }
    assert!(!grows(0.99 * low) && grows(1.05 * high), "{low} … {high}");
}

/// Set in `[model]`, the method applies to each group separately, and to the modules outside all groups.
#[test]
fn the_model_asks_for_all_its_groups() {
    let text = "[model]\nmethod = \"modal\"\n[rate]\nsound = 1\ngesture = 1\n[a]\n[a.CEL]\nx = { m = 1, k = 0.1 }\n[b]\nmethod = \"ca\"\n\
                [b.CEL]\nx = { m = 1, k = 0.1 }\n[c]\n[c.CEL]\nx = { m = 1, k = 0.1 }\ny = { m = 1, k = 0.2 }\n[CEL]\nfree = { m = 1, \
                k = 0.3, dx0 = 1 }\n[SOX]\np = { from = \"a.x\" }\nq = { from = \"b.x\" }\nr = { from = \"c.x\" }\ns = { from = \"c.y\" }\n\
                t = { from = \"free\" }\n";
    let scene = scene(text);
    let of = |code: &str| scene.symbols.iter().filter(|s| s.code == code).count();
    assert_eq!((of("mode"), of("CEL")), (4, 1), "{:?}", scene.symbols);
    let w = 0.3_f64.sqrt();
    let heard = play(&scene, 1000);
    within(
        "a cell by its mode",
        apart(&heard[4], &(0..1000).map(|n| (w * f64::from(n)).cos()).collect::<Vec<_>>()),
        1e-11,
    );
}

/// Unsupported cases are refused with a message; damping that couples modes is reported.
#[test]
fn what_cannot_be() {
    let refused = |text: &str, code: &str, word: &str| {
        let found = compile(&model(text), &catalog(), &Options::default());
        let Err(found) = found else { panic!("{text}") };
        assert!(found.list.iter().any(|d| d.code == code && d.title.contains(word)), "{found:?}");
    };
    let implicit =
        "[MAS]\nh = { m = 1, x = -1 }\n[RES]\nhold = { between = [\"h\", \"low.s3\"], k = 1, method = \"implicit\" }\n";
    refused(&string("modal", 0.25, 0.0, implicit), "E028", "is implicit");
    refused(&string("modal", 0.25, 0.0, "[SOF]\nf = { from = \"low.k[3]\" }\n"), "E028", "cannot read the force of");
    let heavy = string("modal", 0.25, 0.0, "").replace("method = \"modal\"", "method = \"modal\"\ngravity = 1");
    refused(&heavy, "E028", "gravity");
    let live = string("modal", 0.25, 0.0, "[param]\nkk = { value = 0.25, live = true, min = 0.1, max = 0.3 }\n")
        .replace("low.r\"]], k = 0.25", "low.r\"]], k = \"kk\"");
    refused(&live, "E028", "live");
    let tied = string("modal", 0.25, 0.0, "").replace("s7 = { m = 1, k = 0, z = 0.0", "s7 = { m = 1, k = 0, z = 0.01");
    let found = compile(&model(&tied), &catalog(), &Options::default()).expect("it compiles");
    assert!(found.findings.list.iter().any(|d| d.code == "W115"), "{:?}", found.findings);
}
