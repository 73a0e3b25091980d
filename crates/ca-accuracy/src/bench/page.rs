//! Report of a bench: the tables, and the curve of cost against size.

use super::{BYTES, Fits, Instrument, PAPER, RATES, Size};
use crate::timing;
use ca_model::quantity::short;
use ca_report::{Axis, Block, Curve, Grid, Mark, Plot, Report, Section, Table};

/// Measurements of a bench.
#[derive(Default)]
pub struct Measured {
    /// Networks.
    pub fits: Vec<Fits>,
    /// Bundled models.
    pub instruments: Vec<Instrument>,
    /// String of each size, and the time to read and write its bytes \[ns\].
    pub curve: Vec<(Size, f64)>,
}

/// Returns the cells: name, modules at each rate, time per module.
pub fn row(f: &Fits) -> [String; 4] {
    let [a, b] = f.at;
    [f.name.into(), a.modules.to_string(), b.modules.to_string(), short(a.ns / a.modules.max(1) as f64)]
}

/// Returns the cells: name, modules, copies at once at each rate, time per sample at the lowest rate at which it plays.
pub fn instrument(i: &Instrument) -> [String; 5] {
    let size = i.at.iter().flatten().next();
    let [a, b] = i.at_once().map(|n| n.map_or_else(|| "–".into(), |n| n.to_string()));
    [
        i.name.into(),
        size.map_or_else(String::new, |s| s.modules.to_string()),
        a,
        b,
        size.map_or_else(String::new, |s| short(s.ns)),
    ]
}

/// Returns a remark on instruments that do not play at one of the rates.
pub fn without(m: &Measured) -> Option<String> {
    let missing = |i: &Instrument| Some((i.name, RATES[i.at.iter().position(Option::is_none)?] / 1e3));
    let (name, rate) = m.instruments.iter().find_map(missing)?;
    Some(format!("–: cannot be played at that rate; `ca render {name} --rate '{rate} kHz'` prints the reason"))
}

/// Makes the report.
pub fn page(m: &Measured) -> Report {
    let mut report = Report::new("Modules in real time", &timing::machine());
    let [a, b] = RATES.map(|r| format!("at {} kHz", r / 1e3));
    if !m.fits.is_empty() {
        let rows = m.fits.iter().map(|f| {
            let [name, a, b, ns] = row(f);
            vec![name, f.about.into(), a, b, ns]
        });
        let table = Table::new(&["network", "made of", &a, &b, "ns/module"], rows.collect());
        let paper = PAPER.map(|(engine, modules)| vec![engine.to_string(), modules.to_string()]);
        let words = "A module is a MAT or a LIA. On the DSP of the first paper (ICMC 2013, Table 1), at 44.1 kHz:";
        let blocks = vec![
            Block::Table(table),
            Block::Text(words.into()),
            Block::Table(Table::new(&["engine", "modules"], paper.into())),
        ];
        report.sections.push(Section::new("Networks", blocks));
    }
    if !m.instruments.is_empty() {
        let rows = m.instruments.iter().map(|i| instrument(i).to_vec());
        let table = Table::new(&["instrument", "modules", &a, &b, "ns/sample"], rows.collect());
        let mut blocks = vec![Block::Table(table)];
        blocks.extend(without(m).map(Block::Text));
        report.sections.push(Section::new("Simultaneous instruments in real time", blocks));
    }
    if !m.curve.is_empty() {
        let words = format!(
            "A tick of a string reads {BYTES} bytes for each module and writes two fifths of them back. The other curve is the \
             time that this machine needs for these bytes with hardly any computation: where a tick takes about as long, it \
             is limited by memory. Marks are the sizes at which all bytes just fit into a cache."
        );
        let blocks = vec![Block::Plot(curve(m)), Block::Text(words)];
        report.sections.push(Section::new("Cost against size", blocks));
    }
    report
}

/// Plots the time per module of a string against its size, beside the time of its bytes alone and the cache sizes.
fn curve(m: &Measured) -> Plot {
    let x: Vec<f64> = m.curve.iter().map(|(s, _)| s.modules as f64).collect();
    let each = |ns: f64, s: &Size| ns / s.modules.max(1) as f64;
    let tick = m.curve.iter().map(|(s, _)| each(s.ns, s)).collect();
    let bytes = m.curve.iter().map(|(s, bytes)| each(*bytes, s)).collect();
    let (least, most) = (x.first().copied().unwrap_or(1.0), x.last().copied().unwrap_or(1.0));
    let marks = timing::caches().into_iter().map(|(name, bytes)| (name, bytes as f64 / BYTES as f64));
    let marks = marks.filter(|(_, modules)| (least..=most).contains(modules));
    Plot {
        title: "A string".into(),
        x: Axis::log("modules", ""),
        y: Axis::linear("ns per module", ""),
        grid: Grid::Points(x),
        curves: vec![Curve::line("a tick, per module", tick), Curve::line("reading and writing its bytes", bytes)],
        marks: marks.map(|(text, x)| Mark { x, y: None, text }).collect(),
        image: None,
    }
}
