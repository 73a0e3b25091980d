//! Equivalences: the table of docs/numerics.md §6, `[equivalence]`, and a driving point measured in a scene.

use crate::play::{case, num, off, within};
use ca_compile::{Options, load};
use ca_core::equivalence::{Class, Gains, Pair, Quantity, ROWS, anchor_for, row, solve, solve_keeping};
use ca_core::{Scene, State, compute_forces, integrate};
use ca_haptic::equivalence::gains;
use ca_tests::catalog;
use proptest::prelude::*;

const TIME_UNIT: f64 = 1.0 / 44_100.0;

fn near(what: &str, is: f64, want: f64, within: f64) {
    assert!((is / want - 1.0).abs() <= within, "{what}: {is} is not {want}");
}

fn scene(text: &str) -> Scene {
    let (model, scene) = load(text, "hand.ca.toml", &catalog(), &Options::default());
    scene.unwrap_or_else(|d| panic!("{}", ca_model::render::text(&d, &model, false))).scene
}

fn at(name: &str) -> &'static Quantity {
    row(name).unwrap()
}

/// A key on `link`, in per-sample units at 44.1 kHz, with `section` as `[equivalence]`.
fn paper(link: &str, section: &str) -> Scene {
    scene(&format!(
        "[model]\nunits = \"alg\"\nreference_rate = \"44.1 kHz\"\n[rate]\nsound = \"44.1 kHz\"\ngesture = \"44.1 kHz\"\n\
         [TGR]\nkey = {{ device = \"hand\" }}\nother = {{ device = \"hand\", dof = 2 }}\n{link}\n\
         [SOX]\nout = {{ from = \"key\" }}\n[equivalence]\n{section}"
    ))
}

#[test]
fn the_table_of_the_paper() {
    let s = paper(
        "[SOL]\nwall = {}\n[RES]\nspring = { between = [[\"key\", \"other\"], \"wall\"], k = 2e-4 }",
        "mass = [\"20 g\", 1.0]\nposition = [\"20 mm\", 1]",
    );
    let e = &s.hand.equivalence;
    near("alpha", e.gains.alpha, 50.0, 1e-15);
    near("beta", e.gains.beta, 777_924.0, 1e-15);
    near("time", e.time_unit, 22.675_736_961_451_25e-6, 1e-15);
    // every row of docs/numerics.md §6: real = factor × simulated, and exponents of α, β and Te
    let table = [
        ("position", 0.02, [-1, 0, 0]),
        ("velocity", 882.0, [-1, 0, -1]),
        ("acceleration", 38_896_200.0, [-1, 0, -2]),
        ("force", 777_924.0, [0, 1, 0]),
        ("momentum", 17.64, [0, 1, 1]),
        ("mass", 0.02, [1, 1, 2]),
        ("stiffness", 38_896_200.0, [1, 1, 0]),
        ("viscosity", 882.0, [1, 1, 1]),
        ("compliance", 1.0 / 38_896_200.0, [-1, -1, 0]),
        ("energy", 15_558.48, [-1, 1, 0]),
        ("power", 15_558.48 * 44_100.0, [-1, 1, -1]),
        ("time", TIME_UNIT, [0, 0, 1]),
    ];
    assert_eq!(table.map(|t| t.0).to_vec(), ROWS.iter().map(|r| r.name).collect::<Vec<_>>());
    for (name, factor, exponents) in table {
        assert_eq!(at(name).exponents(), exponents, "{name}");
        near(name, at(name).factor(e.gains, e.time_unit), factor, 1e-14);
    }
}

/// The same against independently computed numbers. An impulse is a momentum, an action is energy times time.
#[test]
fn f01_the_table_by_numbers() {
    let c = case("F01");
    let tolerance = num(c, "tolerance/rel");
    let s = paper(
        "[SOL]\nwall = {}\n[RES]\nspring = { between = [[\"key\", \"other\"], \"wall\"], k = 2e-4 }",
        "mass = [\"20 g\", 1.0]\nposition = [\"20 mm\", 1]",
    );
    let e = &s.hand.equivalence;
    within("F01 alpha", off(e.gains.alpha, num(c, "values/alpha")), tolerance);
    within("F01 beta", off(e.gains.beta, num(c, "values/beta")), tolerance);
    let factor = |name: &str| at(name).factor(e.gains, e.time_unit);
    let table = c["values"]["SI_per_unit"].as_object().expect("a table");
    for name in table.keys() {
        let is = match name.as_str() {
            "impulse" => factor("momentum"),
            "action" => factor("energy") * factor("time"),
            row => factor(row),
        };
        within(&format!("F01 {name}"), off(is, num(c, &format!("values/SI_per_unit/{name}"))), tolerance);
    }
    assert!(ROWS.iter().all(|r| table.contains_key(r.name)));
}

#[test]
fn a_mass_on_the_key_weighs_what_the_table_says() {
    // the hand shakes a mass through a spring so stiff that it follows: F = m a at 5 Hz, by second differences
    let s = paper(
        "[MAS]\nbob = { m = 1.0 }\n[RES]\nspring = { between = [\"key\", \"bob\"], k = 0.25 }",
        "mass = [\"20 g\", 1.0]\nposition = [\"20 mm\", 1]",
    );
    let g = gains(&s, "hand")[0];
    let mut state: State = s.state();
    let input = s.input("key").unwrap();
    let (mut x, mut f) = (Vec::new(), Vec::new());
    let amplitude = 0.005;
    let w = 2.0 * std::f64::consts::PI * 5.0 * s.rates.sample_dt;
    for n in 0..(44_100 * 2) {
        // starts with neither displacement nor speed, so that the mass does not ring on its spring
        let t = f64::from(n) * w;
        let rise = (f64::from(n) / 44_100.0).min(1.0);
        let rise = rise * rise * rise * (10.0 - 15.0 * rise + 6.0 * rise * rise);
        let hand = amplitude * rise * t.sin();
        state.input[input] = g.alpha * hand;
        compute_forces(&s, &mut state);
        x.push(hand);
        f.push(g.beta * state.ports.border[0].force);
        integrate(&s, &mut state);
    }
    // least squares of the force on the hand against its acceleration, over whole periods of the second second
    let a = |n: usize| (x[n + 1] - 2.0 * x[n] + x[n - 1]) / (s.rates.sample_dt * s.rates.sample_dt);
    let range = 44_100..(2 * 44_100 - 1);
    let (fa, aa) = range.fold((0.0, 0.0), |(fa, aa), n| (fa + f[n] * a(n), aa + a(n) * a(n)));
    let m = -fa / aa;
    println!("driving-point mass {m:.10} kg");
    // the spring is left: a mass behind it appears 1/(1 − 4 sin²(ω/2)·M/K) times as heavy
    near("driving-point mass", m, 0.02 / (1.0 - 4.0 * (w / 2.0).sin().powi(2) / 0.25), 1e-8);
}

#[test]
fn a_device_on_a_spring_swings_as_the_table_says() {
    // 0.1 kg on K = 2e-4: 7779.24 N/m, 44.3904 Hz
    let s = paper(
        "[SOL]\nwall = {}\n[RES]\nspring = { between = [[\"key\", \"other\"], \"wall\"], k = 2e-4 }",
        "mass = [\"20 g\", 1.0]\nposition = [\"20 mm\", 1]",
    );
    let g = gains(&s, "hand")[0];
    let k = s.certificate.keys[0].k * g.stiffness();
    near("stiffness", k, 7779.24, 1e-14);
    let (m, dt) = (0.1, s.rates.sample_dt);
    let (mut x, mut v) = (0.001, 0.0);
    let mut state = s.state();
    let mut crossings = Vec::new();
    for n in 0..44_100 {
        state.input[s.input("key").unwrap()] = g.alpha * x;
        state.input[s.input("other").unwrap()] = 0.0;
        compute_forces(&s, &mut state);
        let force = g.beta * state.ports.border[0].force;
        integrate(&s, &mut state);
        let before = x;
        v += force / m * dt;
        x += v * dt;
        if before < 0.0 && x >= 0.0 {
            crossings.push(f64::from(n) + before / (before - x));
        }
    }
    let periods = crossings.len() as f64 - 1.0;
    let f = periods / ((crossings[crossings.len() - 1] - crossings[0]) * dt);
    println!("a device of 0.1 kg swings at {f:.6} Hz");
    near("frequency", f, 44.390_4, 2e-6);
}

#[test]
fn si_models_are_in_si() {
    let model = |section: &str| {
        scene(&format!(
            "[TGR]\nkey = {{ device = \"hand\" }}\n[CEL]\nbar = {{ m = \"1 g\", f = 220 }}\n[RES]\nshank = {{ between = [\"key\", \"bar\"], k = 100 }}\n[SOX]\nout = {{ from = \"bar\" }}\n{section}"
        ))
    };
    let none = model("");
    assert_eq!(none.hand.equivalence.gains, Gains::default());
    assert!(ROWS.iter().all(|r| r.factor(none.hand.equivalence.gains, none.hand.equivalence.time_unit) == 1.0));
    let heavy = model("[equivalence]\nmass = [\"20 g\", \"1 g\"]\n").hand.equivalence.gains;
    assert_eq!((heavy.alpha, heavy.beta), (1.0, 20.0));
    // a row of positions keeps the impedance
    let far = model("[equivalence]\nposition = [\"1 mm\", \"1 m\"]\n").hand.equivalence.gains;
    assert_eq!((far.alpha, far.beta), (1000.0, 0.001));
    let held =
        |anchor: &str| model(&format!("[equivalence]\nmass = [4, 1]\nanchor = \"{anchor}\"\n")).hand.equivalence.gains;
    assert_eq!(held("force"), Gains { alpha: 4.0, beta: 1.0 });
    assert_eq!(held("energy"), Gains { alpha: 2.0, beta: 2.0 });
    // a bare number is in SI on the real side, here on both
    assert_eq!(model("[equivalence]\nmass = [\"4 kg\", 1]\n").hand.equivalence.gains, held("position"));
    assert_eq!(
        model("[param]\nbig = \"4 kg\"\n[equivalence]\nmass = [\"big\", 1]\n").hand.equivalence.gains,
        held("position")
    );
}

#[test]
fn keys_differ() {
    let s = paper(
        "[SOL]\nwall = {}\n[RES]\nspring = { between = [[\"key\", \"other\"], \"wall\"], k = 1 }",
        "force = [3, 1]\nposition = [0.5, 1]\n[equivalence.other]\nposition = 2\nforce = 8\n",
    );
    let all = gains(&s, "hand");
    assert_eq!(all, [Gains { alpha: 2.0, beta: 3.0 }, Gains::default(), Gains { alpha: 4.0, beta: 24.0 }]);
    assert!(gains(&s, "another").is_empty());
    let scale = &s.hand.equivalence.keys[0];
    assert!(!scale.is_lever());
    // energy given at one key comes out four times as large at the other
    near("amplifier", s.hand.equivalence.of("other").energy() / s.hand.equivalence.of("key").energy(), 4.0, 1e-15);
    let s = paper(
        "[SOL]\nwall = {}\n[RES]\nspring = { between = [[\"key\", \"other\"], \"wall\"], k = 1 }",
        "[equivalence.other]\nlever = 3\n",
    );
    assert!(s.hand.equivalence.keys[0].is_lever());
    near("lever", s.hand.equivalence.of("other").energy(), 1.0, 1e-15);
    near("lever", s.hand.equivalence.of("other").stiffness(), 9.0, 1e-15);
}

#[test]
fn keys_in_space_and_in_groups_have_their_scale() {
    let s = scene(
        "[room]\ndim = 3\n[room.TGR]\nhand = { device = \"falcon\", dof = [0, 1, 2] }\n[room.MAS]\nball = { m = 0.1, x = [0, 0, 0.1] }\n\
         [RES]\nband = { between = [\"room.hand\", \"room.ball\"], k = 10 }\n[SOX]\nout = { from = \"room.ball\", along = \"z\" }\n\
         [equivalence]\nforce = [2, 1]\n[equivalence.room.hand]\nlever = 5\n",
    );
    assert_eq!(gains(&s, "falcon"), [Gains { alpha: 5.0, beta: 10.0 }; 3]);
}

fn settable() -> Vec<&'static Quantity> {
    ROWS.iter().filter(|r| r.class() != Class::Time).collect()
}

proptest! {
    /// Two rows of different classes determine the table and both hold; two of the same class do not.
    #[test]
    fn two_rows_settle_all(i in 0..11_usize, j in 0..11_usize, a in -9.0..9.0, b in -9.0..9.0, alg: bool) {
        let (rows, time_unit) = (settable(), if alg { TIME_UNIT } else { 1.0 });
        // a ratio that such a model would give, so that none is out of range
        let wild = Gains { alpha: 10f64.powf(a), beta: 10f64.powf(b) };
        let pairs = [rows[i], rows[j]].map(|row| Pair { row, ratio: row.factor(wild, time_unit) });
        let found = solve(pairs, time_unit);
        prop_assert_eq!(found.is_some(), rows[i].class() != rows[j].class());
        if let Some(g) = found {
            prop_assert!((g.alpha / wild.alpha - 1.0).abs() < 1e-13 && (g.beta / wild.beta - 1.0).abs() < 1e-13);
        }
    }

    /// Editing one row makes it hold and leaves all rows of the anchor unchanged.
    #[test]
    fn the_anchor_stays(i in 0..11_usize, a in -3.0..3.0, b in -3.0..3.0, ratio in 0.01..100.0) {
        let row = settable()[i];
        let held = Gains { alpha: 10f64.powf(a), beta: 10f64.powf(b) };
        let pair = Pair { row, ratio: ratio * row.factor(held, TIME_UNIT) };
        for anchor in [Class::Position, Class::Force, Class::Impedance, Class::Energy] {
            let Some(g) = solve_keeping(pair, anchor, held, TIME_UNIT) else {
                prop_assert_eq!(anchor, row.class());
                continue;
            };
            prop_assert!((row.factor(g, TIME_UNIT) / pair.ratio - 1.0).abs() < 1e-13);
            for r in ROWS.iter().filter(|r| r.class() == anchor) {
                prop_assert!((r.factor(g, TIME_UNIT) / r.factor(held, TIME_UNIT) - 1.0).abs() < 1e-13);
            }
        }
        prop_assert!(solve_keeping(pair, anchor_for(row.class()), held, TIME_UNIT).is_some());
    }
}
