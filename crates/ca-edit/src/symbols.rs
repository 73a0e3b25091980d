//! Names of a text and their meanings: modules, groups, instances, parameters, parts and presets, with their places.
//!
//! The reader of `ca-model` finds them; this module adds the path of keys at which each is written.

use crate::layout::Layout;
use crate::{Document, Refusal};
use ca_core::Catalog;
use ca_model::quantity::{is_quantity, product};
use ca_model::sections::SECTIONS;
use ca_model::select::is_word;
use ca_model::suggest::nearest;
use ca_model::{Model, Value, read};
use core::ops::Range;
use std::collections::HashMap;

/// Place of a definition: the model, or one of its parts by index.
pub(crate) type Scope = Option<usize>;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Class {
    Module,
    Group,
    Instance,
    Param,
    Part,
    Preset,
}

/// A named thing of the text. Its index is its position in its class, in the order of the text, so it stays the same
/// if only names change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Symbol {
    pub scope: Scope,
    pub class: Class,
    pub index: usize,
}

/// A name within a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Hit {
    pub at: Range<usize>,
    pub symbol: Symbol,
}

/// Things that a text may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Want {
    /// A module, as in `between`.
    Module,
    /// A parameter, alone or with a factor.
    Number,
    /// A parameter or a module, as in `with`.
    Either,
    /// A parameter of a part, where a choice or a text stands.
    Word,
}

/// A text that was read.
pub(crate) struct Written<'c> {
    pub document: Document,
    pub model: Model,
    pub catalog: &'c Catalog,
    names: HashMap<(Scope, String), Symbol>,
    params: HashMap<(Scope, String), Symbol>,
    /// Path of the word that begins at a byte.
    paths: HashMap<usize, Vec<String>>,
}

impl<'c> Written<'c> {
    pub fn read(text: &str, catalog: &'c Catalog) -> Result<Written<'c>, Refusal> {
        let document = Document::read(text)?;
        let model = read::written(text, "", catalog).0;
        let mut paths = HashMap::new();
        document.tree().words(&mut |path, word| _ = paths.insert(word.range.start, path.to_vec()));
        let (names, params) = (HashMap::new(), HashMap::new());
        let mut w = Written { document, model, catalog, names, params, paths };
        for scope in w.scopes() {
            let body = w.body(scope);
            let all = |class, list: Vec<String>| {
                list.into_iter().enumerate().map(move |(index, n)| (n, Symbol { scope, class, index }))
            };
            let modules = all(Class::Module, body.items.iter().map(|i| i.name.clone()).collect());
            let groups = all(Class::Group, body.groups.iter().map(|g| g.name.clone()).collect());
            let uses = all(Class::Instance, body.uses.iter().map(|u| u.name.clone()).collect());
            let params = all(Class::Param, body.params.iter().map(|p| p.key.clone()).collect());
            for (name, symbol) in modules.chain(groups).chain(uses) {
                w.names.entry((scope, name)).or_insert(symbol);
            }
            params.for_each(|(name, symbol)| _ = w.params.entry((scope, name)).or_insert(symbol));
        }
        Ok(w)
    }

    pub fn text(&self) -> &str {
        self.document.text()
    }

    pub fn layout(&self) -> Layout<'_> {
        Layout { catalog: Some(self.catalog), ..self.document.layout() }
    }

    /// Returns the model, then its parts.
    pub fn scopes(&self) -> Vec<Scope> {
        core::iter::once(None).chain((0..self.model.parts.len()).map(Some)).collect()
    }

    pub fn body(&self, scope: Scope) -> &Model {
        scope.and_then(|i| self.model.parts.get(i)).map_or(&self.model, |p| &p.body)
    }

    /// Returns the keys before the sections of a scope: `part.note` for a part.
    pub fn prefix(&self, scope: Scope) -> Vec<String> {
        let part = scope.and_then(|i| self.model.parts.get(i));
        part.map_or_else(Vec::new, |p| vec!["part".into(), p.name.clone()])
    }

    /// Returns the name in its scope: `beads.a` for a member of a group.
    pub fn name(&self, s: Symbol) -> &str {
        let body = self.body(s.scope);
        match s.class {
            Class::Module => &body.items[s.index].name,
            Class::Group => &body.groups[s.index].name,
            Class::Instance => &body.uses[s.index].name,
            Class::Param => &body.params[s.index].key,
            Class::Part => &self.model.parts[s.index].name,
            Class::Preset => &self.model.presets[s.index].key,
        }
    }

    /// Returns the keys from the root of the file to the definition.
    pub fn path(&self, s: Symbol) -> Vec<String> {
        let start = match s.class {
            Class::Module => self.body(s.scope).items[s.index].name_span.start,
            Class::Param => self.body(s.scope).params[s.index].key_span.start,
            _ => usize::MAX,
        };
        if let Some(path) = self.paths.get(&start) {
            return path.clone();
        }
        let section: &[&str] = match s.class {
            Class::Module | Class::Group => &[],
            Class::Instance => &["use"],
            Class::Param => &["param"],
            Class::Part => &["part"],
            Class::Preset => &["preset"],
        };
        let section = section.iter().map(|k| (*k).to_owned());
        self.prefix(s.scope).into_iter().chain(section).chain([self.name(s).to_owned()]).collect()
    }

    /// Returns the path of the word that begins at a byte.
    pub fn path_at(&self, start: usize) -> Option<&Vec<String>> {
        self.paths.get(&start)
    }

    /// Returns the name by which operations refer to a symbol.
    pub fn address(&self, s: Symbol) -> String {
        let before = self.prefix(s.scope).join(".");
        let dot = if before.is_empty() { "" } else { "." };
        let class = match s.class {
            Class::Module | Class::Group | Class::Instance => "",
            Class::Param => "param.",
            Class::Part => "part.",
            Class::Preset => "preset.",
        };
        format!("{before}{dot}{class}{}", self.name(s))
    }

    /// Finds what operations call `address`.
    pub fn find(&self, address: &str) -> Result<Symbol, Refusal> {
        let (scope, name) = self.scope_of(address);
        let found = match name.split_once('.') {
            Some(("param", rest)) => self.params.get(&(scope, rest.into())).copied(),
            Some(("preset", rest)) if scope.is_none() => self.at(Class::Preset, rest),
            Some(("part", rest)) if scope.is_none() => self.at(Class::Part, rest),
            _ => None,
        };
        let found = found.or_else(|| self.names.get(&(scope, name.into())).copied());
        found.or_else(|| self.params.get(&(scope, name.into())).copied()).ok_or_else(|| self.unknown(address))
    }

    /// Splits `part.note.hammer` into the part and the name in it.
    pub fn scope_of<'a>(&self, address: &'a str) -> (Scope, &'a str) {
        let inner = address.strip_prefix("part.").and_then(|rest| rest.split_once('.'));
        let part = inner.and_then(|(part, name)| {
            let index = self.model.parts.iter().position(|p| p.name == part)?;
            Some((Some(index), name))
        });
        part.unwrap_or((None, address))
    }

    fn at(&self, class: Class, name: &str) -> Option<Symbol> {
        let index = match class {
            Class::Part => self.model.parts.iter().position(|p| p.name == name),
            _ => self.model.presets.iter().position(|p| p.key == name),
        };
        index.map(|index| Symbol { scope: None, class, index })
    }

    pub fn unknown(&self, address: &str) -> Refusal {
        let (scope, name) = self.scope_of(address);
        let words = || self.names.keys().chain(self.params.keys()).filter(|k| k.0 == scope).map(|k| k.1.as_str());
        let mut all: Vec<&str> = words().collect();
        all.sort_unstable();
        let shown: String = address.chars().take(60).collect();
        let what = format!("the model has no `{}`", shown.escape_debug());
        Refusal::new(
            what,
            // the name may have a key behind it
            match nearest(name, all.iter().copied()).or_else(|| nearest(name.rsplit_once('.')?.0, all.iter().copied()))
            {
                Some(near) => format!("did you mean `{near}`?"),
                None => "name a module, a group, an instance, `param.NAME`, `preset.NAME` or `part.NAME`".into(),
            },
        )
    }

    /// Returns a module, group or instance by its name in a scope.
    pub fn named(&self, scope: Scope, name: &str) -> Option<Symbol> {
        self.names.get(&(scope, name.to_owned())).copied()
    }

    /// Returns a parameter by its name in a scope.
    pub fn param(&self, scope: Scope, name: &str) -> Option<Symbol> {
        self.params.get(&(scope, name.to_owned())).copied()
    }

    /// Returns the part of an instance, if this text defines it.
    pub fn part_of(&self, instance: Symbol) -> Option<usize> {
        let u = self.body(instance.scope).uses.get(instance.index)?;
        let (Some(part), None) = (&u.part, &u.file) else { return None };
        let Value::Text(name) = &part.value else { return None };
        self.model.parts.iter().position(|p| p.name == *name)
    }

    /// Checks that a name, with its group before it, can be given to something new in a scope.
    pub fn check_free(&self, scope: Scope, name: &str) -> Result<(), Refusal> {
        let shown: String = name.chars().take(60).collect();
        let shown = shown.escape_debug();
        let last = name.rsplit('.').next().unwrap_or(name);
        if !is_word(last) {
            let help = "a name has letters a to z and A to Z, digits and `_`, and begins with a letter or `_`";
            return Err(Refusal::new(format!("`{shown}` is not a name"), help));
        }
        if last.len() > LONGEST {
            return Err(Refusal::new(format!("`{shown}…` is too long"), format!("use at most {LONGEST} letters")));
        }
        if SECTIONS.contains(&name) || self.catalog.get(name).is_some() {
            let help = "choose another name: a section of the language has this one";
            return Err(Refusal::new(format!("`{shown}` cannot be used as a name"), help));
        }
        if self.named(scope, name).or_else(|| self.param(scope, name)).is_some() {
            return Err(Refusal::new(format!("`{shown}` is already used"), "choose another name"));
        }
        Ok(())
    }

    /// Finds the names in `text`, which stands in `scope`.
    pub fn hits(&self, scope: Scope, text: &str, want: Want) -> Vec<Hit> {
        let lead = text.len() - text.trim_start().len();
        let whole = lead..text.trim_end().len().max(lead);
        match want {
            Want::Word => scope.and_then(|_| self.param_at(scope, text, whole)).unwrap_or_default(),
            Want::Number => self.number(scope, text, whole),
            Want::Module => self.selector(scope, text, whole),
            Want::Either => {
                let number = self.number(scope, text, whole.clone());
                if number.is_empty() { self.selector(scope, text, whole) } else { number }
            }
        }
    }

    fn number(&self, scope: Scope, text: &str, whole: Range<usize>) -> Vec<Hit> {
        let at = match product(text) {
            Some((_, name)) => text.rfind(name).map_or(whole, |i| i..i + name.len()),
            None if is_quantity(text) => return Vec::new(),
            None => whole,
        };
        let own = scope.and_then(|_| self.param_at(scope, text, at.clone()));
        own.or_else(|| self.param_at(None, text, at)).unwrap_or_default()
    }

    fn selector(&self, scope: Scope, text: &str, whole: Range<usize>) -> Vec<Hit> {
        let (of, places) = match text[whole.clone()].split_once('@') {
            Some((of, places)) => (of.trim_end(), Some(places)),
            None => (&text[whole.clone()], None),
        };
        let of = whole.start..whole.start + of.len();
        let mut hits = self.module(scope, text, of);
        let mut at = whole.end - places.map_or(0, str::len);
        for place in places.into_iter().flat_map(|p| p.split(',')) {
            let start = at + place.len() - place.trim_start().len();
            let range = start..start + place.trim().len();
            at += place.len() + 1;
            let own = scope.and_then(|_| self.param_at(scope, text, range.clone()));
            let found = own.or_else(|| self.own(scope, text, range.clone()));
            let found = found.or_else(|| self.param_at(None, text, range.clone()));
            hits.extend(found.or_else(|| self.own(None, text, range)).unwrap_or_default());
        }
        hits
    }

    /// Finds a module: first in the part, then a parameter of the part, then in the model.
    fn module(&self, scope: Scope, text: &str, at: Range<usize>) -> Vec<Hit> {
        if let (Some(_), Some(hits)) = (scope, self.own(scope, text, at.clone())) {
            return hits;
        }
        let head = words(text, at.clone()).into_iter().next();
        let param = head.filter(|_| scope.is_some()).and_then(|head| self.param_at(scope, text, head));
        param.or_else(|| self.own(None, text, at)).unwrap_or_default()
    }

    /// Finds a module of one scope by its path, such as `note[0].bow.hair`.
    fn own(&self, scope: Scope, text: &str, at: Range<usize>) -> Option<Vec<Hit>> {
        let words = words(text, at.clone());
        let head = words.first()?;
        let end = |w: &Range<usize>| text[w.start..at.end].find('.').map_or(at.end, |i| w.start + i);
        let Some(symbol) = self.named(scope, &text[head.clone()]) else {
            // a quoted name with dots
            return words.iter().skip(1).find_map(|w| {
                let at = head.start..end(w);
                self.named(scope, &text[at.clone()]).map(|symbol| vec![Hit { at, symbol }])
            });
        };
        let mut hits = vec![Hit { at: head.clone(), symbol }];
        let Some(next) = words.get(1) else { return Some(hits) };
        if symbol.class == Class::Group {
            let member = format!("{}.{}", &text[head.clone()], &text[next.clone()]);
            hits.extend(self.named(scope, &member).map(|symbol| Hit { at: next.clone(), symbol }));
        }
        if let (Class::Instance, Some(part)) = (symbol.class, self.part_of(symbol)) {
            let rest = next.start..at.end;
            let inner = self.own(Some(part), text, rest.clone()).or_else(|| self.param_at(Some(part), text, rest));
            hits.extend(inner.unwrap_or_default());
        }
        Some(hits)
    }

    /// Finds a parameter of one scope, or of an instance in it.
    fn param_at(&self, scope: Scope, text: &str, at: Range<usize>) -> Option<Vec<Hit>> {
        if let Some(symbol) = self.param(scope, &text[at.clone()]) {
            return Some(vec![Hit { at, symbol }]);
        }
        let words = words(text, at.clone());
        let ([head, next, ..], true) = (words.as_slice(), text[at.clone()].contains('.')) else { return None };
        let symbol = self.named(scope, &text[head.clone()]).filter(|s| s.class == Class::Instance)?;
        let inner = self.param_at(Some(self.part_of(symbol)?), text, next.start..at.end)?;
        Some([vec![Hit { at: head.clone(), symbol }], inner].concat())
    }
}

/// Longest name of something new.
const LONGEST: usize = 100;

/// Returns the words of a dotted name, without their indices.
fn words(text: &str, at: Range<usize>) -> Vec<Range<usize>> {
    let (mut all, mut start, mut depth) = (Vec::new(), at.start, 0_usize);
    let mut add = |from: usize, to: usize| {
        let word = text[from..to].split('[').next().unwrap_or("");
        all.push(from..from + word.trim_end().len());
    };
    for (i, b) in text[at.clone()].bytes().enumerate() {
        match b {
            b'[' => depth += 1,
            b']' => depth = depth.saturating_sub(1),
            b'.' if depth == 0 => {
                add(start, at.start + i);
                start = at.start + i + 1;
            }
            _ => {}
        }
    }
    add(start, at.end);
    all
}
