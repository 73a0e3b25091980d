//! Converts failures to exceptions of the package.

use ca_io::FileError;
use ca_lab::Failure;
use ca_model::Model;
use ca_model::diag::Diags;
use ca_model::render;
use pyo3::prelude::*;

/// Creates an exception of `cordis_anima._errors` with these arguments.
fn raised<'py>(py: Python<'py>, name: &str, args: impl pyo3::call::PyCallArgs<'py>) -> PyErr {
    let made = || py.import("cordis_anima._errors")?.getattr(name)?.call1(args);
    match made() {
        Ok(value) => PyErr::from_value(value),
        Err(e) => e,
    }
}

/// The exception for an invalid request.
pub fn usage(py: Python, what: &str) -> PyErr {
    raised(py, "UsageError", (what,))
}

/// Findings of a model as JSON and as text.
pub fn findings(diags: &Diags, model: &Model) -> (String, String) {
    (render::json(diags, model).to_string(), render::text(diags, model, false))
}

pub fn failure(py: Python, failure: Failure) -> PyErr {
    match failure {
        Failure::Usage(what) => usage(py, &what),
        Failure::Failed(what) => raised(py, "FailedError", (what,)),
        Failure::Found(found) => raised(py, "ModelError", findings(&found.diags, &found.model)),
        // the signal or callback that stopped it is raised first
        Failure::Stopped => raised(py, "FailedError", ("stopped",)),
    }
}

/// The exception for an unusable gesture: a file error, or a usage error if it came from memory.
pub fn gesture(py: Python, e: &FileError) -> PyErr {
    if e.file.is_empty() { usage(py, &e.to_string()) } else { file(py, e) }
}

pub fn file(py: Python, e: &FileError) -> PyErr {
    raised(py, "FileError", (e.to_string(), &e.file, &e.place))
}
