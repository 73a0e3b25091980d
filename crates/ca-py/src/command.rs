//! The command `ca`, for `python -m cordis_anima` and the script of the wheel.

use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the command with `args`, program name first, and returns its exit code.
#[pyfunction]
pub fn command(py: Python, args: Vec<OsString>) -> u8 {
    py.detach(|| ca_cli::run(args))
}
