//! Edits the section `[equivalence]`: rows, anchor and the scale of a key.
//!
//! The written rows determine the table. If one row is set, the row of the anchor is written beside it, unless the
//! anchor has the value that it would have without the section.

use crate::{Document, Place, Value};
use ca_core::equivalence::{Class, Equivalence, Gains, Quantity, ROWS, anchor_for, row};
use ca_model::quantity::{self, show};
use ca_model::suggest::{nearest, ticked};
use core::fmt;

/// Changes to make in the section.
#[derive(Clone, Copy, Debug, Default)]
pub struct Change<'a> {
    /// Names of rows, each with `real:simulated`, e.g. `("mass", "20 g:1.0")`; at most two.
    pub rows: &'a [(String, String)],
    /// Quantity that is held while one row is set: the name of a row, or `impedance`.
    pub anchor: Option<&'a str>,
    /// New scale of one key.
    pub key: Option<KeyScale<'a>>,
}

/// Scale of one device key. A lever scales positions and forces by the same factor.
#[derive(Clone, Copy, Debug)]
pub struct KeyScale<'a> {
    /// Name of the TGR.
    pub key: &'a str,
    /// Factor of the lever.
    pub lever: Option<f64>,
    /// Factor of the positions.
    pub position: Option<f64>,
    /// Factor of the forces.
    pub force: Option<f64>,
}

/// Reason why a section is not changed, with a remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refused {
    /// Error in a requested row, as `row=pair: error`.
    Row(String),
    /// Error in the anchor.
    Anchor(String),
    /// Error in the key.
    Key(String),
    /// Request that sets too many rows, or one equivalence twice.
    Ask(String),
    /// `equivalence` is a value in the text, not a section.
    NotASection,
}

impl Refused {
    /// Returns the error without the option of the command line.
    pub fn reason(&self) -> String {
        match self {
            Refused::Row(why) | Refused::Anchor(why) | Refused::Key(why) | Refused::Ask(why) => why.clone(),
            Refused::NotASection => self.to_string(),
        }
    }
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

/// Changes the section of a text. `now` is the equivalence table of the unchanged model.
///
/// # Errors
/// Returns [`Refused`]; `text` may then be half changed and must be discarded.
pub fn change(text: &mut Document, now: &Equivalence, change: &Change) -> Result<(), Refused> {
    let anchor = change.anchor.map(class).transpose()?;
    let mut section = Section(text);
    section.0.make(&Section::place("").keys[..1]).ok_or(Refused::NotASection)?;
    if !change.rows.is_empty() || anchor.is_some() {
        rows(&mut section, now, change.rows, anchor)?;
    }
    change.key.map_or(Ok(()), |key| scale(section.0, &key))
}

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

fn class(word: &str) -> Result<Class, Refused> {
    let words = || ["impedance"].into_iter().chain(settable().map(|r| r.name));
    Class::of(word).filter(|c| *c != Class::Time).ok_or_else(|| {
        Refused::Anchor(match nearest(word, words()) {
            Some(near) => format!("unknown quantity `{word}`; did you mean `{near}`?"),
            None => format!("unknown quantity `{word}`; choose one of {}", ticked(words())),
        })
    })
}

fn settable() -> impl Iterator<Item = &'static Quantity> + Clone {
    ROWS.iter().filter(|r| r.class() != Class::Time)
}

/// Parses a requested row and returns it with the value to write in the file.
fn asked(text: &(String, String)) -> Result<(&'static Quantity, Value), Refused> {
    let (name, pair) = text;
    let bad = |what: String| Refused::Row(format!("{name}={pair}: {what}"));
    let Some(row) = row(name).filter(|r| r.class() != Class::Time) else {
        let all = || settable().map(|r| r.name);
        return Err(bad(match nearest(name, all()) {
            Some(near) => format!("unknown quantity `{name}`; did you mean `{near}`?"),
            None if name == "time" => "`time` cannot be set: the clock determines it".into(),
            None => format!("unknown quantity `{name}`; choose one of {}", ticked(all())),
        }));
    };
    let Some((real, sim)) = pair.split_once(':') else {
        return Err(bad("write the real and the simulated value, e.g. `mass=20g:1.0`".into()));
    };
    let mut list = Vec::new();
    for side in [real.trim(), sim.trim()] {
        let q = quantity::parse(side).map_err(|e| bad(format!("`{side}`: {e}")))?;
        if q.has_unit && !q.dim.same(row.unit.dim) {
            let is = quantity::unit_of(q.dim);
            return Err(bad(format!("`{side}` must be in {}, not in {is}", row.unit.symbol)));
        }
        if q.value <= 0.0 {
            return Err(bad(format!("`{side}` must be above 0")));
        }
        list.push(if q.has_unit { Value::Text(side.into()) } else { Value::Number(q.value) });
    }
    Ok((row, Value::List(list)))
}

fn rows(
    section: &mut Section,
    now: &Equivalence,
    rows: &[(String, String)],
    anchor: Option<Class>,
) -> Result<(), Refused> {
    let sets = rows.iter().map(asked).collect::<Result<Vec<_>, _>>()?;
    let held = match sets.as_slice() {
        [] => written(section).map(Quantity::class).or(now.anchor),
        [(row, _)] => {
            let class = row.class();
            let held = anchor.or(now.anchor.filter(|a| *a != class)).unwrap_or(anchor_for(class));
            if held == class {
                let what = format!("`{}` and the anchor are the same equivalence", row.name);
                return Err(Refused::Ask(format!("{what}; choose another anchor: {}", beside(class))));
            }
            Some(held)
        }
        [(a, _), (b, _)] if a.class() == b.class() => {
            let what = format!("`{}` and `{}` are the same equivalence", a.name, b.name);
            return Err(Refused::Ask(format!("{what}; with `{}`, set one of {}", a.name, beside(a.class()))));
        }
        [_, _] => None,
        _ => return Err(Refused::Ask("two equivalences determine the whole table: set one or two rows".into())),
    };
    if sets.is_empty() {
        // only the anchor moves: the table must stay the same, so the row that the old anchor implied is written
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
    // the compiler refuses an anchor in the class of the only row
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

fn written(section: &Section) -> Option<&'static Quantity> {
    settable().find(|r| section.has(r.name))
}

fn beside(class: Class) -> String {
    ticked(settable().filter(|r| r.class() != class).map(|r| r.name))
}

/// Writes the present value of a class as a row.
fn pin(section: &mut Section, class: Class, now: &Equivalence) {
    let row = class.row();
    let real = Value::Text(show(row.factor(now.gains, now.time_unit), row.unit));
    section.set(row.name, &Value::List(vec![real, Value::Number(1.0)]));
}

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
