//! Every kind of the catalog keeps the promises of its record; nothing here is written for one kind by name, so a new
//! law is tested the day it is listed.

use crate::play::{Dice, audited, mat, model, reference, scene, with};
use ca_core::catalog::SOURCES;
use ca_core::kind::{Kind, Need, Role, Type, Unit};
use ca_core::model::{Entry, Model, Value, quantity, read, render};
use ca_core::phi::Law;
use ca_core::scene::Stands;
use ca_core::table::Table;
use ca_core::{Catalog, KernelClass, Options, Scene, State, compile, process, tick};
use ca_tests::{gesture, texts};
use proptest::prelude::*;

fn laws() -> Vec<(&'static Kind, &'static Law)> {
    let list: Vec<_> =
        Catalog::core().iter().filter_map(|k| if let Role::Lia(l) = k.role { Some((k, l)) } else { None }).collect();
    assert!(list.len() >= 11);
    list
}

/// A value for a parameter of a link, as it would be written, of the size it has in an instrument.
fn written(unit: Unit, (min, max): (f64, f64), dice: &mut Dice) -> f64 {
    let u = 0.5 * (dice.roll() + 1.0);
    let size = |lo: i32, hi: i32| 10f64.powf(f64::from(lo) + u * f64::from(hi - lo));
    let v = match unit.symbol {
        "N/m" => size(0, 4),
        "N s/m" => size(-4, -1),
        "m" => size(-4, -3),
        "N" | "m/s" => size(-2, 0),
        "N/m^3" => size(4, 9),
        _ => u,
    };
    v.clamp(min, max)
}

/// Parameters of a link, drawn within their ranges; tables rise, so that they resist.
fn args(kind: &Kind, dice: &mut Dice) -> Vec<Entry> {
    let mut out = Vec::new();
    let chosen = |set: &'static [&'static [&'static str]], roll: f64| set[usize::from(roll > 0.0) % set.len()];
    let sets: Vec<_> = kind.one_of.iter().map(|o| (o.sets, chosen(o.sets, dice.roll()))).collect();
    for p in kind.params {
        let mentioned = sets.iter().find(|(all, _)| all.iter().any(|s| s.contains(&p.name)));
        if mentioned.is_some_and(|(_, set)| !set.contains(&p.name)) {
            continue;
        }
        // the last table of a kind is left out only where there is another
        let table = |t: &Type| matches!(t, Type::Points { .. });
        let only = table(&p.ty)
            && kind.params.iter().rfind(|q| table(&q.ty)).is_some_and(|q| q.name == p.name)
            && !out.iter().any(|e: &Entry| matches!(e.value, Value::List(_)));
        if mentioned.is_none() && p.need == Need::Optional && p.name != "l0" && !only && dice.roll() > 0.6 {
            continue;
        }
        let value: Value = match p.ty {
            Type::Number { .. } if p.name == "p" => (0.25 * (4.0 + (4.0 * (dice.roll() + 1.0)).floor())).into(),
            // a rest length would only move the elongation, which is drawn anyway
            Type::Number { .. } if p.name == "l0" => 0.0.into(),
            Type::Number { unit, min, max } => written(unit, (min, max), dice).into(),
            Type::PowerStiffness { .. } => written(Unit::STIFFNESS, (0.0, f64::MAX), dice).into(),
            Type::Choice(words) if p.name == "curve" => {
                // the curve follows the set that was chosen
                let table = sets.iter().any(|(_, s)| s.contains(&"points"));
                let i = ((dice.roll() + 1.0) * 1.5) as usize;
                words[if table { words.len() - 1 } else { i.min(words.len() - 2) }].into()
            }
            Type::Choice(words) => words[usize::from(dice.roll() > 0.0) % words.len()].into(),
            Type::Flag => (dice.roll() > 0.0).into(),
            Type::Points { .. } => {
                let (x, y) = (1e-3 * (2.0 + dice.roll()), 2.0 + dice.roll());
                let row = |a: f64, b: f64| Value::from(vec![a, b]);
                vec![row(-2.0 * x, -3.0 * y), row(-x, -y), row(0.0, 0.0), row(1.5 * x, 0.5 * y), row(4.0 * x, 2.0 * y)]
                    .into()
            }
            _ => continue,
        };
        out.push(Entry::new(p.name, value));
    }
    out
}

/// `low` and `high` joined by one link of this kind.
fn pair(kind: &Kind, dice: &mut Dice) -> Model {
    let mut m = model("[MAS]\nlow = { m = 1 }\nhigh = { m = 2 }\n[SOX]\nout = { from = \"low\" }\n");
    let mut list = args(kind, dice);
    list.push(Entry::new("between", Value::from(vec!["low", "high"])));
    m.add(kind.code, "link", list);
    m
}

fn built(m: &Model, options: &Options) -> Scene {
    compile(m, &Catalog::core(), options).unwrap_or_else(|d| panic!("{d}\n{}", ca_core::model::write::write(m)))
}

/// A law with its coefficients, memory and tables, taken from a compiled scene.
struct Loaded {
    law: &'static Law,
    c: Vec<f64>,
    mem: Vec<f64>,
    tables: Vec<Table>,
    named: String,
}

impl Loaded {
    fn new(kind: &Kind, dice: &mut Dice) -> Loaded {
        let m = pair(kind, dice);
        let scene = built(&m, &Options::default());
        let s = scene.state();
        let op = scene.forces.iter().find(|o| o.law.is_some()).expect("a link");
        let law = op.law.expect("a law");
        let c: Vec<f64> = (0..law.coefs).map(|k| s.coef[op.coef + k * op.n]).collect();
        let mut l = Loaded {
            law,
            c,
            mem: vec![0.0; law.mem],
            tables: scene.tables.clone(),
            named: ca_core::model::write::write(&m),
        };
        l.start(0.0);
        l
    }
    fn start(&mut self, e: f64) {
        (self.law.start)(&self.c, e, &mut self.mem);
    }
    fn force(&mut self, e: f64, w: f64) -> f64 {
        (self.law.force)(&self.c, &mut self.mem, &self.tables, e, w)
    }
    fn stored(&self, e: f64) -> f64 {
        (self.law.stored)(&self.c, &self.mem, &self.tables, e, e)
    }
}

#[test]
fn every_record_is_complete() {
    for kind in Catalog::core().iter() {
        let code = kind.code;
        assert!(code.chars().all(|c| c.is_ascii_uppercase()), "{code}");
        assert!([kind.title, kind.equation, kind.doc, kind.example].iter().all(|t| !t.trim().is_empty()), "{code}");
        assert!(!kind.source.is_empty(), "{code} cites nothing");
        for key in kind.source {
            assert!(SOURCES.iter().any(|(k, full)| k == key && full.len() > 20), "{code} cites `{key}`");
        }
        for (i, p) in kind.params.iter().enumerate() {
            let what = format!("{code}.{}", p.name);
            assert!(p.doc.len() > 2, "{what} has no doc");
            assert_eq!(kind.param(p.name), Some(i), "{what} is there twice");
            match (p.ty, p.need) {
                (Type::Number { unit, min, max } | Type::Numbers { unit, min, max }, need) => {
                    assert!(min < max, "{what}");
                    let plain = unit.symbol.is_empty();
                    assert_eq!(plain, unit.dim == ca_core::kind::Dim::NONE, "{what}: `{}`", unit.symbol);
                    if let Need::Default(v) = need {
                        assert!(min <= v && v <= max, "{what}: {v} is not in {min} … {max}");
                    }
                }
                (Type::Count { min, max }, need) => {
                    assert!(min < max, "{what}");
                    if let Need::Default(v) = need {
                        assert!(f64::from(min) <= v && v <= f64::from(max) && v.fract() == 0.0, "{what}: {v}");
                    }
                }
                (Type::Choice(words), Need::Default(v)) => assert!((v as usize) < words.len(), "{what}"),
                (Type::PowerStiffness { exponent }, _) => assert!(kind.param(exponent).is_some(), "{what}"),
                _ => {}
            }
        }
        for set in kind.one_of.iter().flat_map(|o| o.sets).copied().flatten() {
            assert!(kind.param(set).is_some(), "{code}: `{set}` of an alternative is no parameter");
        }
    }
}

#[test]
fn every_example_sounds() {
    for kind in Catalog::core().iter() {
        let (m, diags) = read::read(kind.example, kind.code, &Catalog::core());
        assert!(diags.list.is_empty(), "{}", render::text(&diags, &m, false));
        assert!(m.items.iter().any(|i| i.kind == kind.code), "the example of {} is of something else", kind.code);
        let scene = built(&m, &Options::default());
        assert!(scene.diags.list.is_empty(), "{}: {}", kind.code, render::text(&scene.diags, &m, false));
        let mut s = scene.state();
        let mut peak = 0.0f64;
        for n in 0..96_000 {
            gesture(&scene, &mut s);
            tick(&scene, &mut s);
            assert!(s.output.iter().all(|v| v.is_finite()), "{} at tick {n}", kind.code);
            peak = s.output.iter().fold(peak, |m, v| m.max(v.abs()));
        }
        assert!(peak > 0.01 && peak <= 1.0, "the example of {} peaks at {peak}", kind.code);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn action_is_reaction(seed in 1u64.., x in -2e-3..2e-3f64, y in -2e-3..2e-3f64, v in -1e-5..1e-5f64) {
        for (kind, _) in laws() {
            let scene = built(&pair(kind, &mut Dice(seed)), &Options::default());
            let (a, b) = (mat(&scene, "low"), mat(&scene, "high"));
            let mut s = scene.state();
            (s.x[a], s.x[b], s.d[a]) = (x, y, v);
            for _ in 0..200 {
                ca_core::sense(&scene, &mut s);
                prop_assert_eq!(s.f[a], -s.f[b], "{}", kind.code);
                ca_core::advance(&scene, &mut s);
            }
        }
    }

    /// Force is the slope of the potential: ΔU = ∫F de at rest, by the midpoint rule.
    #[test]
    fn potential_is_the_integral_of_force(seed in 1u64.., from in -1e-3..1e-3f64, way in -2e-3..2e-3f64) {
        for (kind, _) in laws() {
            let mut l = Loaded::new(kind, &mut Dice(seed));
            // a plectrum has a potential while it holds
            let reach = if l.law.mem > 0 { l.c[2] * 0.999 } else { f64::INFINITY };
            let clip = |e: f64| e.clamp(-reach, reach);
            let (e0, e1) = (clip(from), clip(from + way));
            l.start(0.0);
            let n = 20_000;
            let h = (e1 - e0) / f64::from(n);
            let (mut work, mut scale) = (0.0, 0.0f64);
            for i in 0..n {
                let f = l.force(e0 + (f64::from(i) + 0.5) * h, 0.0);
                work += f * h;
                scale = scale.max((f * (e1 - e0)).abs());
            }
            let gain = l.stored(e1) - l.stored(e0);
            prop_assert!((gain - work).abs() <= 1e-6 * scale.max(1e-300), "{gain} is not {work}\n{}", l.named);
        }
    }

    /// Round and round a closed path, a link takes work or nothing; what it says it turns to heat is never negative.
    #[test]
    fn a_cycle_gains_nothing(seed in 1u64.., middle in -5e-4..5e-4f64, swing in 1e-4..2e-3f64) {
        for (kind, _) in laws() {
            let mut l = Loaded::new(kind, &mut Dice(seed));
            let n = 20_000;
            let path = |i: i32| middle + swing * (f64::from(i) * std::f64::consts::TAU / f64::from(n)).sin();
            // once round to forget where it began
            let (mut taken, mut scale) = (0.0, 0.0f64);
            for i in -n..n {
                let e = [path(i - 1), path(i), path(i + 1)];
                let f = l.force(e[1], e[1] - e[0]);
                let heat = (l.law.lost)(&l.c, &l.mem, &l.tables, e);
                prop_assert!(heat >= 0.0, "heat {heat} at {e:?}\n{}", l.named);
                if i >= 0 {
                    let work = f * 0.5 * (e[2] - e[0]);
                    taken += work;
                    scale += work.abs();
                }
            }
            prop_assert!(taken >= -1e-3 * scale, "{taken} of {scale}\n{}", l.named);
        }
    }

    /// No slope is above the bound the certificate uses (at rest for laws that harden, whose rule of thumb it is).
    #[test]
    fn bounds_bound(seed in 1u64.., e in -2e-3..2e-3f64, step in 1e-7..1e-4f64, w in -1e-5..1e-5f64) {
        for (kind, _) in laws() {
            let mut l = Loaded::new(kind, &mut Dice(seed));
            let bound = (l.law.bound)(&l.c, &l.tables);
            // the bound of laws that harden is their slope at rest, for a rule of thumb; a Hertz contact has none
            let hardens = matches!(kind.code, "CUB" | "POW");
            let reach = if l.law.mem > 0 { 0.9 * l.c[2] } else { f64::INFINITY };
            let (e, step) = if hardens { (0.0, 1e-12) } else { (e.clamp(-reach, reach), step.min(0.1 * reach)) };
            let rise = (l.force(e + step, 0.0) - l.force(e, 0.0)).abs() / step;
            let room = if kind.code == "POW" { l.c[1] * step.powf(0.25 * l.c[2] - 1.0) } else { 0.0 };
            if kind.code != "HRZ" {
                prop_assert!(rise <= bound.k * (1.0 + 1e-6) + room + 1e-6, "{rise} above {}\n{}", bound.k, l.named);
            }
            let tug = (l.force(e, w + 1e-6) - l.force(e, w)).abs() / 1e-6;
            let by_hand = if kind.code == "HRZ" { f64::INFINITY } else { bound.z };
            prop_assert!(tug <= by_hand * (1.0 + 1e-6) + 1e-6, "{tug} above {}\n{}", bound.z, l.named);
            prop_assert!(!bound.active, "a table that resists is not active\n{}", l.named);
        }
    }

    /// With the book kept: every law's accounts close, heat is never negative, linear laws make nothing, and what only
    /// resists never makes a mass faster.
    #[test]
    fn books_close(seed in 1u64.., x in -1e-3..1e-3f64, v in -0.2..0.2f64) {
        for (kind, _) in laws() {
            let mut m = pair(kind, &mut Dice(seed));
            m.add("SOL", "ground", []);
            m.add("RES", "tie", [Entry::new("between", Value::from(vec!["ground", "low"])), Entry::new("k", 1e4)]);
            let scene = built(&m, &Options { energy: true, ..Options::default() });
            let mut s = scene.state();
            let high = mat(&scene, "high");
            (s.x[high], s.d[high]) = (x, v * scene.te);
            let mut before = 0.0;
            for n in 0..2000 {
                tick(&scene, &mut s);
                let book = s.ledger.as_ref().expect("a book");
                prop_assert!(book.lost.iter().all(|l| *l >= 0.0), "{}", kind.code);
                let only_resists = matches!(scene.forces[0].law.map(|l| l.code), Some("FRO" | "LNL friction"))
                    || kind.code == "BOW" && scene.forces.iter().all(|o| o.law.is_some());
                if n > 0 && only_resists {
                    prop_assert!(book.h <= before + book.source.iter().sum::<f64>().abs() + 1e-12 * book.peak);
                }
                before = book.h;
            }
            let b = s.ledger.as_ref().expect("a book").balance();
            prop_assert!(b.residual.abs() <= 1e-12 * b.peak, "{}: {b:?}", kind.code);
            prop_assert!(b.source == 0.0 || scene.forces.iter().any(|o| o.law.is_some_and(|l| !l.linear)));
        }
    }
}

/// A row of six masses joined by one law each, and a seventh across, so that batches hold a run and a loose link.
fn row(kind: &Kind, apart: bool, dice: &mut Dice) -> Model {
    let mut m = model("[SOX]\nout = { from = \"m3\" }\n");
    for i in 0..6 {
        let x = if apart { 1e-4 * f64::from(i) } else { 0.0 };
        let own = [
            Entry::new("m", 0.5 + 0.1 * f64::from(i)),
            Entry::new("x", x),
            Entry::new("dx0", 1e-3 * dice.roll()),
            Entry::new("v", 0.1 * dice.roll()),
        ];
        m.add("MAS", &format!("m{i}"), own);
    }
    let list = args(kind, dice);
    for (k, (a, b)) in [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (0, 3)].into_iter().enumerate() {
        let mut own = list.clone();
        own.retain(|e| e.key != "l0");
        own.push(Entry::new("between", Value::from(vec![format!("m{a}"), format!("m{b}")])));
        if apart && kind.param("l0").is_some() {
            own.push(Entry::new("l0", 5e-5));
        }
        m.add(kind.code, &format!("l{k}"), own);
    }
    m
}

#[test]
fn all_forms_of_a_law_give_the_same_bits() {
    let mut seen = std::collections::BTreeSet::new();
    for (kind, _) in laws() {
        for apart in [false, true] {
            for seed in 1..6 {
                let m = row(kind, apart, &mut Dice(seed * 977));
                let forms = [
                    reference(),
                    Options::default(),
                    Options { energy: true, ..Options::default() },
                    Options { energy: true, ..reference() },
                    Options { probes: vec!["l2".into(), "l5".into()], ..Options::default() },
                ];
                let play = |o: &Options| {
                    let scene = built(&m, o);
                    scene.forces.iter().filter(|o| o.law.is_some()).for_each(|o| {
                        seen.insert((o.form.stride > 0, o.form.offset, o.form.tap));
                    });
                    let places: Vec<usize> = (0..6).map(|i| mat(&scene, &format!("m{i}"))).collect();
                    let mut s = scene.state();
                    (0..1000).for_each(|_| tick(&scene, &mut s));
                    places.iter().map(|p| (s.x[*p].to_bits(), s.d[*p].to_bits())).collect::<Vec<_>>()
                };
                let mut play = play;
                let first = play(&forms[0]);
                for form in &forms[1..] {
                    assert_eq!(play(form), first, "{} {form:?}", kind.code);
                }
            }
        }
    }
    assert_eq!(seen.len(), 8, "not every form was played: {seen:?}");
}

#[test]
fn a_plectrum_lets_go_once_per_passage() {
    for seconds in [0.02, 0.3, 2.0] {
        let text = "[CEL]\nreed = { m = \"1 g\", f = \"220 Hz\", t60 = \"0.05 s\" }\n[ENX]\nplectrum = { x = \"-3 mm\" }\n\
             [PLK]\npluck = { between = [\"reed\", \"plectrum\"], k = \"2 kN/m\", z = \"0.05 N s/m\", d = \"1 mm\" }\n\
             [SOX]\nout = { from = \"reed\", gain = 500 }\n";
        let scene = scene(text);
        let mut s = scene.state();
        let (mut releases, mut takes) = (0, 0);
        let passage = (seconds * scene.rate) as u64;
        for n in 0..4 * passage {
            let u = (n % passage) as f64 / passage as f64;
            let up = (n / passage).is_multiple_of(2);
            s.input[0] = 6e-3 * (u - 0.5) * if up { 1.0 } else { -1.0 };
            let (held, last) = (s.mem[0], s.mem[1]);
            tick(&scene, &mut s);
            releases += u32::from(held == 1.0 && s.mem[0] == 0.0);
            if held == 0.0 && s.mem[0] == 1.0 {
                takes += 1;
                assert!(last * s.mem[1] <= 0.0, "it takes hold where it passes the reed, not before");
            }
        }
        assert_eq!((takes, releases), (4, 4), "4 passages of {seconds} s");
    }
}

/// Makes argument `arg` of item `item` a live parameter of value `v`, and says what its value was in SI.
fn live(m: &Model, item: usize, arg: usize, v: Option<f64>) -> Option<(Model, f64)> {
    let mut m = m.clone();
    let e = &mut m.items[item].args[arg];
    let si = match &e.value {
        Value::Num(v) => *v,
        Value::Text(t) if quantity::is_quantity(t) => quantity::parse(t).ok()?.value,
        _ => return None,
    };
    e.value = "dial".into();
    let range = if si == 0.0 { [0.0, 1e-3] } else { [si * 0.7, si * 1.4] };
    let entries = vec![
        Entry::new("value", v.unwrap_or(si)),
        Entry::new("live", true),
        Entry::new("min", range[0].min(range[1])),
        Entry::new("max", range[0].max(range[1])),
    ];
    m.params.push(Entry::new("dial", Value::Table(entries)));
    Some((m, si))
}

#[test]
fn a_live_change_ends_where_a_fresh_compile_begins() {
    const TICKS: u32 = 7;
    let catalog = Catalog::core();
    let mut dialled = std::collections::BTreeSet::new();
    for (name, text) in texts() {
        let plain = model(&text);
        if plain.items.len() > 60 {
            continue;
        }
        let rate = scene(&text).rate;
        for item in 0..plain.items.len() {
            let kind = catalog.get(&plain.items[item].kind).expect("a kind");
            for arg in 0..plain.items[item].args.len() {
                let p = kind.param(&plain.items[item].args[arg].key).map(|i| &kind.params[i]).expect("a parameter");
                if !matches!(p.ty, Type::Number { .. } | Type::PowerStiffness { .. }) {
                    continue;
                }
                let Some((before, si)) = live(&plain, item, arg, None) else { continue };
                let to = if si == 0.0 { 1e-4 } else { si * 1.03 };
                let what = format!("{name}: {}.{}", plain.items[item].name, p.name);
                let options = Options { rate: Some(rate), ..Options::default() };
                let (after, _) = live(&plain, item, arg, Some(to)).expect("a number");
                let (Ok(scene), Ok(fresh)) =
                    (compile(&before, &catalog, &options), compile(&after, &catalog, &options))
                else {
                    // positions and lengths are where a model starts, an exponent is another law: not live, and said so
                    let refused = compile(&before, &catalog, &options).expect_err("refused");
                    assert!(refused.list.iter().any(|d| d.code == "E025"), "{what}: {refused}");
                    assert!(matches!(p.name, "x" | "dx0" | "v" | "l0" | "p"), "{what}: {refused}");
                    continue;
                };
                assert!(scene.e0 == fresh.e0 && scene.rest == fresh.rest, "{what} moves something that is not live");
                let patch = scene.controls().set("dial", to).unwrap_or_else(|e| panic!("{what}: {e}"));
                let mut s = scene.state();
                (0..5).for_each(|_| tick(&scene, &mut s));
                assert!(s.apply(&patch, TICKS));
                let target = fresh.state().coef;
                let moved: Vec<usize> = (0..target.len()).filter(|i| s.coef[*i] != target[*i]).collect();
                for left in (0..TICKS).rev() {
                    let way = s.coef.clone();
                    tick(&scene, &mut s);
                    for i in &moved {
                        assert!(s.coef[*i] != way[*i], "{what}: coefficient {i} waits");
                    }
                    assert_eq!(s.coef == target, left == 0, "{what}, {left} ticks to go");
                    assert_eq!(s.ramps.is_moving(), left > 0);
                    if moved.is_empty() {
                        break;
                    }
                }
                if !moved.is_empty() {
                    dialled.insert(format!("{}.{}", kind.code, p.name));
                }
            }
        }
    }
    for must in
        ["CEL.f", "CEL.t60", "STRING.f", "STRING.t60", "MESH.f", "STIFFSTRING.b", "REF.k", "BUT.d", "BOW.f", "SOX.gain"]
    {
        assert!(dialled.contains(must), "{must} was never changed: {dialled:?}");
    }
}

/// What decides the future is in the state: a clone goes on bit by bit, and the hash says so.
#[test]
fn a_snapshot_goes_on_as_if_nothing_had_happened() {
    for (name, text) in texts() {
        let scene = audited(&text);
        let mut s = scene.state();
        let run = |s: &mut State, n: usize| {
            for _ in 0..n {
                gesture(&scene, s);
                tick(&scene, s);
            }
        };
        run(&mut s, 700);
        let mut twin = s.clone();
        assert_eq!(twin.bits(), s.bits());
        run(&mut s, 700);
        assert!(scene.n_mat == 0 || twin.bits() != s.bits(), "{name}: the hash does not see time");
        run(&mut twin, 700);
        assert_eq!(twin.bits(), s.bits(), "{name}");
        assert!(twin == s, "{name}");
    }
}

#[test]
fn blocks_are_ticks() {
    for (name, text) in texts() {
        let scene = with(&text, &Options { kernel: KernelClass::Fast, ..Options::default() });
        let (mut a, mut b) = (scene.state(), scene.state());
        let n = scene.n_out.max(1);
        let mut out = Vec::new();
        for block in [1usize, 3, 64, 100] {
            let mut part = vec![f64::NAN; block * n];
            process(&scene, &mut a, &mut part);
            out.extend(part);
        }
        for frame in out.chunks_exact(n) {
            tick(&scene, &mut b);
            assert!(scene.n_out == 0 || frame == b.output, "{name}");
        }
        assert!(a == b, "{name}");
    }
}

#[test]
fn every_link_of_the_examples_is_known_by_name() {
    for (name, text) in texts() {
        let scene = audited(&text);
        for k in 0..scene.n_lia {
            assert!(scene.audited_name(k).is_some_and(|n| n != "?"), "{name}: link {k}");
        }
        let links = scene.symbols.iter().filter(|s| matches!(s.place, Stands::Lia(..))).count();
        assert_eq!(links, scene.n_lia, "{name}");
    }
}
