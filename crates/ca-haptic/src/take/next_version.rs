//! Another version of the model in the middle of a take.
//!
//! The message holds the whole version, bodies from files included, so that a reader needs nothing before it. The cost
//! is small, because a model is rarely saved.

use super::{cdr, couplings};
use crate::version::{ModelText, Version};
use ca_core::internal::kind::cloud::Clouds;
use ca_core::internal::scene::Coupling;
use ca_io::cloud;
use std::collections::BTreeMap;
use std::sync::Arc;

/// ROS 2 definition of the message `ca/msg/Model`.
///
/// - `start`: hash of its state at load.
/// - `moved`, `values`: names of parameters changed before, and the values \[SI\] that they keep.
/// - `changes`: names and values; `clouds`: bodies as OBJ by name; `parts`: texts of its parts by name; `couplings`:
///   couplings of device ports. These four and `moved` are JSON.
/// - `anew`: all masses begin as at load.
pub const MODEL: &str = "\
uint64 tick
uint64 start
float64[] values
string moved
string file
string text
string changes
string resolved
string clouds
bool anew
string parts
string couplings
";

/// A version of the model, as stored in a take.
#[derive(Clone, Debug, PartialEq)]
pub struct NextModel {
    /// Its text.
    pub model: ModelText,
    /// Its bodies from files.
    pub clouds: Clouds,
    /// [`ca_core::State::bits`] at load.
    pub start: u64,
    /// Live parameters that were changed before, with the values that they keep \[SI\].
    pub moved: Vec<(String, f64)>,
    /// True if no mass continues from its present position.
    pub restart: bool,
    /// Couplings of device ports to their links.
    pub couplings: Vec<Coupling>,
}

/// Writes `version`, which plays from `tick` on.
pub(super) fn write(out: &mut Vec<u8>, tick: u64, version: &Version) {
    let (names, values): (Vec<&str>, Vec<f64>) = version.moved.iter().map(|(n, v)| (n.as_str(), *v)).unzip();
    let bodies = version.options.clouds.iter();
    let clouds: BTreeMap<&str, String> =
        bodies.filter_map(|(n, c)| Some((n.as_str(), cloud::write_obj(c.as_ref().ok()?)))).collect();
    let m = &version.model;
    cdr::Out::new(out)
        .put(tick)
        .put(version.scene.state().bits())
        .list(&values)
        .text(&json(&names))
        .text(&m.file)
        .text(&m.text)
        .text(&json(&m.changes))
        .text(&m.resolved)
        .text(&json(&clouds))
        .put(u8::from(version.restart))
        .text(&json(&m.parts))
        .text(&couplings::write(&version.options.couplings));
}

/// Reads a version and its tick; `None` where the message is invalid.
pub(super) fn read(data: &[u8]) -> Option<(u64, NextModel)> {
    let mut r = cdr::In::new(data)?;
    let (tick, start) = (r.get()?, r.get()?);
    let values: Vec<f64> = r.list()?;
    let names: Vec<String> = serde_json::from_str(&r.text()?).ok()?;
    let (file, text) = (r.text()?, r.text()?);
    let changes = serde_json::from_str(&r.text()?).ok()?;
    let resolved = r.text()?;
    let bodies: BTreeMap<String, String> = serde_json::from_str(&r.text()?).ok()?;
    let mut clouds = Clouds::new();
    for (name, obj) in bodies {
        clouds.insert(name, Ok(Arc::new(cloud::read_obj(obj.as_bytes()).ok()?)));
    }
    let moved = (names.len() == values.len()).then(|| names.into_iter().zip(values).collect())?;
    // older takes lack these
    let anew = r.get::<u8>().is_some_and(|b| b != 0);
    let parts = r.text().and_then(|t| serde_json::from_str(&t).ok()).unwrap_or_default();
    let couplings = r.text().map_or(Some(Vec::new()), |t| couplings::read(&t))?;
    let model = ModelText { file, text, changes, resolved, parts };
    Some((tick, NextModel { model, clouds, start, moved, restart: anew, couplings }))
}

fn json<T: serde::Serialize>(v: &T) -> String {
    serde_json::to_string(v).unwrap_or_default()
}
