//! Operations on the text of a model, as data: a page sends them, and a language server makes them.

use crate::add::{self, Values};
use crate::equivalence::{self, KeyScale};
use crate::map::{self, MidiSource};
use crate::symbols::Written;
use crate::{Edited, Refusal, delete, duplicate, group, rename, shift, value};
use ca_compile::{Options, load};
use ca_core::Catalog;
use ca_model::read;
use serde::{Deserialize, Serialize};

/// An operation. All names are as in `--set`: `hammer`, `beads.a` of a group, `low[8]` in links. A name in a part begins
/// with `part.` and the part, such as `part.note.hammer`; `param.felt` and `preset.hard` name those, and `into` names a
/// group or a part. Values are typed text, such as `2 N/m`, `0.5`, `true` or `["a", "b"]`.
///
/// ```
/// use ca_edit::Operation;
/// let text = "[MAS]\nbob = { m = \"1 g\" } # brass\n[SOL]\nwall = {}\n";
/// let json = r#"{"type": "join", "kind": "RES", "from": "wall", "to": "bob", "values": {"k": "2 N/m"}}"#;
/// let operation: Operation = serde_json::from_str(json)?;
/// let edited = operation.apply(text, &ca_model::catalog())?;
/// assert!(edited.text.ends_with("[RES]\nres = { between = [\"wall\", \"bob\"], k = \"2 N/m\" }\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Operation {
    /// Adds a module, a generator or a port: `{"type": "add", "kind": "MAS", "values": {"m": "2 g"}}`. Other required
    /// parameters get the values of the example of the kind.
    Add {
        /// Code of the kind.
        kind: String,
        /// Name, one word; made from the kind if it is left out.
        #[serde(default)]
        name: Option<String>,
        /// Values by parameter.
        #[serde(default)]
        values: Values,
        /// Group or part that gets it.
        #[serde(default)]
        into: Option<String>,
    },
    /// Adds an instance of a part: `{"type": "instance", "part": "plectrum", "with": {"on": "low[6]", "note": "E2"}}`.
    Instance {
        /// Part of the model, or one that comes with the program.
        part: String,
        /// Name; made from the part if it is left out.
        #[serde(default)]
        name: Option<String>,
        /// Number of instances; left out, there is one without an index.
        #[serde(default)]
        n: Option<u32>,
        /// Values by parameter of the part.
        #[serde(default)]
        with: Values,
        /// Part that gets it.
        #[serde(default)]
        into: Option<String>,
    },
    /// Joins two masses by a link: `{"type": "join", "kind": "BUT", "from": "hammer", "to": "low[8]"}`.
    Join {
        /// Code of the link.
        kind: String,
        /// First end.
        from: String,
        /// Second end; a contact keeps it above the first.
        to: String,
        /// Name; made from the kind if it is left out.
        #[serde(default)]
        name: Option<String>,
        /// Values by parameter.
        #[serde(default)]
        values: Values,
        /// Part that gets it; the ends are names in it.
        #[serde(default)]
        into: Option<String>,
    },
    /// Sets a value: `{"type": "set", "name": "hammer.m", "value": "2 g"}`. Also `felt` (a parameter), `felt.live`,
    /// `model.title`, `rate.sound`, `gesture.key`, `preset.hard.felt`, `note.f` (a value of an instance), `note.f[1]`,
    /// `beads.gravity`, `key.midi.to`. It creates what is not there, such as `param.felt` or a preset.
    Set {
        /// Name of the value.
        name: String,
        /// Typed text.
        value: String,
    },
    /// Removes a value, so that it has its default: `{"type": "clear", "name": "hammer.x"}`.
    Clear {
        /// Name of the value.
        name: String,
    },
    /// Renames something and everything that refers to it: `{"type": "rename", "name": "beads.a", "to": "first"}`.
    Rename {
        /// Its name.
        name: String,
        /// The new name, one word.
        to: String,
    },
    /// Deletes: `{"type": "delete", "names": ["hammer"], "dependents": true}`. Without `dependents` it is refused if
    /// something refers to it, and the refusal lists what. With it, links, instances, gestures and values of presets are
    /// deleted too, and a number that names a deleted parameter gets its value.
    Delete {
        /// Names of the things to delete.
        names: Vec<String>,
        /// True to delete dependents too.
        #[serde(default)]
        dependents: bool,
    },
    /// Copies modules, groups, instances or parameters under new names, each behind its original:
    /// `{"type": "duplicate", "names": ["hammer", "strike"]}`. Links among them join the copies.
    Duplicate {
        /// Names of the things to copy.
        names: Vec<String>,
    },
    /// Makes a part of modules, and one instance in their place:
    /// `{"type": "group", "names": ["key", "hammer", "shank"], "part": "action"}`.
    Group {
        /// Modules, groups and instances of the model.
        names: Vec<String>,
        /// Name of the part.
        part: String,
        /// Name of the instance; the name of the part if it is left out.
        #[serde(default)]
        instance: Option<String>,
    },
    /// Moves a module to another rest position \[m\]: `{"type": "move", "name": "hammer", "x": [-0.005]}`. The number keeps
    /// its unit.
    Move {
        /// The module.
        name: String,
        /// One coordinate for each axis.
        x: Vec<f64>,
    },
    /// Maps a MIDI key or controller: `{"type": "midi", "name": "key", "source": {"note": {"first": "C4"}}, "from":
    /// "-2 mm", "to": "0 mm"}`. A mapping that is there keeps its other values.
    Midi {
        /// The port.
        name: String,
        /// Note, controller, bend or pressure.
        source: MidiSource,
        /// Value of the port at rest.
        #[serde(default)]
        from: Option<String>,
        /// Value at full scale; needed unless it is written.
        #[serde(default)]
        to: Option<String>,
    },
    /// Connects a port to a device: `{"type": "device", "name": "key", "device": "tgr12", "dof": [3]}`.
    Device {
        /// The port, a TGR.
        name: String,
        /// Name of the device.
        device: String,
        /// Degrees of freedom from 0, one for each axis that moves.
        dof: Vec<u32>,
    },
    /// Sets the scale between model and hand: `{"type": "equivalence", "rows": {"mass": "20 g:1"}}`. The model must
    /// compile.
    Equivalence {
        /// At most two rows, each `real:simulated`.
        #[serde(default)]
        rows: Values,
        /// Quantity that stays as it is, if one row is set.
        #[serde(default)]
        anchor: Option<String>,
        /// Device key with another scale.
        #[serde(default)]
        key: Option<String>,
        /// Factor of its positions and forces.
        #[serde(default)]
        lever: Option<f64>,
        /// Factor of its positions.
        #[serde(default)]
        position: Option<f64>,
        /// Factor of its forces.
        #[serde(default)]
        force: Option<f64>,
    },
}

impl Operation {
    /// Applies the operation to a text. `catalog` has the kinds. All bytes outside the [edits](Edited::edits) stay.
    ///
    /// # Errors
    /// If the text is not TOML, or the operation does not fit it. A text with other errors can be edited.
    pub fn apply(&self, text: &str, catalog: &Catalog) -> Result<Edited, Refusal> {
        let w = &Written::read(text, catalog)?;
        let edited = match self {
            Operation::Add { kind, name, values, into } => add::add(w, kind, name.as_deref(), values, into.as_deref()),
            Operation::Instance { part, name, n, with, into } => {
                add::instance(w, part, name.as_deref(), *n, with, into.as_deref())
            }
            Operation::Join { kind, from, to, name, values, into } => {
                add::join(w, kind, [from, to], name.as_deref(), values, into.as_deref())
            }
            Operation::Set { name, value } => value::set(w, name, value),
            Operation::Clear { name } => value::clear(w, name),
            Operation::Rename { name, to } => rename::rename(w, name, to),
            Operation::Delete { names, dependents } => delete::delete(w, names, *dependents),
            Operation::Duplicate { names } => duplicate::duplicate(w, names),
            Operation::Group { names, part, instance } => group::group(w, names, part, instance.as_deref()),
            Operation::Move { name, x } => shift::shift(w, name, x),
            Operation::Midi { name, source, from, to } => map::midi(w, name, source, from.as_deref(), to.as_deref()),
            Operation::Device { name, device, dof } => map::device(w, name, device, dof),
            Operation::Equivalence { rows, anchor, key, lever, position, force } => {
                let rows: Vec<(String, String)> = rows.iter().map(|(k, v)| (k.clone(), v.clone())).collect();
                let (lever, position, force) = (*lever, *position, *force);
                let key = key.as_deref().map(|key| KeyScale { key, lever, position, force });
                equivalence(w, &equivalence::Change { rows: &rows, anchor: anchor.as_deref(), key })
            }
        }?;
        let broken = |text: &str| {
            let found = read::written(text, "", catalog).1;
            found.list.into_iter().filter(|d| matches!(d.code, "E001" | "E012")).map(|d| d.title).collect::<Vec<_>>()
        };
        let (before, after) = (broken(text), broken(&edited.text));
        match after.into_iter().find(|title| !before.contains(title)) {
            Some(title) => Err(Refusal::new(format!("this would break the text: {title}"), "change the text by hand")),
            None => Ok(edited),
        }
    }

    /// Returns the name of the step for [`crate::History`].
    pub fn title(&self) -> String {
        let list = |names: &[String]| match names {
            [] => "nothing".to_owned(),
            [one] => one.clone(),
            [first, rest @ ..] => format!("{first} and {} more", rest.len()),
        };
        match self {
            Operation::Add { kind, .. } => format!("add {kind}"),
            Operation::Instance { part, .. } => format!("add {part}"),
            Operation::Join { from, to, .. } => format!("join {from} and {to}"),
            Operation::Set { name, .. } => format!("set {name}"),
            Operation::Clear { name } => format!("clear {name}"),
            Operation::Rename { name, to } => format!("rename {name} to {to}"),
            Operation::Delete { names, .. } => format!("delete {}", list(names)),
            Operation::Duplicate { names } => format!("duplicate {}", list(names)),
            Operation::Group { part, .. } => format!("group to {part}"),
            Operation::Move { name, .. } => format!("move {name}"),
            Operation::Midi { name, .. } | Operation::Device { name, .. } => format!("map {name}"),
            Operation::Equivalence { .. } => "set the scale".into(),
        }
    }
}

fn equivalence(w: &Written, change: &equivalence::Change) -> Result<Edited, Refusal> {
    let compiled = load(w.text(), "", w.catalog, &Options::default()).1;
    let Ok(compiled) = compiled else {
        return Err(Refusal::new("the model has errors", "correct them first: the scale depends on the whole model"));
    };
    let mut document = w.document.clone();
    let now = &compiled.scene.hand.equivalence;
    match equivalence::change(&mut document, now, change) {
        Ok(()) => Ok(Edited::between(w.text(), document.text())),
        Err(why) => Err(Refusal::new(why.reason(), "change the scale as the message says")),
    }
}
