//! Resolves rates, parameters, media and the parameters of every item to SI, and makes MATs, ports and generators
//! nodes. Links wait until all names are known (`wire.rs`).

use crate::MOST_MODES;
use crate::lower::expand::expand;
use crate::lower::ports::gesture;
use crate::lower::ports::port::port;
use crate::lower::rate_options::crossing;
use crate::lower::values::Values;
use crate::lower::{equivalence, params, preset, rates, requirements, space};
use crate::net::{MatNode, MatRole, NetItem, Resolved};
use crate::options::Options;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Arg, Args, Builder, Generator, Problem};
use ca_core::internal::tuning::Scheme;
use ca_core::{Catalog, Kind, Name, Need, OneOf, Param, Role, Type, Unit};
use ca_model::LARGEST;
use ca_model::diag::{Diag, Diags};
use ca_model::names::all_differ;
use ca_model::quantity::Plain;
use ca_model::suggest::nearest;
use ca_model::{Item, Model, Span};

ca_core::choice! {
    /// Meaning of `dx0` and `v` at the start.
    enum Start {
        /// Position and speed at the start.
        Centred = "centred",
        /// The positions before the start.
        MiLib = "mi.lib",
    }
}

/// `start` of `[model]`.
pub const START: Param = Param::new(
    "start",
    Type::Choice(Start::WORDS),
    Need::Default(0.0),
    "meaning of `dx0` and `v`: position and speed at the start, or the positions before it, as in mi.lib",
);

/// Resolves everything except links and outputs.
pub fn resolve(model: &Model, catalog: &Catalog, options: &Options, diags: &mut Diags) -> Resolved {
    let mut net = Resolved::default();
    rates::rates(model, options, &mut net, diags);
    crossing(model, &mut net, diags);
    let alg = rates::reference(model, &net, diags);
    unique(model, diags);
    let mut v = Values::new(alg, diags);
    v.clouds.clone_from(&options.clouds);
    let named = params::all(model, v.diags);
    v.name(named);
    rates::media(model, &mut net, &mut v);
    let mut unknown = BTreeSet::new();
    // Modules of one kind are adjacent.
    let mut last: Option<(&str, &'static Kind)> = None;
    net.items.reserve_exact(model.items.len());
    for (i, item) in model.items.iter().enumerate() {
        if v.diags.is_full() {
            break;
        }
        let known = last.filter(|(code, _)| *code == item.kind).map(|(_, kind)| kind);
        let Some(kind) = known.or_else(|| catalog.get(&item.kind)) else {
            // One finding per section, for any number of modules in it.
            if unknown.insert((item.kind_span, item.kind.as_str())) {
                v.diags.push(unknown_kind(item, catalog));
            }
            continue;
        };
        last = Some((&item.kind, kind));
        if let Some(resolved) = item_args(kind, item, i, &mut v) {
            nodes(resolved, item, &mut net, &mut v);
        }
    }
    if let Some(e) = model.meta("seconds") {
        let tick_dt = v.alg.take();
        net.seconds = v.number(e, Unit::SECOND, (0.0, 86_400.0), "`seconds` of `[model]`").map(|s| s.0);
        v.alg = tick_dt;
    }
    if let Some(e) = model.meta(START.name) {
        net.as_milib = Start::of(v.word(&START, e, "[model]")) == Start::MiLib;
    }
    equivalence::equivalence(model, &mut net, &mut v);
    params::place(&mut v, &mut net);
    net.precision = options.precision;
    net.tables = v.tables;
    // Release spare capacity, which would otherwise last for the whole compilation.
    net.mats.shrink_to_fit();
    net.lias.shrink_to_fit();
    let (named, diags) = (v.named, v.diags);
    gesture::gestures(model, &mut net, alg, &named, diags);
    preset::presets(model, &mut net, alg, &named, diags);
    net
}

fn unknown_kind(item: &Item, catalog: &Catalog) -> Diag {
    let d = Diag::error("E002", format!("unknown kind: `{}`", item.kind)).at(item.kind_span, "no such kind");
    match nearest(&item.kind, catalog.iter().map(|k| k.code)) {
        Some(near) => d.help(format!("did you mean `{near}`?")).fix(item.kind_span, near),
        None => d.help(format!("kinds are {}", list(catalog.iter().map(|k| k.code)))),
    }
}

/// Checks that names are unique, also between modules and parameters: `ca set`, gestures and moving points accept both.
fn unique(model: &Model, diags: &mut Diags) {
    let names = model.params.iter().map(|e| e.key.as_str()).chain(model.items.iter().map(|i| i.name.as_str()));
    if all_differ(names) {
        return;
    }
    let params = model.params.iter().map(|e| (e.key.as_str(), e.key_span, "a parameter"));
    let items = model.items.iter().map(|i| (i.name.as_str(), i.name_span, "a module"));
    let mut taken: BTreeMap<&str, (Span, &str)> = BTreeMap::new();
    for (name, span, what) in params.chain(items) {
        let Some((first, was)) = taken.insert(name, (span, what)) else { continue };
        let title = if was == what {
            format!("`{name}` is used twice")
        } else {
            format!("`{name}` names both {was} and {what}")
        };
        let d = Diag::error("E012", title).at(span, format!("{what} here")).at(first, format!("{was} here"));
        diags.push(d.help("names are unique in a model: rename one of the two"));
    }
}

fn item_args(kind: &'static Kind, item: &Item, model: usize, v: &mut Values<'_>) -> Option<NetItem> {
    let mut args = alloc::vec![Arg::Absent; kind.params.len()];
    let mut follows = Vec::new();
    let (mut good, mut misspelt) = (true, false);
    for e in &item.args {
        let Some(i) = kind.param(&e.key) else {
            let d = Diag::error("E004", format!("`{}`: unknown parameter `{}`", item.name, e.key));
            let d = d.at(e.key_span, "not known here");
            v.diags.push(match nearest(&e.key, kind.params.iter().map(|p| p.name)) {
                Some(near) => d.help(format!("did you mean `{near}`?")).fix(e.key_span, near),
                None => d.help(format!("`{}` has {}", kind.code, list(kind.params.iter().map(|p| p.name)))),
            });
            misspelt = true;
            good = false;
            continue;
        };
        match v.arg(kind, &kind.params[i], e, &item.args, &item.name) {
            Some((arg, follow)) => {
                args[i] = arg;
                follows.extend(follow.map(|(p, factor)| (i, p, factor)));
            }
            None => good = false,
        }
    }
    for (i, p) in kind.params.iter().enumerate() {
        let written = item.args.iter().any(|e| e.key == p.name);
        match p.need {
            // The misspelt parameter is probably the missing one.
            Need::Required if !written && misspelt => good = false,
            Need::Required if !written => {
                let help = match p.ty {
                    Type::Number { unit, .. } => {
                        format!("add e.g. `{} = {}` ({})", p.name, crate::findings::quoted(unit), p.doc)
                    }
                    Type::Between => {
                        format!("add `{} = [\"first\", \"second\"]`, the modules at its ends", p.name)
                    }
                    Type::Module => format!("add `{} = \"…\"` ({})", p.name, p.doc),
                    Type::Count { min, .. } => format!("add e.g. `{} = {}` ({})", p.name, min.max(40), p.doc),
                    _ => format!("add `{}` ({})", p.name, p.doc),
                };
                let d = Diag::error("E005", format!("`{}` needs `{}`", item.name, p.name));
                v.diags.push(d.at(item.name_span, format!("{} without `{}`", kind.code, p.name)).help(help));
                good = false;
            }
            Need::Default(d) if !written => args[i] = Arg::Num(d),
            _ => {}
        }
    }
    for choice in kind.one_of {
        good = good && !misspelt && one_of(kind, item, choice, v.diags);
    }
    good = good && requirements::parameters(kind, item, &args, v.diags);
    good.then(|| NetItem {
        name: Arc::from(item.name.as_str()),
        kind,
        model,
        group: item.group.map(|g| g as u32),
        dim: 1,
        args,
        follows,
        slots: Vec::new(),
    })
}

fn one_of(kind: &Kind, item: &Item, choice: &OneOf, diags: &mut Diags) -> bool {
    let written = |set: &&[&str]| item.args.iter().find(|e| set.contains(&e.key.as_str()));
    let found: Vec<_> = choice.sets.iter().filter_map(|s| written(s).map(|e| (s, e))).collect();
    let title = |name: &str| kind.param(name).map_or("", |i| kind.params[i].doc);
    let value = |name: &str| match kind.param(name).map(|i| kind.params[i].ty) {
        Some(Type::Number { unit, .. }) => crate::findings::quoted(unit),
        _ => "…".into(),
    };
    match found.as_slice() {
        [] if choice.required => {
            let sets = choice.sets.iter().map(|s| format!("`{}`", s[0])).collect::<Vec<_>>().join(" or ");
            let d = Diag::error("E005", format!("`{}` needs {sets}", item.name));
            let d = d.at(item.name_span, format!("{} without {sets}", kind.code));
            let ways = choice.sets.iter().map(|s| format!("`{} = {}` ({})", s[0], value(s[0]), title(s[0])));
            diags.push(d.help(format!("add {}", ways.collect::<Vec<_>>().join(" or "))));
            false
        }
        [] => true,
        [(set, e)] => {
            // The first name of a set selects it.
            let head = item.args.iter().any(|a| a.key == set[0]);
            if !head && choice.required {
                let d = Diag::error("E005", format!("`{}` needs `{}` with `{}`", item.name, set[0], e.key));
                let d = d.at(e.key_span, format!("without `{}`", set[0]));
                diags.push(d.help(format!("add `{} = {}` ({})", set[0], value(set[0]), title(set[0]))));
            }
            head || !choice.required
        }
        [(_, a), (_, b), ..] => {
            let d = Diag::error("E010", format!("`{}`: `{}` and `{}` exclude each other", item.name, a.key, b.key))
                .at(b.key_span, format!("excludes `{}`", a.key))
                .at(a.key_span, "written here")
                .help("keep one of them");
            diags.push(d);
            false
        }
    }
}

/// Makes MATs, ports and generators. A generator that would be too large is refused before it is built.
fn nodes(mut item: NetItem, source: &Item, net: &mut Resolved, v: &mut Values<'_>) {
    let id = net.items.len() as u32;
    let kind = item.kind;
    item.slots = item.args.iter().map(Arg::num).collect();
    let dim = net.medium_of(item.group).dim;
    item.dim = dim;
    let (mut places, mut good) = ([[0.0; 3]; 3], true);
    for (p, arg) in kind.params.iter().zip(&item.args).filter(|(p, _)| matches!(p.ty, Type::Position { .. })) {
        let span = source.args.iter().find(|e| e.key == p.name).map_or(Span::NONE, |e| e.span);
        let what = format_args!("`{}` of `{}`", p.name, item.name);
        let place = space::position(Some(arg), dim, span, &what, v.diags);
        good &= place.is_some();
        if let (Some(k), Some(at)) = (["x", "dx0", "v"].iter().position(|n| *n == p.name), place) {
            places[k] = at;
        }
    }
    if !good {
        return;
    }
    let [rest, dx0, speed] = places;
    match kind.role {
        Role::Mat(spec) => {
            if let (Some(f), "CEL") = (kind.param("f").and_then(|i| item.args[i].num()), kind.code) {
                if f * net.tick_dt >= 0.5 {
                    let span = source.args.iter().find(|e| e.key == "f").map_or(source.span, |e| e.span);
                    let d = Diag::error(
                        "E023",
                        format!("`{}`: {} Hz is not below half the sound rate", item.name, Plain(f)),
                    );
                    let half = net.rate * f64::from(net.oversample) / 2.0;
                    let help = format!("stay below {} Hz, or raise `sound` in `[rate]`", Plain(half));
                    v.diags.push(d.at(span, "too high").help(help));
                }
            }
            let node = MatNode {
                name: Name::from(&item.name),
                code: kind.code,
                role: MatRole::Mat(spec),
                values: net.own_values(kind.params.len()),
                axes: dim,
                rest,
                dx0,
                v: speed,
                group: item.group,
                item: id,
            };
            net.add(node);
            if item.follows.is_empty() {
                // The arguments are in the slots.
                item.args = Vec::new();
            }
            net.items.push(item);
        }
        Role::Port(role) => {
            port(role, &item, source, id, (dim, rest), net, v);
            net.items.push(item);
        }
        Role::Generator(g) => {
            if !g.dims.contains(&dim) {
                let lives = ["on a line", "in a plane", "in space"][usize::from(dim) - 1];
                let d = Diag::error("E029", format!("`{}`: a {} cannot be {lives}", item.name, kind.code));
                let help = if g.dims.contains(&3) {
                    "put it into a group with `dim = 3`"
                } else {
                    "put it into a group without `dim`, and couple it to this group by an LPR or a link with `along`"
                };
                let place = if dim == 1 { "on a line".into() } else { format!("in a group with `dim = {dim}`") };
                v.diags.push(d.at(source.name_span, place).help(help));
                return;
            }
            let scheme = net.scheme(item.group);
            let tick_dt = net.tick_of(item.group);
            let args = Args { code: kind.code, params: kind.params, values: &item.args, tick_dt, dim, scheme };
            let before = net.mats.len() + net.lias.len();
            let will = requirements::modules(&args);
            if will.saturating_add(before) > LARGEST {
                v.diags.push(too_many(&item.name, kind, source, will, before));
                net.items.push(item);
                return;
            }
            let mut slots = Vec::new();
            let built = (g.derive)(&args, &mut slots).and_then(|()| {
                let mut b = Builder::new(&slots, !item.follows.is_empty());
                (g.build)(&args, &mut b).map(|()| b)
            });
            match built {
                Ok(built) => {
                    item.slots.clone_from(&slots);
                    let group = item.group;
                    net.items.push(item);
                    expand(net, id, &built, (dim, rest), group);
                }
                Err(p) => {
                    let p = if net.medium_of(item.group).slow {
                        at_gesture_rate(&p)
                    } else {
                        with_other_ways(p, g, &args, net.oversample)
                    };
                    v.diags.push(does_not_fit(&item.name, source, p));
                    net.items.push(item);
                }
            }
        }
        Role::Lia(_) => net.items.push(item),
    }
}

/// Extends the help for too many masses by settings that would allow them: several ticks per sample, or exact modes.
/// Each is tried.
fn with_other_ways(mut p: Problem, g: &Generator, args: &Args<'_>, oversample: u32) -> Problem {
    let counts = args.params.iter().any(|q| q.name == p.param && matches!(q.ty, Type::Count { .. }));
    let fits = |args: Args<'_>| (g.derive)(&args, &mut Vec::new()).is_ok();
    if !counts || fits(Args { ..*args }) {
        return p;
    }
    let at = |ticks: u32| Args { tick_dt: args.tick_dt * f64::from(oversample) / f64::from(ticks), ..*args };
    if let Some(ticks) = (oversample + 1..=rates::FINEST).find(|ticks| fits(at(*ticks))) {
        p.help = format!("{}, or write `oversample = {ticks}` in `[rate]`", p.help);
    }
    let few = requirements::modules(args) <= MOST_MODES;
    if args.dim == 1 && few && fits(Args { scheme: Scheme::Modal, ..*args }) {
        p.help.push_str(", or `method = \"modal\"` in its group or `[model]`");
    }
    p
}

/// Adapts a problem to a group whose tick is a gesture frame.
fn at_gesture_rate(p: &Problem) -> Problem {
    let title = p.title.replace("this sound rate", "the gesture rate");
    let help = p.help.replace("raise `rate.sound`", "raise `rate.gesture`, or leave out `rate` of the group");
    Problem { title, help, param: p.param }
}

/// Returns the error for a generator that cannot be built, at the parameter responsible.
pub fn does_not_fit(name: &str, source: &Item, p: Problem) -> Diag {
    let written = source.args.iter().find(|e| e.key == p.param);
    let d = Diag::error("E023", format!("`{name}`: {}", p.title));
    d.at(written.map_or(source.name_span, |e| e.span), "does not fit").help(p.help)
}

fn too_many(name: &str, kind: &Kind, source: &Item, will: usize, before: usize) -> Diag {
    let count = source
        .args
        .iter()
        .find(|e| kind.param(&e.key).is_some_and(|i| matches!(kind.params[i].ty, Type::Count { .. })));
    let title = if before == 0 {
        format!("`{name}` would make {will} modules")
    } else {
        format!("`{name}` would make {will} modules in addition to {before} others")
    };
    let d = Diag::error("E027", title).at(count.map_or(source.name_span, |e| e.span), "too many");
    d.help(format!("use fewer: a model can have up to {LARGEST} masses and links, in real time some thousands"))
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}
