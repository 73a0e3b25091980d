//! The folder of a site.

use crate::gallery::{blank, gallery, texts};
use crate::{WebModules, page};
use ca_io::atomic_file;
use ca_lab::Failure;
use ca_play::{STYLE, bundle, module};
use maud::{Markup, PreEscaped, html};
use serde_json::json;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::Path;

/// Which content the pages accept: their own files alone.
const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
    script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; connect-src 'self'; img-src 'self' data: blob:; \
    worker-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'\">\n";

/// Returns the head of a page. `root` leads from its folder to the folder of the site.
pub(crate) fn head(root: &str, title: &str, style: &str) -> Markup {
    html! {
        meta charset="utf-8";
        meta name="viewport" content="width=device-width, initial-scale=1";
        meta name="color-scheme" content="dark light";
        (PreEscaped(POLICY))
        title { (title) }
        link rel="icon" href={ (root) "icon.svg" };
        link rel="stylesheet" href={ (root) (style) };
        script src={ (root) "register.js" } defer {}
    }
}

/// A file of the site: its path and content.
pub(crate) type File = (String, Vec<u8>);

/// Writes the site into a folder and returns the number of files and of bytes. Files that a site of another version had
/// stay.
///
/// # Errors
/// If a file cannot be written.
pub fn site(to: &Path, modules: WebModules) -> Result<(usize, usize), Failure> {
    let mut files = files(modules)?;
    let worker = service_worker(&files);
    files.push(("sw.js".into(), worker.into_bytes()));
    for (name, bytes) in &files {
        let path = to.join(name);
        if let Some(folder) = path.parent() {
            let what = |e| Failure::Failed(format!("the folder `{}` cannot be made: {e}", folder.display()));
            std::fs::create_dir_all(folder).map_err(what)?;
        }
        atomic_file::write(&path, bytes)?;
    }
    Ok((files.len(), files.iter().map(|f| f.1.len()).sum()))
}

fn files(modules: WebModules) -> Result<Vec<File>, Failure> {
    let head = format!(
        "{POLICY}<link rel=\"stylesheet\" href=\"page.css\">\n<link rel=\"manifest\" href=\"site.webmanifest\">\n"
    );
    let script = "<script src=\"play.js\" defer></script>\n<script src=\"register.js\" defer></script>\n";
    let mut files: Vec<File> = vec![
        ("index.html".into(), gallery()?.into_bytes()),
        ("play.html".into(), page(&head, script).into_bytes()),
        ("play.js".into(), bundle("main.js").into_bytes()),
        ("page.css".into(), STYLE.into()),
        ("browser/worklet.js".into(), bundle("browser/worklet.js").into_bytes()),
        ("browser/compiler-worker.js".into(), bundle("browser/compiler-worker.js").into_bytes()),
        ("engine.wasm".into(), modules.engine.to_vec()),
        ("compiler.wasm".into(), modules.compiler.to_vec()),
        ("accuracy.wasm".into(), modules.accuracy.to_vec()),
        ("models/blank.ca.toml".into(), blank().into()),
    ];
    files.extend(crate::documents::files());
    files.extend(texts().map(|(name, text)| (format!("models/{name}.ca.toml"), text.into())));
    for (name, text) in [
        ("gallery.css", concat!(include_str!("../files/colours.css"), include_str!("../files/gallery.css"))),
        ("docs.css", concat!(include_str!("../files/colours.css"), include_str!("../files/docs.css"))),
        ("icon.svg", include_str!("../files/icon.svg")),
        ("register.js", include_str!("../files/register.js")),
        ("site.webmanifest", include_str!("../files/site.webmanifest")),
        ("npm/element.js", include_str!("../files/element.js")),
        ("npm/index.js", include_str!("../files/index.js")),
        ("npm/index.d.ts", include_str!("../files/index.d.ts")),
        ("npm/README.md", include_str!("../files/npm.md")),
    ] {
        files.push((name.into(), text.into()));
    }
    let package = json!({
        "name": "cordis-anima",
        "version": env!("CARGO_PKG_VERSION"),
        "description": "instruments of masses and links that sound and move in a page",
        "license": "MIT OR Apache-2.0",
        "type": "module",
        "main": "index.js",
        "types": "index.d.ts",
        "exports": {".": "./index.js", "./element.js": "./element.js"},
        "files": ["*.js", "*.d.ts", "*.wasm", "page"],
    });
    files.push(("npm/package.json".into(), format!("{package:#}\n").into_bytes()));
    for name in ["model.js", "wasm.js"] {
        files.push((format!("npm/{name}"), module(&format!("browser/{name}")).into()));
    }
    files.push(("npm/compiler.wasm".into(), modules.compiler.to_vec()));
    files.push(("npm/accuracy.wasm".into(), modules.accuracy.to_vec()));
    let played = [
        "play.html",
        "play.js",
        "page.css",
        "browser/worklet.js",
        "browser/compiler-worker.js",
        "engine.wasm",
        "compiler.wasm",
        "accuracy.wasm",
        "register.js",
        "site.webmanifest",
        "icon.svg",
    ];
    let copies: Vec<File> = files
        .iter()
        .filter(|f| played.contains(&f.0.as_str()))
        .map(|f| (format!("npm/page/{}", f.0), f.1.clone()))
        .collect();
    files.extend(copies);
    Ok(files)
}

/// The script that keeps the site for use without a network. Its version is a hash of all files, so that a changed site
/// replaces the old one as a whole.
fn service_worker(files: &[File]) -> String {
    let mut hash = DefaultHasher::new();
    files.hash(&mut hash);
    let names: Vec<&str> = files.iter().map(|f| f.0.as_str()).filter(|n| !n.starts_with("npm/")).collect();
    include_str!("../files/sw.js")
        .replace("VERSION_OF_THE_SITE", &format!("{:016x}", hash.finish()))
        .replace("[\"FILES_OF_THE_SITE\"]", &json!(names).to_string())
}
