//! A model with its findings and the content of the files it names: all input of the compiler.
//!
//! The file name extension decides the format: one of [`ca_import::FORMATS`], or else a model file.

use crate::error::{Error, Found};
use ca_compile::load::finish;
use ca_compile::{Compiled, Options};
use ca_core::internal::kind::cloud::{Clouds, Unread};
use ca_core::{Catalog, Laws, Real};
use ca_import::Format;
use ca_io::error::FileErrorKind;
use ca_io::{FileError, read_limited};
use ca_model::diag::Diags;
use ca_model::printable::printable;
use ca_model::render::line_column;
use ca_model::{Model, read};
use std::path::Path;

/// Returns all kinds: run-time, generators, and LPR.
pub fn catalog() -> Catalog {
    ca_model::catalog().with(ca_lpr::KINDS)
}

/// Returns the functions over `R` of all laws, for [`Scene::bind`](crate::Scene::bind).
pub fn laws<R: Real>() -> Laws<R> {
    ca_core::internal::phi::laws().with(ca_lpr::laws())
}

/// Loads and compiles a model.
///
/// # Errors
/// [`Error::File`] if the file cannot be read, [`Error::Model`] if the model has errors.
pub fn load(path: impl AsRef<Path>) -> Result<Compiled, Error> {
    Ok(Loaded::open(path)?.compile(&Options::default())?)
}

/// Model with the findings of its reader.
#[derive(Clone)]
pub struct Loaded {
    /// The model.
    pub model: Model,
    /// Findings of the reader.
    pub diags: Diags,
    /// File name without folder and extension.
    pub name: String,
    /// Content of the files that the model names.
    pub clouds: Clouds,
    /// Format of the other program that the model was imported from.
    pub format: Option<&'static Format>,
}

impl Loaded {
    /// Reads a model from its file, and the files it names, which are looked up beside it.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is not UTF-8, or is larger than any model. [`Loaded::diags`] has model errors.
    pub fn open(path: impl AsRef<Path>) -> Result<Loaded, FileError> {
        let path = path.as_ref();
        let file = path.to_string_lossy();
        Ok(match ca_import::of(&file) {
            Some(_) => Loaded::import(&foreign_text(path)?, &file),
            None => Loaded::read(&text(path)?, &file),
        })
    }

    /// Reads a model from its text. `file` is its name in reports; the files it names are looked up beside `file`.
    pub fn read(text: &str, file: &str) -> Loaded {
        let folder = Path::new(file).parent().unwrap_or(Path::new("")).to_owned();
        Loaded::read_with(text, file, &mut |name| part(&folder, name))
    }

    /// Reads a model from its text; `open` returns the texts of the files that it takes parts from.
    pub fn read_with(text: &str, file: &str, open: &mut dyn FnMut(&str) -> Result<String, Unread>) -> Loaded {
        let (model, diags) = read::read_with(text, file, &catalog(), open);
        Loaded::found(model, diags, file)
    }

    /// Imports a model from the text of another program, see [`ca_import::assumed`]. With errors, the model is empty
    /// except for the text that they point into.
    pub fn import(text: &str, file: &str) -> Loaded {
        let (mut model, diags) = (ca_import::assumed(file).import)(text, file);
        if diags.has_errors() {
            model = Model { file: file.into(), text: text.into(), ..Model::default() };
        }
        Loaded { format: Some(ca_import::assumed(file)), ..Loaded::found(model, diags, file) }
    }

    /// Takes a model that was built by a program.
    pub fn built(model: Model) -> Loaded {
        Loaded::found(model, Diags::new(), "")
    }

    fn found(model: Model, diags: Diags, file: &str) -> Loaded {
        let name = printable(&stem(Path::new(file)));
        let mut loaded = Loaded { name, clouds: Clouds::new(), format: None, model, diags };
        loaded.look();
        loaded
    }

    /// Reads the named files that were not read yet, after a change of the model; their paths start from its folder.
    pub fn look(&mut self) {
        let (model, kinds) = (&self.model, catalog());
        if ca_io::cloud::named(model, &kinds).into_iter().any(|name| !self.clouds.contains_key(name)) {
            let folder = Path::new(&model.file).parent().unwrap_or(Path::new(""));
            let read = ca_io::cloud::of_model(model, &kinds, folder);
            self.clouds = read.into_iter().chain(std::mem::take(&mut self.clouds)).collect();
        }
    }

    /// Compiles the model with its own [`Options::clouds`], and merges findings of reader and compiler by place.
    ///
    /// # Errors
    /// Returns all findings if one of them is an error.
    pub fn compile(&self, options: &Options) -> Result<Compiled, Box<Found>> {
        let options = Options { clouds: self.clouds.clone(), ..options.clone() };
        finish(&self.model, self.diags.clone(), &catalog(), &options)
            .map_err(|diags| Box::new(Found { model: self.model.clone(), diags }))
    }
}

fn part(folder: &Path, name: &str) -> Result<String, Unread> {
    let path = folder.join(name);
    let unread = |what: &str, help: &str| Unread { what: format!("`{name}`: {what}"), help: help.into() };
    // reading a pipe would block; `text` reports a missing file
    if path.metadata().is_ok_and(|m| !m.is_file()) {
        return Err(unread("it is not a regular file", "name a model file in the same folder"));
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    if let (Ok(real), Ok(here)) = (path.canonicalize(), here.canonicalize()) {
        if !real.starts_with(here) {
            return Err(unread("it is outside the folder of the model", "copy the file into the folder of the model"));
        }
    }
    text(&path).map_err(|e| {
        let what = FileError { fix: String::new(), ..e.clone() }.to_string();
        Unread { what, help: if e.fix.is_empty() { "put it into the folder of the model".into() } else { e.fix } }
    })
}

/// Reads the text of a model file of another program.
///
/// # Errors
/// Fails if it cannot be read.
pub fn foreign_text(path: &Path) -> Result<String, FileError> {
    let format = ca_import::assumed(&path.to_string_lossy());
    Ok((format.decode)(read_limited::text(path, read_limited::MODEL)?))
}

/// Reads the text of a model file.
///
/// # Errors
/// Fails if it cannot be read, or is not UTF-8; the error has line and column.
pub fn text(path: &Path) -> Result<String, FileError> {
    utf8(read_limited::text(path, read_limited::MODEL)?, path)
}

/// Converts bytes to text. Messages call the file `name`.
///
/// # Errors
/// Fails if they are not UTF-8; the error has line and column.
pub fn utf8(bytes: Vec<u8>, name: &Path) -> Result<String, FileError> {
    String::from_utf8(bytes).map_err(|e| {
        let good = e.as_bytes().get(..e.utf8_error().valid_up_to()).unwrap_or_default();
        let good = String::from_utf8_lossy(good);
        let (line, column) = line_column(&good, good.len());
        let what = format!("it is not UTF-8 text from line {line}, column {column} on");
        FileError::new(FileErrorKind::Format, what).file(name.display()).fix("save it as UTF-8")
    })
}

/// Returns the file name without extension: `a/b/gut.ca.toml` → `gut`.
pub fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let lower = name.to_ascii_lowercase();
    let own = [".ca.toml", ".toml"].into_iter().find(|e| lower.ends_with(e)).map(str::len);
    let cut = own.or_else(|| ca_import::of(&lower).map(|f| f.extension.len() + 1)).unwrap_or(0);
    name[..name.len() - cut].to_owned()
}
