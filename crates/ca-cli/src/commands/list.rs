//! `ca list`: lists kinds, models and parts of this build.
//!
//! Pages, tables and schema come from the catalog alone, so they are always current.

use crate::args::completions;
use crate::load::{self, BUNDLED};
use crate::outcome::{Ended, Failure, Outcome};
use ca_core::{Catalog, Kind, Role};
use ca_lab::catalog;
use ca_model::page::kind;
use ca_model::page::part as parts;
use ca_model::part::library::shipped;
use ca_model::suggest::nearest;
use ca_model::{Item, Model, Value};
use ca_model::{read, schema};
use clap::Args;
use clap_complete::ArgValueCompleter;
use serde_json::{Value as Json, json};
use std::fmt::Write as _;
use std::io::Write as _;

/// Lists kinds of modules, bundled models and parts, or shows one of them
///
/// Without a name, prints all lists. With the code of a kind, prints its page: equation, parameters with unit and
/// range, sources, and a complete example. With the name of a bundled model or of a part, shows what it is and how to
/// use it.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca list
  ca list BUT
  ca list hammered_string
  ca list plectrum
  ca list kinds --markdown
  ca list --schema > ca.schema.json")]
pub struct ListArgs {
    /// `kinds`, `models`, `parts`, the code of a kind, the name of a bundled model or of a part
    #[arg(add = ArgValueCompleter::new(completions::listed))]
    pub what: Option<String>,
    /// Prints the lists or the page as JSON
    #[arg(long, conflicts_with_all = ["schema", "markdown"])]
    pub json: bool,
    /// Prints the JSON Schema of model files, for editors
    #[arg(long, conflicts_with = "markdown")]
    pub schema: bool,
    /// Prints the table of kinds as Markdown
    #[arg(long)]
    pub markdown: bool,
}

/// Tests whether a role belongs to a family.
type Belongs = fn(&Role) -> bool;

const FAMILIES: [(&str, Belongs); 4] = [
    ("Matter", |r| matches!(r, Role::Mat(_))),
    ("Interactions", |r| matches!(r, Role::Lia(_))),
    ("Ports", |r| matches!(r, Role::Port(_))),
    ("Generators", |r| matches!(r, Role::Generator(_))),
];

/// Runs the command.
pub fn run(args: &ListArgs) -> Outcome {
    let catalog = catalog();
    if args.schema {
        print(&format!("{:#}\n", schema::schema(&catalog)))?;
        return Ok(Ended::Well);
    }
    if args.markdown {
        if !matches!(args.what.as_deref(), None | Some("kinds")) {
            return Err(Failure::Usage("--markdown: the table always has all kinds; leave out the name".into()));
        }
        print(&markdown(&catalog))?;
        return Ok(Ended::Well);
    }
    let text = match args.what.as_deref() {
        None if args.json => pretty(&json!({"kinds": kinds_json(&catalog), "models": models_json(&catalog),
            "parts": parts::all_json(&catalog)})),
        None => format!(
            "{}\nBundled models\n{}\nParts for `[use]`\n{}\n`ca list NAME` shows one of them, e.g. `ca list BUT`; \
             `ca render NAME` renders a model.\n",
            kinds(&catalog),
            models(&catalog),
            parts::all(&catalog)
        ),
        Some("kinds") if args.json => pretty(&kinds_json(&catalog)),
        Some("kinds") => kinds(&catalog),
        Some("models") if args.json => pretty(&models_json(&catalog)),
        Some("models") => models(&catalog),
        Some("parts") if args.json => pretty(&parts::all_json(&catalog)),
        Some("parts") => parts::all(&catalog),
        Some(word) => one(word, &catalog, args.json)?,
    };
    print(&text)?;
    Ok(Ended::Well)
}

fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

fn pretty(v: &Json) -> String {
    format!("{v:#}\n")
}

/// Returns the pages of everything called `word`; in JSON, a page or a list of pages.
///
/// Names as written come before a kind that matches only in upper case: `bow` finds the part first, then the kind BOW.
fn one(word: &str, catalog: &Catalog, json: bool) -> Result<String, Failure> {
    let mut pages: Vec<(String, Json)> = Vec::new();
    let of_kind = |code: &str| catalog.get(code).map(|k| (kind::text(k), kind::json(k)));
    pages.extend(of_kind(word));
    if let Some((part, header)) = shipped(word, catalog) {
        pages.push((parts::text(&part, &header), parts::json(&part, &header)));
    }
    if let Some(text) = load::bundled(word) {
        let model = read::read(text, word, catalog).0;
        pages.push((about(word, &model), model_json(word, &model)));
    }
    let upper = word.to_ascii_uppercase();
    if upper != word {
        pages.extend(of_kind(&upper));
    }
    if !pages.is_empty() {
        let (texts, mut values): (Vec<String>, Vec<Json>) = pages.into_iter().unzip();
        let value = if values.len() == 1 { values.remove(0) } else { Json::Array(values) };
        return Ok(if json { pretty(&value) } else { texts.join("\n\n") });
    }
    let hint = match nearest(word, completions::pages(catalog).into_iter()) {
        Some(m) => format!("did you mean `{m}`?"),
        None => "`ca list` shows all names".into(),
    };
    Err(Failure::Usage(format!("`{word}` is not a kind, a bundled model or a part; {hint}")))
}

fn kinds(catalog: &Catalog) -> String {
    let (mut out, widest) = (String::new(), |f: fn(&Kind) -> usize| catalog.iter().map(f).max().unwrap_or(0));
    let (a, b) = (widest(|k| k.code.len()), widest(|k| k.title.chars().count()));
    for (family, is) in FAMILIES {
        let _ = writeln!(out, "{family}");
        for k in catalog.iter().filter(|k| is(&k.role)) {
            let _ = writeln!(out, "  {:<a$}  {:<b$}  {}", k.code, k.title, k.equation);
        }
    }
    out
}

fn kinds_json(catalog: &Catalog) -> Json {
    Json::Array(catalog.iter().map(|k| json!({"code": k.code, "title": k.title, "equation": k.equation})).collect())
}

fn models(catalog: &Catalog) -> String {
    let all: Vec<(&str, Model)> =
        BUNDLED.iter().map(|(name, text)| (*name, read::read(text, name, catalog).0)).collect();
    let by: Vec<String> = all.iter().map(|(_, model)| played(model).join(", ")).collect();
    let width = all.iter().map(|m| m.0.len()).max().unwrap_or(0);
    let wide = by.iter().map(String::len).max().unwrap_or(0);
    let line =
        |((name, model), by): (&(&str, Model), &String)| format!("  {name:<width$}  {by:<wide$}  {}\n", model.title());
    let mut out: String = all.iter().zip(&by).map(line).collect();
    out += "docs/instruments.md has the sound, the spectrogram and the measured pitch and decay of each.\n";
    out
}

/// Returns the ways to play a model: device ports, MIDI notes, its gesture, or by itself.
fn played(model: &Model) -> Vec<&'static str> {
    let mut by = Vec::new();
    let ports = || model.items.iter().filter(|i| i.kind == "TGR");
    let of = |i: &Item, device: &str| {
        i.args.iter().any(|e| e.key == "device" && matches!(&e.value, Value::Text(t) if t.starts_with(device)))
    };
    if ports().any(|i| of(i, "tgr")) {
        by.push("TGR keys");
    }
    if ports().any(|i| !of(i, "tgr")) {
        by.push("device");
    }
    if model.items.iter().any(|i| i.args.iter().any(|e| e.key == "midi")) {
        by.push("MIDI");
    }
    if !model.gestures.is_empty() {
        by.push("gesture");
    }
    if by.is_empty() {
        by.push("by itself");
    }
    by
}

fn models_json(catalog: &Catalog) -> Json {
    let one = |(name, text): &(&str, &str)| {
        let model = read::read(text, name, catalog).0;
        json!({"name": name, "title": model.title(), "played": played(&model)})
    };
    Json::Array(BUNDLED.iter().map(one).collect())
}

fn model_json(name: &str, model: &Model) -> Json {
    json!({"name": name, "title": model.title(), "about": model.header, "text": model.text})
}

fn about(name: &str, model: &Model) -> String {
    format!(
        "{name}: {}\n\n{}\n\n  ca render {name}\n  ca check {name}\n  ca new mine.ca.toml --from {name}\n",
        model.title(),
        model.header
    )
}

/// Generates the table for the documentation.
fn markdown(catalog: &Catalog) -> String {
    let mut out = String::new();
    for (family, is) in FAMILIES {
        let _ =
            writeln!(out, "### {family}\n\n| kind | what | equation | parameters | source |\n|---|---|---|---|---|");
        for k in catalog.iter().filter(|k| is(&k.role)) {
            out += &row(k);
        }
        out.push('\n');
    }
    out.truncate(out.trim_end().len());
    out + "\n"
}

fn row(k: &Kind) -> String {
    let params: Vec<String> = k.params.iter().map(|p| format!("`{}`", p.name)).collect();
    let cell = |s: &str| s.replace('|', "\\|");
    format!(
        "| {} | {} | `{}` | {} | {} |\n",
        k.code,
        cell(k.title),
        cell(k.equation),
        params.join(" "),
        k.source.join(", ")
    )
}
