//! Sets and clears a value, which is named as `--set` names it, and written as it is typed.

use crate::layout::quoted;
use crate::paths::Paths;
use crate::symbols::{Class, Symbol, Written};
use crate::tree::{self, Content};
use crate::{Document, Edited, Place, Refusal, TextEdit};
use ca_model::sections::{GROUP, META, RATES, USE};
use ca_model::suggest::{nearest, ticked};
use ca_model::{Entry, Model, Value, in_list, part};

/// Longest typed value \[bytes\].
const LONGEST: usize = 1 << 20;

/// Writes `value` at the place called `name`.
pub(crate) fn set(w: &Written, name: &str, value: &str) -> Result<Edited, Refusal> {
    let toml = typed(value)?;
    let place = place(w, name)?;
    if let Some(edit) = param_as_table(w, &place, &toml) {
        return Ok(Edited::new(w.text(), vec![edit]));
    }
    let range = w.document.node(&place).map(|node| node.range.clone());
    let edit = match range {
        Some(range) => Some(TextEdit::new(range, toml)),
        None => w.layout().set(&place.keys, &toml),
    };
    let mut document = w.document.clone();
    let done = edit.and_then(|e| document.apply(vec![e]));
    finish(w, done.map(|()| document), name)
}

/// Removes the value called `name`, so that it has its default.
pub(crate) fn clear(w: &Written, name: &str) -> Result<Edited, Refusal> {
    let place = place(w, name)?;
    if w.document.node(&place).is_none() && w.document.keys(&place).is_empty() {
        return Err(Refusal::new(format!("`{}` is not written", shown(name)), "it has its default already"));
    }
    let mut document = w.document.clone();
    let done = match place.index {
        Some(_) => document.clear(&place),
        None => document.apply(w.layout().remove(&Paths::from_iter([place.keys]))),
    };
    finish(w, done.map(|()| document), name)
}

pub(crate) fn finish(w: &Written, new: Option<Document>, name: &str) -> Result<Edited, Refusal> {
    new.map(|new| Edited::between(w.text(), new.text())).ok_or_else(|| {
        let what = format!("`{}` cannot be written here", shown(name));
        let help = "a value stands where a table is needed, or a table where a value is: change the text";
        Refusal::new(what, help)
    })
}

pub(crate) fn shown(name: &str) -> String {
    let short: String = name.chars().take(60).collect();
    short.escape_debug().to_string()
}

/// Converts typed text to TOML: a number, `true`, a list, a table, a string in quotes, or else a text.
pub(crate) fn typed(value: &str) -> Result<String, Refusal> {
    let text = value.trim();
    if text.is_empty() {
        return Err(Refusal::new("the value is empty", "type a value, or clear it"));
    }
    if text.len() > LONGEST {
        return Err(Refusal::new("the value is too long", format!("use at most {LONGEST} bytes")));
    }
    if text.starts_with(['[', '{', '"', '\'']) {
        let Some(node) = tree::value(text) else {
            let help = "close every bracket and quote; texts in a list are in quotes, as in `[\"a\", \"b\"]`";
            return Err(Refusal::new(format!("`{}` is not a value", shown(text)), help));
        };
        return Ok(match node.content {
            Content::Text(t) => quoted(&t),
            _ => text.to_owned(),
        });
    }
    match Value::typed(text) {
        Value::Num(v) if !v.is_finite() => {
            Err(Refusal::new(format!("`{}` is not a finite number", shown(text)), "type a smaller number"))
        }
        Value::Num(v) => match tree::value(text).map(|n| n.content) {
            Some(Content::Number(_)) => Ok(text.to_owned()),
            _ => Ok(format!("{v:?}")),
        },
        Value::Bool(b) => Ok(b.to_string()),
        _ if text.contains(char::is_control) => {
            Err(Refusal::new(format!("`{}` has a line break or a control character", shown(text)), "type one line"))
        }
        _ => Ok(quoted(text)),
    }
}

/// Finds the place of a value.
pub(crate) fn place(w: &Written, name: &str) -> Result<Place, Refusal> {
    let (owner, last) = name.rsplit_once('.').map_or(("", name), |(o, l)| (o, l));
    let (key, index) = in_list(last);
    let whole = if owner.is_empty() { key.to_owned() } else { format!("{owner}.{key}") };
    let keys = keys(w, &whole)?;
    let place = Place { keys, index };
    if index.is_some() && w.document.node(&place).is_none() {
        let what = format!("`{}` is not in a list", shown(name));
        return Err(Refusal::new(what, "count from 0, and use an index only for a written list"));
    }
    Ok(place)
}

fn keys(w: &Written, name: &str) -> Result<Vec<String>, Refusal> {
    let (scope, local) = w.scope_of(name);
    let prefix = w.prefix(scope);
    let words: Vec<String> = local.split('.').map(str::to_owned).collect();
    if words.iter().any(String::is_empty) {
        return Err(w.unknown(name));
    }
    let join = |rest: &[String]| [prefix.as_slice(), rest].concat();
    let body = w.body(scope);
    let is_setting = |word: &str| GROUP.contains(&word) || word == "doc";
    match (words[0].as_str(), words.len()) {
        ("model", 2) if scope.is_none() => return known(&words[1], META, "[model]").map(|()| words),
        ("rate", 2) if scope.is_none() => return known(&words[1], RATES, "[rate]").map(|()| words),
        ("equivalence", 2..) if scope.is_none() => return Ok(words),
        ("gesture", 2..) => {
            let path = entry(w, &body.gestures, &local["gesture.".len()..]);
            return Ok(path.unwrap_or_else(|rest| [join(&words[..1]), rest].concat()));
        }
        ("preset", 3..) if scope.is_none() => {
            let rest = &local["preset.".len() + words[1].len() + 1..];
            let values = body.presets.iter().find(|p| p.key == words[1]).map(|p| &p.value);
            let path = if let Some(Value::Table(t)) = values { entry(w, t, rest) } else { entry(w, &[], rest) };
            return Ok(path.unwrap_or_else(|rest| [&words[..2], &rest].concat()));
        }
        ("use", 3..) => {
            let symbol = w.named(scope, &words[1]).filter(|s| s.class == Class::Instance);
            return match symbol {
                Some(s) => Ok([w.path(s), words[2..].to_vec()].concat()),
                None => Err(w.unknown(name)),
            };
        }
        ("param", 2..) => return param(w, scope, &words[1..], name),
        (word, 1) if scope.is_some() && is_setting(word) && w.param(scope, word).is_none() => return Ok(join(&words)),
        _ => {}
    }
    for n in (1..=words.len()).rev() {
        let head = words[..n].join(".");
        if let Some(symbol) = w.named(scope, &head) {
            return of_symbol(w, symbol, &words[n..], name);
        }
    }
    if let Some((word, _)) = words[0].split_once('[') {
        if w.named(scope, word).is_some_and(|s| s.class == Class::Instance) {
            let what = format!("`{}` is a value of one of several instances", shown(name));
            return Err(Refusal::new(what, format!("set the list of all, or `{word}.PARAMETER[0]` for the first")));
        }
    }
    param(w, scope, &words, name)
}

fn known(key: &str, keys: &[&'static str], of: &str) -> Result<(), Refusal> {
    if keys.contains(&key) {
        return Ok(());
    }
    let what = format!("{of} has no `{}`", shown(key));
    Err(Refusal::new(
        what,
        match nearest(key, keys.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("choose one of {}", ticked(keys.iter().copied())),
        },
    ))
}

/// Returns the path of a written entry whose key is a full name, or the words of a new one.
fn entry(w: &Written, entries: &[Entry], name: &str) -> Result<Vec<String>, Vec<String>> {
    let found = entries.iter().find(|e| e.key == name).and_then(|e| w.path_at(e.key_span.start));
    found.cloned().ok_or_else(|| {
        let instances = name.contains(['[', '*']);
        if instances { vec![name.to_owned()] } else { name.split('.').map(str::to_owned).collect() }
    })
}

fn of_symbol(w: &Written, symbol: Symbol, rest: &[String], name: &str) -> Result<Vec<String>, Refusal> {
    let path = || [w.path(symbol), rest.to_vec()].concat();
    let Some(key) = rest.first() else {
        let what = format!("`{}` is not a value", shown(name));
        return Err(Refusal::new(what, format!("name one of its parameters, such as `{}.m`", w.address(symbol))));
    };
    match symbol.class {
        Class::Module => {
            let item = &w.body(symbol.scope).items[symbol.index];
            if let Some(kind) = w.catalog.get(&item.kind) {
                let keys: Vec<&'static str> = kind.params.iter().map(|p| p.name).collect();
                known(key, &keys, &format!("`{}`, a {},", w.address(symbol), kind.code))?;
            }
            Ok(path())
        }
        Class::Group => known(key, GROUP, &format!("the group `{}`", w.address(symbol))).map(|()| path()),
        _ => {
            let params = part_params(w, symbol);
            let is_param = params.as_ref().is_some_and(|p| p.iter().any(|e| e.key == *key));
            if !is_param && USE.contains(&key.as_str()) {
                return Ok(path());
            }
            if let Some(all) = params.filter(|_| !is_param) {
                let what = format!("unknown parameter of the part of `{}`: `{}`", w.address(symbol), shown(key));
                return Err(Refusal::new(
                    what,
                    match nearest(key, all.iter().map(|e| e.key.as_str())) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => {
                            "set the value in the part, `part.NAME.MODULE.KEY`, or make it a parameter of it".into()
                        }
                    },
                ));
            }
            Ok([w.path(symbol), vec!["with".into()], rest.to_vec()].concat())
        }
    }
}

/// Returns the parameters of the part of an instance, if this text or the program has it.
pub(crate) fn part_params(w: &Written, instance: Symbol) -> Option<Vec<Entry>> {
    if let Some(i) = w.part_of(instance) {
        return Some(w.model.parts[i].body.params.clone());
    }
    let u = &w.body(instance.scope).uses[instance.index];
    let (Some(Entry { value: Value::Text(name), .. }), None) = (&u.part, &u.file) else { return None };
    params_of(w, name)
}

/// Returns the parameters of a part by its name.
pub(crate) fn params_of(w: &Written, part_name: &str) -> Option<Vec<Entry>> {
    let own = w.model.parts.iter().find(|p| p.name == part_name);
    let body: Option<Model> = own.map(|p| p.body.clone());
    body.or_else(|| part::library::shipped(part_name, w.catalog).map(|p| p.0.body)).map(|b| b.params)
}

fn param(w: &Written, scope: Option<usize>, words: &[String], name: &str) -> Result<Vec<String>, Refusal> {
    let found = (1..=words.len()).rev().find_map(|n| Some((n, w.param(scope, &words[..n].join("."))?)));
    let Some((n, symbol)) = found else {
        let explicit = w.scope_of(name).1.starts_with("param.");
        return match words {
            [new] if explicit => {
                w.check_free(scope, new)?;
                Ok([w.prefix(scope), vec!["param".into(), new.clone()]].concat())
            }
            _ => Err(w.unknown(name)),
        };
    };
    let rest = &words[n..];
    let keys = ["value", "unit", "live", "min", "max", "port", "span", "doc"];
    if let Some(key) = rest.first() {
        known(key, &keys, &format!("the parameter `{}`", w.name(symbol)))?;
    }
    let table = matches!(w.body(scope).params[symbol.index].value, Value::Table(_));
    let value: &[String] = if rest.is_empty() && table { &["value".to_owned()] } else { rest };
    Ok([w.path(symbol).as_slice(), value].concat())
}

/// Turns `felt = 2` to a table, to give it another key.
fn param_as_table(w: &Written, place: &Place, toml: &str) -> Option<TextEdit> {
    let (key, owner) = place.keys.split_last()?;
    let is_param = owner.len() >= 2 && owner[owner.len() - 2] == "param";
    let old = &w.document.tree().pair(owner)?.value;
    let plain = !matches!(old.content, Content::Table(_));
    (is_param && plain).then(|| {
        let text = &w.text()[old.range.clone()];
        TextEdit::new(old.range.clone(), format!("{{ value = {text}, {key} = {toml} }}"))
    })
}
