//! State of the reader, and the checks that all sections share.
//!
//! It decides what is a valid name and which known key a word resembles, records unreadable names, and keeps the first
//! of two modules with the same name.

use super::syntax::Source;
use crate::diag::{Diag, Diags};
use crate::model::{Entry, Model, Span};
use crate::names::all_differ;
use crate::select::{is_name, is_word};
use crate::suggest::nearest;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Catalog;
use toml::Spanned;
use toml::de::DeTable;

/// Names of parameters in other programs and textbooks.
const OTHER_NAMES: &[(&str, &str)] = &[
    ("mass", "m"),
    ("inertia", "m"),
    ("stiffness", "k"),
    ("spring", "k"),
    ("damping", "z"),
    ("viscosity", "z"),
    ("friction", "z"),
    ("frequency", "f"),
    ("freq", "f"),
    ("decay", "t60"),
    ("sr", "sound"),
    ("sample_rate", "sound"),
    ("threshold", "d"),
    ("distance", "d"),
    ("length", "l0"),
    ("position", "x"),
    ("velocity", "v"),
    ("speed", "v"),
];

pub(crate) fn is_code(key: &str) -> bool {
    key.starts_with(|c: char| c.is_ascii_uppercase())
}

pub(crate) struct Reader<'a, 's> {
    pub(crate) catalog: &'a Catalog,
    pub(crate) source: &'a Source<'s>,
    pub(crate) text: &'a str,
    pub(crate) model: Model,
    pub(crate) diags: Diags,
}

impl Reader<'_, '_> {
    pub(crate) fn span<T>(&self, s: &Spanned<T>) -> Span {
        self.source.span(s.span())
    }

    /// Keeps entries with a known key, and reports others; a similar key is replaced by the known one.
    pub(crate) fn admit(
        &mut self,
        list: Vec<Entry>,
        keys: &[&'static str],
        title: impl Fn(&str) -> String,
        all: impl Fn() -> String,
    ) -> Vec<Entry> {
        let written: Vec<String> = list.iter().map(|e| e.key.clone()).collect();
        let mut kept: Vec<Entry> = Vec::with_capacity(list.len());
        for mut e in list {
            if keys.contains(&e.key.as_str()) {
                kept.push(e);
                continue;
            }
            let free = |k: &&str| !written.iter().any(|w| w == k) && !kept.iter().any(|x| x.key == **k);
            let d = Diag::error("E004", title(&e.key)).at(e.key_span, "not known here");
            let other = OTHER_NAMES.iter().find(|o| o.0.eq_ignore_ascii_case(&e.key)).map(|o| o.1);
            let other = keys.iter().copied().find(|k| Some(*k) == other && free(k));
            match nearest(&e.key, keys.iter().copied().filter(free)).or(other) {
                Some(meant) => {
                    self.diags.push(d.help(format!("did you mean `{meant}`?")).fix(e.key_span, meant));
                    e.key = meant.into();
                    kept.push(e);
                }
                None => self.diags.push(d.help(all())),
            }
        }
        kept
    }

    /// Records the names in a table that is not read.
    pub(crate) fn lose(&mut self, table: &DeTable) {
        self.model.lost.extend(table.keys().map(|k| String::from(k.get_ref().as_ref())));
    }

    /// Checks the name of a module or a parameter. A quoted name with dots belongs to an instance in a written model.
    pub(crate) fn check_name(&mut self, word: &str, span: Span) -> bool {
        is_name(word) || self.check_word(word, span)
    }

    /// Checks a name of one word.
    pub(crate) fn check_word(&mut self, word: &str, span: Span) -> bool {
        if is_word(word) {
            return true;
        }
        let mut mended: String = word.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if mended.starts_with(|c: char| c.is_ascii_digit()) {
            mended.insert(0, '_');
        }
        let d = Diag::error("E014", format!("not a name: `{}`", word.escape_debug())).at(span, "not a name");
        let d = d.help("a name has letters a to z and A to Z, digits and `_`, and starts with a letter or `_`");
        // a name in other letters would become meaningless underscores
        self.diags.push(if word.is_ascii() && is_word(&mended) { d.fix(span, mended) } else { d });
        self.model.lost.push(word.into());
        false
    }
}

/// Sorts modules by place and removes those with a duplicate name.
pub(crate) fn unique(model: &mut Model, diags: &mut Diags) {
    model.items.sort_by_key(|i| i.name_span);
    model.items.shrink_to_fit();
    let groups = model.groups.iter().map(|g| (g.name.as_str(), g.span));
    let groups = groups.chain(model.uses.iter().map(|u| (u.name.as_str(), u.span)));
    if all_differ(groups.clone().map(|g| g.0).chain(model.items.iter().map(|i| i.name.as_str()))) {
        return;
    }
    let mut taken: BTreeMap<&str, Span> = groups.collect();
    let mut kept = Vec::with_capacity(model.items.len());
    for item in &model.items {
        let first = taken.get(item.name.as_str()).copied();
        kept.push(first.is_none());
        let Some(first) = first else {
            taken.insert(&item.name, item.name_span);
            continue;
        };
        diags.push(
            Diag::error("E012", format!("`{}` is used twice", item.name))
                .at(item.name_span, "again here")
                .at(first, "first here")
                .help("names are unique in a model: rename one of the two"),
        );
    }
    let mut kept = kept.into_iter();
    model.items.retain(|_| kept.next().unwrap_or(true));
}
