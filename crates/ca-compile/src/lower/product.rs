//! Reads a number times a parameter, `"6.27 f"`.
//!
//! A product may replace the name of a parameter anywhere. It is evaluated when the scene is compiled, follows values
//! set by then, and costs the tick nothing. A live parameter cannot be scaled, so that its changes reach all places
//! alike. Sums and formulas are not supported: partials and proportions are factors, and more would be a language in
//! itself.

use crate::lower::parsed_param::ParsedParam;
use crate::lower::values::Values;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Unit;
use ca_model::Entry;
use ca_model::diag::Diag;
use ca_model::quantity::{self, QuantityError};
use ca_model::suggest::nearest;

/// Largest number of parameters listed in a finding.
const LISTED: usize = 8;

impl Values<'_> {
    /// Returns the number and the name, if a parameter of that name exists.
    pub(super) fn product<'t>(&self, text: &'t str) -> Option<(f64, &'t str)> {
        quantity::product(text).filter(|(_, name)| self.index.contains_key(*name))
    }

    /// Returns `factor` times the parameter `name`, for a number of unit `unit`.
    pub(super) fn scaled(&mut self, factor: f64, name: &str, unit: Unit, e: &Entry, what: &str) -> Option<f64> {
        // The range of the place applies to the product, not to the parameter.
        let (v, follows) = self.named_number(name, unit, (f64::MIN, f64::MAX), e, what)?;
        let Some((i, _)) = follows else { return Some(factor * v) };
        let short = name.rsplit('.').next().unwrap_or(name);
        let d = Diag::error("E025", format!("{what}: `{name}` is live, and a live parameter cannot be scaled"));
        let d = d.at(e.span, format!("a number times `{short}`")).at(self.named[i].span, "live here");
        self.diags.push(d.help("use a separate live parameter here, or remove `live` or `port` from this one"));
        None
    }

    /// Adds to a finding about a unit that the word may be a misspelt parameter.
    pub(super) fn near_parameter(&self, d: Diag, what: &str, text: &str, err: &QuantityError) -> Diag {
        let Some((_, word)) = quantity::product(text).filter(|_| err.hint.is_none()) else { return d };
        // Parameters of the model, and parameters of the instance by their names within the part.
        let here = |n: &ParsedParam| n.name.rsplit_once('.').is_none_or(|(of, _)| what.contains(&format!("`{of}.")));
        let names: Vec<&str> =
            self.named.iter().filter(|n| here(n)).filter_map(|n| n.name.rsplit('.').next()).collect();
        let Some(near) = nearest(word, names.iter().copied()) else { return d };
        let mended = text.trim().replace(word, near);
        let all: Vec<String> = names.iter().take(LISTED).map(|n| format!("`{n}`")).collect();
        let more = if names.len() > LISTED { ", …" } else { "" };
        d.help(format!("did you mean `{mended}`? parameters here: {}{more}", all.join(", ")))
    }
}
