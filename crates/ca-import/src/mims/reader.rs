//! Resolves the words of a line to numbers, named parameters and modules, and gives labels new names.
//!
//! An unknown word is reported at its place, with the nearest known one.

use super::names::{Losses, legal};
use super::parse::{Line, Token, shown};
use super::part::{Arg, Net};
use super::types::nearest;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use ca_model::Span;
use ca_model::diag::{Diag, Diags};

pub(super) struct Reader<'a, 'd> {
    pub net: Net,
    pub losses: Losses,
    pub diags: &'d mut Diags,
    /// Name of a parameter → index into [`Net::params`].
    pub params: BTreeMap<&'a str, usize>,
    /// Label of a material element → its part.
    pub mats: BTreeMap<&'a str, usize>,
    /// Labels of all other lines.
    pub other_labels: BTreeMap<&'a str, Span>,
}

impl<'a> Reader<'a, '_> {
    /// Returns the number of an argument where its name cannot stay, and records that.
    pub fn fold(&mut self, arg: Arg, by: &str) -> f64 {
        if let Arg::Param(i) = arg {
            self.net.params[i].folded.get_or_insert_with(|| by.to_string());
        }
        self.net.value(arg)
    }

    /// Returns a unique name for `label`, with a note if it differs from the label.
    pub fn name(&mut self, label: Token<'a>) -> String {
        let wanted = legal(label.text);
        if wanted.is_empty() {
            let d = Diag::error("E014", "the name after `@` is missing");
            self.diags.push(d.at(label.span, "expected a label"));
        }
        let name = self.net.names.unique(&wanted);
        if name != wanted {
            let d = Diag::note("N201", format!("`{}` is used twice; this one is now `{name}`", shown(label.text)));
            self.losses.add(&name, d.at(label.span, "renamed"));
        } else if wanted != label.text {
            let d = Diag::note("N201", format!("`{}` is not a valid name; it is now `{name}`", shown(label.text)));
            self.losses.add("renamed", d.at(label.span, "letters, digits and `_`"));
        }
        name
    }

    pub fn twice(&mut self, line: &Line<'a>, first: Span) {
        let d = Diag::error("E012", format!("name used twice: `{}`", shown(line.label.text)))
            .at(line.label.span, "again here")
            .at(first, "first here")
            .help("references to it would be ambiguous; rename one of them");
        self.diags.push(d);
    }

    pub fn mat(&mut self, token: &Token<'a>) -> Option<usize> {
        let Some(label) = token.text.strip_prefix('@') else {
            let d = Diag::error("E006", format!("expected a module: `{}`", shown(token.text)));
            self.diags.push(d.at(token.span, "a module is written `@label`"));
            return None;
        };
        if let Some(&part) = self.mats.get(label) {
            return Some(part);
        }
        let found = shown(label);
        let d = if self.other_labels.contains_key(label) || self.params.contains_key(label) {
            Diag::error("E017", format!("not a material element: `{found}`"))
                .at(token.span, "expected a mass or ground")
        } else {
            let d = Diag::error("E013", format!("unknown name: `{found}`")).at(token.span, "no line defines it");
            match nearest(label, self.mats.keys().copied().take(1000)) {
                Some(name) => d.help(format!("did you mean `@{name}`?")).fix(token.span, format!("@{name}")),
                None => d,
            }
        };
        self.diags.push(d);
        None
    }

    pub fn arg(&mut self, token: &Token<'a>) -> Option<Arg> {
        if let Some(x) = number(token.text) {
            return Some(Arg::Num(x));
        }
        if let Some(&i) = self.params.get(token.text) {
            return Some(Arg::Param(i));
        }
        let found = shown(token.text);
        let d = if token.text.starts_with('@') {
            Diag::error("E006", format!("expected a number: `{found}`")).at(token.span, "a module")
        } else if token.text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
            Diag::error("E007", format!("not a number: `{found}`")).at(token.span, "expected a number")
        } else {
            let d =
                Diag::error("E013", format!("unknown parameter: `{found}`")).at(token.span, "no `param` of this name");
            match nearest(token.text, self.params.keys().copied().take(1000)) {
                Some(name) => d.help(format!("did you mean `{name}`?")).fix(token.span, name),
                None => d,
            }
        };
        self.diags.push(d);
        None
    }
}

/// Parses a finite number as MIMS writes it (`0.`, `.5`, `1e-3`); words such as `inf` are names.
pub(super) fn number(text: &str) -> Option<f64> {
    text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c))
        .then(|| text.parse::<f64>().ok())
        .flatten()
        .filter(|x| x.is_finite())
}
