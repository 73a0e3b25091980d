//! Resolves references (names in quotes) to ends of links, outputs and moving points.

use crate::connect::measure;
use crate::connect::select::{Meaning, Written};
use crate::connect::sets::output_names;
use crate::connect::wiring::{Wiring, broken};
use crate::findings::type_name;
use crate::lower::space;
use crate::net::{End, LiaNode, Measure, Push, Resolved, SecondPort, Wired};
use crate::options::{KernelClass, Options};
use alloc::boxed::Box;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::vec::Vec;
use ca_core::internal::kind::PortRole;
use ca_core::internal::kind::name::{Index, Part};
use ca_core::internal::phi::Pairs;
use ca_core::{Name, Role};
use ca_model::LARGEST;
use ca_model::diag::{Diag, Diags};
use ca_model::{Entry, Item, Model, Span, Value};

const LINKED: &str = "a link joins MATs: masses, fixed points, cells, ports moved from outside";

/// Adds links, force ports, outputs and probes.
pub fn wire(model: &Model, net: Resolved, options: &Options, diags: &mut Diags) -> Wired {
    let (heard, broken) = (output_names(model, options), broken(model, &net));
    let mut w = Wiring {
        model,
        net: net.into(),
        diags,
        output_names: heard,
        points: BTreeMap::new(),
        broken,
        over: false,
        under: 0,
    };
    let links = w.net.items.iter().filter(|i| matches!(i.kind.role, Role::Lia(_))).count();
    w.net.lias.reserve_exact(links);
    for id in 0..w.net.items.len() {
        if let Role::Lia(_) = w.net.items[id].kind.role {
            w.link(id as u32, options);
            // The values are in the slots from now on, unless some follow a parameter.
            let item = &mut w.net.items[id];
            if item.follows.is_empty() {
                item.args = Vec::new();
            }
        }
        if w.diags.is_full() {
            return w.net;
        }
    }
    for id in 0..w.net.items.len() {
        match w.net.items[id].kind.role {
            Role::Port(PortRole::Enf) => w.push(id as u32),
            Role::Port(PortRole::Sox) => w.output(id as u32, false),
            Role::Port(PortRole::Sof) => w.output(id as u32, true),
            _ => {}
        }
    }
    w.broken_items();
    for (asked, probe) in options.probes.iter().enumerate() {
        w.probe(probe, asked as u32);
    }
    if let (Some(name), false) = (&w.net.incomplete, w.diags.has_errors()) {
        let d = Diag::error("E013", format!("`{name}` could not be read, but something else refers to it"));
        w.diags.push(d.help("fix the errors in the file first"));
    }
    w.net
}

impl<'a> Wiring<'a> {
    fn item(&self, id: u32) -> &'a Item {
        &self.model.items[self.net.items[id as usize].model]
    }

    pub(super) fn entry(&self, id: u32, key: &str) -> Option<&'a Entry> {
        self.item(id).args.iter().find(|e| e.key == key)
    }

    /// Returns the ends on one side of `between`, or the targets of a force; `why` describes what is expected there.
    fn side(&mut self, e: &Entry, owner: &str, key: &str, why: &str) -> Option<Vec<End>> {
        match &e.value {
            Value::Text(t) => match self.select(Written { text: t, span: e.span, owner }, Some(why))? {
                Meaning::Ends(v) => Some(v),
                Meaning::Links(_) => None,
            },
            Value::List(l) => {
                let mut all = Some(Vec::new());
                for x in l {
                    let ends = self.side(x, owner, key, why);
                    if all.as_ref().zip(ends.as_ref()).is_some_and(|(a, b)| a.len() + b.len() > LARGEST) {
                        self.too_many(owner, "ends", e.span);
                        return None;
                    }
                    all = all.zip(ends).map(|(mut a, b)| {
                        a.extend(b);
                        a
                    });
                }
                all
            }
            other => {
                let title = format!("`{key}` of `{owner}` must be the name of a module, not {}", type_name(other));
                let d = Diag::error("E006", title).at(e.span, "not a name");
                let quoted = "put the name in quotes, e.g. `\"hammer\"` or `\"low[8]\"`";
                self.diags.push(d.help(quoted));
                None
            }
        }
    }

    pub(super) fn too_many(&mut self, owner: &str, what: &str, span: Span) {
        let d = Diag::error("E027", format!("`{owner}` has too many {what}")).at(span, "here");
        self.diags.push(d.help(format!("use fewer: a model can have up to {LARGEST} masses and links")));
    }

    fn link(&mut self, id: u32, options: &Options) {
        let (name, kind) = (self.net.items[id as usize].name.clone(), self.net.items[id as usize].kind);
        let Role::Lia(law) = kind.role else { return };
        let Some(e) = self.entry(id, "between") else { return };
        let help = "write `between = [\"first\", \"second\"]`";
        let Value::List(l) = &e.value else {
            let d = Diag::error("E006", format!("`between` of `{name}` must be a list of two ends"));
            self.diags.push(d.at(e.span, format!("this is {}", type_name(&e.value))).help(help));
            return;
        };
        let [first, second] = l.as_slice() else {
            let count =
                ["no ends", "one end"].get(l.len()).map_or_else(|| format!("{} ends", l.len()), |s| (*s).into());
            let d =
                Diag::error("E018", format!("`between` of `{name}` has {count}, not two")).at(e.span, "needs two ends");
            let help = if l.len() > 2 {
                "a link has a first and a second end; to link many, make each side a list: `[[\"a\", \"b\"], \"c\"]`"
            } else {
                help
            };
            self.diags.push(d.help(help));
            return;
        };
        let (a, b) = (self.side(first, &name, "between", LINKED), self.side(second, &name, "between", LINKED));
        let (Some(a), Some(b)) = (a, b) else { return };
        if let Some((side, _)) = [(first, &a), (second, &b)].into_iter().find(|(_, ends)| ends.is_empty()) {
            let d = Diag::error("E018", format!("`{name}` joins nothing: one side of `between` is empty"))
                .at(side.span, "empty");
            self.diags.push(d.help(help));
            return;
        }
        let arg = |key: &str| kind.param(key).and_then(|i| self.net.items[id as usize].args[i].num());
        // A set with itself makes all pairs: one to one would join each member to itself.
        let all = Pairs::of(arg("pairs")) == Pairs::All || (a.len() > 1 && a == b);
        let (l0, soften) = (arg("l0"), arg("soften").unwrap_or(0.0));
        if all && options.kernel != KernelClass::Reference && self.set(id, law, (&a, &b), options) {
            return;
        }
        let count = match (all, a == b) {
            (true, true) => a.len().saturating_mul(a.len() - 1) / 2,
            (true, false) => a.len().saturating_mul(b.len()),
            (false, _) => a.len().max(b.len()),
        };
        if self.net.mats.len() + self.net.lias.len() + count > LARGEST {
            // Reported once.
            if !core::mem::replace(&mut self.over, true) {
                self.too_many(&name, "links", e.span);
            }
            return;
        }
        let pairs: Vec<[End; 2]> = if all && a == b {
            (0..a.len()).flat_map(|i| (i + 1..a.len()).map(move |j| (i, j))).map(|(i, j)| [a[i], a[j]]).collect()
        } else if all {
            a.iter().flat_map(|x| b.iter().map(move |y| [*x, *y])).collect()
        } else if a.len() == b.len() {
            a.iter().zip(&b).map(|(x, y)| [*x, *y]).collect()
        } else if a.len() == 1 || b.len() == 1 {
            (0..count).map(|i| [a[i.min(a.len() - 1)], b[i.min(b.len() - 1)]]).collect()
        } else {
            let ends = |n: usize| if n == 1 { "1 end".into() } else { format!("{n} ends") };
            let d = Diag::error(
                "E018",
                format!("`{name}` has {} on one side and {} on the other", ends(a.len()), ends(b.len())),
            );
            let d = d.at(first.span, ends(a.len())).at(second.span, ends(b.len()));
            self.diags.push(
                d.help("use the same number of ends on both sides, a single end on one side, or `pairs = \"all\"`"),
            );
            return;
        };
        if pairs.is_empty() {
            let d = Diag::error("E018", format!("`{name}` joins nothing: a module cannot be paired with itself"));
            self.diags.push(d.at(e.span, "no pair").help("name two different modules"));
            return;
        }
        let Ok(onto) = self.onto(id, &name, pairs.len()) else { return };
        let along = kind.param("along").and_then(|i| space::direction(&self.net.items[id as usize].args[i]));
        let points = |end: &End| if let End::Point(_) = end { self.net.under(*end).len() } else { 0 };
        self.under = self.under.saturating_add(pairs.iter().flatten().map(points).sum());
        if self.under > 40 * LARGEST {
            self.too_many(&name, "links to moving points on long strings", e.span);
            return;
        }
        let values = self.net.own_values(kind.params.len());
        let many = pairs.len() > 1;
        let mut made = Vec::with_capacity(pairs.len());
        for (i, ends) in pairs.into_iter().enumerate() {
            if ends[0] == ends[1] {
                let d = Diag::error("E022", format!("`{name}` joins `{}` to itself", self.net.end_name(ends[0])));
                let help = if many {
                    "leave it out of one side, or use `pairs = \"all\"` with the same list on both sides"
                } else {
                    "name two different modules"
                };
                self.diags.push(d.at(e.span, "the same at both ends").help(help));
                return;
            }
            let measured = match onto.get(i) {
                None => measure::measure(&self.net, ends, along).map(|m| (m, None)),
                Some(o) => self.ports(ends, *o).map(|(m, o)| (m, Some(o))),
            };
            let (mut measure, mut onto) = match measured {
                Ok(found) => found,
                Err((what, help)) => {
                    let at = self.entry(id, "along").map_or(e.span, |e| e.span);
                    let d = Diag::error("E029", format!("`{name}` {what}")).at(at, "does not fit");
                    self.diags.push(d.help(help));
                    return;
                }
            };
            let mut ends = ends;
            // A quadripole is symmetric in its ports: the port in space comes first.
            if let (Measure::Line(_), Some(o @ SecondPort { measure: Measure::Radial, .. })) = (measure, &mut onto) {
                core::mem::swap(&mut ends, &mut o.ends);
                core::mem::swap(&mut measure, &mut o.measure);
            }
            let index = if many { i.into() } else { Index::None };
            let name = Name::new(&name, Part::Own, index);
            let (values, onto) = (values.clone(), onto.map(Box::new));
            let node = LiaNode { name, kind, law, values, ends, measure, onto, sets: None, l0, soften, item: id };
            if soften > 0.0 && !node.is_radial() {
                let at = self.entry(id, "soften").map_or(e.span, |e| e.span);
                let d = Diag::error("E029", format!("`{}` has `soften`, but measures no distance in space", node.name))
                    .at(at, "not a distance");
                self.diags.push(d.help("leave out `soften`, which keeps the direction of a distance in space defined"));
                return;
            }
            for l in measure::vectorial(&self.net, node) {
                made.push(self.net.lias.len() as u32);
                self.net.lias.push(l);
            }
        }
        self.net.families.insert_links(&name, made);
    }

    /// Returns the measures of both ports of a quadripole, or title and help of an error if the ends of one port are in
    /// different worlds.
    fn ports(&self, first: [End; 2], second: [End; 2]) -> Result<(Measure, SecondPort), (&'static str, &'static str)> {
        let measure = |ends| measure::measure(&self.net, ends, None);
        let help = "the two ends of a port must both be on a line or both be in space";
        let first = measure(first).map_err(|_| ("has one end of `between` on a line and one in space", help))?;
        let there = measure(second).map_err(|_| ("has one end of `onto` on a line and one in space", help))?;
        Ok((first, SecondPort { ends: second, measure: there }))
    }

    /// Returns the second ports of `count` quadripoles, one pair of ends each; empty for a link of two ends.
    fn onto(&mut self, id: u32, name: &str, count: usize) -> Result<Vec<[End; 2]>, ()> {
        let Some(e) = self.entry(id, "onto") else { return Ok(Vec::new()) };
        let help = "write `onto = [\"first\", \"second\"]`, the two ends of the second port";
        let pair = if let Value::List(l) = &e.value { <&[Entry; 2]>::try_from(l.as_slice()).ok() } else { None };
        let Some([first, second]) = pair else {
            let d = Diag::error("E018", format!("`onto` of `{name}` is not a pair of ends"));
            self.diags.push(d.at(e.span, "needs two ends").help(help));
            return Err(());
        };
        let (a, b) = (self.side(first, name, "onto", LINKED), self.side(second, name, "onto", LINKED));
        let (Some(a), Some(b)) = (a, b) else { return Err(()) };
        if [&a, &b].iter().any(|side| side.is_empty() || (side.len() != 1 && side.len() != count)) {
            let (a, b) = (a.len(), b.len());
            let title = format!("`{name}` makes {count} links, but `onto` has {a} and {b} ends");
            let d = Diag::error("E018", title).at(e.span, "does not fit");
            self.diags.push(d.help("on each side of `onto`, give one end, or one for each link"));
            return Err(());
        }
        let pairs: Vec<[End; 2]> = (0..count).map(|i| [a[i.min(a.len() - 1)], b[i.min(b.len() - 1)]]).collect();
        if let Some(same) = pairs.iter().find(|p| p[0] == p[1]) {
            let title = format!("`{name}` joins `{}` to itself", self.net.end_name(same[0]));
            self.diags.push(Diag::error("E022", title).at(e.span, "the same at both ends").help(help));
            return Err(());
        }
        Ok(pairs)
    }

    /// Looks up the references of modules that could not be resolved, so that one run reports all errors.
    fn broken_items(&mut self) {
        if self.net.items.len() == self.model.items.len() {
            return;
        }
        let good: BTreeSet<usize> = self.net.items.iter().map(|i| i.model).collect();
        let model = self.model;
        for (_, item) in model.items.iter().enumerate().filter(|(i, _)| !good.contains(i)) {
            for e in &item.args {
                match (e.key.as_str(), &e.value) {
                    ("between" | "onto", Value::List(_)) | ("to", Value::Text(_)) => {
                        self.side(e, &item.name, &e.key, LINKED);
                    }
                    ("from", Value::Text(text)) => {
                        self.select(Written { text, span: e.span, owner: &item.name }, None);
                    }
                    _ => {}
                }
            }
        }
    }

    fn push(&mut self, id: u32) {
        let name = self.net.items[id as usize].name.clone();
        let Some(e) = self.entry(id, "to") else { return };
        let Some(ends) = self.side(e, &name, "to", "a force acts on a MAT: a mass or a cell") else { return };
        let Some(input) = self.net.inputs.iter().position(|i| *i.name == *name) else { return };
        let along = self.net.items[id as usize].args.get(2).and_then(space::direction);
        if self.net.pushes.len() + ends.len() > LARGEST {
            self.too_many(&name, "forces", e.span);
            return;
        }
        for end in ends {
            let Some(parts) = self.directed(end, along, &name, e.span, "pushes") else { return };
            let [(axis, share)] = parts[..] else {
                let d = Diag::error("E029", format!("the direction of `{name}` is not an axis"))
                    .at(e.span, "a slanted direction");
                self.diags.push(d.help("a force port acts along one axis: use one port for each axis"));
                return;
            };
            debug_assert!(share == 1.0);
            self.net.pushes.push(Push { input: input as u32, end, axis });
        }
    }
}
