//! JSON Schema (2020-12) of `*.ca.toml`, for editors.
//!
//! The schema is made from the catalog, so it cannot fall behind. It is as strict as possible without the model: names
//! of parameters, words of choices, exclusions. Bounds are checked only if they hold in every system of units (zero,
//! and plain numbers); the description gives the others. References to names are not checked.

use super::quantity::show;
use super::sections::{GROUP, META, RATES};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_core::equivalence::{Class, Quantity, ROWS};
use ca_core::internal::phi::implicit::{OF_GROUP, OF_MODEL, THETA};
use ca_core::{Catalog, Kind, Need, Param, Type, Unit};
use serde_json::{Map, Value as Json, json};

/// Pattern of one word of a name.
const WORD: &str = "^[A-Za-z_][A-Za-z0-9_]*$";
/// Pattern of a quantity, see [`super::quantity`]; any other string names a `[param]`.
const QUANTITY: &str = r"^\s*[-+−]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?(\s*[A-Za-zµμ%/].*)?$";

const GRAVITY: Param = Param::new(
    "gravity",
    Type::Position { unit: Unit::ACCELERATION },
    Need::Optional,
    "acceleration of free masses: a number, downwards along the last axis, or a number for each axis",
);

/// Returns the schema of the models that this catalog can read.
pub fn schema(catalog: &Catalog) -> Json {
    let mut defs = Map::new();
    defs.insert(
        "quantity".into(),
        json!({"type": "string", "pattern": QUANTITY, "description": "a number with its unit"}),
    );
    defs.insert(
        "name".into(),
        json!({"type": "string", "pattern": r"^[A-Za-z_][A-Za-z0-9_.#♯♭+ −-]*$", "description": "name of a `[param]`, or a musical note"}),
    );
    defs.insert(
        "number".into(),
        json!({"anyOf": [{"type": "number"}, {"$ref": "#/$defs/quantity"}, {"$ref": "#/$defs/name"}]}),
    );
    let (mut kinds, mut of_part) = (Map::new(), Map::new());
    for kind in catalog.iter() {
        defs.insert(kind.code.into(), members(kind, false));
        kinds.insert(kind.code.into(), json!({"$ref": format!("#/$defs/{}", kind.code)}));
        let in_part = format!("{}_of_part", kind.code);
        of_part.insert(kind.code.into(), json!({"$ref": format!("#/$defs/{in_part}")}));
        defs.insert(in_part, members(kind, true));
    }
    let mut group = kinds.clone();
    for kinds in [&mut group, &mut of_part] {
        kinds.extend(GROUP.iter().map(|p| ((*p).to_string(), of_group(p))));
    }
    defs.insert(
        "group".into(),
        json!({"type": "object", "description": "group of modules with common properties", "properties": group, "additionalProperties": false}),
    );
    let section = |doc: &str, keys: &[&str]| {
        let keys: Map<String, Json> = keys.iter().map(|k| ((*k).to_string(), known(k, &OF_MODEL))).collect();
        json!({"type": "object", "description": doc, "properties": keys, "additionalProperties": false})
    };
    let mut properties = kinds;
    properties.insert("model".into(), section("title, units, method and other settings of the model", META));
    properties.insert("rate".into(), section("sound rate, gesture rate and settings of devices and outputs", RATES));
    properties.insert("param".into(), params(true));
    defs.insert("use".into(), uses());
    properties.insert("use".into(), json!({"$ref": "#/$defs/use"}));
    properties.insert("part".into(), parts(&of_part));
    properties.insert(
        "gesture".into(),
        json!({"type": "object", "description": "breakpoints [time, value] of each port or live parameter"}),
    );
    properties.insert(
        "preset".into(),
        json!({
            "type": "object", "description": "named sets of values of live parameters", "propertyNames": {"pattern": WORD},
            "additionalProperties": {"type": "object", "description": "values of live parameters"},
        }),
    );
    properties.insert("equivalence".into(), equivalence());
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "CORDIS-ANIMA model",
        "type": "object",
        "properties": properties,
        "propertyNames": {"pattern": WORD},
        "additionalProperties": {"$ref": "#/$defs/group"},
        "$defs": defs,
    })
}

fn of_group(key: &str) -> Json {
    match key {
        "border" => json!({
            "enum": ["exact", "compensated"], "default": "exact",
            "description": "links between a group at the gesture rate and the sound; exact: only links whose force in a \
                            frame is known at its start; compensated: any link, with the unknown part of the force \
                            predicted from the frames before, and stability is not proven"
        }),
        _ => known(key, &OF_GROUP),
    }
}

/// Describes a key that is not a parameter of a kind; `method` describes that key here.
fn known(key: &str, method: &Param) -> Json {
    let number = |doc: &str| json!({"$ref": "#/$defs/number", "description": doc});
    match key {
        "units" => json!({"enum": ["si", "alg"], "default": "si", "description": "units of bare numbers"}),
        "start" => {
            json!({"enum": ["centred", "mi.lib"], "default": "centred", "description": "initial state: displacement and speed at the start, or as in mi.lib"})
        }
        "rate" => {
            json!({"enum": ["sound", "gesture"], "default": "sound", "description": "rate at which the group is computed"})
        }
        "dim" => json!({"enum": [1, 2, 3], "description": "number of dimensions of space"}),
        "reference_rate" => number("rate whose sampling period is the unit of time for `alg` units [Hz]"),
        "gravity" => param(&GRAVITY),
        "method" => param(method),
        "theta" => param(&THETA),
        "seconds" => number("default duration of a render [s]"),
        "friction" => number("viscosity of the medium on every free mass [N s/m]"),
        "sound" => number("samples per second [Hz]"),
        "oversample" => {
            json!({"type": "integer", "minimum": 1, "maximum": 64, "default": 1, "description": "ticks per sample"})
        }
        "gesture" => number("device frames per second; sound / gesture is a whole number [Hz]"),
        "border" => {
            json!({"enum": ["linear", "hold"], "default": "linear", "description": "position of a device between two frames: interpolated or held"})
        }
        "latency" => {
            json!({"type": "integer", "minimum": 0, "default": 0, "description": "delay added to the position of each device [frames]"})
        }
        "feedback" => json!({"type": "boolean", "default": true, "description": "true if devices receive forces"}),
        "filter" => number("pass-band edge of the low-pass filter on all outputs [Hz]"),
        "format" => {
            json!({"enum": [1, 2], "default": 1, "description": "version of the model format; in 2 the default method is `auto`"})
        }
        "title" => json!({"type": "string", "description": "short title"}),
        "author" => json!({"type": "string", "description": "author of the model"}),
        "source" => json!({"type": "string", "description": "origin of the model, e.g. a publication"}),
        "doc" => json!({"type": "string", "description": "description of the model"}),
        // every listed key has a type, which tests check
        _ => json!(false),
    }
}

/// Describes parts: their parameters, kinds, groups and properties.
fn parts(group: &Map<String, Json>) -> Json {
    let mut part = group.clone();
    part.insert("param".into(), params(false));
    part.insert("use".into(), json!({"$ref": "#/$defs/use"}));
    part.insert("gesture".into(), json!({"type": "object", "description": "built-in gestures of the part"}));
    part.insert("doc".into(), json!({"type": "string", "description": "description of the part in one line"}));
    let part = json!({
        "type": "object", "properties": part, "propertyNames": {"pattern": WORD},
        "additionalProperties": {"$ref": "#/$defs/group"},
    });
    json!({
        "type": "object", "description": "reusable parts; `[use]` makes instances of them", "propertyNames": {"pattern": WORD},
        "additionalProperties": part,
    })
}

fn uses() -> Json {
    let full = json!({
        "type": "object",
        "properties": {
            "part": {"type": "string", "description": "name of the part"},
            "file": {"type": "string", "description": "file that contains the part, relative to the folder of this file"},
            "n": {
                "anyOf": [{"type": "integer", "minimum": 1}, {"$ref": "#/$defs/name"}],
                "description": "number of instances; without it there is one, named without an index",
            },
            "with": {"type": "object", "description": "values of its parameters; for several instances a list has one value for each"},
        },
        "additionalProperties": false,
        "anyOf": [{"required": ["part"]}, {"required": ["file"]}],
    });
    json!({
        "type": "object", "description": "instances of parts", "propertyNames": {"pattern": WORD},
        "additionalProperties": {"anyOf": [{"type": "string"}, full]},
    })
}

/// Describes named numbers. In a part they may lack a value, and may be a word, a module or a list.
fn params(valued: bool) -> Json {
    let number = json!({"$ref": "#/$defs/number"});
    let value = if valued { number.clone() } else { json!({"type": ["number", "string", "boolean", "array"]}) };
    let mut full = json!({
        "type": "object",
        "properties": {
            "value": value, "min": number, "max": number,
            "unit": {"type": "string"}, "doc": {"type": "string"},
            "live": {"type": "boolean", "description": "can be changed while the model plays"},
            "port": {"type": "string", "description": "port that drives the parameter from `min` to `max`"},
            "span": {
                "type": "array", "minItems": 2, "maxItems": 2, "items": number,
                "description": "positions of the port at `min` and at `max`",
            },
        },
    });
    if valued {
        full["anyOf"] = json!([{"required": ["value"]}, {"required": ["port", "span", "min", "max"]}]);
    }
    json!({
        "type": "object",
        "description": "named numbers",
        "propertyNames": {"pattern": WORD},
        "additionalProperties": {"anyOf": [value, full]},
    })
}

/// Describes rows as pairs, the anchor, and a table for each device key (for a key in a group, a table in a table).
fn equivalence() -> Json {
    let number = json!({"$ref": "#/$defs/number"});
    let rows = ROWS.iter().filter(|r| r.class() != Class::Time);
    let pair = |r: &Quantity| {
        let doc = format!("[real, simulated]; a real value without a unit is in {}", r.unit.symbol);
        json!({"type": "array", "minItems": 2, "maxItems": 2, "items": number, "description": doc})
    };
    let mut known: Map<String, Json> = rows.clone().map(|r| (r.name.to_string(), pair(r))).collect();
    let anchors: Vec<&str> = ["impedance"].into_iter().chain(rows.map(|r| r.name)).collect();
    known.insert(
        "anchor".into(),
        json!({"enum": anchors, "description": "quantity that is kept if only one row is given"}),
    );
    let factor = json!({"$ref": "#/$defs/number", "description": "factor in addition to the scale of the model"});
    let key = json!({
        "type": "object", "description": "scale of this device key relative to the others",
        "properties": {"lever": factor, "position": factor, "force": factor}, "additionalProperties": {"type": "object"},
        "allOf": [{"not": {"required": ["lever", "position"]}}, {"not": {"required": ["lever", "force"]}}],
    });
    json!({
        "type": "object", "description": "scale between the device and the model: quantity = [real, simulated]",
        "properties": known, "additionalProperties": key,
    })
}

/// Describes the section of one kind. In a part a word or a flag may be a parameter of that part.
fn members(kind: &Kind, of_part: bool) -> Json {
    let one = |p: &Param| match p.ty {
        Type::Choice(_) | Type::Flag if of_part => json!({"anyOf": [param(p), {"$ref": "#/$defs/name"}]}),
        _ => param(p),
    };
    let properties: Map<String, Json> = kind.params.iter().map(|p| (p.name.to_string(), one(p))).collect();
    let required: Vec<&str> = kind.params.iter().filter(|p| p.need == Need::Required).map(|p| p.name).collect();
    let mut rules = Vec::new();
    for one_of in kind.one_of {
        for (i, a) in one_of.sets.iter().enumerate() {
            for b in &one_of.sets[i + 1..] {
                let pairs = a.iter().flat_map(|x| b.iter().map(move |y| (x, y))).filter(|(x, y)| x != y);
                rules.extend(pairs.map(|(x, y)| json!({"not": {"required": [x, y]}})));
            }
        }
        if one_of.required {
            let firsts: Vec<Json> =
                one_of.sets.iter().filter_map(|s| s.first()).map(|f| json!({"required": [f]})).collect();
            rules.push(json!({"anyOf": firsts}));
        }
    }
    let mut module = json!({"type": "object", "properties": properties, "additionalProperties": false});
    if !required.is_empty() {
        module["required"] = json!(required);
    }
    if !rules.is_empty() {
        module["allOf"] = json!(rules);
    }
    json!({
        "type": "object",
        "title": format!("{}: {}", kind.code, kind.title),
        "description": format!("{}\n\n{}", kind.doc, kind.equation),
        "propertyNames": {"pattern": WORD},
        "additionalProperties": module,
    })
}

fn param(p: &Param) -> Json {
    let (mut json, unit) = match p.ty {
        Type::Number { unit, min, max } => (number(unit, min, max), Some((unit, min, max))),
        Type::Numbers { unit, min, max } => {
            let one = number(unit, min, max);
            (json!({"anyOf": [one, {"type": "array", "items": one}]}), Some((unit, min, max)))
        }
        Type::PowerStiffness { .. } => (number(Unit::STIFFNESS, 0.0, f64::MAX), None),
        Type::Count { min, max } => {
            (json!({"anyOf": [{"type": "integer", "minimum": min, "maximum": max}, {"$ref": "#/$defs/name"}]}), None)
        }
        Type::Choice(words) => (json!({"enum": words}), None),
        Type::Flag => (json!({"type": "boolean"}), None),
        Type::Points { .. } => {
            let number = json!({"anyOf": [{"type": "number"}, {"$ref": "#/$defs/quantity"}]});
            let point = json!({"type": "array", "minItems": 2, "maxItems": 2, "items": number});
            (json!({"type": "array", "minItems": 2, "items": point}), None)
        }
        Type::Position { unit } => {
            let one = number(unit, f64::MIN, f64::MAX);
            let list = json!({"type": "array", "minItems": 2, "maxItems": 3, "items": one});
            (json!({"anyOf": [one, list]}), Some((unit, f64::MIN, f64::MAX)))
        }
        Type::Positions { unit } => {
            let one = number(unit, f64::MIN, f64::MAX);
            let place = json!({"type": "array", "minItems": 3, "maxItems": 3, "items": one});
            (json!({"type": "array", "minItems": 1, "items": place}), Some((unit, f64::MIN, f64::MAX)))
        }
        Type::Direction => {
            let list = json!({"type": "array", "minItems": 2, "maxItems": 3, "items": {"type": "number"}});
            (json!({"anyOf": [{"enum": ["x", "y", "z"]}, list]}), None)
        }
        Type::Counts { min, max } => {
            let one = json!({"type": "integer", "minimum": min, "maximum": max});
            (json!({"anyOf": [one, {"type": "array", "items": one}, {"$ref": "#/$defs/name"}]}), None)
        }
        Type::Nodes => {
            let node = json!({"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "integer"}});
            (json!({"type": "array", "items": node}), None)
        }
        Type::Between => {
            let end = json!({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]});
            (json!({"type": "array", "minItems": 2, "maxItems": 2, "items": end}), None)
        }
        Type::Module => (json!({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}), None),
        Type::Text | Type::File => (json!({"type": "string"}), None),
        Type::Midi => (json!({"type": "object"}), None),
    };
    let mut doc = Vec::from([p.doc.to_string()]);
    match p.ty {
        Type::PowerStiffness { exponent } => doc.push(format!(" [N/m^{exponent}]")),
        Type::Points { x, y } => doc.push(format!(" [{}, {}]", symbol(x), symbol(y))),
        _ => {}
    }
    if let Some((unit, min, max)) = unit {
        doc.push(format!(" [{}]", symbol(unit)));
        let own = |v: f64| v != 0.0 && v.abs() != f64::MAX && v != f64::MIN_POSITIVE;
        if own(min) {
            doc.push(format!(", from {}", show(min, unit)));
        }
        if own(max) {
            doc.push(format!(", up to {}", show(max, unit)));
        }
        if let Need::Default(v) = p.need {
            json["default"] = if v == 0.0 || unit.dim == Unit::NONE.dim { json!(v) } else { json!(show(v, unit)) };
        }
    } else if let Need::Default(v) = p.need {
        json["default"] = match p.ty {
            Type::Choice(words) => json!(words.get(v as usize)),
            Type::Flag => json!(v != 0.0),
            Type::Count { .. } | Type::Counts { .. } => json!(v as u64),
            _ => json!(v),
        };
    }
    json["description"] = json!(doc.concat());
    json
}

fn symbol(unit: Unit) -> &'static str {
    if unit.symbol.is_empty() { "plain number" } else { unit.symbol }
}

/// Describes a bare number with the bounds of every system of units, a quantity, or a name.
fn number(unit: Unit, min: f64, max: f64) -> Json {
    let mut bare = json!({"type": "number"});
    let plain = unit.dim == Unit::NONE.dim;
    if min == f64::MIN_POSITIVE {
        bare["exclusiveMinimum"] = json!(0);
    } else if min == 0.0 || plain && min != f64::MIN {
        bare["minimum"] = json!(min);
    }
    if plain && max != f64::MAX || max == 0.0 {
        bare["maximum"] = json!(max);
    }
    json!({"anyOf": [bare, {"$ref": "#/$defs/quantity"}, {"$ref": "#/$defs/name"}]})
}
