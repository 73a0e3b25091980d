//! Checks and solves `[equivalence]`, the scales between device and model (docs/numerics.md §6).
//!
//! The real side of a pair is in SI, the simulated side in the units of the model. Without any row the scale is one to
//! one in metres and newtons. A single row keeps the class of the anchor as it is without the section. The factors of a
//! key multiply those for all keys.

use crate::findings::type_name;
use crate::lower::values::Values;
use crate::net::{MatRole, Resolved};
use alloc::format;
use alloc::string::String;
use alloc::string::ToString;
use alloc::vec::Vec;
use ca_core::equivalence::{
    Class, Equivalence, Gains, Pair, Quantity, ROWS, Scale, anchor_for, row, solve, solve_keeping,
};
use ca_core::internal::kind::{PortRole, alg_to_si};
use ca_core::{ABOVE_ZERO, InputRole, Unit};
use ca_model::diag::Diag;
use ca_model::suggest::{nearest, ticked};
use ca_model::{Entry, Model, Value};

/// Keys in the table of a device key.
const WORDS: [&str; 3] = ["lever", "position", "force"];

/// Reads the section and sets the gains of every device input.
pub fn equivalence(model: &Model, net: &mut Resolved, v: &mut Values<'_>) {
    let time_unit = v.alg.unwrap_or(1.0);
    let keys: Vec<(String, [Option<u32>; 3])> = net
        .mats
        .iter()
        .filter_map(|m| match m.role {
            MatRole::Port(PortRole::Tgr, inputs) => Some((m.name.to_string(), inputs)),
            _ => None,
        })
        .collect();
    let mut found = Equivalence { time_unit, ..Equivalence::default() };
    let mut pairs: Vec<(Pair, &Entry)> = Vec::new();
    let mut tables: Vec<(String, &Entry)> = Vec::new();
    let mut anchor: Option<&Entry> = None;
    for e in &model.equivalence {
        if e.key == "anchor" {
            found.anchor = read_anchor(e, v);
            anchor = Some(e);
        } else if matches!(e.value, Value::Table(_)) {
            flatten("", e, &mut tables);
        } else {
            match row(&e.key) {
                Some(row) => pairs.extend(pair(row, e, v).map(|p| (p, e))),
                None => unknown(e, &keys, v),
            }
        }
    }
    if let Some(gains) = whole(&pairs, found.anchor, anchor, time_unit, v) {
        found.gains = gains;
    }
    for (name, e) in tables {
        found.keys.extend(scale(name, e, &keys, model, v));
    }
    for (name, inputs) in &keys {
        let gains = found.of(name);
        for i in inputs.iter().flatten() {
            net.inputs[*i as usize].gains = gains;
        }
    }
    shared(net, &found, model, v);
    net.equivalence = found;
}

/// Collects the tables of device keys: `[equivalence.room.hand]` is the key `room.hand`.
fn flatten<'m>(prefix: &str, e: &'m Entry, out: &mut Vec<(String, &'m Entry)>) {
    let name = format!("{prefix}{}", e.key);
    let Value::Table(inner) = &e.value else { return };
    if !inner.is_empty() && inner.iter().all(|x| matches!(x.value, Value::Table(_))) {
        for x in inner {
            flatten(&format!("{name}."), x, out);
        }
    } else {
        out.push((name, e));
    }
}

fn unknown(e: &Entry, keys: &[(String, [Option<u32>; 3])], v: &mut Values<'_>) {
    let d =
        Diag::error("E004", format!("unknown key in `[equivalence]`: `{}`", e.key)).at(e.key_span, "not known here");
    let words = ROWS.iter().map(|r| r.name).filter(|n| *n != "time").chain(["anchor"]);
    v.diags.push(match nearest(&e.key, words.clone()) {
        Some(near) => d.help(format!("did you mean `{near}`?")).fix(e.key_span, near),
        None if keys.iter().any(|k| k.0 == e.key) => {
            d.help(format!("a device key needs a table: `[equivalence.{}]`", e.key))
        }
        None => d.help(format!("`[equivalence]` has {}, and a table for each device key", ticked(words))),
    });
}

fn read_anchor(e: &Entry, v: &mut Values<'_>) -> Option<Class> {
    let word = if let Value::Text(t) = &e.value { t.as_str() } else { "" };
    let words = ["position", "force", "impedance", "energy"];
    match Class::of(word) {
        Some(class) if class != Class::Time => Some(class),
        _ => {
            let title =
                format!("`anchor` of `[equivalence]` must be one of {}, or another row", ticked(words.into_iter()));
            let d = Diag::error("E011", title).at(e.span, "not a choice");
            let names = words.into_iter().chain(ROWS.iter().map(|r| r.name)).filter(|w| *w != "time");
            v.diags.push(match nearest(word, names) {
                Some(near) => d.help(format!("did you mean `{near}`?")).fix(e.span, format!("\"{near}\"")),
                None => d.help(
                    "it names the quantity that stays unchanged: if left out, `position` (the travel of the keys), or \
                     `impedance` if `position` is set",
                ),
            });
            None
        }
    }
}

fn pair(row: &'static Quantity, e: &Entry, v: &mut Values<'_>) -> Option<Pair> {
    if row.class() == Class::Time {
        let d = Diag::error("E032", "`time` cannot have an equivalence").at(e.key_span, "set by the clock");
        v.diags.push(d.help("leave it out: a second is a second; in `alg` units, a sample is one of `reference_rate`"));
        return None;
    }
    let Value::List(list) = &e.value else {
        return wrong_shape(row, e, &format!("not {}", type_name(&e.value)), v);
    };
    let [real, sim] = list.as_slice() else {
        return wrong_shape(row, e, &format!("not a list of {}", list.len()), v);
    };
    let alg = v.alg.take();
    let real = v.constant(real, row.unit, ABOVE_ZERO, &format!("the real `{}` of `[equivalence]`", row.name));
    v.alg = alg;
    let sim = v.constant(sim, row.unit, ABOVE_ZERO, &format!("the simulated `{}` of `[equivalence]`", row.name));
    // `sim` is a number of the model, not SI.
    let unit = v.alg.map_or(1.0, |time_unit| alg_to_si(row.unit.dim, time_unit));
    Some(Pair { row, ratio: real? / (sim? / unit) })
}

fn wrong_shape(row: &Quantity, e: &Entry, is: &str, v: &mut Values<'_>) -> Option<Pair> {
    let d = Diag::error("E006", format!("`{}` of `[equivalence]` must be a pair, {is}", row.name));
    let example = crate::findings::quoted(row.unit);
    v.diags.push(d.at(e.span, "not a pair").help(format!("write `[real, simulated]`, e.g. `[{example}, 1.0]`")));
    None
}

/// Returns α and β for all keys; `None` if an error was reported.
fn whole(
    pairs: &[(Pair, &Entry)],
    held: Option<Class>,
    anchor: Option<&Entry>,
    time_unit: f64,
    v: &mut Values<'_>,
) -> Option<Gains> {
    let others =
        |class: Class| ticked(ROWS.iter().filter(|r| ![class, Class::Time].contains(&r.class())).map(|r| r.name));
    let (gains, last) = match pairs {
        [] => return Some(Gains::default()),
        [(p, e)] => {
            let class = p.row.class();
            let held = held.unwrap_or(anchor_for(class));
            if held == class {
                let d = Diag::error("E032", format!("the anchor keeps the quantity that `{}` sets", p.row.name));
                let d = d.at(anchor.map_or(e.key_span, |a| a.span), "the same equivalence").at(e.key_span, "set here");
                v.diags.push(d.help(format!("with `{}`, choose one of {} as the anchor", p.row.name, others(class))));
                return None;
            }
            (solve_keeping(*p, held, Gains::default(), time_unit), e)
        }
        [(a, _), (b, e)] => {
            let class = a.row.class();
            if class == b.row.class() {
                let title = format!("`{}` and `{}` set the same equivalence", a.row.name, b.row.name);
                let d = Diag::error("E032", title)
                    .at(e.key_span, "follows from the other")
                    .at(pairs[0].1.key_span, "the other");
                v.diags.push(d.help(format!("with `{}`, write one of {}", a.row.name, others(class))));
                return None;
            }
            (solve([*a, *b], time_unit), e)
        }
        [_, _, (c, e), ..] => {
            let d =
                Diag::error("E032", format!("`{}` is one equivalence too many: two determine all others", c.row.name));
            v.diags.push(d.at(e.key_span, "the third").help("keep two; `ca equiv` shows the others"));
            return None;
        }
    };
    if gains.is_none() {
        let d = Diag::error("E009", format!("the scale of `{}` in `[equivalence]` is out of range", last.key));
        v.diags.push(
            d.at(last.span, "out of range")
                .help("use values closer together: a scale has at most 30 orders of magnitude"),
        );
    }
    gains
}

fn scale(
    key: String,
    e: &Entry,
    keys: &[(String, [Option<u32>; 3])],
    model: &Model,
    v: &mut Values<'_>,
) -> Option<Scale> {
    let Value::Table(entries) = &e.value else { return None };
    if !keys.iter().any(|k| k.0 == key) {
        if model.lost.contains(&key) {
            return None;
        }
        if let Some(i) = model.items.iter().find(|i| i.name == key) {
            let d = Diag::error("E017", format!("`[equivalence.{key}]`: {} is not a device key", i.kind));
            v.diags.push(d.at(e.key_span, "not a TGR").help("only a TGR connects a device to the model"));
            return None;
        }
        let d =
            Diag::error("E013", format!("`[equivalence.{key}]`: no device key `{key}`")).at(e.key_span, "no such TGR");
        v.diags.push(match nearest(&key, keys.iter().map(|k| k.0.as_str())) {
            Some(near) => d.help(format!("did you mean `{near}`?")).fix(e.key_span, near),
            None if row(&key).is_some() => d.help(format!("write `{key} = [real, simulated]`")),
            None if keys.is_empty() => d.help("the model has no TGR"),
            None => d.help(format!("its keys are {}", ticked(keys.iter().map(|k| k.0.as_str())))),
        });
        return None;
    }
    let mut factors = [None; 3];
    for x in entries {
        let Some(i) = WORDS.iter().position(|w| *w == x.key) else {
            let d = Diag::error("E004", format!("`[equivalence.{key}]`: unknown key `{}`", x.key))
                .at(x.key_span, "not known here");
            v.diags.push(match nearest(&x.key, WORDS.into_iter()) {
                Some(near) => d.help(format!("did you mean `{near}`?")).fix(x.key_span, near),
                None => d.help("a key has `lever`, or `position` and `force`: they multiply the factors of all keys"),
            });
            return None;
        };
        let what = format!("`{}` of `[equivalence.{key}]`", x.key);
        factors[i] = Some((v.constant(x, Unit::NONE, (1e-6, 1e6), &what)?, x));
    }
    let [lever, position, force] = factors;
    if let (Some((_, l)), Some((_, other))) = (lever, position.or(force)) {
        let d = Diag::error("E010", format!("`[equivalence.{key}]`: `lever` and `{}` exclude each other", other.key));
        let d = d.at(other.key_span, "excludes `lever`").at(l.key_span, "written here");
        v.diags.push(d.help("`lever` sets `position` and `force` to the same factor: keep `lever`, or the other two"));
        return None;
    }
    let of = |f: Option<(f64, &Entry)>| f.or(lever).map_or(1.0, |f| f.0);
    Some(Scale { key, position: of(position), force: of(force) })
}

/// Reports keys on one degree of freedom with different scales: there is only one force on it.
fn shared(net: &Resolved, found: &Equivalence, model: &Model, v: &mut Values<'_>) {
    let devices: Vec<_> = net.inputs.iter().filter(|i| i.role == InputRole::Device && i.device.is_some()).collect();
    for (n, b) in devices.iter().enumerate() {
        let Some(a) = devices[..n].iter().find(|a| a.device == b.device && a.gains != b.gains) else { continue };
        let Some((device, dof)) = &b.device else { continue };
        let title = format!(
            "`{}` and `{}` share degree of freedom {dof} of `{device}`, but have different scales",
            a.name, b.name
        );
        let named = |name: &str| found.keys.iter().any(|k| k.key == name);
        let one = if named(&b.name) { &b.name } else { &a.name };
        let place = model.equivalence.iter().find(|e| e.key == *one).map_or(ca_model::Span::NONE, |e| e.key_span);
        let d = Diag::error("E032", title).at(place, "differs from the other");
        v.diags.push(d.help(format!("give both the same factors, or give `{}` another `dof`", b.name)));
    }
}
