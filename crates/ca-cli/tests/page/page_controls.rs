//! Tests the controls of the page: its checks in a browser, what a second client receives, and a steady magnification.

use crate::browser::Tab;
use crate::host::{Host, peak, until};
use crate::page::{near, point};
use crate::page_checks::{CHECKS, ONCE};
use serde_json::json;
use std::path::Path;

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

/// A kalimba has only the seven keys that have a tine.
pub fn only_keys_that_sound_are_keys() {
    let host = Host::play(&bundled("kalimba"), &[]);
    assert_eq!(host.page().next("scene")["notes"], json!([60, 62, 64, 65, 67, 69, 72]));
    end(host);
}

/// The checks that the page passes with any connection.
pub fn the_page_passes_its_checks() {
    for check in &CHECKS {
        let host = Host::play(check.model, &["--audio", "page"]);
        let Some(mut tab) = Tab::open(&host.address) else { return };
        check.in_chromium(&mut tab);
        end(host);
    }
}

/// A second client sees and hears a mouse in a page, and the page says when the program ends.
pub fn a_mouse_in_a_browser_plays() {
    let mut host = Host::play(crate::STRING, &["--seconds", "600"]);
    let Some(mut tab) = drawn(&host) else { return };
    let [x, y] = near(&mut tab, "low[");
    // a client that does not read is dropped
    let mut watch = host.page();
    watch.next("scene");
    watch.done(&json!({"type": "sound", "on": true}));
    tab.mouse("mousePressed", x, y);
    until("it is held", || watch.next("state")["pointer"].as_i64() >= Some(0));
    for n in 0..15 {
        tab.mouse("mouseMoved", x, y - 4.0 * f64::from(n));
    }
    tab.mouse("mouseReleased", x, y - 60.0);
    until("it is let go", || watch.next("state")["pointer"] == -1);
    assert!(peak(&watch.hear(0.1)) > 1e-4, "it rings");
    until("the string is quiet", || peak(&watch.hear(0.05)) < 0.01);
    let [x, y] = point(&mut tab, "[data-note=\"64\"]", 0.9);
    tab.mouse("mousePressed", x, y);
    until("a key sounds", || peak(&watch.hear(0.05)) > 0.02);
    tab.mouse("mouseReleased", x, y);
    tab.js("(() => { const r = document.querySelector('#params input[type=range]'); r.value = 0; r.dispatchEvent(new Event('input')); })()");
    until("the slider has set it", || watch.next("state")["params"]["k"] == 200.0);
    assert_eq!(tab.errors(), Vec::<String>::new());
    watch.done(&json!({"type": "stop"}));
    host.ended();
    until("the page says so", || tab.js("!document.getElementById('banner').hidden") == true);
}
