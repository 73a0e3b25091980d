//! `ca new`: writes a first model, and the schema that lets an editor help with it.
//!
//! The schema is written beside the model and referenced by a relative path, not by an address or an absolute path. So
//! it matches this build, works without a network, and moves with the folder.

use crate::args::completions;
use crate::load::{self, BUNDLED};
use crate::outcome::{Ended, Failure, Outcome};
use ca_io::{atomic_file, read_limited};
use ca_lab::catalog;
use ca_lab::load::STARTER;
use ca_model::schema;
use ca_model::suggest::nearest;
use clap::Args;
use clap_complete::ArgValueCompleter;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Writes a new model file to start from
///
/// Writes a small commented model of a struck string, or a copy of a bundled model. An existing file is overwritten
/// only with `--force`.
#[derive(Args)]
#[command(after_long_help = "Examples:
  ca new mine.ca.toml
  ca new other.ca.toml --from hammered_string
  ca new other.ca.toml --force")]
pub struct NewArgs {
    /// File to write, `*.ca.toml`
    pub file: PathBuf,
    /// `string`, or the name of a bundled model (`ca list models`)
    #[arg(long, value_name = "NAME", default_value = "string", add = ArgValueCompleter::new(completions::bundled))]
    pub from: String,
    /// Overwrites the file if it exists
    #[arg(long)]
    pub force: bool,
}

/// File name of the JSON Schema, beside the model files.
const SCHEMA: &str = "ca.schema.json";

/// Runs the command.
pub fn run(args: &NewArgs) -> Outcome {
    let text = match (load::bundled(&args.from), args.from.as_str()) {
        (Some(text), _) => text,
        (None, "string") => STARTER,
        (None, word) => {
            let hint = match nearest(word, BUNDLED.iter().map(|m| m.0).chain(["string"])) {
                Some(m) => format!("did you mean `{m}`?"),
                None => "choose `string`, or a model of `ca list models`".into(),
            };
            return Err(Failure::Usage(format!("--from: no bundled model `{word}`; {hint}")));
        }
    };
    write(&args.file, &format!("#:schema ./{SCHEMA}\n{text}"), args.force)?;
    let beside = args.file.with_file_name(SCHEMA);
    describe(&beside)?;
    let file = args.file.display();
    writeln!(std::io::stdout().lock(), "{file} written; to hear it, run\n\n  ca render {file}\n")?;
    Ok(Ended::Well)
}

/// Writes the schema for editors and replaces an older version. Refuses to replace any other file.
fn describe(path: &Path) -> Result<(), Failure> {
    let own = schema::schema(&catalog());
    let read =
        |path| serde_json::from_slice::<serde_json::Value>(&read_limited::text(path, read_limited::MODEL).ok()?).ok();
    let there = path.exists().then(|| read(path).unwrap_or_default());
    if there.is_some_and(|s| s["title"] != own["title"]) {
        let what = format!("`{}` exists and is not a schema of models", path.display());
        return Err(Failure::Failed(format!("{what}: move it away, then run `ca list --schema > {SCHEMA}`")));
    }
    Ok(atomic_file::write(path, format!("{own:#}\n").as_bytes())?)
}

/// Refuses a path without the extension of model files.
pub(super) fn is_model(path: &Path) -> Result<(), Failure> {
    if !path.to_string_lossy().to_ascii_lowercase().ends_with(".ca.toml") {
        let own = path.with_file_name(format!("{}.ca.toml", load::stem(path)));
        let what = format!("`{}`: a model file ends in `.ca.toml`", path.display());
        return Err(Failure::Usage(format!("{what}; name it `{}`", own.display())));
    }
    Ok(())
}

/// Refuses a path without the extension of model files and, unless `force` is true, an existing file.
pub(super) fn may_be(path: &Path, force: bool) -> Result<(), Failure> {
    is_model(path)?;
    if !force && path.symlink_metadata().is_ok() {
        return Err(Failure::Failed(format!("`{}` exists; use `--force` to overwrite it", path.display())));
    }
    Ok(())
}

/// Writes a model file. Overwrites an existing file only if `force` is true.
pub(super) fn write(path: &Path, text: &str, force: bool) -> Result<(), Failure> {
    may_be(path, force)?;
    let write = if force { atomic_file::write } else { atomic_file::write_new };
    Ok(write(path, text.as_bytes())?)
}
