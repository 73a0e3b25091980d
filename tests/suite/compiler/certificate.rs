//! The certificate against brute force: for random networks of all linear links, over six decades, the factorisation
//! agrees with the eigenvalues of the running engine.
//!
//! The brute force does not use the matrices K and C. It perturbs each number of the state in both directions, runs a
//! tick, and computes the spectral radius of the result.

use crate::play::{Random, off, scene, with, within};
use ca_compile::Compiled;
use ca_compile::{Options, compile};
use ca_core::{Level, Scene, State, tick};
use ca_model::read;
use ca_tests::catalog;
use proptest::prelude::*;
use std::fmt::Write as _;

/// Gives one link in four a method.
fn method(roll: f64) -> String {
    match roll {
        r if r < 0.05 => ", method = \"centred\"".into(),
        r if r < 0.25 => format!(", method = \"implicit\", theta = {:.3}", (r - 0.05) * 3.0),
        _ => String::new(),
    }
}

/// A network of masses, cells, a string with a moving point, and a body in space that they support. T = 1, and all
/// stiffness and viscosity is multiplied by `scale`.
fn drawn(seed: u64, scale: f64) -> String {
    let mut rng = Random(seed);
    let mut roll = || 0.5 * (rng.uniform() + 1.0);
    let mut text = String::from("[rate]\nsound = 1\ngesture = 1\n[SOL]\nwall = {}\n");
    let n = 2 + (roll() * 6.0) as usize;
    let decades = |r: f64| 10f64.powf(6.0 * r - 3.0);
    let (mut masses, mut cells) = (String::from("[MAS]\n"), String::from("[CEL]\n"));
    for i in 0..n {
        let m = decades(roll());
        if roll() < 0.3 {
            let (k, z) = (scale * decades(roll()), if roll() < 0.5 { 0.0 } else { scale * decades(roll()) });
            let _ = writeln!(cells, "n{i} = {{ m = {m:e}, k = {k:e}, z = {z:e}{} }}", method(roll()));
        } else {
            let _ = writeln!(masses, "n{i} = {{ m = {m:e} }}");
        }
    }
    let string = roll() < 0.4;
    let body = roll() < 0.5;
    text += &(masses + &cells + "[REF]\n");
    let count = n + (roll() * n as f64) as usize;
    for l in 0..count {
        let a = (roll() * n as f64) as usize;
        let b = (roll() * (n + 1) as f64) as usize;
        let other = if b == n || b == a { "wall".into() } else { format!("n{b}") };
        let (k, z) = (scale * decades(roll()), if roll() < 0.5 { 0.0 } else { scale * decades(roll()) });
        let implicit = method(roll());
        let _ = writeln!(text, "l{l} = {{ between = [\"n{a}\", \"{other}\"], k = {k:e}, z = {z:e}{implicit} }}");
    }
    if string {
        let (m, k) = (decades(roll()), scale * decades(roll()));
        let _ = writeln!(
            text,
            "at = {{ between = [\"n0\", \"s@{:.3}\"], k = {:e}, z = 0 }}",
            roll(),
            scale * decades(roll())
        );
        let _ = writeln!(text, "[STRING]\ns = {{ n = 4, m = {m:e}, k = {k:e} }}");
    }
    if body {
        text += "[ball]\ndim = 3\n[ball.MAS]\n";
        for i in 0..4 {
            let place = [roll(), roll(), roll()].map(|v| format!("{v:.3}")).join(", ");
            let _ = writeln!(text, "b{i} = {{ m = {:e}, x = [{place}] }}", decades(roll()));
        }
        let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
        text += "[LPR]\n";
        for (i, j) in &pairs[..2] {
            let (k, z) = (scale * decades(roll()), scale * decades(roll()));
            let _ = writeln!(
                text,
                "q{i}{j} = {{ between = [\"ball.b{i}\", \"ball.b{j}\"], onto = [\"wall\", \"n1\"], k = {k:e}, z = {z:e} }}"
            );
        }
        text += "[REF]\n";
        let mut links = String::new();
        for (i, j) in &pairs[2..] {
            let (k, z) = (scale * decades(roll()), if roll() < 0.5 { 0.0 } else { scale * decades(roll()) });
            let _ = writeln!(links, "e{i}{j} = {{ between = [\"ball.b{i}\", \"ball.b{j}\"], k = {k:e}, z = {z:e} }}");
        }
        let at = text.find("[REF]\n").expect("it is there") + 6;
        text.truncate(text.len() - 6);
        text.insert_str(at, &links);
    }
    let all: Vec<String> = (0..n).map(|i| format!("o{i} = {{ from = \"n{i}\" }}\n")).collect();
    text + "[SOX]\n" + &all.concat()
}

/// Compiles without judging the findings; `None` if the numbers are refused.
fn compiled(text: &str) -> Option<Compiled> {
    let (model, found) = read::read(text, "drawn.ca.toml", &catalog());
    assert!(!found.has_errors(), "{text}\n{}", ca_model::render::text(&found, &model, false));
    compile(&model, &catalog(), &Options { exact: true, ..Options::default() }).ok()
}

fn near_the_limit(seed: u64) -> Option<(String, Compiled)> {
    let bound = compiled(&drawn(seed, 1.0))?.certificate.bound;
    let mut rng = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).max(1));
    let text = drawn(seed, (4.4 + 1.8 * rng.uniform()) / bound);
    let scene = compiled(&text)?;
    Some((text, scene))
}

/// Spectral radius of one tick at the pose at load.
fn radius(scene: &Scene) -> f64 {
    let start = scene.state();
    let moving: Vec<usize> = (0..scene.counts.n_mat).filter(|i| start.coef[2 * scene.counts.n_mat + i] > 0.0).collect();
    let n = moving.len();
    let place = |s: &mut State, i: usize, by: f64| match i {
        i if i < n => s.x[moving[i]] += by,
        i if i < 2 * n => s.d[moving[i - n]] += by,
        i => s.links.mem[i - 2 * n] += by,
    };
    let read = |s: &State| -> Vec<f64> {
        moving
            .iter()
            .map(|i| s.x[*i])
            .chain(moving.iter().map(|i| s.d[*i]))
            .chain(s.links.mem.iter().copied())
            .collect()
    };
    let size = 2 * n + start.links.mem.len();
    let step = 1e-6;
    let mut map = faer::Mat::<f64>::zeros(size, size);
    for j in 0..size {
        let [up, down] = [step, -step].map(|by| {
            let mut s = start.clone();
            place(&mut s, j, by);
            tick(scene, &mut s);
            read(&s)
        });
        for i in 0..size {
            map[(i, j)] = (up[i] - down[i]) / (2.0 * step);
        }
    }
    let values = map.eigenvalues().expect("they are found");
    values.iter().map(|v| v.re.hypot(v.im)).fold(0.0, f64::max)
}

/// Returns true if a push becomes a thousand times faster within ten million ticks, as with a radius of 1 + 1e-6. Free
/// motion does not become faster.
pub fn grows(scene: &Scene) -> bool {
    let mut s = scene.state();
    let moving: Vec<usize> = (0..scene.counts.n_mat).filter(|i| s.coef[2 * scene.counts.n_mat + i] > 0.0).collect();
    let mut rng = Random(7);
    for i in &moving {
        s.d[*i] += 1e-9 * rng.uniform();
    }
    let fastest = |s: &State| moving.iter().fold(0.0, |most: f64, i| most.max(s.d[*i].abs()));
    let enough = 1e3 * fastest(&s);
    (0..10_000_000).any(|_| {
        tick(scene, &mut s);
        fastest(&s) >= enough
    })
}

/// `n` networks, or as many as `PROPTEST_CASES` asks for.
fn cases(n: u32) -> ProptestConfig {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok());
    ProptestConfig { cases: asked.unwrap_or(n), ..ProptestConfig::default() }
}

/// Compares the certificate of a drawn network with the engine. `None` if it is too near the limit to tell.
fn agrees(seed: u64) -> Option<(Level, bool)> {
    let (text, scene) = near_the_limit(seed)?;
    let c = &scene.certificate;
    let (low, high) = c.largest?;
    assert!(low <= high && high - low <= 1e-12 * high, "{low} … {high}");
    // the cheap bounds enclose the eigenvalue
    assert!(c.lower <= high * (1.0 + 1e-12) && low <= c.bound * (1.0 + 1e-12), "{c:?}\n{text}");
    if (high / 4.0 - 1.0).abs() < 1e-6 {
        return None;
    }
    let r = radius(&scene);
    match c.level {
        // a free mode has the double eigenvalue 1, which differences resolve only to half their digits
        Level::Proven | Level::Linearised => assert!(high < 4.0 && r < 1.0 + 1e-4, "{r}, {c:?}\n{text}"),
        // a centred damper may slow growth below what the radius resolves; then the scene is played
        Level::Unstable => assert!(high > 4.0 && (r > 1.0 + 1e-4 || grows(&scene)), "{r}, {c:?}\n{text}"),
        _ => panic!("nothing here is open: {c:?}\n{text}"),
    }
    Some((c.level, c.exact))
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn no_disagreement_with_the_spectral_radius(seed in 1u64..) {
        agrees(seed);
    }
}

/// A network that grows by 35 millionths a tick, slowed by a centred damper.
#[test]
fn what_grows_slowly_grows() {
    assert_eq!(agrees(10_563_041_860_083_404_182).map(|(level, _)| level), Some(Level::Unstable));
}

/// A free mass beside implicit links whose explicit part is zero: the largest eigenvalue is exactly 0.
#[test]
fn where_nothing_pulls_it_is_nothing() {
    assert_eq!(agrees(9_302_555_187_871_637_248).map(|(level, _)| level), Some(Level::Proven));
}

#[test]
fn the_drawn_networks_are_of_every_kind() {
    let seen: Vec<(Level, bool)> = (1..200u64).filter_map(|i| agrees(i.wrapping_mul(0x2545_f491_4f6c_dd1d))).collect();
    for level in [Level::Proven, Level::Linearised, Level::Unstable] {
        let n = seen.iter().filter(|s| **s == (level, true)).count();
        assert!(n >= 5, "{level}: {n} by a factorisation of {}", seen.len());
    }
}

/// Eigenvalues of the table in docs/numerics.md §1.3, to all digits.
#[test]
fn the_largest_eigenvalue_is_exact() {
    let exact = Options { exact: true, ..Options::default() };
    let chain = |n: usize| {
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[STRING]\nm = {{ n = {n}, m = 1, k = 1 }}\n[SOX]\no = {{ from = \"m[0]\" }}\n"
        )
    };
    let s = with(&chain(40), &exact);
    let (low, high) = s.certificate.largest.expect("asked for");
    let closed = 4.0 * (std::f64::consts::PI * 40.0 / 82.0).sin().powi(2);
    within("chain of 40", off(low, closed).max(off(high, closed)), 1e-12);
    assert_eq!((s.certificate.level, s.certificate.exact), (Level::Proven, true));
    let mesh = |n: usize| {
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[MESH]\nm = {{ nx = {n}, ny = {n}, m = 1, k = 0.5 }}\n[SOX]\no = {{ from = \"m[0,0]\" }}\n"
        )
    };
    let s = with(&mesh(200), &exact);
    let closed = 4.0 * (std::f64::consts::PI * 199.0 / 400.0).sin().powi(2);
    within("mesh of 200 x 200", off(s.certificate.largest.expect("asked for").1, closed), 1e-11);
    assert_eq!((s.certificate.level, s.certificate.exact), (Level::Proven, true));
}

/// A network that is too stiff as a whole is reported with numbers that just make it stable.
#[test]
fn the_mended_number_mends() {
    let text = |k: f64| {
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[MAS]\na = {{ m = 1 }}\nb = {{ m = 1 }}\nc = {{ m = 1 }}\n[SOL]\nw = {{}}\n[REF]\n\
             one = {{ between = [\"a\", \"b\"], k = 1.2 }}\ntwo = {{ between = [\"b\", \"c\"], k = {k:?} }}\nsoft = {{ between = [\"a\", \"w\"], k = 0.1 }}\n\
             [SOX]\nout = {{ from = \"a\" }}\n"
        )
    };
    let s = scene(&text(1.6));
    assert_eq!((s.certificate.level, s.certificate.exact), (Level::Unstable, true));
    let reported = s.findings.list.iter().find(|d| d.code == "W103").expect("W103");
    let help = reported.help.clone().unwrap_or_default();
    let number = help.split("below ").nth(1).and_then(|t| t.split(' ').next()).and_then(|t| t.parse::<f64>().ok());
    let safe = number.unwrap_or_else(|| panic!("{help}"));
    assert!(help.contains("`two`") && safe < 1.6, "{help}");
    assert_eq!(scene(&text(safe)).certificate.level, Level::Proven);
    assert_eq!(scene(&text(safe * 1.02)).certificate.level, Level::Unstable, "{help}");
    assert!(radius(&scene(&text(safe))) < 1.0 + 1e-6);
}

/// A number named as a limit is valid for a spring and makes the scene stable; otherwise a common share does.
#[test]
fn what_mends_a_mass_is_never_below_nothing() {
    let text = |k: f64, z: f64| {
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[SOL]\nw = {{}}\n[MAS]\na = {{ m = 1 }}\n[REF]\nl = {{ between = [\"w\", \"a\"], k = {k:?}, \
             z = {z:?} }}\n[SOX]\nout = {{ from = \"a\" }}\n"
        )
    };
    // viscous and stiff, with one of the two or both beyond the limit
    for (k, z) in [(9.0, 0.5), (1.0, 3.0), (9.0, 2.5), (5.0, 2.4), (43.4, 2.083), (4.1, 0.0), (0.0, 2.1), (4.5, 9.0)] {
        let s = scene(&text(k, z));
        assert_eq!(s.certificate.level, Level::Unstable);
        let reported = s.findings.list.iter().find(|d| d.code == "W103").expect("W103");
        let help = reported.help.clone().unwrap_or_default();
        assert!(!help.contains('-'), "k = {k}, z = {z}: {help}");
        let after =
            |word: &str| help.split(word).nth(1).and_then(|t| t.split(' ').next()).and_then(|t| t.parse::<f64>().ok());
        let (k, z) =
            match (after("keep `k` of `l` below "), after("keep `z` of `l` below "), after("make `l` at most ")) {
                (Some(k), None, None) => (k, z),
                (None, Some(z), None) => (k, z),
                (None, None, Some(share)) => (k * share / 100.0, z * share / 100.0),
                other => panic!("{help}: {other:?}"),
            };
        assert!(k >= 0.0 && z >= 0.0, "{help}");
        assert_eq!(scene(&text(0.999 * k, 0.999 * z)).certificate.level, Level::Proven, "{help}");
        assert_eq!(scene(&text(1.02 * k, 1.02 * z)).certificate.level, Level::Unstable, "{help}");
    }
}

/// The margin is the smallest over contacts (limit 1), bows (limit 1.5) and the linear network.
#[test]
fn the_margin_counts_contacts_and_friction() {
    let text = |more: &str| {
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[SOL]\nw = {{}}\n[MAS]\na = {{ m = 1 }}\n{more}\n[SOX]\nout = {{ from = \"a\" }}\n"
        )
    };
    let margin = |more: &str| scene(&text(more)).certificate.margin();
    let but = |k: f64, how: &str| format!("[BUT]\nb = {{ between = [\"w\", \"a\"], k = {k:?}, d = -1{how} }}");
    within("ten times too stiff", off(margin(&but(10.0, "")), 0.1), 1e-12);
    within("half as stiff", off(margin(&but(0.5, "")), 2.0), 1e-12);
    within(
        "beside a spring",
        off(margin(&format!("{}\n[RES]\nr = {{ between = [\"w\", \"a\"], k = 1 }}", but(1e-3, ""))), 4.0),
        1e-12,
    );
    assert!(margin(&but(10.0, ", method = \"stable\"")).is_infinite() && margin("").is_infinite());
    let bow = "[BOW]\nb = { between = [\"w\", \"a\"], f = 3, v0 = 1, curve = \"coulomb\" }";
    let s = scene(&text(bow));
    assert!(
        s.certificate.rules.friction > 1.5 && s.findings.list.iter().any(|d| d.code == "W113"),
        "{:?}",
        s.certificate
    );
    within("a bow", off(s.certificate.margin(), 1.5 / s.certificate.rules.friction), 1e-12);
}

/// Modules that reach no output are not judged, and are listed as such.
#[test]
fn what_is_left_out_is_not_judged() {
    let text = "[SOL]\nw = {}\nfar = {}\n[MAS]\na = { m = 1 }\nlost = { m = 1e-6 }\n[RES]\nk = { between = [\"w\", \"a\"], k = 1 }\n\
                j = { between = [\"far\", \"lost\"], k = 1e9 }\n[SOX]\nout = { from = \"a\" }\n";
    let s = scene(text);
    assert_eq!((s.certificate.level, &s.certificate.not_judged[..]), (Level::Proven, &[String::from("lost")][..]));
    let s = scene(&format!("{text}also = {{ from = \"lost\" }}\n"));
    assert_eq!((s.certificate.level, s.certificate.not_judged.len()), (Level::Unstable, 0));
}

/// Masses replaced by their modes reach outputs and are judged by them.
#[test]
fn what_goes_by_its_modes_is_judged() {
    let text = "[model]\nmethod = \"modal\"\n[CEL]\nb = { m = 1, k = 1e6 }\nlost = { m = 1, k = 1e6 }\n\
                [SOX]\nout = { from = \"b\" }\n";
    assert_eq!(scene(text).certificate.not_judged, [String::from("lost")]);
    let s = scene(&text.replace("lost = { m = 1, k = 1e6 }\n", ""));
    assert!(s.certificate.not_judged.is_empty() && s.certificate.level == Level::Proven, "{:?}", s.certificate);
}

#[test]
fn live_parameters_count_at_their_worst_together() {
    let text = |most: f64| {
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[param]\nmm = {{ value = 10, live = true, min = 1, max = 10 }}\n\
             kk = {{ value = 1, live = true, min = 1, max = {most:?} }}\n[CEL]\nc = {{ m = \"mm\", k = \"kk\" }}\n\
             [SOX]\nout = {{ from = \"c\" }}\n"
        )
    };
    assert_eq!(scene(&text(3.9)).certificate.level, Level::Proven);
    assert_eq!(scene(&text(4.1)).certificate.level, Level::NotProven);
}

/// A stretched spring in space also resists sideways, without viscosity; the matrix agrees with the engine.
#[test]
fn tension_holds_sideways() {
    for (l0, dx0) in [(0.4, 0.0), (1.0, 0.5), (0.7, 0.2)] {
        let text = format!(
            "[rate]\nsound = 1\ngesture = 1\n[a]\ndim = 3\n[a.SOL]\nw = {{ x = [0, 0, 0] }}\n[a.MAS]\nb = {{ m = 1, x = [1, 0, 0], \
             dx0 = [{dx0:?}, 0, 0] }}\n[a.REF]\ns = {{ between = [\"a.w\", \"a.b\"], k = 0.3, z = 0.1, l0 = {l0:?} }}\n\
             [SOX]\nout = {{ from = \"a.b\", along = \"y\" }}\n"
        );
        let network =
            ca_compile::linear(&crate::play::model(&text), &catalog(), &Options::default()).expect("it compiles");
        let found = ca_compile::analysis::modes::modes(&network).expect("they are found");
        let length = 1.0 + dx0;
        // sideways F/l twice, along it k
        let mut want = [0.3 * (length - l0) / length, 0.3 * (length - l0) / length, 0.3];
        want.sort_by(f64::total_cmp);
        for (m, want) in found.list.iter().zip(want) {
            within("ω²T²", (m.a - want).abs(), 1e-12);
            within("zT/m", (m.b - if want == 0.3 { 0.1 } else { 0.0 }).abs(), 1e-12);
        }
    }
}

#[test]
fn a_steep_bow_is_reported_and_not_called_unstable() {
    let s = scene(
        "[MAS]\nreed = { m = \"1 g\" }\n[ENX]\nbow = {}\n[BOW]\nrub = { between = [\"reed\", \"bow\"], f = \"20 N\", v0 = \"10 mm/s\" }\n\
         [SOX]\nout = { from = \"reed\" }\n[gesture]\nbow = [[0, 0], [1, \"0.2 m\"]]\n",
    );
    assert_eq!(s.certificate.level, Level::NotProven);
    assert!(s.findings.list.iter().any(|d| d.code == "W113"));
    let mut state = s.state();
    (0..20_000).for_each(|_| tick(&s, &mut state));
    assert!(state.is_bounded(1.0));
}

#[test]
fn a_point_that_wanders_is_judged_at_every_node() {
    let text = |k: f64, at: &str| {
        format!(
            "[rate]\nsound = 1\ngesture = 1\n[param]\nwhere = {{ value = 0.01, live = true, min = 0, max = 1 }}\n[STRING]\n\
             s = {{ n = 9, m = 1, k = 0.8, ends = \"fixed\" }}\n[MAS]\nfinger = {{ m = 1e3 }}\n[RES]\n\
             hold = {{ between = [\"finger\", \"s@{at}\"], k = {k:?} }}\n[SOX]\nout = {{ from = \"s[2]\", gain = \"where\" }}\n"
        )
    };
    let level = |k: f64, at: &str| scene(&text(k, at)).certificate.level;
    // the end of the string bears any stiffness, its middle does not
    assert_eq!(level(2.0, "0"), Level::Proven);
    assert_eq!(level(2.0, "0.5"), Level::Unstable);
    // stable where it is, but it might move to where it is not
    assert_eq!(level(2.0, "where"), Level::NotProven);
    assert_eq!((level(0.3, "0.5"), level(0.3, "where")), (Level::Proven, Level::Proven));
}

/// A law that hardens and presses at load is not proven where rounding decides its energy, on both sides of the limit.
#[test]
fn a_hardening_contact_pressed_at_load_is_judged_by_its_slope() {
    for (k, level) in [(1e15, Level::Proven), (1e23, Level::RuleOfThumb)] {
        let text = format!(
            "[model]\nformat = 2\n[MAS]\nb = {{ m = \"1 g\" }}\nc = {{ m = \"1 g\" }}\n[SOL]\nw = {{ x = \"-1 cm\" }}\n[HRZ]\n\
             l0 = {{ between = [\"b\", \"w\"], k = {k:?} }}\nl1 = {{ between = [\"c\", \"b\"], k = 3e3 }}\n[SOX]\no = {{ from = \"b\" }}\n"
        );
        let c = scene(&text);
        assert_eq!(c.certificate.level, level, "k = {k:e}: {:?}", c.certificate);
        assert_eq!(c.findings.list.iter().any(|d| d.code == "W119"), level != Level::Proven, "{text}");
    }
}
