//! Groups at the gesture rate: no energy is made at their border, whatever links cross, and with short frames they
//! converge to the result at the sound rate.

use crate::play::{audited, mat, model, off, rel_l2, scene, within};
use ca_compile::{Options, compile};
use ca_core::{Level, Scene, State, tick};
use ca_tests::catalog;

/// A mass in a group joined to one at the sound rate, which a wall holds.
fn two(rate: &str, big: &str, link: &str) -> String {
    format!(
        "[slow]\nrate = \"{rate}\"\n[slow.MAS]\nbig = {{ m = \"{big}\", dx0 = \"1 mm\", v = 0.1 }}\n\
         [MAS]\nsmall = {{ m = \"10 g\" }}\n[SOL]\nwall = {{}}\n[RES]\nground = {{ between = [\"wall\", \"small\"], k = \
         \"20 kN/m\" }}\n[REF]\ntie = {{ between = [\"slow.big\", \"small\"], {link} }}\n[SOX]\nout = {{ from = \"small\", gain \
         = 100 }}\n"
    )
}

/// A body in space under gravity, held by a hand and tied to a string in two places.
const BODY: &str = r#"
[body]
dim = 3
rate = "gesture"
gravity = "9.81 m/s^2"
friction = "1 mN s/m"
[body.MAS]
a = { m = "20 g", x = [0, 0, 0] }
b = { m = "20 g", x = ["5 cm", 0, 0] }
c = { m = "20 g", x = [0, "5 cm", 0] }
d = { m = "20 g", x = [0, 0, "5 cm"] }
[body.SOL]
roof = { x = [0, 0, "20 cm"] }
[BUT]
apart = { between = ["body.b", "body.c"], k = "1 kN/m", z = "0.1 N s/m", d = "7 cm" }
[REF]
edge = { between = [["body.a", "body.a", "body.a", "body.c", "body.roof"], ["body.b", "body.c", "body.d", "body.d", "body.d"]], k = "2 kN/m", z = "0.1 N s/m" }
hold = { between = ["hand.key", "body.a"], k = "1 kN/m", z = "0.2 N s/m", l0 = 0 }
rub = { between = ["body.b", "low[10]"], along = "y", k = "3 kN/m", z = "0.1 N s/m" }
tie = { between = ["body.d", "low[20]"], along = "z", k = "3 kN/m" }
[hand]
dim = 3
[hand.TGR]
key = { dof = [0, 1, 2] }
[STRING]
low = { n = 40, f = "110 Hz", t60 = "2 s", m = "4 g" }
[SOX]
out = { from = "low[5]", gain = 100 }
seen = { from = "body.d", along = "z" }
"#;

fn move_hand(scene: &Scene, s: &mut State) {
    if s.tick == 0 || (s.tick - 1).is_multiple_of(u64::from(scene.rates.ratio)) {
        let t = s.tick as f64 / scene.rate;
        for (k, x) in s.input.iter_mut().enumerate() {
            *x = 0.02 * (20.0 * t * (k + 1) as f64).sin();
        }
    }
}

/// Conserved energy of the two masses at the end of a frame (docs/numerics.md §5.4), from positions and motion alone:
/// the mass of the group by its own scheme, the sound side with the border fixed.
fn energy(scene: &Scene, s: &State, [small, border]: [usize; 2], big: f64, k: f64) -> f64 {
    let (t, frame) = (1.0 / scene.rate, f64::from(scene.rates.ratio) / scene.rate);
    let d = s.slow.as_ref().expect("a group").state.d[0];
    let (x, v, border) = (s.x[small], s.d[small] / t, s.x[border]);
    let at = x - s.d[small];
    let kinetic = 0.5 * big * (d / frame).powi(2) + 0.5 * 0.01 * v * v;
    kinetic + 0.5 * 20_000.0 * x * at + 0.5 * k * (border - at) * (border - x)
}

/// E05: two masses across the rates neither gain nor lose energy in 100 s. Nor do they in 10 s with a link a hundred
/// times stiffer than its mass allows at the rate of the group: kT²/M = 111.
///
/// With the mean force of the frame before, the energy would grow at KT/4M with both springs in series: 1.7 /s and 1600
/// /s.
#[test]
fn e05_two_masses_across_the_rates_keep_their_energy() {
    for (big, m, k, n) in [("0.2 kg", 0.2, 5e3, 300_000), ("1 g", 1e-3, 1e6, 30_000)] {
        let scene = scene(&two("gesture", big, &format!("k = {k}")));
        assert_eq!(scene.certificate.level, Level::Proven);
        let places = [mat(&scene, "small"), mat(&scene, "slow.big")];
        let mut s = scene.state();
        tick(&scene, &mut s);
        let (mut first, mut worst, mut last) = (None, 0.0_f64, 0.0_f64);
        for _ in 0..n {
            (0..16).for_each(|_| tick(&scene, &mut s));
            let e = energy(&scene, &s, places, m, k);
            let e0 = *first.get_or_insert(e);
            last = (e - e0) / e0;
            worst = worst.max(last.abs());
        }
        within("spread of the energy", worst, 1e-11);
        within("growth [1/s]", 0.5 * last.abs() / (f64::from(n) / 3000.0), 1e-12);
    }
}

/// Largest error of the predicted force of a frame against the mean over its ticks, relative to the largest force.
fn unforeseen(scene: &Scene) -> f64 {
    let group = scene.rates.slow.as_ref().expect("a group");
    let mut s = scene.state();
    let (mut sums, mut worst, mut size) = (vec![0.0; group.coupled], 0.0_f64, 0.0_f64);
    for n in 0..24_000 {
        move_hand(scene, &mut s);
        tick(scene, &mut s);
        let slow = s.slow.as_ref().expect("its state");
        let last = n % scene.rates.ratio == 0;
        for (k, (sum, port)) in sums.iter_mut().zip(&slow.ports).enumerate() {
            *sum += if last { 0.5 * port.force } else { port.force };
            if last {
                let mean = *sum / f64::from(scene.rates.ratio);
                if n > 0 {
                    worst = worst.max((mean - slow.state.input[k]).abs());
                    size = size.max(mean.abs());
                }
                *sum = 0.5 * port.force;
            }
        }
    }
    assert!(size > 0.5, "{size} N is no force");
    worst / size
}

/// The border predicts the mean force of each frame exactly, for a body in space held by a hand.
#[test]
fn the_force_of_a_frame_is_known_as_it_begins() {
    for rate in ["", "gesture = \"1 kHz\"", "gesture = \"48 kHz\"", "latency = 2"] {
        let scene = scene(&format!("[rate]\n{rate}\n{BODY}"));
        let group = scene.rates.slow.as_ref().expect("a group");
        assert_eq!((group.coupled, group.links, group.masses), (5, 6, 4));
        within("mean force of a frame", unforeseen(&scene), 1e-12);
    }
}

/// A force travels one link per tick. Within that reach of a frame a contact is refused, beyond it a contact may be.
#[test]
fn beyond_the_reach_of_a_frame_there_may_be_anything() {
    let text = |node: usize| {
        format!(
            "[slow]\nrate = \"gesture\"\n[slow.MAS]\nbig = {{ m = \"50 g\", v = -1 }}\n[STRING]\nlow = {{ n = 40, f = \"110 Hz\", \
             m = \"4 g\" }}\n[SOL]\nrail = {{ x = \"-1 mm\" }}\n[RES]\ntie = {{ between = [\"slow.big\", \"low[0]\"], k = 2000 \
             }}\n[BUT]\nbuzz = {{ between = [\"rail\", \"low[{node}]\"], k = \"20 kN/m\", d = \"0.99 mm\" }}\n[SOF]\nout = {{ from = \
             \"buzz\" }}\n"
        )
    };
    // `low[0]` is one link from the group
    let scene = scene(&text(15));
    let mut s = scene.state();
    let touches = (0..24_000).filter(|_| {
        tick(&scene, &mut s);
        s.output[0] != 0.0
    });
    assert!(touches.count() > 100, "it is no contact that never touches");
    within("mean force of a frame", unforeseen(&scene), 1e-12);
    let found = compile(&model(&text(14)), &catalog(), &Options::default()).expect_err("too near");
    assert!(
        found.list.iter().any(|d| d.code == "E034" && d.title.contains("`buzz`") && d.title.contains("15 links")),
        "{found}"
    );
}

/// The ledger balances over both rates, tick by tick. At the start of a frame the energy in transit is the work of the
/// force of its first tick in half a tick, so none is lost or made at the border.
#[test]
fn the_ledger_closes_over_both_rates() {
    for rate in ["", "oversample = 2", "gesture = \"6 kHz\""] {
        let scene = audited(&format!("[rate]\n{rate}\n{BODY}"));
        let group = scene.rates.slow.as_ref().expect("a group");
        let mut s = scene.state();
        let (mut open, mut peak) = (0.0_f64, 0.0);
        for n in 0..48_000_u64 {
            move_hand(&scene, &mut s);
            let before: Vec<f64> = s.slow.as_ref().expect("its state").ports.iter().map(|p| p.force).collect();
            tick(&scene, &mut s);
            let (slow, ledger) = (s.slow.as_ref().expect("its state"), s.ledger.as_ref().expect("kept"));
            if scene.oversample() == 1 && n > 1 && (n - 1) % u64::from(scene.rates.ratio) == 0 {
                let half = slow.ports.iter().zip(&before).take(group.coupled);
                let half: f64 = half.map(|(p, f)| 0.5 * f * (p.to - p.from) / f64::from(scene.rates.frame)).sum();
                open = open.max((ledger.in_transit() - half).abs());
            }
            peak = ledger.balance().peak;
        }
        let ledger = s.ledger.as_ref().expect("kept");
        let b = ledger.balance();
        assert!(b.work > 0.5 && b.lost > 0.5 && peak > 1.0, "{b:?}: nothing happened");
        within("residual", b.residual.abs() / b.peak, 1e-12);
        within("one tick", ledger.extremes.worst / b.peak, 1e-13);
        within("left at the border", open / peak, 1e-12);
    }
}

#[test]
fn a_damper_across_the_rates_only_takes() {
    let scene = audited(&two("gesture", "1 g", "k = 1e5, z = 50"));
    let mut s = scene.state();
    let mut last = f64::INFINITY;
    for n in 0..3000 {
        (0..16).for_each(|_| tick(&scene, &mut s));
        let b = s.ledger.as_ref().expect("kept").balance();
        let left = b.h0 - b.lost;
        assert!(n == 0 || left <= last + 1e-15 * b.h0, "frame {n}: {left} after {last}");
        last = left;
    }
    assert!(last < 0.1 * s.ledger.as_ref().expect("kept").balance().h0);
}

/// The error of a group is of second order in its frame, against the group at the sound rate.
#[test]
fn a_group_comes_to_what_it_is_at_the_sound_rate() {
    let heard = |text: &str| -> Vec<f64> {
        let scene = scene(text);
        let mut s = scene.state();
        let mut one = || {
            tick(&scene, &mut s);
            s.output[0]
        };
        (0..4800).map(|_| one()).collect()
    };
    let link = "k = 5000, z = 2";
    let sound = heard(&two("sound", "0.2 kg", link));
    let rates = [1500, 3000, 6000];
    let at = |g: i32| rel_l2(&heard(&format!("[rate]\ngesture = {g}\n{}", two("gesture", "0.2 kg", link))), &sound);
    let errors = rates.map(at);
    within("at 3 kHz", errors[1], 1.5e-3);
    for pair in errors.windows(2) {
        within("order", off(pair[0] / pair[1], 4.0), 0.03);
    }
}

/// A generator in a group has the given pitch at the tick of the group, and it can be heard.
#[test]
fn a_string_in_a_group_has_its_pitch() {
    let scene = scene(
        "[slow]\nrate = \"gesture\"\n[slow.STRING]\nlow = { n = 10, f = \"40 Hz\", m = \"1 kg\" }\n[MAS]\nbob = { m = \"1 g\", dx0 \
         = \"1 mm\" }\n[RES]\ntie = { between = [\"slow.low[4]\", \"bob\"], k = 10 }\n[SOX]\nout = { from = \"slow.low[2]\" }\n",
    );
    let group = scene.rates.slow.as_ref().expect("a group");
    assert_eq!((group.masses, group.links, group.coupled, group.ports.len()), (10, 11, 1, 2));
    // sin(πfT) = √(kT²/m) sin(π/22)
    let slow = &scene.state().slow.expect("its state").state;
    let c = slow.coef[2 * group.layout.counts.n_mat + group.ports[0].own as usize];
    let k = slow.coef[group.forces.iter().find(|op| op.law.is_some()).expect("links").coef];
    let f = ((k * c).sqrt() * (std::f64::consts::PI / 22.0).sin()).asin() * 3000.0 / std::f64::consts::PI;
    within("pitch", off(f, 40.0), 1e-12);
}

#[test]
fn a_snapshot_goes_on_to_the_bit() {
    let scene = scene(BODY);
    let mut s = scene.state();
    for _ in 0..1000 {
        move_hand(&scene, &mut s);
        tick(&scene, &mut s);
    }
    let mut kept = s.clone();
    for s in [&mut s, &mut kept] {
        for _ in 0..1000 {
            move_hand(&scene, s);
            tick(&scene, s);
        }
    }
    assert_eq!(s.bits(), kept.bits());
    kept.slow.as_mut().expect("its state").ports[0].force += 1e-9;
    assert_ne!(s.bits(), kept.bits(), "the force at the end of a frame decides the next");
}

/// `rate = "sound"` is the default: the scene has the same identity and no slow passes.
#[test]
fn a_scene_without_slow_groups_has_nothing_of_them() {
    let text = two("sound", "0.2 kg", "k = 5000");
    let (with, without) = (scene(&text), scene(&text.replace("rate = \"sound\"\n", "")));
    assert_eq!(with.identity(), without.identity());
    assert!(with.rates.slow.is_none() && with.state().slow.is_none());
    let group = |scene: &Scene| {
        scene.passes.reads.iter().chain(&scene.passes.forces).filter(|o| o.name().starts_with("gesture")).count()
    };
    assert_eq!((group(&with), group(&scene(&text.replace("sound", "gesture")))), (0, 2));
}

/// Each side is judged by its own tick: a link within the group by the frame, one across by the sound side alone.
#[test]
fn each_side_is_judged_by_its_own_tick() {
    let inner = |k: f64| {
        let more = format!(
            "far = {{ m = \"0.2 kg\" }}\n[RES]\nin = {{ between = [\"slow.big\", \"slow.far\"], k = {k} }}\n[MAS]\nsmall"
        );
        let text = two("gesture", "0.2 kg", "k = 5000").replacen("[MAS]\nsmall", &more, 1);
        let text = text.replacen("[RES]\nground", "ground", 1).replacen(
            "[MAS]\nsmall = { m = \"10 g\" }\n[SOL]\nwall = {}\n",
            "",
            1,
        );
        format!("[MAS]\nsmall = {{ m = \"10 g\" }}\n[SOL]\nwall = {{}}\n{text}")
    };
    // two masses on a spring: 2 k T²/m
    let limit = 4.0 * 0.2 * 3000.0 * 3000.0 / 2.0;
    let (below, above) = (scene(&inner(limit * 0.999)), scene(&inner(limit * 1.001)));
    assert_eq!(below.certificate.level, Level::Proven);
    assert_eq!(above.certificate.level, Level::Unstable);
    assert!(above.findings.list.iter().any(|d| d.code == "W103" && d.title.contains("gesture rate")));
    // at 48 kHz: (20 kN/m + k) T²/m of the mass at the sound rate
    let limit = 4.0 * 0.01 * 48e3 * 48e3 - 20e3;
    let across = |k: f64| scene(&two("gesture", "1 g", &format!("k = {k}"))).certificate.level;
    assert_eq!((across(limit * 0.999), across(limit * 1.001)), (Level::Proven, Level::Unstable));
}
