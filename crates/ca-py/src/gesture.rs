//! Gestures: constants, breakpoints and samples by port or parameter name, or files.

use crate::error::{self, file, usage};
use crate::long_call::{CallProgress, run_detached};
use crate::measure::table;
use ca_io::gesture::{self, PortMap, Track};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods as _, ToPyArray as _};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A gesture: values over time for ports and parameters.
#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Gesture {
    pub(crate) gesture: gesture::Gesture,
}

/// One track from Python: a constant, samples at a rate, or breakpoints.
#[derive(FromPyObject)]
enum Curve<'py> {
    Value(f64),
    Samples(f64, PyReadonlyArray1<'py, f64>),
    Points(PyReadonlyArray2<'py, f64>),
}

#[pymethods]
impl Gesture {
    /// Creates a gesture from named tracks: a number, an array of times [s] and values (n x 2), or a rate [Hz] and an
    /// array (n). `midi` marks the tracks of a MIDI file.
    #[new]
    #[pyo3(signature = (tracks, midi = false))]
    fn new(py: Python, tracks: Vec<(String, Curve)>, midi: bool) -> PyResult<Gesture> {
        let narrow = |(name, curve): &(String, Curve)| match curve {
            Curve::Points(p) if p.shape()[1] != 2 => Some(name.clone()),
            _ => None,
        };
        if let Some(name) = tracks.iter().find_map(narrow) {
            return Err(usage(py, &format!("breakpoints of `{name}` must be rows (n, 2) of a time and a value")));
        }
        let track = |(name, curve): (String, Curve)| match curve {
            Curve::Value(v) => Track::points(name, vec![(0.0, v)]),
            Curve::Samples(rate, values) if values.is_empty() => Track::sampled(name, rate, Vec::new()),
            Curve::Samples(rate, values) => Track::sampled(name, rate, values.as_array().to_vec()),
            Curve::Points(points) if points.is_empty() => Track::points(name, Vec::new()),
            Curve::Points(points) => {
                let rows = points.as_array();
                Track::points(name, rows.rows().into_iter().map(|r| (r[0], r[1])).collect())
            }
        };
        let tracks: Result<Vec<Track>, _> = tracks.into_iter().map(track).collect();
        let gesture = tracks.and_then(gesture::Gesture::new).map_err(|e| error::gesture(py, &e))?;
        Ok(Gesture { gesture: gesture.as_midi(midi) })
    }

    /// Joins gestures into one.
    #[staticmethod]
    fn together(py: Python, all: Vec<PyRef<Gesture>>) -> PyResult<Gesture> {
        let all = all.iter().map(|g| g.gesture.clone());
        Ok(Gesture { gesture: gesture::Gesture::together(all).map_err(|e| error::gesture(py, &e))? })
    }

    /// Names of the ports and parameters it drives.
    #[getter]
    fn names(&self) -> Vec<&str> {
        self.gesture.tracks().iter().map(Track::name).collect()
    }

    /// Tracks, in the form that the constructor takes.
    fn tracks<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        let one = |t: &Track| {
            let values = match t.curve() {
                gesture::Curve::Samples(rate, v) => (*rate, v.to_pyarray(py)).into_pyobject(py)?.into_any(),
                gesture::Curve::Points(p) => {
                    let flat: Vec<f64> = p.iter().flat_map(|(t, v)| [*t, *v]).collect();
                    table(py, flat, p.len(), 2)?.into_any()
                }
            };
            Ok((t.name().to_owned(), values))
        };
        self.gesture.tracks().iter().map(one).collect()
    }

    /// Remarks on the file, as text.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.gesture.remarks().to_vec()
    }

    /// True if a MIDI file is part of it, which is played to its end.
    #[getter]
    fn midi(&self) -> bool {
        self.gesture.is_midi()
    }

    #[getter]
    fn duration(&self) -> f64 {
        self.gesture.duration()
    }
}

impl Gesture {
    /// Reads a file, with the MIDI mappings of `ports`. `port` names its only track. `rate` \[Hz\] applies to an array
    /// without times.
    pub fn open(
        py: Python,
        path: PathBuf,
        ports: Vec<PortMap>,
        port: Option<String>,
        rate: Option<f64>,
    ) -> PyResult<Gesture> {
        let named = path.clone();
        let read = move |_: &CallProgress| {
            if ca_lab::load::has_extension(&path, "mcap") {
                ca_haptic::take::gesture(&path, &ca_lab::catalog())
            } else {
                gesture::Gesture::open(&path, &ports, rate)
            }
        };
        let gesture = run_detached(py, None, read)?.map_err(|e| file(py, &e))?;
        let Some(port) = port else { return Ok(Gesture { gesture }) };
        let what = format!("`{}` has {} tracks", named.display(), gesture.tracks().len());
        let one = gesture.named(&port);
        let gesture = one
            .ok_or_else(|| usage(py, &format!("{what}, but `{port}` needs one; pass the file as the whole gesture")))?;
        Ok(Gesture { gesture })
    }
}
