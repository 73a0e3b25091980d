//! Measures the level of each output when the model plays by itself, and the gain that would bring it to a good level.

use super::super::render::play;
use crate::outcome::Failure;
use crate::term;
use ca_core::Scene;
use ca_io::perform::Performance;
use ca_lab::facts::level::{SILENT, decibel, level};
use ca_model::quantity::short;
use serde_json::{Value as Json, json};
use std::io::Write;

/// Target peak with headroom: −6 dBFS.
const WANTED: f64 = 0.5;

pub(super) struct LevelRow {
    name: String,
    peak: f64,
}

/// Plays the model as `ca render` does, and measures the peaks.
pub(super) fn levels(scene: &Scene, show: bool) -> Result<Vec<LevelRow>, Failure> {
    let performance = Performance::new(scene, None)?;
    let seconds = ca_lab::play::seconds(&performance, None);
    let frames = ca_lab::play::frames(scene, seconds);
    let n = scene.counts.channels.max(1);
    let mut peaks = vec![0.0_f64; scene.counts.channels];
    let played = play(performance, frames.into(), 1024, show, &mut |_, rows| {
        for frame in rows.chunks_exact(n) {
            for (peak, x) in peaks.iter_mut().zip(frame) {
                *peak = peak.max(x.abs());
            }
        }
        Ok(())
    })?;
    if played.diverged_at.is_some() {
        term::warning("the model diverges, so its levels are meaningless");
    }
    Ok(scene.names.channel_names.iter().zip(peaks).map(|(name, peak)| LevelRow { name: name.clone(), peak }).collect())
}

impl LevelRow {
    /// Factor for the gain of the output that brings the peak to [`WANTED`]. `None` for a silent channel.
    fn factor(&self) -> Option<f64> {
        (self.peak > SILENT).then(|| WANTED / self.peak)
    }
}

pub(super) fn text(rows: &[LevelRow]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    for (i, row) in rows.iter().enumerate() {
        let head = if i == 0 { "levels" } else { "" };
        let what = match row.factor() {
            Some(f) => format!("{}; multiply its gain by {} to get -6 dBFS", level(row.peak, false), short(f)),
            None => "silent".into(),
        };
        writeln!(out, "  {head:<10} `{}`: {what}", row.name)?;
    }
    Ok(())
}

pub(super) fn json(rows: &[LevelRow]) -> Json {
    let one = |row: &LevelRow| {
        let dbfs = (row.peak > 0.0).then(|| decibel(row.peak));
        json!({"name": row.name, "peak": row.peak, "peak_dbfs": dbfs, "gain_factor": row.factor()})
    };
    rows.iter().map(one).collect()
}
