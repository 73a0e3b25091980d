//! `--error`: computes a model by the cheapest proven method whose error is small enough, for `ca render` and `ca play`.

use crate::commands::accuracy::share;
use crate::load::Loaded;
use crate::outcome::Failure;
use crate::term;
use ca_accuracy::timing::Clock;
use ca_accuracy::{AccuracyOptions, Choice, choose};
use ca_edit::{Document, write_change};
use clap::Args;
use std::path::{Path, PathBuf};

/// Multiples of the rate that are tried, and the multiple of the reference.
const TIMES: [u32; 3] = [1, 2, 4];
const REFERENCE: u32 = 16;

/// Options of the error.
#[derive(Args, Clone, Default)]
pub struct ErrorTarget {
    /// Largest relative RMS error, e.g. 1e-3: measures the model first, like `ca accuracy`, then uses the fastest
    /// proven method and rate within it
    #[arg(long, value_name = "E", value_parser = share, help_heading = "Accuracy")]
    pub error: Option<f64>,
    /// Writes the model with the method chosen for `--error` to a new file; comments are kept
    #[arg(long, value_name = "FILE.ca.toml", requires = "error", help_heading = "Accuracy")]
    pub write: Option<PathBuf>,
}

impl ErrorTarget {
    /// Returns the changes of the model that meet the error, as names and values of `--set`; none without `--error`.
    pub fn changes(&self, loaded: &Loaded, rate: Option<f64>, quiet: bool) -> Result<Vec<(String, String)>, Failure> {
        let Some(error) = self.error else { return Ok(Vec::new()) };
        if let Some(path) = &self.write {
            super::new::is_model(path)?;
            if path.symlink_metadata().is_ok() {
                return Err(Failure::Failed(format!("--write: `{}` exists; choose another name", path.display())));
            }
        }
        let choice = measure(loaded, rate, error, quiet)?;
        if let Some(path) = &self.write {
            super::new::write(path, &written(loaded, &choice)?, false)?;
            term::note(&format!("written to `{}`", path.display()));
        }
        if !quiet {
            term::note(&choice.words());
        }
        Ok(choice.changes)
    }

    /// Returns the files that the options write, for comparison with other outputs.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &Path)> {
        self.write.iter().map(|p| ("--write", p.as_path()))
    }
}

fn measure(loaded: &Loaded, rate: Option<f64>, error: f64, quiet: bool) -> Result<Choice, Failure> {
    let probes = ca_accuracy::heard(&loaded.model);
    if probes.is_empty() {
        return Err(Failure::Failed(format!(
            "--error: `{}` has no output to compare; add one, or leave out `--error`",
            loaded.name
        )));
    }
    let mut bar = None;
    let progress = &mut |done, of| {
        if !quiet {
            bar.get_or_insert_with(|| term::progress(of)).set_position(done);
        }
        true
    };
    let remedy = "leave out `--error`";
    let mut ask = AccuracyOptions {
        rate,
        probes: &probes,
        seconds: None,
        times: Some(&TIMES),
        reference: Some(REFERENCE),
        remedy,
        clock: Clock::WALL,
        progress,
    };
    let choice = choose(loaded, error, &mut ask);
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    Ok(choice?)
}

/// Returns the text of the model with the changes of a choice.
fn written(loaded: &Loaded, choice: &Choice) -> Result<String, Failure> {
    let failed = |why: String| Failure::Failed(format!("--write: {why}"));
    let mut text = Document::read(&loaded.model.text).map_err(|e| failed(e.to_string()))?;
    for (name, value) in &choice.changes {
        write_change(&mut text, &loaded.model, name, value).map_err(failed)?;
    }
    Ok(text.to_string())
}
