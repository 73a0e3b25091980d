//! Resolve: rates, parameters, media, and every item's parameters in SI; MATs, ports and generators become nodes.
//! Links wait for all names to be known (`wire.rs`).

use super::Options;
use super::net::{Family, MatNode, MatRole, Medium, Net, NetItem};
use super::values::{Named, Raw, Values, type_name};
use crate::catalog::Catalog;
use crate::generate::{Arg, Args, Build};
use crate::io::PortRole;
use crate::kind::{Kind, Need, Role, Type, Unit};
use crate::live::{LiveParam, Source};
use crate::model::diag::{Diag, Diags};
use crate::model::quantity;
use crate::model::suggest::nearest;
use crate::model::{Entry, Item, Model, Value};
use crate::scene::{Input, InputRole};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// More modules than this are refused: indices are 32 bits wide, and a typing error should not eat the machine.
pub const LARGEST: usize = 8_000_000;

/// Everything but links and outputs.
pub fn resolve(model: &Model, catalog: &Catalog, options: &Options, diags: &mut Diags) -> Net {
    let mut net = Net::default();
    rates(model, options, &mut net, diags);
    let alg = reference(model, &net, diags);
    let mut v = Values { alg, named: Vec::new(), tables: Vec::new(), diags };
    v.named = model.params.iter().filter_map(|e| named(e, v.diags)).collect();
    media(model, &mut net, &mut v);
    let mut modules = 0;
    for (i, item) in model.items.iter().enumerate() {
        let Some(kind) = catalog.get(&item.kind) else {
            let mut d = Diag::error("E002", format!("unknown kind `{}`", item.kind)).at(item.kind_span, "not a kind");
            if let Some(near) = nearest(&item.kind, catalog.iter().map(|k| k.code)) {
                d = d.help(format!("did you mean `{near}`?"));
            }
            v.diags.push(d);
            continue;
        };
        if let Some(resolved) = item_args(kind, item, i, &mut v) {
            modules += nodes(resolved, item, &mut net, &mut v);
            if modules > LARGEST {
                let d = Diag::error("E027", format!("more than {LARGEST} modules"))
                    .at(item.name_span, "too many from here on");
                v.diags.push(d);
                break;
            }
        }
    }
    if let Some(e) = model.meta("seconds") {
        let te = v.alg.take();
        net.seconds = v.number(e, Unit::SECOND, (0.0, 86_400.0), "`model.seconds`").map(|s| s.0);
        v.alg = te;
    }
    params(&mut v, &mut net);
    net.tables = v.tables;
    gestures(model, &mut net, alg, &v.named, diags);
    net
}

fn rates(model: &Model, options: &Options, net: &mut Net, diags: &mut Diags) {
    let hertz = |key: &str, diags: &mut Diags| {
        let e = model.rate.iter().find(|e| e.key == key)?;
        let mut v = Values { alg: None, named: Vec::new(), tables: Vec::new(), diags };
        v.number(e, Unit::HERTZ, (1.0, 1e7), &format!("`rate.{key}`")).map(|n| (n.0, e.span))
    };
    let written = hertz("sound", diags);
    let gesture = hertz("gesture", diags);
    let sound = options.rate.or(written.map(|w| w.0)).unwrap_or(48_000.0);
    let span = gesture.map_or(crate::model::Span::NONE, |g| g.1);
    net.rate = sound;
    net.te = 1.0 / sound;
    // 3 kHz or the nearest that divides the sound rate: 44.1 kHz / 15
    let asked = gesture.map_or(sound / libm::round(sound / 3000.0).max(1.0), |g| g.0);
    let ratio = libm::round(sound / asked).max(1.0);
    if (sound / ratio - asked).abs() > 1e-6 * asked || asked > sound {
        let near = if options.rate.is_some() {
            format!("with a gesture rate of {asked} Hz use a sound rate of {} Hz", asked * ratio)
        } else {
            format!("the nearest gesture rate is {} Hz", sound / ratio)
        };
        let d = Diag::error("E020", format!("sound rate {sound} Hz is not a multiple of gesture rate {asked} Hz"))
            .at(span, "does not divide the sound rate")
            .help(near);
        diags.push(d);
    }
    net.ratio = ratio as u32;
}

/// Tick of the reference rate, for `alg` units.
fn reference(model: &Model, net: &Net, diags: &mut Diags) -> Option<f64> {
    match model.meta("units").map(|e| (&e.value, e.span)) {
        None => None,
        Some((Value::Text(t), _)) if t == "si" => None,
        Some((Value::Text(t), _)) if t == "alg" => {
            let Some(e) = model.meta("reference_rate") else { return Some(net.te) };
            let mut v = Values { alg: None, named: Vec::new(), tables: Vec::new(), diags };
            v.number(e, Unit::HERTZ, (1.0, 1e7), "`model.reference_rate`").map(|r| 1.0 / r.0)
        }
        Some((_, span)) => {
            let d = Diag::error("E011", "`model.units` must be `si` or `alg`").at(span, "not a choice");
            diags.push(d.help("`si`: SI units; `alg`: per-sample units at `reference_rate`, as in GENESIS and mi.lib"));
            None
        }
    }
}

fn raw(e: &Entry, what: &str, diags: &mut Diags) -> Option<Raw> {
    match &e.value {
        Value::Num(v) if v.is_finite() => Some(Raw::Bare(*v)),
        Value::Text(t) if quantity::is_quantity(t) => match quantity::parse(t) {
            Ok(q) => Some(Raw::Quantity(q)),
            Err(err) => {
                diags.push(Diag::error("E007", format!("{what}: not a quantity")).at(e.span, err.message));
                None
            }
        },
        other => {
            let title = format!("{what} must be a finite number or a quantity, not {}", type_name(other));
            diags.push(Diag::error("E006", title).at(e.span, "not a number"));
            None
        }
    }
}

fn named(e: &Entry, diags: &mut Diags) -> Option<Named> {
    let what = format!("parameter `{}`", e.key);
    let mut n = Named {
        name: e.key.clone(),
        value: Raw::Bare(0.0),
        live: false,
        min: None,
        max: None,
        doc: String::new(),
        span: e.key_span,
        used: None,
    };
    let Value::Table(entries) = &e.value else {
        n.value = raw(e, &what, diags)?;
        return Some(n);
    };
    let text = |key: &str| match entries.iter().find(|x| x.key == key).map(|x| &x.value) {
        Some(Value::Text(t)) => Some(t.clone()),
        _ => None,
    };
    // a bare number with `unit = "…"` beside it is a quantity
    let unit = text("unit").filter(|u| !u.is_empty());
    let with_unit = |x: &Entry| match (&x.value, &unit) {
        (Value::Num(v), Some(u)) => Entry { value: Value::Text(format!("{v} {u}")), ..x.clone() },
        _ => x.clone(),
    };
    let mut value = None;
    for x in entries {
        match x.key.as_str() {
            "value" => value = raw(&with_unit(x), &what, diags),
            "min" => n.min = raw(&with_unit(x), &what, diags),
            "max" => n.max = raw(&with_unit(x), &what, diags),
            "live" if matches!(x.value, Value::Bool(_)) => n.live = x.value == Value::Bool(true),
            "unit" | "doc" if matches!(x.value, Value::Text(_)) => {}
            _ => {
                let d = Diag::error("E004", format!("{what}: `{}` is not understood", x.key)).at(x.key_span, "here");
                diags.push(d.help("a parameter has `value`, `unit`, `live`, `min`, `max` and `doc`"));
            }
        }
    }
    n.doc = text("doc").unwrap_or_default();
    if !entries.iter().any(|x| x.key == "value") {
        diags.push(Diag::error("E005", format!("{what} has no `value`")).at(e.key_span, "here"));
    }
    n.value = value?;
    Some(n)
}

fn media(model: &Model, net: &mut Net, v: &mut Values<'_>) {
    let mut medium = |props: &[Entry], owner: &str, outer: Medium| {
        let mut m = outer;
        for e in props {
            let what = format!("`{}` of {owner}", e.key);
            match e.key.as_str() {
                "gravity" => {
                    if let Some(g) = v.number(e, Unit::ACCELERATION, crate::kind::ANY, &what) {
                        m.gravity = g.0;
                    }
                }
                "friction" => {
                    if let Some(z) = v.number(e, Unit::VISCOSITY, crate::kind::POSITIVE, &what) {
                        m.friction = z.0;
                    }
                }
                "dim" if e.value != Value::Num(1.0) => {
                    let d = Diag::error("E028", format!("{what}: only one dimension is built yet")).at(e.span, "here");
                    v.diags.push(d.help("use `dim = 1`, or leave it out"));
                }
                _ => {}
            }
        }
        m
    };
    let root = medium(&model.meta, "`model`", Medium::default());
    for g in &model.groups {
        let m = medium(&g.props, &format!("group `{}`", g.name), root);
        net.media.push(m);
    }
    net.media.push(root);
}

/// Checks and converts the parameters of an item.
fn item_args(kind: &'static Kind, item: &Item, model: usize, v: &mut Values<'_>) -> Option<NetItem> {
    let mut args = alloc::vec![Arg::Absent; kind.params.len()];
    let mut follows = Vec::new();
    let mut good = true;
    for e in &item.args {
        let Some(i) = kind.param(&e.key) else {
            let mut d =
                Diag::error("E004", format!("`{}` of `{}`: {} has no such parameter", e.key, item.name, kind.code))
                    .at(e.key_span, "unknown");
            d = match nearest(&e.key, kind.params.iter().map(|p| p.name)) {
                Some(near) => d.help(format!("did you mean `{near}`?")).fix(e.key_span, near),
                None => d.help(format!("it has {}", list(kind.params.iter().map(|p| p.name)))),
            };
            if !v.diags.list.iter().any(|o| o.code == "E004" && o.span() == d.span() && d.span().is_some()) {
                v.diags.push(d);
            }
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
            Need::Required if !written => {
                let help = match p.ty {
                    Type::Number { unit, .. } => {
                        format!("add `{} = \"{}\"` ({})", p.name, super::values::example(unit), p.doc)
                    }
                    Type::Between => "add `between = [\"first\", \"second\"]`".into(),
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
        good &= one_of(kind, item, choice, v.diags);
    }
    good.then(|| NetItem {
        name: item.name.clone(),
        kind,
        model,
        group: item.group.map(|g| g as u32),
        args,
        follows,
        slots: Vec::new(),
    })
}

fn one_of(kind: &Kind, item: &Item, choice: &crate::kind::OneOf, diags: &mut Diags) -> bool {
    let written = |set: &&[&str]| item.args.iter().find(|e| set.contains(&e.key.as_str()));
    let found: Vec<_> = choice.sets.iter().filter_map(|s| written(s).map(|e| (s, e))).collect();
    match found.as_slice() {
        [] if choice.required => {
            let sets = choice.sets.iter().map(|s| format!("`{}`", s[0])).collect::<Vec<_>>().join(" or ");
            let d = Diag::error("E005", format!("`{}` needs {sets}", item.name));
            diags.push(d.at(item.name_span, format!("{} without {sets}", kind.code)));
            false
        }
        [] => true,
        [(set, e)] => {
            // the first name of a set is what makes it chosen
            let head = item.args.iter().any(|a| a.key == set[0]);
            if !head && choice.required {
                let d = Diag::error("E005", format!("`{}` needs `{}` beside `{}`", item.name, set[0], e.key));
                diags.push(d.at(e.key_span, format!("without `{}`", set[0])));
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

/// Makes MATs, ports and generators; returns how many modules.
fn nodes(mut item: NetItem, source: &Item, net: &mut Net, v: &mut Values<'_>) -> usize {
    let id = net.items.len() as u32;
    let kind = item.kind;
    let num = |item: &NetItem, name: &str| kind.param(name).and_then(|i| item.args[i].num()).unwrap_or(0.0);
    item.slots = item.args.iter().map(Arg::num).collect();
    let rest = num(&item, "x");
    match kind.role {
        Role::Mat(spec) => {
            if let (Some(f), "CEL") = (kind.param("f").and_then(|i| item.args[i].num()), kind.code) {
                if f * net.te >= 0.5 {
                    let span = source.args.iter().find(|e| e.key == "f").map_or(source.span, |e| e.span);
                    let d = Diag::error("E023", format!("`{}`: {f} Hz is not below half the sound rate", item.name));
                    v.diags.push(
                        d.at(span, "too high").help(format!("stay below {} Hz, or raise `rate.sound`", net.rate / 2.0)),
                    );
                }
            }
            let node = MatNode {
                name: item.name.clone(),
                code: kind.code,
                role: MatRole::Mat(spec),
                values: (0..kind.params.len() as u32).map(Source::Slot).collect(),
                rest,
                dx0: num(&item, "dx0"),
                v: num(&item, "v"),
                group: item.group,
                item: id,
            };
            single(net, node);
            net.items.push(item);
            1
        }
        Role::Port(role) => {
            port(role, &item, source, id, rest, net, v);
            net.items.push(item);
            1
        }
        Role::Generator(g) => {
            let span_of = |p: &str| source.args.iter().find(|e| e.key == p).map_or(source.name_span, |e| e.span);
            match (g.derive)(&Args { kind, values: &item.args, te: net.te }) {
                Ok(slots) => {
                    item.slots = slots.clone();
                    let (args, live, group, te) = (item.args.clone(), !item.follows.is_empty(), item.group, net.te);
                    net.items.push(item);
                    let before = net.mats.len() + net.lias.len();
                    let mut b = Build::new(net, id, &slots, live, rest, group);
                    (g.build)(&Args { kind, values: &args, te }, &mut b);
                    b.finish();
                    net.mats.len() + net.lias.len() - before
                }
                Err(p) => {
                    let d = Diag::error("E023", format!("`{}`: {}", item.name, p.title));
                    v.diags.push(d.at(span_of(p.param), "cannot be reached").help(p.help));
                    net.items.push(item);
                    0
                }
            }
        }
        Role::Lia(_) => {
            net.items.push(item);
            1
        }
    }
}

fn single(net: &mut Net, node: MatNode) {
    let id = net.mats.len() as u32;
    let family = Family { masses: alloc::vec![id], size: [1, 1], ..Family::default() };
    net.families.insert(node.name.clone(), family);
    net.mats.push(node);
}

fn port(role: PortRole, item: &NetItem, source: &Item, id: u32, rest: f64, net: &mut Net, v: &mut Values<'_>) {
    if matches!(role, PortRole::Sox | PortRole::Sof) {
        return;
    }
    let (input_role, unit) = match role {
        PortRole::Enf => (InputRole::Force, Unit::NEWTON),
        PortRole::Tgr => (InputRole::Device, Unit::METRE),
        _ => (InputRole::Position, Unit::METRE),
    };
    let entry = |key: &str| source.args.iter().find(|e| e.key == key);
    let midi = entry("midi").and_then(|e| v.midi(e, unit, &item.name));
    let device = entry("device").and_then(|e| match &e.value {
        Value::Text(t) => {
            Some((t.clone(), item.kind.param("dof").and_then(|i| item.args[i].num()).unwrap_or(0.0) as u32))
        }
        other => {
            let d =
                Diag::error("E006", format!("`device` of `{}` must be a text, not {}", item.name, type_name(other)));
            v.diags.push(d.at(e.span, "not a text"));
            None
        }
    });
    let input = net.inputs.len() as u32;
    net.inputs.push(Input { name: item.name.clone(), role: input_role, rest, midi, device });
    if role != PortRole::Enf {
        let node = MatNode {
            name: item.name.clone(),
            code: item.kind.code,
            role: MatRole::Port(role, input),
            values: [].into(),
            rest,
            dx0: 0.0,
            v: 0.0,
            group: item.group,
            item: id,
        };
        single(net, node);
    }
}

/// Live parameters, and warnings about unused ones.
fn params(v: &mut Values<'_>, net: &mut Net) {
    let mut renumber = alloc::vec![usize::MAX; v.named.len()];
    for (i, n) in v.named.iter().enumerate() {
        let value = |r: Raw| match r {
            Raw::Bare(v) => v,
            Raw::Quantity(q) => q.value,
        };
        if !n.live {
            net.constants.insert(n.name.clone(), value(n.value));
            continue;
        }
        let bare = matches!(n.value, Raw::Bare(_));
        let (unit, min, max) = n.used.unwrap_or((Unit::NONE, f64::MIN, f64::MAX));
        let factor = if bare { v.alg.map_or(1.0, |tr| unit.dim.alg_to_si(tr)) } else { 1.0 };
        renumber[i] = net.params.len();
        net.params.push(LiveParam {
            name: n.name.clone(),
            unit,
            min: n.min.map_or(min / factor, value),
            max: n.max.map_or(max / factor, value),
            value: value(n.value),
            doc: n.doc.clone(),
        });
        let p = &net.params[renumber[i]];
        if !(p.value >= p.min && p.value <= p.max) {
            let d = Diag::error("E009", format!("parameter `{}` is outside its own range: {}", n.name, p.value));
            v.diags.push(d.at(n.span, format!("must lie between {} and {}", p.min, p.max)));
        }
    }
    for item in &mut net.items {
        for f in &mut item.follows {
            f.1 = renumber[f.1];
        }
    }
}

/// The built-in gesture.
fn gestures(model: &Model, net: &mut Net, alg: Option<f64>, named: &[Named], diags: &mut Diags) {
    for e in &model.gestures {
        let input = net.inputs.iter().find(|i| i.name == e.key);
        let param = net.params.iter().find(|p| p.name == e.key);
        let unit = match (input, param) {
            (Some(i), _) if i.role == InputRole::Force => Unit::NEWTON,
            (Some(_), _) => Unit::METRE,
            (None, Some(p)) => p.unit,
            (None, None) => {
                let mut d = Diag::error("E021", format!("gesture `{}` drives nothing", e.key))
                    .at(e.key_span, "neither a port nor a live parameter");
                let names =
                    net.inputs.iter().map(|i| i.name.as_str()).chain(net.params.iter().map(|p| p.name.as_str()));
                if let Some(n) = named.iter().find(|n| n.name == e.key && !n.live) {
                    d = d.at(n.span, "declared here, not live").help("add `live = true` to the parameter");
                } else if let Some(near) = nearest(&e.key, names) {
                    d = d.help(format!("did you mean `{near}`?")).fix(e.key_span, near);
                }
                diags.push(d);
                continue;
            }
        };
        // times are seconds in every unit system; only the values follow the model's units
        let mut time = Values { alg: None, named: Vec::new(), tables: Vec::new(), diags };
        let what = format!("gesture `{}`", e.key);
        let seconds = time.points(e, Unit::SECOND, Unit { symbol: unit.symbol, dim: unit.dim }, &what);
        let Some(mut points) = seconds else { continue };
        if let (Some(tr), Value::List(list)) = (alg, &e.value) {
            for (p, written) in points.iter_mut().zip(list) {
                if let Value::List(pair) = &written.value {
                    if matches!(pair[1].value, Value::Num(_)) && param.is_none() {
                        p[1] *= unit.dim.alg_to_si(tr);
                    }
                }
            }
        }
        if points.is_empty() || points.windows(2).any(|w| w[1][0] < w[0][0]) {
            let d = Diag::error("E019", format!("{what} must go forward in time"));
            diags.push(d.at(e.span, "times must not fall").help("write `[[seconds, value], …]` in order"));
            continue;
        }
        net.gestures.push((e.key.clone(), points));
    }
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ").clone()
}
