//! Reads and compiles a model from text, with one list of findings. All front ends start here.
//!
//! The compiler also runs on a model with reading errors, so that one run reports all errors of a file. In that case
//! only its errors are kept, and only at places that the reader has not reported: one mistake gives one finding, and
//! warnings about an incomplete model would be guesses. If the reader has reached its limit of findings, the compiler
//! does not run.

use crate::compile::{Compiled, compile};
use crate::options::Options;
use ca_core::Catalog;
use ca_model::diag::{Diag, Diags, Severity};
use ca_model::{Model, Span, read};

/// Reads and compiles a model; `file` is its name in reports.
///
/// The model is returned in any case, because reports are rendered from its text. [`Compiled::findings`] has the
/// warnings and notes of both steps. If there is an error, the result is all findings, sorted and without duplicates.
///
/// ```
/// use ca_compile::{Options, load};
/// use ca_core::Catalog;
/// use ca_model::render;
/// let text = "[MAS]\nbob = { m = '20 gr', mm = 3 }\n[SOX]\nout = { from = 'bop' }\n";
/// let (model, result) = load(text, "bob.ca.toml", &ca_model::catalog(), &Options::default());
/// let found = result.unwrap_err();
/// let codes: Vec<_> = found.list.iter().map(|d| d.code).collect();
/// assert_eq!(codes, ["E007", "E004", "E013"]);
/// assert!(render::text(&found, &model, false).contains("did you mean `bob`?"));
/// ```
pub fn load(text: &str, file: &str, catalog: &Catalog, options: &Options) -> (Model, Result<Compiled, Diags>) {
    let (model, found) = read::read(text, file, catalog);
    let result = finish(&model, found, catalog, options);
    (model, result)
}

/// Compiles a model that was read, and possibly changed by [`Model::set`]; `found` holds the findings of the reader.
///
/// # Errors
/// All findings, sorted, with at least one error.
pub fn finish(model: &Model, found: Diags, catalog: &Catalog, options: &Options) -> Result<Compiled, Diags> {
    if found.is_full() {
        return Err(found);
    }
    let result = compile(model, catalog, options);
    if !found.has_errors() {
        let merge = |more: Diags| {
            let mut all = found.clone();
            all.extend(more);
            all.sort();
            all.merge_instances();
            all
        };
        return match result {
            Ok(Compiled { scene, audited, findings }) => Ok(Compiled { scene, audited, findings: merge(findings) }),
            Err(diags) => Err(merge(diags)),
        };
    }
    let mut all = found;
    let read = all.list.len();
    for d in result.err().into_iter().flat_map(|d| d.list) {
        if d.severity == Severity::Error && !follows(&d, &all.list[..read], model) {
            all.push(d);
        }
    }
    all.sort();
    all.merge_instances();
    Err(all)
}

/// Returns whether a finding of the compiler is a consequence of one of the reader.
fn follows(d: &Diag, read: &[Diag], model: &Model) -> bool {
    let same = |o: &Diag| o.code == d.code && o.span() == d.span();
    // True if the reader reported something within this span.
    let within =
        |whole: Span| read.iter().any(|o| o.labels.iter().any(|l| whole.start <= l.0.start && l.0.end <= whole.end));
    let item = || model.items.iter().find(|i| i.name_span == d.span() && d.span().is_some());
    match d.code {
        // The model is empty, or refers to something that the reader could not read.
        "E024" => true,
        "E013" if !d.span().is_some() => true,
        "E005" => {
            read.iter().any(same) || item().is_some_and(|i| within(Span { start: i.name_span.start, end: i.span.end }))
        }
        _ => read.iter().any(same),
    }
}
