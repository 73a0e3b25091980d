//! Every law acts along a direction in space as it does on a line. Along an axis of space the bits are the same too,
//! except those that depend on the square root.

use crate::play::{Random, mat, model, within};
use crate::random_parameters::{args, built, held, laws};
use ca_compile::Options;
use ca_core::{Kind, State, tick};
use ca_model::{Entry, Model, Value};

/// Two masses at a distance, on a line or along `n` in space, and one link, which acts along `along` if given.
fn pair(kind: &Kind, list: &[Entry], n: Option<[f64; 3]>, along: Option<[f64; 3]>) -> Model {
    let at = |v: f64| n.map_or(format!("{v}"), |n| format!("[{}, {}, {}]", v * n[0], v * n[1], v * n[2]));
    let (from, speed, back) = (at(3e-3), at(0.4), at(-0.3));
    let dim = if n.is_some() { "dim = 3" } else { "dim = 1" };
    let mut m = model(&format!(
        "[room]\n{dim}\n[room.MAS]\nlow = {{ m = 1, v = {back} }}\nhigh = {{ m = 2, x = {from}, v = {speed} }}\n"
    ));
    let mut list = list.to_vec();
    held(kind, &mut m, &mut list);
    list.push(Entry::new("between", Value::from(vec!["room.low", "room.high"])));
    list.extend(along.map(|n| Entry::new("along", Value::from(n.to_vec()))));
    m.add(kind.code, "link", list);
    m
}

/// Positions of both masses along `n` after each tick.
fn run(m: &Model, n: Option<[f64; 3]>, ticks: usize) -> Vec<[f64; 2]> {
    let scene = built(m, &Options::default());
    let mut s = scene.state();
    let places = ["room.low", "room.high"].map(|name| mat(&scene, name));
    let along = |s: &State, i: usize| match n {
        None => s.x[places[i]],
        Some(n) => (0..3).map(|k| n[k] * s.x[places[i] + k]).sum(),
    };
    let mut all = Vec::new();
    for _ in 0..ticks {
        tick(&scene, &mut s);
        all.push([along(&s, 0), along(&s, 1)]);
    }
    all
}

fn worst(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let size = a.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
    let apart = a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    apart / size
}

const AXES: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.36, 0.48, 0.8]];

#[test]
fn along_a_direction_every_law_is_that_of_the_line() {
    for (kind, _) in laws() {
        for seed in 1..8 {
            let list = args(kind, &mut Random(seed * 7919));
            let line = run(&pair(kind, &list, None, None), None, 600);
            assert!(line.iter().flatten().all(|x| x.is_finite()), "{}", kind.code);
            // a distance has no sign: compared only while the second point stays above the first
            let crossed = line.iter().position(|[a, b]| b - a + 3e-3 <= 1e-4).unwrap_or(line.len());
            for n in AXES {
                // the ports of a quadripole define their own directions
                if kind.param("along").is_some() {
                    let with = run(&pair(kind, &list, Some(n), Some(n)), Some(n), 600);
                    within(&format!("{} along {n:?}", kind.code), worst(&line, &with), 1e-12);
                }
                let free = run(&pair(kind, &list, Some(n), None), Some(n), crossed);
                within(&format!("{} between points on {n:?}", kind.code), worst(&line[..crossed], &free), 1e-12);
            }
        }
    }
}

#[test]
fn a_link_without_length_is_three_links() {
    let text = |links: &str| {
        format!(
            "[room]\ndim = 3\n[room.SOL]\nnail = {{}}\n[room.MAS]\nbob = {{ m = \"1 g\", x = [0.1, 0.2, -0.3], \
             dx0 = [0.01, 0, 0.02], v = [0, 1, 2] }}\n{links}\n[SOX]\nout = {{ from = \"room.bob\", along = \"x\" }}\n"
        )
    };
    let one = "[REF]\nall = { between = [\"room.nail\", \"room.bob\"], k = 50, z = 0.01, l0 = 0 }";
    let link = |k: &str| {
        format!("{k} = {{ between = [\"room.nail\", \"room.bob\"], along = \"{k}\", k = 50, z = 0.01, l0 = 0 }}\n")
    };
    let three = format!("[REF]\n{}{}{}", link("x"), link("y"), link("z"));
    let play = |links: &str| {
        let scene = built(&model(&text(links)), &Options::default());
        let mut s = scene.state();
        (0..2000).for_each(|_| tick(&scene, &mut s));
        s.bits()
    };
    assert_eq!(play(one), play(&three));
}

#[test]
fn a_plane_is_space_with_a_frozen_axis() {
    let text = |dim: u8, v: &dyn Fn(&str, &str) -> String| {
        let (zero, at, speed) = (v("0", "0"), v("0.03", "0.04"), v("0.5", "-0.2"));
        let gravity = if dim == 2 { "[0, -9.81]" } else { "[0, -9.81, 0]" };
        format!(
            "[room]\ndim = {dim}\ngravity = {gravity}\nfriction = 1e-3\n[room.SOL]\nnail = {{ x = {zero} }}\n\
             [room.MAS]\nbob = {{ m = \"2 g\", x = {at}, v = {speed} }}\n[REF]\narm = {{ between = [\"room.nail\", \
             \"room.bob\"], k = 300, z = 0.02 }}\n[SOX]\nout = {{ from = \"room.bob\", along = \"y\" }}\n"
        )
    };
    let play = |text: &str| {
        let scene = built(&model(text), &Options::default());
        let mut s = scene.state();
        (0..5000).for_each(|_| tick(&scene, &mut s));
        let bob = 3;
        assert_eq!((s.x[bob + 2], s.d[bob + 2]), (0.0, 0.0));
        [s.x[bob].to_bits(), s.x[bob + 1].to_bits()]
    };
    let flat = play(&text(2, &|a, b| format!("[{a}, {b}]")));
    assert_eq!(flat, play(&text(3, &|a, b| format!("[{a}, {b}, 0]"))));
}

#[test]
fn the_ledger_balances_in_space() {
    for (kind, _) in laws() {
        for seed in 1..4 {
            let list = args(kind, &mut Random(seed * 31));
            let m = pair(kind, &list, Some(AXES[3]), None);
            let scene = built(&m, &Options { energy: true, ..Options::default() });
            let mut s = scene.state();
            // the second mass also moves sideways, so that the link rotates
            s.d[mat(&scene, "room.high") + 2] += 1e-5;
            (0..3000).for_each(|_| tick(&scene, &mut s));
            let ledger = s.ledger.as_ref().expect("asked for");
            let b = ledger.balance();
            within(&format!("{}: ledgers in space", kind.code), b.residual.abs() / b.peak, 1e-12);
        }
    }
}
