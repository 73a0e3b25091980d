//! Tests `ca play` as users run it: the built command, with its page over a real socket and in a real Chromium. The
//! tests run in real time, so `tests/run` runs them with the tests of the haptic loop.

mod browser;
#[cfg(target_os = "linux")]
mod browser_start;
mod host;
mod inconvenient_times;
#[cfg(unix)]
mod midi_osc;
mod page_controls;
mod pictures;
mod share;

#[path = "../../../../tests/src/long_form.rs"]
mod long_form;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;
mod soak;

use host::{Host, peak, until};
use serde_json::json;

const STRING: &str = r#"
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

mod in_real_time {
    use super::*;

    #[test]
    fn what_is_done_in_a_page_is_seen_heard_and_replayed_to_the_bit() {
        let mut host = Host::play(STRING, &["--log", "take.mcap", "--energy"]);
        let mut page = host.page();
        let scene = page.next("scene");
        assert_eq!((&scene["channels"], &scene["gesture"]), (&json!(["left", "right"]), &json!(true)));
        assert_eq!(scene["params"][0]["unit"], "N/m");
        let masses = scene["drawing"]["masses"].as_u64().unwrap();
        let named = |page: &mut host::Client, name: &str| {
            (0..masses).find(|m| page.ask(&json!({"type": "pick", "mass": m}))["name"] == name).unwrap()
        };
        page.done(&json!({"type": "sound", "on": true}));
        assert_eq!(peak(&page.hear(0.1)), 0.0, "nobody has touched it");
        let still = page.look();
        assert!(still.iter().all(|x| *x == 0.0));

        let mass = named(&mut page, "low[10]");
        page.done(&json!({"type": "grab", "mass": mass}));
        for n in 1..=20 {
            page.done(&json!({"type": "drag", "by": [1e-4 * f64::from(n)]}));
        }
        // as far as the string allows
        until("the mass follows", || page.look()[mass as usize] > 1e-4);
        until("the held mass is named", || page.next("state")["held"] == json!([mass]));
        let second = named(&mut page, "bob");
        page.done(&json!({"type": "grab", "mass": second, "finger": 1}));
        page.done(&json!({"type": "drag", "by": [-1e-3], "finger": 1}));
        until("the mass of the second finger follows", || page.look()[second as usize] < -1e-4);
        page.done(&json!({"type": "release", "finger": 1}));
        until("the first finger still holds", || page.next("state")["held"] == json!([mass]));
        page.done(&json!({"type": "release"}));
        let rung = page.hear(0.2);
        assert!(peak(&rung) > 0.01, "a string that was let go sounds: {}", peak(&rung));
        until("nobody is held", || page.next("state")["held"] == json!([]));

        page.done(&json!({"type": "set", "values": {"k": "900 N/m"}}));
        until("the parameter is shown", || page.next("state")["params"]["k"] == 900.0);
        page.done(&json!({"type": "port", "name": "push", "value": 0.2}));
        page.done(&json!({"type": "gesture", "play": true}));
        until("it plays", || page.next("state")["playing"] == true);
        until("it has ended", || page.next("state")["playing"] == false);
        for (request, why) in [
            (json!({"type": "grab", "mass": 1_000_000}), "does not exist"),
            (json!({"type": "grab", "mass": named(&mut page, "wall")}), "fixed"),
            (json!({"type": "drag", "by": [1]}), "does not hold a mass"),
            (json!({"type": "set", "values": {"k": 1e9}}), "between"),
            (json!({"type": "set", "values": {"kk": 1}}), "not a live parameter"),
            (json!({"type": "port", "name": "pull", "value": 1}), "`push`"),
            (json!({"type": "port", "name": "push", "value": "x"}), "number"),
            (json!({"type": "arm", "on": true}), "--allow-arm"),
            (json!({"type": "fly"}), "`fly`"),
        ] {
            let reply = page.ask(&request);
            assert_eq!(reply["ok"], false, "{request}");
            assert!(reply["text"].as_str().unwrap().contains(why), "{request}: {reply}");
        }
        // a client that disappears releases its mass
        let mut other = host.page();
        let mass = named(&mut page, "low[3]");
        other.done(&json!({"type": "grab", "mass": mass}));
        let second = page.ask(&json!({"type": "grab", "mass": mass}));
        assert!(second["text"].as_str().unwrap().contains("another page"), "{second}");
        drop(other);
        until("it is let go", || page.next("state")["held"] == json!([]));
        page.done(&json!({"type": "stop"}));
        host.ended();
        let replayed = host.ca(&["replay", "take.mcap", "--verify", "--energy", "--json"]);
        let verdict: serde_json::Value = serde_json::from_str(&replayed).unwrap_or_else(|e| panic!("{e}: {replayed}"));
        assert_eq!(verdict["identical"], true, "{replayed}");
    }

    /// Saves the file while it plays. A new version goes on, a broken one is reported while the old one goes on, and a
    /// number that is not live can be changed.
    #[test]
    fn an_edited_model_plays_on() {
        let mut host = Host::play(STRING, &["--log", "take.mcap", "--energy"]);
        let mut page = host.page();
        assert_eq!(page.next("scene")["generation"], 1);
        page.done(&json!({"type": "sound", "on": true}));
        page.done(&json!({"type": "set", "values": {"k": 1000}}));
        page.done(&json!({"type": "port", "name": "push", "value": 2}));
        until("the string is pressed", || peak(&page.hear(0.05)) > 0.01);
        let edited = STRING.replace("n = 30", "n = 34").replace("max = 4000", "max = 5000");
        host.write(&edited);
        let report = page.next("report");
        assert_eq!(report["ok"], true, "{report}");
        let scene = page.next("scene");
        assert_eq!((&scene["generation"], &scene["params"][0]["max"]), (&json!(2), &json!(5000.0)));
        let masses = scene["drawing"]["masses"].as_u64().unwrap();
        until("pictures are of it", || page.look_at(2).len() as u64 == masses);
        // values set by hand stay, and so does the port
        until("the parameter is where it was", || page.next("state")["params"]["k"] == 1000.0);
        assert!(peak(&page.hear(0.05)) > 0.01, "the port presses on");

        host.write(&edited.replace("[STRING]", "[STRNG]"));
        let report = page.next("report");
        assert_eq!(report["ok"], false);
        assert!(report["text"].as_str().unwrap().contains("model.ca.toml"), "{report}");
        assert!(peak(&page.hear(0.05)) > 0.01, "the one before plays on");
        host.write(&edited.replace("left =", "links ="));
        let report = page.next("report");
        assert!(report["text"].as_str().unwrap().contains("outputs"), "{report}");
        host.write(STRING);
        assert_eq!(page.next("scene")["generation"], 3);

        page.done(&json!({"type": "change", "name": "low.t60", "value": "0.5 s"}));
        assert_eq!(page.next("scene")["generation"], 4);
        page.done(&json!({"type": "change", "name": "low.t60", "value": "-1 s"}));
        let report = page.next("report");
        assert!(report["ok"] == false && report["text"].as_str().unwrap().contains("`t60`"), "{report}");
        page.done(&json!({"type": "change", "name": "low.t60", "value": "5 s"}));
        assert_eq!(page.next("scene")["generation"], 5);
        // another process can do this too, together with a live parameter
        let said = host.ca(&["set", "low.t60=4 s", "k=700"]);
        assert!(said.contains("k = 700") && said.contains("low.t60 = 4 s: compiling the model again"), "{said}");
        assert_eq!(page.next("scene")["generation"], 6);
        // a mass of the new version can be held
        page.done(&json!({"type": "grab", "mass": 3}));
        page.done(&json!({"type": "drag", "by": [1e-3]}));
        page.done(&json!({"type": "set", "values": {"k": 600}}));
        until("it is set", || page.next("state")["params"]["k"] == 600.0);
        page.done(&json!({"type": "stop"}));
        host.ended();
        // the take has all six versions and the actions in each
        let replayed = host.ca(&["replay", "take.mcap", "--verify", "--energy", "--json"]);
        let verdict: serde_json::Value = serde_json::from_str(&replayed).unwrap_or_else(|e| panic!("{e}: {replayed}"));
        assert_eq!((&verdict["identical"], &verdict["versions"]), (&json!(true), &json!(6)), "{replayed}");
        let energy = |what: &str| verdict["energy"][what].as_f64().unwrap();
        assert!(energy("residual").abs() < 1e-9 * energy("peak"), "the account since the last: {replayed}");
        host.ca(&["report", "take.mcap", "-q", "-o", "r.html"]);
        let report = std::fs::read_to_string(host.path("r.html")).unwrap();
        assert!(report.contains("new version, with low.t60 = 4 s"), "its events are told");
        assert!(report.contains("The model was changed while it played"), "and why there is no ledger");
    }

    /// The page can record sound from now on and save the performance so far. It receives the kinetic energy.
    #[test]
    fn what_was_played_is_kept() {
        let mut host = Host::play(STRING, &[]);
        let mut page = host.page();
        let scene = page.next("scene");
        assert_eq!(scene["energy"], json!(["low", "bob"]));
        assert!(scene["stability"].as_str().unwrap().contains("margin"), "{scene}");
        page.done(&json!({"type": "port", "name": "push", "value": 0.3}));
        until("it moves", || page.next("energy")["motion"][0].as_f64().unwrap() > 0.0);
        let early = page.ask(&json!({"type": "record", "on": false}));
        assert_eq!(early["text"], "the sound is not being recorded");
        page.done(&json!({"type": "record", "on": true}));
        until("it is said what is recorded", || page.next("state")["recording"] == "model-1.wav");
        page.done(&json!({"type": "sound", "on": true}));
        page.done(&json!({"type": "gesture", "play": true}));
        assert!(peak(&page.hear(1.2)) > 0.0);
        page.done(&json!({"type": "record", "on": false}));
        let finished = |name: &str, page: &mut host::Client| {
            until(name, || page.next("said")["text"].as_str().unwrap().contains(name));
        };
        finished("model-1.wav", &mut page);
        // the temporary file is already unlinked, so a killed process leaves nothing
        assert_eq!(std::fs::read_dir(host.path("tmp")).unwrap().count(), 0);
        page.done(&json!({"type": "save"}));
        finished("model-1.mcap", &mut page);
        page.done(&json!({"type": "save"}));
        finished("model-2.mcap", &mut page);
        page.done(&json!({"type": "stop"}));
        host.ended();
        let wav = std::fs::read(host.path("model-1.wav")).unwrap();
        assert!(wav.len() > 2 * 4 * 48_000, "a second, in two channels: {}", wav.len());
        for take in ["model-1.mcap", "model-2.mcap"] {
            let replayed = host.ca(&["replay", take, "--verify", "--json"]);
            let verdict: serde_json::Value = serde_json::from_str(&replayed).unwrap();
            assert_eq!(verdict["identical"], true, "{replayed}");
            assert!(verdict["hashes"].as_u64().unwrap() > 0, "{replayed}");
        }
    }

    #[test]
    fn it_begins_anew() {
        inconvenient_times::it_begins_anew();
    }

    #[test]
    fn a_wrong_change_takes_no_good_one_along() {
        inconvenient_times::a_wrong_change_takes_no_good_one_along();
    }

    #[test]
    fn a_take_lasts_until_it_is_saved() {
        inconvenient_times::a_take_lasts_until_it_is_saved();
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_killed_session_leaves_no_take() {
        inconvenient_times::a_killed_session_leaves_no_take();
    }

    #[test]
    fn it_plays_from_its_beginning() {
        page_controls::it_plays_from_its_beginning();
    }

    #[test]
    fn only_keys_that_sound_are_keys() {
        page_controls::only_keys_that_sound_are_keys();
    }

    #[test]
    fn a_game_controller_plays() {
        page_controls::a_game_controller_plays();
    }

    #[test]
    fn two_fingers_hold_two_masses() {
        page_controls::two_fingers_hold_two_masses();
    }

    #[test]
    fn one_button_plays() {
        page_controls::one_button_plays();
    }

    #[test]
    fn magnification_settles_and_is_calm() {
        page_controls::magnification_settles_and_is_calm();
    }

    #[test]
    fn the_text_is_of_the_model_as_it_is_now() {
        share::the_text_is_of_the_model_as_it_is_now();
    }

    #[test]
    fn a_link_is_copied_and_one_file_is_saved() {
        share::a_link_is_copied_and_one_file_is_saved();
    }

    #[test]
    fn two_play_side_by_side() {
        inconvenient_times::two_play_side_by_side();
    }

    #[test]
    fn a_long_session_stays_within_its_memory_and_replays() {
        soak::a_long_session();
    }

    #[cfg(unix)]
    #[test]
    fn midi_and_osc_play_and_are_replayed_to_the_bit() {
        midi_osc::plays();
    }

    /// The browser opens a file, and other users cannot see the token.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_browser_is_led_to_the_page_by_a_file() {
        browser_start::by_a_file();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_browser_that_cannot_read_the_file_is_not_opened() {
        browser_start::not_in_a_sandbox();
    }

    #[test]
    fn pictures_of_the_page_are_made() {
        pictures::are_made();
    }

    /// The page of a report without a server: picture and waveform follow the chosen time.
    #[test]
    fn a_report_shows_the_moving_instrument() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("model.ca.toml"), STRING).unwrap();
        let page = dir.path().join("r.html");
        let mut report = host::command(dir.path());
        report.args(["report", "model.ca.toml", "-q", "--seconds", "1", "--accuracy", "0", "-o", "r.html"]);
        assert!(report.status().unwrap().success());
        let Some(mut tab) = browser::Tab::open(&format!("file://{}", page.display())) else { return };
        let film = |tab: &mut browser::Tab| tab.js("document.documentElement.dataset.film");
        until("it is drawn", || film(&mut tab) == "0.000");
        assert_eq!(tab.js("+document.documentElement.dataset.filmFrames >= 60"), true);
        let still = tab.part("filmCanvas");
        tab.js("(() => { const s = document.getElementById('filmAt'); s.value = 0.03; s.dispatchEvent(new Event('input')); })()");
        until("it goes to the time that is chosen", || film(&mut tab) == "0.030");
        assert_ne!(tab.part("filmCanvas"), still, "it moves");
        assert_eq!(tab.js("document.querySelector('audio').currentTime.toFixed(3)"), "0.030");
        tab.js("document.querySelector('.chart-over').scrollIntoView({ behavior: 'instant' })");
        let place = tab.js(
            "(() => { const r = document.querySelector('.chart-over').getBoundingClientRect(); return [r.x + r.width / 2, r.y + 20]; })()",
        );
        let [x, y] = [0, 1].map(|k| place[k].as_f64().unwrap());
        tab.mouse("mousePressed", x, y);
        tab.mouse("mouseReleased", x, y);
        until("the player goes there", || {
            tab.js("document.querySelector('audio').currentTime").as_f64().is_some_and(|t| (t - 0.5).abs() < 0.02)
        });
        tab.js("document.getElementById('film').scrollIntoView({ behavior: 'instant' })");
        until("and the picture", || {
            film(&mut tab).as_str().is_some_and(|t| (t.parse::<f64>().unwrap() - 0.5).abs() < 0.02)
        });
        assert_eq!(
            tab.js("document.documentElement.dataset.errors + document.documentElement.dataset.violations"),
            "00"
        );
        assert_eq!(tab.errors(), Vec::<String>::new());
    }

    /// In a browser, the page opens without errors and moves. A mouse that drags a mass holds it, and it sounds.
    #[test]
    fn a_mouse_in_a_browser_plays() {
        let mut host = Host::play(STRING, &["--seconds", "600"]);
        let Some(mut tab) = browser::Tab::open(&host.address) else { return };
        until("the scene is there", || tab.js("document.getElementById('title').textContent") == "A string and a bob");
        let mut watch = host.page();
        watch.next("scene");
        let before = tab.picture();
        let [x, y] = tab.near().expect("some mass is near the middle");
        tab.mouse("mousePressed", x, y);
        until("it is held", || watch.next("state")["pointer"].as_i64() >= Some(0));
        for n in 0..15 {
            tab.mouse("mouseMoved", x, y - 4.0 * f64::from(n));
        }
        until("the picture moves", || tab.picture() != before);
        tab.mouse("mouseReleased", x, y - 60.0);
        until("it is let go", || watch.next("state")["pointer"] == -1);
        watch.done(&json!({"type": "sound", "on": true}));
        assert!(peak(&watch.hear(0.1)) > 1e-4, "it rings");
        until("its energy is drawn", || tab.js("+document.documentElement.dataset.energy > 0") == true);
        // after user input, the page may start sound
        tab.js("document.getElementById('sound').dataset.on === 'true' || document.getElementById('sound').click()");
        until("the page plays, too", || tab.js("document.getElementById('sound').dataset.on") == "true");
        // plays keys on the screen, and computer keys once they are switched on
        let at = |tab: &mut browser::Tab, what: &str| {
            let place = tab.js(&format!(
                "(() => {{ const e = document.querySelector('{what}'); e.scrollIntoView(); \
                 const r = e.getBoundingClientRect(); return [r.x + r.width / 2, r.y + 0.9 * r.height]; }})()"
            ));
            [0, 1].map(|k| place[k].as_f64().unwrap())
        };
        until("the string is quiet", || peak(&watch.hear(0.05)) < 0.01);
        let [x, y] = at(&mut tab, "[data-note=\"64\"]");
        tab.mouse("mousePressed", x, y);
        until("a key sounds", || peak(&watch.hear(0.05)) > 0.02);
        tab.mouse("mouseReleased", x, y);
        assert_eq!(tab.js("document.querySelector('#keyboard .down') === null"), true);
        until("it is quiet again", || peak(&watch.hear(0.05)) < 0.01);
        tab.js("document.getElementById('letters').click()");
        tab.js("dispatchEvent(new KeyboardEvent('keydown', { code: 'KeyX', bubbles: true }))");
        assert_eq!(tab.js("document.querySelector('#keyboard .down')?.dataset.note"), "62");
        until("a letter sounds", || peak(&watch.hear(0.05)) > 0.02);
        tab.js("dispatchEvent(new KeyboardEvent('keyup', { code: 'KeyX', bubbles: true }))");
        tab.js("document.getElementById('letters').click()");
        tab.js("document.getElementById('presetsBox').open = true");
        tab.js("(() => { document.getElementById('presetName').value = 'soft'; \
             document.querySelector('#presetForm button').click(); })()");
        tab.js("(() => { const r = document.querySelector('#params input[type=range]'); r.value = 0; \
             r.dispatchEvent(new Event('input')); })()");
        until("the slider has set it", || watch.next("state")["params"]["k"] == 200.0);
        tab.js("document.querySelector('#presets .pick').click()");
        until("the preset has set it", || watch.next("state")["params"]["k"] == 2000.0);
        tab.js("(() => { const m = document.getElementById('morph'); m.value = 50; m.dispatchEvent(new Event('input')); })()");
        until("half of the way is half of it", || watch.next("state")["params"]["k"] == 1100.0);
        assert_eq!(tab.errors(), Vec::<String>::new());
        watch.done(&json!({"type": "stop"}));
        host.ended();
        until("the page says so", || tab.js("!document.getElementById('banner').hidden") == true);
    }
}
