//! All pairs of two sets as one module: the same bits as the pairs written out, by every method of finding touching
//! pairs, and the properties of any contact: momentum, energy, findings at load.

use crate::play::{Random, audited, mat, model, reference, scene, with, within};
use ca_compile::{Options, compile};
use ca_core::{Scene, State, tick};
use std::fmt::Write as _;

const D: f64 = 5e-3;

/// `n` grains of 0.2 g and diameter `d`, drawn within `radius` of the origin, at speeds up to `v` along each axis.
fn grains(n: usize, radius: f64, v: f64, rng: &mut Random) -> String {
    let mut t = String::from("[room]\ndim = 3\n[room.SOL]\nmiddle = {}\n[room.MAS]\n");
    let mut at: Vec<[f64; 3]> = Vec::new();
    while at.len() < n {
        let p = [rng.uniform(), rng.uniform(), rng.uniform()].map(|c| c * radius);
        let apart = |q: &[f64; 3]| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>() > D * D;
        if p.iter().map(|c| c * c).sum::<f64>() < radius * radius && at.iter().all(apart) {
            let v = [rng.uniform() * v, rng.uniform() * v, rng.uniform() * v];
            writeln!(t, "g{} = {{ m = \"0.2 g\", x = {p:?}, v = {v:?} }}", at.len()).expect("text");
            at.push(p);
        }
    }
    t
}

fn names(from: usize, to: usize) -> String {
    let all: Vec<String> = (from..to).map(|i| format!("\"room.g{i}\"")).collect();
    format!("[{}]", all.join(", "))
}

fn with_output(text: &str) -> String {
    format!("{text}\n[SOX]\nout = {{ from = \"room.g0\", along = \"x\" }}\n")
}

/// Forty grains in a shell; all pairs may touch.
fn shaken(contact: &str) -> String {
    let (all, body) = (names(0, 40), grains(40, 0.012, 1.0, &mut Random(7)));
    let shell =
        format!("[BUT]\nshell = {{ between = [\"room.middle\", {all}], k = 2000, d = 0.012, sense = \"inside\" }}");
    with_output(&format!("{body}{shell}\n{contact}"))
}

fn hits() -> String {
    let all = names(0, 40);
    format!("hits = {{ between = [{all}, {all}], k = 5000, z = 0.02, d = {D} }}")
}

fn bits(scene: &Scene, s: &State) -> Vec<u64> {
    let grains: Vec<usize> = (0..40).map(|i| mat(scene, &format!("room.g{i}"))).collect();
    grains.iter().flat_map(|m| s.x[*m..][..3].iter().chain(&s.d[*m..][..3])).map(|v| v.to_bits()).collect()
}

/// Disturbs some grains: a jump of a metre and back, and speeds from a crawl to many diameters a tick.
fn shake(scene: &Scene, s: &mut State, n: u64, rng: &mut Random) {
    let who = mat(scene, &format!("room.g{}", (rng.0 % 40)));
    match n % 4000 {
        500 => s.d[who] = 0.2 * rng.uniform() * D,
        1500 => s.x[who + 1] += 1.0,
        1502 => s.x.iter_mut().for_each(|x| *x = x.clamp(-0.02, 0.02)),
        2500 => s.d[who + 2] = 30.0 * rng.uniform() * D,
        2600 | 3900 => s.d.iter_mut().for_each(|d| *d *= 0.01),
        _ => {}
    }
    rng.uniform();
}

#[test]
fn every_bit_is_that_of_the_pairs() {
    let (all, a, b) = (names(0, 40), names(0, 15), names(15, 40));
    let contacts = [
        hits(),
        format!("two = {{ between = [{a}, {b}], pairs = \"all\", k = 5000, d = {D}, sticky = false }}"),
        format!("[HRZ]\nhertz = {{ between = [{all}, {all}], k = 3e5, h = 0.2, d = {D} }}"),
        format!("bag = {{ between = [{a}, {b}], pairs = \"all\", k = 300, d = 0.015, sense = \"inside\" }}"),
    ];
    for (which, contact) in contacts.iter().enumerate() {
        let text = shaken(contact);
        let mut scenes = Vec::from([with(&text, &reference())]);
        scenes.extend((0..3).map(|_| scene(&text)));
        scenes.push(audited(&text));
        assert!(scenes[0].links.pair_sets.is_empty() && scenes[1].links.pair_sets.len() == 1, "{contact}");
        let skins = [0.0, 0.0, 0.25, 1.0, 0.25];
        let mut states = scenes.iter().map(|s| s.state()).collect::<Vec<_>>();
        for (s, skin) in states.iter_mut().zip(skins) {
            s.links.near.iter_mut().for_each(|n| n.skin = skin);
        }
        let mut touched = 0;
        for n in 0..16_000 {
            for (scene, s) in scenes.iter().zip(&mut states) {
                shake(scene, s, n, &mut Random(n * 977 + 5));
                tick(scene, s);
            }
            if n % 50 == 0 {
                let plain = bits(&scenes[0], &states[0]);
                for (k, (scene, s)) in scenes.iter().zip(&states).enumerate().skip(1) {
                    assert_eq!(bits(scene, s), plain, "{contact}: tick {n}, way {k}");
                }
            }
            touched += u32::from(states[0].f.iter().all(|f| f.is_finite()));
        }
        assert_eq!(touched, 16_000);
        let lists = states.iter().map(|s| s.links.near.first().map_or(0, |n| n.lists)).collect::<Vec<_>>();
        // a contact from inside does not use a list
        let expected = if which == 3 { lists == [0; 5] } else { lists[1] == 0 && lists[2..].iter().all(|n| *n > 10) };
        assert!(expected, "{contact}: {lists:?}");
    }
}

#[test]
fn pairs_written_one_by_one_are_the_same() {
    let mut each = String::new();
    for i in 0..40 {
        for j in i + 1..40 {
            writeln!(each, "h{i}_{j} = {{ between = [\"room.g{i}\", \"room.g{j}\"], k = 5000, z = 0.02, d = {D} }}")
                .expect("text");
        }
    }
    let (one, all) = (scene(&shaken(&hits())), scene(&shaken(&each)));
    assert_eq!((one.counts.n_lia, all.counts.n_lia), (41, 40 + 780));
    let (mut s, mut t) = (one.state(), all.state());
    for _ in 0..3000 {
        tick(&one, &mut s);
        tick(&all, &mut t);
    }
    assert_eq!(bits(&one, &s), bits(&all, &t));
    assert!(s.links.near[0].lists > 0);
}

#[test]
fn a_list_that_does_not_fit_loses_nothing() {
    // all grains in a heap much smaller than one grain: every pair touches
    let text = shaken(&hits().replace(&format!("d = {D}"), "d = 0.05"));
    let (plain, set) = (with(&text, &reference()), scene(&text));
    let (mut s, mut t) = (plain.state(), set.state());
    for n in 0..2000 {
        tick(&plain, &mut s);
        tick(&set, &mut t);
        assert_eq!(bits(&plain, &s), bits(&set, &t), "tick {n}");
    }
}

#[test]
fn positions_that_are_huge_or_no_numbers_stop_nothing() {
    let text = shaken(&hits());
    let (plain, set) = (with(&text, &reference()), scene(&text));
    for bad in [1e9, 1e17, 1e160, 1e308, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        let (mut s, mut t) = (plain.state(), set.state());
        for n in 0..300 {
            for (scene, s) in [(&plain, &mut s), (&set, &mut t)] {
                if n == 100 {
                    s.x[mat(scene, "room.g7")] = bad;
                    s.x[mat(scene, "room.g9")] = bad;
                }
                if n == 200 {
                    s.d[mat(scene, "room.g3") + 1] = bad;
                }
                tick(scene, s);
            }
        }
        let clean =
            |b: Vec<u64>| b.into_iter().map(|b| if f64::from_bits(b).is_nan() { 0 } else { b }).collect::<Vec<_>>();
        assert_eq!(clean(bits(&plain, &s)), clean(bits(&set, &t)), "{bad}");
    }
}

#[test]
fn a_state_taken_back_goes_on_as_it_did() {
    let scene = scene(&shaken(&hits()));
    let mut s = scene.state();
    (0..1000).for_each(|_| tick(&scene, &mut s));
    let kept = s.clone();
    (0..1500).for_each(|_| tick(&scene, &mut s));
    let once = bits(&scene, &s);
    s.x.iter_mut().enumerate().for_each(|(i, x)| *x += 0.01 * (i % 7) as f64);
    (0..500).for_each(|_| tick(&scene, &mut s));
    // restores all but the neighbour list, then everything
    let near = s.links.near.clone();
    s = kept.clone();
    s.links.near = near;
    (0..1500).for_each(|_| tick(&scene, &mut s));
    assert_eq!(bits(&scene, &s), once);
    s = kept;
    (0..1500).for_each(|_| tick(&scene, &mut s));
    assert_eq!(bits(&scene, &s), once);
}

#[test]
fn a_distance_that_moves_keeps_every_pair() {
    let text = format!(
        "[param]\nd = {{ value = {D}, live = true, min = 0, max = 0.02 }}\n{}",
        shaken(&hits().replace(&format!("d = {D}"), "d = \"d\""))
    );
    let scenes = [with(&text, &reference()), scene(&text)];
    let mut states = scenes.iter().map(|s| s.state()).collect::<Vec<_>>();
    for n in 0..6000 {
        for (scene, s) in scenes.iter().zip(&mut states) {
            let to = match n {
                1000 => 0.008,
                2000 => 0.0,
                3000 => 0.006,
                4000 => 0.001,
                5000 => 0.004,
                _ => f64::NAN,
            };
            if let Ok(patch) = scene.controls().set("d", to) {
                assert!(s.apply(&patch, 300));
            }
            tick(scene, s);
        }
        assert_eq!(bits(&scenes[0], &states[0]), bits(&scenes[1], &states[1]), "tick {n}");
    }
}

#[test]
fn momentum_is_kept() {
    let all = names(0, 60);
    let body = grains(60, 0.013, 1.0, &mut Random(11));
    let scene =
        scene(&with_output(&format!("{body}[BUT]\nhits = {{ between = [{all}, {all}], k = 5000, d = 0.006 }}")));
    let mut s = scene.state();
    let sum = |s: &State, k: usize| s.d.chunks(3).map(|d| d[k]).sum::<f64>();
    let size = s.d.iter().map(|d| d.abs()).sum::<f64>();
    let before = [0, 1, 2].map(|k| sum(&s, k));
    let first = s.d.clone();
    (0..5000).for_each(|_| tick(&scene, &mut s));
    assert!(s.d.iter().zip(&first).filter(|(a, b)| a != b).count() > 60, "they have met");
    for (k, before) in before.iter().enumerate() {
        within("momentum", (sum(&s, k) - before).abs() / size, 1e-13);
    }
}

#[test]
fn the_energy_ledger_balances_and_agrees_with_that_of_the_pairs() {
    let all = names(0, 40);
    let hertz = format!("[HRZ]\nhits = {{ between = [{all}, {all}], k = 3e5, h = 0.1, d = {D} }}");
    for contact in [hits(), hertz] {
        let text = shaken(&contact);
        let (set, pairs) = (audited(&text), with(&text, &Options { energy: true, ..reference() }));
        let (mut s, mut t) = (set.state(), pairs.state());
        for _ in 0..4000 {
            tick(&set, &mut s);
            tick(&pairs, &mut t);
        }
        let balance = |s: &State| s.ledger.as_ref().expect("a ledger").balance();
        let (one, all) = (balance(&s), balance(&t));
        within("residual", one.residual.abs() / one.peak, 1e-12);
        assert!(all.lost > 0.0 && all.scheme_error != 0.0);
        for (what, a, b) in
            [("held", one.h, all.h), ("lost", one.lost, all.lost), ("made", one.scheme_error, all.scheme_error)]
        {
            within(what, (a - b).abs() / one.peak, 1e-12);
        }
        let hits = (0..set.counts.n_lia).filter(|k| set.audited_name(*k).as_deref() == Some("hits")).count();
        assert_eq!(hits, 1, "the set is one entry");
    }
}

#[test]
fn a_pair_that_is_heard_makes_the_pairs() {
    let one = scene(&shaken(&hits()));
    assert_eq!((one.counts.n_lia, one.links.pair_sets[0].pairs()), (41, 780));
    let sof = "\n[SOF]\nblow = { from = \"hits[3]\" }\n";
    assert_eq!(scene(&(shaken(&hits()) + sof)).counts.n_lia, 40 + 780);
    let probed = Options { probes: vec!["hits[5]".into()], ..Options::default() };
    assert_eq!(with(&shaken(&hits()), &probed).counts.n_lia, 40 + 780);
    // on a line a contact has sides, so its pairs stay separate links
    let line = "[MAS]\na = { m = 1 }\nb = { m = 1, x = 1 }\nc = { m = 1, x = 2 }\nd = { m = 1, x = 3 }\n[BUT]\n\
         hits = { between = [[\"a\", \"b\", \"c\", \"d\"], [\"a\", \"b\", \"c\", \"d\"]], k = 1 }\n[SOX]\nout = { from = \"a\" }\n";
    assert_eq!(scene(line).counts.n_lia, 6);
    // so does a method with memory for each pair
    let stable = hits().replace("k = 5000", "k = 5000, method = \"stable\"");
    assert_eq!(scene(&shaken(&stable)).counts.n_lia, 40 + 780);
    // one against many is not worth a set
    let one = format!("rim = {{ between = [\"room.middle\", {}], pairs = \"all\", k = 1, d = {D} }}", names(0, 40));
    assert!(scene(&shaken(&one)).links.pair_sets.is_empty());
}

#[test]
fn the_rule_for_contacts_takes_the_lightest_pair() {
    let body = "[room]\ndim = 3\n[room.MAS]\ng0 = { m = \"5 g\" }\ng1 = { m = \"1 g\", x = [1,0,0] }\n\
         g2 = { m = \"2 g\", x = [2,0,0] }\ng3 = { m = \"3 g\", x = [3,0,0] }\ng4 = { m = \"4 g\", x = [4,0,0] }\n\
         g5 = { m = \"9 g\", x = [5,0,0] }\n[BUT]\n";
    let (all, a, b) = (names(0, 6), names(0, 3), names(3, 6));
    for (between, c) in
        [(format!("[{all}, {all}]"), 1.0 + 0.5), (format!("[{a}, {b}], pairs = \"all\""), 1.0 + 1.0 / 3.0)]
    {
        let text = with_output(&format!("{body}hits = {{ between = {between}, k = 4e5, d = 1e-3 }}"));
        let (set, pairs) = (scene(&text), with(&text, &reference()));
        assert_eq!(set.links.pair_sets.len(), 1);
        within("kT²/m", (set.certificate.rules.contact / (4e5 * c / 1e-3 / 48e3 / 48e3) - 1.0).abs(), 1e-14);
        assert!((set.certificate.rules.contact - pairs.certificate.rules.contact).abs() < 1e-12);
        assert_eq!(set.certificate.level, pairs.certificate.level);
    }
}

#[test]
fn ten_thousand_grains_are_one_module() {
    let text = |gap: &str| {
        format!(
            "[room]\ndim = 3\n[room.GRAINS]\ng = {{ n = 10000, m = \"0.1 g\", gap = \"{gap}\" }}\n[BUT]\n\
             hits = {{ between = [\"room.g[*]\", \"room.g[*]\"], k = 100, d = \"5 mm\" }}\n\
             [SOX]\nout = {{ from = \"room.g[0]\", along = \"x\" }}\n"
        )
    };
    let apart = scene(&text("6 mm"));
    assert_eq!((apart.counts.n_lia, apart.links.pair_sets[0].pairs()), (1, 49_995_000));
    assert!(apart.findings.list.is_empty(), "{}", apart.findings);
    let pressed = scene(&text("4 mm"));
    assert_eq!(pressed.findings.list.len(), 1);
    let said = &pressed.findings.list[0];
    assert!(
        said.code == "W102" && said.title.contains("`hits` already presses at load, with a force of 0.1 N"),
        "{}",
        pressed.findings
    );
    // the pairs themselves would be too many
    let refused = compile(&model(&text("6 mm")), &ca_model::catalog(), &reference()).expect_err("too many");
    assert!(refused.list.iter().any(|d| d.code == "E027"), "{refused}");
}
