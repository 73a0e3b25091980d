//! Finds the part that a line of `[use]` names, in its file or in another one.
//!
//! The reader does not open files. Its caller provides their content, so that a take can contain them. Paths stay below
//! the folder of the model, so that the folder can be passed on as a whole.

use super::expander::{Expander, Home};
use super::files::SourceFile;
use super::library;
use super::read::first;
use super::shift::{next_file, shift_diags, shift_model};
use crate::diag::Diag;
use crate::model::{Entry, Model, Part, Span, Use, Value};
use crate::suggest::nearest;
use crate::text::file::one_file;
use alloc::format;
use alloc::rc::Rc;
use alloc::string::String;
use alloc::vec::Vec;

impl Expander<'_> {
    /// Returns the part and its file, or `None` after a report.
    pub fn find(&mut self, u: &Use, home: &Rc<Home>) -> Option<(Part, Rc<Home>)> {
        let home = match &u.file {
            Some(e) => self.file(u, e, home)?,
            None => home.clone(),
        };
        let Some(e) = &u.part else {
            self.settings(u, first_place(u), &home);
            let m = &home.model;
            if let (Some(first), true) = (m.parts.first(), m.items.is_empty() && m.uses.is_empty()) {
                let d = Diag::error(
                    "E013",
                    format!("`{}`: `{}` contains only parts, and `part` is missing", u.name, home.file),
                );
                let d = d.at(first_place(u), "which part?");
                self.diags.push(d.help(format!("add `part = \"{}\"`", first.name)));
                return None;
            }
            let body = Model { parts: Vec::new(), ..home.model.clone() };
            return Some((
                Part { name: home.file.clone(), span: u.span, doc: String::new(), props: Vec::new(), body },
                home,
            ));
        };
        let name = text(e);
        if let Some(part) = home.model.parts.iter().find(|p| p.name == name) {
            return Some((part.clone(), home));
        }
        let shipped = library::file(name).filter(|_| u.file.is_none());
        if let Some((file, text)) = shipped {
            let home = self.shipped(file, text)?;
            let part = home.model.parts.iter().find(|p| p.name == name)?.clone();
            return Some((part, home));
        }
        let place = if home.file.is_empty() { "in this model".into() } else { format!("in `{}`", home.file) };
        let d = Diag::error("E013", format!("`{}`: no part `{name}` {place}", u.name)).at(e.span, "unknown");
        let library = library::LIBRARY.iter().map(|p| p.0).filter(|_| u.file.is_none());
        let parts = || home.model.parts.iter().map(|p| p.name.as_str()).chain(library.clone());
        let all: Vec<String> = parts().map(|p| format!("`{p}`")).collect();
        self.diags.push(match nearest(name, parts()) {
            Some(near) => d.help(format!("did you mean `{near}`?")).fix(e.span, format!("\"{near}\"")),
            None if home.model.parts.is_empty() && u.file.is_none() => d.help(format!(
                "declare it in sections such as `[part.{name}.MAS]`, or use a bundled part: {}",
                all.join(", ")
            )),
            None if all.is_empty() => d.help("leave out `part` to use the whole file: it does not define parts"),
            None => d.help(format!("available parts: {}", all.join(", "))),
        });
        None
    }

    /// Returns the file of a bundled part: the text from `open` if available, otherwise the bundled text.
    fn shipped(&mut self, path: String, text: &str) -> Option<Rc<Home>> {
        if let Some(known) = self.files.get(&path) {
            return known.clone();
        }
        let text = (self.open)(&path).unwrap_or_else(|_| text.into());
        Some(self.read(path, text))
    }

    /// Returns the named file, which is read once.
    fn file(&mut self, u: &Use, e: &Entry, home: &Home) -> Option<Rc<Home>> {
        let name = text(e);
        let Some(path) = below(home.folder(), name) else {
            let d = Diag::error("E031", format!("`{}`: `{name}` is not a path inside the folder of the model", u.name));
            let help = "move it into the folder of the model, and write its path relative to this file, with `/` and \
                        without `..`";
            self.diags.push(d.at(e.span, "outside the folder").help(help));
            return None;
        };
        if let Some(known) = self.files.get(&path) {
            return known.clone();
        }
        let text = match (self.open)(&path) {
            Ok(text) => text,
            Err(why) => {
                let d = Diag::error("E031", format!("`{}`: {}", u.name, why.what));
                let here = home.model.parts.iter().any(|p| p.name == name);
                let help = if here {
                    format!("to use the part `{name}` of this file, write `{{ part = \"{name}\" }}`")
                } else {
                    why.help
                };
                self.diags.push(d.at(first_place(u), "cannot be read").help(help));
                self.files.insert(path, None);
                return None;
            }
        };
        Some(self.read(path, text))
    }

    fn read(&mut self, path: String, text: String) -> Rc<Home> {
        let (mut model, mut found) = one_file(&text, &path, self.catalog);
        let start = next_file(&self.model);
        shift_model(&mut model, start);
        shift_diags(&mut found, start);
        self.diags.extend(found);
        self.same_units(&path, &model);
        model.text = String::new();
        self.model.files.push(SourceFile { name: path.clone(), text, start });
        let home = Rc::new(Home { file: path.clone(), model });
        self.files.insert(path, Some(home.clone()));
        home
    }
}

fn first_place(u: &Use) -> Span {
    first(u.file.as_ref(), u.span)
}

fn text(e: &Entry) -> &str {
    if let Value::Text(t) = &e.value { t.trim() } else { "" }
}

/// Returns the path of a file that is named in `folder`, or `None` if it leads out of the folder of the model.
pub(super) fn below(folder: &str, name: &str) -> Option<String> {
    let plain = |w: &str| !matches!(w, "" | "." | "..") && !w.contains(['\\', ':']) && !w.chars().any(char::is_control);
    let words: Vec<&str> = name.strip_prefix("./").unwrap_or(name).split('/').collect();
    words.iter().all(|w| plain(w)).then(|| format!("{folder}{}", words.join("/")))
}
