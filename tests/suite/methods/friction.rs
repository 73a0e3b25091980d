//! Friction by the methods that only resist: no energy gain, sliding that stops, shared masses, space, choice of
//! method. The bowed mass itself is B07, in `references.rs`.

use crate::methods::stable::{heat, made, only_falls, ran};
use crate::play::{TURN, audited, mat, off, rel_l2, scene, within};
use ca_core::{Level, tick};
use ca_tests::catalog;
use proptest::prelude::*;
use std::fmt::Write as _;

const CURVES: [&str; 4] = ["smooth", "piecewise", "coulomb", "table"];

/// Arguments of a curve of force `f` and speed `v0`. The table is uneven and steeper on one side.
fn curve(name: &str, f: f64, v0: f64) -> String {
    match name {
        "table" => {
            let points = [[-9.0, -0.2], [-1.0, -1.0], [0.0, 0.0], [2.0, 0.8], [3.0, 0.9], [20.0, 0.1]];
            let points = points.map(|[v, y]| format!("[{:?}, {:?}]", v * v0, y * f));
            format!("curve = \"table\", points = [{}]", points.join(", "))
        }
        "piecewise" => {
            format!("curve = \"piecewise\", f = {f:?}, v0 = {v0:?}, v1 = {:?}, fd = {:?}", 2.5 * v0, 0.3 * f)
        }
        _ => format!("curve = \"{name}\", f = {f:?}, v0 = {v0:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// Two masses on springs that rub, with slopes from near zero to 1e12 T/m, never gain energy.
    #[test]
    fn any_friction_only_takes(exponents in [-3.0..3.0f64, -6.0..0.0f64, -6.0..0.0f64, -3.0..12.0f64], kind in 0usize..4) {
        let [speed, one, two, steep] = exponents.map(|e| 10f64.powf(e));
        let mobility = (1.0 / one + 1.0 / two) / 48e3;
        for (f, v0) in [(1.0, mobility / steep), (speed / mobility, speed / steep)] {
            for method in ["secant", "newton"] {
                for more in ["", "also = { between = [\"high\", \"wall\"], curve = \"coulomb\", f = 1e-3, v0 = 1e-3, method = \"secant\" }\n"] {
                    let text = format!(
                        "[SOL]\nwall = {{}}\n[MAS]\nlow = {{ m = {one:?}, v = {speed:?} }}\nhigh = {{ m = {two:?}, v = {:?} }}\n[BOW]\n\
                         rub = {{ between = [\"low\", \"high\"], {}, method = \"{method}\" }}\n{more}[RES]\n\
                         a = {{ between = [\"wall\", \"low\"], k = {:?} }}\nb = {{ between = [\"high\", \"wall\"], k = {:?} }}\n[SOX]\nout = {{ from = \"low\" }}\n",
                        -0.3 * speed, curve(CURVES[kind], f, v0), 0.1 * one * 48e3 * 48e3, 0.02 * two * 48e3 * 48e3
                    );
                    let scene = audited(&text);
                    prop_assert_eq!(scene.certificate.level, Level::Proven);
                    // Newton's method gives way in some cases
                    prop_assert!(scene.findings.list.iter().all(|d| d.code == "N206"), "{}", scene.findings);
                    let s = only_falls(&scene, 400, 1e-12, &text, |_| {});
                    prop_assert!(made(&s) <= 1e-12, "made {:e}\n{text}", made(&s));
                    prop_assert!(heat(&scene, &s) > 0.0);
                }
            }
        }
    }
}

/// A block that slides on a table stops after v²m/2f and stays there.
#[test]
fn a_block_slides_and_stops() {
    let (m, f, v) = (1e-3, 0.02, 0.5);
    for v0 in [1e-3, 1e-6, 1e-12] {
        for method in ["secant", "newton"] {
            // the secant is half a tick late, and Newton's method gives way to it where the curve is steep
            let tolerance = if method == "newton" && v0 == 1e-3 { 1e-5 } else { 1e-3 };
            let scene = audited(&format!(
                "[SOL]\ntable = {{}}\n[MAS]\nblock = {{ m = {m:?}, v = {v:?} }}\n[BOW]\nrub = {{ between = [\"table\", \"block\"], curve = \"coulomb\", f = {f:?}, v0 = {v0:?}, method = \"{method}\" }}\n[SOX]\nout = {{ from = \"block\" }}\n"
            ));
            let mut s = scene.state();
            let i = mat(&scene, "block");
            (0..48_000).for_each(|_| tick(&scene, &mut s));
            let way = v * v * m / (2.0 * f);
            // below v0 it glides for another m v0²/2f
            within(
                &format!("way of the block, {method}, v0 = {v0}"),
                off(s.x[i], way),
                tolerance + 2.0 * (v0 / v).powi(2),
            );
            // the secant oscillates with decreasing amplitude
            let tremor = f * scene.rates.sample_dt / (4.0 * m * 46e3);
            within("at rest", (s.d[i] * scene.rate).abs(), tremor);
            within("all is heat", off(heat(&scene, &s), s.ledger.as_ref().expect("a ledger").h0), 1e-9);
        }
    }
    let ca = scene(&format!(
        "[SOL]\ntable = {{}}\n[MAS]\nblock = {{ m = {m:?}, v = {v:?} }}\n[BOW]\nrub = {{ between = [\"table\", \"block\"], curve = \"coulomb\", f = {f:?}, v0 = 1e-6 }}\n[SOX]\nout = {{ from = \"block\" }}\n"
    ));
    let mut s = ca.state();
    (0..48_000).for_each(|_| tick(&ca, &mut s));
    assert!((s.d[mat(&ca, "block")] * ca.rate).abs() > 1e-5);
}

/// Below the largest friction a push makes it creep at no more than v0·push/f.
#[test]
fn what_is_held_creeps() {
    for method in ["secant", "newton"] {
        let scene = scene(&format!(
            "[SOL]\ntable = {{}}\n[MAS]\nblock = {{ m = 0.001 }}\n[ENF]\npush = {{ to = \"block\" }}\n[BOW]\nrub = {{ between = [\"table\", \"block\"], curve = \"coulomb\", f = 0.02, v0 = 1e-6, method = \"{method}\" }}\n[SOX]\nout = {{ from = \"block\" }}\n"
        ));
        let mut s = scene.state();
        s.input[0] = 0.015;
        (0..48_000).for_each(|_| tick(&scene, &mut s));
        within(&format!("creep, {method}"), off(s.d[mat(&scene, "block")] * scene.rate, 0.75e-6), 1e-9);
    }
}

fn bowed(f: f64, method: &str) -> String {
    format!(
        "[CEL]\nbar = {{ m = 0.001, f = \"200 Hz\" }}\n[ENX]\nbow = {{}}\n[BOW]\nrub = {{ between = [\"bar\", \"bow\"], f = {f:?}, v0 = 0.01, method = \"{method}\" }}\n[SOX]\nout = {{ from = \"bar\" }}\n"
    )
}

fn played(text: &str, ticks: u32) -> Vec<f64> {
    let scene = scene(text);
    let mut s = scene.state();
    let bar = mat(&scene, "bar");
    (0..ticks)
        .map(|n| {
            s.input[0] = 0.02 * f64::from(n) / scene.rate;
            tick(&scene, &mut s);
            s.x[bar]
        })
        .collect()
}

/// Newton's method up to b = 4, where the root is certainly unique; the secant beyond.
#[test]
fn newton_gives_way_where_it_would_jump() {
    let force = |b: f64| b * 0.01 * 0.001 * 48e3 / 0.5f64.exp();
    assert_eq!(played(&bowed(force(4.001), "newton"), 2000), played(&bowed(force(4.001), "secant"), 2000));
    assert_ne!(played(&bowed(force(3.999), "newton"), 2000), played(&bowed(force(3.999), "secant"), 2000));
}

/// A single link gives the same alone and in the system: on a line, and along a direction of space.
#[test]
fn alone_and_together_are_the_same() {
    for name in CURVES {
        let text = |room: &str, at: &str, v: &str, along: &str| {
            format!(
                "[room]\ndim = {room}\n[room.MAS]\nlow = {{ m = 0.001, v = {v} }}\nbar = {{ m = 0.003, x = {at} }}\n[BOW]\nrub = {{ between = [\"room.low\", \"room.bar\"], {}, method = \"secant\"{along} }}\n",
                curve(name, 3.0, 0.02)
            )
        };
        let play = |text: &str, share: f64| {
            let scene = scene(text);
            let mut s = scene.state();
            let i = mat(&scene, "room.bar");
            let path: Vec<f64> = (0..500).map(|_| (tick(&scene, &mut s), s.x[i]).1 / share).collect();
            (path, ran(&scene)[0].to_string())
        };
        let (line, alone) = play(&text("1", "0", "0.7", ""), 1.0);
        let (space, shared) = play(&text("3", "[0, 0, 0]", "[0.42, 0.56, 0]", ", along = [0.6, 0.8, 0]"), 0.6);
        assert!(!alone.contains("shared") && shared.contains("shared"), "{alone}, {shared}");
        within(&format!("{name} along a direction is on a line"), rel_l2(&space, &line), 1e-12);
    }
}

/// A pile that is pulled apart: friction between neighbours, contacts at the ends, on a line and in space.
#[test]
fn shared_friction_only_takes() {
    for (dim, v0) in [(1, 1e-2), (1, 1e-6), (3, 1e-2), (3, 1e-6)] {
        let at = |x: f64, y: f64| if dim == 1 { format!("{x:?}") } else { format!("[{x:?}, {y:?}, {:?}]", -0.5 * x) };
        let mut text = format!("[room]\ndim = {dim}\n[room.SOL]\nwall = {{ x = {} }}\n[room.MAS]\n", at(-0.01, 0.0));
        for i in 0..5 {
            let (x, v) = (0.01 * f64::from(i), [-3.0, 1.0, 2.0, -1.0, 0.5][i as usize]);
            let _ = writeln!(text, "b{i} = {{ m = 0.00{}, x = {}, v = {} }}", i + 1, at(x, 0.0), at(v, 0.4 * v));
        }
        text += "[BUT]\nstop = { between = [\"room.wall\", \"room.b0\"], k = 1e9, d = 0.005, method = \"stable\" }\n[BOW]\n";
        for (i, method) in ["newton", "secant", "newton", "secant"].into_iter().enumerate() {
            let args = curve(CURVES[i], 0.5, v0);
            let _ = writeln!(
                text,
                "r{i} = {{ between = [\"room.b{i}\", \"room.b{}\"], {args}, method = \"{method}\" }}",
                i + 1
            );
        }
        let out = if dim == 1 { "" } else { ", along = \"x\"" };
        let scene = audited(&(text + &format!("[SOX]\nout = {{ from = \"room.b3\"{out} }}\n")));
        let names = ran(&scene);
        assert!(
            names.iter().filter(|n| n.starts_with("BOW") && n.ends_with("shared")).count() == 4
                && names.contains(&"BUT stable3d"),
            "{names:?}"
        );
        assert_eq!(names.iter().filter(|n| **n == "contacts").count(), 1);
        assert_eq!(scene.certificate.level, Level::Proven);
        let mut s = scene.state();
        let mut last = f64::INFINITY;
        for n in 0..20_000 {
            tick(&scene, &mut s);
            let ledger = s.ledger.as_ref().expect("a ledger");
            if n > 0 {
                assert!(ledger.h <= last + 1e-12 * ledger.extremes.peak, "{dim}, {v0}: {} after {last}", ledger.h);
            }
            last = ledger.h;
        }
        let ledger = s.ledger.as_ref().expect("a ledger");
        let b = ledger.balance();
        within(&format!("a pile in {dim}, v0 = {v0}: residual"), b.residual.abs() / b.peak, 5e-12);
        within("made", made(&s), 1e-13);
        assert!(heat(&scene, &s) > 0.3 * b.h0, "{b:?}");
    }
}

#[test]
fn a_table_that_drives_is_cut_to_what_resists() {
    let text = |method: &str| {
        format!(
            "[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 0.001, dx0 = 0.001 }}\n[RES]\nspring = {{ between = [\"wall\", \"bob\"], k = 1000 }}\n[BOW]\n\
             rub = {{ between = [\"wall\", \"bob\"], curve = \"table\", points = [[-1, 0.1], [-0.1, 0.2], [0, 0], [0.1, 0.2], [1, -0.1]], method = \"{method}\" }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
        )
    };
    assert!(scene(&text("ca")).findings.list.iter().any(|d| d.code == "W110"));
    for method in ["secant", "newton"] {
        let scene = audited(&text(method));
        assert!(scene.findings.list.is_empty(), "{}", scene.findings);
        let mut s = scene.state();
        let mut last = f64::INFINITY;
        for n in 0..5000 {
            tick(&scene, &mut s);
            let ledger = s.ledger.as_ref().expect("a ledger");
            if n > 0 {
                assert!(ledger.h <= last + 1e-13 * ledger.extremes.peak);
            }
            last = ledger.h;
        }
        assert!(heat(&scene, &s) > 0.0);
    }
}

#[test]
fn force_turned_while_it_rubs() {
    for method in ["secant", "newton"] {
        let text = bowed(0.5, method).replace("f = 0.5,", "f = \"press\",");
        let live = "[param]\npress = { value = 0.5, unit = \"N\", live = true, min = 0, max = 50 }\n";
        let scene = audited(&(live.to_string() + &text));
        let mut s = scene.state();
        let bar = mat(&scene, "bar");
        for (k, press) in [0.0, 50.0, 0.01, 5.0, 0.0].into_iter().enumerate() {
            assert!(s.apply(&scene.controls().set("press", press).expect("a number"), 100));
            for n in 0..2000 {
                s.input[0] = 0.02 * (2000 * k + n) as f64 / scene.rate;
                tick(&scene, &mut s);
            }
            if press == 50.0 {
                within("it goes with the bow", off(s.d[bar] * scene.rate, 0.02), 0.02);
            }
        }
        let b = s.ledger.as_ref().expect("a ledger").balance();
        within("residual", b.residual.abs() / b.peak, 1e-12);
        within("changed", b.changed.abs(), 0.0);
        // except for the tick in which the hand begins to move, which no link can predict
        within("made", made(&s), 1e-3);
    }
}

/// Motion that decays between two flushes of tiny numbers is solved together without NaN: its squares underflow to
/// zero, and the largest of them is a divisor.
#[test]
fn what_has_died_away_is_still_a_number() {
    for (m, n, f, g) in [(1.0, 1.0, 0.3, 0.2), (0.3, 0.7, 0.05, 0.05)] {
        let cell = |m: f64| format!("m = {m:?}, k = {:?}, z = {:?}", 0.25 * m, 0.75 * m);
        let scene = scene(&format!(
            "[rate]\nsound = 1\ngesture = 1\n[SOL]\nwall = {{}}\n[CEL]\na = {{ {} }}\nb = {{ {} }}\n[BOW]\n\
             one = {{ between = [\"b\", \"a\"], f = {f:?}, v0 = 1, method = \"secant\" }}\n\
             two = {{ between = [\"b\", \"wall\"], f = {g:?}, v0 = 1, method = \"secant\" }}\n[SOX]\n\
             out = {{ from = \"a\" }}\n",
            cell(m),
            cell(n)
        ));
        assert!(ran(&scene).contains(&"BOW smooth shared"), "{:?}", ran(&scene));
        let mut s = scene.state();
        tick(&scene, &mut s);
        (s.x[mat(&scene, "a")], s.x[mat(&scene, "b")]) = (1e-120, 0.7e-120);
        for _ in 0..1000 {
            tick(&scene, &mut s);
            assert!(s.x.iter().all(|x| x.abs() < 1e-119), "{:?}", s.x);
        }
    }
}

/// A block on a spring and a belt, against the closed form of the textbook. It sticks until the spring exceeds the
/// static force, x = f/k after f/(k v), then swings about fd/k until it has the speed of the belt again.
#[test]
fn a_block_on_a_belt_sticks_and_slips_as_by_hand() {
    let (k, m, v, f, fd): (f64, f64, f64, f64, f64) = (1000.0, 0.01, 0.1, 1.6, 0.8);
    let scene = audited(&format!(
        "[SOL]\nwall = {{}}\n[ENX]\nbelt = {{}}\n[MAS]\nblock = {{ m = {m} }}\n[RES]\nspring = {{ between = [\"wall\", \"block\"], k = {k} }}\n\
         [BOW]\nrub = {{ between = [\"block\", \"belt\"], curve = \"coulomb\", method = \"set-valued\", f = {f}, fd = {fd} }}\n[SOX]\nout = {{ from = \"block\" }}\n"
    ));
    assert_eq!(scene.certificate.level, Level::Proven);
    let mut s = scene.state();
    let (block, belt) = (mat(&scene, "block"), mat(&scene, "belt"));
    let (mut changes, mut stuck, mut far) = (Vec::new(), false, 0.0_f64);
    for n in 0..96_000u32 {
        s.input[0] = v * f64::from(n) / scene.rate;
        let before = s.x[block] - s.x[belt];
        tick(&scene, &mut s);
        let sticks = s.links.mem[0] != 0.0;
        if sticks && stuck {
            far = far.max((s.x[block] - s.x[belt] - before).abs());
        }
        if sticks != stuck {
            changes.push((n, sticks));
        }
        stuck = sticks;
    }
    within("what sticks moves with the belt, in a tick", far, 1e-15);
    // the swing about fd/k begins at (f − fd)/k from its middle, at the speed of the belt, and ends at that speed
    let (w, a) = ((k / m).sqrt(), (f - fd) / k);
    let slip = (TURN - 2.0 * (w * a / v).atan()) / w;
    let stick = 2.0 * a / v;
    let from = changes.iter().position(|c| c.1 && c.0 > 9600).expect("it sticks again");
    let turns = &changes[from..from + 2 * ((changes.len() - from - 1) / 2) + 1];
    let mean = |all: Vec<f64>| all.iter().sum::<f64>() / all.len() as f64 * scene.rates.sample_dt;
    let period = mean(turns.windows(3).step_by(2).map(|w| f64::from(w[2].0 - w[0].0)).collect());
    let sticks = mean(turns.windows(2).step_by(2).map(|w| f64::from(w[1].0 - w[0].0 - 1)).collect());
    assert!(turns.len() > 60);
    within("period of stick and slip", off(period, slip + stick), 1e-3);
    within("time of stick, in ticks", (sticks - stick).abs() / scene.rates.sample_dt, 1.01);
    within("16 ms and 28.3154 ms", off(stick, 16e-3).max(off(slip + stick, 28.3154e-3)), 1e-5);
    let s = s.ledger.expect("a ledger");
    within("energy", s.balance().residual.abs() / s.balance().peak, 1e-12);
}

/// A push below the static force causes no creep, and a sliding block stops for good at the right place.
#[test]
fn set_valued_friction_holds_and_stops_exactly() {
    let rub = |more: &str| {
        format!(
            "[SOL]\ntable = {{}}\n[MAS]\nblock = {{ m = 0.001{more} }}\n[ENF]\npush = {{ to = \"block\" }}\n[BOW]\nrub = {{ between = [\"table\", \"block\"], curve = \"coulomb\", method = \"set-valued\", f = 0.02, fd = 0.01 }}\n[SOX]\nout = {{ from = \"block\" }}\n"
        )
    };
    let scene = audited(&rub(""));
    let (mut s, block) = (scene.state(), mat(&scene, "block"));
    // starts below the sliding force, so the block sticks in either state
    s.input[0] = 0.0099;
    tick(&scene, &mut s);
    s.input[0] = 0.0199;
    (0..48_000).for_each(|_| tick(&scene, &mut s));
    within("held for a second", s.x[block].abs(), 1e-18);
    s.input[0] = 0.0201;
    (0..4_800).for_each(|_| tick(&scene, &mut s));
    within("it slides with what the sliding force leaves", off(s.d[block] * scene.rate, 0.0101 / 0.001 * 0.1), 1e-3);
    let scene = audited(&rub(", v = 0.5"));
    let mut s = scene.state();
    (0..48_000).for_each(|_| tick(&scene, &mut s));
    within("way of the block", off(s.x[block], 0.5 * 0.5 * 0.001 / (2.0 * 0.01)), 1e-3);
    assert_eq!(s.d[block], 0.0, "it stands");
    within("all is heat", off(heat(&scene, &s), s.ledger.as_ref().expect("a ledger").h0), 1e-9);
}

/// A block that sticks to a port moves with it, because such a port runs a tick late. No energy is made.
#[test]
fn what_sticks_to_a_port_goes_with_it() {
    let (a, w) = (0.01, 20.0 * TURN);
    let scene = audited(
        "[SOL]\nwall = {}\n[MAS]\nblock = { m = 0.01 }\n[ENX]\nbelt = {}\n[RES]\nspring = { between = [\"wall\", \"block\"], k = 1000 }\n\
         [BOW]\nrub = { between = [\"block\", \"belt\"], curve = \"coulomb\", method = \"set-valued\", f = 1e5 }\n[SOX]\nout = { from = \"block\" }\n",
    );
    let (mut s, block, belt) = (scene.state(), mat(&scene, "block"), mat(&scene, "belt"));
    let theta = w / scene.rate;
    let at = |n: u32| a * (theta * f64::from(n)).sin();
    let mut far = 0.0_f64;
    for n in 0..6 * (TURN / theta).round() as u32 {
        s.input[0] = at(n);
        tick(&scene, &mut s);
        if n > 2 {
            assert_eq!(s.x[belt], at(n - 1), "tick {n}");
            far = far.max((s.d[block] - (at(n) - at(n - 1))).abs());
        }
    }
    within("it goes as the belt goes", far, 1e-15);
    let ledger = s.ledger.as_ref().expect("a ledger");
    within("the ledger closes", ledger.balance().residual.abs() / ledger.balance().peak, 1e-12);
    within("made", made(&s), 1e-11);
}

/// Several links keep separate memories.
#[test]
fn the_heat_of_several_is_that_of_each() {
    let scene = audited(
        "[SOL]\ntable = {}\n[MAS]\na = { m = 0.01, v = 0.3 }\nb = { m = 0.01, v = 0.5 }\nc = { m = 0.02, v = -0.1 }\n[BOW]\n\
         rub = { between = [\"table\", [\"a\", \"b\", \"c\"]], curve = \"coulomb\", method = \"set-valued\", f = 0.03 }\n[SOX]\nout = { from = \"a\" }\n\
         other = { from = \"b\" }\nlast = { from = \"c\" }\n",
    );
    let mut s = scene.state();
    (0..24_000).for_each(|_| tick(&scene, &mut s));
    let ledger = s.ledger.as_ref().expect("a ledger");
    for (i, h0) in [0.5 * 0.01 * 0.09, 0.5 * 0.01 * 0.25, 0.5 * 0.02 * 0.01].into_iter().enumerate() {
        // the first tick takes some of the speed
        within(&format!("heat of link {i}"), off(ledger.lost[i], h0), 1e-3);
    }
    within("heat of all", off(heat(&scene, &s), ledger.h0), 1e-9);
    within("made", made(&s), 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// Two masses on springs, and a third link that shares one of them, never gain energy, alone or together.
    #[test]
    fn set_valued_friction_only_takes(exponents in [-3.0..3.0f64, -6.0..0.0f64, -6.0..0.0f64, -3.0..3.0f64], share in 0.0..1.0f64) {
        let [speed, one, two, strong] = exponents.map(|e| 10f64.powf(e));
        let f = strong * speed * one.min(two) * 48e3;
        for more in ["", "also = { between = [\"high\", \"wall\"], curve = \"coulomb\", method = \"set-valued\", f = 1e-3 }\n"] {
            let text = format!(
                "[SOL]\nwall = {{}}\n[MAS]\nlow = {{ m = {one:?}, v = {speed:?} }}\nhigh = {{ m = {two:?}, v = {:?} }}\n[BOW]\n\
                 rub = {{ between = [\"low\", \"high\"], curve = \"coulomb\", method = \"set-valued\", f = {f:?}, fd = {:?} }}\n{more}[RES]\n\
                 a = {{ between = [\"wall\", \"low\"], k = {:?} }}\nb = {{ between = [\"high\", \"wall\"], k = {:?} }}\n[SOX]\nout = {{ from = \"low\" }}\n",
                -0.3 * speed, share * f, 0.1 * one * 48e3 * 48e3, 0.02 * two * 48e3 * 48e3
            );
            let scene = audited(&text);
            let level = if more.is_empty() { Level::Proven } else { Level::RuleOfThumb };
            prop_assert_eq!(scene.certificate.level, level);
            let s = only_falls(&scene, 400, 1e-12, &text, |_| {});
            prop_assert!(made(&s) <= 1e-12, "made {:e}\n{text}", made(&s));
        }
    }
}

/// A block of 10 g on a table, with a force along it of 5 m/s² times its mass, and `more` arguments.
fn weighed(f: f64, more: &str) -> String {
    format!(
        "[h]\ngravity = 5.0\n[h.SOL]\ntable = {{}}\n[h.MAS]\nb = {{ m = 0.01{more} }}\n[BOW]\nr = {{ between = [\"h.b\", \"h.table\"], curve = \
         \"coulomb\", f = {f:?}, fd = 0.03, method = \"set-valued\" }}\n[SOX]\no = {{ from = \"h.b\" }}\n"
    )
}

/// The static force holds a block at rest at load; the sliding force acts on a moving block.
#[test]
fn what_rests_at_load_sticks() {
    let far = |text: &str| {
        let scene = scene(text);
        let mut s = scene.state();
        (0..48_000).for_each(|_| tick(&scene, &mut s));
        s.x[mat(&scene, "h.b")]
    };
    within("held", far(&weighed(0.0501, "")).abs(), 1e-15);
    // g − 0.03/m for a second, whether the static force is too small or the block moves
    within("let go", off(far(&weighed(0.0499, "")), -1.0), 1e-3);
    within("on its way", off(far(&weighed(0.06, ", v = -1e-6")), -1.0), 1e-3);
    let still = scene(&weighed(0.06, ""));
    assert_eq!(still.initial.links.mem[0], 1.0);
    within("its first tick", still.initial.d[mat(&still, "h.b")].abs(), 1e-18);
    // takes of older arithmetic start sliding
    let (model, _) = ca_model::read::read(&weighed(0.06, ""), "old.ca.toml", &catalog());
    let older = |arithmetic| {
        let options = ca_compile::Options { arithmetic, ..ca_compile::Options::default() };
        ca_compile::compile(&model, &catalog(), &options).expect("it compiles").initial.links.mem[0]
    };
    assert_eq!([Some(4), Some(5), None].map(older), [0.0, 1.0, 1.0]);
}

/// Stacked blocks creep instead of sticking: this is reported and not called proven; a single block is proven.
#[test]
fn stacked_blocks_creep_and_are_not_called_proven() {
    let text = "[SOL]\nt = {}\n[MAS]\na = { m = 0.02 }\nb = { m = 0.01 }\n[ENF]\np = { to = \"b\" }\n[BOW]\nr = { between = [\"a\", \"t\"], \
                curve = \"coulomb\", f = 1.0, method = \"set-valued\" }\ns = { between = [\"b\", \"a\"], curve = \"coulomb\", f = 0.6, method = \
                \"set-valued\" }\n[SOX]\no = { from = \"b\" }\n";
    let shared = scene(text);
    assert_eq!((shared.certificate.level, &shared.certificate.rules.decides[..]), (Level::RuleOfThumb, "r"));
    assert_eq!(shared.findings.list.iter().filter(|d| d.code == "W118").count(), 2, "{}", shared.findings);
    let mut s = shared.state();
    for _ in 0..48_000 {
        s.input[0] = 0.5;
        tick(&shared, &mut s);
    }
    let crept = s.x[mat(&shared, "b")];
    assert!(crept > 1e-5 && crept < 2e-4, "by no more than both creeps: {crept}");
    let alone = scene(
        &text
            .replace("s = { between = [\"b\", \"a\"], curve = \"coulomb\", f = 0.6, method = \"set-valued\" }\n", "")
            .replace("to = \"b\"", "to = \"a\""),
    );
    assert_eq!(alone.certificate.level, Level::Proven);
    assert!(alone.findings.list.iter().all(|d| d.code != "W118"), "{}", alone.findings);
}

/// N206 reports whenever Newton's method is not used, whatever the cause, and only then.
#[test]
fn newtons_method_that_gives_way_is_reported() {
    let notes = |text: &str| scene(text).findings.list.iter().filter(|d| d.code == "N206").count();
    let bow = |f: f64, method: &str| {
        format!(
            "[MAS]\na = {{ m = 1e-3 }}\nb = {{ m = 1e6, v = 0.1 }}\n[BOW]\nr = {{ between = [\"a\", \"b\"], f = {f:?}, v0 = 0.05, method = \
             \"{method}\" }}\n[SOX]\no = {{ from = \"a\" }}\n"
        )
    };
    let limit = 4.0 * 0.05 * 1e-3 * 48e3 / 0.5_f64.exp() / (1.0 + 1e-9);
    assert_eq!([0.999, 1.001].map(|share| notes(&bow(share * limit, "newton"))), [0, 1]);
    assert_eq!(notes(&bow(2.0 * limit, "secant")), 0);
    let shared = bow(0.1 * limit, "newton")
        .replace("[SOX]", "t = { between = [\"a\", \"b\"], f = 1, v0 = 1, method = \"secant\" }\n[SOX]");
    assert_eq!(notes(&shared), 1);
}
