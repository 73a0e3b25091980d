//! `ca bench`: measures how many modules of each kind play in real time on this machine.
//!
//! The output compares this machine only with the DSP of the first paper. Figures of other machines could be mistaken
//! for this one. `ca-accuracy` measures.

use crate::outcome::{Ended, Failure, Outcome};
use crate::{page as pages, term};
use ca_accuracy::bench::page::{self, Measured, instrument, row, without};
use ca_accuracy::bench::{self, NETWORKS, Network, PAPER, RATES, SIZES, Size};
use ca_model::quantity::short;
use ca_model::suggest::nearest;
use clap::Args;
use serde_json::{Value as Json, json};
use std::io::Write as _;
use std::path::PathBuf;

/// Measures how many modules of each kind play in real time on this machine
///
/// A module is a MAT or a LIA. Each network grows until a tick takes as long as a sample at 44.1 and 48 kHz. Time is
/// the processor time of one core. Other running programs share its caches and its clock and may halve the result, so
/// stop them first.
///
/// The output also shows the three engines of Leonard, Castagné and Cadoz (2013, Table 1), on the DSP of their time,
/// and how many of each bundled instrument play at once. All modules have different parameters.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca bench
  ca bench --only string,cells,mesh
  ca bench --curve --page bench.html
  ca bench --only string --json")]
pub struct BenchArgs {
    /// Measures only these networks, given by name, and no instruments
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Measures also the cost of a string of 100 to 1 000 000 modules (takes half a minute and 2 GB)
    #[arg(long)]
    pub curve: bool,
    /// Writes an HTML page with the tables and the curve
    #[arg(long, value_name = "FILE.html")]
    pub page: Option<PathBuf>,
    /// Prints the tables as JSON
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(args: &BenchArgs) -> Outcome {
    if let Some(page) = &args.page {
        pages::is_page(page)?;
    }
    let wanted = wanted(&args.only)?;
    let models: &[(&str, &str)] = if args.only.is_empty() { ca_lab::load::BUNDLED } else { &[] };
    let sizes: &[usize] = if args.curve { &SIZES } else { &[] };
    let bar = term::progress((wanted.len() + models.len() + sizes.len()) as u64);
    let mut m = Measured { fits: Vec::new(), instruments: Vec::new(), curve: Vec::new() };
    for network in wanted {
        m.fits.push(bench::fits(network, || Ok(()))?);
        bar.inc(1);
    }
    for (name, text) in models {
        m.instruments.push(bench::instrument(name, text)?);
        bar.inc(1);
    }
    for modules in sizes {
        m.curve.push(bench::beside_streaming(*modules)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let Some(path) = &args.page {
        pages::write(path, &page::page(&m).html())?;
        term::note(&format!("page written to `{}`", path.display()));
    }
    if args.json {
        writeln!(std::io::stdout().lock(), "{:#}", value(&m))?;
    } else {
        text(&m)?;
    }
    Ok(Ended::Well)
}

/// Finds networks by name; returns all if `only` is empty.
fn wanted(only: &[String]) -> Result<Vec<&'static Network>, Failure> {
    let find = |wanted: &String| {
        let known = || NETWORKS.iter().map(|n| n.name);
        NETWORKS.iter().find(|n| n.name == wanted.trim()).ok_or_else(|| {
            let all = known().collect::<Vec<_>>().join(", ");
            if ca_lab::load::BUNDLED.iter().any(|(name, _)| *name == wanted.trim()) {
                let what = format!(
                    "`{wanted}` is an instrument, and `--only` chooses networks: {all}; \
                     leave out `--only` to measure instruments"
                );
                return Failure::Usage(what);
            }
            let help =
                nearest(wanted, known()).map_or(format!("choose from {all}"), |near| format!("did you mean `{near}`?"));
            Failure::Usage(format!("no network `{wanted}`; {help}"))
        })
    };
    if only.is_empty() {
        return Ok(NETWORKS.iter().collect());
    }
    let mut all: Vec<&Network> = Vec::new();
    for network in only.iter().map(find) {
        let network = network?;
        if all.iter().all(|n| n.name != network.name) {
            all.push(network);
        }
    }
    Ok(all)
}

fn text(m: &Measured) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let [a, b] = RATES.map(|r| format!("{} kHz", r / 1e3));
    writeln!(out, "Modules in real time on one core of {}:\n", ca_accuracy::timing::machine())?;
    writeln!(out, "  {:<12} {a:>10} {b:>10} {:>12}   made of", "network", "ns/module")?;
    for f in &m.fits {
        let [name, a, b, ns] = row(f);
        writeln!(out, "  {name:<12} {a:>10} {b:>10} {ns:>12}   {}", f.about)?;
    }
    writeln!(out, "\nOn the DSP of the first paper (ICMC 2013, Table 1), at 44.1 kHz:\n")?;
    for (engine, modules) in PAPER {
        writeln!(out, "  {modules:>10}   {engine}")?;
    }
    if !m.instruments.is_empty() {
        writeln!(out, "\nNumber of instruments that play at once in real time:\n")?;
        writeln!(out, "  {:<20} {:>8} {a:>10} {b:>10} {:>12}", "instrument", "modules", "ns/sample")?;
    }
    for i in &m.instruments {
        let [name, modules, a, b, ns] = instrument(i);
        writeln!(out, "  {name:<20} {modules:>8} {a:>10} {b:>10} {ns:>12}")?;
    }
    if let Some(why) = without(m) {
        writeln!(out, "\n  {why}")?;
    }
    if !m.curve.is_empty() {
        writeln!(
            out,
            "\n  {:>10} {:>12} {:>12} {:>14}   a string",
            "modules", "ns/tick", "ns/module", "its bytes, ns"
        )?;
    }
    for (s, bytes) in &m.curve {
        let [each, bytes] = [s.ns, *bytes].map(|ns| short(ns / s.modules.max(1) as f64));
        writeln!(out, "  {:>10} {:>12} {each:>12} {bytes:>14}", s.modules, short(s.ns))?;
    }
    Ok(())
}

fn value(m: &Measured) -> Json {
    let size = |(s, bytes): &(Size, f64)| json!({"modules": s.modules, "ns_per_tick": s.ns, "ns_of_its_bytes": bytes});
    let each = |s: &Size| s.ns / s.modules.max(1) as f64;
    let fits = m.fits.iter().map(|f| {
        let at: Vec<Json> =
            f.at.iter()
                .zip(RATES)
                .map(|(s, r)| json!({"rate": r, "modules": s.modules, "ns_per_tick": s.ns, "ns_per_module": each(s)}))
                .collect();
        json!({"network": f.name, "about": f.about, "in_real_time": at})
    });
    let instruments = m.instruments.iter().map(|i| {
        let all = i.at.iter().zip(RATES).zip(i.at_once());
        let at: Vec<Json> = all
            .filter_map(|((s, rate), n)| s.as_ref().map(|s| (s, rate, n)))
            .map(|(s, rate, n)| json!({"rate": rate, "modules": s.modules, "ns_per_sample": s.ns, "at_once": n}))
            .collect();
        json!({"instrument": i.name, "in_real_time": at})
    });
    let caches = ca_accuracy::timing::caches().into_iter().map(|(name, bytes)| json!({"name": name, "bytes": bytes}));
    json!({
        "machine": ca_accuracy::timing::machine(),
        "networks": fits.collect::<Vec<_>>(),
        "paper": PAPER.map(|(engine, modules)| json!({"engine": engine, "rate": 44_100.0, "modules": modules})),
        "instruments": instruments.collect::<Vec<_>>(),
        "caches": caches.collect::<Vec<_>>(),
        "curve": m.curve.iter().map(size).collect::<Vec<_>>(),
    })
}
