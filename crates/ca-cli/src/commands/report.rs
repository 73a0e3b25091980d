//! `ca report`: writes the page of a model or a take built by [`ca_pages`]. The exit code tells whether the page has
//! warnings.

use super::{border, render};
use crate::args::common::quantity_of;
use crate::args::{Playing, Source};
use crate::load::{self, has_extension};
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, page, term};
use ca_core::Unit;
use ca_io::perform::Performance;
use ca_pages::{ModelPage, PageOptions, TRIED, Work};
use ca_report::{Report, Weight};
use clap::Args;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Writes a page about a model or a take
///
/// The page is one HTML file that needs no network. It has the sound with its waveform, spectrogram and spectrum, the
/// modes of the linear part, the motion of modules, the energy ledger, the error against run time for the beginning of
/// the sound, what is proven about stability, and the model itself.
///
/// A model is played as by `ca render`, with the energy ledger. A take (`*.mcap`) is shown as recorded: gestures,
/// forces, faults, and the timing of the real-time loop. It is replayed for the ledger. Exit code 3 as for `ca render`
/// and `ca replay`: the page is still written, and shows what is wrong.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca report hammered_string
  ca report hammered_string -o soft.html --set hammer.m='10 g' --seconds 2
  ca report hammered_string --probe hammer --probe 'low[3]' --gesture key.csv
  ca report take.mcap -o take.html")]
pub struct ReportArgs {
    /// the model, or a take
    #[command(flatten)]
    pub source: Source,
    /// Page to write (default: the name of the model in the current directory)
    #[arg(short, long, value_name = "FILE.html")]
    pub output: Option<PathBuf>,
    /// how it is played
    #[command(flatten)]
    pub playing: Playing,
    /// Shows the motion of a module, or the force of a link: `low[3]`, `strike`, `low@0.3`; repeatable (default: what
    /// the outputs measure, and the device keys)
    #[arg(long, value_name = "NAME")]
    pub probe: Vec<String>,
    /// Seconds of sound for the comparison of methods and rates, as in `ca accuracy`; 0 leaves it out (default: 0.2)
    #[arg(long, value_name = "S", value_parser = tried)]
    pub accuracy: Option<f64>,
    /// Prints only warnings and errors
    #[arg(short, long)]
    pub quiet: bool,
}

fn tried(text: &str) -> Result<f64, String> {
    quantity_of(text, Unit::SECOND, (0.0, 3600.0))
}

/// Runs the command.
pub fn run(args: &ReportArgs) -> Outcome {
    let source = Path::new(&args.source.model);
    let is_take = has_extension(source, "mcap");
    if let Some(path) = &args.output {
        page::is_page(path)?;
        outputs::check_distinct(&[("-o", path)], &render::inputs(&args.source.model, &args.playing.gesture))?;
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
        remedy: "play longer with `--accuracy`, or compare another module with `--probe`",
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

fn take(args: &ReportArgs, file: &Path) -> Result<(String, Report), Failure> {
    let played = &args.playing;
    useless(
        "a take is shown as it was played; to play it with changes, use `ca render MODEL --gesture TAKE`",
        &[
            ("--preset", args.source.preset.is_some()),
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
