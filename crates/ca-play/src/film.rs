//! The script of a picture without a server: the modules of the page that draw, as one text.
//!
//! Decides for the same modules as the page has, joined by leaving out what imports and exports them: each has its names for
//! itself, and a page that is one file cannot import.

use crate::asset;

/// In the order in which they need each other.
const MODULES: [&str; 6] = [
    "picture/colour.js",
    "picture/shaders.js",
    "picture/scene.js",
    "picture/camera.js",
    "picture/gl.js",
    "picture/film.js",
];

/// One script, to stand in a page with the elements that `film.js` names.
pub fn script() -> String {
    let mut text = String::from("\"use strict\";\n(() => {\n");
    let modules = MODULES.iter().filter_map(|name| asset::find(name)).map(|a| String::from_utf8_lossy(a.bytes));
    for module in modules {
        for line in module.lines().filter(|l| !l.starts_with("import ")) {
            text += line.strip_prefix("export ").unwrap_or(line);
            text.push('\n');
        }
    }
    text + "})();\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_modules_are_in_it_and_nothing_imports() {
        let text = script();
        for what in ["class Scene", "class Camera", "class Picture", "const MASS", "kindColour", "class Film"] {
            assert_eq!(text.matches(&format!("\n{what}")).count().max(text.matches(what).count().min(1)), 1, "{what}");
        }
        assert!(!text.contains("\nimport ") && !text.contains("\nexport ") && !text.contains("</script"));
    }
}
