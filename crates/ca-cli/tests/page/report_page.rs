//! Tests the page of a report in a browser.

use crate::STRING;
use crate::browser::Tab;
use crate::host::{command, until};

/// The picture and the waveform follow the chosen time.
pub fn shows_the_moving_instrument() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("model.ca.toml"), STRING).unwrap();
    let page = dir.path().join("r.html");
    let mut report = command(dir.path());
    report.args(["report", "model.ca.toml", "-q", "--seconds", "1", "--accuracy", "0", "-o", "r.html"]);
    assert!(report.status().unwrap().success());
    let Some(mut tab) = Tab::open(&format!("file://{}", page.display())) else { return };
    let film = |tab: &mut Tab| tab.js("document.documentElement.dataset.film");
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
    assert_eq!(tab.js("document.documentElement.dataset.errors + document.documentElement.dataset.violations"), "00");
    assert_eq!(tab.errors(), Vec::<String>::new());
}
