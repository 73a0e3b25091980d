//! Reports content of a file that its parts do not bring along: units, `[param]`, settings.
//!
//! A part is read in the units of the model, so a file in other units is an error. A name that only the file defines is
//! an error too, even if the model has a parameter of that name, which the author of the part did not mean. For a file
//! that is used as a whole the settings of the model apply, with a note.

use super::expander::{Expander, Home};
use super::scope::Scope;
use crate::diag::Diag;
use crate::model::{Entry, Model, Span, Use, Value};
use crate::suggest::ticked;
use alloc::format;
use alloc::vec::Vec;
use ca_core::{Kind, Type};

/// Keys of `[model]`, besides the units, that change the computation.
const SETTINGS: &[&str] = &["format", "gravity", "friction", "method", "theta", "start"];

impl Expander<'_> {
    /// Reports a file whose units differ from the model.
    pub fn same_units(&mut self, file: &str, of: &Model) {
        let Some(e) = of.meta("units") else { return };
        let (theirs, ours) = (word(Some(e)), word(self.model.meta("units")));
        let rate = of.meta("reference_rate").map(|e| &e.value);
        let other_rate =
            theirs == "alg" && rate.is_some() && rate != self.model.meta("reference_rate").map(|e| &e.value);
        if theirs == ours && !other_rate {
            return;
        }
        let what = if theirs == ours { "with another `reference_rate` than the model" } else { "unlike the model" };
        let d = Diag::error("E028", format!("`{file}` uses `{theirs}` units, {what}"));
        let help = format!(
            "write its numbers with units, such as `\"20 g\"`, and remove `units`; \
             or give the model the same `units = \"{theirs}\"` and `reference_rate`"
        );
        self.diags.push(d.at(e.span, "applies to this file only").help(help));
    }

    /// Notes the settings of a wholly used file that differ from the model.
    pub fn settings(&mut self, u: &Use, at: Span, home: &Home) {
        let ours = |section: &[Entry], e: &Entry| section.iter().any(|o| o.key == e.key && o.value == e.value);
        let meta = home.model.meta.iter().filter(|e| SETTINGS.contains(&e.key.as_str()));
        let meta = meta.filter(|e| !ours(&self.model.meta, e));
        let rate = home.model.rate.iter().filter(|e| !ours(&self.model.rate, e));
        let left: Vec<&Entry> = meta.chain(rate).collect();
        let Some(first) = left.first() else { return };
        if self.diags.list.iter().any(|d| d.code == "N202" && d.span() == at) {
            return;
        }
        let keys = ticked(left.iter().map(|e| e.key.as_str()));
        let d = Diag::note("N202", format!("`{}` uses `{}` without its {keys}", u.name, home.file));
        let d = d.at(at, "some settings are ignored").at(first.key_span, "ignored");
        let help = "only `[model]` and `[rate]` of the main model apply: write these settings there";
        self.diags.push(d.help(help));
    }

    /// Reports names in a number of a part that only the file of the part defines; `owner` is the module of the number.
    pub fn of_file(&mut self, e: &Entry, kind: Option<&'static Kind>, owner: &str, home: &Home, scope: &Scope) {
        use Type::{Between, Choice, File, Flag, Midi, Module, Text};
        if home.file.is_empty() || home.model.params.is_empty() {
            return;
        }
        let ty = kind.and_then(|k| k.param(&e.key).map(|i| k.params[i].ty));
        if !matches!(ty, Some(Between | Module | Choice(_) | Flag | Text | File | Midi)) {
            self.name_of_file(e, &e.key, owner, home, scope);
        }
    }

    fn name_of_file(&mut self, e: &Entry, key: &str, owner: &str, home: &Home, scope: &Scope) {
        let name = match &e.value {
            Value::List(l) | Value::Table(l) => {
                return l.iter().for_each(|x| self.name_of_file(x, key, owner, home, scope));
            }
            Value::Text(t) => t.trim(),
            _ => return,
        };
        let Some(p) = home.model.params.iter().find(|p| p.key == name) else { return };
        if scope.args.contains_key(name) || scope.own.contains(name) {
            return;
        }
        let d = Diag::error(
            "E013",
            format!("`{key}` of `{owner}`: a part cannot use `{name}`, a parameter of `{}`", home.file),
        );
        let part = self.open_parts.last().map_or("", |w| w.1.as_str());
        let help = format!(
            "a part can use only its own parameters: declare `{name}` in `[part.{part}.param]` and set it in `with`"
        );
        self.diags.push(d.at(e.span, "not a parameter of the part").at(p.key_span, "parameter of the file").help(help));
        self.model.lost.push(name.into());
    }
}

fn word(units: Option<&Entry>) -> &str {
    match units.map(|e| &e.value) {
        Some(Value::Text(t)) => t.trim(),
        _ => "si",
    }
}
