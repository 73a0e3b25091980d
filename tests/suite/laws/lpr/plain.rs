//! Quadripoles: the plain link with one port held, choice of law, worlds of any kind, zero length, outputs.

use super::FS;
use crate::play::{Random, apart, mat, model, scene, with, within};
use ca_compile::Options;
use ca_conformance::random_parameters::{args, built, laws};
use ca_core::{compute_forces, integrate, tick};
use ca_model::{Entry, Model, Value};
use std::fmt::Write as _;

/// Two masses joined by a link, or by an LPR of the same law with one port held, on a line or in space.
fn plain_and_quadripole(code: &str, list: &[Entry], space: bool, onto: bool) -> Model {
    let at = |x: f64| if space { Value::from(vec![0.6 * x, 0.8 * x, 0.0]) } else { Value::from(x) };
    let mut m = model(if space { "[room]\ndim = 3\n[room.SOL]\nnorth = {}\nsouth = {}\n" } else { "" });
    let group = space.then_some(0);
    let name = |n: &str| if space { format!("room.{n}") } else { n.to_string() };
    for (mass, x, v) in [("low", 0.0, 0.02), ("high", 1e-3, -0.05)] {
        m.add("MAS", &name(mass), [Entry::new("m", 0.1), Entry::new("x", at(x)), Entry::new("v", at(v))]);
        m.items.last_mut().expect("an item").group = group;
    }
    let ends = Value::from(vec![name("low"), name("high")]);
    let mut own = list.to_vec();
    if code.starts_with("LPR") {
        m.add("SOL", "top", []).add("SOL", "bottom", []);
        let held = Value::from(vec!["top".to_string(), "bottom".to_string()]);
        let (first, second) = if onto { (held, ends) } else { (ends, held) };
        own.extend([Entry::new("between", first), Entry::new("onto", second)]);
    } else {
        own.push(Entry::new("between", ends));
    }
    m.add(code, "link", own);
    let out = if space { vec![Entry::new("along", "x")] } else { vec![] };
    m.add("SOX", "out", out.into_iter().chain([Entry::new("from", name("low")), Entry::new("dc", 0.0)]));
    m
}

#[test]
fn with_a_port_held_it_is_the_plain_link() {
    let mut compared = 0;
    // the laws of the core, which all have an LPR
    let core = ca_model::catalog();
    for (plain, _) in laws().iter().filter(|(k, _)| core.get(k.code).is_some()) {
        let code = if plain.code == "REF" { "LPR".to_string() } else { format!("LPR_{}", plain.code) };
        assert!(
            ca_tests::catalog().get(&code).is_some(),
            "{} has no {code}: add its line to `quadripoles!` of crates/ca-lpr/src/kinds.rs",
            plain.code
        );
        for seed in 1..9 {
            let mut list = args(plain, &mut Random(seed * 7919));
            list.retain(|e| e.key != "l0");
            for (space, onto) in [(false, false), (false, true), (true, false), (true, true)] {
                // a contact measures from position at its first port; the second is slack at rest
                if onto && plain.param("l0").is_none() {
                    continue;
                }
                let play = |code: &str| {
                    let scene = built(
                        &plain_and_quadripole(code, &list, space, onto),
                        &Options { energy: true, ..Options::default() },
                    );
                    let mut s = scene.state();
                    (0..4000).for_each(|_| tick(&scene, &mut s));
                    let b = s.ledger.as_ref().expect("a ledger").balance();
                    assert!(b.residual.abs() <= 1e-12 * b.peak, "{code}: {b:?}");
                    let [low, high] =
                        ["low", "high"].map(|n| mat(&scene, &format!("{}{n}", if space { "room." } else { "" })));
                    let n = if space { 3 } else { 1 };
                    (0..n).flat_map(|k| [s.x[low + k], s.x[high + k]]).collect::<Vec<_>>()
                };
                let (want, is) = (play(plain.code), play(&code));
                within(&format!("{code}, space {space}, onto {onto}"), apart(&want, &is), 1e-12);
                compared += 1;
            }
        }
    }
    assert!(compared > 200, "{compared}");
}

/// Without viscosity the compiler uses the law of the spring, with the kernel of a quadripole; the result is the same.
#[test]
fn cheaper_laws_are_quadripoles_too() {
    let edge = |kind: &str, args: &str| {
        format!(
            "[air]\ndim = 3\n[air.SOL]\nnail = {{}}\n[air.MAS]\nball = {{ m = 0.01, x = [0.1, 0, 0], v = [0.1, 0, 0] }}\n\
             [SOL]\nwall = {{}}\n[CEL]\nbar = {{ m = 0.01, k = 5e4 }}\n[{kind}]\nedge = {{ between = [\"air.nail\", \
             \"air.ball\"], onto = [\"wall\", \"bar\"], {args} }}\n[SOX]\nout = {{ from = \"bar\" }}\n"
        )
    };
    for (general, plain, law) in [
        (edge("LPR", "k = 1e4"), edge("LPR_RES", "k = 1e4"), "LPR_RES"),
        (edge("LPR", "z = 2"), edge("LPR_FRO", "z = 2"), "LPR_FRO"),
        (
            edge("LPR_BOW", "curve = \"table\", points = [[-1, -3], [1, 3]]"),
            edge("LPR_LNL", "friction = [[-1, -3], [1, 3]]"),
            "LPR_BOW table",
        ),
    ] {
        let play = |text: &str| {
            let scene = scene(text);
            let mut s = scene.state();
            (0..2000).for_each(|_| tick(&scene, &mut s));
            (scene.passes.forces.iter().find(|o| o.law.is_some()).expect("a link").name(), s.output[0])
        };
        let (name, heard) = play(&general);
        assert_eq!((name, heard.to_bits()), (law, play(&plain).1.to_bits()));
        assert!(heard.abs() > 1e-9, "{heard}");
    }
}

/// Space to space and line to line: the energy that one world loses is gained by the other.
#[test]
fn between_worlds_of_one_kind_the_ledger_balances() {
    let text = |dim: u8| {
        let at = |x: f64| if dim == 3 { format!("[{}, {}, 0]", 0.6 * x, 0.8 * x) } else { format!("{x}") };
        let mut t = format!("[a]\ndim = {dim}\n[b]\ndim = {dim}\n");
        for (world, v) in [('a', 0.1), ('b', 0.0)] {
            let _ = write!(
                t,
                "[{world}.SOL]\nnail = {{}}\n[{world}.MAS]\nball = {{ m = 0.01, x = {}, v = {} }}\n",
                at(0.1),
                at(v)
            );
        }
        let along = if dim == 3 { ", along = \"x\"" } else { "" };
        t + "[RES]\nown = { between = [\"b.nail\", \"b.ball\"], k = 2e4 }\n[LPR]\nedge = { between = [\"a.nail\", \
             \"a.ball\"], onto = [\"b.nail\", \"b.ball\"], k = 1e4, z = 0.1 }\n[SOX]\nout = { from = \"b.ball\""
            + along
            + " }\n"
    };
    for dim in [1, 3] {
        let scene = with(&text(dim), &Options { energy: true, ..Options::default() });
        assert!(scene.findings.list.is_empty(), "{}", scene.findings);
        let mut s = scene.state();
        let (at, mut most) = (mat(&scene, "b.ball"), 0.0f64);
        for _ in 0..48_000 {
            tick(&scene, &mut s);
            let speed = if dim == 3 { s.d[at].hypot(s.d[at + 1]) } else { s.d[at] };
            most = most.max(0.5 * 0.01 * (speed * FS).powi(2));
        }
        let b = s.ledger.as_ref().expect("a ledger").balance();
        within(&format!("closure, {dim} axes"), b.residual.abs() / b.peak, 1e-12);
        assert!(most > 0.1 * b.h0, "little of {} J arrived: {most}", b.h0);
        assert!(b.scheme_error.abs() <= 1e-6 * b.h0 && b.lost > 0.1 * b.h0, "{b:?}");
    }
}

#[test]
fn at_zero_length_nothing_pulls_in_space() {
    let scene = scene(
        "[air]\ndim = 3\n[air.SOL]\nnail = {}\n[air.MAS]\nball = { m = 0.01 }\n[SOL]\nwall = {}\n[CEL]\nbar = { m = 0.01, \
         k = 5e4 }\n[LPR]\nedge = { between = [\"air.nail\", \"air.ball\"], onto = [\"wall\", \"bar\"], k = 1e4, z = 1, \
         l0 = 0.01 }\n[SOX]\nout = { from = \"bar\" }\n",
    );
    let mut s = scene.state();
    let (ball, bar) = (mat(&scene, "air.ball"), mat(&scene, "bar"));
    let mut bar_moved = 0.0f64;
    for _ in 0..2000 {
        compute_forces(&scene, &mut s);
        assert_eq!(s.f[ball..][..3], [0.0; 3]);
        integrate(&scene, &mut s);
        bar_moved = bar_moved.max(s.x[bar]);
    }
    // the law keeps running, and the other port still gets its force
    assert!(bar_moved > 1e-4 && s.x.iter().all(|x| x.is_finite()), "{bar_moved}");
}

/// Outputs fed by an LPR have a high-pass filter, others do not.
#[test]
fn outputs_that_a_body_in_space_feeds_lose_what_is_steady() {
    let body = "[air]\ndim = 3\n[air.SOL]\nnail = {}\n[air.MAS]\nball = { m = 0.01, x = [0.1, 0, 0] }\n[SOL]\nwall = {}\n\
                [MAS]\nfar = { m = 0.01 }\n[CEL]\nbar = { m = 0.01, k = 5e4 }\nlone = { m = 0.01, k = 5e4 }\n[RES]\n\
                string = { between = [\"bar\", \"far\"], k = 1e4 }\nside = { between = [\"wall\", \"lone\"], k = 1e4 }\n\
                [LPR]\nedge = { between = [\"air.nail\", \"air.ball\"], onto = [\"wall\", \"bar\"], k = 1e4 }\n";
    let high_passes = |outs: &str| {
        scene(&format!("{body}[SOX]\nfly = {{ from = \"air.ball\", along = \"x\", dc = 0 }}\n{outs}"))
            .out
            .blockers
            .len()
    };
    for (out, many) in [
        ("out = { from = \"bar\" }", 1),
        ("out = { from = \"far\" }", 1),
        ("out = { from = \"far\", dc = 0 }", 0),
        ("out = { from = \"lone\" }", 0),
        ("out = { from = \"air.ball\", along = \"y\" }", 0),
        (
            "out = { from = \"bar\" }\n[SOF]\nedge_force = { from = \"edge\" }\nother = { from = \"side\" }\nlone_force = { from = \"lone\" }",
            2,
        ),
    ] {
        assert_eq!(high_passes(out), many, "{out}");
    }
    // with both ends of an LPR on lines nothing rotates
    let flat = "[CEL]\na = { m = 0.01, k = 5e4 }\nb = { m = 0.01, k = 5e4 }\n[SOL]\nwall = {}\n[LPR]\nl = { between = \
                [\"wall\", \"a\"], onto = [\"wall\", \"b\"], k = 1e4 }\n[SOX]\nout = { from = \"b\" }\n";
    assert!(scene(flat).out.blockers.is_empty());
}
