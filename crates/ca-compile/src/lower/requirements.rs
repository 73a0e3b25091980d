//! Constraints beyond the parameter tables of the kinds: parameters that need each other, and the size of generators.

use alloc::format;
use ca_core::internal::kind::builder::{Arg, Args};
use ca_core::internal::phi::bow::{CurveShape, FrictionMethod};
use ca_core::{Kind, Type};
use ca_model::Item;
use ca_model::diag::{Diag, Diags};

/// Returns false, with a finding, if the parameters of an item are inconsistent.
pub fn parameters(kind: &Kind, item: &Item, args: &[Arg], diags: &mut Diags) -> bool {
    let entry = |name: &str| item.args.iter().find(|e| e.key == name);
    let num = |name: &str| kind.param(name).and_then(|i| args[i].num());
    let missing = |name: &str, beside: &str, help: &str| {
        let d = Diag::error("E005", format!("`{}` needs `{name}` with `{beside}`", item.name));
        let span = entry(beside).map_or(item.name_span, |e| e.key_span);
        d.at(span, format!("without `{name}`")).help(help)
    };
    let chosen = |name: &str| {
        let Type::Choice(words) = kind.params[kind.param(name)?].ty else { return None };
        words.get(num(name)? as usize).copied()
    };
    let set_valued = chosen("method") == Some(FrictionMethod::WORDS[FrictionMethod::SetValued as usize]);
    let d = match kind.code {
        "BOW" if CurveShape::of(num("curve")) == CurveShape::Table && entry("points").is_none() => missing(
            "points",
            "curve",
            "add `points = [[\"-1 m/s\", \"-1 N\"], [0, 0], [\"1 m/s\", \"1 N\"]]`, or choose another curve",
        ),
        "BOW" if CurveShape::of(num("curve")) != CurveShape::Table && entry("points").is_some() => {
            let d = missing("curve", "points", "add `curve = \"table\"`");
            entry("curve").map_or(d.clone(), |e| d.fix(e.span, "\"table\""))
        }
        "BOW" | "LPR_BOW" if set_valued && CurveShape::of(num("curve")) != CurveShape::Coulomb => {
            let d = Diag::error(
                "E010",
                format!("`{}`: `method = \"set-valued\"` requires `curve = \"coulomb\"`", item.name),
            );
            let d = d.at(entry("method").map_or(item.name_span, |e| e.span), "another curve");
            d.help("add `curve = \"coulomb\"`, or choose another method")
        }
        "BOW" | "LPR_BOW" if set_valued && num("fd").zip(num("f")).is_some_and(|(fd, f)| fd > f) => {
            let d = Diag::error("E009", format!("`fd` of `{}` is above `f`", item.name));
            let d =
                d.at(entry("fd").map_or(item.name_span, |e| e.span), "sliding friction cannot exceed static friction");
            d.help("make `f` larger, or `fd` smaller")
        }
        "BOW" if entry("f").is_some() && entry("v0").is_none() && !set_valued => {
            missing("v0", "f", "add e.g. `v0 = \"50 mm/s\"` (speed of the largest force)")
        }
        "BOW" if falls_backwards(num("v0"), num("v1")) => {
            let d = Diag::error("E009", format!("`v1` of `{}` is not above `v0`", item.name));
            let span = entry("v1").map_or(item.name_span, |e| e.span);
            d.at(span, "friction falls from `v0` to `v1`")
                .help("make `v1` larger, e.g. three times `v0`, or leave it out")
        }
        "LNL" if entry("spring").is_none() && entry("friction").is_none() => {
            let d = Diag::error("E005", format!("`{}` needs `spring` or `friction`", item.name));
            let d = d.at(item.name_span, "LNL without a table");
            d.help("add e.g. `spring = [[\"-1 mm\", \"-2 N\"], [0, 0], [\"1 mm\", \"2 N\"]]`")
        }
        _ => return true,
    };
    diags.push(d);
    false
}

/// Returns whether the friction curve of a bow would fall before it has risen.
fn falls_backwards(v0: Option<f64>, v1: Option<f64>) -> bool {
    v0.zip(v1).is_some_and(|(v0, v1)| v1 <= v0)
}

/// Returns an upper bound of the MATs and LIAs that a generator makes, before it makes them. Its counts multiply. Each
/// mass adds up to two links in a mesh or a stiff string, and one in a simple row.
pub fn modules(a: &Args<'_>) -> usize {
    if let Some(c) = a.values.iter().find_map(|v| if let Arg::Cloud(c) = v { Some(c) } else { None }) {
        return c.points.len() + c.edges.len();
    }
    let counts = a.params.iter().zip(a.values).filter(|(p, _)| matches!(p.ty, Type::Count { .. }));
    let (mut masses, mut sides) = (1usize, 0);
    for (_, v) in counts {
        masses = masses.saturating_mul(v.num().unwrap_or(1.0) as usize);
        sides += 1;
    }
    let longest = a.values.iter().map(|v| if let Arg::List(l) = v { l.len() } else { 1 }).max().unwrap_or(1);
    let shear = usize::from(a.is_written("shear"));
    masses.max(longest).saturating_mul(if sides > 1 { 3 + 2 * shear } else { 2 })
}
