//! The page of a model and of a take, as `ca report` writes them.
//!
//! Decides what is on the page and in which order: first what is wrong, then what is heard, then what explains it, then
//! the model. Everything that a page can be made of is made into one, also silence, a divergence or a take that was cut
//! off; the notes of the page say what is not as it should be. How the page looks is decided in `ca-report`.
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

/// Whether something on a page is not as meant.
pub fn is_degraded(report: &Report) -> bool {
    report.notes.iter().any(|n| n.0 == Weight::Warning)
}
