//! Tests the pages of `docs/`: generated parts are up to date, and statements are true.

use super::commands;
#[cfg(unix)]
use crate::sandbox::peak;
use crate::sandbox::{Sandbox, blocks, from_root};
use std::fs;
use std::path::{Path, PathBuf};

const INTRO: &str = "# Kinds of modules

After this page you can choose a kind of module by its equation, and name its parameters.

Made by `ca list --markdown`: do not edit. `ca list BUT` shows the whole page of a kind: each parameter with its unit,
range and default, the sources in full, and an example that sounds. `e` is the elongation of a link, second end minus
first, and `F` its force, positive where it pulls; `x1` is the position one tick before, `T` the tick, `f` the summed
force. [The language pages](language/README.md) explain how to write a model file.

";

/// Compares a generated page with its file, which `UPDATE=1` writes.
fn fresh(page: &str, want: &str) {
    let path = from_root(page);
    if std::env::var_os("UPDATE").is_some() {
        fs::write(&path, want).unwrap();
    }
    let is = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        is == want,
        "{page} is stale; run `UPDATE=1 cargo test $ALL --test cli -- docs` ($ALL is in CONTRIBUTING.md) and look at what changed"
    );
}

#[test]
fn the_page_of_kinds_is_fresh() {
    fresh("docs/kinds.md", &format!("{INTRO}{}", Sandbox::new().ca(&["list", "--markdown"]).is(0).out));
}

#[test]
fn the_page_of_commands_is_fresh() {
    let sandbox = Sandbox::new();
    let help = |words: &[&str]| sandbox.with(&[("COLUMNS", "100")], &[&["help"][..], words].concat()).is(0).out;
    fresh("docs/commands.md", &commands::page(help));
}

/// Pages about the language of models, with their texts.
fn language() -> Vec<(PathBuf, String)> {
    let files = markdown(&from_root("docs/language")).into_iter();
    files.map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect()
}

#[test]
fn the_examples_of_the_format_are_models_without_findings() {
    let sandbox = Sandbox::new();
    let mut seen = 0;
    for (path, page) in language() {
        let models = blocks(&page, "toml");
        assert!(!models.is_empty() || path.ends_with("README.md"), "{}: no example", path.display());
        for (_, model) in &models {
            sandbox.put("example.ca.toml", model);
            let r = sandbox.ca(&["render", "example.ca.toml", "--seconds", "2"]).is(0);
            assert_eq!(r.err, "", "{model}");
            let check = sandbox.ca(&["check", "example.ca.toml"]).is(0);
            assert_eq!(check.err, "", "{model}");
        }
        seen += models.len();
    }
    assert!(seen >= 20, "only {seen} examples were found");
}

#[test]
fn the_pages_of_the_format_name_all_there_is() {
    use ca_model::read::{GROUP, META, RATES, SECTIONS};
    let page: String = language().into_iter().map(|(_, text)| text).collect();
    for word in META.iter().chain(RATES).chain(GROUP) {
        assert!(page.contains(&format!("`{word}`")), "the pages do not know `{word}`");
    }
    for section in SECTIONS {
        assert!(page.contains(&format!("`[{section}]`")), "the pages do not know `[{section}]`");
    }
}

/// The page about devices lists every key of a profile outside the guard, with its default.
#[test]
fn the_page_of_devices_has_the_keys_of_profiles() {
    let page = std::fs::read_to_string(from_root("docs/devices.md")).unwrap();
    let least = serde_json::json!({ "name": "x", "title": "x", "source": "x", "dof": 1, "range": [0, 1], "force": 1 });
    let profile: ca_haptic::profile::Profile = serde_json::from_value(least.clone()).unwrap();
    let all = serde_json::to_value(profile).unwrap();
    let own = all.as_object().unwrap().iter().filter(|(key, _)| !["guard", "body"].contains(&key.as_str()));
    for (key, default) in own.chain(all["body"].as_object().unwrap()) {
        let row = page.lines().find(|l| l.starts_with(&format!("| `{key}` |")));
        let row = row.unwrap_or_else(|| panic!("`{key}` is not on the page"));
        let cell = row.trim_end_matches('|').rsplit('|').next().unwrap().trim();
        if default.is_null() || least.get(key).is_some() {
            assert!(cell.parse::<f64>().is_err(), "{row}");
        } else {
            assert_eq!(cell.parse::<f64>().ok(), default.as_f64(), "{row}");
        }
    }
}

/// The page about safety lists every number of the guard with its default and every cause by name. The README links to
/// the page.
#[test]
fn the_page_of_safety_has_the_numbers_of_the_guard() {
    let page = std::fs::read_to_string(from_root("docs/safety.md")).unwrap();
    let defaults = serde_json::to_value(ca_haptic::profile::Limits::default()).unwrap();
    let mut seen = 0;
    for (name, value) in defaults.as_object().unwrap() {
        // values such as the band and the stiffness of an edge are not set by users
        let Some(row) = page.lines().find(|l| l.contains(&format!("| `{name}` |"))) else {
            assert!(value.is_null() || value.is_array(), "`{name}` is not on the page");
            continue;
        };
        let cell = row.trim_end_matches('|').rsplit('|').next().unwrap().trim();
        let first = cell.split(' ').next().unwrap();
        match value {
            serde_json::Value::Number(n) => {
                assert_eq!(first.parse::<f64>().ok(), n.as_f64(), "{row}");
                seen += 1;
            }
            serde_json::Value::Bool(b) => assert_eq!(first, b.to_string(), "{row}"),
            _ => {}
        }
    }
    assert!(seen >= 12, "{seen}");
    for cause in ca_haptic::frame::CAUSES {
        assert!(page.contains(cause.name()), "{cause:?}");
    }
    for words in ["cannot replace a switch", "Hands off", "who calibrated"] {
        assert!(page.contains(words), "{words}");
    }
    assert!(std::fs::read_to_string(from_root("README.md")).unwrap().contains("docs/safety.md"));
}

/// Markdown files of a folder, in the order of their names.
pub fn markdown(folder: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let mut files: Vec<PathBuf> = files.filter(|p| p.extension().is_some_and(|e| e == "md")).collect();
    files.sort();
    files
}

/// Pages of `docs/`, including those written by benches.
fn pages() -> Vec<PathBuf> {
    ["docs", "docs/language", "docs/measured"].iter().flat_map(|folder| markdown(&from_root(folder))).collect()
}

/// Each page begins with what its reader can do after it. A long page has a table of contents, which names its sections.
#[test]
fn pages_begin_with_what_their_readers_can_do() {
    for path in markdown(&from_root("docs")).into_iter().chain(markdown(&from_root("docs/language"))) {
        let text = fs::read_to_string(&path).unwrap();
        let first = text.lines().skip(1).find(|l| !l.is_empty()).unwrap_or_default();
        assert!(first.starts_with("After this page you "), "{}: {first}", path.display());
    }
    for (path, page) in language().iter().filter(|(path, _)| !path.ends_with("README.md")) {
        for anchor in anchors(page).iter().skip(1) {
            assert!(page.contains(&format!("](#{anchor})")), "{}: #{anchor} is not in its contents", path.display());
        }
    }
}

/// Anchors of the headings of a page, as GitHub makes them.
fn anchors(page: &str) -> Vec<String> {
    let mut code = false;
    let is_heading = |line: &&str| {
        code ^= line.starts_with("```");
        !code && line.starts_with('#')
    };
    let anchor = |line: &str| {
        let text = line.trim_start_matches('#').trim().to_lowercase();
        let kept = text.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    page.lines().filter(is_heading).map(anchor).collect()
}

#[test]
fn the_index_of_the_documents_names_every_page() {
    let index = fs::read_to_string(from_root("docs/README.md")).unwrap();
    let root = from_root("docs");
    for page in pages().iter().filter_map(|p| p.strip_prefix(&root).ok()).filter(|p| *p != Path::new("README.md")) {
        let name = page.to_string_lossy();
        assert!(index.contains(&format!("]({name})")), "docs/README.md does not name {name}");
    }
}

/// Links between pages lead to existing files and sections. External links are not checked.
#[test]
fn links_between_documents_lead_somewhere() {
    let mut pages = pages();
    pages.extend(["README.md", "CONTRIBUTING.md", "crates/ca-py/README.md"].map(from_root));
    let mut seen = 0;
    for page in &pages {
        let text = fs::read_to_string(page).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link) {
            if link.contains("://") || link.contains(char::is_whitespace) {
                continue;
            }
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let to = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            assert!(to.exists(), "{}: no {file}", page.display());
            if !anchor.is_empty() && to.extension().is_some_and(|e| e == "md") {
                let there = anchors(&fs::read_to_string(&to).unwrap());
                assert!(there.iter().any(|a| a == anchor), "{}: {file} has no #{anchor}", page.display());
            }
            seen += 1;
        }
    }
    assert!(seen > 40, "{seen} links");
}

/// The files of the page about imports are saved under their names, the last text in backquotes before each. Then its
/// commands run in order.
#[cfg(unix)]
#[test]
fn the_commands_of_the_page_of_imports_run() {
    let page = fs::read_to_string(from_root("docs/import.md")).unwrap();
    let sandbox = Sandbox::new();
    for language in ["text", "toml"] {
        for (before, file) in blocks(&page, language) {
            sandbox.put(before.rsplit('`').nth(1).unwrap(), file);
        }
    }
    let lines: Vec<&str> = blocks(&page, "sh").into_iter().flat_map(|(_, b)| b.lines()).collect();
    assert!(lines.len() >= 7, "{lines:?}");
    let said: String = lines.iter().map(|line| sandbox.sh(line).is(0)).map(|ran| ran.out + &ran.err).collect();
    for words in ["N201", "read as the position one sample before", "6 MAT, 9 LIA: 6 MAS, 8 REF, 1 BUT"] {
        assert!(said.contains(words), "no `{words}` in\n{said}");
    }
    let read = |name: &str| fs::read(sandbox.path(name)).unwrap();
    assert!(read("one.wav") == read("direct.wav"), "the sound of the imported model is another");
    assert!(peak(&sandbox.wav("pyramid.wav").1) > 1e-3 && peak(&sandbox.wav("played.wav").1) > 1e-3);
}

/// The pages for contributors name existing files, and CONTRIBUTING.md has two pages.
#[test]
fn what_contributors_are_sent_to_is_there() {
    let folders = ["crates/", "tests/", "docs/", "benches/", "models/"];
    for (name, least) in [("CONTRIBUTING.md", 8), ("docs/testing.md", 15), ("docs/extend.md", 25)] {
        let page = fs::read_to_string(from_root(name)).unwrap();
        let named = page.split('`').skip(1).step_by(2).filter(|s| folders.iter().any(|f| s.starts_with(f)));
        let mut seen = 0;
        for path in named.filter(|s| !s.contains(['*', ' ']) && !s.contains("NAME")) {
            assert!(from_root(path).exists(), "{name}: no {path}");
            seen += 1;
        }
        assert!(seen >= least, "{name}: {seen}");
    }
    let words = fs::read_to_string(from_root("CONTRIBUTING.md")).unwrap().split_whitespace().count();
    assert!(words <= 1100, "CONTRIBUTING.md has {words} words; move some to docs/testing.md or docs/extend.md");
}

#[test]
fn the_glossary_knows_every_kind() {
    let page = fs::read_to_string(from_root("docs/glossary.md")).unwrap();
    let words: Vec<&str> = page.split(|c: char| !c.is_ascii_alphanumeric()).collect();
    // the page of kinds is generated from the catalog
    let kinds = fs::read_to_string(from_root("docs/kinds.md")).unwrap();
    let codes = kinds.lines().filter_map(|l| l.strip_prefix("| ")?.split(' ').next());
    let codes: Vec<&str> = codes.filter(|c| c.chars().all(|c| c.is_ascii_uppercase())).collect();
    assert!(codes.len() >= 28, "{codes:?}");
    for code in codes {
        assert!(words.contains(&code), "docs/glossary.md does not say what {code} is");
    }
}

/// Collects all texts below a directory that may cite a page, except output of tools.
pub fn texts(dir: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_string();
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        if path.is_dir() {
            if !name.starts_with('.') && !["target", "__pycache__", "node_modules"].contains(&name.as_str()) {
                texts(&path, found);
            }
        } else if ["rs", "py", "pyi", "md", "toml", "h", "c", "js", "ipynb"].contains(&ending) {
            found.push(path);
        }
    }
}

/// Sections of the numerics page cited in a text, as `§1.3`, `§5.2, §5.3` or `§5.2 and §5.3` after its name. Returns
/// `None` for a section sign without a digit after it.
fn cited(text: &str) -> Option<Vec<String>> {
    let mut all = Vec::new();
    for rest in text.split(&["numerics", ".md "].concat()).skip(1) {
        let mut rest = rest.strip_prefix('§');
        while let Some(from) = rest {
            let end = from.find(|c: char| c != '.' && !c.is_ascii_digit()).unwrap_or(from.len());
            let number = from[..end].trim_end_matches('.');
            if number.is_empty() {
                return None;
            }
            all.push(number.to_string());
            let after = &from[number.len()..];
            rest = [", §", " and §", ", and §"].into_iter().find_map(|join| after.strip_prefix(join));
        }
    }
    Some(all)
}

#[test]
fn every_section_of_the_numerics_page_that_code_cites_exists() {
    let page = fs::read_to_string(from_root("docs/numerics.md")).unwrap();
    let headings = page.lines().filter(|l| l.starts_with('#'));
    let sections: Vec<&str> = headings.filter_map(|l| l.trim_start_matches('#').split_whitespace().next()).collect();
    let mut files = Vec::new();
    for dir in ["crates", "tests", "benches", "docs", "models"] {
        texts(&from_root(dir), &mut files);
    }
    files.push(from_root("README.md"));
    let (mut seen, old) = (0, ["umerics", " "].concat());
    for path in files {
        let text = fs::read_to_string(&path).unwrap();
        let Some(numbers) = cited(&text) else { panic!("{}: a citation without a number", path.display()) };
        seen += numbers.len();
        for n in numbers {
            assert!(sections.contains(&n.as_str()), "{}: docs/numerics.md has no section {n}", path.display());
        }
        for rest in text.split(&old).skip(1) {
            let bare = rest.starts_with(|c: char| c.is_ascii_digit());
            assert!(!bare, "{}: cite a section of docs/numerics.md in place of {rest:.4}", path.display());
        }
    }
    assert!(seen >= 90, "only {seen} citations were found");
}

/// The numerics page names a test by its file (from `tests/suite` or the root) and function, and code by its file.
#[test]
fn what_the_numerics_page_names_is_there() {
    let page = fs::read_to_string(from_root("docs/numerics.md")).unwrap();
    let mut seen = 0;
    for name in page.split('`').skip(1).step_by(2).filter(|n| n.contains(".rs")) {
        let (file, test) = name.split_once("::").unwrap_or((name, ""));
        let home = if test.is_empty() { "crates/ca-core/src" } else { "tests/suite" };
        let near = from_root(home).join(file);
        let path = if near.exists() { near } else { from_root(file) };
        let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(test.is_empty() || text.contains(&format!("fn {test}(")), "{name}: no such test");
        seen += 1;
    }
    assert!(seen >= 100, "only {seen} names were found");
}
