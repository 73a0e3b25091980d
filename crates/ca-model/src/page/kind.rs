//! Page of a kind.

use crate::quantity::show;
use alloc::format;
use alloc::string::{String, ToString as _};
use alloc::vec::Vec;
use ca_core::{Dim, Kind, Need, Param, SOURCES, Type, Unit};
use core::fmt::Write as _;
use serde_json::{Value as Json, json};

/// Width of the text in characters.
const WIDTH: usize = 96;

fn accepts(p: &Param) -> String {
    match p.ty {
        Type::Number { unit, min, max } => number(unit, min, max),
        Type::PowerStiffness { exponent } => format!("[N/m^{exponent}] ≥ 0"),
        Type::Count { min, max } => format!("whole, {min} to {max}"),
        Type::Choice(words) => words.join(" | "),
        Type::Flag => "true | false".into(),
        Type::Numbers { unit, min, max } => format!("{}, one or a list", number(unit, min, max)),
        Type::Position { unit } => format!("[{}], a number per axis", symbol(unit)),
        Type::Direction => "x | y | z | [x, y, z]".into(),
        Type::Counts { min, max } => format!("whole, {min} to {max}, one or a list"),
        Type::Nodes => "list of [i, j]".into(),
        Type::Points { x, y } => format!("list of [{}, {}]", symbol(x), symbol(y)),
        Type::Between => "two modules, or two lists".into(),
        Type::Module => "a module".into(),
        Type::File => "a file".into(),
        Type::Positions { unit } => format!("list of [x, y, z] in [{}]", symbol(unit)),
        Type::Text => "text".into(),
        Type::Midi => "table".into(),
    }
}

fn symbol(u: Unit) -> &'static str {
    if u.symbol.is_empty() { "1" } else { u.symbol }
}

fn number(unit: Unit, min: f64, max: f64) -> String {
    let above = if min == f64::MIN_POSITIVE {
        " > 0".into()
    } else if min == f64::MIN {
        String::new()
    } else {
        format!(" ≥ {}", show(min, unit_for(min, unit)))
    };
    let below = if max == f64::MAX { String::new() } else { format!(" ≤ {}", show(max, unit_for(max, unit))) };
    format!("[{}]{above}{below}", symbol(unit))
}

fn unit_for(v: f64, unit: Unit) -> Unit {
    if v == 0.0 { Unit::NONE } else { unit }
}

fn default(p: &Param) -> String {
    match p.need {
        Need::Required => "required".into(),
        Need::Optional => "optional".into(),
        Need::Default(v) => match p.ty {
            Type::Choice(words) => words.get(v as usize).copied().unwrap_or("?").into(),
            Type::Flag => (v != 0.0).to_string(),
            Type::Number { unit, .. } | Type::Numbers { unit, .. } | Type::Position { unit } => {
                show(v, unit_for(v, unit))
            }
            _ => v.to_string(),
        },
    }
}

/// Breaks a text into lines of at most [`WIDTH`] characters, with `indent` blanks in front.
fn wrap(text: &str, indent: usize) -> String {
    let (mut out, mut line) = (String::new(), String::new());
    let gap = " ".repeat(indent);
    for word in text.split_whitespace() {
        if !line.is_empty() && indent + line.chars().count() + 1 + word.chars().count() > WIDTH {
            let _ = writeln!(out, "{gap}{line}");
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    out + &format!("{gap}{line}\n")
}

fn reference(key: &str) -> &'static str {
    SOURCES.iter().find(|s| s.0 == key).map_or("", |s| s.1)
}

/// Returns the page as text.
pub fn text(k: &Kind) -> String {
    let mut out = format!("{}  {}\n\n    {}\n\n{}", k.code, k.title, k.equation, wrap(k.doc, 0));
    if !k.params.is_empty() {
        out += "\nParameters\n";
        let cells: Vec<[String; 3]> = k.params.iter().map(|p| [p.name.into(), accepts(p), default(p)]).collect();
        let width = |i: usize| cells.iter().map(|c| c[i].chars().count()).max().unwrap_or(0).min(34);
        let (a, b, c) = (width(0), width(1), width(2));
        for (p, [name, accepts, default]) in k.params.iter().zip(&cells) {
            let _ = writeln!(out, "  {name:<a$}  {accepts:<b$}  {default:<c$}  {}", p.doc);
        }
    }
    for o in k.one_of {
        let sets: Vec<String> = o.sets.iter().map(|s| format!("`{}`", s.join("`, `"))).collect();
        let must = if o.required { "one of them is required" } else { "at most one of them" };
        let _ = writeln!(out, "  {}: {must}", sets.join(" or "));
    }
    if !k.source.is_empty() {
        out += "\nSources\n";
        for key in k.source {
            out += &wrap(&format!("[{key}] {}", reference(key)), 2);
        }
    }
    out + &format!("\nExample\n\n{}\n", indent(k.example))
}

fn indent(text: &str) -> String {
    text.trim()
        .lines()
        .map(|l| if l.is_empty() { String::new() } else { format!("    {l}") })
        .collect::<Vec<_>>()
        .join("\n")
}

/// Returns the page as JSON. Ranges are in SI units; a missing limit is `null`.
pub fn json(k: &Kind) -> Json {
    let params: Vec<Json> = k
        .params
        .iter()
        .map(|p| {
            let (unit, min, max) = match p.ty {
                Type::Number { unit, min, max } | Type::Numbers { unit, min, max } => (Some(unit), min, max),
                Type::Position { unit } => (Some(unit), f64::MIN, f64::MAX),
                Type::Count { min, max } | Type::Counts { min, max } => (None, f64::from(min), f64::from(max)),
                Type::PowerStiffness { .. } => (None, 0.0, f64::MAX),
                _ => (None, f64::MIN, f64::MAX),
            };
            let limit = |v: f64| (v.abs() != f64::MAX).then_some(v);
            json!({
                "name": p.name, "accepts": accepts(p), "unit": unit.map(|u| u.symbol),
                "dimension": unit.map(|u| { let Dim { m, kg, s } = u.dim; [m, kg, s] }),
                "min": limit(min), "max": limit(max), "required": p.need == Need::Required,
                "default": if let Need::Default(_) = p.need { Some(default(p)) } else { None }, "doc": p.doc,
            })
        })
        .collect();
    let sources: Vec<Json> = k.source.iter().map(|s| json!({"key": s, "reference": reference(s)})).collect();
    json!({
        "code": k.code, "title": k.title, "equation": k.equation, "doc": k.doc, "parameters": params,
        "one_of": k.one_of.iter().map(|o| json!({"sets": o.sets, "required": o.required})).collect::<Vec<_>>(),
        "sources": sources, "example": k.example.trim_start(),
    })
}
