//! Power-law contacts by the methods that keep energy: B04, blows of any size, shared masses, space, a hand.

use crate::methods::stable::{bounce, heat, made, only_falls, ran};
use crate::play::{Random, audited, case, mat, num, off, scene, within};
use ca_core::{Level, State, tick};
use proptest::prelude::*;
use std::fmt::Write as _;

#[test]
fn b04_a_hertz_contact_by_method() {
    let c = case("B04");
    let (m, k, t) = (num(c, "setup/m"), num(c, "setup/k"), num(c, "values/t_contact"));
    let hit = |method: &str, fs: f64| {
        let law = format!("[HRZ]\nhit = {{ between = [\"wall\", \"ball\"], k = {k:?}, method = \"{method}\" }}\n");
        bounce(fs, &law, t, m)
    };
    for (method, name) in [("stable", "DG"), ("stable3d", "EQ")] {
        let (place, speed) = hit(method, 48e3);
        let should_be = num(c, &format!("values/rms_pos_err_48k/{name}"));
        within(&format!("B04 place, {method}: {place:.2e}, {should_be:.2e} expected"), place, 1.1 * should_be);
        within(&format!("B04 speed, {method}"), speed, num(c, "tolerance/DG_vel"));
    }
    let (fine, finer) = (hit("stable", 384e3).0, hit("stable", 768e3).0);
    within("B04 order 2, stable", ((fine / finer).log2() - num(c, "tolerance/order")).abs(), 0.1);
    let (fine, finer) = (hit("stable3d", 384e3).0, hit("stable3d", 768e3).0);
    assert!((fine / finer).log2() > 0.9, "no order 1: {fine} {finer}");
}

/// HRZ with exponent 1 is the linear law.
#[test]
fn a_power_of_one_is_a_buffer() {
    let text = |law: &str| {
        format!(
            "[SOL]\nwall = {{}}\n[MAS]\nball = {{ m = 0.001, x = 1e-4, v = -1 }}\n{law}[SOX]\nout = {{ from = \"ball\" }}\n"
        )
    };
    for k in [1e5, 1e7, 1e11] {
        for method in ["stable", "stable3d"] {
            let play = |law: &str| {
                let scene = scene(&text(&law.replace("METHOD", method)));
                let mut s = scene.state();
                let i = mat(&scene, "ball");
                let path: Vec<f64> = (0..200).map(|_| (tick(&scene, &mut s), s.x[i]).1).collect();
                path
            };
            let tail = format!("between = [\"wall\", \"ball\"], k = {k:?}, method = \"METHOD\"");
            let one = play(&format!("[HRZ]\nhit = {{ {tail}, p = 1 }}\n"));
            let other = play(&format!("[BUT]\nhit = {{ {tail}, sticky = false }}\n"));
            let size = other.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let apart = one.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            within(&format!("p = 1 is a BUT, k = {k:e}, {method}"), apart / size, 1e-12);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// Blows from 1 µm/s to 1 km/s of masses from 1 mg to 1 kg, with hardness kη^(p−1)T²/m at the depth of a tick up to
    /// 1e16 and any loss, never make energy or pull, and the ledgers balance.
    #[test]
    fn any_blow_only_takes(
        exponents in [0.0..1.0f64, -6.0..3.0f64, -6.0..0.0f64, -4.0..16.0f64, -6.0..6.0f64],
        p in 4u32..=20,
        inside in any::<bool>(),
        begins in -3.0..1.0f64,
        lossless in any::<bool>(),
    ) {
        let p = 0.25 * f64::from(p);
        let [phase, speed, mass, hard, loss] = exponents;
        let (v, m) = (10f64.powf(speed), 10f64.powf(mass));
        let reach = v / 48e3;
        let k = 10f64.powf(hard) * m * 48e3 * 48e3 / reach.powf(p - 1.0);
        let h = if lossless { 0.0 } else { 10f64.powf(loss) / v };
        // starts at most three ticks away, or pressed by up to one tick
        let (x, sense, way) = (reach * (phase - begins), ["outside", "inside"][usize::from(inside)], [1.0, -1.0][usize::from(inside)]);
        // √(kη^(p−1)T²/m) is the energy of the rounding of a position, at the depth of a tick
        let tolerance = 1e-12 + 1e-14 * 10f64.powf(0.5 * hard);
        for method in ["stable", "stable3d"] {
            let text = format!(
                "[SOL]\nwall = {{}}\n[MAS]\nball = {{ m = {m:?}, x = {:?}, v = {:?} }}\n[HRZ]\nhit = {{ between = [\"wall\", \"ball\"], \
                 k = {k:?}, p = {p:?}, h = {h:?}, sense = \"{sense}\", method = \"{method}\" }}\n[SOX]\nout = {{ from = \"ball\" }}\n",
                way * x, -way * v
            );
            let scene = audited(&text);
            let stiff = scene.findings.list.iter().any(|d| d.code == "W119");
            prop_assert_eq!(scene.certificate.level, if stiff { Level::RuleOfThumb } else { Level::Proven });
            let s = only_falls(&scene, 400, tolerance, &text, |s| {
                assert!(s.links.tap.iter().all(|f| way * f <= 0.0), "{method} pulls\n{text}");
            });
            let b = s.ledger.as_ref().expect("a ledger").balance();
            prop_assert!(b.scheme_error <= tolerance * b.peak, "{method}: made {:e}\n{text}", b.scheme_error / b.peak);
            prop_assert!(!lossless || off(b.h, b.h0) <= tolerance, "{method}: {b:?}\n{text}");
        }
    }
}

#[test]
fn losses_of_hunt_and_crossley() {
    // restitution with a light loss: 1 − e = (2/3) h v as in Hunt and Crossley 1975, e.g. h = 1.5 α with α v ≪ 1
    for (method, tolerance) in [("stable", 0.03), ("stable3d", 0.03)] {
        for h in [0.001, 0.003, 0.01] {
            let text = format!(
                "[rate]\nsound = \"1 MHz\"\n[SOL]\nwall = {{}}\n[MAS]\nball = {{ m = 0.001, x = 1e-6, v = -1 }}\n[HRZ]\nhit = {{ between = [\"wall\", \"ball\"], k = 1e8, h = {h:?}, method = \"{method}\" }}\n[SOX]\nout = {{ from = \"ball\" }}\n"
            );
            let scene = audited(&text);
            let mut s = scene.state();
            (0..1000).for_each(|_| tick(&scene, &mut s));
            let back = s.d[mat(&scene, "ball")] * scene.rate;
            within(&format!("restitution, {method}, h = {h}"), off(1.0 - back, 2.0 / 3.0 * h), tolerance);
            let ledger = s.ledger.as_ref().expect("a ledger");
            within("its heat", off(ledger.h0 - ledger.h, heat(&scene, &s)), 1e-9);
        }
    }
}

/// A row of balls between walls, with the ledgers for each stiffness.
#[test]
fn masses_that_share_a_blow_keep_their_energy() {
    for a in [1.0, 1e4, 1e8, 1e12] {
        for h in [0.0, 0.3] {
            let k = a * 1e-3 * 48e3 * 48e3 / (3.0f64 / 48e3).sqrt();
            let mut text = String::from("[SOL]\nleft = { x = -0.01 }\nright = { x = 0.07 }\n[MAS]\n");
            let mut rng = Random(7);
            for i in 0..7 {
                let m = 1e-3 * (1.0 + 0.5 * rng.uniform());
                let _ = writeln!(
                    text,
                    "b{i} = {{ m = {m:?}, x = {:?}, v = {:?} }}",
                    0.01 * f64::from(i),
                    3.0 * rng.uniform()
                );
            }
            let how = format!("k = {k:?}, h = {h:?}, method = \"stable\", d = 0.001");
            let _ = write!(
                text,
                "[HRZ]\nl = {{ between = [\"left\", \"b0\"], {how} }}\nr = {{ between = [\"b6\", \"right\"], {how} }}\n"
            );
            for i in 0..6 {
                let _ = writeln!(text, "c{i} = {{ between = [\"b{i}\", \"b{}\"], {how} }}", i + 1);
            }
            let scene = audited(&(text + "[SOX]\nout = { from = \"b3\" }\n"));
            assert!(ran(&scene).contains(&"HRZ stable, shared") && !ran(&scene).contains(&"HRZ stable"));
            // beyond 1e9 rounding decides
            let stiff = scene.findings.list.iter().any(|d| d.code == "W119");
            assert_eq!(scene.certificate.level, if stiff { Level::RuleOfThumb } else { Level::Proven });
            let mut s = scene.state();
            let (mut worst, mut struck, mut last) = (0.0f64, 0, f64::INFINITY);
            let mut rises = 0.0f64;
            for n in 0..48_000 {
                tick(&scene, &mut s);
                let ledger = s.ledger.as_ref().expect("a ledger");
                struck += usize::from(s.links.tap.iter().filter(|f| **f < 0.0).count() > 1);
                if n > 0 {
                    worst = worst.max(off(ledger.h, ledger.h0));
                    rises = rises.max((ledger.h - last) / ledger.extremes.peak);
                }
                last = ledger.h;
            }
            // stiffer ones separate within a tick
            assert!(struck > 0 || a > 1.0, "never two at once");
            // the rest is the rounding of positions times the stiffness
            let most = 1e-14 * f64::max(a, 1e3);
            within(&format!("a row of round balls, a = {a:e}, h = {h}"), worst, if h == 0.0 { most } else { 1.0 });
            within("it rises by", rises, most);
            within("made", made(&s), most);
            assert!(
                s.links.touches.unsolved == 0 || a > 1e8 && s.links.touches.unsolved < 50,
                "{:?}",
                s.links.touches.unsolved
            );
            let ledger = s.ledger.as_ref().expect("a ledger").balance();
            within("its residual", ledger.residual.abs() / ledger.peak, 1e-12);
            let at = |i: usize| s.x[mat(&scene, &format!("b{i}"))] + scene.places.rest[mat(&scene, &format!("b{i}"))];
            assert!((0..6).all(|i| at(i + 1) > at(i)), "a ball has passed another");
        }
    }
}

#[test]
fn a_ball_in_a_round_box() {
    for (k, h, most) in [(1e7, 0.0, 1e-11), (1e11, 0.0, 1e-11), (1e15, 0.0, 1e-10), (1e11, 0.5, 1e-11)] {
        let text = format!(
            "[room]\ndim = 3\n[room.MAS]\nball = {{ m = \"1 g\", v = [1, 0.3, -2] }}\n[room.SOL]\nbox = {{ x = [0.01, 0, 0] }}\n[HRZ]\n\
             wall = {{ between = [\"room.box\", \"room.ball\"], k = {k:?}, h = {h:?}, d = 0.05, sense = \"inside\", method = \"stable\" }}\n\
             floor = {{ between = [\"room.box\", \"room.ball\"], along = \"z\", d = -0.02, k = {k:?}, h = {h:?}, method = \"stable\" }}\n\
             [SOX]\nout = {{ from = \"room.ball\", along = \"x\" }}\n"
        );
        let scene = audited(&text);
        let mut s = scene.state();
        let (mut worst, mut last, mut touched) = (0.0f64, f64::INFINITY, [0; 2]);
        for n in 0..24_000 {
            tick(&scene, &mut s);
            let ledger = s.ledger.as_ref().expect("a ledger");
            (0..2).for_each(|i| touched[i] += u32::from(s.links.tap[i] != 0.0));
            if n > 0 {
                worst = worst.max(off(ledger.h, ledger.h0));
                assert!(ledger.h <= last + most * ledger.extremes.peak);
            }
            last = ledger.h;
        }
        assert!(touched.iter().all(|n| *n > 3), "{touched:?}");
        within(&format!("a round box, k = {k:e}, h = {h}"), worst, if h == 0.0 { 1e-10 } else { 1.0 });
        let b = s.ledger.as_ref().expect("a ledger").balance();
        within("its residual", b.residual.abs() / b.peak, 1e-12);
        within("made", made(&s), most);
    }
}

#[test]
fn pressed_at_load_turned_while_pressed_and_a_hand() {
    for method in ["stable", "stable3d"] {
        // pressed at load: all stored energy becomes motion, except for the half tick of the start
        let text = format!(
            "[param]\nk = {{ value = 1e7, unit = \"N/m^1.5\", live = true, min = 1e5, max = 1e9 }}\n[SOL]\nfloor = {{}}\n[MAS]\nball = {{ m = \"1 g\", x = \"-0.1 mm\" }}\n[HRZ]\nhit = {{ between = [\"floor\", \"ball\"], k = \"k\", method = \"{method}\" }}\n[SOX]\nout = {{ from = \"ball\" }}\n"
        );
        let scene = audited(&text);
        let play = |turn: Option<f64>| {
            let mut s = scene.state();
            tick(&scene, &mut s);
            if let Some(k) = turn {
                assert!(s.apply(&scene.controls().set("k", k).expect("a number"), 4));
            }
            (0..2000).for_each(|_| tick(&scene, &mut s));
            let v = s.d[mat(&scene, "ball")] * scene.rate;
            (s, 0.5e-3 * v * v)
        };
        let held = 1e7 * 1e-4f64.powf(2.5) / 2.5;
        let (s, out) = play(None);
        within(&format!("all of what was pressed, {method}"), off(out, held), 0.05);
        within("made", made(&s), 1e-12);
        // a change of stiffness while pressed is booked as such, and no energy is made
        for k in [1e5, 1e9] {
            let (s, out) = play(Some(k));
            let b = s.ledger.as_ref().expect("a ledger").balance();
            within("made", made(&s), 1e-11);
            within("the ledger", b.residual.abs() / b.peak, 1e-12);
            within("what went in came out", off(out, b.h0 + b.changed), 1e-9);
            assert!(method == "stable3d" || (b.changed > 0.0) == (k > 1e7), "{b:?}");
        }
        let text = format!(
            "[ENX]\nfloor = {{ x = \"-1 mm\" }}\n[MAS]\nball = {{ m = \"1 g\" }}\n[HRZ]\nhit = {{ between = [\"floor\", \"ball\"], k = 1e9, method = \"{method}\" }}\n[SOX]\nout = {{ from = \"ball\" }}\n"
        );
        let scene = audited(&text);
        let mut s: State = scene.state();
        for n in 0..2000 {
            s.input[0] = -1e-3 + (f64::from(n) / scene.rate).min(0.02);
            tick(&scene, &mut s);
        }
        within("twice the speed of the hand", (s.d[mat(&scene, "ball")] * scene.rate - 2.0).abs(), 1e-9);
        within("work of the hand", off(s.ledger.as_ref().expect("a ledger").balance().work, 2e-3), 1e-9);
    }
}

#[test]
fn nothing_where_there_is_no_stiffness() {
    for method in ["stable", "stable3d"] {
        let scene = audited(&format!(
            "[SOL]\nwall = {{}}\n[MAS]\nball = {{ m = 1, x = 1e-5, v = -1 }}\n[HRZ]\nhit = {{ between = [\"wall\", \"ball\"], k = 0, h = 1, method = \"{method}\" }}\n[SOX]\nout = {{ from = \"ball\" }}\n"
        ));
        let mut s = scene.state();
        (0..100).for_each(|_| tick(&scene, &mut s));
        within("it goes on", off(s.d[mat(&scene, "ball")] * scene.rate, -1.0), 1e-14);
    }
}

#[test]
fn the_first_try_is_near_the_root() {
    // x^(4/n) from the bits, and the mean slope of a power without cancellation
    for n in 4..=24 {
        let n = f64::from(n);
        for e in -60..=60 {
            let x = 10f64.powf(0.37 + 0.5 * f64::from(e));
            let near = ca_core::internal::numeric::quarter_root(x, n) / x.powf(4.0 / n);
            within("a root by bits", (near - 1.0).abs(), 0.125);
        }
        for s in [1e-9, 0.3, 1.0, 7.0] {
            for a in [1e-7, 0.1, 1.0, 50.0] {
                let p = 0.25 * n;
                let mean = ca_core::internal::numeric::quarter_mean(s, a, n);
                let should_be = if s == a { p * a.powf(p - 1.0) } else { (s.powf(p) - a.powf(p)) / (s - a) };
                within("a mean slope", off(mean, should_be), 1e-13);
            }
            let next = f64::from_bits(s.to_bits() + 1);
            within(
                "of neighbours",
                off(ca_core::internal::numeric::quarter_mean(next, s, n), 0.25 * n * s.powf(0.25 * n - 1.0)),
                1e-13,
            );
        }
    }
}
