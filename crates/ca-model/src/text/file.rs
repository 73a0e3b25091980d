//! Reads one file: from TOML text to [`Model`], with its parts as written.
//!
//! The document is walked by hand, span by span. Derived deserialisation stops at its first error and lacks places, but
//! a text format should report all errors at once. The reader *continues with what was probably meant*: a misspelt kind
//! or parameter is reported and read as the suggested one, so that one mistake does not cause ten reports. Only names
//! and forms are checked here; the compiler checks numbers, units and references.

use super::entry::{Key, Val, article, ordered};
use super::reader::{Reader, is_code, unique};
use super::syntax::{self, Source};
use crate::diag::{Diag, Diags, Severity};
use crate::model::{Entry, Model, Value};
use crate::sections::{CURVES, GROUP, META, RATES, SECTIONS};
use crate::select::is_word;
use crate::suggest::{nearest, ticked};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Catalog;
use toml::de::{DeTable, DeValue};

/// Reads one file; its parts stay as written.
pub(crate) fn one_file(text: &str, file: &str, catalog: &Catalog) -> (Model, Diags) {
    let mut diags = Diags::new();
    let source = Source::mend(text, catalog, &mut diags);
    let mut model = Model { file: file.into(), text: text.into(), header: header(text), ..Model::default() };
    let mut one = |source: &Source| {
        let (doc, errors) = DeTable::parse_recoverable(source.text());
        syntax::report(source, text, doc.get_ref(), &errors, &mut diags);
        let (model_so_far, diags_so_far) = (core::mem::take(&mut model), core::mem::take(&mut diags));
        let mut reader = Reader { catalog, source, text, model: model_so_far, diags: diags_so_far };
        for (key, value) in ordered(doc.get_ref()) {
            reader.root(key, value);
        }
        (model, diags) = (reader.model, reader.diags);
        diags.is_full()
    };
    if source.cuts.is_empty() {
        one(&source);
    } else {
        // the rest of a file with too many errors is not read
        _ = source.parts().any(|part| one(&part));
    }
    // a text with syntax errors gets these alone
    if let Some(newer) = source.newer.filter(|_| !diags.list.iter().any(|d| d.code == "E001")) {
        diags.push(newer.note(text));
    }
    unique(&mut model, &mut diags);
    first_of_broken_lines(text, &mut diags);
    broken_lines(&mut model, &diags);
    (model, diags)
}

/// Keeps only the first syntax error of a line: the other errors on it may be consequences.
fn first_of_broken_lines(text: &str, diags: &mut Diags) {
    let breaks: Vec<usize> = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i).collect();
    let line = |d: &Diag| d.span().is_some().then(|| breaks.partition_point(|&b| b < d.span().start));
    let broken: BTreeSet<usize> = diags.list.iter().filter(|d| d.code == "E001").filter_map(line).collect();
    let mut reported = BTreeSet::new();
    diags.list.retain(|d| match line(d).filter(|l| d.severity == Severity::Error && broken.contains(l)) {
        Some(line) => d.code == "E001" && reported.insert(line),
        None => true,
    });
}

/// Marks names on lines with syntax errors as lost, unless a module of that name was read.
fn broken_lines(model: &mut Model, diags: &Diags) {
    for d in diags.list.iter().filter(|d| d.code == "E001") {
        let at = d.span().start.min(model.text.len());
        let Some(before) = model.text.get(..at) else { continue };
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        let line = model.text[start..].lines().next().unwrap_or("").trim_start();
        let name: String = line.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        if is_word(&name) && !model.items.iter().any(|i| i.name == name) && !model.lost.contains(&name) {
            model.lost.push(name);
        }
    }
}

/// Returns the comment lines at the head of the file, without those for editors (`#:schema …`).
fn header(text: &str) -> String {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().skip_while(|l| l.trim().is_empty()).map_while(|l| l.trim_start().strip_prefix('#'));
    let lines = lines.filter(|l| !l.starts_with(":schema"));
    let lines: Vec<&str> = lines.map(|l| l.strip_prefix(' ').unwrap_or(l).trim_end()).collect();
    lines.join("\n").trim_end().into()
}

impl Reader<'_, '_> {
    pub(crate) fn root(&mut self, key: &Key, value: &Val) {
        let name = key.get_ref().as_ref();
        let DeValue::Table(table) = value.get_ref() else { return self.root_value(key, value) };
        if SECTIONS.contains(&name) {
            return self.section(name, table);
        }
        if let Some(kind) = self.catalog.get(name) {
            return self.modules(name, Some(kind), key, table, None);
        }
        let entries = || table.keys().map(|k| k.get_ref().as_ref());
        if !is_code(name) {
            let only_props = !table.is_empty() && entries().all(|k| GROUP.contains(&k));
            if only_props || entries().any(is_code) {
                return self.group(key, table);
            }
        }
        let words =
            SECTIONS.iter().copied().filter(|s| !self.has_section(s)).chain(self.catalog.iter().map(|k| k.code));
        match nearest(name, words) {
            // a group without members, perhaps with a misspelt property
            None if !is_code(name) && !table.values().any(|v| v.get_ref().is_table()) => self.group(key, table),
            Some(meant) => {
                let d = Diag::error("E002", format!("unknown section: `{name}`"));
                let d = d.at(self.span(key), "no such section or kind").help(format!("did you mean `{meant}`?"));
                self.diags.push(d.fix(self.span(key), meant));
                match self.catalog.get(meant) {
                    Some(kind) => self.modules(meant, Some(kind), key, table, None),
                    None => self.section(meant, table),
                }
            }
            None => {
                let help = if is_code(name) {
                    format!("kinds are {}", ticked(self.catalog.iter().map(|k| k.code)))
                } else {
                    format!(
                        "sections are {} and kinds in upper case; write the modules of a group in `[{name}.MAS]`",
                        ticked(SECTIONS.iter().copied())
                    )
                };
                let d = Diag::error("E002", format!("unknown section: `{name}`"));
                self.diags.push(d.at(self.span(key), "no such section or kind").help(help));
                if is_code(name) {
                    self.modules(name, None, key, table, None);
                } else {
                    self.lose(table);
                }
            }
        }
    }

    fn has_section(&self, name: &str) -> bool {
        match name {
            "model" => !self.model.meta.is_empty(),
            "rate" => !self.model.rate.is_empty(),
            "param" => !self.model.params.is_empty(),
            "part" => !self.model.parts.is_empty(),
            "use" => !self.model.uses.is_empty(),
            "gesture" => !self.model.gestures.is_empty(),
            "preset" => !self.model.presets.is_empty(),
            _ => !self.model.equivalence.is_empty(),
        }
    }

    /// Reports a value before the first section, or a section that is not a table.
    fn root_value(&mut self, key: &Key, value: &Val) {
        let name = key.get_ref().as_ref();
        let what = article(value.get_ref());
        let known = SECTIONS.contains(&name) || self.catalog.get(name).is_some();
        let d = if known || is_code(name) {
            let d = Diag::error("E003", format!("`{name}` must be a section"))
                .at(self.span(value), format!("this is {what}"));
            d.help(match value.get_ref() {
                DeValue::Array(_) => format!("write `[{name}]`, in single brackets, and one line for each module"),
                _ => format!("write `[{name}]` on a separate line and its entries below"),
            })
        } else {
            let home = [("model", META), ("rate", RATES)].into_iter().find(|s| s.1.contains(&name));
            let d = Diag::error("E002", format!("`{name}` is outside any section"));
            d.at(self.span(key), "before the first section").help(match home {
                Some((section, _)) => format!("move it below `[{section}]`"),
                None => "move it into a section: `[model]`, `[rate]`, `[MAS]` and so on".into(),
            })
        };
        self.diags.push(d);
    }

    fn section(&mut self, name: &str, table: &DeTable) {
        match name {
            "model" => self.model.meta = self.known(name, table, META),
            "rate" => self.model.rate = self.known(name, table, RATES),
            "param" => self.model.params = self.params(table),
            "part" => self.parts(table),
            "use" => self.uses(table),
            "gesture" => {
                let mut list = Vec::new();
                // a table with such a key makes a gesture; any other holds gestures
                self.paths(
                    "",
                    table,
                    &|t| t.keys().any(|k| CURVES.iter().any(|c| c.0 == k.get_ref().as_ref())),
                    &mut list,
                );
                self.model.gestures = list;
            }
            "preset" => self.model.presets = self.presets(table),
            _ => self.model.equivalence = self.entries(table),
        }
    }

    /// Reads entries whose keys are full names, so `ball.hand` and a nested table are equal. A table that `is_value`
    /// accepts is a value.
    fn paths(&mut self, prefix: &str, table: &DeTable, is_value: &dyn Fn(&DeTable) -> bool, out: &mut Vec<Entry>) {
        for (key, value) in ordered(table) {
            let path = format!("{prefix}{}", key.get_ref());
            match value.get_ref() {
                // a table with such a key is a gesture; other tables contain gestures
                DeValue::Table(inner) if !is_value(inner) => {
                    self.paths(&format!("{path}."), inner, is_value, out);
                }
                _ => out.extend(self.entry(path, key, value)),
            }
        }
    }

    /// `[preset.NAME]`: a table for each preset, whose keys are full names of parameters.
    fn presets(&mut self, table: &DeTable) -> Vec<Entry> {
        let mut all = Vec::new();
        for (key, value) in ordered(table) {
            let (name, key_span, span) = (key.get_ref().as_ref(), self.span(key), self.span(value));
            let DeValue::Table(inner) = value.get_ref() else {
                let title = format!("preset `{name}` must be a table, not {}", article(value.get_ref()));
                let help = format!("write `[preset.{name}]`, and its values on the lines below");
                self.diags.push(Diag::error("E006", title).at(span, "wrong type").help(help));
                continue;
            };
            if self.check_word(name, key_span) {
                let mut values = Vec::new();
                self.paths("", inner, &|_| false, &mut values);
                all.push(Entry { key: name.into(), key_span, value: Value::Table(values), span });
            }
        }
        all
    }

    /// Returns the entries of a section with a fixed list of keys.
    fn known(&mut self, section: &str, table: &DeTable, keys: &[&'static str]) -> Vec<Entry> {
        let list = self.entries(table);
        let title = |key: &str| format!("unknown key in `[{section}]`: `{key}`");
        self.admit(list, keys, title, || format!("the keys of `[{section}]` are {}", ticked(keys.iter().copied())))
    }

    fn params(&mut self, table: &DeTable) -> Vec<Entry> {
        let list = self.entries(table);
        list.into_iter().filter(|e| self.check_name(&e.key, e.key_span)).collect()
    }
}
