//! Maps a MIDI key or controller, or a device key, to a port.

use crate::symbols::{Class, Written};
use crate::value::{finish, shown, typed};
use crate::{Edited, Place, Refusal};
use ca_core::Type;
use serde::{Deserialize, Serialize};

/// MIDI source of a port.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MidiSource {
    /// A note by name or number, such as `C4` or `60`; with `last`, the range from this to that one.
    Note {
        /// The note, or the lowest one.
        first: String,
        /// The highest note.
        last: Option<String>,
    },
    /// A controller, 0 to 127.
    Controller(u8),
    /// The pitch bend.
    Bend,
    /// The channel pressure.
    Pressure,
}

impl MidiSource {
    fn entry(&self) -> Result<(&'static str, String), Refusal> {
        Ok(match self {
            MidiSource::Note { first, last: None } => ("note", typed(first)?),
            MidiSource::Note { first, last: Some(last) } => ("note", format!("[{}, {}]", typed(first)?, typed(last)?)),
            MidiSource::Controller(n) if *n <= 127 => ("cc", n.to_string()),
            MidiSource::Controller(n) => {
                return Err(Refusal::new(format!("unknown MIDI controller: {n}"), "give a number from 0 to 127"));
            }
            MidiSource::Bend => ("bend", "true".into()),
            MidiSource::Pressure => ("pressure", "true".into()),
        })
    }
}

const SOURCES: [&str; 4] = ["note", "cc", "bend", "pressure"];

/// Maps `source` to the port `name`, which goes from `from` to `to`. A mapping that is there keeps its other values.
pub(crate) fn midi(
    w: &Written,
    name: &str,
    source: &MidiSource,
    from: Option<&str>,
    to: Option<&str>,
) -> Result<Edited, Refusal> {
    let port = port(w, name, &|ty| matches!(ty, Type::Midi), "midi")?;
    let place = port.then("midi");
    let (key, value) = source.entry()?;
    let old: Vec<String> = w.document.keys(&place).into_iter().map(Into::into).collect();
    let mut ends: Vec<(&str, String)> = Vec::new();
    for (key, value) in [("from", from), ("to", to)] {
        ends.extend(value.map(|v| Ok::<_, Refusal>((key, typed(v)?))).transpose()?);
    }
    if to.is_none() && !old.iter().any(|k| k == "to") {
        let help = "give `to`, the value of the port at full scale, such as `5 mm`";
        return Err(Refusal::new(format!("the mapping of `{}` needs its end", shown(name)), help));
    }
    let mut document = w.document.clone();
    let done = if old.is_empty() {
        let mut table = vec![format!("{key} = {value}")];
        table.extend(ends.iter().map(|(k, v)| format!("{k} = {v}")));
        document.write(&place, &format!("{{ {} }}", table.join(", ")))
    } else {
        let is_old_source = |k: &&String| SOURCES.contains(&k.as_str());
        let written = old.iter().find(is_old_source).map_or(Some(()), |k| {
            let is_same = k == key || document.rename(&place.clone().then(k), key).is_some();
            is_same.then_some(())
        });
        let mut drop: Vec<&String> = old.iter().filter(is_old_source).skip(1).collect();
        if key != "note" {
            drop.extend(old.iter().filter(|k| matches!(k.as_str(), "velocity" | "back")));
        }
        written.and_then(|()| {
            drop.iter().try_for_each(|k| document.clear(&place.clone().then(k)))?;
            document.write(&place.clone().then(key), &value)?;
            ends.iter().try_for_each(|(k, v)| document.write(&place.clone().then(k), v))
        })
    };
    finish(w, done.map(|()| document), name)
}

/// Connects the port `name` to degrees of freedom of a device, one for each axis that moves.
pub(crate) fn device(w: &Written, name: &str, device: &str, dof: &[u32]) -> Result<Edited, Refusal> {
    let port = port(w, name, &|ty| matches!(ty, Type::Counts { .. }), "dof")?;
    let dofs = match dof {
        [one] => one.to_string(),
        [] => {
            return Err(Refusal::new(
                "the list of degrees of freedom is empty",
                "give one for each axis that moves, from 0",
            ));
        }
        all if all.len() <= 3 => format!("[{}]", all.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")),
        _ => return Err(Refusal::new("there are too many degrees of freedom", "give at most three")),
    };
    if device.trim().is_empty() {
        return Err(Refusal::new("the name of the device is empty", "give the name of the device, such as `tgr12`"));
    }
    let mut document = w.document.clone();
    let done = document
        .write(&port.clone().then("device"), &crate::layout::quoted(device.trim()))
        .and_then(|()| document.write(&port.then("dof"), &dofs));
    finish(w, done.map(|()| document), name)
}

/// Returns the place of a module whose kind has a parameter of this type.
fn port(w: &Written, name: &str, fits: &dyn Fn(Type) -> bool, key: &str) -> Result<Place, Refusal> {
    let symbol = w.find(name)?;
    let item = w.body(symbol.scope).items.get(symbol.index).filter(|_| symbol.class == Class::Module);
    let kind = item.and_then(|i| w.catalog.get(&i.kind));
    if kind.is_some_and(|k| k.params.iter().any(|p| p.name == key && fits(p.ty))) {
        return Ok(Place::keys(w.path(symbol)));
    }
    let codes = w.catalog.iter().filter(|k| k.params.iter().any(|p| p.name == key && fits(p.ty))).map(|k| k.code);
    let what = format!("`{}` has no `{key}`", shown(name));
    Err(Refusal::new(what, format!("choose a port: {}", ca_model::suggest::ticked(codes))))
}
