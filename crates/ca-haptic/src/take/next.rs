//! Another version of the model, in the middle of a take.
//!
//! Decides that a message holds all of it again, bodies from files included: whoever reads a take from there on needs nothing
//! else, and an author who saves a model saves little.

use super::{cdr, couplings};
use crate::version::{ModelText, Version};
use ca_core::internal::kind::cloud::Clouds;
use ca_core::internal::scene::Coupling;
use ca_io::cloud;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The definition of the message: `ca/msg/Model`. `start` is the hash of its state at load, `changes` a list of names and values,
/// `clouds` bodies as OBJ by name, `moved` the names of parameters that somebody had moved before, whose `values` they keep
/// \[SI\], `parts` the texts of files that it takes parts from, by name, `couplings` the couplings of device ports; the five are JSON;
/// where `anew`, all masses begin as at load.
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

/// A version of the model, as a take holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct NextModel {
    /// its text
    pub model: ModelText,
    /// its bodies from files
    pub clouds: Clouds,
    /// [`ca_core::State::bits`] at load
    pub start: u64,
    /// live parameters that stay where somebody had moved them \[SI\]
    pub moved: Vec<(String, f64)>,
    /// no mass goes on from where it was
    pub anew: bool,
    /// device ports that are coupled to their links
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
        .put(u8::from(version.anew))
        .text(&json(&m.parts))
        .text(&couplings::write(&version.options.couplings));
}

/// Reads one, with its tick; `None` where that is not what is there.
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
    // takes of before have none of these
    let anew = r.get::<u8>().is_some_and(|b| b != 0);
    let parts = r.text().and_then(|t| serde_json::from_str(&t).ok()).unwrap_or_default();
    let couplings = r.text().map_or(Some(Vec::new()), |t| couplings::read(&t))?;
    let model = ModelText { file, text, changes, resolved, parts };
    Some((tick, NextModel { model, clouds, start, moved, anew, couplings }))
}

fn json<T: serde::Serialize>(v: &T) -> String {
    serde_json::to_string(v).unwrap_or_default()
}
