//! Kinds without an equation or expansion in the oracle, taken from their catalog record.
//!
//! This compares a new kind from the day it is listed. Its wiring, measuring, schedule and sums are the oracle's own.
//! Its equation comes from the record, which the conformance suite checks; an expansion has a test against its closed
//! form. Refusing kinds without a second definition here would make every new kind an edit in three files of the
//! oracle. The kinds that the oracle knows keep their second definition.

use super::expand::{Family, fixed, mat};
use super::network::{Law, Link, MeasureKind, Network, Past};
use super::numbers::{Numbers, entry, list};
use ca_core::internal::kind::builder::{Arg, Args, Builder, Built, Generator};
use ca_core::internal::op::{loaded, started};
use ca_core::internal::tuning::Scheme;
use ca_core::{Kind, Need, Role, Table, Type};
use ca_model::{Item, Value};

/// A law by its record, with its coefficients, memory and tables.
pub struct Listed {
    law: &'static ca_core::Law,
    c: Vec<f64>,
    /// Memory, from the first elongation on.
    mem: Option<Vec<f64>>,
    tables: Vec<Table>,
}

pub fn kind(i: &Item) -> &'static Kind {
    ca_conformance::random_parameters::catalog().get(&i.kind).unwrap_or_else(|| panic!("no kind {}", i.kind))
}

/// Parameters of a module in the order of its record. Tables are stored apart and referred to by number.
fn args(numbers: &Numbers, i: &Item, tables: &mut Vec<Table>) -> Vec<Arg> {
    let one = |p: &ca_core::Param, tables: &mut Vec<Table>| match (entry(&i.args, p.name), p.ty, p.need) {
        (None, _, Need::Default(v)) => Arg::Num(v),
        (None, ..) | (_, Type::Between | Type::Direction, _) => Arg::Absent,
        (Some(Value::Text(t)), Type::Choice(words), _) => {
            words.iter().position(|w| w == t).map_or(Arg::Absent, |at| Arg::Num(at as f64))
        }
        (_, Type::Points { .. }, _) => {
            let power = if p.name == "friction" || p.name == "points" { -1.0 } else { 0.0 };
            tables.push(Table::new(&numbers.curve(i, p.name, power).expect("points")).expect("a table"));
            Arg::Num((tables.len() - 1) as f64)
        }
        (Some(v @ Value::List(_)), ..) => Arg::List(list(v).iter().map(|e| numbers.value(&e.value, 0.0)).collect()),
        _ => Arg::Num(numbers.num(i, p.name)),
    };
    kind(i).params.iter().map(|p| one(p, tables)).collect()
}

impl Listed {
    pub fn new(numbers: &Numbers, i: &Item) -> Listed {
        let Role::Lia(law) = kind(i).role else { panic!("{} is no law", i.kind) };
        let mut tables = Vec::new();
        let mut p: Vec<Option<f64>> = args(numbers, i, &mut tables).iter().map(Arg::num).collect();
        if let Some(own) = law.table {
            p.push(Some(tables.len() as f64));
            tables.push(own());
        }
        Listed { law, c: loaded(law, &p, numbers.tick_dt), mem: None, tables }
    }

    /// True if it is not measured while nothing touches.
    pub fn passes(&self) -> bool {
        self.law.contact && self.law.mem == 0
    }

    /// Force on the first end, for an elongation e [m] and its change w in the last tick [m].
    pub fn force(&mut self, e: f64, w: f64) -> f64 {
        let mem = self.mem.get_or_insert_with(|| started(self.law, &self.c, e));
        (self.law.fns.force)(&self.c, mem, &self.tables, e, w)
    }
}

/// Expands a generator to plain modules.
pub fn drawn(numbers: &Numbers, net: &mut Network, i: &Item, generator: &Generator) -> Family {
    let (kind, values) = (kind(i), args(numbers, i, &mut Vec::new()));
    let (tick_dt, dim) = (numbers.tick_dt, numbers.axes(i) as u8);
    let args = Args { code: kind.code, params: kind.params, values: &values, tick_dt, dim, scheme: Scheme::Explicit };
    let slots = generator.derived(&args).expect("it can be drawn");
    let mut sketch = Builder::new(&slots, false);
    (generator.build)(&args, &mut sketch).expect("it is drawn");
    let slot = |at: u32| slots.get(at as usize).copied().flatten();
    let mut family = Family { size: sketch.size.map(|n| n as usize), ..Family::default() };
    let mut all = Vec::new();
    for (at, (what, _)) in sketch.mats.iter().enumerate() {
        let new = match *what {
            Built::Mass(m, z) => {
                let m = slot(m).expect("a mass");
                mat(numbers, net, i, m, 1.0 - slot(z).unwrap_or(0.0) * tick_dt / m, 0.0)
            }
            Built::Cell(m, f, t60) => {
                let (a, b) = numbers.heard_at(slot(f).expect("a pitch"), slot(t60).unwrap_or(f64::INFINITY));
                mat(numbers, net, i, slot(m).expect("a mass"), 1.0 - b, -a)
            }
            Built::Fixed | Built::Anchor => fixed(numbers, net, i),
        };
        if let Some(p) = sketch.places.get(at) {
            (0..3).for_each(|k| net.mats[new].rest[k] += p[k]);
        }
        if let Some(v) = sketch.speeds.get(at) {
            net.mats[new].d = v.map(|v| v * tick_dt);
        }
        if *what == Built::Anchor {
            family.ends.push(new);
        } else {
            family.masses.push(new);
        }
        all.push(new);
    }
    for l in &sketch.links {
        let ends = l.ends.map(|e| all[e as usize]);
        let (k, z) = (slot(l.k).unwrap_or(0.0), slot(l.z).unwrap_or(0.0) / tick_dt);
        let apart = [0, 1, 2].map(|k| net.mats[ends[1]].rest[k] - net.mats[ends[0]].rest[k]);
        let length = apart.iter().map(|v| v * v).sum::<f64>().sqrt();
        let (measure, e0) = if dim == 1 {
            (MeasureKind::Line([0, 0]), 0.0)
        } else {
            (MeasureKind::Radial(apart, 0.0, Past::Stored(None)), -l.l0.unwrap_or(length))
        };
        family.links.push(net.links.len());
        net.links.push(Link { ports: vec![(ends, measure)], e0, law: Law::Linear { k, z }, f: 0.0 });
    }
    family.nodes = sketch.nodes.iter().map(|n| all[*n as usize]).collect();
    family
}
