//! Checks of the page through a browser alone, so that they hold whatever carries its messages: the socket of `ca play`,
//! or the engine inside the page. Tests of `ca-cli` and `ca-site` open the page and run each check on a fresh one.

use crate::browser::Tab;
use crate::page::{Page, drawn, near, point, press, until};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// A string and a bob with a live parameter, keys and a gesture.
pub const STRING: &str = r#"
[model]
title = "A string and a bob"
[param]
k = { value = "2 kN/m", unit = "N/m", live = true, min = 200, max = 4000, doc = "stiffness of the bob" }
[STRING]
low = { n = 30, f = "110 Hz", t60 = "3 s", m = "1 g" }
[MAS]
bob = { m = "10 g" }
[SOL]
wall = {}
[REF]
spring = { between = ["wall", "bob"], k = "k", z = 0.2 }
[ENF]
push = { to = "low[4]", midi = { note = ["C4", "E5"], to = "5 N", attack = "1 ms" } }
[SOX]
left = { from = "low[6]", gain = 200 }
right = { from = "bob", gain = 200 }
[gesture]
push = [[0, 0], [0.01, 0.5], [0.02, 0], [0.6, 0]]
"#;

/// A blow at load that is over before a user looks; nothing moves it again.
pub const ONCE: &str = r#"
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

const KALIMBA: &str = include_str!("../../models/kalimba.ca.toml");

/// A check, and the model that its page plays.
pub struct Check {
    pub name: &'static str,
    pub model: &'static str,
    run: Run,
}

enum Run {
    /// In any browser.
    Page(fn(&mut dyn Page)),
    /// With fingers or a small screen, as the DevTools protocol has them.
    Chromium(fn(&mut Tab)),
}

const fn check(name: &'static str, model: &'static str, run: Run) -> Check {
    Check { name, model, run }
}

pub const CHECKS: [Check; 14] = [
    check("only keys that sound are keys", KALIMBA, Run::Page(only_keys_that_sound_are_keys)),
    check("one button plays", STRING, Run::Chromium(one_button_plays)),
    check("it plays from its beginning", ONCE, Run::Page(it_plays_from_its_beginning)),
    check("a mouse pulls a mass", STRING, Run::Page(a_mouse_pulls_a_mass)),
    check("two fingers hold two masses", STRING, Run::Chromium(two_fingers_hold_two_masses)),
    check("keys play", STRING, Run::Page(keys_play)),
    check("MIDI of the browser plays, with a pedal", STRING, Run::Page(midi_plays)),
    check("a game controller plays", STRING, Run::Page(a_game_controller_plays)),
    check("sliders and presets set values", STRING, Run::Page(sliders_and_presets_set_values)),
    check("any number changes, and a wrong one is refused", STRING, Run::Page(any_number_changes)),
    check("a screen goes off and on", STRING, Run::Page(a_screen_goes_off_and_on)),
    check("a browser without an output says so", STRING, Run::Page(a_missing_output_is_told)),
    check("magnification settles and is calm", STRING, Run::Page(magnification_settles_and_is_calm)),
    check("what the connection cannot do is not offered", STRING, Run::Page(nothing_impossible_is_offered)),
];

impl Check {
    /// Runs the check on a page that was just opened with the model.
    pub fn in_chromium(&self, tab: &mut Tab) {
        let Run::Chromium(run) = self.run else { return self.in_any(tab) };
        println!("check: {}", self.name);
        drawn(tab);
        run(tab);
        self.ended(tab);
    }

    /// Runs the check in any browser. A check that only Chromium can do is left out.
    pub fn in_any(&self, page: &mut dyn Page) {
        if let Run::Page(run) = self.run {
            println!("check: {}", self.name);
            drawn(page);
            run(page);
            self.ended(page);
        }
    }

    fn ended(&self, page: &mut dyn Page) {
        let quiet = "(d => [d.errors, d.violations])(document.documentElement.dataset)";
        assert_eq!((page.js(quiet), page.errors()), (json!(["0", "0"]), Vec::new()), "{}", self.name);
        assert_eq!(page.js("document.documentElement.scrollWidth <= innerWidth"), true, "{}", self.name);
    }
}

/// Turns the sound on, so that time goes on.
fn sound_on(page: &mut dyn Page) {
    press(page, "#sound");
    until(page, "the sound is on", "document.documentElement.dataset.sound === 'on'");
    until(page, "time goes on", "window.state.tick > 0");
}

/// A kalimba offers only the seven keys that have a tine.
fn only_keys_that_sound_are_keys(page: &mut dyn Page) {
    until(page, "the keyboard is there", "document.querySelectorAll('#keyboard button').length === 13");
    let keys = "[...document.querySelectorAll('#keyboard button:enabled')].map(k => +k.dataset.note)";
    assert_eq!(page.js(keys), json!([60, 62, 64, 65, 67, 69, 72]));
}

/// One button turns the sound on and plays; afterwards its label is "Play again". In a narrow window, buttons keep
/// their size.
fn one_button_plays(page: &mut Tab) {
    page.looks(390, 844, "dark");
    std::thread::sleep(Duration::from_millis(300));
    drawn(page);
    let label = "document.getElementById('play').textContent.trim()";
    let sizes = "[...document.querySelectorAll('.tools button, #params .learn, #params .value')].map(b => \
        { const r = b.getBoundingClientRect(); return [Math.round(r.x), Math.round(r.width), Math.round(r.height)]; })";
    assert_eq!(page.js(label), "Play");
    let before = page.js(sizes);
    page.js("document.getElementById('play').click()");
    until(page, "it plays", &format!("{label} === 'Stop'"));
    until(page, "the sound is on", "document.getElementById('sound').dataset.on === 'true'");
    assert_eq!(page.js(sizes), before, "while it plays");
    until(page, "it has played", &format!("{label} === 'Play again'"));
    page.js("document.getElementById('mute').click()");
    page.js("document.querySelector('.learn').click()");
    until(page, "it waits for a knob", "document.querySelector('.learn').textContent === 'turn a knob…'");
    page.js("(() => { const r = document.querySelector('#params input[type=range]'); r.value = 0; r.dispatchEvent(new Event('input')); })()");
    assert_eq!(page.js(sizes), before, "muted, learning, moved");
    assert_eq!(page.js("+document.documentElement.dataset.generation"), 2);
}

/// The instrument restarts as at load.
fn it_plays_from_its_beginning(page: &mut dyn Page) {
    sound_on(page);
    until(page, "it has died away", "document.getElementById('decibels').textContent === 'silent'");
    assert_eq!(page.js("document.documentElement.dataset.generation"), "1");
    page.js("document.getElementById('play').click()");
    until(page, "it sounds again", "document.documentElement.dataset.generation === '2' && window.loud() > 0.01");
}

/// A mouse that drags a mass holds it, and the string rings when it is let go.
fn a_mouse_pulls_a_mass(page: &mut dyn Page) {
    sound_on(page);
    assert_eq!(page.js("window.loud()"), 0, "nobody has touched it");
    let before = page.part("canvas");
    let [x, y] = near(page, "low[");
    page.mouse("mousePressed", x, y);
    until(page, "it is held", "window.state.held.length === 1");
    assert_eq!(page.js("document.getElementById('stage').classList.contains('holding')"), true);
    for n in 0..15 {
        page.mouse("mouseMoved", x, y - 4.0 * f64::from(n));
    }
    let end = Instant::now() + Duration::from_secs(60);
    while page.part("canvas") == before {
        assert!(Instant::now() < end, "the picture does not move");
    }
    page.mouse("mouseReleased", x, y - 60.0);
    until(page, "it is let go", "window.state.held.length === 0");
    until(page, "it rings", "window.loud() > 1e-4");
    until(page, "its energy is drawn", "+document.documentElement.dataset.energy > 0");
}

/// Two fingers hold two masses.
fn two_fingers_hold_two_masses(page: &mut Tab) {
    sound_on(page);
    let [x, y] = near(page, "low[");
    let mut touch = |kind: &str, fingers: &[(f64, u32)], held: u32| {
        let points: Vec<Value> =
            fingers.iter().map(|(dx, id)| json!({"x": x + dx, "y": y - 0.2 * dx, "id": id})).collect();
        page.command("Input.dispatchTouchEvent", &json!({"type": kind, "touchPoints": points}));
        until(page, &format!("{held} are held"), &format!("window.state.held.length === {held}"));
        let drawn = format!("document.querySelectorAll('#overlay g:not(.off)').length === {held}");
        until(page, &format!("{held} are drawn"), &drawn);
    };
    touch("touchStart", &[(0.0, 1)], 1);
    touch("touchStart", &[(0.0, 1), (90.0, 2)], 2);
    touch("touchEnd", &[(90.0, 2)], 1);
    touch("touchEnd", &[], 0);
}

/// Keys on the screen play, and computer keys once they are switched on.
fn keys_play(page: &mut dyn Page) {
    sound_on(page);
    let [x, y] = point(page, "[data-note=\"64\"]", 0.9);
    page.mouse("mousePressed", x, y);
    until(page, "a key sounds", "window.loud() > 0.02");
    assert_eq!(page.js("document.querySelector('#keyboard .down')?.dataset.note"), "64");
    page.mouse("mouseReleased", x, y);
    assert_eq!(page.js("document.querySelector('#keyboard .down') === null"), true);
    until(page, "it is quiet again", "window.loud() < 0.01");
    let letter = |kind: &str| {
        format!("document.body.dispatchEvent(new KeyboardEvent('{kind}', {{ code: 'KeyX', bubbles: true }}))")
    };
    page.js(&letter("keydown"));
    assert_eq!(page.js("document.querySelector('#keyboard .down') === null"), true, "letters are off");
    page.js("document.getElementById('letters').click()");
    page.js(&letter("keydown"));
    assert_eq!(page.js("document.querySelector('#keyboard .down')?.dataset.note"), "62");
    until(page, "a letter sounds", "window.loud() > 0.02");
    page.js(&letter("keyup"));
    assert_eq!(page.js("document.querySelector('#keyboard .down') === null"), true);
}

/// MIDI devices of the browser play, and the pedal holds a key that comes up.
fn midi_plays(page: &mut dyn Page) {
    sound_on(page);
    page.js(
        "(() => { const input = { name: 'Keys' }; navigator.requestMIDIAccess = async () => ({ inputs: new Map([['a', input]]) }); \
         window.midi = (...bytes) => input.onmidimessage({ data: Uint8Array.from(bytes) }); document.getElementById('webmidi').click(); })()",
    );
    until(page, "the device is named", "document.getElementById('webmidi').textContent === 'MIDI: Keys'");
    page.js("(() => { midi(0xb0, 64, 127); midi(0x90, 64, 100); })()");
    until(page, "a note sounds", "window.loud() > 0.02");
    // a key that is down presses the string, which comes to rest elsewhere
    until(page, "the string moves", "window.motion > 1e-8");
    until(page, "the string is still", "window.motion < 1e-12");
    let played = page.js("window.state.tick").as_f64().expect("a tick");
    page.js("midi(0x80, 64, 0)");
    until(page, "half a second passes", &format!("window.state.tick > {}", played + 24_000.0));
    assert_eq!(page.js("window.motion < 1e-9"), true, "the pedal holds the key");
    page.js("midi(0xb0, 64, 0)");
    until(page, "it comes up with the pedal", "window.motion > 1e-8");
}

/// The buttons of a game controller are keys, and its sticks MIDI controllers.
fn a_game_controller_plays(page: &mut dyn Page) {
    sound_on(page);
    page.js("(() => { window.pad = { index: 0, connected: true, axes: [0, 0, 0, 0], \
         buttons: Array.from({ length: 16 }, () => ({ pressed: false, value: 0 })) }; \
         navigator.getGamepads = () => [window.pad]; })()");
    let frames = "new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(true))))";
    until(page, "it was read once", frames);
    page.js("(() => { window.pad.buttons[1].pressed = true; })()");
    until(page, "the second key is down", "+document.querySelector('#keyboard .down')?.dataset.note === 61");
    until(page, "it sounds", "window.loud() > 1e-3");
    page.js("(() => { window.pad.buttons[1].pressed = false; })()");
    until(page, "the key is up", "document.querySelector('#keyboard .down') === null");
    page.js("document.querySelector('#params .learn').click()");
    until(page, "it waits", "window.state.learning === 'k'");
    page.js("(() => { window.pad.axes[2] = 1; })()");
    until(page, "the stick is bound", "window.state.bound[0]?.number === 18");
    page.js("(() => { window.pad.axes[2] = 0.5; })()");
    until(page, "the stick sets it", "window.state.params.k > 2000 && window.state.params.k < 4000");
}

/// A slider, a typed value and a preset set the parameter in the engine, and a wrong value is refused beside it.
fn sliders_and_presets_set_values(page: &mut dyn Page) {
    sound_on(page);
    until(page, "it is as at load", "window.state.params.k === 2000");
    page.js("document.getElementById('presetsBox').open = true");
    page.js("(() => { document.getElementById('presetName').value = 'soft'; document.querySelector('#presetForm button').click(); })()");
    page.js("(() => { const r = document.querySelector('#params input[type=range]'); r.value = 0; r.dispatchEvent(new Event('input')); })()");
    until(page, "the slider has set it", "window.state.params.k === 200");
    page.js("document.querySelector('#presets .pick').click()");
    until(page, "the preset has set it", "window.state.params.k === 2000");
    page.js(
        "(() => { const m = document.getElementById('morph'); m.value = 50; m.dispatchEvent(new Event('input')); })()",
    );
    until(page, "half of the way is half of it", "window.state.params.k === 1100");
    let typed = |text: &str| {
        format!(
            "(() => {{ const f = document.querySelector('#params .value'); f.value = '{text}'; \
             f.dispatchEvent(new KeyboardEvent('keydown', {{ key: 'Enter' }})); }})()"
        )
    };
    page.js(&typed("0.9 kN/m"));
    until(page, "the typed value is set", "window.state.params.k === 900");
    page.js(&typed("9 kN/m"));
    let refused = "document.querySelector('#params .error').textContent.includes('between')";
    until(page, "a value out of range is refused", refused);
    assert_eq!(page.js("window.state.params.k"), 900);
}

/// Any number of the model changes by its name. A wrong value is reported, and the version before plays on.
fn any_number_changes(page: &mut dyn Page) {
    sound_on(page);
    let change = |name: &str, value: &str| {
        format!(
            "(() => {{ document.getElementById('changeName').value = '{name}'; document.getElementById('changeValue').value = '{value}'; \
             document.querySelector('#changeForm button').click(); }})()"
        )
    };
    page.js(&change("low.t60", "0.5 s"));
    until(page, "the new version plays", "document.documentElement.dataset.generation === '2'");
    page.js(&change("low.t60", "-1 s"));
    let report = "(r => !r.hidden && r.textContent.includes('`t60`'))(document.getElementById('report'))";
    until(page, "the error is shown", report);
    page.js(&change("low.tt60", "1 s"));
    let told = "['news', 'report'].some(id => (e => !e.hidden && e.textContent.includes('tt60'))(document.getElementById(id)))";
    until(page, "a wrong name is told", told);
    assert_eq!(page.js("document.documentElement.dataset.generation"), "2");
    let tick = page.js("window.state.tick").as_f64().expect("a tick");
    until(page, "the version before plays on", &format!("window.state.tick > {tick}"));
    page.js(&change("low.t60", "1 s"));
    until(page, "a right one plays", "document.documentElement.dataset.generation === '3'");
    until(page, "the error is gone", "document.getElementById('report').hidden");
}

/// A screen that goes off lets the masses go, and the system may stop the sound. When it is on again, the sound goes on.
fn a_screen_goes_off_and_on(page: &mut dyn Page) {
    sound_on(page);
    let [x, y] = near(page, "low[");
    page.mouse("mousePressed", x, y);
    until(page, "it is held", "window.state.held.length === 1");
    let screen = |hidden: bool| {
        format!(
            "(() => {{ Object.defineProperty(document, 'hidden', {{ configurable: true, get: () => {hidden} }}); \
             document.dispatchEvent(new Event('visibilitychange')); }})()"
        )
    };
    page.js(&screen(true));
    until(page, "it is let go", "!document.getElementById('stage').classList.contains('holding')");
    assert_eq!(page.js("Promise.all([...window.contexts].map(c => c.suspend())).then(all => all.length)"), 1);
    page.mouse("mouseReleased", x, y);
    page.js(&screen(false));
    until(page, "the sound goes on", "[...window.contexts].every(c => c.state === 'running')");
    assert_eq!(page.js("document.documentElement.dataset.sound"), "on");
    until(page, "nothing is held", "window.state.held.length === 0");
    let [x, y] = point(page, "[data-note=\"64\"]", 0.9);
    page.mouse("mousePressed", x, y);
    until(page, "a key sounds", "window.loud() > 0.02");
    page.mouse("mouseReleased", x, y);
}

/// A browser without an output never starts the sound, which the page says.
fn a_missing_output_is_told(page: &mut dyn Page) {
    page.js("(() => { AudioContext.prototype.resume = () => new Promise(() => {}); })()");
    press(page, "#sound");
    until(page, "it is told", "document.getElementById('news').textContent.includes('no output for sound')");
    assert_eq!(page.js("document.documentElement.dataset.sound"), "failed");
}

/// A control that needs the other kind of connection is not shown.
fn nothing_impossible_is_offered(page: &mut dyn Page) {
    sound_on(page);
    let shown = |page: &mut dyn Page, id: &str| {
        page.js(&format!("document.getElementById('{id}').getClientRects().length > 0"))
    };
    // no model here has a device
    assert_eq!(shown(page, "arm"), false);
    let here = page.js("document.documentElement.dataset.engine") == "browser";
    page.js("document.getElementById('textBox').open = true");
    for (id, needs_program) in [
        ("stop", true),
        ("save", true),
        ("modelText", false),
        ("apply", false),
        ("render", false),
        ("modes", false),
        ("saveText", false),
        ("share", false),
    ] {
        assert_eq!(shown(page, id), needs_program != here, "{id}");
    }
    // both record the sound, each in its own place
    let place = if here { "saves it as a WAV file" } else { "in the folder where `ca play` was started" };
    assert_eq!(shown(page, "record"), true);
    assert_eq!(page.js(&format!("document.getElementById('record').title.includes('{place}')")), true);
    if here {
        assert_eq!(shown(page, "output"), false, "the browser chooses the output");
        assert_eq!(shown(page, "sharing"), false, "the text has its own links");
    }
}

/// Magnification four times per second, for `n` masses at positions `at(i, t)` \[m\].
fn factors(page: &mut dyn Page, n: usize, at: &str) -> Vec<f64> {
    let script = format!(
        "(async () => {{ const {{ Motion }} = await import('./motion.js'); const n = {n}, at = {at}, out = []; \
         const scene = {{ numbers: n, n, offset: Uint32Array.from({{ length: n + 1 }}, (_, i) => i), space: new Uint8Array(n), \
         counted: new Uint8Array(n).fill(1), linear: true, extent: 1, line: 20, true: 1 }}; const m = new Motion(scene); \
         for (let k = 0; k < 600; k++) {{ const t = k / 60; m.push(Float32Array.from({{ length: n }}, (_, i) => at(i, t)), t + 1e-6, t); \
         m.exaggerate(t); if (k % 15 === 14) out.push(scene.line); }} return out; }})()"
    );
    page.js(&script).as_array().expect("numbers").iter().map(|f| f.as_f64().unwrap()).collect()
}

/// A string plucked after a second, and 24 strings of 75 masses whose keys move ninety times as far, one after the
/// other.
fn magnification_settles_and_is_calm(page: &mut dyn Page) {
    let string =
        "(i, t) => t < 1 ? 0 : 1e-4 * Math.sin(Math.PI * (i + 1) / 41) * Math.cos(692.1 * t) * 10 ** (-0.5 * (t - 1))";
    let piano = "(i, t) => { const key = Math.floor(i / 80), j = i % 80, s = t - 1 - 0.4 * key; if (s < 0 || key > 23) return 0; \
                 if (j < 5) return s < 0.3 ? -9e-3 * Math.min(1, s / 0.04) : 0; \
                 return s < 0.05 ? 0 : 1e-4 * Math.sin(Math.PI * j / 80) * Math.cos(825.4 * t) * 10 ** (-0.5 * s); }";
    for (name, n, at) in [("string", 40, string), ("piano", 2400, piano)] {
        let all = factors(page, n, at);
        let late = &all[8..];
        for w in late.windows(2) {
            let step = (w[1] / w[0]).ln().abs();
            assert!(step < 0.15, "{name}: from {:.0} to {:.0} in a quarter of a second; {all:.0?}", w[0], w[1]);
        }
        // motion of 0.1 mm is drawn as at least 1 % of the picture, even if keys move beyond it
        assert!(late.iter().all(|f| f * 1e-4 > 0.01), "{name} looks frozen: {all:.0?}");
    }
}
