//! Writes parts and plan as a [`Model`], with a header on its source and how to play it.
//!
//! The model has `alg` units at 44.1 kHz and the same sound rate. The header lists the parts that a generator replaced,
//! because a header stays with the model, unlike a finding. Unused parameters are left out, with a note.

use super::generator_plan::{Generator, GeneratorPlan};
use super::names::Losses;
use super::part::{Arg, Net, Part};
use super::start;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_model::diag::{Diag, Diags};
use ca_model::{Entry, Group, Item, Model, Span, Value};

pub(super) fn emit(net: &Net, plan: &GeneratorPlan, file: &str, diags: &mut Diags) -> Model {
    let file = file.rsplit(['/', '\\']).next().unwrap_or("");
    let mut model = Model { header: header(net, plan, file), ..Model::default() };
    let title = file.strip_suffix(".mdl").unwrap_or(file);
    if !title.is_empty() {
        model.meta.push(Entry::new("title", title));
    }
    model.meta.push(Entry::new("units", "alg"));
    model.meta.push(Entry::new("reference_rate", "44.1 kHz"));
    if start::matters(net) {
        model.meta.push(Entry::new("start", "mi.lib"));
    }
    model.rate.push(Entry::new("sound", "44.1 kHz"));
    for (name, a) in &net.groups {
        let props = Vec::from([Entry::new("gravity", *a)]);
        model.groups.push(Group { name: name.clone(), span: Span::NONE, props });
    }
    let mut used = BTreeSet::new();
    let first: BTreeMap<usize, &Generator> = plan.generators.iter().map(|g| (g.at, g)).collect();
    for (i, part) in net.parts.iter().enumerate() {
        if let Some(g) = first.get(&i) {
            let args = generator(net, g, &mut used);
            model.items.push(item(g.kind, g.name.clone(), None, args));
        } else if !plan.gone.get(i).copied().unwrap_or(false) {
            let mut args = ends(net, plan, part);
            args.extend(entries(net, &part.args, &mut used));
            model.items.push(item(part.kind, part.name.clone(), part.group, args));
        }
    }
    params(net, &used, &mut model, diags);
    model
}

fn item(kind: &str, name: String, group: Option<usize>, args: Vec<Entry>) -> Item {
    Item { kind: kind.into(), kind_span: Span::NONE, name, name_span: Span::NONE, group, args, span: Span::NONE }
}

fn name_of(net: &Net, plan: &GeneratorPlan, part: usize) -> String {
    plan.names.get(&part).cloned().or_else(|| net.parts.get(part).map(|p| p.name.clone())).unwrap_or_default()
}

fn ends(net: &Net, plan: &GeneratorPlan, part: &Part) -> Vec<Entry> {
    let names: Vec<String> = part.ends.iter().map(|&p| name_of(net, plan, p)).collect();
    match (part.kind, &names[..]) {
        ("ENF", [to]) => Vec::from([Entry::new("to", to.as_str())]),
        (_, [from]) => Vec::from([Entry::new("from", from.as_str())]),
        (_, [_, _]) => Vec::from([Entry::new("between", names)]),
        _ => Vec::new(),
    }
}

fn entries(net: &Net, args: &[(&'static str, Arg)], used: &mut BTreeSet<usize>) -> Vec<Entry> {
    let value = |arg: Arg, used: &mut BTreeSet<usize>| match arg {
        Arg::Num(x) => Value::Num(x),
        Arg::Word(w) => Value::from(w),
        Arg::Curve(points) => Value::from(points.map(|p| p.to_vec()).to_vec()),
        Arg::Param(i) => {
            used.insert(i);
            net.params.get(i).map_or(Value::Num(0.0), |p| Value::from(p.name.as_str()))
        }
    };
    args.iter().map(|&(key, arg)| Entry::new(key, value(arg, used))).collect()
}

fn generator(net: &Net, g: &Generator, used: &mut BTreeSet<usize>) -> Vec<Entry> {
    let mut all = entries(net, &g.args, used);
    if !g.fixed.is_empty() {
        let nodes: Vec<Vec<f64>> = g.fixed.iter().map(|n| n.iter().map(|i| *i as f64).collect()).collect();
        all.push(Entry::new("fixed", nodes));
    }
    all
}

fn params(net: &Net, used: &BTreeSet<usize>, model: &mut Model, diags: &mut Diags) {
    let mut losses = Losses::default();
    for (i, p) in net.params.iter().enumerate() {
        let kept = used.contains(&i);
        if kept {
            model.params.push(Entry::new(&p.name, p.value));
        }
        let d = match (&p.folded, kept) {
            (Some(by), true) => Diag::note("N201", format!("`{by}` keeps the value of `{}`, not the name", p.name))
                .at(p.span, "part of a product there"),
            (Some(by), false) => Diag::note("N201", format!("`{}` is left out: `{by}` contains its value", p.name))
                .at(p.span, "part of a product there"),
            (None, false) => Diag::note("N201", format!("`{}` is left out", p.name)).at(p.span, "not used"),
            (None, true) => continue,
        };
        losses.add(&p.name, d);
    }
    losses.into_diags(diags);
}

fn header(net: &Net, plan: &GeneratorPlan, file: &str) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for part in &net.parts {
        match counts.iter_mut().find(|c| c.0 == part.kind) {
            Some(c) => c.1 += 1,
            None => counts.push((part.kind, 1)),
        }
    }
    let counts: Vec<String> = counts.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
    let source = if file.is_empty() { "a MIMS model" } else { file };
    let mut lines = Vec::from([
        format!("Imported from {} (MIMS). Numbers are per sample at 44.1 kHz, as there.", one_line(source)),
        format!("{}.", counts.join(", ")),
    ]);
    if start::matters(net) {
        lines.push("Starts as mi.lib does: `dx0` is one sample before the first, `v` the step that led there.".into());
    }
    for g in &plan.generators {
        let label = |p: usize| net.parts.get(p).map_or("", |p| p.name.as_str());
        let (a, b) = g.members;
        let sides = g.args.iter().filter(|(key, _)| matches!(*key, "n" | "nx" | "ny"));
        let size: Vec<String> =
            sides.filter_map(|(_, n)| if let Arg::Num(n) = n { Some(n.to_string()) } else { None }).collect();
        lines.push(format!("`{}`: {} of {}, was {} to {}.", g.name, g.kind, size.join(" x "), label(a), label(b)));
    }
    let ports = |kinds: &[&str], verb: &str| {
        let of = |p: &Part| match p.ends.first() {
            Some(&end) => format!("`{}` ({}, {verb} {})", p.name, p.kind, name_of(net, plan, end)),
            None => format!("`{}` ({}, position)", p.name, p.kind),
        };
        let all: Vec<String> = net.parts.iter().filter(|p| kinds.contains(&p.kind)).map(of).collect();
        all.join(", ")
    };
    for (what, kinds, verb) in [("Move", ["ENX", "ENF"], "on"), ("Hear", ["SOX", "SOF"], "of")] {
        let all = ports(&kinds, verb);
        lines.push(if all.is_empty() { format!("{what}: nothing.") } else { format!("{what}: {all}.") });
    }
    lines.join("\n").trim().to_string()
}

/// Replaces control characters in a file name, which would end a comment.
fn one_line(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
