//! The parts that come with the program: a table, and the page of one.
//!
//! Decides that a page is made of what the part declares and its author wrote above it, as that of a kind is of the catalog.

use ca_core::Catalog;
use ca_model::part::Part;
use ca_model::part::library::{LIBRARY, shipped};
use ca_model::{Entry, Value};
use serde_json::{Value as Json, json};
use std::fmt::Write as _;

/// Their names, a line about each.
pub fn all(catalog: &Catalog) -> String {
    let width = LIBRARY.iter().map(|p| p.0.len()).max().unwrap_or(0);
    let about = |name: &str| shipped(name, catalog).map(|p| p.0.doc).unwrap_or_default();
    let line = |(name, _): &(&str, &str)| format!("  {name:<width$}  {}\n", about(name));
    LIBRARY.iter().map(line).collect()
}

pub fn all_json(catalog: &Catalog) -> Json {
    let one = |(name, _): &(&str, &str)| Some(json!({"name": name, "doc": shipped(name, catalog)?.0.doc}));
    Json::Array(LIBRARY.iter().filter_map(one).collect())
}

/// What one is for, its parameters, and how it is used.
pub fn page(part: &Part, header: &str) -> String {
    let mut out = format!("{}: {}\n\n{}\n\nParameters\n", part.name, part.doc, header);
    let width = part.body.params.iter().map(|p| p.key.chars().count()).max().unwrap_or(0);
    for p in &part.body.params {
        let _ = writeln!(out, "  {:<width$}  {}; {}", p.key, text(field(p, "doc")), default(p));
    }
    let needed: Vec<String> =
        part.body.params.iter().filter(|p| is_needed(p)).map(|p| format!("{} = …", p.key)).collect();
    let with = if needed.is_empty() { String::new() } else { format!(", with = {{ {} }}", needed.join(", ")) };
    let _ = write!(out, "\n  [use]\n  {0} = {{ part = \"{0}\"{with} }}\n", part.name);
    out
}

pub fn json(part: &Part, header: &str) -> Json {
    let param = |p: &Entry| {
        let word = |key: &str| field(p, key).map(|v| text(Some(v)));
        json!({"name": p.key, "doc": word("doc"), "unit": word("unit"), "default": value(p).map(|v| text(Some(v)))})
    };
    let params: Vec<Json> = part.body.params.iter().map(param).collect();
    json!({"name": part.name, "doc": part.doc, "about": header, "params": params})
}

fn default(p: &Entry) -> String {
    let unit = field(p, "unit").map(|u| format!(" [{}]", text(Some(u)))).unwrap_or_default();
    match (value(p), field(p, "port")) {
        (Some(v), _) => format!("default {}{unit}", text(Some(v))),
        (None, Some(port)) => format!("driven by the port `{}`{unit}", text(Some(port))),
        (None, None) => format!("required{unit}"),
    }
}

fn is_needed(p: &Entry) -> bool {
    value(p).is_none() && field(p, "port").is_none()
}

/// What holds where nothing is given.
fn value(p: &Entry) -> Option<&Value> {
    if matches!(p.value, Value::Table(_)) { field(p, "value") } else { Some(&p.value) }
}

fn field<'p>(p: &'p Entry, key: &str) -> Option<&'p Value> {
    let Value::Table(table) = &p.value else { return None };
    table.iter().find(|e| e.key == key).map(|e| &e.value)
}

fn text(v: Option<&Value>) -> String {
    match v {
        Some(Value::Text(t)) => t.clone(),
        Some(Value::Num(x)) => x.to_string(),
        Some(Value::Bool(b)) => b.to_string(),
        Some(Value::List(l)) => format!("[{}]", l.iter().map(|e| text(Some(&e.value))).collect::<Vec<_>>().join(", ")),
        _ => String::new(),
    }
}
