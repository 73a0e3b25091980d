//! Every place of a text where a name refers to something, and to what.
//!
//! The catalogue of kinds tells which parameters name modules and which name numbers; the rest are the sections.

use crate::TextEdit;
use crate::layout::{key, quoted};
use crate::symbols::{Class, Hit, Scope, Symbol, Want, Written};
use ca_core::Type;
use ca_model::{Entry, Span, Value};
use core::ops::Range;

/// Thing that contains a reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    /// A value of a symbol, with its keys, such as `with.f`.
    Of(Symbol, String),
    /// An entry of `[gesture]`, `[preset]`, `[equivalence]` or `[model]`, by its path.
    Entry(Vec<String>),
}

/// A text that names something.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    /// Bytes of the text, with quotes.
    pub range: Range<usize>,
    /// The text without quotes and escapes.
    pub text: String,
    /// True for a key, false for a value.
    pub is_key: bool,
    pub hits: Vec<Hit>,
    pub owner: Owner,
}

impl Written<'_> {
    /// Returns all references, in an order that does not depend on names.
    pub fn references(&self) -> Vec<Reference> {
        let mut all = List { written: self, found: Vec::new() };
        for scope in self.scopes() {
            all.modules(scope);
            all.settings(scope);
            all.uses(scope);
            for g in &self.body(scope).gestures {
                let path = self.path_at(g.key_span.start).cloned().unwrap_or_default();
                all.gesture(scope, g, &Owner::Entry(path));
            }
        }
        for e in self.model.meta.iter().filter(|e| matches!(e.key.as_str(), "gravity" | "friction" | "theta")) {
            all.value(None, e, Want::Number, &Owner::Entry(vec!["model".into(), e.key.clone()]));
        }
        all.keys();
        all.found
    }

    /// Writes new words into a reference. `new` gives the word for a symbol that changes.
    pub fn rewrite(&self, r: &Reference, new: &dyn Fn(Symbol) -> Option<String>) -> Option<TextEdit> {
        let mut text = r.text.clone();
        for hit in r.hits.iter().rev() {
            if let Some(word) = new(hit.symbol) {
                text.replace_range(hit.at.clone(), &word);
            }
        }
        self.rewritten(r, &text)
    }

    /// Writes a new text into a reference, with the quotes of the old one where possible.
    pub fn rewritten(&self, r: &Reference, text: &str) -> Option<TextEdit> {
        if text == r.text {
            return None;
        }
        let old = &self.text()[r.range.clone()];
        let quote = old.chars().next().filter(|c| matches!(c, '"' | '\''));
        let plain = !text.contains(['"', '\'', '\\']) && !text.contains(char::is_control);
        Some(TextEdit::new(
            r.range.clone(),
            match quote {
                Some(q) if plain && !old.starts_with(&[q; 3].iter().collect::<String>()) => format!("{q}{text}{q}"),
                None if r.is_key => key(text),
                _ => quoted(text),
            },
        ))
    }
}

struct List<'w, 'c> {
    written: &'w Written<'c>,
    found: Vec<Reference>,
}

impl List<'_, '_> {
    fn add(&mut self, span: Span, text: &str, hits: Vec<Hit>, owner: &Owner) {
        if hits.is_empty() || !span.is_some() {
            return;
        }
        let (text, owner) = (text.into(), owner.clone());
        self.found.push(Reference { range: span.start..span.end, text, is_key: false, hits, owner });
    }

    /// Finds names in all texts of a value.
    fn value(&mut self, scope: Scope, e: &Entry, want: Want, owner: &Owner) {
        match &e.value {
            Value::Text(t) => self.add(e.span, t, self.written.hits(scope, t, want), owner),
            Value::List(all) | Value::Table(all) => all.iter().for_each(|x| self.value(scope, x, want, owner)),
            Value::Num(_) | Value::Bool(_) => {}
        }
    }

    fn modules(&mut self, scope: Scope) {
        let w = self.written;
        for (index, item) in w.body(scope).items.iter().enumerate() {
            let symbol = Symbol { scope, class: Class::Module, index };
            let kind = w.catalog.get(&item.kind);
            for e in &item.args {
                let ty = kind.and_then(|k| k.param(&e.key).map(|i| k.params[i].ty));
                let owner = Owner::Of(symbol, e.key.clone());
                match (ty, &e.value) {
                    (Some(Type::Choice(words)), Value::Text(t)) if words.contains(&t.as_str()) => {}
                    (Some(Type::Between | Type::Module), _) => self.value(scope, e, Want::Module, &owner),
                    (Some(Type::Choice(_) | Type::Flag | Type::Text | Type::File), _) => {
                        self.value(scope, e, Want::Word, &owner);
                    }
                    _ => self.value(scope, e, Want::Number, &owner),
                }
            }
        }
    }

    /// Parameters, and properties of groups and parts.
    fn settings(&mut self, scope: Scope) {
        let w = self.written;
        for (index, g) in w.body(scope).groups.iter().enumerate() {
            let symbol = Symbol { scope, class: Class::Group, index };
            g.props.iter().for_each(|e| self.value(scope, e, Want::Number, &Owner::Of(symbol, e.key.clone())));
        }
        if let Some((index, part)) = scope.and_then(|i| w.model.parts.get(i).map(|p| (i, p))) {
            let symbol = Symbol { scope: None, class: Class::Part, index };
            part.props.iter().for_each(|e| self.value(scope, e, Want::Number, &Owner::Of(symbol, e.key.clone())));
        }
        for (index, p) in w.body(scope).params.iter().enumerate() {
            let owner = |key: &str| Owner::Of(Symbol { scope, class: Class::Param, index }, key.into());
            match &p.value {
                Value::Table(t) => {
                    for e in t {
                        match e.key.as_str() {
                            "port" => self.value(scope, e, Want::Module, &owner("port")),
                            "value" if scope.is_some() => self.value(scope, e, Want::Either, &owner("value")),
                            _ => {}
                        }
                    }
                }
                _ if scope.is_some() => self.value(scope, p, Want::Either, &owner("")),
                _ => {}
            }
        }
    }

    fn uses(&mut self, scope: Scope) {
        let w = self.written;
        for (index, u) in w.body(scope).uses.iter().enumerate() {
            let symbol = Symbol { scope, class: Class::Instance, index };
            if let (Some(e), Some(part)) = (&u.part, w.part_of(symbol)) {
                if let Value::Text(t) = &e.value {
                    let hit = Hit { at: 0..t.len(), symbol: Symbol { scope: None, class: Class::Part, index: part } };
                    self.add(e.span, t, vec![hit], &Owner::Of(symbol, "part".into()));
                }
            }
            u.n.iter().for_each(|e| self.value(scope, e, Want::Word, &Owner::Of(symbol, "n".into())));
            for e in &u.with {
                self.value(scope, e, Want::Either, &Owner::Of(symbol, format!("with.{}", e.key)));
            }
        }
    }

    /// `follow` names a port or a parameter; in a part, any text may name a parameter of it.
    fn gesture(&mut self, scope: Scope, e: &Entry, owner: &Owner) {
        match &e.value {
            _ if e.key == "follow" => self.value(scope, e, Want::Either, owner),
            Value::List(all) | Value::Table(all) => all.iter().for_each(|x| self.gesture(scope, x, owner)),
            Value::Text(_) if scope.is_some() => self.value(scope, e, Want::Either, owner),
            _ => {}
        }
    }

    /// Keys that are names: of gestures, presets and equivalences, and parameters in `with`.
    fn keys(&mut self) {
        let w = self.written;
        let mut found: Vec<Reference> = Vec::new();
        w.document.tree().words(&mut |path, word| {
            let (scope, rest) = match path {
                [part, name, rest @ ..] if part == "part" => (w.model.parts.iter().position(|p| p.name == *name), rest),
                _ => (None, path),
            };
            let (want, names) = match rest {
                [section, names @ ..] if section == "gesture" => (Want::Either, names),
                [section, names @ ..] if section == "equivalence" && scope.is_none() => (Want::Module, names),
                [section, _, names @ ..] if section == "preset" && scope.is_none() => (Want::Number, names),
                [section, name, with, param] if section == "use" && with == "with" => {
                    let instance = w.named(scope, name).filter(|s| s.class == Class::Instance);
                    let part = instance.and_then(|s| w.part_of(s));
                    if let (Some(instance), Some(symbol)) = (instance, part.and_then(|p| w.param(Some(p), param))) {
                        let hits = vec![Hit { at: 0..param.len(), symbol }];
                        let (owner, text) = (Owner::Of(instance, format!("with.{param}")), param.clone());
                        found.push(Reference { range: word.range.clone(), text, is_key: true, hits, owner });
                    }
                    return;
                }
                _ => return,
            };
            let Some((last, before)) = names.split_last() else { return };
            let before: usize = before.iter().map(|n| n.len() + 1).sum();
            let mut hits = w.hits(scope, &names.join("."), want);
            hits.retain(|h| h.at.start >= before);
            for h in &mut hits {
                h.at = h.at.start - before..h.at.end - before;
            }
            if !hits.is_empty() {
                let (owner, text) = (Owner::Entry(path.to_vec()), last.clone());
                found.push(Reference { range: word.range.clone(), text, is_key: true, hits, owner });
            }
        });
        self.found.extend(found);
    }
}
