//! Compiled half of `cordis_anima`: models, scenes and everything that plays them, for Python.
//!
//! It returns plain data (numbers, arrays, findings as JSON). Classes with documentation, units and plots are written
//! in Python, in `python/cordis_anima`, where users read them; their guide is the `README.md` of this crate. Arrays are
//! moved or shared, never copied. Calls that may take long let other threads run, report progress, and end at Ctrl-C.

// the macros of pyo3 expand to unsafe code, which this crate itself may not use
#![deny(unsafe_code)]
// values from Python arrive by value
#![allow(clippy::needless_pass_by_value)]

mod command;
mod compiled;
mod error;
mod fit;
mod gesture;
mod gradient;
mod long_call;
mod many;
mod measure;
mod model;
mod play;
mod render;
mod scene;
mod sim;
mod take;

/// See the package `cordis_anima`.
#[pyo3::pymodule(gil_used = false)]
mod _core {
    use numpy::PyArray1;
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::command::command;
    #[pymodule_export]
    use crate::gesture::Gesture;
    #[pymodule_export]
    use crate::gradient::{Checkpoints, Energy, Forward, Reverse};
    #[pymodule_export]
    use crate::many::batch::play;
    #[pymodule_export]
    use crate::many::sweep::Sweep;
    #[pymodule_export]
    use crate::measure::quantity;
    #[pymodule_export]
    use crate::model::{Model, bundled, kinds, parts};
    #[pymodule_export]
    use crate::play::Performance;
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::sim::Sim;
    #[pymodule_export]
    use crate::take::Take;

    /// Version of the engine.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");

    /// Loads the array interface of NumPy now. The first array would load it later, where an interrupt (Ctrl-C) panics.
    #[pymodule_init]
    #[allow(clippy::unnecessary_wraps)] // the macro requires a result
    fn load_arrays(module: &Bound<'_, PyModule>) -> PyResult<()> {
        PyArray1::<f64>::zeros(module.py(), 0, false);
        Ok(())
    }
}
