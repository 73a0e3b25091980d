//! Puts the parts into a model, in the order of the lines.

use super::expander::{Expander, Home, Open};
use super::fan::fan;
use super::scope::Scope;
use crate::diag::Diags;
use crate::model::{Entry, Model, Part, Use};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::rc::Rc;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Catalog;
use ca_core::internal::kind::cloud::Unread;
use hashbrown::HashSet;

/// Puts in the parts that `[use]` names. A model without that section is unchanged.
pub(crate) fn expand(model: &mut Model, diags: &mut Diags, catalog: &Catalog, open: Open<'_>) {
    if model.uses.is_empty() {
        return;
    }
    let items = core::mem::take(&mut model.items);
    let uses = model.uses.clone();
    let home = Home { file: String::new(), model: Model { parts: model.parts.clone(), ..Model::default() } };
    into(model, diags, catalog, open, |e| e.lines(&items, &uses, None, &Rc::new(home), &Scope::default()));
}

/// Adds instances of `part`, as `u` specifies, to a model that a program builds. [`super::lists`] resolves `[*]` in it.
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

/// Adds instances of the bundled part `name`, as `u` specifies, see [`super::library`].
pub fn add_shipped(model: &mut Model, name: &str, u: &Use, catalog: &Catalog) -> Diags {
    add_from(model, name, u, Model::default(), catalog)
}

/// Adds instances of a part called `name` in `body`, otherwise of a bundled one.
fn add_from(model: &mut Model, name: &str, u: &Use, body: Model, catalog: &Catalog) -> Diags {
    let (mut diags, mut u) = (Diags::new(), u.clone());
    u.part = Some(Entry::new("part", name));
    let home = Home { file: String::new(), model: body };
    let mut open =
        |name: &str| Err(Unread { what: format!("the file `{name}` is not available"), help: String::new() });
    into(model, &mut diags, catalog, &mut open, |e| e.place(&u, &Rc::new(home), &Scope::default()));
    diags.merge_instances();
    diags
}

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
        open_parts: Vec::new(),
    };
    let gestures = core::mem::take(&mut e.model.gestures);
    put(&mut e);
    let of_parts = core::mem::replace(&mut e.model.gestures, gestures);
    fan(&mut e.model, catalog, &mut e.diags);
    // gestures of the model replace gestures of its parts
    let mut written: HashSet<String> = e.model.gestures.iter().map(|g| g.key.clone()).collect();
    for g in of_parts {
        if written.insert(g.key.clone()) {
            e.model.gestures.push(g);
        }
    }
    (*model, *diags) = (e.model, e.diags);
}
