//! Models: from text or calls, ready to compile.

use crate::error::{failure, findings, usage};
use crate::fit::{self, FitArgs, Target};
use crate::gesture::Gesture;
use crate::long_call::run_detached;
use crate::measure;
use crate::scene::Scene;
use ca_compile::Options;
use ca_core::Role;
use ca_lab::bytes;
use ca_lab::load::{self, BUNDLED, Loaded};
use ca_model::diag::Severity;
use ca_model::part::library::LIBRARY;
use ca_model::part::{self, Part, Use};
use ca_model::select::{is_name, is_word};
use ca_model::suggest::nearest;
use ca_model::{Entry, Span, Value, read, write};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::HashSet;
use std::path::PathBuf;

/// A model as written by its author.
#[pyclass(module = "cordis_anima._core")]
pub struct Model {
    loaded: Loaded,
    /// Names of its modules and groups; empty until something is added.
    names: HashSet<String>,
}

#[derive(FromPyObject)]
pub enum Given {
    Bool(bool),
    Num(f64),
    Text(String),
    List(Vec<Given>),
    Table(Table),
}

/// A mapping in its order.
pub struct Table(Vec<(String, Given)>);

impl<'a, 'py> FromPyObject<'a, 'py> for Table {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Table> {
        let all = given.cast::<PyDict>()?.iter().map(|(k, v)| Ok((k.extract()?, v.extract()?)));
        Ok(Table(all.collect::<PyResult<_>>()?))
    }
}

impl Given {
    /// Converts it like typed input, in which text may be a number.
    pub fn typed(self) -> Value {
        if let Given::Text(text) = self { Value::typed(&text) } else { self.value() }
    }

    fn value(self) -> Value {
        match self {
            Given::Bool(v) => Value::Bool(v),
            Given::Num(v) => Value::Num(v),
            Given::Text(v) => Value::Text(v),
            Given::List(all) => Value::List(all.into_iter().map(|v| Entry::new("", v.value())).collect()),
            Given::Table(Table(all)) => Value::Table(entries(all)),
        }
    }
}

fn entries(args: Vec<(String, Given)>) -> Vec<Entry> {
    args.into_iter().map(|(key, value)| Entry::new(&key, value.value())).collect()
}

/// The exception for an invalid name.
fn no_name(py: Python, name: &str) -> PyErr {
    let of = "letters from a to z or A to Z, digits and `_`, and do not begin with a digit";
    usage(py, &format!("`{}` is not a valid name: use {of}; a dot separates a group from a name", name.escape_debug()))
}

/// The exception for a name in use.
fn taken(py: Python, name: &str, by: &str) -> PyErr {
    usage(py, &format!("`{name}` is already {by}; names must be unique in a model, so rename one of the two"))
}

#[pyfunction]
pub fn bundled() -> Vec<&'static str> {
    BUNDLED.iter().map(|m| m.0).collect()
}

/// Shipped parts: name and one line about each.
#[pyfunction]
pub fn parts() -> Vec<(&'static str, String)> {
    let doc = |name: &str| part::library::shipped(name, &ca_lab::catalog()).map(|p| p.0.doc);
    LIBRARY.iter().map(|p| (p.0, doc(p.0).unwrap_or_default())).collect()
}

/// All kinds: code, title, equation, family, and parameters as name, unit, documentation.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn kinds()
-> Vec<(&'static str, &'static str, &'static str, &'static str, Vec<(&'static str, String, &'static str)>)> {
    let family = |r: &Role| match r {
        Role::Mat(_) => "MAT",
        Role::Lia(_) => "LIA",
        Role::Port(_) => "port",
        Role::Generator(_) => "generator",
    };
    let one = |k: &'static ca_core::Kind| {
        let params = k.params.iter().map(|p| (p.name, measure::symbol(p.ty), p.doc)).collect();
        (k.code, k.title, k.equation, family(&k.role), params)
    };
    ca_lab::catalog().iter().map(one).collect()
}

impl Model {
    pub fn of(loaded: Loaded) -> Model {
        Model { loaded, names: HashSet::new() }
    }

    /// Reserves a name for a module or a group; it must be valid in selectors and unique.
    fn take(&mut self, py: Python, name: &str) -> PyResult<()> {
        let model = &self.loaded.model;
        if self.names.is_empty() {
            self.names
                .extend(model.items.iter().map(|i| i.name.clone()).chain(model.groups.iter().map(|g| g.name.clone())));
        }
        if !is_name(name) {
            return Err(no_name(py, name));
        }
        if model.params.iter().any(|p| p.key == name) {
            return Err(taken(py, name, "a parameter"));
        }
        if !self.names.insert(name.to_owned()) {
            let first = model.items.iter().find(|i| i.name == name);
            let what = first.map_or_else(|| "a group".into(), |i| format!("a `{}` module", i.kind));
            return Err(taken(py, name, &what));
        }
        Ok(())
    }

    /// The model to compile: modules in their groups, and contents of the named files.
    pub fn whole(&self) -> Loaded {
        let mut loaded = self.loaded.clone();
        let model = &mut loaded.model;
        for item in model.items.iter_mut().filter(|i| i.group.is_none()) {
            let group = item.name.rsplit_once('.').map(|(group, _)| group);
            item.group = group.and_then(|group| model.groups.iter().position(|g| g.name == group));
        }
        loaded.diags.extend(ca_model::part::lists(model, &ca_lab::catalog()));
        loaded.look();
        loaded
    }

    /// The part `name` of it, or the whole model as a part.
    fn part(&self, py: Python, name: &str) -> PyResult<Part> {
        let parts = &self.loaded.model.parts;
        parts.iter().find(|p| p.name == name).cloned().ok_or_else(|| {
            let names = || parts.iter().map(|p| p.name.as_str()).chain(LIBRARY.iter().map(|p| p.0));
            let hint = match nearest(name, names()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("use {}, or pass a model instead", load::ticked(names())),
            };
            usage(py, &format!("the model has no part `{name}`; {hint}"))
        })
    }
}

#[pymethods]
impl Model {
    #[new]
    fn new() -> Model {
        Model::of(Loaded::built(ca_model::Model::default()))
    }

    /// Opens a file or a bundled model.
    #[staticmethod]
    fn open(py: Python, word: String) -> PyResult<Model> {
        let loaded = run_detached(py, None, move |_| load::load(&word))?;
        Ok(Model::of(loaded.map_err(|e| failure(py, e))?))
    }

    /// Reads text.
    #[staticmethod]
    fn read(py: Python, text: String, file: String) -> PyResult<Model> {
        run_detached(py, None, move |_| Loaded::read(&text, &file)).map(Model::of)
    }

    /// Imports the text of a MIMS model.
    #[staticmethod]
    fn mims(py: Python, text: String, file: String) -> PyResult<Model> {
        run_detached(py, None, move |_| Loaded::import(&text, &file)).map(Model::of)
    }

    /// Reads bytes made by `bytes`, under the name `name`.
    #[staticmethod]
    fn from_bytes(py: Python, bytes: Vec<u8>, name: String) -> PyResult<Model> {
        let made = run_detached(py, None, move |_| bytes::from_bytes(&bytes, &name))?;
        Ok(Model::of(made.map_err(|e| failure(py, e))?))
    }

    /// The meaning of the model, as bytes.
    fn bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let whole = self.whole();
        let made = run_detached(py, None, move |_| bytes::bytes(&whole))?.map_err(|e| failure(py, e))?;
        Ok(PyBytes::new(py, &made))
    }

    fn copy(&self) -> Model {
        Model::of(self.loaded.clone())
    }

    /// The text of a model file.
    fn toml(&self) -> String {
        write::write(&self.loaded.model)
    }

    #[getter]
    fn file(&self) -> &str {
        &self.loaded.model.file
    }

    /// Name of its file without folder and extension.
    #[getter]
    fn name(&self) -> &str {
        &self.loaded.name
    }

    #[getter]
    fn title(&self) -> &str {
        self.loaded.model.title()
    }

    /// Kinds and names of its modules.
    #[getter]
    fn items(&self) -> Vec<(&str, &str)> {
        self.loaded.model.items.iter().map(|i| (i.kind.as_str(), i.name.as_str())).collect()
    }

    /// Adds a module; `a.b` is in the group `a`, which may be added later. Refuses unknown kinds and parameters, and
    /// names that are invalid or in use.
    fn add(&mut self, py: Python, kind: &str, name: &str, args: Vec<(String, Given)>) -> PyResult<()> {
        let meant = |meant: Option<&str>, all: String| meant.map_or(all, |m| format!("did you mean `{m}`?"));
        let catalog = ca_lab::catalog();
        let Some(known) = catalog.get(kind) else {
            let hint = meant(nearest(kind, catalog.iter().map(|k| k.code)), "`kinds()` lists all kinds".into());
            return Err(usage(py, &format!("`{name}`: unknown kind `{kind}`; {hint}")));
        };
        let params = || known.params.iter().map(|p| p.name);
        if let Some((key, _)) = args.iter().find(|(key, _)| known.param(key).is_none()) {
            let hint = meant(nearest(key, params()), format!("it has {}", params().collect::<Vec<_>>().join(", ")));
            return Err(usage(py, &format!("`{name}`: `{kind}` has no parameter `{key}`; {hint}")));
        }
        self.take(py, name)?;
        self.loaded.model.add(kind, name, entries(args));
        Ok(())
    }

    fn group(&mut self, py: Python, name: &str, props: Vec<(String, Given)>) -> PyResult<()> {
        if self.loaded.model.groups.iter().any(|g| g.name == name) {
            return Err(usage(
                py,
                &format!("the group `{name}` exists already; give all of its properties in one call"),
            ));
        }
        self.take(py, name)?;
        let group = ca_model::Group { name: name.into(), span: ca_model::Span::NONE, props: entries(props) };
        self.loaded.model.groups.push(group);
        Ok(())
    }

    /// Adds instances of a part: one of this model, a shipped one by name, or another model as a whole.
    #[pyo3(signature = (name, part, of, n, given))]
    fn use_part(
        &mut self,
        py: Python,
        name: &str,
        part: &str,
        of: Option<PyRef<'_, Model>>,
        n: Option<f64>,
        given: Vec<(String, Given)>,
    ) -> PyResult<()> {
        let shipped = of.is_none() && !self.loaded.model.parts.iter().any(|p| p.name == part);
        let shipped = LIBRARY.iter().map(|p| p.0).find(|p| shipped && *p == part);
        let part = match of {
            None if shipped.is_some() => None,
            None => Some(self.part(py, part)?),
            Some(of) if !part.is_empty() => Some(of.part(py, part)?),
            Some(of) => {
                let whole = of.whole();
                let name = if whole.name.is_empty() { name.into() } else { whole.name };
                Some(Part { name, span: Span::NONE, doc: String::new(), props: Vec::new(), body: whole.model })
            }
        };
        self.take(py, name)?;
        let mut u = Use::new(name);
        (u.n, u.with) = (n.map(|n| Entry::new("n", n)), entries(given));
        let mut next = self.loaded.model.clone();
        let found = match (&part, shipped) {
            (None, Some(name)) => part::add_shipped(&mut next, name, &u, &ca_lab::catalog()),
            (Some(part), _) => part::add(&mut next, part, &u, &ca_lab::catalog()),
            (None, None) => return Err(usage(py, "no part given; pass the name of a part, or a model")),
        };
        if let Some(first) = found.list.iter().find(|d| d.severity == Severity::Error) {
            self.names.remove(name);
            let help = first.help.as_ref().map(|h| format!("; {h}")).unwrap_or_default();
            return Err(usage(py, &format!("{}{help}", first.title)));
        }
        self.loaded.model = next;
        self.names.clear();
        Ok(())
    }

    /// Writes an entry of `model`, `rate`, `param`, `gesture`, `preset` or `equivalence`.
    fn put(&mut self, py: Python, section: &str, key: &str, value: Given) -> PyResult<()> {
        let known = [("model", read::META), ("rate", read::RATES)].into_iter().find(|s| s.0 == section).map(|s| s.1);
        if let Some(keys) = known.filter(|keys| !keys.contains(&key)) {
            let meant = nearest(key, keys.iter().copied());
            let hint = meant.map_or_else(|| format!("it has {}", keys.join(", ")), |m| format!("did you mean `{m}`?"));
            return Err(usage(py, &format!("`[{section}]` has no `{key}`; {hint}")));
        }
        if (matches!(section, "param" | "preset") && !is_word(key)) || (section == "gesture" && !is_name(key)) {
            return Err(no_name(py, key));
        }
        let model = &mut self.loaded.model;
        if let Some(module) = model.items.iter().find(|i| section == "param" && i.name == key) {
            return Err(taken(py, key, &format!("a `{}` module", module.kind)));
        }
        let list = match section {
            "model" => &mut model.meta,
            "rate" => &mut model.rate,
            "param" => &mut model.params,
            "gesture" => &mut model.gestures,
            "preset" => &mut model.presets,
            "equivalence" => &mut model.equivalence,
            _ => {
                return Err(usage(
                    py,
                    &format!(
                        "`{section}` is not a section; use `model`, `rate`, `param`, `gesture`, `preset` or `equivalence`"
                    ),
                ));
            }
        };
        list.retain(|e| e.key != key);
        list.push(Entry::new(key, value.value()));
        Ok(())
    }

    /// Sets an existing parameter; text is parsed as by `--set`.
    fn set(&mut self, py: Python, name: &str, value: Given) -> PyResult<()> {
        load::set(&mut self.loaded, name, value.typed()).map_err(|e| failure(py, e))
    }

    /// Compiles without playing. Returns success, all findings as JSON, and their text.
    #[pyo3(signature = (rate=None))]
    fn check(&self, py: Python, rate: Option<f64>) -> PyResult<(bool, String, String)> {
        let loaded = self.whole();
        run_detached(py, None, move |_| {
            let (scene, diags) = load::compiled(&loaded, &Options { rate, ..Options::default() });
            let (json, text) = findings(&diags, &loaded.model);
            (scene.is_some(), json, text)
        })
    }

    #[pyo3(signature = (*, rate=None, energy=false, probes=Vec::new(), exact=false))]
    fn compile(
        &self,
        py: Python,
        rate: Option<f64>,
        energy: bool,
        probes: Vec<String>,
        exact: bool,
    ) -> PyResult<Scene> {
        let options = Options { rate, energy, probes, exact, ..Options::default() };
        let loaded = self.whole();
        let made = run_detached(py, None, move |_| {
            let scene = loaded.compile(&options)?;
            Ok(Scene::new(scene, loaded, options))
        });
        made?.map_err(|e| failure(py, e))
    }

    /// Plays it into a take, with the engine for devices.
    #[pyo3(signature = (path, *, rate, seconds, gesture, energy, forces, progress))]
    #[allow(clippy::too_many_arguments)]
    fn record(
        &self,
        py: Python,
        path: PathBuf,
        rate: Option<f64>,
        seconds: Option<f64>,
        gesture: Option<Py<Gesture>>,
        energy: bool,
        forces: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let ask = ca_take::RecordOptions { seconds, rate, energy, forces };
        let loaded = self.whole();
        let done = run_detached(py, progress, move |wanted| {
            let gesture = gesture.as_ref().map(|g| &g.get().gesture);
            ca_take::record(&loaded, gesture, &ask, &path, &mut |done, of| wanted.goes_on(done, of)).map(drop)
        });
        done?.map_err(|e| failure(py, e))
    }

    /// See `cordis_anima.Scene.modes`.
    #[pyo3(signature = (rate=None))]
    fn modes<'py>(&self, py: Python<'py>, rate: Option<f64>) -> PyResult<Bound<'py, PyDict>> {
        measure::modes(py, self.whole(), rate)
    }

    /// See `cordis_anima.Scene.linear`.
    #[pyo3(signature = (rate=None))]
    fn linear<'py>(&self, py: Python<'py>, rate: Option<f64>) -> PyResult<Bound<'py, PyDict>> {
        measure::linear(py, self.whole(), rate)
    }

    /// See `cordis_anima.Scene.accuracy`.
    #[pyo3(signature = (*, rate, seconds, probes, times, reference, progress))]
    #[allow(clippy::too_many_arguments)]
    fn accuracy<'py>(
        &self,
        py: Python<'py>,
        rate: Option<f64>,
        seconds: Option<f64>,
        probes: Vec<String>,
        times: Vec<u32>,
        reference: u32,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let asked = measure::AccuracyArgs { rate, seconds, probes, times, reference };
        measure::accuracy(py, self.whole(), asked, progress)
    }

    /// The changes by which a method is used at a multiple of the rate, as names and values; none for unknown methods.
    fn changes(&self, method: &str, times: u32) -> Option<Vec<(String, String)>> {
        ca_accuracy::changes(&self.loaded, method, times)
    }

    /// See `cordis_anima.fit`.
    #[pyo3(signature = (target, vary, *, ranges, seconds, gain, renders, gesture, report, progress))]
    #[allow(clippy::too_many_arguments)]
    fn fit<'py>(
        &self,
        py: Python<'py>,
        target: Target<'py>,
        vary: Vec<String>,
        ranges: Vec<(String, String, String)>,
        seconds: Option<f64>,
        gain: Option<f64>,
        renders: u32,
        gesture: Option<Py<Gesture>>,
        report: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Model, Bound<'py, PyDict>)> {
        let asked = FitArgs { vary, ranges, seconds, gain, renders, gesture, report };
        let (loaded, found) = fit::fitted(py, self.whole(), target, asked, progress)?;
        Ok((Model::of(loaded), found))
    }
}
