//! What fails, as an exception of the package.

use ca_io::FileError;
use ca_lab::Failure;
use ca_model::Model;
use ca_model::diag::Diags;
use ca_model::render;
use pyo3::prelude::*;

/// An exception of `cordis_anima._errors` with these arguments.
fn raised<'py>(py: Python<'py>, name: &str, args: impl pyo3::call::PyCallArgs<'py>) -> PyErr {
    let made = || py.import("cordis_anima._errors")?.getattr(name)?.call1(args);
    match made() {
        Ok(value) => PyErr::from_value(value),
        Err(e) => e,
    }
}

/// A request that makes no sense.
pub fn usage(py: Python, what: &str) -> PyErr {
    raised(py, "UsageError", (what,))
}

/// Findings of a model: their JSON and how they read.
pub fn findings(diags: &Diags, model: &Model) -> (String, String) {
    (render::json(diags, model).to_string(), render::text(diags, model, false))
}

/// The exception for a failure.
pub fn failure(py: Python, failure: Failure) -> PyErr {
    match failure {
        Failure::Usage(what) => usage(py, &what),
        Failure::Failed(what) => raised(py, "FailedError", (what,)),
        Failure::Found(found) => raised(py, "ModelError", findings(&found.diags, &found.model)),
        // who stopped it has said why, which is looked at first
        Failure::Stopped => raised(py, "FailedError", ("stopped",)),
    }
}

/// The exception for a gesture that cannot be used: that of its file, or of a mistake where it came from memory.
pub fn gesture(py: Python, e: &FileError) -> PyErr {
    if e.file.is_empty() { usage(py, &e.to_string()) } else { file(py, e) }
}

/// The exception for a file that cannot be used.
pub fn file(py: Python, e: &FileError) -> PyErr {
    raised(py, "FileError", (e.to_string(), &e.file, &e.place))
}
