//! The pages of the documents: every link leads somewhere, and what "Play this" plays is the model above it.

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use ca_site::{WebModules, site};
use flate2::read::DeflateDecoder;
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::PathBuf;

/// A site with modules of a few bytes, because only its pages are read.
fn pages() -> (tempfile::TempDir, BTreeMap<PathBuf, String>) {
    let dir = tempfile::tempdir().unwrap();
    site(dir.path(), WebModules { engine: b"e", compiler: b"c", accuracy: b"a" }).unwrap();
    let mut pages = BTreeMap::new();
    for folder in ["docs", "docs/language"] {
        for entry in std::fs::read_dir(dir.path().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "html") {
                pages.insert(path.clone(), std::fs::read_to_string(&path).unwrap());
            }
        }
    }
    (dir, pages)
}

/// Values of an attribute, without the escapes of HTML.
fn values<'a>(page: &'a str, name: &str) -> impl Iterator<Item = String> + use<'a> {
    let start = format!(" {name}=\"");
    let after: Vec<&str> = page.split(&start).skip(1).collect();
    after.into_iter().map(|rest| unescaped(rest.split('"').next().unwrap()))
}

/// The page without its code, which may look like links.
fn without_code(page: &str) -> String {
    let mut parts = page.split("<pre>");
    let first = parts.next().unwrap().to_owned();
    parts.fold(first, |all, part| all + part.split_once("</pre>").unwrap().1)
}

fn unescaped(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

#[test]
fn every_link_of_the_documents_leads_to_a_file_and_an_anchor() {
    let (dir, pages) = pages();
    let gallery = dir.path().join("index.html");
    let texts = pages.iter().map(|(p, t)| (p.clone(), t.clone()));
    let texts: Vec<(PathBuf, String)> =
        texts.chain([(gallery.clone(), std::fs::read_to_string(&gallery).unwrap())]).collect();
    let (mut links, mut anchors) = (0, 0);
    for (path, page) in &texts {
        let page = &without_code(page);
        for link in values(page, "href").chain(values(page, "src")).filter(|l| !l.contains("://")) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let file = file.split('?').next().unwrap();
            let to = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            let to = to.canonicalize().unwrap_or_else(|_| panic!("{}: no {link}", path.display()));
            assert!(to.starts_with(dir.path().canonicalize().unwrap()) && to.is_file(), "{}: {link}", path.display());
            links += 1;
            if !anchor.is_empty() && !anchor.starts_with("model=") {
                let there = std::fs::read_to_string(&to).unwrap();
                assert!(values(&there, "id").any(|id| id == anchor), "{}: no #{anchor} in {file}", path.display());
                anchors += 1;
            }
        }
    }
    assert!(pages.len() >= 22 && links > 600 && anchors > 80, "{} pages, {links} links, {anchors}", pages.len());
}

/// Ids of one page differ, and no Markdown is left.
#[test]
fn pages_are_html() {
    let (_dir, pages) = pages();
    for (path, page) in &pages {
        let mut ids: Vec<String> = values(page, "id").collect();
        ids.sort();
        let all = ids.len();
        ids.dedup();
        assert_eq!(ids.len(), all, "{}", path.display());
        let page = &without_code(page);
        assert!(!page.contains("do not edit"), "{}", path.display());
        assert!(!page.contains("](") && !page.contains(".md\""), "{}", path.display());
        let head = page.split("</head>").next().unwrap();
        assert!(head.contains("Content-Security-Policy") && head.contains("default-src 'none'"), "{}", path.display());
        assert_eq!(page.matches("aria-current=\"page\"").count(), 1, "{}", path.display());
    }
}

#[test]
fn what_play_this_plays_is_the_model_above_it() {
    let (_dir, pages) = pages();
    let mut played = 0;
    for (path, page) in &pages {
        let blocks: Vec<&str> = page.split("<code class=\"language-toml\">").skip(1).collect();
        for block in blocks {
            let (text, after) = block.split_once("</code></pre>\n").unwrap();
            let text = unescaped(text);
            let link = after.strip_prefix("<p class=\"play\"><a href=\"");
            let is_model = text.lines().any(|l| l == "[SOX]");
            assert_eq!(link.is_some(), is_model, "{}: {text}", path.display());
            let Some(link) = link.map(|l| l.split('"').next().unwrap()) else { continue };
            let packed = link.trim_start_matches("../").strip_prefix("play.html#model=").unwrap();
            let mut carried = String::new();
            let bytes = URL_SAFE_NO_PAD.decode(packed).unwrap();
            DeflateDecoder::new(&bytes[..]).read_to_string(&mut carried).unwrap();
            assert_eq!(carried, text, "{}", path.display());
            // the compiler of the page, with the limits of a link
            let request =
                serde_json::json!({"type": "compile", "file": "shared.ca.toml", "text": text, "limit": 20_000});
            let (answer, _) = ca_web::compiler::answer(request.to_string().as_bytes(), &[]);
            assert_eq!(answer["ok"], true, "{}: {answer}", path.display());
            played += 1;
        }
    }
    assert!(played >= 20, "{played}");
}

/// The site is kept for use without a network with its documents.
#[test]
fn the_service_worker_keeps_the_documents() {
    let (dir, pages) = pages();
    let worker = std::fs::read_to_string(dir.path().join("sw.js")).unwrap();
    let mut all: Vec<PathBuf> = pages.into_keys().collect();
    all.push(dir.path().join("docs.css"));
    all.push(dir.path().join("docs/pictures/membrane.webp"));
    for path in all {
        let name = path.strip_prefix(dir.path()).unwrap();
        assert!(path.is_file() && worker.contains(&format!("\"{}\"", name.display())), "{}", name.display());
    }
}
