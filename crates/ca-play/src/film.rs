//! Script of the moving picture for pages without a server: the drawing modules of the page, as one text.
//!
//! The modules are the files of the page without their `import` and `export` keywords, since a page in one file cannot
//! import. This works because no two modules define the same name.

use crate::asset;

/// Modules in the order of their dependencies.
const MODULES: [&str; 6] = [
    "picture/colour.js",
    "picture/shaders.js",
    "picture/scene.js",
    "picture/camera.js",
    "picture/gl.js",
    "picture/film.js",
];

/// Returns the script. Its page needs the elements that `film.js` names.
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
