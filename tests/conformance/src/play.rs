//! Compiles and plays models from text, and reads the reference cases of `data/numerics_cases.json`, for the numerical
//! tests.
//!
//! `CA_TOL=0 cargo test $ALL --test suite -- --nocapture` prints every residual beside its tolerance.

use crate::models::catalog;
use ca_compile::Compiled;
use ca_compile::{KernelClass, Options, compile};
use ca_core::Scene;
use ca_model::{Model, read, render};
use serde_json::Value;
use std::sync::OnceLock;

/// 2π.
pub const TURN: f64 = std::f64::consts::TAU;
/// π.
pub const PI: f64 = std::f64::consts::PI;

/// Reads the model in `text`.
///
/// # Panics
/// If it has errors.
pub fn model(text: &str) -> Model {
    let (model, diags) = read::read(text, "test.ca.toml", &catalog());
    assert!(!diags.has_errors(), "{text}\n{}", render::text(&diags, &model, false));
    model
}

/// Compiles the model in `text` with these options.
///
/// # Panics
/// If it has errors.
pub fn with(text: &str, options: &Options) -> Compiled {
    let model = model(text);
    compile(&model, &catalog(), options).unwrap_or_else(|d| panic!("{text}\n{}", render::text(&d, &model, false)))
}

/// Compiles the model in `text`.
pub fn scene(text: &str) -> Compiled {
    with(text, &Options::default())
}

/// Compiles the model in `text` with the energy ledger.
pub fn audited(text: &str) -> Compiled {
    with(text, &Options { energy: true, ..Options::default() })
}

/// Options to compute links one by one in document order.
pub fn reference() -> Options {
    Options { kernel: KernelClass::Reference, ..Options::default() }
}

/// Place of the MAT `name` in the state.
///
/// # Panics
/// If it does not exist.
pub fn mat(scene: &Scene, name: &str) -> usize {
    (0..scene.counts.n_mat).find(|i| scene.mat_name(*i) == name).unwrap_or_else(|| panic!("no MAT `{name}`"))
}

/// Places of `name[0] …` in the state.
pub fn mats(scene: &Scene, name: &str) -> Vec<usize> {
    (0..scene.counts.n_mat)
        .map_while(|i| (0..scene.counts.n_mat).find(|p| scene.mat_name(*p) == format!("{name}[{i}]")))
        .collect()
}

/// Reference case whose id begins with `id`.
///
/// # Panics
/// If it does not exist.
pub fn case(id: &str) -> &'static Value {
    static CASES: OnceLock<Value> = OnceLock::new();
    let all = CASES.get_or_init(|| serde_json::from_str(include_str!("../../data/numerics_cases.json")).expect("JSON"));
    let found = |c: &&Value| c["id"].as_str().is_some_and(|i| i.starts_with(id));
    all["cases"].as_array().and_then(|c| c.iter().find(found)).unwrap_or_else(|| panic!("no case {id}"))
}

/// Number of a case; `path` is keys and indices separated by `/`.
///
/// # Panics
/// If it does not exist.
pub fn num(case: &Value, path: &str) -> f64 {
    case.pointer(&format!("/{path}")).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {path}"))
}

/// Rows of a table of a case.
///
/// # Panics
/// If it does not exist.
pub fn rows(case: &Value, path: &str) -> Vec<Vec<f64>> {
    let array = |v: &Value| v.as_array().cloned().unwrap_or_default();
    let table = array(case.pointer(&format!("/{path}")).expect("a table"));
    table.iter().map(|r| array(r).iter().filter_map(Value::as_f64).collect()).collect()
}

/// Numbers of a list of a case.
///
/// # Panics
/// If it does not exist.
pub fn list(case: &Value, path: &str) -> Vec<f64> {
    let v = case.pointer(&format!("/{path}")).and_then(Value::as_array).expect("a list");
    v.iter().filter_map(Value::as_f64).collect()
}

/// Asserts `residual` ≤ `tolerance`; NaN fails.
///
/// # Panics
/// If it is above.
#[track_caller]
pub fn within(what: &str, residual: f64, tolerance: f64) {
    if std::env::var_os("CA_TOL").is_some() {
        println!("{what:<42} {residual:9.2e} of {tolerance:.0e}");
    }
    assert!(residual <= tolerance, "{what}: {residual:e} is above {tolerance:e}");
}

/// Relative difference.
pub fn off(value: f64, reference: f64) -> f64 {
    ((value - reference) / reference).abs()
}

/// Largest absolute difference of two columns, NaN if any is.
///
/// # Panics
/// If their lengths differ.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, |m, v| if v.is_nan() { f64::NAN } else { v.max(m) })
}

/// ‖a − b‖ / ‖b‖.
///
/// # Panics
/// If their lengths differ.
pub fn rel_l2(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let square = |v: f64| v * v;
    let miss: f64 = a.iter().zip(b).map(|(a, b)| square(a - b)).sum();
    (miss / b.iter().map(|v| square(*v)).sum::<f64>()).sqrt()
}

/// A small deterministic generator (xorshift) of numbers in −1 … 1.
pub struct Random(pub u64);

impl Random {
    /// Returns the next number.
    pub fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
