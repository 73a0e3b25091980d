//! Puts in an instance of a part: resolves its parameters and prefixes its names.
//!
//! The lines of a model and of a part are handled by the same functions, since a line of a part may use another part.

use super::expander::{Expander, Home};
use super::find::below;
use super::read::first;
use super::scope::{Arg, Scope, is_number};
use crate::diag::Diag;
use crate::model::{Entry, Group, Item, LARGEST, Part, Use, Value};
use crate::quantity::Plain;
use crate::suggest::nearest;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::rc::Rc;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::{Kind, Type};

/// Largest depth of parts within parts.
const DEEP: usize = 16;

enum Line<'m> {
    Module(&'m Item),
    Use(&'m Use),
}

/// Returns modules and uses in the order of the text.
fn lines<'m>(items: &'m [Item], uses: &'m [Use]) -> Vec<Line<'m>> {
    let place = |l: &Line| match l {
        Line::Module(i) => i.name_span.start,
        Line::Use(u) => u.span.start,
    };
    let mut all: Vec<Line> = items.iter().map(Line::Module).chain(uses.iter().map(Line::Use)).collect();
    all.sort_by_key(place);
    all
}

impl Expander<'_> {
    /// Adds modules with their names in `scope`. `groups` maps groups of a part to groups of the model; `None` at the
    /// root.
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
                    // the first group is the instance itself
                    let group = groups.get(i.group.map_or(0, |g| g + 1)).copied();
                    self.model.items.push(Item { name, group, args, ..i.clone() });
                }
            }
        }
    }

    /// Puts in the instances of a line of `[use]` in `outer`.
    pub fn place(&mut self, u: &Use, home: &Rc<Home>, outer: &Scope) {
        let name = format!("{}{}", outer.prefix, u.name);
        for e in &u.with {
            self.of_file(e, None, &name, home, outer);
        }
        let Some((part, home)) = self.find(u, home) else {
            self.model.lost.push(name);
            return;
        };
        let this = (home.file.clone(), part.name.clone());
        let itself = self.open_parts.contains(&this);
        if itself || self.open_parts.len() >= DEEP {
            let (what, label, help) = if itself {
                ("uses itself".into(), "again here", "a part cannot use itself, directly or through other parts")
            } else {
                let what = format!("is nested more than {DEEP} deep");
                (what, "nested too deep", "write these modules directly in one of the enclosing parts")
            };
            let d = Diag::error("E033", format!("`{name}`: the part `{}` {what}", part.name));
            self.diags.push(d.at(first(u.part.as_ref(), u.span), label).help(help));
            self.model.lost.push(name);
            return;
        }
        let Ok(n) = self.count(u, &name, outer) else {
            self.model.lost.push(name);
            return;
        };
        if !self.fits(u, &name, n, &part, &home) {
            self.model.lost.push(name);
            return;
        }
        self.unknown(u, &name, &part);
        self.lengths(u, &name, n, &part);
        self.open_parts.push(this);
        for i in 0..n.unwrap_or(1) {
            let full = if n.is_some() { format!("{name}[{i}]") } else { name.clone() };
            let with = u.with.iter().map(|e| (e.key.as_str(), of_instance(e, n.map(|_| i)))).collect();
            self.instance(&full, u, &with, &part, &home, outer);
            // each instance counts as a group, even an empty one
            if self.model.items.len().max(self.model.groups.len()) >= LARGEST {
                self.too_many(u.span);
            }
            if self.is_over() {
                break;
            }
        }
        self.open_parts.pop();
    }

    /// Returns the number of instances, `None` for one without an index, or an error after a report.
    fn count(&mut self, u: &Use, name: &str, outer: &Scope) -> Result<Option<usize>, ()> {
        let Some(e) = &u.n else { return Ok(None) };
        let written = match &e.value {
            Value::Text(t) => match outer.plain(t) {
                Some(v) => {
                    outer.used.borrow_mut().insert(t.trim().into());
                    v.clone()
                }
                None => e.value.clone(),
            },
            v => v.clone(),
        };
        match written {
            Value::Num(v) if v == libm::floor(v) && (1.0..=LARGEST as f64).contains(&v) => Ok(Some(v as usize)),
            Value::Num(v) if v == libm::floor(v) && v > LARGEST as f64 => {
                let d = Diag::error("E027", format!("`n` of `{name}` is above {LARGEST}: {}", Plain(v)));
                let help = format!(
                    "a model must have fewer than {LARGEST} modules and instances; for real time, a few thousand"
                );
                self.diags.push(d.at(e.span, "too many").help(help));
                Err(())
            }
            _ => {
                let d = Diag::error("E006", format!("`n` of `{name}` must be a whole number, at least 1"));
                self.diags.push(
                    d.at(e.span, "not a whole number above 0").help("write the number of instances, e.g. `n = 12`"),
                );
                Err(())
            }
        }
    }

    fn unknown(&mut self, u: &Use, name: &str, part: &Part) {
        for e in u.with.iter().filter(|e| !part.body.params.iter().any(|p| p.key == e.key)) {
            let d = Diag::error("E004", format!("`{name}`: the part `{}` has no parameter `{}`", part.name, e.key));
            let d = d.at(e.key_span, "not known here");
            let params = || part.body.params.iter().map(|p| p.key.as_str());
            let all: Vec<String> = params().map(|p| format!("`{p}`")).collect();
            self.diags.push(match nearest(&e.key, params()) {
                Some(near) => d.help(format!("did you mean `{near}`?")).fix(e.key_span, near),
                None if all.is_empty() => d.help(format!("declare it in `[part.{}.param]`, which is empty", part.name)),
                None => d.help(format!("its parameters are {}", all.join(", "))),
            });
        }
    }

    /// Reports lists whose length differs from the number of instances.
    fn lengths(&mut self, u: &Use, name: &str, n: Option<usize>, part: &Part) {
        let Some(n) = n else { return };
        for e in &u.with {
            let Value::List(l) = &e.value else { continue };
            if l.len() != n {
                let d =
                    Diag::error("E018", format!("`{}` of `{name}` has {} values for {n} instances", e.key, l.len()));
                let d = d
                    .at(e.span, format!("{} values", l.len()))
                    .at(first(u.n.as_ref(), u.span), format!("{n} of `{}`", part.name));
                self.diags.push(d.help("write one value for each instance, or one value for all"));
            }
        }
    }

    fn instance(
        &mut self,
        full: &str,
        u: &Use,
        with: &BTreeMap<&str, Option<Entry>>,
        part: &Part,
        home: &Rc<Home>,
        outer: &Scope,
    ) {
        let body = &part.body;
        let own = body.items.iter().map(|i| head(&i.name)).chain(body.groups.iter().map(|g| g.name.as_str()));
        let own = own.chain(body.uses.iter().map(|u| u.name.as_str())).chain(body.lost.iter().map(|l| head(l)));
        let mut scope = Scope { prefix: format!("{full}."), own: own.map(Into::into).collect(), ..Scope::default() };
        let mut params = Vec::new();
        for p in &body.params {
            let (arg, param) = self.param(full, u, with.get(p.key.as_str()), (p, &body.params), outer, &scope);
            scope.args.insert(p.key.clone(), arg);
            params.push(param);
        }
        // the group of the instance, then the groups of the part, which inherit its properties unless they have others
        let props: Vec<Entry> = part.props.iter().map(|e| scope.entry(e, None)).collect();
        let mut groups = alloc::vec![self.model.groups.len()];
        self.model.groups.push(Group { name: full.into(), span: u.span, props: props.clone() });
        for g in &body.groups {
            let mut own: Vec<Entry> = g.props.iter().map(|e| scope.entry(e, None)).collect();
            own.extend(props.iter().filter(|p| !g.props.iter().any(|o| o.key == p.key)).cloned());
            groups.push(self.model.groups.len());
            self.model.groups.push(Group { name: format!("{full}.{}", g.name), span: g.span, props: own });
        }
        self.model.lost.extend(body.lost.iter().map(|l| format!("{full}.{l}")));
        self.lines(&body.items, &body.uses, Some(&groups), home, &scope);
        for g in &body.gestures {
            self.model.gestures.push(Entry { key: scope.name(&g.key), ..scope.resolve(g) });
        }
        self.one_of_many(full, u, &scope);
        let (used, named) = (scope.used.into_inner(), scope.named.into_inner());
        for (key, arg) in &scope.args {
            if let (Arg::Outer(..), Some(Some(Entry { value: Value::Text(of), .. })), true) =
                (arg, with.get(key.as_str()), used.contains(key))
            {
                outer.passed(of, named.contains(key));
            }
        }
        // an unused parameter is reported for the first instance only
        let said = full.ends_with(']') && !full.ends_with("[0]");
        for (p, param) in body.params.iter().zip(params) {
            let keep = named.contains(&p.key) || !used.contains(&p.key) && !said;
            self.model.params.extend(param.filter(|_| keep));
        }
    }

    /// Reports a list given for one number, which was meant for several instances.
    fn one_of_many(&mut self, full: &str, u: &Use, scope: &Scope) {
        for (key, n) in scope.lists.take() {
            let Some(e) = u.with.iter().find(|e| e.key == key && u.n.is_none()) else { continue };
            let d = Diag::error("E006", format!("`{key}` of `{full}` must be a number, not a list"));
            let help = format!("add `n = {n}` to make an instance for each value, or write one value");
            self.diags.push(d.at(e.span, format!("{n} values for one instance")).help(help));
        }
    }

    /// Returns the value of a parameter, and its `[param]` if it is a number.
    fn param(
        &mut self,
        full: &str,
        u: &Use,
        given: Option<&Option<Entry>>,
        (p, params): (&Entry, &[Entry]),
        outer: &Scope,
        scope: &Scope,
    ) -> (Arg, Option<Entry>) {
        let key = format!("{full}.{}", p.key);
        let known = |name: &str| self.root.contains(name) || outer.own.contains(name) || outer.args.contains_key(name);
        let table = if let Value::Table(t) = &p.value { Some(t) } else { None };
        if let Some(given) = given {
            let Some(e) = given else {
                self.model.lost.push(key);
                return (Arg::Missing, None);
            };
            let is_number = is_number(&e.value, &known);
            if let (false, Value::Text(t)) = (is_number, &e.value) {
                if let Some((meant, number)) = outer.reference(t) {
                    return (Arg::Outer(meant, number.clone(), e.span), None);
                }
            }
            let meant = outer.resolve(e).value;
            if !is_number {
                return (Arg::Other(meant, e.span), None);
            }
            let param = match table {
                Some(t) => {
                    let rest = t.iter().filter(|x| !matches!(x.key.as_str(), "value" | "port" | "span"));
                    let value = Entry { key: "value".into(), key_span: e.key_span, value: meant.clone(), span: e.span };
                    Value::Table(rest.cloned().chain([value]).collect())
                }
                None => meant.clone(),
            };
            return (Arg::Number(meant, e.span), Some(Entry { key, key_span: p.key_span, value: param, span: e.span }));
        }
        let default = match table {
            Some(t) => t.iter().find(|x| x.key == "value").map(|x| &x.value),
            None => Some(&p.value),
        };
        let driven = table.is_some_and(|t| t.iter().any(|x| x.key == "port"));
        let Some(default) = default.or(driven.then_some(&Value::Num(0.0))) else {
            let d =
                Diag::error("E005", format!("`{full}` needs `{}`", p.key)).at(u.span, format!("without `{}`", p.key));
            self.diags.push(
                d.at(p.key_span, "declared without a value")
                    .help(format!("add it to `with`, e.g. `with = {{ {} = … }}`", p.key)),
            );
            self.model.lost.push(key);
            return (Arg::Missing, None);
        };
        let inner =
            |name: &str| self.root.contains(name) || scope.own.contains(name) || params.iter().any(|p| p.key == name);
        if !is_number(default, &inner) {
            let default = Entry { value: default.clone(), ..p.clone() };
            return (Arg::Other(scope.resolve(&default).value, p.span), None);
        }
        let mut value = p.value.clone();
        if let Value::Table(t) = &mut value {
            for port in t.iter_mut().filter(|x| x.key == "port") {
                if let Value::Text(name) = &port.value {
                    port.value = Value::Text(scope.name(name));
                }
            }
        }
        (Arg::Number(default.clone(), p.span), Some(Entry { key, value, ..p.clone() }))
    }
}

/// Resolves a file that a part names from the folder of the part's file.
fn of_part(mut e: Entry, kind: Option<&'static Kind>, home: &Home) -> Entry {
    let file = kind.and_then(|k| k.param(&e.key).map(|i| k.params[i].ty)).is_some_and(|t| matches!(t, Type::File));
    if let (true, Value::Text(name)) = (file && !home.folder().is_empty(), &e.value) {
        if let Some(path) = below(home.folder(), name) {
            e.value = Value::Text(path);
        }
    }
    e
}

/// Returns the value for instance `i`. A list that is too short, which has been reported, gives its last value, so that
/// nothing else is reported as missing.
fn of_instance(e: &Entry, i: Option<usize>) -> Option<Entry> {
    match (&e.value, i) {
        (Value::List(l), Some(i)) => {
            let of = l.get(i).or(l.last())?;
            Some(Entry { key: e.key.clone(), key_span: e.key_span, ..of.clone() })
        }
        _ => Some(e.clone()),
    }
}

/// Returns the first word of a name, without an index.
fn head(name: &str) -> &str {
    name.split(['.', '[']).next().unwrap_or(name)
}
