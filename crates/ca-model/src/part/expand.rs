//! Expand: the modules of a model and those of the parts it uses, in the order in which the lines stand.

use super::fan::fan;
use super::find::Home;
use super::instance::of_part;
use super::scope::Scope;
use super::size::Size;
use super::{Part, Use};
use crate::diag::{Diag, Diags};
use crate::{Entry, Item, LARGEST, Model, Span};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::rc::Rc;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Catalog;
use ca_core::kind::cloud::Unread;
use hashbrown::HashSet;

/// What a file holds, by its path from the folder of the model.
pub(crate) type Open<'f> = &'f mut dyn FnMut(&str) -> Result<String, Unread>;

/// A model whose parts are put in.
pub(super) struct Expander<'e> {
    pub catalog: &'e Catalog,
    pub open: Open<'e>,
    pub model: Model,
    pub diags: Diags,
    /// files that were asked for; what cannot be read has been reported
    pub files: BTreeMap<String, Option<Rc<Home>>>,
    /// parameters and modules at the root
    pub root: BTreeSet<String>,
    /// what an instance of a part makes, by file and name
    pub sizes: BTreeMap<(String, String), Size>,
    /// there are too many of them
    pub over: bool,
    /// the parts that are being put in, each in the one before: file and name
    pub within: Vec<(String, String)>,
}

/// A line that makes modules.
pub(super) enum Line<'m> {
    Module(&'m Item),
    Use(&'m Use),
}

/// Modules and uses in the order of the text.
pub(super) fn lines<'m>(items: &'m [Item], uses: &'m [Use]) -> Vec<Line<'m>> {
    let place = |l: &Line| match l {
        Line::Module(i) => i.name_span.start,
        Line::Use(u) => u.span.start,
    };
    let mut all: Vec<Line> = items.iter().map(Line::Module).chain(uses.iter().map(Line::Use)).collect();
    all.sort_by_key(place);
    all
}

/// Puts the parts in that `[use]` names. Nothing is done to a model without that section.
pub(crate) fn expand(model: &mut Model, diags: &mut Diags, catalog: &Catalog, open: Open<'_>) {
    if model.uses.is_empty() {
        return;
    }
    let items = core::mem::take(&mut model.items);
    let uses = model.uses.clone();
    let home = Home { file: String::new(), model: Model { parts: model.parts.clone(), ..Model::default() } };
    into(model, diags, catalog, open, |e| e.lines(&items, &uses, None, &Rc::new(home), &Scope::default()));
}

/// Adds what `u` says of `part` to a model that a program builds; lists of many instances are made by [`super::lists`].
///
/// ```
/// use ca_model::part::{self, Part, Use};
/// use ca_model::{Entry, Model, Span, Value};
/// let mut body = Model::default();
/// body.params.push(Entry::new("f", Value::Table(Vec::new())));
/// body.add("CEL", "bar", [Entry::new("m", "1 g"), Entry::new("f", "f")]);
/// let part = Part { name: "tine".into(), span: Span::NONE, doc: String::new(), props: Vec::new(), body };
/// let mut u = Use::new("tine");
/// (u.n, u.with) = (Some(Entry::new("n", 2.0)), vec![Entry::new("f", vec!["C4", "E4"])]);
/// let mut model = Model::default();
/// let found = part::add(&mut model, &part, &u, &ca_model::catalog());
/// assert!(!found.has_errors());
/// assert_eq!(model.items[1].name, "tine[1].bar");
/// ```
pub fn add(model: &mut Model, part: &Part, u: &Use, catalog: &Catalog) -> Diags {
    let body = Model { parts: Vec::from([part.clone()]), ..Model::default() };
    add_from(model, &part.name, u, body, catalog)
}

/// Adds what `u` says of the part `name` that comes with the program, see [`super::library`].
pub fn add_shipped(model: &mut Model, name: &str, u: &Use, catalog: &Catalog) -> Diags {
    add_from(model, name, u, Model::default(), catalog)
}

/// The same of a part called `name` among those of `body`, or else of the program.
fn add_from(model: &mut Model, name: &str, u: &Use, body: Model, catalog: &Catalog) -> Diags {
    let (mut diags, mut u) = (Diags::new(), u.clone());
    u.part = Some(Entry::new("part", name));
    let home = Home { file: String::new(), model: body };
    let mut open = |name: &str| Err(Unread { what: format!("`{name}` is not at hand"), help: String::new() });
    into(model, &mut diags, catalog, &mut open, |e| e.place(&u, &Rc::new(home), &Scope::default()));
    diags.merge_instances();
    diags
}

/// Lets `put` add modules to `model`.
fn into(model: &mut Model, diags: &mut Diags, catalog: &Catalog, open: Open<'_>, put: impl FnOnce(&mut Expander<'_>)) {
    let params = model.params.iter().map(|p| &p.key);
    let names = params.chain(model.items.iter().map(|i| &i.name)).chain(model.groups.iter().map(|g| &g.name));
    let root = names.chain(model.uses.iter().map(|u| &u.name)).cloned().collect();
    let mut e = Expander {
        catalog,
        open,
        model: core::mem::take(model),
        diags: core::mem::take(diags),
        files: BTreeMap::new(),
        root,
        sizes: BTreeMap::new(),
        over: false,
        within: Vec::new(),
    };
    let gestures = core::mem::take(&mut e.model.gestures);
    put(&mut e);
    let of_parts = core::mem::replace(&mut e.model.gestures, gestures);
    fan(&mut e.model, catalog, &mut e.diags);
    // what is written in the model counts, not what its parts would play
    let mut written: HashSet<String> = e.model.gestures.iter().map(|g| g.key.clone()).collect();
    for g in of_parts {
        if written.insert(g.key.clone()) {
            e.model.gestures.push(g);
        }
    }
    (*model, *diags) = (e.model, e.diags);
}

impl Expander<'_> {
    /// Adds modules as they are called in `scope`; `groups` are the numbers of their groups in the model, where these are not
    /// what they say.
    pub fn lines(&mut self, items: &[Item], uses: &[Use], groups: Option<&[usize]>, home: &Rc<Home>, scope: &Scope) {
        for line in lines(items, uses) {
            if self.is_over() {
                return;
            }
            match line {
                Line::Use(u) => self.place(u, home, scope),
                Line::Module(i) if self.model.items.len() >= LARGEST => {
                    return self.too_many(i.name_span);
                }
                Line::Module(i) => {
                    let Some(groups) = groups else {
                        self.model.items.push(i.clone());
                        continue;
                    };
                    let kind = self.catalog.get(&i.kind);
                    let args = i.args.iter().map(|e| of_part(scope.entry(e, kind), kind, home)).collect();
                    let name = format!("{}{}", scope.prefix, i.name);
                    for e in &i.args {
                        self.of_file(e, kind, &name, home, scope);
                    }
                    // the first is that of the instance
                    let group = groups.get(i.group.map_or(0, |g| g + 1)).copied();
                    self.model.items.push(Item { name, group, args, ..i.clone() });
                }
            }
        }
    }

    /// Whether nothing more is put in.
    pub fn is_over(&self) -> bool {
        self.over || self.diags.is_full()
    }

    pub fn too_many(&mut self, at: Span) {
        self.over = true;
        if !self.diags.list.iter().any(|d| d.code == "E027") {
            let d =
                Diag::error("E027", format!("more than {LARGEST} modules, with those of parts")).at(at, "from here on");
            self.diags.push(d.help("a model holds no more, and a real-time one some thousands"));
        }
    }
}
