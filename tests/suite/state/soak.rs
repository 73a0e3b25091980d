//! Long plays of small drawn models on a line: proven scenes never make energy, whatever pushes them.
//!
//! Models are drawn part by part, not from the seed of a generator as for the certificate. A failing model therefore
//! shrinks to the few parts it needs, and is printed as text.

use crate::play::{Random, scene, with};
use ca_compile::Options;
use ca_core::{Level, Scene, State, tick};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::TestRunner;
use std::fmt::Write as _;

/// Plays drawn models: five hundred for two thousand ticks, forty for twenty thousand and one for a million. The long
/// form plays ten thousand for two thousand ticks and sixty for a million.
pub fn soak<S: Strategy>(drawn: impl Fn() -> S, play: impl Fn(&S::Value, u64))
where
    S::Value: std::fmt::Debug,
{
    let long = ca_tests::long_form::long_form("nineteen of twenty scenes, and most of the ticks");
    let [many, some, few] = if long { [10_000, 0, 60] } else { [500, 40, 1] };
    for (cases, ticks) in [(many, 2_000), (some, 20_000), (few, 1_000_000)] {
        let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
        let played = TestRunner::new(config).run(&drawn(), |d| {
            play(&d, ticks);
            Ok(())
        });
        played.unwrap_or_else(|e| panic!("{e}"));
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Body {
    Mass,
    Cell,
    Junction,
    String,
    /// a position port moved by a gesture
    Port,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Tie {
    Plain,
    Centred,
    Implicit,
    Contact,
    /// a contact a million times as stiff
    Hard,
    /// a contact with a power law
    Round,
    /// hardening springs, as a cubic and as a table, and a plectrum
    Cubic,
    Drawn,
    Plectrum,
    Bow,
    Crossed,
}

/// A number over decades, from 10⁻ⁿ to 10ⁿ.
pub fn decades(n: f64) -> impl Strategy<Value = f64> {
    (-n..n).prop_map(|e| 10f64.powf(e))
}

fn viscosity() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), decades(3.0)]
}

/// A network on a line: its masses, its links, and its share of the stability limit.
#[derive(Clone, Debug)]
pub struct Line {
    bodies: Vec<(Body, f64, f64, f64)>,
    ties: Vec<(Tie, Index, Index, f64, f64)>,
    near: f64,
}

pub fn line() -> impl Strategy<Value = Line> {
    let body = (
        select(vec![Body::Mass, Body::Cell, Body::Junction, Body::String, Body::Port]),
        decades(3.0),
        decades(3.0),
        viscosity(),
    );
    let kinds = [
        Tie::Plain,
        Tie::Centred,
        Tie::Implicit,
        Tie::Contact,
        Tie::Hard,
        Tie::Round,
        Tie::Cubic,
        Tie::Drawn,
        Tie::Plectrum,
        Tie::Bow,
        Tie::Crossed,
    ];
    let tie = (select(kinds.to_vec()), any::<Index>(), any::<Index>(), decades(3.0), viscosity());
    let (bodies, ties) = (proptest::collection::vec(body, 2..6), proptest::collection::vec(tie, 1..9));
    (bodies, ties, 0.1..0.99).prop_map(|(mut bodies, ties, near): (Vec<(Body, f64, f64, f64)>, _, _)| {
        // the first module takes the push
        if bodies[0].0 == Body::Port {
            bodies[0].0 = Body::Mass;
        }
        Line { bodies, ties, near }
    })
}

impl Line {
    /// Name of a mass, of a mass in a module, or of the wall.
    fn end(&self, i: usize) -> String {
        match self.bodies.get(i) {
            None => "wall".into(),
            Some((Body::Junction | Body::String, ..)) => format!("n{i}[0]"),
            Some(_) => format!("n{i}"),
        }
    }

    /// An end, anywhere between the masses of a string.
    fn point(&self, i: usize) -> String {
        match self.bodies.get(i) {
            Some((Body::String, ..)) => format!("n{i}@0.37"),
            _ => self.end(i),
        }
    }

    /// The model at one tick a second, with stiffness and viscosity times `scale`.
    pub fn text(&self, scale: f64) -> String {
        let codes = [
            "SOL",
            "MAS",
            "CEL",
            "WAVEGUIDE",
            "STRING",
            "REF",
            "BUT",
            "HRZ",
            "CUB",
            "LNL",
            "PLK",
            "BOW",
            "LPR",
            "SOX",
            "ENF",
            "ENX",
        ];
        let mut parts = codes.map(|code| (code, String::new()));
        let mut add = |code: &str, name: String, args: String| {
            let part = parts.iter_mut().find(|p| p.0 == code).expect("a section");
            let _ = writeln!(part.1, "{name} = {{ {args} }}");
        };
        add("SOL", "wall".into(), String::new());
        add("ENF", "hand".into(), format!("to = \"{}\"", self.end(0)));
        for (i, (body, m, k, z)) in self.bodies.iter().enumerate() {
            let held = format!("m = {m:e}, k = {:e}, z = {:e}", k * scale, z * scale);
            let (code, args) = match body {
                Body::Port => ("ENX", String::new()),
                Body::Mass => ("MAS", format!("m = {m:e}")),
                Body::Cell => ("CEL", held),
                Body::String => ("STRING", format!("n = 4, {held}")),
                // a heavier junction has more of the string
                Body::Junction => ("WAVEGUIDE", format!("f = 0.01, t60 = 5e3, z = {m:e}, at = [0.1], m = {m:e}")),
            };
            add(code, format!("n{i}"), args);
            add("SOX", format!("o{i}"), format!("from = \"{}\"", self.end(i)));
        }
        // links solved in two ways cannot share a mass
        let plain = [Tie::Plain, Tie::Centred, Tie::Implicit, Tie::Crossed];
        let blows = self.ties.iter().any(|t| !plain.contains(&t.0));
        for (l, (tie, a, b, k, z)) in self.ties.iter().enumerate() {
            let n = self.bodies.len();
            let a = a.index(n);
            let b = Some(b.index(n)).filter(|b| *b != a).unwrap_or(n);
            let [p, q] = [a, b].map(|i| self.end(i));
            let held = format!("k = {:e}, z = {:e}", k * scale, z * scale);
            let ends = format!("between = [\"{p}\", \"{q}\"]");
            let (code, args) = match tie {
                Tie::Contact => ("BUT", format!("{ends}, {held}, method = \"stable\"")),
                Tie::Hard => {
                    // the energy that rounding makes grows with kT²/m; W119 tells of more than 1e9
                    let mobility = |i: usize| self.bodies.get(i).map_or(0.0, |b| 1.0 / b.1);
                    let hard = (1e6 * k * scale).min(1e8 / (mobility(a) + mobility(b)));
                    ("BUT", format!("{ends}, k = {hard:e}, z = {:e}, method = \"stable\"", z * scale))
                }
                Tie::Round => ("HRZ", format!("{ends}, k = {:e}, method = \"stable\"", k * scale)),
                Tie::Cubic => ("CUB", format!("{ends}, {held}, k3 = {:e}, method = \"stable\"", k * scale)),
                Tie::Drawn => {
                    let [k, z] = [k * scale, z * scale];
                    let spring = format!("[[-2, {:e}], [-1, {:e}], [0, 0], [0.5, {k:e}], [3, {:e}]]", -k, -k, 9.0 * k);
                    let friction = format!("[[-1, {:e}], [1, {z:e}]]", -z);
                    ("LNL", format!("{ends}, spring = {spring}, friction = {friction}, method = \"stable\""))
                }
                Tie::Plectrum => ("PLK", format!("{ends}, {held}, d = 1, method = \"stable\"")),
                Tie::Bow => ("BOW", format!("{ends}, f = {:e}, v0 = 1, method = \"secant\"", k * scale)),
                Tie::Crossed => ("LPR", format!("{ends}, onto = [\"wall\", \"{p}\"], {held}")),
                Tie::Centred if !blows => ("REF", format!("{ends}, {held}, method = \"centred\"")),
                Tie::Implicit if !blows => ("REF", format!("{ends}, {held}, method = \"implicit\", theta = 0.2")),
                _ => ("REF", format!("between = [\"{}\", \"{}\"], {held}", self.point(a), self.point(b))),
            };
            add(code, format!("t{l}"), args);
        }
        let written = parts.iter().filter(|p| !p.1.is_empty());
        written.fold("[rate]\nsound = 1\ngesture = 1\n".into(), |text, (code, part)| format!("{text}[{code}]\n{part}"))
    }

    /// The model at its share of the limit, or scaled down until proven, since waves need a share even without springs.
    fn proven(&self) -> (String, Scene) {
        let bound = scene(&self.text(1.0)).certificate.bound;
        let mut scale = if bound > 0.0 { self.near * 4.0 / bound } else { 1.0 };
        loop {
            let text = self.text(scale);
            let scene = with(&text, &Options { energy: true, ..Options::default() });
            if scene.certificate.level == Level::Proven {
                return (text, scene.scene);
            }
            scale *= 0.7;
            assert!(scale > 1e-9, "{:?}\n{text}", scene.certificate);
        }
    }
}

/// Pushes at random for three quarters of `ticks`, then stops: the energy is what was given, then only falls.
fn makes_nothing(line: &Line, ticks: u64) {
    let (text, scene) = line.proven();
    ledgers_balance(&text, &scene, ticks);
}

/// Largest force of a link on a line, by its law.
fn strongest(scene: &Scene, s: &State) -> f64 {
    let laws = scene.passes.forces.iter().filter_map(|op| Some((op, op.law?)));
    let forces = laws.flat_map(|(op, law)| {
        (0..op.n).map(move |i| {
            let [a, b] = scene.links.ends[op.first + i].map(|m| m as usize);
            let c: Vec<f64> = (0..law.coefs).map(|k| s.coef[op.coef + k * op.n + i]).collect();
            let mut mem = s.links.mem[op.mem + i * law.mem..][..law.mem].to_vec();
            let e = s.x[b] - s.x[a] + scene.links.e0[op.first + i];
            (law.fns.force)(&c, &mut mem, &scene.tables, e, s.d[b] - s.d[a]).abs()
        })
    });
    forces.fold(0.0, f64::max)
}

/// Largest kT²/m of a link, by the slope of its law.
fn stiffest(scene: &Scene, s: &State) -> f64 {
    let laws = scene.passes.forces.iter().filter_map(|op| Some((op, op.law?)));
    let mobility = |end: u32| s.coef[2 * scene.counts.n_mat + end as usize];
    let all = laws.flat_map(|(op, law)| {
        (0..op.n).map(move |i| {
            let c: Vec<f64> = (0..law.coefs).map(|k| s.coef[op.coef + k * op.n + i]).collect();
            let ends: f64 = scene.links.ends[op.first + i].into_iter().map(mobility).sum();
            (law.at_load.bound)(&c, &scene.tables).k * ends
        })
    });
    all.fold(0.0, f64::max)
}

fn ledgers_balance(text: &str, scene: &Scene, ticks: u64) {
    let (mut s, mut rng) = (scene.state(), Random(0x2545_f491_4f6c_dd1d));
    let mut released = f64::INFINITY;
    let (mut far, mut pull): (f64, f64) = (1.0, 0.0);
    let hand = scene.input("hand").expect("a hand");
    // rounding of the force of a hard contact, as in `methods::shared`
    let rounding = ROOM.max(1e-14 * stiffest(scene, &s));
    for n in 0..ticks {
        let moves = n < ticks / 4 * 3;
        for (i, v) in s.input.iter_mut().enumerate() {
            *v = match (i == hand, moves) {
                (true, _) => {
                    if moves {
                        rng.uniform()
                    } else {
                        0.0
                    }
                }
                (false, true) => (1e-2 * n as f64 * (i + 1) as f64).sin() + 1e-2 * rng.uniform(),
                (false, false) => *v,
            };
        }
        tick(scene, &mut s);
        if n % 64 != 0 && n + 1 != ticks {
            continue;
        }
        let b = s.ledger.as_ref().expect("a ledger").balance();
        // free modules drift, and the last digit of their position counts as work of each force
        far = s.x.iter().fold(far, |m, x| m.max(x.abs()));
        pull = pull.max(strongest(scene, &s));
        let tolerance = rounding * b.peak + n as f64 * f64::EPSILON * far * pull * scene.counts.n_lia as f64;
        // an explicit damper at a port with jerks may hold negative energy (docs/numerics.md §2.1)
        let least = if scene.inputs.len() > 1 { f64::NEG_INFINITY } else { -tolerance };
        assert!(
            b.h >= least && b.h <= b.h0 + b.work + tolerance && b.residual.abs() <= tolerance,
            "{n}: {b:?}\n{text}"
        );
        // the push of the last tick is booked in the next
        if n > ticks / 4 * 3 + 3 {
            assert!(b.h <= released + tolerance, "{n}: {b:?}\n{text}");
            released = b.h;
        }
    }
    if s.links.touches.unsolved > 0 {
        println!("{} of {ticks} steps met the bound on iterations, and made no energy", s.links.touches.unsolved);
    }
}

/// Rounding of the ledger over a million ticks, relative to its peak.
const ROOM: f64 = 1e-9;

/// Two free masses, pushed for so long that the last digit of their positions counts.
#[test]
fn what_drifts_far_away_is_entered_to_its_last_digit() {
    let text = "[rate]\nsound = 1\ngesture = 1\n[MAS]\na = { m = 1 }\nb = { m = 1 }\n[REF]\nt = { between = [\"a\", \"b\"], k = 0.2 }\n\
                [SOX]\no = { from = \"a\" }\n[ENF]\nhand = { to = \"a\" }\n";
    let scene = with(text, &Options { energy: true, ..Options::default() });
    assert_eq!(scene.certificate.level, Level::Proven);
    ledgers_balance(text, &scene, 600_000);
}

#[test]
fn what_is_proven_makes_no_energy() {
    soak(line, makes_nothing);
}
