//! Compiles kinds with random parameters for the other files.

use crate::felt;
use crate::models;
use crate::play::{Random, model};
use ca_compile::Compiled;
use ca_compile::{Options, compile};
use ca_core::{Catalog, Kind, Law, Need, Role, Scene, Table, Type, Unit};
use ca_model::{Entry, Model, Value, read, render};

/// The whole catalog and the test kind of [`felt`].
pub fn catalog() -> Catalog {
    models::catalog().with(&[&felt::KIND])
}

/// Name and text of every model, and of the example of that kind.
pub fn texts() -> Vec<(String, String)> {
    let mut all = models::texts();
    all.push((format!("example of {}", felt::KIND.code), felt::KIND.example.into()));
    all
}

/// Reads the model in `text` with the kinds of [`catalog`].
///
/// # Panics
/// If it has errors.
pub fn read(text: &str) -> Model {
    let (model, diags) = read::read(text, "test.ca.toml", &catalog());
    assert!(!diags.has_errors(), "{}", render::text(&diags, &model, false));
    model
}

/// All laws with their kinds.
///
/// # Panics
/// If there are fewer than 12.
pub fn laws() -> Vec<(&'static Kind, &'static Law)> {
    let list: Vec<_> =
        catalog().iter().filter_map(|k| if let Role::Lia(l) = k.role { Some((k, l)) } else { None }).collect();
    assert!(list.len() >= 12);
    list
}

/// Every law with each of its methods, the explicit one first.
///
/// # Panics
/// If there are fewer than six methods besides the explicit one.
pub fn methods() -> Vec<(&'static Kind, &'static str)> {
    let words = |k: &Kind| match k.param("method").map(|i| k.params[i].ty) {
        Some(Type::Choice(words)) => words,
        _ => &["ca"],
    };
    let all: Vec<_> = laws().into_iter().flat_map(|(k, _)| words(k).iter().map(move |w| (k, *w))).collect();
    assert!(all.len() >= laws().len() + 6);
    all
}

/// Adds a method other than the first, and the only curve that it supports.
fn by(way: &str, args: &mut Vec<Entry>) {
    if way == "set-valued" {
        args.retain(|e| !matches!(e.key.as_str(), "curve" | "points" | "f" | "fd"));
        args.extend([Entry::new("curve", "coulomb"), Entry::new("f", 0.3), Entry::new("fd", 0.2)]);
    }
    if way != "ca" {
        args.push(Entry::new("method", way));
    }
}

/// Draws a value for a parameter of a link, as it would be written, in the usual range of an instrument.
///
/// # Panics
/// If no size is known for the unit.
pub fn written(unit: Unit, (min, max): (f64, f64), rng: &mut Random) -> f64 {
    let u = 0.5 * (rng.uniform() + 1.0);
    let size = |lo: i32, hi: i32| 10f64.powf(f64::from(lo) + u * f64::from(hi - lo));
    let v = match unit.symbol {
        "N/m" => size(0, 4),
        "N s/m" | "s" => size(-4, -1),
        "m" => size(-4, -3),
        "N" | "m/s" => size(-2, 0),
        "N/m^3" => size(4, 9),
        "N/m^2" => size(3, 7),
        "" | "s/m" => u,
        other => panic!(
            "no size is known of a parameter in `{other}`: add to this list, `written` in {}, from … to where a link of an \
             instrument has it (powers of ten), so that forces that are drawn are some newtons",
            file!()
        ),
    };
    v.clamp(min, max)
}

/// Draws the parameters of a link within their ranges; tables rise, so that they resist.
pub fn args(kind: &Kind, rng: &mut Random) -> Vec<Entry> {
    let mut out = Vec::new();
    let chosen = |set: &'static [&'static [&'static str]], roll: f64| set[usize::from(roll > 0.0) % set.len()];
    let sets: Vec<_> = kind.one_of.iter().map(|o| (o.sets, chosen(o.sets, rng.uniform()))).collect();
    for p in kind.params {
        let mentioned = sets.iter().find(|(all, _)| all.iter().any(|s| s.contains(&p.name)));
        if mentioned.is_some_and(|(_, set)| !set.contains(&p.name)) {
            continue;
        }
        // the ends of the drawn link are on a line, and other methods are not explicit laws
        if matches!(p.name, "soften" | "method" | "theta") {
            continue;
        }
        let table = |t: &Type| matches!(t, Type::Points { .. });
        let only = table(&p.ty)
            && kind.params.iter().rfind(|q| table(&q.ty)).is_some_and(|q| q.name == p.name)
            && !out.iter().any(|e: &Entry| matches!(e.value, Value::List(_)));
        if mentioned.is_none() && p.need == Need::Optional && p.name != "l0" && !only && rng.uniform() > 0.6 {
            continue;
        }
        let value: Value = match p.ty {
            Type::Number { .. } if p.name == "p" => (0.25 * (4.0 + (4.0 * (rng.uniform() + 1.0)).floor())).into(),
            // a rest length would only shift the elongation, which is drawn anyway
            Type::Number { .. } if p.name == "l0" => 0.0.into(),
            Type::Number { unit, min, max } => written(unit, (min, max), rng).into(),
            Type::PowerStiffness { .. } => written(Unit::STIFFNESS, (0.0, f64::MAX), rng).into(),
            Type::Choice(words) if p.name == "curve" => {
                let table = sets.iter().any(|(_, s)| s.contains(&"points"));
                let i = ((rng.uniform() + 1.0) * 1.5) as usize;
                words[if table { words.len() - 1 } else { i.min(words.len() - 2) }].into()
            }
            Type::Choice(words) => words[usize::from(rng.uniform() > 0.0) % words.len()].into(),
            Type::Flag => (rng.uniform() > 0.0).into(),
            Type::Points { .. } => {
                let (x, y) = (1e-3 * (2.0 + rng.uniform()), 2.0 + rng.uniform());
                let row = |a: f64, b: f64| Value::from(vec![a, b]);
                vec![row(-2.0 * x, -3.0 * y), row(-x, -y), row(0.0, 0.0), row(1.5 * x, 0.5 * y), row(4.0 * x, 2.0 * y)]
                    .into()
            }
            _ => continue,
        };
        out.push(Entry::new(p.name, value));
    }
    // the friction of a bow falls only after it has risen
    let num = |key: &str| {
        out.iter().find(|e| e.key == key).and_then(|e| if let Value::Num(v) = e.value { Some(v) } else { None })
    };
    if let (Some(v0), Some(v1)) = (num("v0"), num("v1")) {
        out.iter_mut().filter(|e| e.key == "v1").for_each(|e| e.value = (v0 + v1).into());
    }
    out
}

/// Fixes the second port of a quadripole at two fixed points, which leaves the plain link.
pub fn held(kind: &Kind, m: &mut Model, args: &mut Vec<Entry>) {
    if kind.param("onto").is_some() {
        m.add("SOL", "north", []);
        m.add("SOL", "south", []);
        args.push(Entry::new("onto", Value::from(vec!["north", "south"])));
    }
}

/// `low` and `high` joined by one link of this kind.
pub fn pair(kind: &Kind, way: &str, rng: &mut Random) -> Model {
    let mut m = model("[MAS]\nlow = { m = 1 }\nhigh = { m = 2 }\n[SOX]\nout = { from = \"low\" }\n");
    let mut list = args(kind, rng);
    by(way, &mut list);
    held(kind, &mut m, &mut list);
    list.push(Entry::new("between", Value::from(vec!["low", "high"])));
    m.add(kind.code, "link", list);
    m
}

/// Compiles a model with the kinds of [`catalog`].
///
/// # Panics
/// If it has errors.
pub fn built(m: &Model, options: &Options) -> Compiled {
    compile(m, &catalog(), options).unwrap_or_else(|d| panic!("{d}\n{}", ca_model::write::write(m)))
}

/// A law from a compiled scene, with its coefficients, memory and tables.
pub struct Loaded {
    /// The law.
    pub law: &'static Law,
    /// Its coefficients.
    pub c: Vec<f64>,
    /// Its memory.
    pub mem: Vec<f64>,
    /// Tables of the scene.
    pub tables: Vec<Table>,
    /// The model as text.
    pub named: String,
}

impl Loaded {
    /// A link with drawn parameters.
    pub fn new(kind: &Kind, rng: &mut Random) -> Loaded {
        let m = pair(kind, "ca", rng);
        let mut l = Loaded::first(&built(&m, &Options::default()));
        l.named = ca_model::write::write(&m);
        l
    }
    /// The first link of a scene.
    ///
    /// # Panics
    /// If the scene has no link.
    pub fn first(scene: &Scene) -> Loaded {
        let s = scene.state();
        let op = scene.passes.forces.iter().find(|o| o.law.is_some()).expect("a link");
        let law = op.law.expect("a law");
        let c: Vec<f64> = (0..law.coefs).map(|k| s.coef[op.coef + k * op.n]).collect();
        let (mem, tables) = (vec![0.0; law.mem], scene.tables.clone());
        let mut l = Loaded { law, c, mem, tables, named: String::new() };
        l.start(0.0);
        l
    }
    /// Starts at the elongation `e` \[m\].
    pub fn start(&mut self, e: f64) {
        (self.law.fns.start)(&self.c, [e, 0.0], &mut self.mem);
    }
    /// Force \[N\] at the elongation `e` after a step of `w` \[m\].
    pub fn force(&mut self, e: f64, w: f64) -> f64 {
        (self.law.fns.force)(&self.c, &mut self.mem, &self.tables, e, w)
    }
    /// Energy \[J\] at the elongation `e`.
    pub fn stored(&self, e: f64) -> f64 {
        (self.law.fns.energies.stored)(&self.c, &self.mem, &self.tables, e, e)
    }
}

/// True if the first link stores no energy at any elongation and its force is known before its ends move.
pub fn only_resists(scene: &Scene) -> bool {
    let mut l = Loaded::first(scene);
    let late = !l.law.stage.is_explicit();
    // a pluck that begins disengaged stores nothing until it is reached
    let way = |i: i32| 1e-2 * (f64::from(i) * std::f64::consts::TAU / 2000.0).sin();
    l.start(0.0);
    let reaches = (1..=4000).any(|i| {
        l.force(way(i), way(i) - way(i - 1));
        l.stored(way(i)) != 0.0
    });
    !late
        && !reaches
        && ![-1e-2, -1e-3, -1e-4, -1e-5, 1e-5, 1e-4, 1e-3, 1e-2].into_iter().any(|e| {
            l.start(e);
            l.stored(e) != 0.0
        })
}

/// Number of masses of [`row`].
pub const MASSES: u32 = 12;

/// A row of masses joined by links of one law, long enough for a run, and one link across, so that batches hold a run
/// and a loose link.
pub fn row(kind: &Kind, way: &str, apart: bool, rng: &mut Random) -> Model {
    let mut m = model("[SOX]\nout = { from = \"m3\" }\n");
    for i in 0..MASSES {
        let x = if apart { 1e-4 * f64::from(i) } else { 0.0 };
        let own = [
            Entry::new("m", 0.5 + 0.1 * f64::from(i)),
            Entry::new("x", x),
            Entry::new("dx0", 1e-3 * rng.uniform()),
            Entry::new("v", 0.1 * rng.uniform()),
        ];
        m.add("MAS", &format!("m{i}"), own);
    }
    let mut list = args(kind, rng);
    by(way, &mut list);
    held(kind, &mut m, &mut list);
    for (k, (a, b)) in (1..MASSES).map(|i| (i - 1, i)).chain([(0, 3)]).enumerate() {
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
