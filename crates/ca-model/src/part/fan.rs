//! Fans: `note[*].key` is a list of one module of each instance.
//!
//! Decides that lists are made before anything is compiled, and that one of them stands wherever a module may.

use crate::diag::{Diag, Diags};
use crate::select::parse;
use crate::{Entry, Item, LARGEST, Model, Value};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_core::Catalog;
use ca_core::kind::Type;

/// How many instances there are of each name, and where to say what is wrong.
pub(super) struct Fans<'f> {
    counts: BTreeMap<String, usize>,
    diags: &'f mut Diags,
    /// names that are none, which has been reported
    lost: Vec<String>,
}

/// Makes lists of all names of many instances in `model`.
pub(crate) fn fan(model: &mut Model, catalog: &Catalog, diags: &mut Diags) {
    let mut counts = BTreeMap::new();
    // each instance is a group
    let instances = model.groups.iter().filter_map(|g| g.name.strip_suffix(']')?.rsplit_once('['));
    for (name, index) in instances {
        let n: &mut usize = counts.entry(name.into()).or_default();
        *n = (*n).max(index.parse().map_or(0, |i: usize| i + 1));
    }
    if counts.is_empty() {
        return;
    }
    let mut fans = Fans { counts, diags, lost: Vec::new() };
    fans.items(&mut model.items, catalog);
    fans.gestures(&mut model.gestures);
    model.lost.append(&mut fans.lost);
}

impl Fans<'_> {
    fn items(&mut self, items: &mut [Item], catalog: &Catalog) {
        for item in items {
            let Some(kind) = catalog.get(&item.kind) else { continue };
            for e in &mut item.args {
                let ty = kind.param(&e.key).map(|i| kind.params[i].ty);
                if matches!(ty, Some(Type::Between | Type::Module)) {
                    self.entry(e, &item.name);
                }
            }
        }
    }

    fn entry(&mut self, e: &mut Entry, owner: &str) {
        match &mut e.value {
            Value::List(l) => l.iter_mut().for_each(|x| self.entry(x, owner)),
            Value::Text(t) if t.contains('[') => {
                let all = match self.names(&t.clone(), e, owner) {
                    Ok(Some(all)) => all,
                    Ok(None) => return,
                    // goes on with an instance that there is, so that one mistake is one finding
                    Err(()) => Vec::from([first_instance(&e.value)]),
                };
                let one = |name: &String| Entry { value: Value::Text(name.clone()), ..e.clone() };
                e.value = Value::List(all.iter().map(one).collect());
            }
            _ => {}
        }
    }

    /// A gesture of many ports is one for each.
    fn gestures(&mut self, gestures: &mut Vec<Entry>) {
        if !gestures.iter().any(|g| g.key.contains('[')) {
            return;
        }
        for g in core::mem::take(gestures) {
            match self.names(&g.key, &g, "gesture") {
                Ok(Some(all)) if all.len().saturating_mul(size(&g)) > LARGEST => {
                    let d =
                        Diag::error("E027", format!("gesture `{}` has too many points for {} ports", g.key, all.len()));
                    self.diags.push(d.at(g.key_span, "too many").help("let fewer ports play it, or fewer points"));
                }
                Ok(Some(all)) => gestures.extend(all.into_iter().map(|key| Entry { key, ..g.clone() })),
                Ok(None) => gestures.push(g),
                Err(()) => {}
            }
        }
    }

    /// The names that `text` means, or none where it means itself; nothing where that is reported.
    fn names(&mut self, text: &str, e: &Entry, owner: &str) -> Result<Option<Vec<String>>, ()> {
        let mut all = Vec::new();
        match self.each(String::new(), text.trim(), &mut all) {
            Ok(many) => Ok(many.then_some(all)),
            Err(Outside { name, index, n }) => {
                self.lost.extend(parse(text).ok().map(|s| s.name));
                let d = Diag::error("E016", format!("`{owner}`: no `{name}[{index}]`"));
                let d = d.at(if e.key == text { e.key_span } else { e.span }, "no such instance");
                self.diags.push(d.help(format!("`{name}` has {n}: [0] to [{}], or [*] for all", n - 1)));
                Err(())
            }
        }
    }

    /// Adds all names that begin with `done`, where `rest` is still to be read; true where an index means other than itself.
    fn each(&self, mut done: String, rest: &str, all: &mut Vec<String>) -> Result<bool, Outside> {
        let index =
            rest.split_once('[').and_then(|(word, r)| r.split_once(']').map(|(index, rest)| (word, index, rest)));
        let Some((word, index, rest)) = index.filter(|_| all.len() < LARGEST) else {
            all.push(done + rest);
            return Ok(false);
        };
        done += word;
        let Some(n) = self.counts.get(done.as_str()).copied() else {
            return self.each(format!("{done}[{index}]"), rest, all);
        };
        let Some(which) = indices(index.trim(), n) else {
            return Err(Outside { name: done, index: index.into(), n });
        };
        let mut many = which.first().map(ToString::to_string).as_deref() != Some(index);
        for i in which {
            many |= self.each(format!("{done}[{i}]"), rest, all)?;
        }
        Ok(many)
    }
}

/// An index that no instance has.
struct Outside {
    name: String,
    index: String,
    n: usize,
}

/// The name with the first instance in the place of each index but the last.
fn first_instance(value: &Value) -> String {
    let Value::Text(t) = value else { return String::new() };
    let mut out = String::new();
    let mut rest = t.as_str();
    while let Some((before, after)) = rest.split_once('[') {
        let Some((index, more)) = after.split_once(']') else { break };
        let of_instance = more.starts_with('.');
        out += before;
        out.extend(["[", if of_instance { "0" } else { index }, "]"]);
        rest = more;
    }
    out + rest
}

/// Values in a gesture.
fn size(e: &Entry) -> usize {
    match &e.value {
        Value::List(l) | Value::Table(l) => 1 + l.iter().map(size).sum::<usize>(),
        _ => 1,
    }
}

/// Which instances an index means; nothing where there are none such.
fn indices(index: &str, n: usize) -> Option<Vec<usize>> {
    let one = |t: &str| -> Option<usize> {
        let i: i64 = t.trim().parse().ok()?;
        usize::try_from(if i < 0 { i + n as i64 } else { i }).ok().filter(|i| *i <= n)
    };
    if index == "*" {
        return Some((0..n).collect());
    }
    if let Some((a, b)) = index.split_once("..") {
        let (a, b) = (one(a)?, one(b)?);
        return (a < b).then(|| (a..b).collect());
    }
    one(index).filter(|i| *i < n).map(|i| Vec::from([i]))
}
