//! The site and the single file in a real Chromium. They need the modules of the engine inside this build: set
//! `CA_WEB_ENGINE` to the folder that `tools/site --engine` makes, as `tests/run --long` does.

#[path = "../../ca-cli/tests/page/browser.rs"]
#[allow(dead_code)]
mod browser;
mod server;
#[path = "../../../tests/src/skipped.rs"]
mod skipped;

use browser::Tab;
use ca_site::{WebModules, modules, one_file, site};
use serde_json::{Value, json};
use server::Server;
use std::path::Path;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

fn built() -> Option<WebModules> {
    let found = modules();
    if found.is_none() {
        skipped::skipped("modules of the browser", "CA_WEB_ENGINE is not set, so no page without a server is played");
    }
    found
}

/// Waits until an expression in the page is true.
#[track_caller]
fn until(tab: &mut Tab, what: &str, is: &str) {
    let end = Instant::now() + Duration::from_secs(60);
    while tab.js(is) != true {
        if Instant::now() > end {
            let page = tab.js("JSON.stringify([document.documentElement.dataset, document.getElementById('bannerText')?.textContent, document.getElementById('reportText')?.textContent])");
            panic!("{what}: not within a minute: {page} {:?}", tab.errors());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

const OPEN: &str = "document.documentElement.dataset.generation === '1'";
const SOUNDS: &str = "document.getElementById('decibels').textContent.includes('dBFS')";

/// Opens an instrument and plays it.
fn play(tab: &mut Tab) {
    until(tab, "the instrument is there", OPEN);
    tab.js("document.getElementById('play').click()");
    until(tab, "it sounds", SOUNDS);
    until(tab, "time goes on", "+document.documentElement.dataset.tick > 10000");
}

fn folder(modules: WebModules) -> (tempfile::TempDir, Server) {
    let dir = tempfile::tempdir().unwrap();
    let (files, bytes) = site(dir.path(), modules).unwrap();
    assert!(files > 60 && bytes > 1_000_000);
    let server = Server::of(dir.path().to_owned());
    (dir, server)
}

#[test]
fn an_instrument_of_the_gallery_is_played_pulled_edited_and_shared() {
    let Some(modules) = built() else { return };
    let (_dir, server) = folder(modules);
    let Some(mut tab) = Tab::open(&server.address) else { return };
    until(&mut tab, "the gallery shows all", "document.querySelectorAll('.card').length >= 34");
    assert_eq!(tab.js("document.querySelectorAll('.card svg circle').length > 1000"), true);
    tab.js("location.href = document.querySelector('.card[href*=\"hammered_string\"]').href; 0");
    play(&mut tab);
    // pulled: the mass follows the pointer
    until(&mut tab, "the gesture has ended", "document.getElementById('play').dataset.on === 'false'");
    let at = tab.near().expect("a mass of the string");
    tab.mouse("mousePressed", at[0], at[1]);
    for step in 1..=10 {
        tab.mouse("mouseMoved", at[0], at[1] - 6.0 * f64::from(step));
    }
    until(&mut tab, "it is held", "document.getElementById('stage').classList.contains('holding')");
    tab.mouse("mouseReleased", at[0], at[1] - 60.0);
    until(&mut tab, "it sounds", SOUNDS);
    // edited: a wrong text is reported and the old one plays on, a right one plays
    let edit = |tab: &mut Tab, from: &str, to: &str| {
        tab.js(&format!(
            "(() => {{ const t = document.getElementById('modelText'); t.value = t.value.replace({}, {}); \
             document.getElementById('apply').click(); }})()",
            json!(from),
            json!(to)
        ));
    };
    edit(&mut tab, "[STRING]", "[STRNG]");
    until(
        &mut tab,
        "the error is shown",
        "document.getElementById('reportText').textContent.includes('hammered_string.ca.toml:')",
    );
    let generation = "+document.documentElement.dataset.generation";
    let before = tab.js(generation).as_f64().unwrap();
    edit(&mut tab, "[STRNG]", "[STRING]");
    until(&mut tab, "it is mended", "document.getElementById('report').hidden");
    until(&mut tab, "the new version plays", &format!("{generation} > {before}"));
    // shared: the link carries the edited text
    edit(&mut tab, "110 Hz", "123 Hz");
    tab.js("Object.defineProperty(navigator, 'clipboard', {value: {writeText: async t => { window.copied = t; }}}); document.getElementById('share').click()");
    until(&mut tab, "the link is copied", "typeof window.copied === 'string'");
    let link = tab.js("window.copied");
    assert!(link.as_str().unwrap().contains("play.html#model="), "{link}");
    tab.js(&format!("location.href = {link}; location.reload()"));
    until(&mut tab, "the shared text is there", "document.getElementById('modelText')?.value.includes('123 Hz')");
    play(&mut tab);
    assert_eq!(tab.errors(), Vec::<String>::new());
}

#[test]
fn a_link_that_is_damaged_or_too_large_is_refused() {
    let Some(modules) = built() else { return };
    let (_dir, server) = folder(modules);
    let Some(mut tab) = Tab::open(&format!("{}play.html#model=AAAA", server.address)) else { return };
    until(&mut tab, "it is said", "document.getElementById('bannerText').textContent.includes('damaged')");
    // a million characters in a short link
    let bomb = "new Response(new Blob(['#'.repeat(1e6)]).stream().pipeThrough(new CompressionStream('deflate-raw'))).arrayBuffer()\
        .then(b => { location.hash = 'model=' + btoa(String.fromCharCode(...new Uint8Array(b))).replaceAll('+', '-').replaceAll('/', '_'); location.reload(); return true; })";
    tab.js(bomb);
    until(&mut tab, "it is said", "document.getElementById('bannerText').textContent.includes('too long')");
    for (address, why) in [
        ("play.html", "names no instrument"),
        ("play.html?model=nothing", "no instrument `nothing`"),
        ("play.html?model=../x", "names no instrument"),
    ] {
        tab.js(&format!("location.href = {}", json!(format!("{}{address}", server.address))));
        until(
            &mut tab,
            address,
            &format!("document.getElementById('bannerText')?.textContent.includes({})", json!(why)),
        );
    }
}

#[test]
fn the_site_works_without_a_network_once_visited() {
    let Some(modules) = built() else { return };
    let (_dir, server) = folder(modules);
    let Some(mut tab) = Tab::open(&format!("{}play.html?model=plucked_string", server.address)) else { return };
    play(&mut tab);
    until(&mut tab, "the site is kept", "navigator.serviceWorker.controller !== null");
    server.off.store(true, Relaxed);
    tab.js("location.reload()");
    std::thread::sleep(Duration::from_millis(300));
    play(&mut tab);
    tab.js("location.href = 'play.html?model=kalimba'");
    until(&mut tab, "another one opens", "document.getElementById('title')?.textContent.includes('alimba')");
    play(&mut tab);
}

#[test]
fn one_file_plays_from_a_disk() {
    let Some(modules) = built() else { return };
    let dir = tempfile::tempdir().unwrap();
    let text =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/kalimba.ca.toml")).unwrap();
    // the end of a script inside a model does not end the script of the page
    let text = format!("# </script><script>document.title = 'broken'</script>\n{text}");
    let path = dir.path().join("kalimba.html");
    std::fs::write(&path, one_file(&text, "kalimba.ca.toml", "", modules)).unwrap();
    let Some(mut tab) = Tab::open(&format!("file://{}", path.display())) else { return };
    play(&mut tab);
    assert_eq!(tab.js("document.querySelectorAll('#keyboard button').length"), 13);
    assert_eq!(tab.js("document.getElementById('share').hidden"), true);
    let value = tab.js("document.getElementById('modelText').value.startsWith('# </script>')");
    assert_eq!(value, true);
    assert_eq!(tab.errors(), Vec::<String>::new());
}

#[test]
fn two_elements_on_one_page_play() {
    let Some(modules) = built() else { return };
    let (dir, server) = folder(modules);
    let page = "<!doctype html><meta charset=utf-8><script type=module src=npm/element.js></script>\
        <ca-instrument src=models/kalimba.ca.toml></ca-instrument>\
        <ca-instrument>[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '9 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar', gain = 500 }</ca-instrument>";
    std::fs::write(dir.path().join("two.html"), page).unwrap();
    let Some(mut tab) = Tab::open(&format!("{}two.html", server.address)) else { return };
    let inside = |k: usize, what: &str| {
        format!(
            "(() => {{ const d = document.querySelectorAll('iframe')[{k}]?.contentDocument; return d?.documentElement && ({what}); }})()"
        )
    };
    for k in 0..2 {
        until(&mut tab, "it is there", &inside(k, "d.documentElement.dataset.generation === '1'"));
        tab.js(&inside(k, "d.getElementById('play').click()"));
    }
    for k in 0..2 {
        until(&mut tab, "it sounds", &inside(k, "d.getElementById('decibels').textContent.includes('dBFS')"));
    }
}

#[test]
fn every_model_plays_in_the_browser_with_the_bits_of_the_command() {
    let Some(modules) = built() else { return };
    let (_dir, server) = folder(modules);
    let Some(mut tab) = Tab::open(&format!("{}index.html", server.address)) else { return };
    let run = include_str!("bits.js");
    for (name, text) in ca_lab::load::BUNDLED {
        let model = json!({"type": "compile", "file": format!("{name}.ca.toml"), "text": text});
        let found = tab.js(&format!("({run})({model})"));
        let there: Vec<u32> = found
            .as_array()
            .unwrap_or_else(|| panic!("{name}: {found} {:?}", tab.errors()))
            .iter()
            .map(number)
            .collect();
        assert_eq!(there, native(&model), "{name}");
    }
}

fn number(v: &Value) -> u32 {
    v.as_u64().unwrap() as u32
}

/// Number of samples, and their FNV-1a hash in 32 bits, of one second.
fn native(model: &Value) -> Vec<u32> {
    let (object, plan) = ca_web::compiler::answer(model.to_string().as_bytes(), &[]);
    let facts = serde_json::from_value(object["facts"].clone()).unwrap();
    let mut engine = ca_web::engine::WebEngine::open(&plan, &facts).unwrap();
    engine.request(br#"{"type": "gesture", "play": true}"#);
    let shape = engine.shape();
    let (mut n, mut hash) = (0, 0x811c_9dc5_u32);
    for _ in 0..(shape.rate / f64::from(shape.frame)).ceil() as u32 {
        for x in engine.play(1) {
            n += 1;
            hash = (hash ^ x.to_bits()).wrapping_mul(0x0100_0193);
        }
    }
    vec![n, hash]
}
