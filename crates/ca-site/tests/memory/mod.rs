//! Memory stays flat over 50 reloads: of the page, and of the instrument in a page.

use crate::browser::Tab;
use crate::long_form::long_form;
use crate::page::until;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

/// Reloads, and after how many of them the memory has settled.
const RELOADS: u32 = 50;
const SETTLED: u32 = 10;
/// Timers of the page last 12 s, and keep what they use.
const TIMERS: Duration = Duration::from_secs(15);
/// What a page may gain from then on, in its renderers \[MB\], and in the heap of its scripts \[MB\].
const GROWTH: [f64; 2] = [32.0, 2.0];
/// What the memory of a module may gain, which grows in pages of 64 kB \[MB\].
const MODULE: f64 = 0.5;

/// Objects and memory \[MB\] of a page after a collection.
#[derive(Debug)]
struct Used {
    objects: BTreeMap<String, f64>,
    heap: f64,
    renderers: f64,
}

impl Used {
    fn by(tab: &mut Tab) -> Used {
        std::thread::sleep(TIMERS);
        for _ in 0..3 {
            tab.command("HeapProfiler.collectGarbage", &json!({}));
        }
        let metrics = tab.command("Performance.getMetrics", &json!({}))["metrics"].clone();
        let all = metrics.as_array().expect("metrics").iter();
        let mut all: BTreeMap<String, f64> =
            all.map(|m| (m["name"].as_str().unwrap().into(), m["value"].as_f64().unwrap())).collect();
        let heap = all["JSHeapUsedSize"] / 1e6;
        let counted = [
            "Documents",
            "Frames",
            "JSEventListeners",
            "Nodes",
            "AudioHandlers",
            "AudioWorkletProcessors",
            "WorkerGlobalScopes",
        ];
        all.retain(|name, _| counted.contains(&name.as_str()));
        Used { objects: all, heap, renderers: renderers(tab.process()) }
    }
}

/// Private memory of the processes that run pages and their sound, below a process \[MB\].
fn renderers(browser: u32) -> f64 {
    let read = |pid: u32, name: &str| std::fs::read_to_string(format!("/proc/{pid}/{name}")).unwrap_or_default();
    let number = |text: &str, name: &str| -> Option<f64> {
        text.lines().find_map(|l| l.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
    };
    let pids = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids: Vec<u32> = pids.filter_map(|e| e.file_name().to_str()?.parse().ok()).collect();
    let parent = |pid: u32| number(&read(pid, "status"), "PPid:").unwrap_or(0.0) as u32;
    let below = |pid: &u32| {
        std::iter::successors(Some(*pid), |p| Some(parent(*p))).take_while(|p| *p > 1).any(|p| p == browser)
    };
    let renders = |pid: &u32| read(*pid, "cmdline").contains("--type=renderer");
    let found = pids.into_iter().filter(renders).filter(below);
    found.filter_map(|pid| number(&read(pid, "status"), "RssAnon:")).sum::<f64>() / 1e3
}

/// Reloads something over and over, and compares the memory then with the one after the first reloads.
fn flat(tab: &mut Tab, what: &str, mut reload: impl FnMut(&mut Tab, u32)) {
    tab.command("Performance.enable", &json!({}));
    let mut settled = None;
    for n in 1..=RELOADS {
        reload(tab, n);
        if n == SETTLED {
            settled = Some(Used::by(tab));
        }
    }
    let (before, after) = (settled.expect("it has settled"), Used::by(tab));
    println!("{what}: {before:.1?}, then {after:.1?}");
    for (name, count) in &after.objects {
        // what belongs to a frame that is drawn may come and go
        assert!(*count <= before.objects[name] + 20.0, "{what}: {name} from {before:?} to {after:?}");
    }
    assert!(after.heap < before.heap + GROWTH[1], "{what}: scripts from {before:?} to {after:?}");
    assert!(after.renderers < before.renderers + GROWTH[0], "{what}: processes from {before:?} to {after:?}");
}

#[test]
fn memory_is_flat_over_reloads() {
    if !long_form("fifty reloads of a page, and of an instrument in it") {
        return;
    }
    let Some((modules, _alone)) = crate::built() else { return };
    let (dir, server) = crate::folder(modules);
    versions(dir.path());
    let Some(mut tab) = Tab::open(&format!("{}play.html?model=hammered_string", server.address)) else { return };
    crate::play(&mut tab);
    flat(&mut tab, "versions of the model", |tab, n| {
        let edit = format!(
            "(() => {{ const t = document.getElementById('modelText'); t.value = t.value.replace(/(\\n# \\d+)?$/, '\\n# {n}'); \
             document.getElementById('apply').click(); }})()"
        );
        let generation = tab.js("+document.documentElement.dataset.generation").as_f64().unwrap();
        tab.js(&edit);
        until(tab, "the new version plays", &format!("+document.documentElement.dataset.generation > {generation}"));
    });
    flat(&mut tab, "pages", |tab, _| {
        tab.js("(() => { window.old = true; location.reload(); })()");
        until(
            tab,
            "the page is new",
            "window.old === undefined && document.documentElement.dataset.generation === '1'",
        );
        crate::play(tab);
    });
    assert_eq!(tab.errors(), Vec::<String>::new());
}

/// The memories of the modules themselves stay flat.
fn versions(site: &Path) {
    std::fs::write(site.join("npm/versions.mjs"), include_str!("versions.mjs")).unwrap();
    let model = site.join("models/hammered_string.ca.toml");
    let Some(said) = crate::node(&[&site.join("npm/versions.mjs"), &model]) else { return };
    let sizes: Value = serde_json::from_str(&said).unwrap();
    let at = |n: u32, module: &str| sizes[n as usize - 1][module].as_f64().unwrap();
    for module in ["compiler", "engine"] {
        let [settled, last] = [SETTLED, RELOADS].map(|n| at(n, module) / 1e6);
        assert!(last < settled + MODULE, "{module}: {settled} MB, then {last} MB: {sizes}");
    }
}
