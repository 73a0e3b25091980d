//! Reads values as numbers in SI: units, ranges, named parameters, tables.
//!
//! A bare number is in the units of the model, a quantity in its written unit. Both are checked against the dimension
//! of their place. A `[param]` without a unit takes the dimension of the place where it is used.

use crate::findings::{bad_quantity, instead, quoted, range_help, type_name, unit_in_sentence, unit_span, wrong_unit};
use crate::lower::parsed_param::{ParsedParam, Raw};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_core::internal::kind::alg_to_si;
use ca_core::internal::kind::builder::Arg;
use ca_core::internal::kind::cloud::Clouds;
use ca_core::{Dim, Kind, Need, Param, Table, Type, Unit};
use ca_model::diag::{Diag, Diags};
use ca_model::quantity;
use ca_model::quantity::Plain;
use ca_model::suggest::nearest;
use ca_model::{Entry, Span, Value};
use hashbrown::HashMap;

/// A number and, if it follows a live parameter, the index of that parameter and the factor.
pub type Followed = (f64, Option<(usize, f64)>);

/// Reader of the values of one model.
pub struct Values<'a> {
    /// Tick of the reference rate for `alg` units; `None` in SI.
    pub alg: Option<f64>,
    /// Parameters, set by [`Values::name`].
    pub named: Vec<ParsedParam>,
    /// Index of each parameter by name.
    pub(super) index: HashMap<String, usize>,
    /// Contents of files.
    pub clouds: Clouds,
    /// Tables read so far.
    pub tables: Vec<Table>,
    /// Findings.
    pub diags: &'a mut Diags,
}

impl<'a> Values<'a> {
    /// Creates a reader without named parameters.
    pub fn new(alg: Option<f64>, diags: &'a mut Diags) -> Values<'a> {
        Values { alg, named: Vec::new(), index: HashMap::new(), clouds: Clouds::new(), tables: Vec::new(), diags }
    }
}

impl Values<'_> {
    /// Sets the named parameters.
    pub fn name(&mut self, named: Vec<ParsedParam>) {
        // Of two parameters with the same name, which is reported, the first counts.
        self.index = named.iter().enumerate().rev().map(|(i, n)| (n.name.clone(), i)).collect();
        self.named = named;
    }

    /// Returns the factor from a bare number of dimension `dim` to SI.
    fn bare(&self, dim: Dim) -> f64 {
        self.alg.map_or(1.0, |tr| alg_to_si(dim, tr))
    }

    /// Reads a quantity in SI, if it has the dimension of `unit`; `what` names the place in findings.
    fn measured(&mut self, text: &str, unit: Unit, e: &Entry, what: &str) -> Option<f64> {
        match quantity::parse(text) {
            // 0 needs no unit.
            Ok(q) if !q.has_unit && (unit.dim.same(Unit::NONE.dim) || q.value == 0.0) => Some(q.value),
            Ok(q) if !q.has_unit => {
                let d = Diag::error("E008", format!("{what} has no unit: `{}`", text.trim()));
                let d =
                    d.at(e.span, format!("a number in quotes needs its unit, here {}", unit_in_sentence(unit.symbol)));
                let new = format!("\"{} {}\"", text.trim(), unit.symbol);
                self.diags.push(d.help("write the unit, or leave out the quotes").fix(e.span, new));
                None
            }
            Ok(q) if q.dim.same(unit.dim) => Some(q.value),
            Ok(q) => {
                let d = wrong_unit(what, unit.symbol, &quantity::unit_of(q.dim), unit_span(e, text));
                let d = instead(d, text, &q, unit, e);
                self.diags.push(d);
                None
            }
            Err(err) => {
                let d = bad_quantity(what, e, text, &err, Some(unit));
                self.diags.push(self.near_parameter(d, what, text, &err));
                None
            }
        }
    }

    /// Reads a number of dimension `unit` within `min ..= max`, or a named parameter.
    pub fn number(&mut self, e: &Entry, unit: Unit, range: (f64, f64), what: &str) -> Option<Followed> {
        let followed = match &e.value {
            Value::Num(v) => (*v * self.bare(unit.dim), None),
            Value::Text(t) if quantity::is_quantity(t) => match self.product(t) {
                Some((factor, name)) => (self.scaled(factor, name, unit, e, what)?, None),
                None => (self.measured(t, unit, e, what)?, None),
            },
            // A parameter takes precedence over a note of the same name.
            Value::Text(t) => match quantity::note(t).filter(|_| unit.dim.same(Unit::HERTZ.dim)) {
                Some(f) if !self.index.contains_key(t) => (f, None),
                _ => self.named_number(t, unit, range, e, what)?,
            },
            other => {
                let title = format!("{what} must be a number, not {}", type_name(other));
                let help = format!("write e.g. `{}`, or the name of a `[param]`", quoted(unit));
                self.diags.push(Diag::error("E006", title).at(e.span, "not a number").help(help));
                return None;
            }
        };
        self.in_range(followed.0, unit, range, e, what).then_some(followed)
    }

    fn in_range(&mut self, v: f64, unit: Unit, (min, max): (f64, f64), e: &Entry, what: &str) -> bool {
        if v >= min && v <= max {
            return true;
        }
        let show = |v: f64| {
            if unit.symbol.is_empty() { format!("{}", Plain(v)) } else { quantity::show(v, unit) }
        };
        let written = match &e.value {
            Value::Text(t) if quantity::is_quantity(t) && self.product(t).is_none() => t.trim().into(),
            _ => show(v),
        };
        let mut d = Diag::error("E009", format!("{what} is out of range: {written}")).at(e.span, "out of range");
        if let Value::Text(t) = &e.value {
            let name = self.product(t).map_or(t.as_str(), |p| p.1);
            if let Some(n) = self.index.get(name).map(|i| &self.named[*i]) {
                d = d.at(n.value_span, "from here");
            }
        }
        let help = if v.is_finite() { range_help(min, max, show) } else { "use a finite number".into() };
        self.diags.push(d.help(help));
        false
    }

    /// Returns the value of parameter `name` for a place of unit `unit`.
    pub(super) fn named_number(
        &mut self,
        name: &str,
        unit: Unit,
        range: (f64, f64),
        e: &Entry,
        what: &str,
    ) -> Option<Followed> {
        let Some(i) = self.index.get(name).copied() else {
            let d = Diag::error("E013", format!("{what}: `{name}` is neither a number nor a name in `[param]`"))
                .at(e.span, "not in `[param]`");
            let near = nearest(
                name.trim_start_matches('$'),
                self.named.iter().filter(|n| n.value.is_some()).map(|n| n.name.as_str()),
            );
            let near = near.map(ToString::to_string);
            let note = || quantity::near_note(name).filter(|_| unit.dim.same(Unit::HERTZ.dim));
            self.diags.push(match near.or_else(note) {
                Some(near) => d.help(format!("did you mean `{near}`?")).fix(e.span, format!("\"{near}\"")),
                None if unit.dim.same(Unit::HERTZ.dim) => d.help(
                    "declare it under `[param]`, or write a value such as `\"440 Hz\"` or a note such as `\"A4 +5 c\"`",
                ),
                None => d.help(format!("declare it under `[param]`, or write a value such as `{}`", quoted(unit))),
            });
            return None;
        };
        let factor = match self.named[i].value? {
            Raw::Quantity(q) if q.has_unit && q.dim.same(unit.dim) => 1.0,
            Raw::Quantity(q) if q.has_unit => {
                let is = quantity::unit_of(q.dim);
                let d = wrong_unit(what, unit.symbol, &is, e.span).at(self.named[i].value_span, "declared here");
                self.diags.push(d.help(format!(
                    "give `{name}` in {}, or use another parameter here",
                    unit_in_sentence(unit.symbol)
                )));
                return None;
            }
            _ => self.bare(unit.dim),
        };
        let n = &mut self.named[i];
        match &mut n.used {
            // The ranges of all places of use are intersected.
            Some((u, min, max)) if u.dim.same(unit.dim) => (*min, *max) = (min.max(range.0), max.min(range.1)),
            Some(_) => {}
            none => *none = Some((unit, range.0, range.1)),
        }
        Some((n.value?.number() * factor, n.live.then_some((i, factor))))
    }

    /// Reads a number that must not follow a live parameter.
    pub fn constant(&mut self, e: &Entry, unit: Unit, range: (f64, f64), what: &str) -> Option<f64> {
        let (v, follows) = self.number(e, unit, range, what)?;
        if let Some((i, _)) = follows {
            let d = Diag::error("E025", format!("{what} cannot change while playing"))
                .at(e.span, "names a live parameter")
                .at(self.named[i].span, "live here")
                .help("write the number itself, or remove `live` from the parameter");
            self.diags.push(d);
            return None;
        }
        Some(v)
    }

    /// Returns the exponent `name` of a power law from the arguments of its module. Returns `None` if it is wrong,
    /// which is reported when that argument itself is read.
    fn exponent(&self, kind: &Kind, name: &str, siblings: &[Entry]) -> Option<f64> {
        let p = match siblings.iter().find(|s| s.key == name).map(|s| &s.value) {
            None => match kind.param(name).map(|i| kind.params[i].need) {
                Some(Need::Default(p)) => p,
                _ => return None,
            },
            Some(Value::Num(p)) => *p,
            Some(Value::Text(t)) if quantity::is_quantity(t) => match self.product(t) {
                Some((factor, name)) => factor * self.named[*self.index.get(name)?].value?.number(),
                None => quantity::parse(t).ok()?.value,
            },
            Some(Value::Text(t)) => self.named[*self.index.get(t)?].value?.number(),
            Some(_) => return None,
        };
        (quarters(p) && (1.0..=5.0).contains(&p)).then_some(p)
    }

    /// Reads a parameter of a group or of the model by its bare name.
    pub fn word(&mut self, param: &Param, e: &Entry, owner: &str) -> Option<f64> {
        self.arg(&ca_core::internal::phi::REF, param, e, &[], owner)?.0.num()
    }

    /// Returns a plain number of the right dimension within its range; `None` for anything else, right or wrong.
    fn plain(&self, kind: &Kind, param: &Param, e: &Entry) -> Option<f64> {
        let Type::Number { unit, min, max } = param.ty else { return None };
        let v = match &e.value {
            Value::Num(v) => *v * self.bare(unit.dim),
            Value::Text(t) if quantity::is_quantity(t) => match quantity::parse(t) {
                Ok(q) if !q.has_unit && unit.dim.same(Unit::NONE.dim) => q.value,
                Ok(q) if q.has_unit && q.dim.same(unit.dim) => q.value,
                _ => return None,
            },
            _ => return None,
        };
        // Exponents have further conditions.
        (v >= min && v <= max && !is_exponent(kind, param)).then_some(v)
    }

    /// Reads the argument `param` of an item.
    pub fn arg(
        &mut self,
        kind: &'static Kind,
        param: &Param,
        e: &Entry,
        siblings: &[Entry],
        owner: &str,
    ) -> Option<(Arg, Option<(usize, f64)>)> {
        // Fast path: most arguments are plain numbers in range.
        if let Some(v) = self.plain(kind, param, e) {
            return Some((Arg::Num(v), None));
        }
        let what = format!("`{}` of `{owner}`", param.name);
        let plain = |v: f64| Some((Arg::Num(v), None));
        match param.ty {
            Type::Number { unit, min, max } => {
                if !is_exponent(kind, param) {
                    if !param.live {
                        return plain(self.constant(e, unit, (min, max), &what)?);
                    }
                    let (v, follows) = self.number(e, unit, (min, max), &what)?;
                    return Some((Arg::Num(v), follows));
                }
                // The unit of the stiffness depends on the exponent, which must therefore be constant.
                let v = self.constant(e, unit, (min, max), &what)?;
                if !quarters(v) {
                    let near = libm::round(v * 4.0) / 4.0;
                    let d = Diag::error("E009", format!("{what} is not a multiple of 1/4: {}", Plain(v)))
                        .at(e.span, "the tick computes only products and square roots");
                    self.diags.push(d.help(format!("the nearest is {near}")).fix(e.span, format!("{near}")));
                    return None;
                }
                plain(v)
            }
            Type::PowerStiffness { exponent } => {
                let p = self.exponent(kind, exponent, siblings)?;
                let unit = Unit::power_stiffness(p);
                let (v, follows) = self.number(e, unit, ca_core::POSITIVE, &what)?;
                Some((Arg::Num(v), follows))
            }
            Type::Count { min, max } => plain(self.count(e, (min, max), &what)?),
            Type::Choice(words) => match &e.value {
                Value::Text(t) if words.contains(&t.as_str()) => {
                    plain(words.iter().position(|w| w == t).unwrap_or(0) as f64)
                }
                Value::Text(t) => {
                    let list = words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ");
                    let mut d = Diag::error("E011", format!("{what} cannot be `{t}`")).at(e.span, "not a choice");
                    d = match nearest(t, words.iter().copied()) {
                        Some(near) => d.help(format!("did you mean `{near}`?")).fix(e.span, format!("\"{near}\"")),
                        None => d.help(format!("choose one of {list}")),
                    };
                    self.diags.push(d);
                    None
                }
                other => {
                    let list = words.iter().map(|w| format!("`\"{w}\"`")).collect::<Vec<_>>().join(", ");
                    self.wrong_type(&what, "a word in quotes", other, e.span, &format!("choose one of {list}"))
                }
            },
            Type::Flag => match e.value {
                Value::Bool(b) => plain(f64::from(u8::from(b))),
                ref other => self.wrong_type(&what, "`true` or `false`", other, e.span, "write it without quotes"),
            },
            Type::Numbers { unit, min, max } => match &e.value {
                Value::List(list) if list.is_empty() => {
                    let d = Diag::error("E006", format!("{what} is an empty list")).at(e.span, "no number");
                    self.diags.push(d.help(format!("write one number or more, e.g. `[{}]`", quoted(unit))));
                    None
                }
                Value::List(list) => {
                    let read: Vec<_> = list.iter().map(|x| self.constant(x, unit, (min, max), &what)).collect();
                    read.into_iter().collect::<Option<Vec<f64>>>().map(|l| (Arg::List(l), None))
                }
                _ => self.number(e, unit, (min, max), &what).map(|(v, f)| (Arg::Num(v), f)),
            },
            Type::Points { x, y } => {
                let points = self.points(e, x, y, &what)?;
                let Some(table) = Table::new(&points) else {
                    self.not_a_table(e, &points, x, &what);
                    return None;
                };
                self.tables.push(table);
                plain(self.tables.len() as f64 - 1.0)
            }
            Type::Position { unit } => self.position(e, unit, &what).map(|a| (a, None)),
            Type::Direction => self.direction(e, &what).map(|a| (a, None)),
            Type::Counts { min, max } => match &e.value {
                Value::List(list) => {
                    let read: Vec<_> = list.iter().map(|x| self.count(x, (min, max), &what)).collect();
                    read.into_iter().collect::<Option<Vec<f64>>>().map(|l| (Arg::List(l), None))
                }
                _ => self.count(e, (min, max), &what).map(|v| (Arg::Num(v), None)),
            },
            Type::Nodes => self.nodes(e, &what).map(|list| (Arg::List(list), None)),
            Type::File => self.file(e, &what).map(|a| (a, None)),
            Type::Positions { unit } => self.positions(e, unit, &what).map(|l| (Arg::List(l), None)),
            // Structure, read elsewhere.
            Type::Between | Type::Module | Type::Text | Type::Midi => Some((Arg::Absent, None)),
        }
    }

    fn not_a_table(&mut self, e: &Entry, points: &[[f64; 2]], x: Unit, what: &str) {
        let Value::List(list) = &e.value else { return };
        if let Some(i) = (1..points.len()).find(|i| points[*i][0] <= points[i - 1][0]) {
            let show = |i: usize| quantity::show(points[i][0], x);
            let title = format!("{what}: the first numbers must increase, but {} follows {}", show(i), show(i - 1));
            let d = Diag::error("E019", title)
                .at(list[i].span, "does not increase")
                .at(list[i - 1].span, "the point before");
            self.diags.push(d.help("write the points in increasing order, each first number once"));
            return;
        }
        let many = ["no point", "one point"].get(points.len()).copied().unwrap_or("too few points");
        let d = Diag::error("E019", format!("{what} has {many}, but a table needs two")).at(e.span, "not a table");
        let d = d.help("write `[[x, y], [x, y], …]` with x increasing; beyond the ends, the last value applies");
        self.diags.push(d);
    }

    pub(super) fn wrong_type<T>(&mut self, what: &str, wanted: &str, is: &Value, span: Span, help: &str) -> Option<T> {
        let title = format!("{what} must be {wanted}, not {}", type_name(is));
        self.diags.push(Diag::error("E006", title).at(span, "wrong type").help(help));
        None
    }
}

fn is_exponent(kind: &Kind, param: &Param) -> bool {
    kind.params.iter().any(|p| matches!(p.ty, Type::PowerStiffness { exponent } if exponent == param.name))
}

fn quarters(p: f64) -> bool {
    p * 4.0 == libm::round(p * 4.0)
}
