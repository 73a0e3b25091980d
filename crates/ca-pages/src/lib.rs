//! Builds the page of a model or of a take for `ca report`.
//!
//! A page begins with warnings and notes. The sound follows, then its explanation, then the model. Silence, a
//! divergence or a truncated take still produces a page. `ca-report` decides the layout.
//!
//! Begin with [`ModelPage::new`], which compiles a model, or with [`take()`], which reads a take.
//!
//! ```
//! use ca_io::perform::Performance;
//! use ca_pages::{ModelPage, PageOptions};
//!
//! let text = "[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '2 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar', gain = 500 }\n";
//! let loaded = ca_lab::Loaded::read(text, "bar.ca.toml");
//! let page = ModelPage::new(&loaded, None, &[])?;
//! let options = PageOptions { seconds: Some(0.1), accuracy: 0.0, ..PageOptions::default() };
//! let report = page.report(Performance::new(page.scene(), None)?, None, &options, &mut |_| true)?;
//! assert!(report.notes.is_empty() && report.html().contains("Summary"));
//! # Ok::<(), ca_lab::Failure>(())
//! ```
#![forbid(unsafe_code)]

mod energy;
mod loops;
mod model;
mod parts;
mod take;

pub use model::{ModelPage, PageOptions, TRIED, Work};
pub use take::take;

use ca_report::{Report, Weight};

/// Returns true if a page has a warning.
pub fn is_degraded(report: &Report) -> bool {
    report.notes.iter().any(|n| n.0 == Weight::Warning)
}
