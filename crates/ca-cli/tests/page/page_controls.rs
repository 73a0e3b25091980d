//! Tests the page: one button that plays, keys that sound, buttons of constant size, and a steady magnification.

use crate::browser::Tab;
use crate::host::{Host, peak, until};
use serde_json::{Value, json};
use std::path::Path;

/// A blow at load that is over before a user looks; nothing moves it again.
const ONCE: &str = r#"
[model]
title = "Struck at load"
seconds = 1
[STRING]
low = { n = 40, f = "110 Hz", t60 = "0.3 s", m = "1 g" }
[MAS]
hammer = { m = "20 g", x = "-5 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[8]"], k = "8 kN/m", z = "0.2 N s/m" }
[SOX]
out = { from = "low[3]", gain = 800 }
"#;

fn bundled(name: &str) -> String {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    std::fs::read_to_string(models.join(format!("{name}.ca.toml"))).unwrap()
}

/// Opens the page in a browser, and waits until it is drawn; `None` without a browser.
fn drawn(host: &Host) -> Option<Tab> {
    let mut tab = Tab::open(&host.address)?;
    until("it is drawn", || tab.js("+document.documentElement.dataset.frames > 5") == true);
    Some(tab)
}

fn end(mut host: Host) {
    host.page().done(&json!({"type": "stop"}));
    host.ended();
}

/// The instrument restarts as at load, and its gesture with it.
pub fn it_plays_from_its_beginning() {
    let host = Host::play(ONCE, &[]);
    let mut page = host.page();
    page.next("scene");
    page.done(&json!({"type": "sound", "on": true}));
    until("it has died away", || peak(&page.hear(0.1)) < 1e-6);
    page.done(&json!({"type": "play"}));
    assert_eq!(page.next("scene")["generation"], 2);
    until("it sounds again", || peak(&page.hear(0.05)) > 0.01);
    end(host);

    let host = Host::play(crate::STRING, &[]);
    let mut page = host.page();
    page.next("scene");
    page.done(&json!({"type": "play"}));
    until("its gesture plays", || page.next("state")["playing"] == true);
    until("and ends", || page.next("state")["playing"] == false);
    end(host);
}

/// A kalimba offers only the seven keys that have a tine.
pub fn only_keys_that_sound_are_keys() {
    let host = Host::play(&bundled("kalimba"), &[]);
    let mut page = host.page();
    assert_eq!(page.next("scene")["notes"], json!([60, 62, 64, 65, 67, 69, 72]));
    if let Some(mut tab) = Tab::open(&host.address) {
        until("the keyboard is there", || tab.js("document.querySelectorAll('#keyboard button').length") == 13);
        let keys = "[...document.querySelectorAll('#keyboard button:enabled')].map(k => +k.dataset.note)";
        assert_eq!(tab.js(keys), json!([60, 62, 64, 65, 67, 69, 72]));
        assert_eq!(tab.errors(), Vec::<String>::new());
    }
    end(host);
}

/// The buttons of a game controller are keys, and its sticks MIDI controllers.
pub fn a_game_controller_plays() {
    let host = Host::play(crate::STRING, &["--seconds", "600"]);
    let Some(mut tab) = drawn(&host) else { return };
    let mut page = host.page();
    page.next("scene");
    tab.js("(() => { window.pad = { index: 0, connected: true, axes: [0, 0, 0, 0], \
         buttons: Array.from({ length: 16 }, () => ({ pressed: false, value: 0 })) }; \
         navigator.getGamepads = () => [window.pad]; })()");
    let frames = "new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(true))))";
    until("it was read once", || tab.js(frames) == true);
    page.done(&json!({"type": "sound", "on": true}));
    tab.js("(() => { window.pad.buttons[1].pressed = true; })()");
    until("the second key is down", || tab.js("+document.querySelector('#keyboard .down')?.dataset.note") == 61);
    until("it sounds", || peak(&page.hear(0.05)) > 1e-3);
    tab.js("(() => { window.pad.buttons[1].pressed = false; })()");
    until("the key is up", || tab.js("document.querySelector('#keyboard .down') === null") == true);
    tab.js("document.querySelector('#params .learn').click()");
    until("it waits", || !page.next("state")["learning"].is_null());
    tab.js("(() => { window.pad.axes[2] = 1; })()");
    until("the stick is bound", || page.next("state")["bound"][0]["number"] == 18);
    end(host);
}

/// Two fingers hold two masses.
pub fn two_fingers_hold_two_masses() {
    let host = Host::play(crate::STRING, &["--seconds", "600"]);
    let Some(mut tab) = drawn(&host) else { return };
    let mut watch = host.page();
    watch.next("scene");
    let [x, y] = tab.near().expect("some mass is near the middle");
    let touch = |tab: &mut Tab, kind: &str, fingers: &[(f64, u32)]| {
        let points: Vec<Value> =
            fingers.iter().map(|(dx, id)| json!({"x": x + dx, "y": y - 0.2 * dx, "id": id})).collect();
        tab.emulate("Input.dispatchTouchEvent", &json!({"type": kind, "touchPoints": points}));
    };
    let held = |watch: &mut crate::host::Client| watch.next("state")["held"].as_array().map_or(0, Vec::len);
    touch(&mut tab, "touchStart", &[(0.0, 1)]);
    until("one is held", || held(&mut watch) == 1);
    touch(&mut tab, "touchStart", &[(0.0, 1), (90.0, 2)]);
    until("two are held", || held(&mut watch) == 2);
    until("two are drawn", || tab.js("document.querySelectorAll('#overlay g:not(.off)').length") == 2);
    touch(&mut tab, "touchEnd", &[(90.0, 2)]);
    until("one is let go", || held(&mut watch) == 1);
    touch(&mut tab, "touchEnd", &[]);
    until("both are let go", || held(&mut watch) == 0);
    assert_eq!(tab.errors(), Vec::<String>::new());
    end(host);
}

/// One button turns the sound on and plays; afterwards its label is "Play again". In a narrow window, buttons keep
/// their size.
pub fn one_button_plays() {
    let host = Host::play(crate::STRING, &["--audio", "page"]);
    let Some(mut tab) = Tab::open(&host.address) else { return };
    tab.looks(390, 844, "dark");
    until("it is drawn", || tab.js("+document.documentElement.dataset.frames > 5") == true);
    let label = |tab: &mut Tab| tab.js("document.getElementById('play').textContent.trim()");
    let sizes = |tab: &mut Tab| -> Value {
        tab.js(
            "[...document.querySelectorAll('.tools button, #params .learn, #params .value')].map(b => \
             { const r = b.getBoundingClientRect(); return [Math.round(r.x), Math.round(r.width), Math.round(r.height)]; })",
        )
    };
    assert_eq!(label(&mut tab), "Play");
    let before = sizes(&mut tab);
    tab.js("document.getElementById('play').click()");
    until("it plays", || label(&mut tab) == "Stop");
    until("the sound is on", || tab.js("document.getElementById('sound').dataset.on") == "true");
    assert_eq!(sizes(&mut tab), before, "while it plays");
    until("it has played", || label(&mut tab) == "Play again");
    tab.js("document.getElementById('mute').click()");
    tab.js("document.querySelector('.learn').click()");
    until("it waits for a knob", || tab.js("document.querySelector('.learn').textContent") == "turn a knob…");
    tab.js("(() => { const r = document.querySelector('#params input[type=range]'); r.value = 0; r.dispatchEvent(new Event('input')); })()");
    assert_eq!(sizes(&mut tab), before, "muted, learning, moved");
    assert_eq!(tab.js("document.documentElement.scrollWidth <= innerWidth"), true);
    assert_eq!(tab.js("+document.documentElement.dataset.generation"), 2);
    assert_eq!(tab.errors(), Vec::<String>::new());
    end(host);
}

/// Magnification four times per second, for `n` masses at positions `at(i, t)` \[m\].
fn factors(tab: &mut Tab, n: usize, at: &str) -> Vec<f64> {
    let script = format!(
        "(async () => {{ const {{ Motion }} = await import('./motion.js'); const n = {n}, at = {at}, out = []; \
         const scene = {{ numbers: n, n, offset: Uint32Array.from({{ length: n + 1 }}, (_, i) => i), space: new Uint8Array(n), \
         counted: new Uint8Array(n).fill(1), linear: true, extent: 1, line: 20, true: 1 }}; const m = new Motion(scene); \
         for (let k = 0; k < 600; k++) {{ const t = k / 60; m.push(Float32Array.from({{ length: n }}, (_, i) => at(i, t)), t + 1e-6, t); \
         m.exaggerate(t); if (k % 15 === 14) out.push(scene.line); }} return out; }})()"
    );
    tab.js(&script).as_array().expect("numbers").iter().map(|f| f.as_f64().unwrap()).collect()
}

/// A string plucked after a second, and 24 strings of 75 masses whose keys move ninety times as far, one after the
/// other.
pub fn magnification_settles_and_is_calm() {
    let host = Host::play(crate::STRING, &[]);
    let Some(mut tab) = drawn(&host) else { return };
    let string =
        "(i, t) => t < 1 ? 0 : 1e-4 * Math.sin(Math.PI * (i + 1) / 41) * Math.cos(692.1 * t) * 10 ** (-0.5 * (t - 1))";
    let piano = "(i, t) => { const key = Math.floor(i / 80), j = i % 80, s = t - 1 - 0.4 * key; if (s < 0 || key > 23) return 0; \
                 if (j < 5) return s < 0.3 ? -9e-3 * Math.min(1, s / 0.04) : 0; \
                 return s < 0.05 ? 0 : 1e-4 * Math.sin(Math.PI * j / 80) * Math.cos(825.4 * t) * 10 ** (-0.5 * s); }";
    for (name, n, at) in [("string", 40, string), ("piano", 2400, piano)] {
        let all = factors(&mut tab, n, at);
        let late = &all[8..];
        for w in late.windows(2) {
            let step = (w[1] / w[0]).ln().abs();
            assert!(step < 0.15, "{name}: from {:.0} to {:.0} in a quarter of a second; {all:.0?}", w[0], w[1]);
        }
        // motion of 0.1 mm is drawn as at least 1 % of the picture, even if keys move beyond it
        assert!(late.iter().all(|f| f * 1e-4 > 0.01), "{name} looks frozen: {all:.0?}");
    }
    end(host);
}
