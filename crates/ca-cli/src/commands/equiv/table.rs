//! Prints the table of equivalences as text or JSON.

use crate::load::Loaded;
use crate::outcome::Failure;
use ca_core::equivalence::{Class, Equivalence, Gains, Quantity, ROWS, Scale};
use ca_core::{Scene, Unit};
use ca_lab::facts::border::scale_of;
use ca_model::quantity::{show, six};
use serde_json::{Value as Json, json};
use std::io::Write;

/// A model whose equivalences are shown.
pub(super) struct EquivalenceTable<'a> {
    name: &'a str,
    scene: &'a Scene,
}

impl<'a> EquivalenceTable<'a> {
    pub(super) fn new(loaded: &'a Loaded, scene: &'a Scene) -> EquivalenceTable<'a> {
        EquivalenceTable { name: if scene.about.title.is_empty() { &loaded.name } else { &scene.about.title }, scene }
    }

    fn e(&self) -> &Equivalence {
        &self.scene.hand.equivalence
    }

    fn alg(&self) -> bool {
        self.e().time_unit != 1.0
    }

    /// Formats the real quantity that corresponds to 1 of the model.
    fn real(&self, row: &Quantity, g: Gains) -> String {
        digits(row.factor(g, self.e().time_unit), row.unit)
    }

    fn one(&self, row: &Quantity) -> String {
        if self.alg() { "1".into() } else { format!("1 {}", row.unit.symbol) }
    }

    pub(super) fn text(&self, out: &mut impl Write, verbose: bool) -> Result<(), Failure> {
        let e = self.e();
        writeln!(out, "{}", self.name)?;
        if self.alg() {
            let rate = digits(1.0 / e.time_unit, Unit::HERTZ);
            writeln!(out, "  the model's numbers are per sample of {rate}: real = factor × simulated")?;
        } else {
            writeln!(out, "  the model's numbers are in SI: real = factor × simulated")?;
        }
        if self.scene.ports.tgr.is_empty() {
            writeln!(out, "  no device key (TGR): the scale has no effect")?;
        }
        let keys: Vec<&Scale> = e.keys.iter().collect();
        let all = if keys.is_empty() { "in the hand" } else { "all other keys" };
        write!(out, "\n  {:<13} {:<10} {all:<16}", "quantity", "simulated")?;
        keys.iter().try_for_each(|k| write!(out, " {:<16}", k.key))?;
        writeln!(out)?;
        for row in ROWS {
            write!(out, "  {:<13} {:<10} {:<16}", row.name, self.one(row), self.real(row, e.gains))?;
            keys.iter().try_for_each(|k| write!(out, " {:<16}", self.real(row, e.of(&k.key))))?;
            writeln!(out)?;
        }
        for k in keys {
            writeln!(out, "\n  `{}` is {}", k.key, scale_of(k))?;
        }
        if verbose {
            writeln!(
                out,
                "\n  alpha {} simulated metres per metre, beta {} newtons per simulated newton",
                e.gains.alpha, e.gains.beta
            )?;
            for k in &e.keys {
                let g = e.of(&k.key);
                writeln!(out, "  `{}`: alpha {}, beta {}", k.key, g.alpha, g.beta)?;
            }
        }
        Ok(())
    }

    pub(super) fn json(&self) -> Json {
        let e = self.e();
        let factors = |g: Gains| -> serde_json::Map<String, Json> {
            ROWS.iter().map(|r| (r.name.to_string(), json!(r.factor(g, e.time_unit)))).collect()
        };
        let rows: Vec<Json> = ROWS
            .iter()
            .map(|r| json!({"name": r.name, "unit": r.unit.symbol, "class": r.class().name(), "factor": r.factor(e.gains, e.time_unit)}))
            .collect();
        let keys: Vec<Json> = e
            .keys
            .iter()
            .map(|k| {
                let g = e.of(&k.key);
                json!({
                    "name": k.key, "position": k.position, "force": k.force, "lever": k.is_lever(),
                    "energy_gain": k.force / k.position, "factors": factors(g), "alpha": g.alpha, "beta": g.beta,
                })
            })
            .collect();
        json!({
            "title": self.name, "units": if self.alg() { "alg" } else { "si" }, "te": e.time_unit,
            "anchor": e.anchor.map(Class::name), "rows": rows, "keys": keys, "alpha": e.gains.alpha, "beta": e.gains.beta,
        })
    }
}

fn digits(v: f64, unit: Unit) -> String {
    show(six(v), unit)
}
