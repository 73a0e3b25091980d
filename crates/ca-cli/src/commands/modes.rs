//! `ca modes`: computes the modes of the linear part of a model.
//!
//! Each port is a column in dB below its strongest mode, because players want to know which modes a blow or a pickup
//! favours. The raw values at the ports, in 1/√kg, are in the JSON.

use crate::args::Source;
use crate::args::common::count;
use crate::outcome::{Ended, Failure, Outcome};
use crate::{load, outputs, term};
use ca_compile::Options;
use ca_compile::analysis::{Mode, Modes, Network, modes};
use ca_io::atomic_file::AtomicFile;
use ca_lab::catalog;
use ca_lab::facts::border::ticks;
use ca_lab::facts::modes::{rate, value};
use ca_model::quantity::Plain;
use clap::Args;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Computes the modes of the linear part of a model
///
/// For each mode, prints its frequency in continuous time and as the scheme plays it at this sound rate, the difference
/// in cents, the time to decay by 60 dB, and how strongly each output measures it, each input drives it, and each
/// nonlinear link acts on it, in dB below the strongest mode there. Nonlinear links are not part of the modes; they are
/// listed by name. Parameters have their initial values, and moving points their initial positions.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca modes hammered_string
  ca modes iron_bar --modes 8 --rate '96 kHz'
  ca modes membrane --shapes shapes.csv
  ca modes hammered_string --set low.f='220 Hz' --json")]
pub struct ModesArgs {
    /// the model
    #[command(flatten)]
    pub source: Source,
    /// Number of modes, lowest first
    #[arg(short = 'n', long, default_value_t = 24, value_name = "N", value_parser = count)]
    pub modes: usize,
    /// Writes the mode shapes as CSV: one row per place, one column per mode
    #[arg(long, value_name = "FILE.csv")]
    pub shapes: Option<PathBuf>,
    /// Prints all modes as JSON
    #[arg(long)]
    pub json: bool,
}

/// Limit on the ports printed side by side; the JSON has all of them.
const COLUMNS: usize = 8;
/// Level at and below which a mode counts as silent at a port \[dB\].
const SILENT: f64 = -200.0;

/// Help for modules that no output measures.
const HEAR: &str = "add an output for it to include it";

/// Runs the command.
pub fn run(args: &ModesArgs) -> Outcome {
    if let Some(path) = &args.shapes {
        outputs::check_distinct(&[("--shapes", path)], &[("the model", Path::new(&args.source.model))])?;
    }
    let loaded = load::load(&args.source)?;
    let options = Options { rate: args.source.rate, clouds: loaded.clouds.clone(), ..Options::default() };
    let network = ca_compile::linear(&loaded.model, &catalog(), &options).map_err(|diags| {
        term::findings(&diags, &loaded.model);
        Failure::Reported
    })?;
    let n = network.linear.dofs.len();
    if n == 0 {
        if !network.unheard.is_empty() {
            let silent = load::ticked(network.unheard.iter().map(String::as_str));
            return Err(Failure::Failed(format!(
                "nothing that reaches an output moves; no output depends on {silent}: {HEAR}"
            )));
        }
        let but =
            if network.left_out.is_empty() { String::new() } else { format!("; not linear: {}", left_out(&network)) };
        return Err(Failure::Failed(format!("nothing in the linear part of this model moves{but}")));
    }
    let Some(found) = modes::modes(&network) else {
        let most = modes::LARGEST;
        return Err(Failure::Failed(format!(
            "{n} places move, which is too many for a table of modes: use at most {most}"
        )));
    };
    if let Some(path) = &args.shapes {
        shapes(path, &network, &found)?;
        term::note(&format!("shapes written to `{}`", path.display()));
    }
    if args.json {
        writeln!(std::io::stdout().lock(), "{:#}", value(&loaded.name, &network, &found))?;
    } else {
        text(&loaded.name, &network, &found, args.modes)?;
    }
    Ok(Ended::Well)
}

/// Lists the links that are not in the matrices, by name and kind.
fn left_out(network: &Network) -> String {
    let names: Vec<String> = network.left_out.iter().map(|(name, code)| format!("`{name}` ({code})")).collect();
    names.join(", ")
}

/// Levels of the modes at a port, in dB below the strongest.
fn levels(found: &Modes, port: &[(u32, f64)]) -> Vec<f64> {
    let at: Vec<f64> = found.list.iter().map(|m| m.at(port).abs()).collect();
    let top = at.iter().copied().fold(0.0, f64::max);
    at.iter().map(|v| if *v > 0.0 && top > 0.0 { 20.0 * (v / top).log10() } else { f64::NEG_INFINITY }).collect()
}

fn text(name: &str, network: &Network, found: &Modes, most: usize) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let swings = found.list.iter().filter(|m| m.heard > 0.0).count();
    writeln!(
        out,
        "{name}: {} places that move, {swings} oscillating modes, at {} Hz{}",
        network.names.len(),
        rate(network).round(),
        ticks(network.oversample)
    )?;
    if !network.left_out.is_empty() {
        writeln!(out, "  not included, because they are not linear: {}", left_out(network))?;
    }
    if !network.unheard.is_empty() {
        let silent = load::ticked(network.unheard.iter().map(String::as_str));
        writeln!(out, "  not included, because no output depends on them: {silent} ({HEAR})")?;
    }
    let ports: Vec<_> = network.ports.iter().take(COLUMNS).collect();
    let columns: Vec<Vec<f64>> = ports.iter().map(|p| levels(found, &p.at)).collect();
    let wide = |name: &str| name.chars().count().max(8);
    write!(out, "\n  {:>4} {:>12} {:>12} {:>9} {:>9}", "mode", "free [Hz]", "heard [Hz]", "cents", "T60 [s]")?;
    ports.iter().try_for_each(|p| write!(out, "  {:>1$}", p.name, wide(&p.name)))?;
    writeln!(out)?;
    for (j, m) in found.list.iter().enumerate().take(most) {
        write!(out, "  {:>4} {:>12} {:>12} {:>9} {:>9}", j + 1, hertz(m.f), hertz(m.heard), cents(m), seconds(m))?;
        for (p, c) in ports.iter().zip(&columns) {
            let level = if c[j] > SILENT { format!("{:.1} dB", c[j]) } else { "silent".into() };
            write!(out, "  {level:>0$}", wide(&p.name))?;
        }
        writeln!(out)?;
    }
    if found.list.len() > most {
        writeln!(out, "  … {} more: `--modes {}`", found.list.len() - most, found.list.len())?;
    }
    if network.ports.len() > COLUMNS {
        writeln!(out, "  {} more ports: see `--json`", network.ports.len() - COLUMNS)?;
    }
    if !network.force_outputs.is_empty() {
        writeln!(
            out,
            "  not included, because they do not measure displacement: {}",
            load::ticked(network.force_outputs.iter().map(String::as_str))
        )?;
    }
    if found.list.iter().any(|m| m.grows) {
        writeln!(out, "  a mode grows: the scene is unstable at this sound rate, see `ca check`")?;
    }
    if found.approximate {
        writeln!(out, "  damping couples the modes; T60 is computed for each mode alone")?;
    }
    Ok(())
}

fn hertz(f: f64) -> String {
    if f > 0.0 { format!("{:.4}", Plain(f)) } else { "-".into() }
}

fn cents(m: &Mode) -> String {
    if m.f > 0.0 && m.heard > 0.0 { format!("{:+.3}", m.cents()) } else { "-".into() }
}

fn seconds(m: &Mode) -> String {
    match m.t60 {
        _ if m.grows => "grows".into(),
        t if t.is_finite() => format!("{:.4}", Plain(t)),
        _ => "for ever".into(),
    }
}

/// Writes the mode shapes with a row per place and a column per mode \[1/√kg\].
fn shapes(path: &Path, network: &Network, found: &Modes) -> Result<(), Failure> {
    let bad =
        |e: std::io::Error| Failure::Failed(format!("`{}` cannot be written: {}", path.display(), load::reason(&e)));
    let staged = AtomicFile::create(path)?;
    let mut file = std::io::BufWriter::new(staged.handle()?);
    let mut write = || -> std::io::Result<()> {
        write!(file, "place")?;
        (1..=found.list.len()).try_for_each(|j| write!(file, ",mode {j}"))?;
        writeln!(file)?;
        for (i, name) in network.names.iter().enumerate() {
            // quoted, because names in meshes contain commas
            write!(file, "\"{name}\"")?;
            found.list.iter().try_for_each(|m| write!(file, ",{:e}", m.shape[i]))?;
            writeln!(file)?;
        }
        file.flush()
    };
    write().map_err(bad)?;
    Ok(staged.commit()?)
}
