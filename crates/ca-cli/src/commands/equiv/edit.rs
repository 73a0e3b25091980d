//! The `[equivalence]` of a model file, changed as asked and nothing else with it.
//!
//! Decides to edit the text, by a library that keeps comments, blanks and the order of everything, rather than to write
//! the model anew: a file is its author's. Whatever is written determines the table by itself: where one row is asked
//! for, the row that holds the anchor is written beside it, unless the anchor is what it would be without the section.

use crate::args::EquivArgs;
use crate::outcome::Failure;
use ca_core::equivalence::{Class, Equivalence, Gains, Quantity, ROWS, anchor_for, row};
use ca_model::Model;
use ca_model::quantity::{self, show};
use ca_model::suggest::nearest;
use toml_edit::{Array, DocumentMut, Item, Table, TableLike, value};

/// The text with the section as asked.
pub(super) fn edit(text: &str, model: &Model, now: &Equivalence, args: &EquivArgs) -> Result<String, Failure> {
    let mut doc: DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| {
        Failure::Failed(format!("`{}`: it cannot be edited: {}", model.file, e.message()))
    })?;
    let anchor = args.anchor.as_deref().map(class).transpose()?;
    let section = doc.entry("equivalence").or_insert_with(|| Item::Table(Table::new()));
    let Some(section) = section.as_table_like_mut() else {
        return Err(Failure::Failed(format!("`{}`: `equivalence` is no section", model.file)));
    };
    if !args.set.is_empty() || anchor.is_some() {
        rows(section, now, args, anchor)?;
    }
    if let Some(key) = &args.key {
        scale(section, key, args)?;
    }
    Ok(doc.to_string())
}

/// What a word holds.
fn class(word: &str) -> Result<Class, Failure> {
    let words = || ["impedance"].into_iter().chain(settable().map(|r| r.name));
    Class::of(word).filter(|c| *c != Class::Time).ok_or_else(|| {
        Failure::Usage(match nearest(word, words()) {
            Some(near) => format!("--anchor: there is no `{word}`; did you mean `{near}`?"),
            None => format!("--anchor: there is no `{word}`; it is one of {}", crate::load::ticked(words())),
        })
    })
}

fn settable() -> impl Iterator<Item = &'static Quantity> + Clone {
    ROWS.iter().filter(|r| r.class() != Class::Time)
}

/// A row to set, and its value as it will stand in the file.
fn asked(text: &(String, String)) -> Result<(&'static Quantity, Array), Failure> {
    let (name, pair) = text;
    let bad = |what: String| Failure::Usage(format!("--set {name}={pair}: {what}"));
    let Some(row) = row(name).filter(|r| r.class() != Class::Time) else {
        let all = || settable().map(|r| r.name);
        return Err(bad(match nearest(name, all()) {
            Some(near) => format!("there is no `{name}`; did you mean `{near}`?"),
            None if name == "time" => "time has no equivalence of its own: the clock decides".into(),
            None => format!("there is no `{name}`; a row is one of {}", crate::load::ticked(all())),
        }));
    };
    let Some((real, sim)) = pair.split_once(':') else {
        return Err(bad("write the real one and the simulated one, e.g. `mass=20g:1.0`".into()));
    };
    let mut list = Array::new();
    for side in [real.trim(), sim.trim()] {
        let q = quantity::parse(side).map_err(|e| bad(format!("`{side}`: {e}")))?;
        if q.has_unit && !q.dim.same(row.unit.dim) {
            let is = quantity::unit_of(q.dim);
            return Err(bad(format!("`{side}` is in {is}, and `{name}` in {}", row.unit.symbol)));
        }
        if q.value <= 0.0 {
            return Err(bad(format!("`{side}`: it must be above 0")));
        }
        if q.has_unit { list.push(side) } else { list.push(number(q.value)) }
    }
    Ok((row, list))
}

/// The rows and the anchor of the whole.
fn rows(
    section: &mut dyn TableLike,
    now: &Equivalence,
    args: &EquivArgs,
    anchor: Option<Class>,
) -> Result<(), Failure> {
    let sets = args.set.iter().map(asked).collect::<Result<Vec<_>, _>>()?;
    // what stays
    let held = match sets.as_slice() {
        [] => written(section).map(Quantity::class).or(now.anchor),
        [(row, _)] => {
            let class = row.class();
            let held = anchor.or(now.anchor.filter(|a| *a != class)).unwrap_or(anchor_for(class));
            if held == class {
                let what = format!("`{}` and the anchor are one equivalence said twice", row.name);
                return Err(Failure::Usage(format!("{what}; hold one of {}", beside(class))));
            }
            Some(held)
        }
        [(a, _), (b, _)] if a.class() == b.class() => {
            let what = format!("`{}` and `{}` are one equivalence said twice", a.name, b.name);
            return Err(Failure::Usage(format!("{what}; beside `{}`, set one of {}", a.name, beside(a.class()))));
        }
        [_, _] => None,
        _ => return Err(Failure::Usage("two equivalences settle the whole table: set one or two rows".into())),
    };
    if sets.is_empty() {
        // only the padlock moves: the table stays, so what followed from the old anchor is written down
        let others: Vec<Class> = settable().filter(|r| section.contains_key(r.name)).map(Quantity::class).collect();
        if let [one] = others.as_slice() {
            pin(section, now.anchor.unwrap_or(anchor_for(*one)), now);
        }
    } else {
        for row in settable() {
            let keep = sets.iter().any(|s| s.0 == row) || held == Some(row.class());
            if !keep {
                section.remove(row.name);
            }
        }
        for (row, pair) in &sets {
            section.insert(row.name, value(pair.clone()));
        }
        if let ([(row, _)], Some(held)) = (sets.as_slice(), held) {
            let standard = held.row().factor(Gains::default(), now.time_unit);
            let stays = held.row().factor(now.gains, now.time_unit) == standard;
            let nobody_else = settable().all(|r| r.class() != held || !section.contains_key(r.name));
            if nobody_else && !(stays && (held == anchor_for(row.class()) || anchor.or(now.anchor) == Some(held))) {
                pin(section, held, now);
            }
        }
    }
    // an anchor that holds what the only row sets would be refused
    let only = settable().filter(|r| section.contains_key(r.name)).collect::<Vec<_>>();
    if let Some(a) = anchor {
        section.insert("anchor", value(a.name()));
    } else if let ([one], Some(a)) = (only.as_slice(), now.anchor) {
        if one.class() == a {
            section.remove("anchor");
        }
    }
    Ok(())
}

/// A row that is written.
fn written(section: &dyn TableLike) -> Option<&'static Quantity> {
    settable().find(|r| section.contains_key(r.name))
}

/// Rows that may stand beside those of a class.
fn beside(class: Class) -> String {
    crate::load::ticked(settable().filter(|r| r.class() != class).map(|r| r.name))
}

/// As it stands in a file: the library would write 1e99 with all its zeros.
fn number(v: f64) -> toml_edit::Value {
    format!("{v:?}").parse().unwrap_or_else(|_| v.into())
}

/// Writes down what a class is now.
fn pin(section: &mut dyn TableLike, class: Class, now: &Equivalence) {
    let row = class.row();
    let mut pair = Array::new();
    pair.push(show(row.factor(now.gains, now.time_unit), row.unit));
    pair.push(1.0);
    section.insert(row.name, value(pair));
}

/// The table of one key.
fn scale(section: &mut dyn TableLike, key: &str, args: &EquivArgs) -> Result<(), Failure> {
    let mut at = section;
    for word in key.split('.') {
        let next = at.entry(word).or_insert_with(|| Item::Table(Table::new()));
        at = next
            .as_table_like_mut()
            .ok_or_else(|| Failure::Usage(format!("--key: `[equivalence.{key}]` is no table in this model")))?;
    }
    if let Some(lever) = args.lever {
        at.remove("position");
        at.remove("force");
        at.insert("lever", value(number(lever)));
        return Ok(());
    }
    let old = at.remove("lever");
    for (name, factor) in [("position", args.position), ("force", args.force_factor)] {
        match (factor, &old) {
            (Some(f), _) => _ = at.insert(name, value(f)),
            (None, Some(lever)) => _ = at.insert(name, lever.clone()),
            (None, None) => {}
        }
    }
    Ok(())
}
