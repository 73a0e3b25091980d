//! Expands `note[*].key` to a list with one module of each instance, wherever a module may stand, before compilation.

use super::instances::{Counts, Outside};
use crate::diag::{Diag, Diags};
use crate::model::{Entry, Item, LARGEST, Model, Value};
use crate::select::parse;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::{Catalog, Type};

pub(super) struct Fans<'f> {
    counts: Counts,
    diags: &'f mut Diags,
    /// Invalid names, which have been reported.
    lost: Vec<String>,
}

/// Expands all names of several instances in `model`.
pub(crate) fn fan(model: &mut Model, catalog: &Catalog, diags: &mut Diags) {
    let counts = Counts::of(model);
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
                    // continues with an existing instance, so that one mistake is one finding
                    Err(()) => Vec::from([first_instance(&e.value)]),
                };
                let one = |name: &String| Entry { value: Value::Text(name.clone()), ..e.clone() };
                e.value = Value::List(all.iter().map(one).collect());
            }
            _ => {}
        }
    }

    /// Copies a gesture of several ports for each port.
    fn gestures(&mut self, gestures: &mut Vec<Entry>) {
        if !gestures.iter().any(|g| g.key.contains('[')) {
            return;
        }
        for g in core::mem::take(gestures) {
            match self.names(&g.key, &g, "gesture") {
                Ok(Some(all)) if all.len().saturating_mul(size(&g)) > LARGEST => {
                    let d =
                        Diag::error("E027", format!("gesture `{}` has too many points for {} ports", g.key, all.len()));
                    self.diags.push(d.at(g.key_span, "too many").help("use fewer ports or fewer points"));
                }
                Ok(Some(all)) => gestures.extend(all.into_iter().map(|key| Entry { key, ..g.clone() })),
                Ok(None) => gestures.push(g),
                Err(()) => {}
            }
        }
    }

    /// Returns the names that `text` stands for, `None` if it stands for itself, or an error after a report.
    fn names(&mut self, text: &str, e: &Entry, owner: &str) -> Result<Option<Vec<String>>, ()> {
        let mut all = Vec::new();
        match self.counts.each(String::new(), text.trim(), &mut all) {
            Ok(many) => Ok(many.then_some(all)),
            Err(Outside { name, index, n }) => {
                self.lost.extend(parse(text).ok().map(|s| s.name));
                let d = Diag::error("E016", format!("`{owner}`: no `{name}[{index}]`"));
                let d = d.at(if e.key == text { e.key_span } else { e.span }, "no such instance");
                self.diags.push(d.help(format!("`{name}` has the instances [0] to [{}]; [*] selects all {n}", n - 1)));
                Err(())
            }
        }
    }
}

/// Replaces each index of an instance by 0.
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

fn size(e: &Entry) -> usize {
    match &e.value {
        Value::List(l) | Value::Table(l) => 1 + l.iter().map(size).sum::<usize>(),
        _ => 1,
    }
}
