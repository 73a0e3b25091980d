//! `ca accuracy`: error against run time, over methods and rates.

use crate::args::Source;
use crate::args::common::seconds;
use crate::load;
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, page, term};
use ca_accuracy::timing::Clock;
use ca_accuracy::{AccuracyOptions, Measured, Reported};
use clap::Args;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Measures error and run time of a model with several methods and sound rates
///
/// Plays the model as it is, with every other method of its modules, in single precision, and at multiples of its rate,
/// and compares the signals at its outputs (before gains and filters) with a reference. The reference is the closed
/// form of the modes if the model is linear and nothing drives it. Otherwise it is the same model at a far higher rate,
/// with Richardson extrapolation, and a second method must agree with it. Its uncertainty is printed; if the methods
/// disagree, it is called not known.
///
/// Each row shows the relative RMS error of the signal and of its spectrum, the error of pitch in cents and of decay in
/// dB, the relative error of energy, and the run time in ns per sample on this machine. Rows on the Pareto front of
/// error and time are marked. With `--error`, the fastest row within that error whose stability is proven is named.
/// Exit code 3 if there is none.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca accuracy plucked_string --seconds 0.3 --times 1,2 --reference 8
  ca accuracy hammered_string --seconds 0.2 --times 1,2 --reference 8 --error 0.9
  ca accuracy glass --seconds 0.3 --times 1,2 --reference 8 --json
  ca accuracy marimba --seconds 0.2 --times 1 --reference 4 -o marimba.html")]
pub struct AccuracyArgs {
    /// the model
    #[command(flatten)]
    pub source: Source,
    /// Seconds to play (default: `seconds` of the model, at most 1 s; less for a model that takes long)
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Multiples of the sound rate to try (default: 1,2,4,8; fewer for a model that takes long)
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub times: Vec<u32>,
    /// Multiple of the sound rate for a reference without closed form (default: 64; less for a model that takes long)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=4096))]
    pub reference: Option<u32>,
    /// Compares the signal of this module instead of the outputs, e.g. `low[3]` or `strike`; repeatable
    #[arg(long, value_name = "NAME")]
    pub probe: Vec<String>,
    /// Names the fastest proven row with at most this relative RMS error, e.g. 1e-3; `ca render --error` renders with
    /// it
    #[arg(long, value_name = "E", value_parser = share)]
    pub error: Option<f64>,
    /// Writes an HTML page with the plot and the table
    #[arg(short, long, value_name = "FILE.html")]
    pub output: Option<PathBuf>,
    /// Prints the table as JSON
    #[arg(long)]
    pub json: bool,
}

/// Parses an error.
pub(super) fn share(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err("expected a number above 0, e.g. 1e-3".into()),
    }
}

/// Runs the command.
pub fn run(args: &AccuracyArgs) -> Outcome {
    if let Some(path) = &args.output {
        page::is_page(path)?;
        outputs::check_distinct(&[("-o", path)], &[("the model", Path::new(&args.source.model))])?;
    }
    let loaded = load::load(&args.source)?;
    let probes = if args.probe.is_empty() { ca_accuracy::heard(&loaded.model) } else { args.probe.clone() };
    if probes.is_empty() {
        let what = format!("`{}` has no output to compare", loaded.name);
        return Err(Failure::Failed(format!("{what}; choose a module to compare with `--probe`")));
    }
    let times = Some(&args.times[..]).filter(|times| !times.is_empty());
    let (rate, seconds) = (args.source.rate, args.seconds);
    let mut bar = None;
    let progress = &mut |done, of| {
        bar.get_or_insert_with(|| term::progress(of)).set_position(done);
        true
    };
    let mut ask = AccuracyOptions {
        rate,
        probes: &probes,
        seconds,
        times,
        reference: args.reference,
        remedy: "play longer with `--seconds`, or compare another module with `--probe`",
        clock: Clock::WALL,
        progress,
    };
    let found = ca_accuracy::measured(&loaded, &mut ask);
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    let found = found?;
    let reported = Reported::new(&loaded.name, &found, args.error, "--");
    if args.json {
        writeln!(std::io::stdout().lock(), "{:#}", reported.json())?;
    } else {
        text(&reported)?;
    }
    if let Some(path) = &args.output {
        page::write(path, &reported.page(&loaded.model).html())?;
        term::note(&format!("page written to `{}`", path.display()));
    }
    Ok(if args.error.is_some() && reported.best.is_none() { Ended::Degraded } else { Ended::Well })
}

fn text(reported: &Reported) -> Result<(), Failure> {
    let f = reported.found;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}: {:.3} s at {} Hz, against {}", reported.name, f.seconds(), f.rate, f.origin())?;
    let cells: Vec<Vec<String>> = f.rows.iter().map(|r| f.cells(r)).collect();
    let wide =
        |k: usize| cells.iter().map(|c| c[k].chars().count()).chain([Measured::HEAD[k].len()]).max().unwrap_or(0);
    let line = |row: &[&str]| {
        let all = row
            .iter()
            .enumerate()
            .map(|(k, c)| if k == 0 || k == 8 { format!("{c:<0$}", wide(k)) } else { format!("{c:>0$}", wide(k)) });
        format!("  {}", all.collect::<Vec<_>>().join("  ")).trim_end().to_owned()
    };
    writeln!(out, "{}", line(&Measured::HEAD))?;
    for row in &cells {
        writeln!(out, "{}", line(&row.iter().map(String::as_str).collect::<Vec<_>>()))?;
    }
    writeln!(out, "  * no other row is both more exact and faster")?;
    for (method, why) in &f.refused {
        writeln!(out, "  method {method} not possible: {why}")?;
    }
    for (method, what) in &f.warned {
        writeln!(out, "  method {method}: {what}")?;
    }
    if let Some(verdict) = reported.verdict() {
        writeln!(out, "{verdict}")?;
    }
    Ok(())
}
