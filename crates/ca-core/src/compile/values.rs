//! Values: from what is written to numbers in SI: units, ranges, named parameters, tables, MIDI mappings.
//!
//! Decides that a bare number is in the model's units and a quantity in its own, that both are checked against the
//! dimension of the place they stand in, and that a `[param]` without a unit takes the dimension of where it is used.

use crate::generate::Arg;
use crate::io::midi::{MidiMap, MidiSource};
use crate::kind::{Dim, Kind, Need, Param, Type, Unit};
use crate::model::diag::{Diag, Diags};
use crate::model::quantity::{self, Quantity};
use crate::model::suggest::nearest;
use crate::model::{Entry, Span, Value};
use crate::table::Table;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// A number as written in `[param]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Raw {
    /// in the model's units, whatever the dimension
    Bare(f64),
    /// with its unit
    Quantity(Quantity),
}

/// A `[param]`.
#[derive(Clone, Debug)]
pub struct Named {
    /// its name
    pub name: String,
    /// its value
    pub value: Raw,
    /// may change while playing
    pub live: bool,
    /// smallest value while playing
    pub min: Option<Raw>,
    /// largest value while playing
    pub max: Option<Raw>,
    /// one line
    pub doc: String,
    /// where it stands
    pub span: Span,
    /// where it was first used: unit and range of that place
    pub used: Option<(Unit, f64, f64)>,
}

/// A number and, if it follows a live parameter, which one and by what factor.
pub type Followed = (f64, Option<(usize, f64)>);

/// Reads values of one model.
pub struct Values<'a> {
    /// tick of the reference rate for `alg` units; `None` in SI
    pub alg: Option<f64>,
    /// the parameters
    pub named: Vec<Named>,
    /// tables met so far
    pub tables: Vec<Table>,
    /// findings
    pub diags: &'a mut Diags,
}

impl Values<'_> {
    /// Factor from a bare number of dimension `dim` to SI.
    fn bare(&self, dim: Dim) -> f64 {
        self.alg.map_or(1.0, |tr| dim.alg_to_si(tr))
    }

    /// A quantity in SI, if its dimension is that of `unit`; `what` names the place for the report.
    fn measured(&mut self, text: &str, unit: Unit, e: &Entry, what: &str) -> Option<f64> {
        match quantity::parse(text) {
            Ok(q) if !q.has_unit => Some(q.value * self.bare(unit.dim)),
            Ok(q) if q.dim.same(unit.dim) => Some(q.value),
            Ok(q) => {
                let is = quantity::unit_of(q.dim);
                self.diags.push(wrong_unit(what, unit, &is, e.span));
                None
            }
            Err(err) => {
                let inside = |at: usize| if e.span.is_some() { (e.span.start + 1 + at).min(e.span.end) } else { at };
                let span = if e.span.is_some() {
                    Span { start: inside(err.at), end: inside(err.end.max(err.at + 1)) }
                } else {
                    Span::NONE
                };
                let help = format!("write a number and its unit, e.g. `\"{}\"`", example(unit));
                self.diags
                    .push(Diag::error("E007", format!("{what}: not a quantity")).at(span, err.message).help(help));
                None
            }
        }
    }

    /// A number of dimension `unit` within `min ..= max`, or a named parameter.
    pub fn number(&mut self, e: &Entry, unit: Unit, range: (f64, f64), what: &str) -> Option<Followed> {
        let followed = match &e.value {
            Value::Num(v) => (*v * self.bare(unit.dim), None),
            Value::Text(t) if quantity::is_quantity(t) => (self.measured(t, unit, e, what)?, None),
            Value::Text(t) => self.named_number(t, unit, range, e, what)?,
            other => {
                let title = format!("{what} must be a number, not {}", type_name(other));
                let help = format!("write e.g. `\"{}\"`, or the name of a `[param]`", example(unit));
                self.diags.push(Diag::error("E006", title).at(e.span, "not a number").help(help));
                return None;
            }
        };
        self.in_range(followed.0, unit, range, e.span, what).then_some(followed)
    }

    fn in_range(&mut self, v: f64, unit: Unit, (min, max): (f64, f64), span: Span, what: &str) -> bool {
        if v >= min && v <= max {
            return true;
        }
        let show = |v: f64| quantity::show(v, unit);
        let help = if !v.is_finite() || (min == f64::MIN && max == f64::MAX) {
            "use a finite number".into()
        } else if max == f64::MAX && min == f64::MIN_POSITIVE {
            "use a value above 0".into()
        } else if max == f64::MAX {
            format!("use {} or more", show(min))
        } else {
            format!("use a value from {} to {}", show(min), show(max))
        };
        let title = format!("{what} is out of range: {}", show(v));
        self.diags.push(Diag::error("E009", title).at(span, "out of range").help(help));
        false
    }

    fn named_number(&mut self, name: &str, unit: Unit, range: (f64, f64), e: &Entry, what: &str) -> Option<Followed> {
        let Some(i) = self.named.iter().position(|n| n.name == name) else {
            let mut d = Diag::error("E013", format!("{what}: no parameter `{name}`")).at(e.span, "not in `[param]`");
            match nearest(name, self.named.iter().map(|n| n.name.as_str())) {
                Some(near) => d = d.help(format!("did you mean `{near}`?")).fix(e.span, format!("\"{near}\"")),
                None => {
                    d = d.help(format!(
                        "declare it under `[param]`, or write a quantity such as `\"{}\"`",
                        example(unit)
                    ));
                }
            }
            self.diags.push(d);
            return None;
        };
        let factor = match self.named[i].value {
            Raw::Bare(_) => self.bare(unit.dim),
            Raw::Quantity(q) if !q.has_unit => self.bare(unit.dim),
            Raw::Quantity(q) if q.dim.same(unit.dim) => 1.0,
            Raw::Quantity(q) => {
                let is = quantity::unit_of(q.dim);
                let d = wrong_unit(what, unit, &is, e.span).at(self.named[i].span, "declared here");
                self.diags.push(d);
                return None;
            }
        };
        let raw = |r: Raw| match r {
            Raw::Bare(v) => v,
            Raw::Quantity(q) => q.value,
        };
        let n = &mut self.named[i];
        n.used.get_or_insert((unit, range.0, range.1));
        Some((raw(n.value) * factor, n.live.then_some((i, factor))))
    }

    /// A plain number that cannot follow anything.
    fn constant(&mut self, e: &Entry, unit: Unit, range: (f64, f64), what: &str) -> Option<f64> {
        let (v, follows) = self.number(e, unit, range, what)?;
        if follows.is_some() {
            let d = Diag::error("E025", format!("{what} cannot change while playing"))
                .at(e.span, "names a live parameter")
                .help("write the number itself, or take `live` from the parameter");
            self.diags.push(d);
            return None;
        }
        Some(v)
    }

    /// The exponent written beside a power stiffness; what is wrong with it is reported where it stands.
    fn exponent(&self, value: &Value) -> Option<f64> {
        let raw = match value {
            Value::Num(v) => Raw::Bare(*v),
            Value::Text(t) if quantity::is_quantity(t) => Raw::Quantity(quantity::parse(t).ok()?),
            Value::Text(t) => self.named.iter().find(|n| n.name == *t)?.value,
            _ => return None,
        };
        Some(match raw {
            Raw::Bare(v) => v,
            Raw::Quantity(q) => q.value,
        })
    }

    /// The argument `param` of an item.
    pub fn arg(
        &mut self,
        kind: &'static Kind,
        param: &Param,
        e: &Entry,
        siblings: &[Entry],
        owner: &str,
    ) -> Option<(Arg, Option<(usize, f64)>)> {
        let what = format!("`{}` of `{owner}`", param.name);
        let plain = |v: f64| Some((Arg::Num(v), None));
        match param.ty {
            Type::Number { unit, min, max } => {
                // where a model starts, lengths and exponents are no coefficients: nothing would follow a change of them
                if matches!(param.name, "x" | "dx0" | "v" | "l0" | "p") {
                    self.constant(e, unit, (min, max), &what)?;
                }
                let (v, follows) = self.number(e, unit, (min, max), &what)?;
                if param.name == "p" && v * 4.0 != libm::round(v * 4.0) {
                    let d = Diag::error("E009", format!("{what} is not a multiple of 1/4: {v}"))
                        .at(e.span, "the tick has only products and square roots")
                        .help(format!("use {}", libm::round(v * 4.0) / 4.0));
                    self.diags.push(d);
                    return None;
                }
                Some((Arg::Num(v), follows))
            }
            Type::PowerStiffness { exponent } => {
                let p = siblings.iter().find(|s| s.key == exponent).map_or_else(
                    || kind.param(exponent).map(|i| kind.params[i].need),
                    |s| self.exponent(&s.value).map(Need::Default),
                );
                let Some(Need::Default(p)) = p else { return plain(0.0) };
                let unit = Unit { symbol: power_symbol(p), dim: Dim::power_stiffness(p) };
                let (v, follows) = self.number(e, unit, crate::kind::POSITIVE, &what)?;
                Some((Arg::Num(v), follows))
            }
            Type::Count { min, max } => {
                let v = self.constant(e, Unit::NONE, (f64::from(min), f64::from(max)), &what)?;
                if v != libm::floor(v) {
                    let d = Diag::error("E006", format!("{what} must be a whole number: {v}")).at(e.span, "not whole");
                    self.diags.push(d);
                    return None;
                }
                plain(v)
            }
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
                other => self.wrong_type(&what, "a word in quotes", other, e.span),
            },
            Type::Flag => match e.value {
                Value::Bool(b) => plain(f64::from(u8::from(b))),
                ref other => self.wrong_type(&what, "`true` or `false`", other, e.span),
            },
            Type::Numbers { unit, min, max } => match &e.value {
                Value::List(list) => {
                    let read: Vec<_> =
                        list.iter().map(|x| self.constant(x, unit, (min, max), &what)).collect::<Vec<_>>();
                    if list.is_empty() {
                        return self.wrong_type(&what, "a list with at least one number", &e.value, e.span);
                    }
                    read.into_iter().collect::<Option<Vec<f64>>>().map(|l| (Arg::List(l), None))
                }
                _ => self.number(e, unit, (min, max), &what).map(|(v, f)| (Arg::Num(v), f)),
            },
            Type::Points { x, y } => {
                let points = self.points(e, x, y, &what)?;
                let Some(table) = Table::new(&points) else {
                    let d = Diag::error("E019", format!("{what} needs at least two points with rising first numbers"))
                        .at(e.span, "not a table")
                        .help("write `[[x, y], [x, y], …]` with x going up");
                    self.diags.push(d);
                    return None;
                };
                self.tables.push(table);
                plain(self.tables.len() as f64 - 1.0)
            }
            // structure, read elsewhere
            Type::Between | Type::Module | Type::Text | Type::Midi => Some((Arg::Absent, None)),
        }
    }

    /// A list of points, each column in its unit.
    pub fn points(&mut self, e: &Entry, x: Unit, y: Unit, what: &str) -> Option<Vec<[f64; 2]>> {
        let Value::List(list) = &e.value else {
            return self.wrong_type(what, "a list of `[x, y]` points", &e.value, e.span);
        };
        let mut points = Vec::with_capacity(list.len());
        let mut good = true;
        for p in list {
            match &p.value {
                Value::List(pair) if pair.len() == 2 => {
                    let a = self.constant(&pair[0], x, crate::kind::ANY, what);
                    let b = self.constant(&pair[1], y, crate::kind::ANY, what);
                    match (a, b) {
                        (Some(a), Some(b)) => points.push([a, b]),
                        _ => good = false,
                    }
                }
                _ => {
                    let d = Diag::error("E019", format!("{what}: a point has two numbers")).at(p.span, "not `[x, y]`");
                    self.diags.push(d);
                    good = false;
                }
            }
        }
        good.then_some(points)
    }

    fn wrong_type<T>(&mut self, what: &str, wanted: &str, is: &Value, span: Span) -> Option<T> {
        let title = format!("{what} must be {wanted}, not {}", type_name(is));
        self.diags.push(Diag::error("E006", title).at(span, "wrong type"));
        None
    }

    /// A MIDI mapping.
    pub fn midi(&mut self, e: &Entry, unit: Unit, owner: &str) -> Option<MidiMap> {
        let what = format!("`midi` of `{owner}`");
        let Value::Table(entries) = &e.value else {
            return self.wrong_type(&what, "a table such as `{ note = \"C4\", to = \"5 mm\" }`", &e.value, e.span);
        };
        let mut map =
            MidiMap { source: MidiSource::PitchBend, channel: None, from: 0.0, to: 0.0, attack: 0.005, release: 0.03 };
        let (mut sources, mut to, mut good) = (0, false, true);
        for m in entries {
            let what = format!("`{}` in {what}", m.key);
            let time = |v: &mut Self| v.constant(m, Unit::SECOND, crate::kind::POSITIVE, &what);
            let done = match m.key.as_str() {
                "note" => notes(m).map(|(low, high)| map.source = MidiSource::Note { low, high }),
                "cc" => small(m, 127).map(|n| map.source = MidiSource::Control(n)),
                "bend" => (m.value == Value::Bool(true)).then(|| map.source = MidiSource::PitchBend),
                "pressure" => (m.value == Value::Bool(true)).then(|| map.source = MidiSource::Pressure),
                "channel" => small(m, 16).filter(|n| *n > 0).map(|n| map.channel = Some(n)),
                "from" => self.constant(m, unit, crate::kind::ANY, &what).map(|v| map.from = v),
                "to" => self.constant(m, unit, crate::kind::ANY, &what).map(|v| map.to = v),
                "attack" => time(self).map(|v| map.attack = v),
                "release" => time(self).map(|v| map.release = v),
                _ => None,
            };
            sources += i32::from(matches!(m.key.as_str(), "note" | "cc" | "bend" | "pressure"));
            to |= m.key == "to";
            if done.is_none() {
                good = false;
                let d = Diag::error("E026", format!("{what} is not understood")).at(m.key_span, "here").help(
                    "use one of note (\"C4\", 60 or [48, 72]), cc (0 to 127), bend = true, pressure = true, \
                     and channel, from, to, attack, release",
                );
                self.diags.push(d);
            }
        }
        if good && (sources != 1 || !to) {
            let title = format!("{what} needs one of `note`, `cc`, `bend`, `pressure`, and `to`");
            self.diags.push(Diag::error("E026", title).at(e.span, "incomplete"));
            return None;
        }
        good.then_some(map)
    }
}

fn small(e: &Entry, max: u8) -> Option<u8> {
    match e.value {
        Value::Num(v) if v == libm::floor(v) && v >= 0.0 && v <= f64::from(max) => Some(v as u8),
        _ => None,
    }
}

/// A note as number or name (C4 = 60), or a range of two.
fn notes(e: &Entry) -> Option<(u8, u8)> {
    match &e.value {
        Value::List(l) if l.len() == 2 => Some((note(&l[0])?, note(&l[1])?)).filter(|(a, b)| a <= b),
        _ => note(e).map(|n| (n, n)),
    }
}

fn note(e: &Entry) -> Option<u8> {
    let Value::Text(t) = &e.value else { return small(e, 127) };
    let mut chars = t.chars();
    let step = match chars.next()?.to_ascii_uppercase() {
        'C' => 0,
        'D' => 2,
        'E' => 4,
        'F' => 5,
        'G' => 7,
        'A' => 9,
        'B' => 11,
        _ => return None,
    };
    let rest = chars.as_str();
    let (sharp, octave) = match rest.chars().next()? {
        '#' | '♯' => (1, &rest[rest.chars().next()?.len_utf8()..]),
        'b' | '♭' => (-1, &rest[rest.chars().next()?.len_utf8()..]),
        _ => (0, rest),
    };
    let number = 12 * (octave.parse::<i32>().ok()?.checked_add(1)?.clamp(-9, 20)) + step + sharp;
    u8::try_from(number).ok().filter(|n| *n < 128)
}

/// The unit of a power law of exponent `p`, a multiple of 1/4 from 1 to 5.
fn power_symbol(p: f64) -> &'static str {
    const SYMBOLS: [&str; 17] = [
        "N/m", "N/m^1.25", "N/m^1.5", "N/m^1.75", "N/m^2", "N/m^2.25", "N/m^2.5", "N/m^2.75", "N/m^3", "N/m^3.25",
        "N/m^3.5", "N/m^3.75", "N/m^4", "N/m^4.25", "N/m^4.5", "N/m^4.75", "N/m^5",
    ];
    SYMBOLS.get(libm::round(4.0 * (p - 1.0)).max(0.0) as usize).copied().unwrap_or("N/m^p")
}

/// A plausible quantity of a unit, for help texts.
pub fn example(unit: Unit) -> String {
    let n = match unit.symbol {
        "m" => "2 mm",
        "kg" => "20 g",
        "s" => "0.5 s",
        "Hz" => "440 Hz",
        "N/m" => "8 kN/m",
        "N s/m" => "0.2 N s/m",
        "m/s" => "0.5 m/s",
        "" => return "1.0".into(),
        other => return format!("1 {other}"),
    };
    n.into()
}

fn wrong_unit(what: &str, unit: Unit, is: &str, span: Span) -> Diag {
    let wants = if unit.symbol.is_empty() { "a plain number" } else { unit.symbol };
    let is = if is.is_empty() { "a plain number" } else { is };
    Diag::error("E008", format!("{what} wants {wants}, this is {is}"))
        .at(span, format!("this is {is}"))
        .help(format!("write e.g. `\"{}\"`", example(unit)))
}

/// What a value is, for people.
pub fn type_name(v: &Value) -> &'static str {
    match v {
        Value::Num(_) => "a number",
        Value::Text(_) => "a text",
        Value::Bool(_) => "true or false",
        Value::List(_) => "a list",
        Value::Table(_) => "a table",
    }
}
