//! Finds a model by a word, and sets its parameters.
//!
//! A word for a model is the name of a file or, without such a file, of a bundled model. The message for an unknown
//! word suggests the nearest name.

use crate::Failure;
use ca_compile::{Compiled, Options};
use ca_core::Scene;
use ca_core::internal::kind::cloud::Unread;
use ca_core::internal::scene::PRESET;
pub use ca_io::error::reason;
use ca_model::diag::{Diags, Severity};
use ca_model::part::instances;
use ca_model::part::library::is_shipped;
use ca_model::render::line_column;
pub use ca_model::suggest::listed as ticked;
use ca_model::suggest::nearest;
use ca_model::{Entry, Item, Model, Span, Value, in_list, read, write};
pub use cordis_anima::loaded::{foreign_text, stem, text, utf8};
pub use cordis_anima::{Loaded, catalog};
use std::path::Path;

include!(concat!(env!("OUT_DIR"), "/bundled.rs"));

/// Text of the model that `ca new` writes.
pub const STARTER: &str = include_str!("starter.ca.toml");

/// Returns the text of a bundled model.
pub fn bundled(name: &str) -> Option<&'static str> {
    BUNDLED.iter().find(|m| m.0 == name).map(|m| m.1)
}

/// Returns whether a path has this extension, ignoring case.
pub fn has_extension(path: &Path, ext: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ext))
}

/// Loads the model that a word means.
///
/// # Errors
/// [`Failure::Usage`] where there is none of that name; [`Failure::Failed`] where its file cannot be read. Errors in
/// its text are in [`Loaded::diags`].
pub fn load(word: &str) -> Result<Loaded, Failure> {
    let path = Path::new(word);
    // a folder does not hide a bundled model of the same name
    if path.exists() && !(path.is_dir() && bundled(word).is_some()) {
        Ok(Loaded::open(path)?)
    } else if let Some(text) = bundled(word) {
        Ok(Loaded::read(text, &format!("{word}.ca.toml")))
    } else {
        Err(Failure::Usage(no_model(word)))
    }
}

/// Reads a model again as its author wrote it, with the stored texts of the files it takes parts from.
pub fn read_again(model: &Model) -> Loaded {
    read_other(model, &model.text)
}

/// Returns the paths, from the folder of the model, of the files it takes parts from, including unreadable ones.
pub fn part_files(model: &Model) -> Vec<String> {
    let asked = model.uses.iter().filter_map(|u| match &u.file.as_ref()?.value {
        Value::Text(t) => Some(t.trim().to_owned()),
        _ => None,
    });
    let mut all: Vec<String> =
        model.files.iter().map(|f| f.name.clone()).chain(asked).filter(|f| !is_shipped(f)).collect();
    all.sort();
    all.dedup();
    all
}

/// Returns the text of a model as a model file: as its author wrote it, or, for a model of another program, its
/// conversion.
pub fn own_text(loaded: &Loaded) -> String {
    let model = &loaded.model;
    if loaded.format.is_some() || model.text.is_empty() { write::write(model) } else { model.text.clone() }
}

/// Checks that the text of a model is all of it, as a page without files needs.
///
/// # Errors
/// [`Failure::Failed`] if it takes parts or points from other files.
pub fn needs_no_files(loaded: &Loaded) -> Result<(), Failure> {
    if part_files(&loaded.model).is_empty() && loaded.clouds.is_empty() {
        return Ok(());
    }
    let what = "the model takes parts or points from other files, which a page cannot read; copy them into the model";
    Err(Failure::Failed(what.into()))
}

/// Reads a changed text with the stored texts of the part files.
fn read_other(model: &Model, text: &str) -> Loaded {
    Loaded::read_with(text, &model.file, &mut |name| {
        let known = model.files.iter().find(|f| f.name == name);
        let missing = || Unread { what: format!("no stored text of `{name}`"), help: "read the model again".into() };
        known.map(|f| f.text.clone()).ok_or_else(missing)
    })
}

/// Returns a model with a changed text and the stored texts of its files.
#[must_use]
pub fn reread(loaded: &Loaded, text: &str) -> Loaded {
    let Loaded { model, diags, .. } = read_other(&loaded.model, text);
    Loaded { model, diags, name: loaded.name.clone(), clouds: loaded.clouds.clone(), format: None }
}

fn no_model(word: &str) -> String {
    let path = Path::new(word);
    if path.is_symlink() {
        return format!(
            "`{word}` is a symbolic link that does not lead to a file; give the path of the file, or recreate the link"
        );
    }
    let like_a_file = word.contains(['/', '\\']) || path.extension().is_some();
    let files: Vec<String> = path
        .parent()
        .map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p })
        .and_then(|p| std::fs::read_dir(p).ok())
        .into_iter()
        .flatten()
        .flatten()
        .map(|f| path.with_file_name(f.file_name()).to_string_lossy().into_owned())
        .filter(|f| Path::new(f).is_file() && (f.ends_with(".ca.toml") || ca_import::of(f).is_some()))
        .collect();
    let own = format!("{word}.ca.toml");
    let names = BUNDLED.iter().map(|m| m.0);
    let meant = if files.contains(&own) {
        Some(own.as_str())
    } else {
        nearest(word, files.iter().map(String::as_str)).or_else(|| nearest(&stem(path), names))
    };
    let what = if like_a_file { "no such file" } else { "no file or bundled model has this name" };
    match meant {
        Some(m) => format!("`{word}`: {what}; did you mean `{m}`?"),
        None => format!("`{word}`: {what}; `ca list models` (in Python `examples.names()`) lists the bundled models"),
    }
}

/// Sets a parameter as [`Model::put`] does, and reads the files it then names; `key[*].f` sets it for each instance.
///
/// # Errors
/// [`Failure::Usage`] with the nearest name where the parameter does not exist.
pub fn set(loaded: &mut Loaded, name: &str, value: Value) -> Result<(), Failure> {
    if let Some(each) = instances(&loaded.model, name) {
        return each.iter().try_for_each(|name| set(loaded, name, value.clone()));
    }
    let model = &mut loaded.model;
    if let Some((owner, key)) = name.rsplit_once('.') {
        let known: Option<Vec<&str>> = match owner {
            "model" => Some(read::META.to_vec()),
            "rate" => Some(read::RATES.to_vec()),
            _ => model.items.iter().find(|i| i.name == owner).and_then(|i| keys(i)),
        };
        if let Some(keys) = known {
            if !keys.contains(&in_list(key).0) {
                let meant = nearest(key, keys.iter().copied());
                let hint = meant.map_or_else(
                    || format!("it has {}", ticked(keys.iter().copied())),
                    |m| format!("did you mean `{owner}.{m}`?"),
                );
                return Err(Failure::Usage(format!("`{owner}` has no parameter `{key}`; {hint}")));
            }
        }
    }
    let preset = (name == PRESET).then(|| value.shown());
    if model.put(name, value) {
        loaded.look();
        return Ok(());
    }
    if let Some(word) = preset {
        let names = || model.presets.iter().map(|p| p.key.as_str());
        let hint = match nearest(&word, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if model.presets.is_empty() => "the model has no presets; add one below `[preset.NAME]`".into(),
            None => format!("the presets are {}", ticked(names())),
        };
        return Err(Failure::Usage(format!("`{word}` is not a preset of this model; {hint}")));
    }
    if let Some(what) = of_group(model, name).or_else(|| of_member(model, name)) {
        return Err(Failure::Usage(what));
    }
    let mut all: Vec<String> = model.params.iter().map(|e| e.key.clone()).collect();
    for i in &model.items {
        all.extend(keys(i).into_iter().flatten().map(|k| format!("{}.{k}", i.name)));
    }
    let hint = match nearest(name, all.iter().map(String::as_str)) {
        Some(m) => format!("did you mean `{m}`?"),
        None if name.contains('.') || model.params.is_empty() => {
            format!("its modules are {}", ticked(model.items.iter().map(|i| i.name.as_str())))
        }
        None => format!("its parameters are {}", ticked(model.params.iter().map(|e| e.key.as_str()))),
    };
    Err(Failure::Usage(format!("the model has no `{name}`; {hint}")))
}

/// Returns the file and line of a place in the text of a model; `None` for a model without text.
fn place(model: &Model, span: Span) -> Option<String> {
    let source = model.source(span);
    let known = span.is_some() && !source.text.is_empty();
    known.then(|| format!("{}:{}", source.file, line_column(source.text, source.to_text_span(span).start).0))
}

/// Message for an attempt to set one of the modules that come from one line.
fn of_member(model: &Model, name: &str) -> Option<String> {
    let (line, rest) = name.split_once('[')?;
    let item = model.items.iter().find(|i| i.name == line)?;
    let key = rest.split_once("].").map_or("", |(_, key)| key);
    let whole = keys(item).is_some_and(|all| all.contains(&key));
    let fix = if whole { format!("; `{line}.{key}` sets it for all of them") } else { String::new() };
    Some(format!("`{name}`: the modules of `{line}` share one line and cannot be set separately{fix}"))
}

/// Message for an attempt to set a property of a group, which is not a parameter.
fn of_group(model: &Model, name: &str) -> Option<String> {
    let (owner, key) = name.rsplit_once('.')?;
    let group = model.groups.iter().find(|g| g.name == owner && read::GROUP.contains(&key))?;
    let what = format!("`{key}` of the group `{owner}` can only be changed in the file");
    Some(match group.props.iter().find(|e| e.key == key).and_then(|e| place(model, e.key_span)) {
        Some(at) => format!("{what}; it is at {at}"),
        None => match place(model, group.span) {
            Some(at) => format!("{what}; add it below `[{owner}]`, {at}"),
            None => what,
        },
    })
}

/// As [`set`], from typed text: a number, a quantity, a flag or a word.
///
/// # Errors
/// As [`set`], and [`Failure::Usage`] for a list, with the place where it can be written.
pub fn set_typed(loaded: &mut Loaded, name: &str, text: &str) -> Result<(), Failure> {
    if let Some(each) = instances(&loaded.model, name) {
        return each.iter().try_for_each(|name| set_typed(loaded, name, text));
    }
    let model = &loaded.model;
    let (owner, key) = name.rsplit_once('.').unwrap_or(("", name));
    // a title may begin with a bracket
    if text.trim_start().starts_with('[') && owner != "model" {
        let item = model.items.iter().find(|i| i.name == owner);
        let args: &[Entry] = item.map_or(&model.params, |i| &i.args);
        let written = args.iter().find(|e| e.key == key).map(|e| e.key_span).or(item.map(|i| i.name_span));
        if let Some(span) = written {
            let at = place(model, span).map(|at| format!(", {at}")).unwrap_or_default();
            let what = format!("`{name}`: a list such as `{}` cannot be set this way", text.trim());
            return Err(Failure::Usage(format!("{what}; write it in the file{at}")));
        }
    }
    set(loaded, name, Value::typed(text))
}

fn keys(item: &Item) -> Option<Vec<&'static str>> {
    Some(catalog().get(&item.kind)?.params.iter().map(|p| p.name).collect())
}

/// Compiles a model and returns the findings of reader and compiler, in order of place and without duplicates.
pub fn compiled(loaded: &Loaded, options: &Options) -> (Option<Scene>, Diags) {
    match loaded.compile(options) {
        Ok(Compiled { scene, findings, .. }) => (Some(scene), findings),
        Err(found) => (None, found.diags),
    }
}

/// Number of warnings among the findings.
pub fn warnings(diags: &Diags) -> usize {
    diags.count(Severity::Warning)
}
