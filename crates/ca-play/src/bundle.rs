//! The modules of the page as one script, for pages that cannot import: a single file, an audio worklet from a blob.
//!
//! The modules are written for it: an `import` is one line that names a file of the page, and an `export` stands before
//! a declaration. Each module becomes a function that returns its exports, so that two modules may use one name.

use crate::asset;
use std::fmt::Write as _;

/// Returns the script of a module of the page and of all that it imports.
///
/// # Panics
/// If a module imports a file that is not part of the page. A test bundles every page.
pub fn bundle(root: &str) -> String {
    let mut all = Bundle { text: String::from("\"use strict\";\n(() => {\nconst modules = {};\n"), done: Vec::new() };
    all.add(root);
    all.text + "})();\n"
}

struct Bundle {
    text: String,
    done: Vec<String>,
}

impl Bundle {
    fn add(&mut self, name: &str) {
        if self.done.iter().any(|n| n == name) {
            return;
        }
        let asset = asset::find(name).unwrap_or_else(|| panic!("the page lacks the module `{name}`"));
        let source = String::from_utf8_lossy(asset.bytes);
        let (mut body, mut exports) = (String::new(), Vec::new());
        for line in source.lines() {
            if let Some((names, from)) = line.strip_prefix("import ").and_then(|l| l.split_once(" from ")) {
                let from = beside(name, from.trim_matches(|c| "\"';".contains(c)));
                self.add(&from);
                let _ = writeln!(body, "const {names} = modules[\"{from}\"];");
            } else if let Some(list) = line.strip_prefix("export {") {
                let names = list.trim_end_matches([';', '}', ' ']).split(',').map(str::trim);
                exports.extend(names.filter(|n| !n.is_empty()));
            } else if let Some(declaration) = line.strip_prefix("export ") {
                exports.extend(declared(declaration));
                let _ = writeln!(body, "{declaration}");
            } else {
                let _ = writeln!(body, "{line}");
            }
        }
        let _ =
            write!(self.text, "modules[\"{name}\"] = (() => {{\n{body}return {{ {} }};\n}})();\n", exports.join(", "));
        self.done.push(name.into());
    }
}

/// Returns the path of a module that `name` imports as `from`.
fn beside(name: &str, from: &str) -> String {
    let mut folders: Vec<&str> = name.split('/').collect();
    folders.pop();
    for part in from.split('/') {
        match part {
            "." => {}
            ".." => {
                folders.pop();
            }
            part => folders.push(part),
        }
    }
    folders.join("/")
}

/// Returns the name that a line declares.
fn declared(line: &str) -> Option<&str> {
    let words = ["async function ", "function ", "class ", "const ", "let "];
    let rest = words.iter().find_map(|w| line.strip_prefix(w))?;
    rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_page_is_one_script_without_imports() {
        for root in ["main.js", "picture/film.js", "browser/worklet.js", "browser/compiler-worker.js"] {
            let text = bundle(root);
            assert!(!text.contains("\nimport ") && !text.contains("\nexport ") && !text.contains("</script"), "{root}");
            assert!(text.contains(" = modules[\""), "{root}");
        }
        let film = bundle("picture/film.js");
        assert!(film.find("modules[\"picture/colour.js\"] =") < film.find("modules[\"picture/film.js\"] ="));
        assert!(
            film.contains("return { Scene };")
                && bundle("main.js").contains("return { Slider, Parameters, ports, element };")
        );
    }

    #[test]
    fn paths_of_imports_are_found() {
        assert_eq!(beside("browser/a.js", "../b.js"), "b.js");
        assert_eq!(beside("main.js", "./picture/gl.js"), "picture/gl.js");
    }
}
