//! Writes a [`Model`] as text, in the form that an author would choose.
//!
//! The order is `[model]`, `[rate]`, `[param]`, modules, `[gesture]`, `[preset]`, `[equivalence]`, with one module on a
//! line and aligned `=`. TOML allows each section once. A model in the order MAS, REF, MAS is therefore written with
//! kinds in order of first appearance and modules of a kind in their order; reading it gives the same modules,
//! regrouped. Only the comments at the head of the file are written, since a [`Model`] does not contain others. No TOML
//! library is used: writing must work without the feature `parse`, and none writes one module on a line.

use super::model::{Entry, Item, Model, Value};
use super::select::is_word;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Largest length of a line that is not broken.
const WIDTH: usize = 110;
/// Largest length of a name for alignment.
const PAD: usize = 16;

/// Returns the text of a model. For valid, unique names `read(write(m))` is `m`, except for spans, text and regrouping.
pub fn write(model: &Model) -> String {
    let mut out = String::new();
    for line in model.header.trim_end().lines() {
        let line: String = line.chars().filter(|c| !c.is_control() || *c == '\t').collect();
        let gap = if line.is_empty() || line.starts_with([':', '!']) { "" } else { " " };
        emit(&mut out, format!("#{gap}{line}").trim_end());
    }
    section(&mut out, "model", &model.meta);
    section(&mut out, "rate", &model.rate);
    section(&mut out, "param", &model.params);
    modules(&mut out, model);
    section(&mut out, "gesture", &model.gestures);
    for preset in &model.presets {
        if let Value::Table(values) = &preset.value {
            head(&mut out, &format!("preset.{}", quoted_key(&preset.key)));
            lines(&mut out, values);
        }
    }
    section(&mut out, "equivalence", &model.equivalence);
    out
}

fn emit(out: &mut String, line: &str) {
    out.push_str(line);
    out.push('\n');
}

fn head(out: &mut String, name: &str) {
    if !out.is_empty() {
        out.push('\n');
    }
    emit(out, &format!("[{name}]"));
}

fn section(out: &mut String, name: &str, entries: &[Entry]) {
    if entries.is_empty() {
        return;
    }
    head(out, name);
    lines(out, entries);
}

fn lines(out: &mut String, entries: &[Entry]) {
    let lines: Vec<(String, &Value)> = entries.iter().map(|e| (quoted_key(&e.key), &e.value)).collect();
    let pad = padding(lines.iter().map(|l| l.0.as_str()));
    for (key, value) in lines {
        line(out, &key, pad, value);
    }
}

/// Returns the group that a module is written in, and its name there.
fn place<'m>(model: &'m Model, item: &'m Item) -> (&'m str, &'m str) {
    let own = item.group.and_then(|g| model.groups.get(g)).map(|g| g.name.as_str());
    let of_own = own.and_then(|o| Some((o, item.name.strip_prefix(o)?.strip_prefix('.')?)));
    match of_own.or_else(|| item.name.split_once('.').filter(|_| own.is_none())) {
        Some((g, word)) if is_word(word) && (of_own.is_some() || is_word(g)) => (g, word),
        _ => ("", &item.name),
    }
}

/// Modules of one kind in one group, with their names there.
struct Section<'m> {
    group: &'m str,
    kind: &'m str,
    members: Vec<(&'m str, &'m Item)>,
}

fn modules(out: &mut String, model: &Model) {
    let mut sections: Vec<Section> = Vec::new();
    for item in &model.items {
        let (group, word) = place(model, item);
        match sections.iter_mut().find(|s| s.group == group && s.kind == item.kind) {
            Some(s) => s.members.push((word, item)),
            None => sections.push(Section { group, kind: &item.kind, members: Vec::from([(word, item)]) }),
        }
    }
    let mut opened: Vec<&str> = Vec::new();
    let mut open = |out: &mut String, name: &str, alone: bool| {
        let Some(group) = model.groups.iter().find(|g| g.name == name) else { return };
        if !opened.contains(&group.name.as_str()) {
            opened.push(&group.name);
            if alone && group.props.is_empty() {
                head(out, &quoted_key(&group.name));
            }
            section(out, &quoted_key(&group.name), &group.props);
        }
    };
    for Section { group, kind, members } in &sections {
        if !group.is_empty() {
            open(out, group, false);
        }
        let group = if group.is_empty() { String::new() } else { quoted_key(group) + "." };
        head(out, &format!("{group}{}", quoted_key(kind)));
        let pad = padding(members.iter().map(|m| m.0));
        for (word, item) in members {
            module(out, &quoted_key(word), pad, item);
        }
    }
    for g in &model.groups {
        open(out, &g.name, true);
    }
}

/// Writes `name = { … }`, or one dotted key on each line if that is too long.
fn module(out: &mut String, key: &str, pad: usize, item: &Item) {
    let value = table(&item.args);
    if key.chars().count().max(pad) + 3 + value.chars().count() <= WIDTH || item.args.is_empty() {
        emit(out, &format!("{key:pad$} = {value}"));
        return;
    }
    let keys: Vec<String> = item.args.iter().map(|e| format!("{key}.{}", quoted_key(&e.key))).collect();
    let pad = keys.iter().map(|k| k.chars().count()).max().unwrap_or(0).min(2 * PAD);
    for (k, e) in keys.iter().zip(&item.args) {
        line(out, k, pad, &e.value);
    }
}

fn padding<'a>(names: impl Iterator<Item = &'a str>) -> usize {
    names.map(|n| n.chars().count()).filter(|&n| n <= PAD).max().unwrap_or(0)
}

/// Writes `key = value`; a long list is broken into lines.
fn line(out: &mut String, key: &str, pad: usize, value: &Value) {
    let short = inline(value);
    let Value::List(list) = value else {
        emit(out, &format!("{key:pad$} = {short}"));
        return;
    };
    if key.chars().count().max(pad) + 3 + short.chars().count() <= WIDTH {
        emit(out, &format!("{key:pad$} = {short}"));
        return;
    }
    emit(out, &format!("{key:pad$} = ["));
    let mut row = String::new();
    for e in list {
        let member = format!("{},", inline(&e.value));
        if !row.is_empty() && row.chars().count() + member.chars().count() + 5 > WIDTH {
            emit(out, &format!("    {row}"));
            row.clear();
        }
        if !row.is_empty() {
            row.push(' ');
        }
        row += &member;
    }
    emit(out, &format!("    {row}"));
    emit(out, "]");
}

fn inline(value: &Value) -> String {
    match value {
        Value::Num(v) => number(*v),
        Value::Text(t) => quoted(t),
        Value::Bool(b) => b.to_string(),
        Value::List(list) => {
            format!("[{}]", list.iter().map(|e| inline(&e.value)).collect::<Vec<_>>().join(", "))
        }
        Value::Table(entries) => table(entries),
    }
}

fn table(entries: &[Entry]) -> String {
    if entries.is_empty() {
        return "{}".into();
    }
    let list: Vec<String> = entries.iter().map(|e| format!("{} = {}", quoted_key(&e.key), inline(&e.value))).collect();
    format!("{{ {} }}", list.join(", "))
}

/// Returns the shortest digits that read back to the same bits.
fn number(v: f64) -> String {
    if v.is_nan() {
        return "nan".into();
    }
    let text = format!("{v:?}");
    match text.strip_suffix(".0") {
        Some(whole) if v.abs() < 1e15 => whole.into(),
        _ => text,
    }
}

fn quoted_key(key: &str) -> String {
    let bare = !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    if bare { key.into() } else { quoted(key) }
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out += "\\\"",
            '\\' => out += "\\\\",
            '\n' => out += "\\n",
            '\t' => out += "\\t",
            '\r' => out += "\\r",
            c if c.is_control() => out.extend(["\\u".to_string(), format!("{:04X}", c as u32)]),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
