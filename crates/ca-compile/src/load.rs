//! From text to scene in one call, with one list of findings: what every front end does first.
//!
//! Decides that the compiler also looks at a model the reader found errors in, so that all errors of a file come in one
//! run. What the compiler says then is believed only where the reader has not been: one mistake is one finding, and
//! warnings about half a model are guesswork. A reader that stopped at its limit has said enough.

use crate::compile::{Compiled, compile};
use crate::options::Options;
use ca_core::Catalog;
use ca_model::diag::{Diag, Diags, Severity};
use ca_model::{Model, Span, read};

/// Reads and compiles a model; `file` is its name in reports.
///
/// The model is returned whatever happens: reports are rendered from its text. Warnings and notes of both steps are in
/// [`Compiled::findings`]; with an error there is no scene, and all findings are returned, sorted, none of them twice.
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

/// Compiles a model that was read, perhaps changed by [`Model::set`], with what the reader found.
///
/// # Errors
/// All findings, sorted, with an error among them.
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

/// True where a finding of the compiler only follows from one of the reader.
fn follows(d: &Diag, read: &[Diag], model: &Model) -> bool {
    let same = |o: &Diag| o.code == d.code && o.span() == d.span();
    // what is missing, in a module of which something could not be read
    let within =
        |whole: Span| read.iter().any(|o| o.labels.iter().any(|l| whole.start <= l.0.start && l.0.end <= whole.end));
    let item = || model.items.iter().find(|i| i.name_span == d.span() && d.span().is_some());
    match d.code {
        // an empty model, and references to what the reader has lost
        "E024" => true,
        "E013" if !d.span().is_some() => true,
        "E005" => {
            read.iter().any(same) || item().is_some_and(|i| within(Span { start: i.name_span.start, end: i.span.end }))
        }
        _ => read.iter().any(same),
    }
}
