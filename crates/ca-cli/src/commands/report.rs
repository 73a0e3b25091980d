//! `ca report`: writes the page of a model or a take, which [`ca_pages`] makes. The exit code says whether the page warns.

use super::{border, render};
use crate::args::ReportArgs;
use crate::load::{self, has_extension};
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, page, term};
use ca_io::perform::Performance;
use ca_pages::{ModelPage, PageOptions, TRIED, Work};
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
    let (name, report) = if is_take { take(args, source)? } else { model(args)? };
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
    Ok(if ca_pages::is_degraded(&report) { Ended::Degraded } else { Ended::Well })
}

/// The page of a model, with its name.
fn model(args: &ReportArgs) -> Result<(String, Report), Failure> {
    render::listen();
    let loaded = load::load(&args.source)?;
    let page = ModelPage::new(&loaded, args.source.rate, &args.probe)?;
    load::warn(&loaded, page.scene());
    border::idle(&args.source, page.scene());
    let gesture = render::gesture(&args.playing, page.scene())?;
    let performance = Performance::new(page.scene(), gesture.as_ref())?;
    let (_, length) = render::length(&args.playing, &performance);
    let options = PageOptions {
        seconds: args.playing.seconds,
        accuracy: args.accuracy.unwrap_or(TRIED),
        changes: args.source.changes().collect(),
        remedy: "play longer with `--accuracy`, or listen elsewhere with `--probe`",
    };
    let mut playing = render::Progress::new(length.frames, !args.quiet);
    let mut comparing = None;
    let report = page.report(performance, gesture.as_ref(), &options, &mut |work| match work {
        Work::Played(done, _) => playing.goes_on(done),
        Work::Warning(what) => {
            playing.end();
            term::warning(what);
            true
        }
        Work::Compared(done, of) => {
            playing.end();
            if !args.quiet {
                comparing.get_or_insert_with(|| term::progress(of)).set_position(done);
            }
            !render::stopped()
        }
    });
    playing.end();
    if let Some(bar) = comparing {
        bar.finish_and_clear();
    }
    let report = report?;
    Ok((loaded.name, report))
}

/// The page of a take, with its name.
fn take(args: &ReportArgs, file: &Path) -> Result<(String, Report), Failure> {
    let played = &args.playing;
    useless(
        "a take is shown as it was played; `ca render MODEL --gesture TAKE` plays it otherwise",
        &[
            ("--set", args.source.changes().next().is_some()),
            ("--rate", args.source.rate.is_some()),
            ("--seconds", played.seconds.is_some()),
            ("--gesture", !played.gesture.is_empty()),
            ("--probe", !args.probe.is_empty()),
            ("--accuracy", args.accuracy.is_some()),
        ],
    )?;
    Ok(ca_pages::take(file)?)
}

/// Refuses options without effect.
fn useless(what: &str, given: &[(&str, bool)]) -> Result<(), Failure> {
    match given.iter().find(|g| g.1) {
        Some((name, _)) => Err(Failure::Usage(format!("{name}: {what}"))),
        None => Ok(()),
    }
}
