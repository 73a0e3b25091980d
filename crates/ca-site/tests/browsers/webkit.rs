//! Controls a real WebKitGTK by WebDriver.

use super::desktop::Desktop;
use super::{Browser, Ended};
use crate::page::Page;
use crate::skipped::skipped;
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

pub struct WebKit {
    port: u16,
    session: String,
    _driver: Ended,
}

/// The browser that comes with the library.
fn browser() -> Option<PathBuf> {
    let folders = std::fs::read_dir("/usr/lib").ok()?;
    let found = folders.flatten().map(|f| f.path().join("webkit2gtk-4.1/MiniBrowser"));
    found.into_iter().find(|p| p.is_file())
}

impl WebKit {
    /// Starts the browser. Returns `None` without it.
    #[track_caller]
    pub fn start(desktop: &Desktop) -> Option<WebKit> {
        let Some(browser) = browser() else {
            skipped("webkit", "no WebKitGTK, so the site is not played in it");
            return None;
        };
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let mut driver = Command::new("WebKitWebDriver");
        driver.arg(format!("--port={port}"));
        desktop.used_by(&mut driver);
        let Ok(driver) = driver.stderr(Stdio::null()).spawn() else {
            skipped("webkit", "no WebKitWebDriver, so the site is not played in WebKit");
            return None;
        };
        let mut page = WebKit { port, session: String::new(), _driver: Ended(driver) };
        let end = Instant::now() + Duration::from_secs(30);
        while TcpStream::connect(("127.0.0.1", port)).is_err() {
            assert!(Instant::now() < end, "WebKitWebDriver does not answer");
            std::thread::sleep(Duration::from_millis(20));
        }
        let options = json!({"binary": browser, "args": ["--automation"]});
        let asked = json!({"capabilities": {"alwaysMatch": {"webkitgtk:browserOptions": options}}});
        let made = page.ask("POST", "/session", &asked);
        page.session = format!("/session/{}", made["sessionId"].as_str().unwrap_or_else(|| panic!("{made}")));
        page.ask("POST", "/window/rect", &json!({"x": 0, "y": 0, "width": 1440, "height": 900}));
        Some(page)
    }

    /// Moves the mouse, and does something with its button there.
    fn act(&mut self, x: f64, y: f64, button: &[&str]) {
        let (x, y) = (x.round() as i64, y.round() as i64);
        let mut actions = vec![json!({"type": "pointerMove", "x": x, "y": y, "origin": "viewport"})];
        actions.extend(button.iter().map(|kind| json!({"type": kind, "button": 0})));
        let kind = json!({"pointerType": "mouse"});
        let mouse = json!({"type": "pointer", "id": "mouse", "parameters": kind, "actions": actions});
        self.ask("POST", "/actions", &json!({"actions": [mouse]}));
    }

    fn ask(&mut self, method: &str, path: &str, body: &Value) -> Value {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
        let body = if method == "GET" { String::new() } else { body.to_string() };
        let at = format!("{}{path}", self.session);
        write!(
            stream,
            "{method} {at} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: close\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            self.port,
            body.len()
        )
        .unwrap();
        let mut all = String::new();
        stream.read_to_string(&mut all).unwrap();
        let (head, text) = all.split_once("\r\n\r\n").unwrap_or_else(|| panic!("{at}: {all}"));
        assert!(head.starts_with("HTTP/1.1 200"), "{at}: {all}");
        serde_json::from_str::<Value>(text).unwrap_or_else(|e| panic!("{at}: {e}: {all}"))["value"].clone()
    }
}

impl Browser for WebKit {
    fn go(&mut self, address: &str) {
        self.ask("POST", "/url", &json!({"url": address}));
    }
}

impl Drop for WebKit {
    fn drop(&mut self) {
        // ends the browser; the driver cannot while it is killed
        if !std::thread::panicking() {
            self.ask("DELETE", "", &json!({}));
        }
    }
}

impl Page for WebKit {
    fn js(&mut self, expression: &str) -> Value {
        let script = format!(
            "const done = arguments[0]; (async () => JSON.stringify(await ({expression})))().then(done, e => done('\"' + e + '\"'))"
        );
        let made = self.ask("POST", "/execute/async", &json!({"script": script, "args": []}));
        made.as_str().map_or(Value::Null, |text| serde_json::from_str(text).unwrap())
    }

    fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        let button = match kind {
            "mousePressed" => Some("pointerDown"),
            "mouseReleased" => Some("pointerUp"),
            _ => None,
        };
        self.act(x, y, button.as_slice());
    }

    /// A press and a release in two requests are no click here.
    fn click(&mut self, x: f64, y: f64) {
        self.act(x, y, &["pointerDown", "pointerUp"]);
    }

    fn part(&mut self, id: &str) -> String {
        let found = self.ask("POST", "/element", &json!({"using": "css selector", "value": format!("#{id}")}));
        let element = found.as_object().and_then(|o| o.values().next()).and_then(Value::as_str).unwrap().to_owned();
        self.ask("GET", &format!("/element/{element}/screenshot"), &Value::Null).as_str().unwrap().into()
    }

    /// The protocol has no log; the page counts its errors.
    fn errors(&mut self) -> Vec<String> {
        Vec::new()
    }
}
