//! The section `[equivalence]`: rows, anchor and the scale of a key.
//!
//! The written rows determine the table. If one row is set, the row that holds the anchor is written
//! beside it, unless the anchor is what it would be without the section.

use crate::{Document, Place, Value};
use ca_core::equivalence::{Class, Equivalence, Gains, Quantity, ROWS, anchor_for, row};
use ca_model::quantity::{self, show};
use ca_model::suggest::{nearest, ticked};
use core::fmt;

/// A change of the section.
#[derive(Clone, Copy, Debug, Default)]
pub struct Change<'a> {
    /// names of rows, each with `real:simulated`, e.g. `("mass", "20 g:1.0")`; at most two
    pub rows: &'a [(String, String)],
    /// what stays while one row is set: the name of a row, or `impedance`
    pub anchor: Option<&'a str>,
    /// a key with another scale
    pub key: Option<KeyScale<'a>>,
}

/// The scale of one device key. A lever is both factors of one number.
#[derive(Clone, Copy, Debug)]
pub struct KeyScale<'a> {
    /// name of the TGR
    pub key: &'a str,
    /// the arm of the lever
    pub lever: Option<f64>,
    /// factor of its positions
    pub position: Option<f64>,
    /// factor of its forces
    pub force: Option<f64>,
}

/// Why a section is not changed; with a remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refused {
    /// the row that is asked for, as `row=pair`, and what is wrong with it
    Row(String),
    /// what is wrong with the anchor
    Anchor(String),
    /// what is wrong with the key
    Key(String),
    /// what is asked for is too much, or is said twice
    Ask(String),
    /// `equivalence` of the text is a value
    NotASection,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refused::Row(why) => write!(f, "--set {why}"),
            Refused::Anchor(why) => write!(f, "--anchor: {why}"),
            Refused::Key(why) => write!(f, "--key: {why}"),
            Refused::Ask(why) => f.write_str(why),
            Refused::NotASection => f.write_str("`equivalence` is a value; write it as the section `[equivalence]`"),
        }
    }
}

impl core::error::Error for Refused {}

/// Changes the section of a text; `now` is the table of the model as it is.
///
/// # Errors
/// [`Refused`]; the text is then of no use.
pub fn change(text: &mut Document, now: &Equivalence, change: &Change) -> Result<(), Refused> {
    let anchor = change.anchor.map(class).transpose()?;
    let mut section = Section(text);
    section.0.make(&Section::place("").keys[..1]).ok_or(Refused::NotASection)?;
    if !change.rows.is_empty() || anchor.is_some() {
        rows(&mut section, now, change.rows, anchor)?;
    }
    change.key.map_or(Ok(()), |key| scale(section.0, &key))
}

/// The section in its text.
struct Section<'a>(&'a mut Document);

impl Section<'_> {
    fn place(key: &str) -> Place {
        Place::keys(["equivalence", key])
    }

    fn has(&self, key: &str) -> bool {
        self.0.keys(&Place::keys(["equivalence"])).contains(&key)
    }

    fn set(&mut self, key: &str, value: &Value) {
        _ = self.0.set(&Section::place(key), value);
    }

    fn clear(&mut self, key: &str) {
        _ = self.0.clear(&Section::place(key));
    }
}

/// The class that a word names.
fn class(word: &str) -> Result<Class, Refused> {
    let words = || ["impedance"].into_iter().chain(settable().map(|r| r.name));
    Class::of(word).filter(|c| *c != Class::Time).ok_or_else(|| {
        Refused::Anchor(match nearest(word, words()) {
            Some(near) => format!("there is no `{word}`; did you mean `{near}`?"),
            None => format!("there is no `{word}`; it is one of {}", ticked(words())),
        })
    })
}

fn settable() -> impl Iterator<Item = &'static Quantity> + Clone {
    ROWS.iter().filter(|r| r.class() != Class::Time)
}

/// A row to set, and its value as it will stand in the file.
fn asked(text: &(String, String)) -> Result<(&'static Quantity, Value), Refused> {
    let (name, pair) = text;
    let bad = |what: String| Refused::Row(format!("{name}={pair}: {what}"));
    let Some(row) = row(name).filter(|r| r.class() != Class::Time) else {
        let all = || settable().map(|r| r.name);
        return Err(bad(match nearest(name, all()) {
            Some(near) => format!("there is no `{name}`; did you mean `{near}`?"),
            None if name == "time" => "time has no equivalence of its own: the clock decides".into(),
            None => format!("there is no `{name}`; a row is one of {}", ticked(all())),
        }));
    };
    let Some((real, sim)) = pair.split_once(':') else {
        return Err(bad("write the real one and the simulated one, e.g. `mass=20g:1.0`".into()));
    };
    let mut list = Vec::new();
    for side in [real.trim(), sim.trim()] {
        let q = quantity::parse(side).map_err(|e| bad(format!("`{side}`: {e}")))?;
        if q.has_unit && !q.dim.same(row.unit.dim) {
            let is = quantity::unit_of(q.dim);
            return Err(bad(format!("`{side}` is in {is}, and `{name}` in {}", row.unit.symbol)));
        }
        if q.value <= 0.0 {
            return Err(bad(format!("`{side}`: it must be above 0")));
        }
        list.push(if q.has_unit { Value::Text(side.into()) } else { Value::Number(q.value) });
    }
    Ok((row, Value::List(list)))
}

/// The rows and the anchor of the whole.
fn rows(
    section: &mut Section,
    now: &Equivalence,
    rows: &[(String, String)],
    anchor: Option<Class>,
) -> Result<(), Refused> {
    let sets = rows.iter().map(asked).collect::<Result<Vec<_>, _>>()?;
    // what stays
    let held = match sets.as_slice() {
        [] => written(section).map(Quantity::class).or(now.anchor),
        [(row, _)] => {
            let class = row.class();
            let held = anchor.or(now.anchor.filter(|a| *a != class)).unwrap_or(anchor_for(class));
            if held == class {
                let what = format!("`{}` and the anchor are one equivalence said twice", row.name);
                return Err(Refused::Ask(format!("{what}; hold one of {}", beside(class))));
            }
            Some(held)
        }
        [(a, _), (b, _)] if a.class() == b.class() => {
            let what = format!("`{}` and `{}` are one equivalence said twice", a.name, b.name);
            return Err(Refused::Ask(format!("{what}; beside `{}`, set one of {}", a.name, beside(a.class()))));
        }
        [_, _] => None,
        _ => return Err(Refused::Ask("two equivalences settle the whole table: set one or two rows".into())),
    };
    if sets.is_empty() {
        // only the padlock moves: the table stays, so what followed from the old anchor is written down
        let others: Vec<Class> = settable().filter(|r| section.has(r.name)).map(Quantity::class).collect();
        if let [one] = others.as_slice() {
            pin(section, now.anchor.unwrap_or(anchor_for(*one)), now);
        }
    } else {
        for row in settable() {
            let keep = sets.iter().any(|s| s.0 == row) || held == Some(row.class());
            if !keep {
                section.clear(row.name);
            }
        }
        for (row, pair) in &sets {
            section.set(row.name, pair);
        }
        if let ([(row, _)], Some(held)) = (sets.as_slice(), held) {
            let standard = held.row().factor(Gains::default(), now.time_unit);
            let stays = held.row().factor(now.gains, now.time_unit) == standard;
            let only_row = settable().all(|r| r.class() != held || !section.has(r.name));
            if only_row && !(stays && (held == anchor_for(row.class()) || anchor.or(now.anchor) == Some(held))) {
                pin(section, held, now);
            }
        }
    }
    // an anchor that holds what the only row sets would be refused
    let only = settable().filter(|r| section.has(r.name)).collect::<Vec<_>>();
    if let Some(a) = anchor {
        section.set("anchor", &Value::Text(a.name().into()));
    } else if let ([one], Some(a)) = (only.as_slice(), now.anchor) {
        if one.class() == a {
            section.clear("anchor");
        }
    }
    Ok(())
}

/// A row that is written.
fn written(section: &Section) -> Option<&'static Quantity> {
    settable().find(|r| section.has(r.name))
}

/// Rows that may stand beside the rows of a class.
fn beside(class: Class) -> String {
    ticked(settable().filter(|r| r.class() != class).map(|r| r.name))
}

/// Writes down what a class is now.
fn pin(section: &mut Section, class: Class, now: &Equivalence) {
    let row = class.row();
    let real = Value::Text(show(row.factor(now.gains, now.time_unit), row.unit));
    section.set(row.name, &Value::List(vec![real, Value::Number(1.0)]));
}

/// The table of one key.
fn scale(text: &mut Document, key: &KeyScale) -> Result<(), Refused> {
    let owner = Place::keys(["equivalence"].into_iter().chain(key.key.split('.')));
    let name = key.key;
    let refused = || Refused::Key(format!("`[equivalence.{name}]` is not a table in this model"));
    text.make(&owner.keys).ok_or_else(refused)?;
    let lever = owner.clone().then("lever");
    let factors = [("position", key.position), ("force", key.force)].map(|(name, f)| (owner.clone().then(name), f));
    let old = text.value(&lever);
    if let Some(arm) = key.lever {
        for (place, _) in &factors {
            _ = text.clear(place);
        }
        return text.set(&lever, &Value::Number(arm)).ok_or_else(refused);
    }
    _ = text.clear(&lever);
    for (place, factor) in &factors {
        if let Some(value) = factor.map(Value::Number).or_else(|| old.clone()) {
            text.set(place, &value).ok_or_else(refused)?;
        }
    }
    Ok(())
}
