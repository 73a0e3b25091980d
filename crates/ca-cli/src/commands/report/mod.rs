//! `ca report`: a page about a model or a take.
//!
//! Decides what is on the page and in which order: first what is wrong, then what is heard, then what explains it, then
//! the model. Everything that a page can be made of is made into one, also silence, a divergence or a take that was cut
//! off; the exit code says what the note on the page says. How the page looks is `ca-report`'s.

mod loops;
mod model;
mod parts;
mod played;
mod take;

use crate::args::ReportArgs;
use crate::commands::render;
use crate::load::has_extension;
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, page, term};
use ca_report::{Report, Weight};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Runs the command.
pub fn run(args: &ReportArgs) -> Outcome {
    let source = Path::new(&args.source.model);
    let is_take = has_extension(source, "mcap");
    if let Some(path) = &args.output {
        page::is_page(path)?;
        outputs::apart(&[("-o", path)], &render::inputs(&args.source.model, &args.playing.gesture))?;
    }
    let (name, report) = if is_take { take::report(args, source)? } else { model::report(args)? };
    let output = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.html")));
    for (weight, text) in &report.notes {
        match weight {
            Weight::Warning => term::warning(text),
            Weight::Note if args.quiet => {}
            Weight::Note => term::note(text),
        }
    }
    let html = report.html();
    page::write(&output, &html)?;
    if !args.quiet {
        let titles: Vec<String> = report.sections.iter().map(|s| s.title.to_lowercase()).collect();
        let kb = html.len().div_ceil(1000);
        writeln!(std::io::stdout().lock(), "{}: {kb} kB: {}", output.display(), titles.join(", "))?;
    }
    Ok(if degraded(&report) { Ended::Degraded } else { Ended::Well })
}

/// Whether something is not as meant.
fn degraded(report: &Report) -> bool {
    report.notes.iter().any(|n| n.0 == Weight::Warning)
}

/// Refuses what the thing to be shown has no use for.
fn useless(what: &str, given: &[(&str, bool)]) -> Result<(), Failure> {
    match given.iter().find(|g| g.1) {
        Some((name, _)) => Err(Failure::Usage(format!("{name}: {what}"))),
        None => Ok(()),
    }
}
