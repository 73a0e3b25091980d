//! Measurements of a model: modes, linear part, accuracy, energy, quantities.

use crate::error::{failure, usage};
use crate::long_call::run_detached;
use ca_accuracy::AccuracyOptions;
use ca_accuracy::timing::Clock;
use ca_compile::Options;
use ca_compile::analysis::{Dof, LinkRow, modes};
use ca_core::{Ledger, Location, Type};
use ca_lab::{Failure, Found, Loaded, catalog};
use ca_model::quantity::{Quantity, QuantityError, parse};
use numpy::{IntoPyArray as _, PyArray1, PyArray2, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::borrow::Cow;
use std::collections::HashMap;

/// Unit of a parameter, empty without one.
pub fn symbol(ty: Type) -> String {
    match ty {
        Type::Number { unit, .. } | Type::Numbers { unit, .. } => unit.symbol.to_owned(),
        Type::PowerStiffness { exponent } => format!("N/m^{exponent}"),
        _ => String::new(),
    }
}

/// Parses a quantity to SI units: `text` is a number in `unit`, or has its own unit of the same dimension.
#[pyfunction]
pub fn quantity(py: Python, name: &str, text: &str, unit: &str) -> PyResult<f64> {
    let such = parse(format!("1.5 {unit}").trim());
    let fits = |q: &Quantity| !q.has_unit || such.as_ref().is_ok_and(|s| s.dim.same(q.dim));
    let or = if unit.is_empty() { String::new() } else { format!(", or \"1.5 {unit}\"") };
    let refused = |why: String| usage(py, &format!("{name} = \"{text}\": {why}; write a number{or}"));
    let read = parse(text).map_err(|e: QuantityError| refused(e.to_string()))?;
    if fits(&read) {
        Ok(read.value)
    } else {
        Err(refused(if unit.is_empty() { "it must not have a unit".into() } else { format!("it is not in {unit}") }))
    }
}

/// All modes of the linear part, as arrays over modes.
pub fn modes(py: Python<'_>, loaded: Loaded, rate: Option<f64>) -> PyResult<Bound<'_, PyDict>> {
    let found = run_detached(py, None, move |_| {
        let options = Options { rate, clouds: loaded.clouds.clone(), ..Options::default() };
        let network = ca_compile::linear(&loaded.model, &catalog(), &options)
            .map_err(|diags| Failure::Found(Box::new(Found { model: loaded.model.clone(), diags })))?;
        let n = network.linear.dofs.len();
        if n == 0 {
            return Err(Failure::Failed("nothing in the linear part of this model moves, so it lacks modes".into()));
        }
        let all = modes::modes(&network).ok_or_else(|| {
            let most = modes::LARGEST;
            Failure::Failed(format!("{n} moving places are too many for a table of modes; the limit is {most}"))
        })?;
        Ok((network, all))
    })?;
    let (network, all) = found.map_err(|e| failure(py, e))?;
    let column = |f: &dyn Fn(&modes::Mode) -> f64| all.list.iter().map(f).collect::<Vec<f64>>().into_pyarray(py);
    let d = PyDict::new(py);
    d.set_item("f", column(&|m| m.f))?;
    d.set_item("heard", column(&|m| m.heard))?;
    d.set_item("cents", column(&modes::Mode::cents))?;
    d.set_item("t60", column(&|m| m.t60))?;
    d.set_item("grows", all.list.iter().map(|m| m.grows).collect::<Vec<bool>>().into_pyarray(py))?;
    let (modes, places) = (all.list.len(), network.names.len());
    let shapes: Vec<f64> = all.list.iter().flat_map(|m| m.shape.iter().copied()).collect();
    d.set_item("shapes", shapes.into_pyarray(py).reshape([modes, places])?)?;
    let ports: Vec<f64> = all.list.iter().flat_map(|m| network.ports.iter().map(|p| m.at(&p.at))).collect();
    d.set_item("levels", ports.into_pyarray(py).reshape([modes, network.ports.len()])?)?;
    d.set_item("ports", network.ports.iter().map(|p| p.name.as_str()).collect::<Vec<_>>())?;
    d.set_item("places", network.names)?;
    d.set_item("left_out", network.left_out.iter().map(|l| l.0.as_str()).collect::<Vec<_>>())?;
    d.set_item("approximate", all.approximate)?;
    Ok(d)
}

/// The linear part as used by a tick: coefficients, rows of links, ports.
pub fn linear(py: Python<'_>, loaded: Loaded, rate: Option<f64>) -> PyResult<Bound<'_, PyDict>> {
    let found = run_detached(py, None, move |_| {
        let options = Options { rate, clouds: loaded.clouds.clone(), ..Options::default() };
        let network = ca_compile::linear_tick(&loaded.model, &catalog(), &options)
            .map_err(|diags| Failure::Found(Box::new(Found { model: loaded.model.clone(), diags })))?;
        Ok((network, loaded.compile(&options)?.scene))
    })?;
    let (network, scene) = found.map_err(|e| failure(py, e))?;
    // the motion into the first tick is taken from the scene, which starts with the forces at load
    let places: HashMap<String, usize> = scene
        .symbols
        .iter()
        .filter_map(|s| if let Location::Mat(at) = s.location { Some((s.name.to_string(), at as usize)) } else { None })
        .collect();
    let motion = |(name, dof): (&String, &Dof)| {
        let at = places.get(name).or_else(|| places.get(name.rsplit_once('.')?.0))?;
        scene.initial.d.get(at + dof.axis as usize).copied()
    };
    let d0: Vec<f64> = network.names.iter().zip(&network.linear.dofs).map(|m| motion(m).unwrap_or(0.0)).collect();
    let linear = &network.linear;
    let d = PyDict::new(py);
    d.set_item("tick", network.tick_dt)?;
    let dofs = |f: &dyn Fn(&Dof) -> f64| linear.dofs.iter().map(f).collect::<Vec<f64>>().into_pyarray(py);
    d.set_item("mobility", dofs(&|p| p.c))?;
    d.set_item("constant", network.constant.clone().into_pyarray(py))?;
    d.set_item("own_k", dofs(&|p| p.k))?;
    d.set_item("own_z", dofs(&|p| p.z))?;
    d.set_item("own_implicit", dofs(&|p| p.implicit))?;
    let links = |f: &dyn Fn(&LinkRow) -> f64| linear.rows.iter().map(f).collect::<Vec<f64>>().into_pyarray(py);
    d.set_item("link_k", links(&|r| r.k))?;
    d.set_item("link_z", links(&|r| r.z))?;
    d.set_item("link_implicit", links(&|r| r.implicit))?;
    d.set_item("links", network.link_names.clone())?;
    d.set_item("elongation", rows(py, linear.rows.iter().map(|r| linear.entries(r)))?)?;
    for (name, role) in [("hears", "hears"), ("pushes", "pushes"), ("acts", "acts")] {
        let of = || network.ports.iter().filter(|p| p.role == role);
        let names: Vec<&str> = of().map(|p| p.name.as_str()).collect();
        d.set_item(name, (names, rows(py, of().map(|p| &p.at[..]))?))?;
    }
    d.set_item("places", network.names.clone())?;
    d.set_item("driven", network.driven.clone())?;
    d.set_item("x", network.x.clone().into_pyarray(py))?;
    d.set_item("d", d0.into_pyarray(py))?;
    d.set_item("v", network.v.clone().into_pyarray(py))?;
    d.set_item("left_out", network.left_out.iter().map(|l| l.0.as_str()).collect::<Vec<_>>())?;
    d.set_item("other_scheme", network.other_scheme)?;
    Ok(d)
}

/// Rows of weights as three arrays: weights, places, first entry of each row.
fn rows<'py, 'e>(py: Python<'py>, rows: impl Iterator<Item = &'e [(u32, f64)]>) -> PyResult<Bound<'py, PyTuple>> {
    let (mut weights, mut places, mut first) = (Vec::new(), Vec::new(), vec![0_i64]);
    for row in rows {
        weights.extend(row.iter().map(|e| e.1));
        places.extend(row.iter().map(|e| i64::from(e.0)));
        first.push(places.len() as i64);
    }
    (weights.into_pyarray(py), places.into_pyarray(py), first.into_pyarray(py)).into_pyobject(py)
}

/// Arguments of a measurement of accuracy.
pub struct AccuracyArgs {
    /// Sound rate \[Hz\].
    pub rate: Option<f64>,
    /// Length \[s\].
    pub seconds: Option<f64>,
    /// Modules to compare; the outputs if empty.
    pub probes: Vec<String>,
    /// Multiples of the rate.
    pub times: Vec<u32>,
    /// Multiple of the rate for the reference.
    pub reference: u32,
}

/// Error and run time, as arrays over methods.
pub fn accuracy<'py>(
    py: Python<'py>,
    loaded: Loaded,
    asked: AccuracyArgs,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let probes = if asked.probes.is_empty() { ca_accuracy::heard(&loaded.model) } else { asked.probes };
    if probes.is_empty() {
        return Err(usage(py, "the model has no output to compare; name modules to compare with `probes`"));
    }
    let found = run_detached(py, progress, move |wanted| {
        let mut ask = AccuracyOptions {
            rate: asked.rate,
            probes: &probes,
            seconds: asked.seconds,
            times: Some(&asked.times),
            reference: Some(asked.reference),
            remedy: "play longer with `seconds`, or compare other modules with `probes`",
            clock: Clock::WALL,
            progress: &mut |done, of| wanted.goes_on(done, of),
        };
        ca_accuracy::measured(&loaded, &mut ask)
    });
    let found = found?.map_err(|e| failure(py, e))?;
    let rows = &found.rows;
    let column = |f: &dyn Fn(&ca_accuracy::MethodRow) -> f64| -> Bound<'py, PyArray1<f64>> {
        rows.iter().map(f).collect::<Vec<f64>>().into_pyarray(py)
    };
    let d = PyDict::new(py);
    d.set_item("method", rows.iter().map(|r| r.method).collect::<Vec<_>>())?;
    d.set_item("times", rows.iter().map(|r| r.times).collect::<Vec<_>>().into_pyarray(py))?;
    d.set_item("error", column(&|r| r.score.error))?;
    d.set_item("spectrum", column(&|r| r.score.spectrum))?;
    d.set_item("cents", column(&|r| r.score.cents.unwrap_or(f64::NAN)))?;
    d.set_item("decay", column(&|r| r.score.decay))?;
    d.set_item("made", column(&|r| r.energy_error().unwrap_or(f64::NAN)))?;
    d.set_item("ns", column(&|r| r.ns))?;
    d.set_item("stability", rows.iter().map(|r| r.level.to_string()).collect::<Vec<_>>())?;
    d.set_item("front", rows.iter().map(|r| r.front).collect::<Vec<_>>().into_pyarray(py))?;
    d.set_item("rate", found.rate)?;
    d.set_item("seconds", found.seconds())?;
    d.set_item("known", found.reference.known)?;
    d.set_item("against", found.origin())?;
    d.set_item("refused", found.refused.clone())?;
    Ok(d)
}

/// Rows of `width` numbers as an array, without a copy.
pub fn table<T: numpy::Element>(
    py: Python<'_>,
    flat: Vec<T>,
    rows: usize,
    width: usize,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    flat.into_pyarray(py).reshape([rows, width])
}

/// The energy ledger: its sums, and losses, errors and inputs by module.
pub fn energy<'py>(
    py: Python<'py>,
    scene: &ca_core::Scene,
    ledger: &Ledger,
    ticks: u64,
) -> PyResult<Bound<'py, PyDict>> {
    let b = ledger.balance();
    let d = PyDict::new(py);
    for (name, value) in [
        ("start", b.h0),
        ("stored", b.h),
        ("kinetic", ledger.kinetic),
        ("lost", b.lost),
        ("made", b.scheme_error),
        ("work", b.work),
        ("changed", b.changed),
        ("residual", b.residual),
        ("peak", b.peak),
        ("off_potential", b.strayed),
        ("seconds", ticks as f64 * scene.rates.sample_dt),
    ] {
        d.set_item(name, value)?;
    }
    let by_link = |all: &[f64]| -> Vec<(String, f64)> {
        let name = |l: usize| scene.audited_name(l).map_or_else(|| "?".into(), Cow::into_owned);
        all.iter().enumerate().filter(|(_, v)| **v != 0.0).map(|(l, v)| (name(l), *v)).collect()
    };
    d.set_item("lost_by", by_link(&ledger.lost))?;
    d.set_item("made_by", by_link(&ledger.scheme_error))?;
    let ports =
        scene.ports.enx.iter().chain(&scene.ports.tgr).map(|p| p.input).chain(scene.ports.enf.iter().map(|p| p.input));
    let work: Vec<(String, f64)> =
        ports.zip(&ledger.work).map(|(i, w)| (scene.inputs[i as usize].name.clone(), *w)).collect();
    d.set_item("work_by", work)?;
    Ok(d)
}
