//! Resolves names of a part in one of its instances.
//!
//! The type of its place decides. A number refers to a `[param]` of the instance, a selector to a module, and anything
//! else gets the value of the parameter.

use crate::model::{Entry, Span, Value};
use crate::quantity::{is_quantity, note, product};
use crate::select::is_name;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::{Kind, Type};
use core::cell::RefCell;

/// Value of a parameter of a part, with its place.
pub(super) enum Arg {
    /// Number: a `[param]` of the instance.
    Number(Value, Span),
    /// Number of the part around: the name of its `[param]`, and the number for places that cannot have a reference.
    Outer(Value, Value, Span),
    /// Name, list or flag.
    Other(Value, Span),
    /// Missing value, which has been reported.
    Missing,
}

/// Meaning of a text, and its place if that is not the place of the text.
type Meaning = (Value, Option<Span>);

/// Names of one instance; empty at the root of the model.
#[derive(Default)]
pub(super) struct Scope {
    /// Full name of the instance, with a dot.
    pub prefix: String,
    /// Modules, groups and instances in it.
    pub own: BTreeSet<String>,
    /// Parameters.
    pub args: BTreeMap<String, Arg>,
    /// Parameters that are used.
    pub used: RefCell<BTreeSet<String>>,
    /// Parameters among these that a number refers to by name.
    pub named: RefCell<BTreeSet<String>>,
    /// Lists given for one number, with their lengths.
    pub lists: RefCell<BTreeMap<String, usize>>,
}

impl Scope {
    /// Resolves the names in a value.
    pub fn entry(&self, e: &Entry, kind: Option<&'static Kind>) -> Entry {
        let ty = kind.and_then(|k| k.param(&e.key).map(|i| k.params[i].ty));
        match ty {
            Some(Type::Between | Type::Module) => each(e, &|t| self.selector(t)),
            Some(Type::Choice(words)) => match &e.value {
                Value::Text(t) if words.contains(&t.as_str()) => e.clone(),
                _ => each(e, &|t| self.word(t)),
            },
            // `midi` contains words and numbers
            Some(Type::Midi) => each(e, &|t| self.word(t).or_else(|| self.scaled(t))),
            Some(Type::Flag | Type::Text | Type::File) => each(e, &|t| self.word(t)),
            Some(Type::Number { .. } | Type::PowerStiffness { .. } | Type::Count { .. }) => {
                if let Value::Text(t) = &e.value {
                    let name = product(t).map_or(t.trim(), |p| p.1);
                    if let Some(Arg::Other(Value::List(l), _)) = self.args.get(name) {
                        self.lists.borrow_mut().insert(name.into(), l.len());
                    }
                }
                each(e, &|t| self.number(t))
            }
            _ => each(e, &|t| self.number(t)),
        }
    }

    /// Resolves the names in a value that is given to a part within this scope.
    pub fn resolve(&self, e: &Entry) -> Entry {
        each(e, &|t| self.number(t).or_else(|| self.selector(t)))
    }

    fn arg(&self, name: &str) -> Option<&Arg> {
        let (name, arg) = self.args.get_key_value(name.trim())?;
        self.used.borrow_mut().insert(name.clone());
        Some(arg)
    }

    fn number(&self, text: &str) -> Option<Meaning> {
        if let Some(scaled) = self.scaled(text) {
            return Some(scaled);
        }
        match self.arg(text)? {
            Arg::Number(..) | Arg::Missing => {
                self.named.borrow_mut().insert(text.trim().into());
                Some((Value::Text(format!("{}{}", self.prefix, text.trim())), None))
            }
            Arg::Outer(v, _, span) => {
                self.named.borrow_mut().insert(text.trim().into());
                Some((v.clone(), Some(*span)))
            }
            Arg::Other(v, span) => Some((v.clone(), Some(*span))),
        }
    }

    /// Resolves a number times a parameter, which remains a product.
    fn scaled(&self, text: &str) -> Option<Meaning> {
        let (factor, name) = product(text)?;
        let arg = self.arg(name)?;
        if !matches!(arg, Arg::Other(..)) {
            self.named.borrow_mut().insert(name.into());
        }
        let (factor, name) = match arg {
            Arg::Number(..) | Arg::Missing => (factor, format!("{}{name}", self.prefix)),
            Arg::Outer(Value::Text(t), ..) | Arg::Other(Value::Text(t), _) => match product(t) {
                Some((more, name)) => (factor * more, name.into()),
                None => (factor, t.clone()),
            },
            // a list or a flag: the finding about it applies to this value
            Arg::Outer(v, _, span) | Arg::Other(v, span) => return Some((v.clone(), Some(*span))),
        };
        Some((Value::Text(format!("{factor} {name}")), None))
    }

    /// Returns a parameter that is a number, as its `[param]` and as the number. It is marked as used later, once the
    /// part that it is given to is put in ([`Scope::passed`]).
    pub fn reference(&self, name: &str) -> Option<(Value, &Value)> {
        let name = name.trim();
        match self.args.get(name)? {
            Arg::Number(v, _) => Some((Value::Text(format!("{}{name}", self.prefix)), v)),
            Arg::Outer(meant, v, _) => Some((meant.clone(), v)),
            Arg::Other(..) | Arg::Missing => None,
        }
    }

    /// Marks a parameter as used, because it is given to a part within that uses it, by name or not.
    pub fn passed(&self, name: &str, by_name: bool) {
        self.used.borrow_mut().insert(name.trim().into());
        if by_name {
            self.named.borrow_mut().insert(name.trim().into());
        }
    }

    /// Returns the number that a parameter stands for.
    pub fn plain(&self, name: &str) -> Option<&Value> {
        match self.args.get(name.trim())? {
            Arg::Number(v, _) | Arg::Outer(_, v, _) => Some(v),
            Arg::Other(..) | Arg::Missing => None,
        }
    }

    fn word(&self, text: &str) -> Option<Meaning> {
        match self.arg(text)? {
            Arg::Number(v, span) | Arg::Outer(_, v, span) | Arg::Other(v, span) => Some((v.clone(), Some(*span))),
            Arg::Missing => None,
        }
    }

    /// Resolves a text where a module belongs: a module of the instance, of a parameter, or else of the model.
    fn selector(&self, text: &str) -> Option<Meaning> {
        let text = text.trim();
        let (of, places) = match text.split_once('@') {
            Some((of, places)) => (of, Some(places)),
            None => (text, None),
        };
        let head = of.split(['.', '[', ' ']).next().unwrap_or("");
        let place = |p: &str| match self.arg(p) {
            Some(Arg::Other(Value::Text(t), _)) => t.clone(),
            Some(arg) => {
                self.named.borrow_mut().insert(p.trim().into());
                match arg {
                    Arg::Outer(Value::Text(t), ..) => t.clone(),
                    _ => format!("{}{}", self.prefix, p.trim()),
                }
            }
            None if self.own.contains(p.trim()) => format!("{}{}", self.prefix, p.trim()),
            None => p.into(),
        };
        let places = places.map(|all| format!("@{}", all.split(',').map(place).collect::<Vec<_>>().join(",")));
        let places = places.unwrap_or_default();
        if self.own.contains(head) {
            return Some((Value::Text(format!("{}{of}{places}", self.prefix)), None));
        }
        let rest = of.get(head.len()..).unwrap_or("");
        match self.arg(head) {
            Some(Arg::Other(Value::Text(t), span)) => {
                let whole = rest.is_empty() && places.is_empty();
                Some((Value::Text(format!("{t}{rest}{places}")), whole.then_some(*span)))
            }
            Some(Arg::Other(v, span)) if rest.is_empty() && places.is_empty() => Some((v.clone(), Some(*span))),
            _ if places.is_empty() => None,
            _ => Some((Value::Text(format!("{of}{places}")), None)),
        }
    }

    /// Returns the full name for a key of `[gesture]` or a `port`.
    pub fn name(&self, text: &str) -> String {
        match self.arg(text) {
            Some(Arg::Other(Value::Text(t), _)) => return t.clone(),
            Some(Arg::Outer(Value::Text(t), ..)) => {
                self.named.borrow_mut().insert(text.trim().into());
                return t.clone();
            }
            Some(Arg::Number(..)) => {
                self.named.borrow_mut().insert(text.trim().into());
                return format!("{}{text}", self.prefix);
            }
            _ => {}
        }
        match self.selector(text) {
            Some((Value::Text(t), _)) => t,
            _ => text.into(),
        }
    }
}

/// Copies an entry and replaces every text that `means` resolves.
fn each(e: &Entry, means: &dyn Fn(&str) -> Option<Meaning>) -> Entry {
    let list = |l: &[Entry]| -> Vec<Entry> { l.iter().map(|x| each(x, means)).collect() };
    let (value, span) = match &e.value {
        Value::Text(t) => match means(t) {
            Some((value, span)) => (value, span.filter(|s| s.is_some()).unwrap_or(e.span)),
            None => (e.value.clone(), e.span),
        },
        Value::List(l) => (Value::List(list(l)), e.span),
        Value::Table(l) => (Value::Table(list(l)), e.span),
        other => (other.clone(), e.span),
    };
    Entry { key: e.key.clone(), key_span: e.key_span, value, span }
}

/// Returns true if a value is a number. A text is one unless it names something in the model.
pub(super) fn is_number(value: &Value, known: &dyn Fn(&str) -> bool) -> bool {
    match value {
        Value::Num(_) | Value::Table(_) => true,
        Value::Text(t) if is_name(t.trim()) && known(t.trim()) => false,
        Value::Text(t) if product(t).is_some_and(|(_, name)| known(name)) => false,
        Value::Text(t) => is_quantity(t) || note(t).is_some(),
        _ => false,
    }
}
