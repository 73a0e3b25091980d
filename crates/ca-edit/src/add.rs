//! Adds a module, a generator, a link, or an instance of a part.

use crate::layout::quoted;
use crate::symbols::{Class, Scope, Written};
use crate::value::{finish, params_of, shown, typed};
use crate::{Document, Edited, Refusal, TextEdit};
use ca_core::{Catalog, Kind, Need, Role, Type};
use ca_model::select::{Index, is_word, parse};
use ca_model::suggest::nearest;
use ca_model::{Value, part, read};
use std::collections::BTreeMap;

/// Values by their keys, as typed.
pub(crate) type Values = BTreeMap<String, String>;

/// Place of something new: the model or a part, and perhaps a group in it.
struct Target {
    scope: Scope,
    group: Option<String>,
}

/// Adds a module of `kind`. Parameters that it needs and `values` lacks have the values of the example of the kind.
pub(crate) fn add(
    w: &Written,
    kind: &str,
    name: Option<&str>,
    values: &Values,
    into: Option<&str>,
) -> Result<Edited, Refusal> {
    let found = kind_of(w, kind)?;
    let target = target(w, into)?;
    let name = new_name(w, &target, name, &found.code.to_ascii_lowercase())?;
    let mut written: Vec<(&str, String)> = Vec::new();
    for key in values.keys() {
        if found.param(key).is_none() {
            let near = nearest(key, found.params.iter().map(|p| p.name));
            let help =
                near.map_or_else(|| format!("`ca list {}` lists them", found.code), |n| format!("did you mean `{n}`?"));
            return Err(Refusal::new(format!("unknown parameter of {}: `{}`", found.code, shown(key)), help));
        }
    }
    let missing = missing(found, values);
    for p in found.params {
        match values.get(p.name) {
            Some(v) => written.push((p.name, typed(v)?)),
            None if !missing.contains(&p.name) => {}
            None if matches!(p.ty, Type::Between | Type::Module | Type::File) => {
                let what = format!("{} needs `{}`", found.code, p.name);
                return Err(Refusal::new(what, format!("give it: {}", p.doc)));
            }
            None => written.extend(example(found, p.name, w.catalog).map(|v| (p.name, v))),
        }
    }
    let entries: Vec<String> = written.iter().map(|(k, v)| format!("{k} = {v}")).collect();
    let table = if entries.is_empty() { "{}".into() } else { format!("{{ {} }}", entries.join(", ")) };
    let section: Vec<String> =
        [w.prefix(target.scope), target.group.clone().into_iter().collect(), vec![found.code.into()]].concat();
    insert(w, &section, &name, &table)
}

/// Adds a link of `kind` between two ends, which are written as in `between`.
pub(crate) fn join(
    w: &Written,
    kind: &str,
    ends: [&str; 2],
    name: Option<&str>,
    values: &Values,
    into: Option<&str>,
) -> Result<Edited, Refusal> {
    let found = kind_of(w, kind)?;
    if !matches!(found.role, Role::Lia(_)) {
        let help = "choose a link, such as REF, RES, FRO, BUT or BOW";
        return Err(Refusal::new(format!("{} does not join two masses", found.code), help));
    }
    let target = target(w, into)?;
    for end in ends {
        check_end(w, target.scope, end)?;
    }
    if ends[0].trim() == ends[1].trim() {
        return Err(Refusal::new(format!("`{}` cannot be joined to itself", shown(ends[0])), "name two masses"));
    }
    let mut values = values.clone();
    let between = format!("[{}, {}]", quoted(ends[0].trim()), quoted(ends[1].trim()));
    values.insert("between".into(), between);
    add(w, kind, name, &values, into)
}

/// Adds an instance of a part of the model, or of one that comes with the program.
pub(crate) fn instance(
    w: &Written,
    part: &str,
    name: Option<&str>,
    n: Option<u32>,
    with: &Values,
    into: Option<&str>,
) -> Result<Edited, Refusal> {
    let target = target(w, into)?;
    if target.group.is_some() {
        return Err(Refusal::new("a group cannot contain an instance", "add it to the model or to a part"));
    }
    let Some(params) = params_of(w, part) else {
        let all = w.model.parts.iter().map(|p| p.name.as_str()).chain(part::library::LIBRARY.iter().map(|p| p.0));
        let help = match nearest(part, all) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`ca list parts` shows the parts that come with the program".into(),
        };
        return Err(Refusal::new(format!("unknown part: `{}`", shown(part)), help));
    };
    let name = new_name(w, &target, name, part)?;
    if let Some(key) = with.keys().find(|k| !params.iter().any(|p| p.key == **k)) {
        let near = nearest(key, params.iter().map(|p| p.key.as_str()));
        let help = near.map_or_else(|| "leave it out".into(), |n| format!("did you mean `{n}`?"));
        return Err(Refusal::new(format!("unknown parameter of the part `{part}`: `{}`", shown(key)), help));
    }
    let needs = |v: &Value| matches!(v, Value::Table(t) if !t.iter().any(|e| e.key == "value" || e.key == "port"));
    let missing: Vec<&str> =
        params.iter().filter(|p| needs(&p.value) && !with.contains_key(&p.key)).map(|p| p.key.as_str()).collect();
    if !missing.is_empty() {
        let what = format!("the part `{part}` needs {}", ca_model::suggest::ticked(missing.into_iter()));
        return Err(Refusal::new(what, format!("give a value for each; `ca list {part}` explains them")));
    }
    if n == Some(0) {
        return Err(Refusal::new("there cannot be 0 instances", "give a number from 1"));
    }
    let mut entries = vec![format!("part = {}", quoted(part))];
    entries.extend(n.map(|n| format!("n = {n}")));
    let mut values = Vec::new();
    for p in params.iter().filter(|p| with.contains_key(&p.key)) {
        values.push(format!("{} = {}", crate::layout::key(&p.key), typed(&with[&p.key])?));
    }
    if !values.is_empty() {
        entries.push(format!("with = {{ {} }}", values.join(", ")));
    }
    let section = [w.prefix(target.scope), vec!["use".into()]].concat();
    insert(w, &section, &name, &format!("{{ {} }}", entries.join(", ")))
}

fn kind_of(w: &Written, code: &str) -> Result<&'static Kind, Refusal> {
    w.catalog.get(code).ok_or_else(|| {
        let help = match nearest(code, w.catalog.iter().map(|k| k.code)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`ca list` shows all kinds".into(),
        };
        Refusal::new(format!("unknown kind: `{}`", shown(code)), help)
    })
}

fn target(w: &Written, into: Option<&str>) -> Result<Target, Refusal> {
    let Some(into) = into else { return Ok(Target { scope: None, group: None }) };
    let (part, group) = match into.strip_prefix("part.") {
        Some(rest) => rest.split_once('.').map_or((Some(rest), None), |(p, g)| (Some(p), Some(g))),
        None => (None, Some(into)),
    };
    let scope = match part {
        Some(p) => Some(w.model.parts.iter().position(|x| x.name == p).ok_or_else(|| w.unknown(into))?),
        None => None,
    };
    if let Some(g) = group {
        w.named(scope, g).filter(|s| s.class == Class::Group).ok_or_else(|| w.unknown(into))?;
    }
    Ok(Target { scope, group: group.map(Into::into) })
}

/// Checks a name in its group, or makes one from `base`.
fn new_name(w: &Written, target: &Target, name: Option<&str>, base: &str) -> Result<String, Refusal> {
    let full = |name: &str| target.group.as_ref().map_or(name.to_owned(), |g| format!("{g}.{name}"));
    match name {
        Some(name) if name.contains('.') => {
            let help = "give one word; `into` names a group or a part";
            Err(Refusal::new(format!("`{}` is not one word", shown(name)), help))
        }
        Some(name) => w.check_free(target.scope, &full(name)).map(|()| name.to_owned()),
        None => Ok(fresh(base, &mut 2, |name| w.check_free(target.scope, &full(name)).is_ok())),
    }
}

/// Makes a new name: `base`, or `base` with another number, from `next` on.
pub(crate) fn fresh(base: &str, next: &mut u64, is_free: impl Fn(&str) -> bool) -> String {
    if is_free(base) {
        return base.into();
    }
    // `key[3]` is a name of the reader, but not of anything new
    let word = base.chars().take(60).take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect::<String>();
    let stem = if is_word(&word) { word.trim_end_matches(|c: char| c.is_ascii_digit()) } else { "module" };
    loop {
        let name = format!("{stem}{next}");
        *next += 1;
        if is_free(&name) {
            return name;
        }
    }
}

/// Returns the parameters that a kind needs beside `values`.
fn missing(kind: &Kind, values: &Values) -> Vec<&'static str> {
    let one_of = |name: &str| kind.one_of.iter().find(|o| o.sets.iter().any(|s| s.contains(&name)));
    let mut all = Vec::new();
    for p in kind.params.iter().filter(|p| !values.contains_key(p.name)) {
        let needed = match one_of(p.name) {
            // the set of the example, unless a parameter of another is given
            Some(o) if o.required => {
                let given = o.sets.iter().any(|s| s.iter().any(|k| values.contains_key(*k)));
                !given && o.sets.iter().any(|s| s.first() == Some(&p.name))
            }
            _ => p.need == Need::Required,
        };
        if needed {
            all.push(p.name);
        }
    }
    all
}

/// Returns a value of the first module of a kind in its example, as written there.
fn example(kind: &Kind, key: &str, catalog: &Catalog) -> Option<String> {
    let model = read::written(kind.example, "", catalog).0;
    let item = model.items.iter().find(|i| i.kind == kind.code)?;
    let e = item.args.iter().find(|e| e.key == key)?;
    kind.example.get(e.span.start..e.span.end).map(Into::into)
}

/// Checks one end of a link: a mass that exists, or masses with an index.
fn check_end(w: &Written, scope: Scope, end: &str) -> Result<(), Refusal> {
    let selector = parse(end).map_err(|e| {
        Refusal::new(
            format!("`{}` is not the name of a mass: {}", shown(end), e.message),
            "write e.g. `hammer` or `low[8]`",
        )
    })?;
    let hits = w.hits(scope, end, crate::symbols::Want::Module);
    let Some(last) = hits.iter().rfind(|h| h.symbol.class != Class::Param || hits.len() == 1) else {
        return Err(w.unknown(&selector.name));
    };
    let body = w.body(last.symbol.scope);
    match last.symbol.class {
        Class::Module => {
            let item = &body.items[last.symbol.index];
            let role = w.catalog.get(&item.kind).map(|k| k.role);
            let many =
                matches!(role, Some(Role::Generator(_))) && selector.index == Index::None && selector.at.is_none();
            if many {
                let what = format!("`{}` has several masses", shown(end));
                return Err(Refusal::new(what, format!("name one of them, such as `{}[0]`", selector.name)));
            }
            if matches!(role, Some(Role::Lia(_))) {
                return Err(Refusal::new(format!("`{}` is a link, not a mass", shown(end)), "name a mass"));
            }
            Ok(())
        }
        Class::Group => Err(Refusal::new(format!("`{}` is a group", shown(end)), "name one of its masses")),
        // a module of an instance, or a parameter of a part
        _ => Ok(()),
    }
}

/// Inserts the entry `name` into a section, which is made where it usually stands.
fn insert(w: &Written, section: &[String], name: &str, table: &str) -> Result<Edited, Refusal> {
    let path = [section, &[name.to_owned()]].concat();
    let edit = w.layout().set(&path, table);
    let new: Option<Document> = edit.and_then(|e: TextEdit| {
        let mut document = w.document.clone();
        document.apply(vec![e]).map(|()| document)
    });
    finish(w, new, name)
}
