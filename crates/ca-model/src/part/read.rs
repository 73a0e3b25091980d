//! Reads `[part.NAME]` and `[use]`.

use crate::diag::Diag;
use crate::model::{Entry, Part, Span, Use, Value};
use crate::sections::{GROUP, IN_PART, SECTIONS, USE};
use crate::suggest::ticked;
use crate::text::entry::{Key, Val, article, ordered};
use crate::text::reader::{Reader, unique};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use toml::de::{DeTable, DeValue};

impl Reader<'_, '_> {
    pub(crate) fn parts(&mut self, table: &DeTable) {
        for (key, value) in ordered(table) {
            let name = key.get_ref().as_ref();
            let DeValue::Table(table) = value.get_ref() else {
                let what = article(value.get_ref());
                let d = Diag::error("E003", format!("the part `{name}` must be a section"));
                let d = d.at(self.span(value), format!("this is {what}"));
                self.diags.push(d.help(format!("write its modules in sections such as `[part.{name}.MAS]`")));
                continue;
            };
            if self.check_word(name, self.span(key)) {
                let part = self.part(key, table);
                self.model.parts.push(part);
            }
        }
    }

    fn part(&mut self, key: &Key, table: &DeTable) -> Part {
        let name: String = key.get_ref().as_ref().into();
        let outer = core::mem::take(&mut self.model);
        let mut props = Vec::new();
        for (k, v) in ordered(table) {
            let word = k.get_ref().as_ref();
            let section = SECTIONS.contains(&word);
            match v.get_ref() {
                DeValue::Table(_) if section && !IN_PART.contains(&word) => {
                    let d = Diag::error(
                        "E002",
                        format!("`[{word}]` is allowed only at the root of a model, not in a part"),
                    );
                    let help = format!("a part can contain kinds, groups, and {}", ticked(IN_PART.iter().copied()));
                    self.diags.push(d.at(self.span(k), format!("in the part `{name}`")).help(help));
                }
                DeValue::Table(_) => self.root(k, v),
                _ => props.extend(self.entry(word.into(), k, v)),
            }
        }
        let mut body = core::mem::replace(&mut self.model, outer);
        unique(&mut body, &mut self.diags);
        let known: Vec<&'static str> = GROUP.iter().copied().chain(["doc"]).collect();
        let title = |key: &str| format!("unknown property of the part `{name}`: `{key}`");
        let mut props = self
            .admit(props, &known, title, || format!("the properties of a part are {}", ticked(known.iter().copied())));
        let doc = props.iter().position(|e| e.key == "doc").map(|i| props.remove(i).value);
        let doc = if let Some(Value::Text(t)) = doc { t } else { String::new() };
        Part { name, span: self.span(key), doc, props, body }
    }

    pub(crate) fn uses(&mut self, table: &DeTable) {
        for (key, value) in ordered(table) {
            let name = key.get_ref().as_ref();
            if !self.check_word(name, self.span(key)) {
                continue;
            }
            match self.a_use(key, value) {
                Some(u) => self.model.uses.push(u),
                None => self.model.lost.push(name.into()),
            }
        }
    }

    fn a_use(&mut self, key: &Key, value: &Val) -> Option<Use> {
        let name: String = key.get_ref().as_ref().into();
        let mut u = Use { span: self.span(key), part: None, file: None, n: None, with: Vec::new(), name };
        let name = u.name.clone();
        match value.get_ref() {
            DeValue::String(_) => u.file = self.entry("file".into(), key, value),
            DeValue::Table(t) => {
                let list = self.entries(t);
                let title = |k: &str| format!("`{name}`: unknown key of `[use]`: `{k}`");
                for e in self.admit(list, USE, title, || format!("its keys are {}", ticked(USE.iter().copied()))) {
                    self.key_of_use(&mut u, e);
                }
            }
            other => {
                let d = Diag::error("E003", format!("`{name}` must name a part or a file"));
                let d = d.at(self.span(value), format!("this is {}", article(other)));
                self.diags.push(d.help(format!("write `{name} = {{ part = \"…\" }}` or `{name} = \"file.ca.toml\"`")));
                return None;
            }
        }
        if u.part.is_none() && u.file.is_none() {
            let d = Diag::error("E005", format!("`{name}` names neither a part nor a file"))
                .at(u.span, "`part` or `file` is missing");
            let of = self.model.parts.first().map_or("key", |p| p.name.as_str());
            self.diags.push(d.help(format!("add e.g. `part = \"{of}\"`, or `file = \"bow.ca.toml\"`")));
            return None;
        }
        Some(u)
    }

    fn key_of_use(&mut self, u: &mut Use, e: Entry) {
        let wrong = |r: &mut Self, e: &Entry, wanted: &str| {
            let d = Diag::error("E006", format!("`{}` of `{}` must be {wanted}", e.key, u.name));
            r.diags.push(d.at(e.span, "wrong type"));
        };
        match (e.key.as_str(), &e.value) {
            ("part", Value::Text(_)) => u.part = Some(e),
            ("file", Value::Text(_)) => u.file = Some(e),
            ("n", _) => u.n = Some(e),
            ("with", Value::Table(_)) => {
                let Value::Table(list) = e.value else { return };
                u.with = list;
            }
            ("with", _) => wrong(self, &e, "a table of the parameters of the part"),
            _ => wrong(self, &e, "a string"),
        }
    }
}

/// Returns the place of an entry, otherwise `or`.
pub(super) fn first(of: Option<&Entry>, or: Span) -> Span {
    of.map_or(or, |e| e.span)
}
