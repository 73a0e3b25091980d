//! Reads sections with modules: kinds, and groups of kinds.
//!
//! Modules of a group with an invalid name are left out, since their names would be invalid too.

use super::entry::{Key, article, ordered};
use super::reader::{Reader, is_code};
use crate::diag::Diag;
use crate::model::{Entry, Group, Item, Span};
use crate::sections::GROUP;
use crate::select::is_group;
use crate::suggest::{nearest, ticked};
use alloc::borrow::ToOwned;
use alloc::format;
use alloc::vec::Vec;
use ca_core::{Kind, Type};
use toml::de::{DeTable, DeValue};

impl Reader<'_, '_> {
    pub(super) fn group(&mut self, key: &Key, table: &DeTable) {
        let name = key.get_ref().as_ref();
        let valid = is_group(name) || self.check_word(name, self.span(key));
        let index = self.model.groups.len();
        let mut props = Vec::new();
        self.model.groups.push(Group { name: name.into(), span: self.span(key), props: Vec::new() });
        for (k, v) in ordered(table) {
            let code = k.get_ref().as_ref();
            match v.get_ref() {
                DeValue::Table(t) if is_code(code) => {
                    let kind = self.group_kind(code, k);
                    self.modules(kind.map_or(code, |k| k.code), kind, k, t, Some((index, name)));
                }
                DeValue::Table(t) if !GROUP.contains(&code) => {
                    let d = Diag::error("E002", format!("`{name}.{code}` is neither a kind nor a property"));
                    let d = d.at(self.span(k), "a group contains kinds, in upper case");
                    let meant = nearest(code, self.catalog.iter().map(|k| k.code));
                    self.diags.push(match meant {
                        Some(m) => d.help(format!("did you mean `{m}`?")).fix(self.span(k), m),
                        None => d.help("a group cannot contain another group"),
                    });
                    match meant.and_then(|m| self.catalog.get(m)) {
                        Some(kind) => self.modules(kind.code, Some(kind), k, t, Some((index, name))),
                        None => self.lose(t),
                    }
                }
                _ => props.extend(self.entry(code.into(), k, v)),
            }
        }
        let title = |key: &str| format!("unknown property of the group `{name}`: `{key}`");
        let props = self
            .admit(props, GROUP, title, || format!("the properties of a group are {}", ticked(GROUP.iter().copied())));
        if let Some(group) = self.model.groups.get_mut(index) {
            group.props = props;
        }
        if !valid {
            // the names of its modules are unusable too, and no module keeps its index
            let members = self.model.items.iter().filter(|i| i.group == Some(index)).map(|i| i.name.clone());
            self.model.lost.extend(members.collect::<Vec<_>>());
            self.model.items.retain(|i| i.group != Some(index));
            self.model.groups.truncate(index);
        }
    }

    fn group_kind(&mut self, code: &str, key: &Key) -> Option<&'static Kind> {
        let found = self.catalog.get(code);
        if found.is_some() {
            return found;
        }
        let d = Diag::error("E002", format!("unknown kind: `{code}`")).at(self.span(key), "no such kind");
        let meant = nearest(code, self.catalog.iter().map(|k| k.code));
        self.diags.push(match meant {
            Some(m) => d.help(format!("did you mean `{m}`?")).fix(self.span(key), m),
            None => d.help(format!("kinds are {}", ticked(self.catalog.iter().map(|k| k.code)))),
        });
        meant.and_then(|m| self.catalog.get(m))
    }

    /// Reads the modules of one kind. `group` is its index and name.
    pub(super) fn modules(
        &mut self,
        code: &str,
        kind: Option<&'static Kind>,
        kind_key: &Key,
        table: &DeTable,
        group: Option<(usize, &str)>,
    ) {
        for (key, value) in ordered(table) {
            if self.diags.is_full() {
                return;
            }
            let word = key.get_ref().as_ref();
            let name = group.map_or_else(|| word.to_owned(), |(_, g)| format!("{g}.{word}"));
            // the value is not TOML, which has been reported; the parser leaves its span empty
            if value.span() == (0..0) {
                self.model.lost.push(name);
                continue;
            }
            let valid = self.check_name(word, self.span(key));
            let args = match value.get_ref() {
                DeValue::Table(t) => {
                    let list = self.entries(t);
                    match kind {
                        Some(kind) => self.admit_params(&name, kind, list),
                        None => list,
                    }
                }
                other => {
                    self.not_a_table(&name, kind, article(other), self.span(value));
                    Vec::new()
                }
            };
            if valid {
                self.model.items.push(Item {
                    kind: code.into(),
                    kind_span: self.span(kind_key),
                    name,
                    name_span: self.span(key),
                    group: group.map(|g| g.0),
                    args,
                    span: self.span(value),
                });
            }
        }
    }

    fn admit_params(&mut self, name: &str, kind: &'static Kind, list: Vec<Entry>) -> Vec<Entry> {
        let keys: Vec<&'static str> = kind.params.iter().map(|p| p.name).collect();
        let title = |key: &str| format!("`{name}`: unknown parameter `{key}`");
        self.admit(list, &keys, title, || {
            format!("the parameters of `{}` are {}", kind.code, ticked(keys.iter().copied()))
        })
    }

    fn not_a_table(&mut self, name: &str, kind: Option<&Kind>, what: &str, span: Span) {
        let first = kind.and_then(|k| k.params.first());
        let shown = first.map_or("…".into(), |p| format!("{} = …", p.name));
        let d = Diag::error("E003", format!("`{name}` must be a table")).at(span, format!("this is {what}"));
        let mut d = d.help(format!("write its parameters in braces: `{{ {shown} }}`"));
        let written = self.text.get(span.start..span.end);
        let quantity = first.filter(|p| {
            matches!(p.ty, Type::Number { .. } | Type::Position { .. }) && matches!(what, "a string" | "a number")
        });
        if let (Some(p), Some(w)) = (quantity, written) {
            d = d.fix(span, format!("{{ {} = {w} }}", p.name));
        }
        self.diags.push(d);
    }
}
