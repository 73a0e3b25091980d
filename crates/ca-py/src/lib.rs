//! The compiled half of `cordis_anima`: models, scenes and what plays them, for Python.
//!
//! Decides that this half hands over plain things (numbers, arrays, JSON of findings) and that classes with documents,
//! units and pictures are written in Python, where their users read them. Arrays are moved or shared, never copied; every
//! call that may be long lets other threads run, tells how far it is, and ends at Ctrl-C.
//!
//! What is not here: what people import. The classes are in `python/cordis_anima`, their guide is `README.md` of this crate.

// the macros of pyo3 write what this crate may not
#![deny(unsafe_code)]
// and what Python hands over comes by value
#![allow(clippy::needless_pass_by_value)]

mod command;
mod compiled;
mod error;
mod fit;
mod gesture;
mod gradient;
mod many;
mod measure;
mod model;
mod play;
mod render;
mod scene;
mod sim;
mod take;
mod wait;

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

    /// Loads the array interface of NumPy. The first array would load it later, where an interrupt (Ctrl-C) is a panic.
    #[pymodule_init]
    #[allow(clippy::unnecessary_wraps)] // the macro wants a result
    fn load_arrays(module: &Bound<'_, PyModule>) -> PyResult<()> {
        PyArray1::<f64>::zeros(module.py(), 0, false);
        Ok(())
    }
}
