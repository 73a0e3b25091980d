//! Time from a drag to its sound, in a page with the engine inside.
//!
//! The model rests until it is touched. The page notes the time of the event by which the mouse moves a held mass. A
//! second worklet behind the engine notes the time at which the audio thread has the first sample that is not silence. The
//! browser plays this sample later; the page shows that latency, as it does with `ca play` (`benches/touch.rs` of `ca-cli`).

use crate::browser::Tab;
use serde_json::json;
use std::path::Path;
use std::time::{Duration, Instant};

/// A mass that rests, and decays to silence quickly.
const MODEL: &str =
    "[CEL]\nbar = { m = \"1 g\", f = \"400 Hz\", t60 = \"30 ms\" }\n[SOX]\nout = { from = \"bar\", gain = 1000 }\n";
/// Keeps the worklet of the engine, which a page keeps to itself.
const KEEP: &str = "{ const Made = AudioWorkletNode; \
    window.AudioWorkletNode = class extends Made { constructor(...all) { super(...all); window.engine ??= this; } }; }";
/// Samples beyond 1e-6 of full scale are heard.
const EAR: &str = "(async () => { const source = `registerProcessor('ear', class extends AudioWorkletProcessor { \
    constructor() { super(); this.port.onmessage = () => { this.listens = true; }; } \
    process([input]) { const at = this.listens && input[0] ? input[0].findIndex(x => Math.abs(x) > 1e-6) : -1; \
    if (at >= 0) { this.listens = false; this.port.postMessage(Date.now() + 1e3 * at / sampleRate); } return true; } });`; \
    const { context } = window.engine; \
    await context.audioWorklet.addModule(URL.createObjectURL(new Blob([source], { type: 'text/javascript' }))); \
    const ear = new AudioWorkletNode(context, 'ear', { outputChannelCount: [1] }); \
    ear.port.onmessage = ({ data }) => { window.heard = data; }; \
    window.engine.connect(ear); ear.connect(context.destination); \
    window.listen = () => { window.moved = window.heard = null; ear.port.postMessage(null); }; \
    addEventListener('pointermove', e => { window.moved ??= performance.timeOrigin + e.timeStamp; }, true); return true; })()";

/// Times from the event to the first sample, sorted \[ms\], and the latency of the browser from there, as the page shows
/// it.
pub struct Drag {
    pub times: Vec<f64>,
    pub behind: String,
}

fn wait(tab: &mut Tab, what: &str, is: &str) {
    let end = Instant::now() + Duration::from_secs(60);
    while tab.js(is) != true {
        assert!(Instant::now() < end, "{what}: {:?}", tab.errors());
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Drags `n` times on the site in a folder; `None` without Chromium.
pub fn measured(folder: &Path, address: &str, n: usize) -> Option<Drag> {
    std::fs::write(folder.join("models/bar.ca.toml"), MODEL).expect("a model");
    let mut tab = Tab::open("about:blank")?;
    tab.command("Page.addScriptToEvaluateOnNewDocument", &json!({"source": KEEP}));
    // the second worklet is no file of the site
    tab.command("Page.setBypassCSP", &json!({"enabled": true}));
    tab.command("Page.navigate", &json!({"url": format!("{address}play.html?model=bar")}));
    wait(&mut tab, "the page", "+document.documentElement.dataset.frames > 20");
    tab.js("document.getElementById('sound').click()");
    wait(&mut tab, "the sound", "document.documentElement.dataset.sound === 'on'");
    assert_eq!(tab.js(EAR), true, "{:?}", tab.errors());
    let place =
        tab.js("(r => [r.x, r.y, r.width, r.height])(document.getElementById('canvas').getBoundingClientRect())");
    let [left, top, width, height] = [0, 1, 2, 3].map(|k| place[k].as_f64().expect("a canvas"));
    let [x, y] = [left + width / 2.0, top + height / 2.0];
    let mut times = Vec::new();
    for _ in 0..n {
        tab.mouse("mousePressed", x, y);
        wait(&mut tab, "the mass is held", "document.getElementById('stage').classList.contains('holding')");
        std::thread::sleep(Duration::from_millis(400));
        tab.js("window.listen()");
        std::thread::sleep(Duration::from_millis(50));
        tab.mouse("mouseMoved", x, y - 40.0);
        wait(&mut tab, "it is heard", "window.heard !== null && window.moved !== null");
        times.push(tab.js("window.heard - window.moved").as_f64().expect("a time"));
        tab.mouse("mouseReleased", x, y - 40.0);
        std::thread::sleep(Duration::from_millis(400));
    }
    times.sort_by(f64::total_cmp);
    let fact = "[...document.querySelectorAll('#facts dt')].find(e => e.textContent === 'This page')?.nextSibling.textContent ?? 'not shown'";
    let behind = tab.js(fact).as_str().unwrap_or_default().to_owned();
    Some(Drag { times, behind })
}
