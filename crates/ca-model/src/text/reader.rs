//! The reader at work: what it has of the text and of the model, and the questions all sections ask.
//!
//! Decides what is a name, what is nearly a known key, that what cannot be read is remembered by name, and that of two modules
//! of one name the first is kept.

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

/// What other programs and textbooks call a parameter.
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

/// A model being read.
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

    /// Keeps entries whose key is known, and those whose key is nearly so under the key that was meant.
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

    /// Remembers the names in a table that is not read.
    pub(crate) fn lose(&mut self, table: &DeTable) {
        self.model.lost.extend(table.keys().map(|k| String::from(k.get_ref().as_ref())));
    }

    /// A name of a module or a parameter. One with dots stood in quotes: it is of an instance, as a model is written whose parts
    /// are put in.
    pub(crate) fn check_name(&mut self, word: &str, span: Span) -> bool {
        is_name(word) || self.check_word(word, span)
    }

    /// A name of one word.
    pub(crate) fn check_word(&mut self, word: &str, span: Span) -> bool {
        if is_word(word) {
            return true;
        }
        let mut mended: String = word.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if mended.starts_with(|c: char| c.is_ascii_digit()) {
            mended.insert(0, '_');
        }
        let d = Diag::error("E014", format!("not a name: `{}`", word.escape_debug())).at(span, "not a name");
        let d = d.help("a name is made of the letters a to z and A to Z, digits and `_`, and starts with a letter");
        // of a word in other letters nothing that means anything is left
        self.diags.push(if word.is_ascii() && is_word(&mended) { d.fix(span, mended) } else { d });
        self.model.lost.push(word.into());
        false
    }
}

/// Sorts modules by place and leaves out those whose name is taken.
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
