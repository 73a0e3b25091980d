//! `crates/ca-model/diagnostics/*.md`: the findings about models, as shown in the documentation and by `ca explain`.
//!
//! A section `## E004 unknown parameter` has prose, then a `toml` block (or one of another program, such as `mdl` of
//! MIMS), followed by a `text` block with the expected report. `UPDATE=1 cargo test $ALL --test suite -- diagnostics`
//! ($ALL is in CONTRIBUTING.md) rewrites the reports; review the difference like code.

use ca_compile::{Options, load};
use ca_core::internal::kind::cloud::{Cloud, Unread};
use ca_model::diag::CODES;
use ca_model::{Model, render};
use ca_tests::catalog;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

fn report(language: &str, text: &str) -> String {
    let file = format!("model.{language}");
    let (model, diags) = if let Some(format) = ca_import::of(&file) {
        let diags = (format.import)(text, &file).1;
        (Model { file, text: text.into(), ..Model::default() }, diags)
    } else {
        // files beside the model: a drawing with a seam, and a truncated one
        let seam = Cloud { points: vec![[0.0; 3], [0.1, 0.0, 0.0]], edges: vec![[0, 1]], merged: 2, flat: 1 };
        let cut = Unread { what: "`cut.ply`, line 9: it ends here".into(), help: "export it again".into() };
        let clouds = [("seam.obj".into(), Ok(seam.into())), ("cut.ply".into(), Err(cut))].into();
        let options = Options { clouds, ..Options::default() };
        let (model, result) = load(text, "model.ca.toml", &catalog(), &options);
        (model, result.map_or_else(|diags| diags, |scene| scene.findings))
    };
    if diags.list.is_empty() { "no findings\n".into() } else { render::text(&diags, &model, false) }
}

fn files() -> Vec<(PathBuf, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/ca-model/diagnostics");
    let entries = std::fs::read_dir(folder).expect("the folder of the pages");
    let mut list: Vec<PathBuf> = entries.map(|e| e.expect("readable").path()).collect();
    list.retain(|p| p.extension().is_some_and(|e| e == "md"));
    list.sort();
    list.into_iter().map(|p| (p.clone(), std::fs::read_to_string(p).expect("UTF-8"))).collect()
}

/// One input block: its heading, its text, and the report after it (`None` if missing).
struct Case {
    line: usize,
    heading: String,
    language: String,
    input: String,
    expected: Option<String>,
}

/// Parses a document. Returns its cases, and the document with all reports rewritten.
fn walk(doc: &str) -> (Vec<Case>, String) {
    let mut cases: Vec<Case> = Vec::new();
    let mut fresh = String::new();
    let mut heading = String::new();
    let mut waiting = false;
    let mut lines = doc.lines().enumerate();
    let emit = |fresh: &mut String, case: &Case| {
        let _ = write!(fresh, "\n```text\n{}```\n", report(&case.language, &case.input));
    };
    while let Some((i, line)) = lines.next() {
        let fence = line.strip_prefix("```");
        if waiting && !(line.is_empty() || fence == Some("text")) {
            emit(&mut fresh, &cases[cases.len() - 1]);
            fresh.push('\n');
            waiting = false;
        }
        match fence {
            None => {
                if let Some(h) = line.strip_prefix("## ") {
                    heading = h.to_string();
                }
                if !waiting {
                    fresh.push_str(line);
                    fresh.push('\n');
                }
            }
            Some(language) => {
                let mut body = String::new();
                for (_, l) in lines.by_ref().take_while(|(_, l)| *l != "```") {
                    body.push_str(l);
                    body.push('\n');
                }
                if language == "text" && waiting {
                    let case = cases.last_mut().expect("a toml block before");
                    case.expected = Some(body);
                    emit(&mut fresh, case);
                    waiting = false;
                } else {
                    let _ = write!(fresh, "```{language}\n{body}```\n");
                    if language == "toml" || ca_import::of(&format!("model.{language}")).is_some() {
                        let (heading, language) = (heading.clone(), language.to_string());
                        cases.push(Case { line: i + 1, heading, language, input: body, expected: None });
                        waiting = true;
                    }
                }
            }
        }
    }
    if waiting {
        emit(&mut fresh, &cases[cases.len() - 1]);
    }
    (cases, fresh)
}

#[test]
fn reports_are_as_written() {
    let mut wrong = String::new();
    let mut n = 0;
    for (path, doc) in files() {
        let (cases, fresh) = walk(&doc);
        n += cases.len();
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&path, fresh).expect("writable");
            continue;
        }
        for c in cases {
            let got = report(&c.language, &c.input);
            if c.expected.as_deref() != Some(&got) {
                let want = c.expected.as_deref().unwrap_or("(no text block)\n");
                let _ =
                    writeln!(wrong, "{}:{} {}\n--- written\n{want}--- now\n{got}", path.display(), c.line, c.heading);
            }
        }
    }
    assert!(n > 0, "no case in crates/ca-model/diagnostics");
    assert!(wrong.is_empty(), "{wrong}UPDATE=1 writes the reports anew");
}

#[test]
fn each_section_shows_its_code() {
    for (path, doc) in files() {
        for c in walk(&doc).0 {
            let code = c.heading.split(' ').next().unwrap_or("");
            let title = c.heading.strip_prefix(code).unwrap_or("").trim();
            let known = CODES.iter().any(|k| k.0 == code && k.1 == title);
            assert!(known, "{}: the heading `{}` is not a line of diag::CODES", path.display(), c.heading);
            assert!(
                report(&c.language, &c.input).contains(&format!("[{code}]")),
                "{}:{} does not show {code}",
                path.display(),
                c.line
            );
        }
    }
}

#[test]
fn every_code_has_a_section() {
    let shown: BTreeSet<String> = files().iter().flat_map(|(_, doc)| walk(doc).0).map(|c| c.heading).collect();
    let missing: Vec<String> =
        CODES.iter().map(|(code, title)| format!("{code} {title}")).filter(|h| !shown.contains(h)).collect();
    assert!(missing.is_empty(), "without a section in crates/ca-model/diagnostics:\n{}", missing.join("\n"));
}

/// The explanations built into the crate are exactly those in the files. The files are part of the crate, so rewritten
/// reports are compared by the next run, which builds them first.
#[test]
fn the_pages_of_the_crate_are_those_of_the_files() {
    if std::env::var_os("UPDATE").is_some() {
        return;
    }
    let mut written: BTreeMap<String, String> = BTreeMap::new();
    for (_, doc) in files() {
        let (mut code, mut fenced) = (None, false);
        for line in doc.lines() {
            if let (false, Some(heading)) = (fenced, line.strip_prefix("## ")) {
                code = heading.split(' ').next();
                continue;
            }
            fenced ^= line.starts_with("```");
            if let Some(code) = code {
                written.entry(code.into()).or_default().extend([line.trim_end(), "\n"]);
            }
        }
    }
    let sorted = |text: &str| {
        let mut lines: Vec<String> = text.lines().filter(|l| !l.is_empty()).map(str::to_owned).collect();
        lines.sort();
        lines
    };
    for (code, title) in CODES {
        let page = ca_model::explain::page(code).unwrap_or_else(|| panic!("{code} has no page"));
        assert_eq!((page.code, page.title), (*code, *title));
        assert_eq!(sorted(&page.text()), sorted(&written[*code]), "{code}");
        assert!(!page.text().starts_with("```"), "{code}: a page begins by saying what the code means");
    }
    assert!(ca_model::explain::page("E000").is_none());
}

#[test]
fn updating_is_idempotent() {
    for (path, doc) in files() {
        let once = walk(&doc).1;
        assert_eq!(walk(&once).1, once, "{}", path.display());
    }
    let (cases, fresh) = walk("## E004 x\n\n```toml\n[model]\nq = 1\n```\nprose\n");
    assert!(cases[0].expected.is_none() && fresh.contains("```text\nerror[E004]") && fresh.ends_with("```\n\nprose\n"));
}
