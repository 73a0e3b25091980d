//! A page in a browser, whichever browser it is, as tests of the page use it.

use crate::browser::Tab;
use serde_json::Value;
use std::time::{Duration, Instant};

pub trait Page {
    /// Evaluates an expression, and waits for its promise.
    fn js(&mut self, expression: &str) -> Value;

    /// Moves the mouse to a point, and presses or releases it there: `mousePressed`, `mouseMoved` or `mouseReleased`.
    fn mouse(&mut self, kind: &str, x: f64, y: f64);

    /// Presses and releases the mouse at a point.
    fn click(&mut self, x: f64, y: f64) {
        self.mouse("mousePressed", x, y);
        self.mouse("mouseReleased", x, y);
    }

    /// A picture of an element.
    fn part(&mut self, id: &str) -> String;

    /// Exceptions, errors and warnings of the page.
    fn errors(&mut self) -> Vec<String>;
}

impl Page for Tab {
    fn js(&mut self, expression: &str) -> Value {
        Tab::js(self, expression)
    }

    fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        Tab::mouse(self, kind, x, y);
    }

    fn part(&mut self, id: &str) -> String {
        Tab::part(self, id)
    }

    fn errors(&mut self) -> Vec<String> {
        Tab::errors(self)
    }
}

/// Waits until an expression in the page is true.
#[track_caller]
pub fn until(page: &mut dyn Page, what: &str, is: &str) {
    let end = Instant::now() + Duration::from_secs(60);
    while page.js(is) != true {
        if Instant::now() > end {
            let now = page.js("JSON.stringify([document.documentElement.dataset, window.state, window.loud?.(), document.getElementById('bannerText')?.textContent, document.getElementById('reportText')?.textContent])");
            panic!("{what}: not within a minute: {now} {:?}", page.errors());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Waits until the page is drawn. From now on it keeps the last state that the engine sent, the largest
/// kinetic energy of a part \[J\], and its audio contexts.
pub fn drawn(page: &mut dyn Page) {
    until(page, "it is drawn", "+document.documentElement.dataset.frames > 5");
    page.js(
        "(() => { window.state = { held: [], params: {} }; window.motion = 0; window.contexts = new Set(); const parse = JSON.parse, { resume } = AudioContext.prototype; \
         JSON.parse = (...all) => { const made = parse(...all); if (made?.type === 'state') window.state = made; \
         if (made?.type === 'energy') window.motion = Math.max(...made.motion); return made; }; \
         AudioContext.prototype.resume = function () { window.contexts.add(this); return resume.call(this); }; \
         window.loud = () => { const text = document.getElementById('decibels').textContent; \
         return text.endsWith('dBFS') ? 10 ** (parseFloat(text.replace('−', '-')) / 20) : 0; }; })()",
    );
}

fn numbers<const N: usize>(page: &mut dyn Page, expression: &str) -> [f64; N] {
    let found = page.js(expression);
    std::array::from_fn(|k| found[k].as_f64().unwrap_or_else(|| panic!("{expression}: {found}")))
}

/// A point of an element, at a part of its height.
pub fn point(page: &mut dyn Page, selector: &str, part: f64) -> [f64; 2] {
    let place = format!(
        "(() => {{ const e = document.querySelector('{selector}'); e.scrollIntoView(); const r = e.getBoundingClientRect(); \
         return [r.x + r.width / 2, r.y + {part} * r.height]; }})()"
    );
    numbers(page, &place)
}

/// Presses an element.
pub fn press(page: &mut dyn Page, selector: &str) {
    let [x, y] = point(page, selector, 0.5);
    page.click(x, y);
}

/// Finds a point near the middle where a mass can be pressed whose name contains a text.
///
/// # Panics
/// If there is none.
pub fn near(page: &mut dyn Page, name: &str) -> [f64; 2] {
    let size = "(() => { const e = document.getElementById('canvas'); e.scrollIntoView(); const r = e.getBoundingClientRect(); \
                return [r.x, r.y, r.width, r.height]; })()";
    let [left, top, w, h] = numbers(page, size);
    for part in [0.5, 0.45, 0.55, 0.4, 0.6, 0.35, 0.65, 0.3, 0.7] {
        for step in 0..40 {
            let off = 0.01 * f64::from(step / 2) * if step % 2 == 0 { 1.0 } else { -1.0 };
            let at = [left + part * w, top + h * (0.5 + off)];
            page.mouse("mouseMoved", at[0], at[1]);
            let tip = "new Promise(r => setTimeout(() => r(document.getElementById('tooltip').textContent), 250))";
            // the page has looked for a mass before this callback of the same frame
            let over = "new Promise(r => requestAnimationFrame(() => r(document.getElementById('stage').classList.contains('over'))))";
            if page.js(over) == true && page.js(tip).as_str().is_some_and(|t| t.contains(name)) {
                return at;
            }
        }
    }
    panic!("no mass `{name}` is near the middle: {:?}", page.errors());
}
