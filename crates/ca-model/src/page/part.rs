//! Pages of the bundled parts: a list, and the page of one part.
//!
//! A page is made from the declarations of the part and the comment above it, as the page of a kind from the catalog.

use crate::part::Part;
use crate::part::library::{LIBRARY, shipped};
use crate::{Entry, Item, Value};
use alloc::format;
use alloc::string::{String, ToString as _};
use alloc::vec::Vec;
use ca_core::Catalog;
use core::fmt::Write as _;
use serde_json::{Value as Json, json};

/// Returns a line for each bundled part.
pub fn all(catalog: &Catalog) -> String {
    let width = LIBRARY.iter().map(|p| p.0.len()).max().unwrap_or(0);
    let about = |name: &str| shipped(name, catalog).map(|p| p.0.doc).unwrap_or_default();
    let line = |(name, _): &(&str, &str)| format!("  {name:<width$}  {}\n", about(name));
    LIBRARY.iter().map(line).collect()
}

/// Returns name and line of each bundled part as JSON.
pub fn all_json(catalog: &Catalog) -> Json {
    let one = |(name, _): &(&str, &str)| Some(json!({"name": name, "doc": shipped(name, catalog)?.0.doc}));
    Json::Array(LIBRARY.iter().filter_map(one).collect())
}

/// Returns the page as text: purpose, parameters, ports and an example. `header` is the comment above the part.
pub fn text(part: &Part, header: &str) -> String {
    let mut out = format!("{}: {}\n\n{}\n\nParameters\n", part.name, part.doc, header);
    let width = part.body.params.iter().map(|p| p.key.chars().count()).max().unwrap_or(0);
    for p in &part.body.params {
        let _ = writeln!(out, "  {:<width$}  {}; {}", p.key, word(field(p, "doc")), default(p));
    }
    let ports = ports(part);
    if !ports.is_empty() {
        out += "\nPorts\n";
        let width = ports.iter().map(|p| p.name.chars().count()).max().unwrap_or(0);
        for p in &ports {
            let midi = p.midi().map_or(String::new(), |way| format!("; MIDI moves it {way}"));
            let _ = writeln!(out, "  {:<width$}  rests at {}{midi}", p.name, p.rest);
        }
        out += "\n  [gesture]\n";
        for p in &ports {
            let _ = writeln!(out, "  {}", p.gesture(&part.name));
        }
    }
    let needed: Vec<String> =
        part.body.params.iter().filter(|p| is_needed(p)).map(|p| format!("{} = …", p.key)).collect();
    let with = if needed.is_empty() { String::new() } else { format!(", with = {{ {} }}", needed.join(", ")) };
    let _ = write!(out, "\n  [use]\n  {0} = {{ part = \"{0}\"{with} }}\n", part.name);
    out
}

/// Returns the page as JSON.
pub fn json(part: &Part, header: &str) -> Json {
    let param = |p: &Entry| {
        let told = |key: &str| field(p, key).map(|v| word(Some(v)));
        json!({"name": p.key, "doc": told("doc"), "unit": told("unit"), "default": value(p).map(|v| word(Some(v)))})
    };
    let params: Vec<Json> = part.body.params.iter().map(param).collect();
    let ports: Vec<Json> = ports(part)
        .iter()
        .map(|p| json!({"name": p.name, "unit": p.unit, "rest": p.rest, "midi": p.midi(), "gesture": p.gesture(&part.name)}))
        .collect();
    json!({"name": part.name, "doc": part.doc, "about": header, "params": params, "ports": ports})
}

/// Port of a part as written. A number that is a parameter is replaced by the default of the parameter.
struct Port {
    name: String,
    unit: &'static str,
    rest: String,
    /// Movement by MIDI: from, to, description of the source, and whether the source is notes.
    way: Option<(String, String, String, bool)>,
}

impl Port {
    fn midi(&self) -> Option<String> {
        self.way.as_ref().map(|(from, to, by, _)| format!("from {from} to {to} {by}"))
    }

    /// Returns a line of `[gesture]`: down and back, or the range of a controller; without MIDI 2 mm or 1 N.
    fn gesture(&self, part: &str) -> String {
        let some = if self.unit == "N" { "1 N" } else { "2 mm" };
        let points = match &self.way {
            Some((from, to, _, true)) => format!("[[0, \"{from}\"], [0.02, \"{to}\"], [0.1, \"{from}\"]]"),
            Some((from, to, _, false)) => format!("[[0, \"{from}\"], [1, \"{to}\"]]"),
            None => format!("[[0, \"{}\"], [0.02, \"{some}\"], [0.1, \"{}\"]]", self.rest, self.rest),
        };
        format!("\"{part}.{}\" = {points}", self.name)
    }
}

fn ports(part: &Part) -> Vec<Port> {
    let of = |list: &[Entry], key: &str| list.iter().find(|e| e.key == key).map(|e| e.value.clone());
    // default of a parameter of the part
    let meant = |v: Value| match &v {
        Value::Text(t) => part.body.params.iter().find(|p| p.key == t.trim()).and_then(value).cloned().unwrap_or(v),
        _ => v,
    };
    let moved = |kind: &str| matches!(kind, "TGR" | "ENX" | "ENF");
    let one = |item: &Item| {
        let unit = if item.kind == "ENF" { "N" } else { "m" };
        let number = |v: Option<Value>| match v.map(meant) {
            Some(Value::Num(x)) => format!("{x} {unit}"),
            other => other.map_or(format!("0 {unit}"), |v| word(Some(&v))),
        };
        let way = match of(&item.args, "midi") {
            Some(Value::Table(m)) => {
                let by = |key: &str| of(&m, key).map(|v| word(Some(&v)));
                let notes = by("note").is_some();
                let by = match (by("note"), by("cc")) {
                    (Some(note), _) => format!("by the note `{note}`"),
                    (_, Some(cc)) => format!("by controller {cc}"),
                    _ => "by a wheel or pressure".into(),
                };
                Some((number(of(&m, "from")), number(of(&m, "to")), by, notes))
            }
            _ => None,
        };
        Port { name: item.name.clone(), unit, rest: number(of(&item.args, "x")), way }
    };
    part.body.items.iter().filter(|i| moved(&i.kind)).map(one).collect()
}

fn default(p: &Entry) -> String {
    let unit = field(p, "unit").map(|u| format!(" [{}]", word(Some(u)))).unwrap_or_default();
    match (value(p), field(p, "port")) {
        (Some(v), _) => format!("default {}{unit}", word(Some(v))),
        (None, Some(port)) => format!("driven by the port `{}`{unit}", word(Some(port))),
        (None, None) => format!("required{unit}"),
    }
}

fn is_needed(p: &Entry) -> bool {
    value(p).is_none() && field(p, "port").is_none()
}

fn value(p: &Entry) -> Option<&Value> {
    if matches!(p.value, Value::Table(_)) { field(p, "value") } else { Some(&p.value) }
}

fn field<'p>(p: &'p Entry, key: &str) -> Option<&'p Value> {
    let Value::Table(table) = &p.value else { return None };
    table.iter().find(|e| e.key == key).map(|e| &e.value)
}

fn word(v: Option<&Value>) -> String {
    match v {
        Some(Value::Text(t)) => t.clone(),
        Some(Value::Num(x)) => x.to_string(),
        Some(Value::Bool(b)) => b.to_string(),
        Some(Value::List(l)) => format!("[{}]", l.iter().map(|e| word(Some(&e.value))).collect::<Vec<_>>().join(", ")),
        _ => String::new(),
    }
}
