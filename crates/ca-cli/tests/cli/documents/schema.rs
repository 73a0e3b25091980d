//! Tests the JSON Schema with an independent validator: it accepts every model and example, and refuses what a schema
//! can refuse.

use crate::documents::docs::markdown;
use crate::sandbox::{Sandbox, blocks, from_root};
use jsonschema::Validator;
use serde_json::{Value as Json, json};
use std::fs;
use std::path::Path;
use toml_edit::{DocumentMut, Item, TableLike, Value};

/// Validator for the output of `ca list --schema`, which must be a valid schema.
fn validator() -> Validator {
    let schema = Sandbox::new().ca(&["list", "--schema"]).is(0).json();
    jsonschema::draft202012::meta::validate(&schema).unwrap_or_else(|e| panic!("no schema: {e}"));
    jsonschema::draft202012::new(&schema).unwrap_or_else(|e| panic!("no schema: {e}"))
}

fn value(v: &Value) -> Json {
    match v {
        Value::String(s) => json!(s.value()),
        Value::Integer(i) => json!(i.value()),
        Value::Float(f) => json!(f.value()),
        Value::Boolean(b) => json!(b.value()),
        Value::Datetime(d) => json!(d.to_string()),
        Value::Array(a) => a.iter().map(value).collect(),
        Value::InlineTable(t) => table(t),
    }
}

fn table(t: &dyn TableLike) -> Json {
    let entry = |(k, v): (&str, &Item)| {
        let v = v.as_value().map(value).or_else(|| v.as_table_like().map(table));
        (k.to_owned(), v.expect("a value or a table"))
    };
    Json::Object(t.iter().map(entry).collect())
}

/// Parses the model in `text` as an editor passes it to a validator.
fn document(text: &str) -> Json {
    let parsed: DocumentMut = text.parse().unwrap_or_else(|e| panic!("{e}\n{text}"));
    table(parsed.as_table())
}

/// Lists the schema errors of `text`, with their places.
fn wrong(v: &Validator, text: &str) -> Vec<String> {
    v.iter_errors(&document(text)).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

fn collect(folder: &Path, found: &mut Vec<(String, String)>) {
    for path in fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
        if path.is_dir() {
            collect(&path, found);
        } else if path.to_string_lossy().ends_with(".ca.toml") {
            found.push((path.display().to_string(), fs::read_to_string(&path).unwrap()));
        }
    }
}

/// All `toml` blocks of the pages, except plans of sweeps.
fn examples() -> Vec<(String, String)> {
    let mut pages = vec![from_root("README.md"), from_root("crates/ca-py/README.md")];
    pages.extend(["docs", "docs/language"].iter().flat_map(|folder| markdown(&from_root(folder))));
    let mut all = Vec::new();
    for page in &pages {
        let text = fs::read_to_string(page).unwrap();
        let models =
            blocks(&text, "toml").into_iter().filter(|(_, b)| document(b).get("model").is_none_or(Json::is_object));
        all.extend(models.map(|(_, b)| (page.display().to_string(), b.to_owned())));
    }
    all
}

#[test]
fn the_schema_takes_every_model_and_every_example_there_is() {
    let v = validator();
    let mut all = examples();
    assert!(all.len() >= 18, "only {} examples were found", all.len());
    for folder in ["models", "tests/models", "crates"] {
        let before = all.len();
        collect(&from_root(folder), &mut all);
        assert!(all.len() > before, "no model in {folder}");
    }
    all.extend(ca_lab::catalog().iter().map(|k| (format!("example of {}", k.code), k.example.to_owned())));
    for (name, text) in ca_lab::load::BUNDLED {
        assert!(all.iter().any(|(_, t)| t == text), "{name} is bundled and was not found");
    }
    let refused: Vec<_> = all.iter().map(|(name, text)| (name, wrong(&v, text))).filter(|w| !w.1.is_empty()).collect();
    assert!(refused.is_empty(), "{refused:#?}");
}

#[test]
fn the_schema_refuses_what_it_can() {
    let v = validator();
    for (text, place) in [
        ("[MAS]\nbob = { m = true }\n", "/MAS/bob/m"),
        ("[MAS]\nbob = { m = 0 }\n", "/MAS/bob/m"),
        ("[MAS]\nbob = { m = \"20 g\", mm = 3 }\n", "/MAS/bob"),
        ("[MAS]\nbob = { x = 3 }\n", "/MAS/bob"),
        ("[CEL]\nbar = { m = 1, f = 2, k = 3 }\n", "/CEL/bar"),
        ("[model]\nseconds = true\n", "/model/seconds"),
        ("[model]\nseconds = [1]\n", "/model/seconds"),
        ("[model]\nmethod = \"magic\"\n", "/model/method"),
        ("[model]\ntheta = [1]\n", "/model/theta"),
        ("[model]\ngravity = true\n", "/model/gravity"),
        ("[model]\ntitle = 3\n", "/model/title"),
        ("[model]\nlength = 3\n", "/model"),
        ("[rate]\nborder = \"soft\"\n", "/rate/border"),
        ("[room]\ndim = 4\n", "/room/dim"),
        ("[room]\nmethod = \"pefrl\"\n", "/room/method"),
        ("[RES]\nr = { between = [\"a\"], k = 1 }\n", "/RES/r/between"),
    ] {
        let said = wrong(&v, text);
        assert!(said.iter().any(|s| s.starts_with(&format!("{place}:"))), "{text}{said:?}");
    }
}

#[test]
fn a_new_model_names_its_schema() {
    let v = validator();
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path("mine")).unwrap();
    for (args, title) in
        [(&["new", "mine/a.ca.toml"][..], "My string"), (&["new", "mine/b.ca.toml", "--from", "glass"], "")]
    {
        sandbox.ca(args).is(0);
        let text = fs::read_to_string(sandbox.path(args[1])).unwrap();
        let line = text.lines().next().unwrap();
        let named = line.strip_prefix("#:schema ").expect("the first line names a schema");
        // like Taplo, resolves the path from the folder of the model
        let schema = fs::read_to_string(sandbox.path("mine").join(named)).unwrap();
        let schema: Json = serde_json::from_str(&schema).unwrap();
        assert_eq!(schema, sandbox.ca(&["list", "--schema"]).is(0).json());
        assert_eq!(wrong(&v, &text), Vec::<String>::new());
        assert!(text.contains(title));
        assert!(
            !sandbox.ca(&["check", args[1]]).is(0).out.contains("schema"),
            "a line for editors is no text for people"
        );
    }
    // an older schema is replaced; another file is kept and named
    sandbox.put("mine/ca.schema.json", "{\"title\": \"CORDIS-ANIMA model\"}").ca(&["new", "mine/c.ca.toml"]).is(0);
    assert!(fs::read_to_string(sandbox.path("mine/ca.schema.json")).unwrap().contains("\"MAS\""));
    sandbox.put("mine/ca.schema.json", "precious").ca(&["new", "mine/d.ca.toml"]).is(1).says(&["ca.schema.json"]);
    assert_eq!(fs::read_to_string(sandbox.path("mine/ca.schema.json")).unwrap(), "precious");
}
