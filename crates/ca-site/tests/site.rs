//! The site and the single file in a real Chromium. They need the modules of the engine inside this build: set
//! `CA_WEB_ENGINE` to the folder that `tools/site --engine` makes, as `tests/run --long` does.

#[path = "../../ca-cli/tests/page/browser.rs"]
#[allow(dead_code)]
mod browser;
#[allow(dead_code)]
mod second;
mod server;
#[path = "../../../tests/src/skipped.rs"]
mod skipped;

use browser::Tab;
use ca_accuracy::timing::Clock;
use ca_site::{WebModules, modules, one_file, site};
use serde_json::{Value, json};
use server::Server;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Pages in real time would disturb each other on two cores.
static ALONE: Mutex<()> = Mutex::new(());

fn built() -> Option<(WebModules, MutexGuard<'static, ()>)> {
    let found = modules();
    if found.is_none() {
        skipped::skipped("modules of the browser", "CA_WEB_ENGINE is not set, so no page without a server is played");
    }
    found.map(|modules| (modules, ALONE.lock().unwrap_or_else(PoisonError::into_inner)))
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
    let Some((modules, _alone)) = built() else { return };
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
    // saved: the render, and what was played
    tab.js("window.saved = {}; const made = URL.createObjectURL; let last; \
         URL.createObjectURL = blob => { last = blob; return made.call(URL, blob); }; \
         HTMLAnchorElement.prototype.click = function () { \
         const name = this.download; last.arrayBuffer().then(b => { window.saved[name] = b; }); }; 0");
    tab.js("document.getElementById('render').click()");
    let saved = |name: &str, bytes: u32| {
        format!(
            "(b => !!b && b.byteLength > {bytes} && String.fromCharCode(...new Uint8Array(b, 0, 4)) === 'RIFF')(window.saved['{name}'])"
        )
    };
    until(&mut tab, "the render is saved", &saved("hammered_string.wav", 2_000_000));
    tab.js("window.saved = {}; document.getElementById('record').click()");
    std::thread::sleep(Duration::from_millis(600));
    tab.js("document.getElementById('record').click()");
    until(&mut tab, "the sound is saved", &saved("hammered_string.wav", 100_000));
    tab.js("document.getElementById('saveText').click()");
    until(&mut tab, "the text is saved", "window.saved['hammered_string.ca.toml']?.byteLength > 1000");
    assert_eq!(tab.js("getComputedStyle(document.getElementById('stop')).display"), "none", "nothing to end");
    tab.js("document.getElementById('modes').click()");
    until(&mut tab, "the modes are shown", "document.querySelectorAll('#modesBox tr').length > 20");
    // tuned: the text gets the number of the command, and plays
    let before = tab.js(generation).as_f64().unwrap();
    tab.js("document.getElementById('tunePitch').value = 'B2'; document.getElementById('tune').click()");
    until(&mut tab, "it is tuned", "document.getElementById('modelText').value.includes('\"123.47082436 Hz\"')");
    until(&mut tab, "the tuned version plays", &format!("{generation} > {before}"));
    until(&mut tab, "the new mode is shown", "document.getElementById('modesBox').textContent.includes('123.47')");
    // measured: sound and edits go on meanwhile, and it can be stopped
    let state = "document.getElementById('accuracyState').textContent";
    tab.js("document.getElementById('accuracy').click()");
    until(&mut tab, "it measures", &format!("{state}.startsWith('Step')"));
    let (before, tick) = (tab.js(generation).as_f64().unwrap(), tab.js("+document.documentElement.dataset.tick"));
    edit(&mut tab, "123.47082436 Hz", "110 Hz");
    until(&mut tab, "the new version plays", &format!("{generation} > {before}"));
    until(&mut tab, "time goes on", &format!("+document.documentElement.dataset.tick > {tick} + 20000"));
    tab.js("document.getElementById('accuracy').click()");
    until(&mut tab, "it is stopped", &format!("{state} === 'The measurement was stopped.'"));
    let small =
        "[model]\nseconds = 0.1\n[CEL]\nc = { m = '1 g', f = '440 Hz', dx0 = '1 mm' }\n[SOX]\no = { from = 'c' }\n";
    let text = "document.getElementById('modelText').value";
    tab.js(&format!("window.text = {text}; {text} = {}; document.getElementById('accuracy').click()", json!(small)));
    until(&mut tab, "it is measured", "document.querySelectorAll('#accuracyTable tr').length > 4");
    tab.js("document.getElementById('accuracySave').click()");
    until(&mut tab, "its page is saved", "window.saved['hammered_string_accuracy.html']?.byteLength > 10000");
    tab.js(&format!("{text} = window.text; 0"));
    // shared: the link carries the edited text
    edit(&mut tab, "110 Hz", "123 Hz");
    tab.js("Object.defineProperty(navigator, 'clipboard', {value: {writeText: async t => { window.copied = t; }}}); document.getElementById('share').click()");
    until(&mut tab, "the link is copied", "typeof window.copied === 'string'");
    let link = tab.js("window.copied");
    assert!(link.as_str().unwrap().contains("play.html#model="), "{link}");
    tab.js(&format!("location.href = {link}; 0"));
    until(&mut tab, "the shared text is there", "document.getElementById('modelText')?.value.includes('123 Hz')");
    play(&mut tab);
    assert_eq!(tab.errors(), Vec::<String>::new());
}

#[test]
fn a_link_that_is_damaged_or_too_large_is_refused() {
    let Some((modules, _alone)) = built() else { return };
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
    let Some((modules, _alone)) = built() else { return };
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
    // so do the documents, and the models in them
    tab.js("location.href = 'docs/'");
    until(&mut tab, "the documents are there", "document.querySelector('main a[href=\"instrument.html\"]') !== null");
    tab.js("document.querySelector('main a[href=\"instrument.html\"]').click()");
    until(&mut tab, "the model is there", "document.querySelector('.play a') !== null");
    tab.js("document.querySelector('.play a').click()");
    until(&mut tab, "it opens", "document.getElementById('title')?.textContent === 'A struck string of my own'");
    play(&mut tab);
    assert_eq!(tab.errors(), Vec::<String>::new());
}

#[test]
fn one_file_plays_from_a_disk() {
    let Some((modules, _alone)) = built() else { return };
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
    let Some((modules, _alone)) = built() else { return };
    let (dir, server) = folder(modules);
    let page = "<!doctype html><meta charset=utf-8><script type=module src=npm/element.js></script>\
        <ca-instrument src=models/kalimba.ca.toml></ca-instrument>\
        <ca-instrument>[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '9 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar', gain = 500 }</ca-instrument>\
        <p style='height: 3000px'></p>";
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
    // out of sight, its time stands still; in sight, it goes on
    tab.js("scrollTo(0, 3500)");
    let tick = inside(0, "+d.documentElement.dataset.tick");
    std::thread::sleep(Duration::from_secs(1));
    let before = tab.js(&tick);
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(tab.js(&tick), before);
    tab.js("scrollTo(0, 0)");
    until(&mut tab, "it goes on", &format!("{tick} > {before}"));
}

/// A model that needs more than real time is reported, and can be played at half the rate.
#[test]
fn a_model_that_is_too_heavy_is_offered_at_half_the_rate() {
    let Some((modules, _alone)) = built() else { return };
    let (dir, server) = folder(modules);
    let text = "[rate]\noversample = 64\n[STRING]\nlow = { n = 300, f = '80 Hz', t60 = '2 s', m = '1 g' }\n\
        [SOX]\nout = { from = 'low[7]', gain = 10 }\n";
    std::fs::write(dir.path().join("models/heavy.ca.toml"), text).unwrap();
    let Some(mut tab) = Tab::open(&format!("{}play.html?model=heavy", server.address)) else { return };
    until(&mut tab, "the instrument is there", OPEN);
    tab.js("document.getElementById('play').click()");
    until(&mut tab, "it is said", "document.getElementById('bannerText').textContent.includes('of real time')");
    assert_eq!(tab.js("document.documentElement.dataset.rate"), "48000");
    tab.js("document.getElementById('again').click()");
    until(&mut tab, "it plays at half the rate", "document.documentElement.dataset.rate === '24000'");
    until(&mut tab, "time goes on", "+document.documentElement.dataset.tick > 1000");
    // an edited text keeps the rate
    tab.js("document.getElementById('modelText').value += '\\n'; document.getElementById('apply').click()");
    until(&mut tab, "the new version plays", "+document.documentElement.dataset.generation === 2");
    assert_eq!(tab.js("document.documentElement.dataset.rate"), "24000");
}

/// The package renders in Node, with the bytes of the command, and refuses with the errors of the model.
#[test]
fn the_package_renders_in_node() {
    let Some((modules, _alone)) = built() else { return };
    let (dir, _server) = folder(modules);
    let script = "const [site, out] = process.argv.slice(1); const { render, check } = await import(`${site}/npm/index.js`); \
        const fs = await import('node:fs'), text = fs.readFileSync(`${site}/models/kalimba.ca.toml`, 'utf8'); \
        fs.writeFileSync(out, (await render(text, { seconds: 0.5, file: 'k.ca.toml' })).wav); \
        const found = await check(text), refused = await check('[STRNG]').catch(e => e.message); \
        console.log(JSON.stringify({ masses: found.masses, refused }));";
    let wav = dir.path().join("k.wav");
    let Some(said) = node(&[Path::new("--input-type=module"), Path::new("-e"), Path::new(script), dir.path(), &wav])
    else {
        return;
    };
    let said: Value = serde_json::from_str(&said).unwrap();
    assert!(said["masses"].as_u64().unwrap() > 7 && said["refused"].as_str().unwrap().contains("STRING"), "{said}");
    let text = std::fs::read_to_string(dir.path().join("models/kalimba.ca.toml")).unwrap();
    let render = json!({"type": "render", "file": "k.ca.toml", "text": text, "seconds": 0.5});
    let (_, native) = ca_web::compiler::answer(render.to_string().as_bytes(), &[]);
    assert!(std::fs::read(wav).unwrap() == native);
}

/// The package tunes and measures in Node as natively. Run times differ, and what an FFT or an eigenvalue gives differs in
/// the last bits.
#[test]
fn the_package_tunes_and_measures_in_node() {
    let Some((modules, _alone)) = built() else { return };
    let (dir, _server) = folder(modules);
    let script = "const [site] = process.argv.slice(1), { tune, accuracy } = await import(`${site}/npm/index.js`); \
        const fs = await import('node:fs'), text = fs.readFileSync(`${site}/models/hammered_string.ca.toml`, 'utf8'); \
        const options = { file: 'h.ca.toml', seconds: 0.3, times: [1], reference: 8 }, why = e => e.message; \
        const { page, ...found } = await accuracy(text, options); \
        const stopped = await accuracy(text, { ...options, progress: done => done < 2 }).catch(why); \
        const refused = [await tune(text, 'lo=B2').catch(why), await accuracy('[STRNG]').catch(why)]; \
        console.log(JSON.stringify({ found, page, stopped, refused, tuned: await tune(text, 'low=B2', { file: 'h.ca.toml' }) }));";
    let Some(said) = node(&[Path::new("--input-type=module"), Path::new("-e"), Path::new(script), dir.path()]) else {
        return;
    };
    let said: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(said["stopped"], "the measurement was stopped");
    let refused = |k: usize, word: &str| said["refused"][k].as_str().unwrap().contains(word);
    assert!(refused(0, "did you mean `low`?") && refused(1, "STRING"), "{}", said["refused"]);
    assert!(said["page"].as_str().unwrap().starts_with("<!"));
    let text = std::fs::read_to_string(dir.path().join("models/hammered_string.ca.toml")).unwrap();
    let tune = json!({"type": "tune", "file": "h.ca.toml", "text": text, "parts": ["low=B2"]});
    let (tuned, _) = ca_web::compiler::answer(tune.to_string().as_bytes(), &[]);
    assert_eq!(said["tuned"]["text"], tuned["text"]);
    let (there, here) = (&said["tuned"]["tuned"][0], &tuned["tuned"][0]);
    assert_eq!((&there["number"], &there["part"]), (&here["number"], &here["part"]));
    let near =
        |a: &Value, b: &Value| (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-9 * b.as_f64().unwrap().abs();
    assert!(near(&there["heard_hz"], &here["heard_hz"]), "{there} {here}");
    let request =
        json!({"type": "accuracy", "file": "h.ca.toml", "text": text, "seconds": 0.3, "times": [1], "reference": 8});
    let (found, _) = ca_web::accuracy::answer(request.to_string().as_bytes(), Clock::WALL, &mut |_, _| true);
    for name in ["name", "reference", "refused", "warned"] {
        assert_eq!(said["found"][name], found[name], "{name}");
    }
    for name in ["rate", "seconds"] {
        assert_eq!(said["found"][name].as_f64(), found[name].as_f64(), "{name}");
    }
    let rows = |of: &Value| of["rows"].as_array().unwrap().clone();
    assert_eq!(rows(&said["found"]).len(), rows(&found).len());
    for (there, here) in rows(&said["found"]).iter().zip(&rows(&found)) {
        for name in ["method", "times", "error", "made", "stability"] {
            assert_eq!(there[name], here[name], "{name}: {there} {here}");
        }
        assert!(near(&there["spectrum_error"], &here["spectrum_error"]), "{there} {here}");
        assert!(there["ns_per_sample"].as_f64().unwrap() > 0.0, "{there}");
    }
}

/// Runs Node; `None` without it.
fn node(args: &[&Path]) -> Option<String> {
    let Ok(done) = Command::new("node").args(args).output() else {
        skipped::skipped("node", "no Node.js, so no package is used");
        return None;
    };
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    Some(String::from_utf8(done.stdout).unwrap())
}

#[test]
fn every_model_plays_with_the_bits_of_the_command_in_node_and_in_chromium() {
    let Some((modules, _alone)) = built() else { return };
    let (dir, server) = folder(modules);
    std::fs::write(dir.path().join("npm/second.js"), include_str!("second.js")).unwrap();
    let native = |name: &str| {
        let text = std::fs::read_to_string(dir.path().join("models").join(name)).unwrap();
        second::native(name, &text)
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/node.mjs");
    let mut models = 0;
    for line in node(&[&script, dir.path()]).iter().flat_map(|all| all.lines()) {
        let there: Value = serde_json::from_str(line).unwrap();
        let name = there["file"].as_str().unwrap();
        assert_eq!((&there["samples"], &there["hash"]), native(name).json(), "{name} in Node");
        models += 1;
    }
    assert!(models == 0 || models > 34, "{models}");
    let Some(mut tab) = Tab::open(&server.address) else { return };
    tab.js("Promise.all(['compiler', 'engine'].map(async n => WebAssembly.compile(await (await fetch(n + '.wasm')).arrayBuffer())))\
        .then(async ([c, e]) => { window.engine = e; window.compiler = (await WebAssembly.instantiate(c)).exports; })");
    for entry in std::fs::read_dir(dir.path().join("models")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let there = tab.js(&format!(
            "(async () => {{ const {{ second }} = await import('./npm/second.js'); \
             return second(window.compiler, window.engine, {0}, await (await fetch('models/' + {0})).text()); }})()",
            json!(name)
        ));
        assert_eq!((&there["samples"], &there["hash"]), native(&name).json(), "{name} in Chromium: {:?}", tab.errors());
    }
}
