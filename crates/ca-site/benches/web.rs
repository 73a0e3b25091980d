//! Measures the engine in the browser: size, start, and time for a second of sound beside the native engine. It prints
//! the page; with `UPDATE=1` it writes it to `docs/measured/web.md`. It needs Node.js, Chromium, and `CA_WEB_ENGINE`.
#![allow(missing_docs)]

#[path = "../../ca-cli/tests/page/browser.rs"]
#[allow(dead_code)]
mod browser;
#[path = "../tests/second/mod.rs"]
#[allow(dead_code)]
mod second;
#[path = "../tests/server/mod.rs"]
#[allow(dead_code)]
mod server;
#[path = "../../../tests/src/skipped.rs"]
mod skipped;

use browser::Tab;
use ca_lab::load::BUNDLED;
use ca_site::{modules, site};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};
use server::Server;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Rounds of timing; the fastest counts.
const ROUNDS: usize = 5;

/// Time for a second of sound of each model in Node \[ms\].
fn node(site: &Path) -> BTreeMap<String, f64> {
    std::fs::write(site.join("npm/second.js"), include_str!("../tests/second.js")).expect("a file");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/node.mjs");
    let mut all: BTreeMap<String, f64> = BTreeMap::new();
    for _ in 0..ROUNDS {
        let done = Command::new("node").args([&script, site]).output().expect("Node.js");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        for line in String::from_utf8_lossy(&done.stdout).lines() {
            let second: Value = serde_json::from_str(line).expect("a line of JSON");
            let name = second["file"].as_str().unwrap_or_default().trim_end_matches(".ca.toml");
            let ms = second["ms"].as_f64().expect("a time");
            all.entry(name.into()).and_modify(|t| *t = t.min(ms)).or_insert(ms);
        }
    }
    all
}

fn zipped(bytes: &[u8]) -> f64 {
    let mut out = GzEncoder::new(Vec::new(), Compression::best());
    out.write_all(bytes).and_then(|()| out.finish()).expect("memory").len() as f64 / 1e3
}

/// Time from the address to the first sample in Chromium, with and without the files in its cache \[s\].
fn starts(server: &Server) -> Option<[f64; 2]> {
    let mut tab = Tab::open("about:blank")?;
    tab.emulate("Network.enable", &json!({}));
    let slow = json!({"offline": false, "latency": 40, "downloadThroughput": 1.25e6, "uploadThroughput": 1.25e6});
    let mut times = [0.0; 2];
    for time in &mut times {
        tab.emulate("Network.emulateNetworkConditions", &slow);
        let began = Instant::now();
        tab.emulate("Page.navigate", &json!({"url": format!("{}play.html?model=hammered_string", server.address)}));
        while tab.js("document.documentElement.dataset.generation === '1'") != true {}
        tab.js("document.getElementById('play').click()");
        while tab.js("+document.documentElement.dataset.tick > 0") != true {}
        *time = began.elapsed().as_secs_f64();
        while tab.js("navigator.serviceWorker.controller !== null") != true {}
    }
    Some(times)
}

/// The processor, as Linux calls it.
fn processor() -> String {
    let all = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = all.lines().find_map(|l| l.strip_prefix("model name"));
    line.map_or_else(|| "unknown".into(), |l| l.trim_start_matches([' ', '\t', ':']).to_owned())
}

fn main() {
    let Some(modules) = modules() else {
        skipped::skipped("modules of the browser", "CA_WEB_ENGINE is not set");
        return;
    };
    let native =
        |name: &str, text: &str| (0..ROUNDS).map(|_| second::native(name, text).ms).fold(f64::INFINITY, f64::min);
    let mut page = String::from(
        "# The engine in the browser\n\nThis page answers how large the engine is, how soon it sounds, and how much slower it is than the \
         command. Made by `CA_WEB_ENGINE=$PWD/target/web UPDATE=1 cargo bench -p ca-site` after `tools/site --engine`: do not edit.\n\n",
    );
    let (engine, compiler) = (zipped(modules.engine), zipped(modules.compiler));
    let _ = writeln!(
        page,
        "Size, compressed: engine {engine:.0} kB (target 350), with the compiler {:.0} kB (target 1000).",
        engine + compiler
    );
    let dir = tempfile::tempdir().expect("a folder");
    site(dir.path(), modules).expect("a site");
    let server = Server::of(dir.path().to_owned());
    if let Some([cold, warm]) = starts(&server) {
        let _ = writeln!(
            page,
            "\nFrom the address to the first sample in Chromium, at 10 Mbit/s and 40 ms, on a server that does not compress: {cold:.1} s (target 5), \
             visited before {warm:.1} s (target 1)."
        );
    }
    let there = node(dir.path());
    let _ = writeln!(page, "\nTime for a second of sound \\[ms\\], fastest of {ROUNDS}, on {}:\n", processor());
    page += "| model | native | Node.js | ratio |\n|---|---|---|---|\n";
    let mut ratios = Vec::new();
    for (name, text) in BUNDLED {
        let (here, there) = (native(name, text), there.get(*name).copied().unwrap_or(f64::NAN));
        ratios.push(there / here);
        let _ = writeln!(page, "| {name} | {here:.1} | {there:.1} | {:.1} |", there / here);
    }
    ratios.sort_by(f64::total_cmp);
    let (median, most) = (ratios[ratios.len() / 2], ratios[ratios.len() - 1]);
    let _ = writeln!(page, "\nMedian of the ratio {median:.1} (target 1.8), largest {most:.1} (target 3).");
    println!("{page}");
    if std::env::var_os("UPDATE").is_some() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/measured/web.md");
        std::fs::write(path, page).expect("the page can be written");
    }
}
