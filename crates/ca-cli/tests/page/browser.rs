//! Controls a real headless Chromium through the DevTools protocol.

use crate::skipped::skipped;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::io::{BufRead as _, BufReader, Read as _};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tungstenite::{Message, WebSocket};

/// A page in a private browser.
pub struct Tab {
    socket: WebSocket<TcpStream>,
    id: u64,
    session: String,
    errors: Vec<String>,
    pressed: bool,
    child: Child,
    _profile: tempfile::TempDir,
}

impl Drop for Tab {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Tab {
    /// Opens an address. Returns `None` without Chromium.
    pub fn open(address: &str) -> Option<Tab> {
        let profile = tempfile::tempdir().unwrap();
        let mut command = Command::new("chromium");
        command.args(["--headless=new", "--no-sandbox", "--no-first-run", "--disable-background-networking"]);
        command.args([
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--window-size=1440,900",
        ]);
        command.args(["--remote-debugging-port=0", "--disable-component-update", "--disable-sync", "about:blank"]);
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        let Ok(mut child) = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn() else {
            skipped("chromium", "no Chromium, so no page is played");
            return None;
        };
        let mut err = BufReader::new(child.stderr.take().unwrap());
        let at = loop {
            let mut line = String::new();
            assert!(err.read_line(&mut line).unwrap() > 0, "Chromium ended");
            if let Some(at) = line.find("ws://") {
                break line[at..].trim().to_owned();
            }
        };
        std::thread::spawn(move || err.read_to_string(&mut String::new()));
        let stream = TcpStream::connect(at["ws://".len()..].split('/').next().unwrap()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
        let socket = tungstenite::client(at.as_str(), stream).unwrap().0;
        let mut tab =
            Tab { socket, id: 0, session: String::new(), errors: Vec::new(), pressed: false, child, _profile: profile };
        let target = tab.command("Target.createTarget", &json!({"url": "about:blank"}));
        let attach = json!({"targetId": target["targetId"], "flatten": true});
        tab.session = tab.command("Target.attachToTarget", &attach)["sessionId"].as_str().unwrap().into();
        for domain in ["Page", "Runtime", "Log"] {
            tab.command(&format!("{domain}.enable"), &json!({}));
        }
        tab.command("Page.navigate", &json!({"url": address}));
        Some(tab)
    }

    /// Sends a command of the DevTools protocol, and returns its result.
    pub fn command(&mut self, method: &str, params: &Value) -> Value {
        self.id += 1;
        let mut request = json!({"id": self.id, "method": method, "params": params});
        if !self.session.is_empty() {
            request["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(request.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["id"] == self.id {
                // a page that is left meanwhile gives no result
                let left = message["error"]["message"] == "Inspected target navigated or closed";
                assert!(left || message["error"].is_null(), "{method}: {message}");
                return message["result"].clone();
            }
            let bad = |level: &Value| level == "error" || level == "warning";
            match message["method"].as_str().unwrap_or_default() {
                "Runtime.exceptionThrown" => self.errors.push(message["params"].to_string()),
                "Log.entryAdded" if bad(&message["params"]["entry"]["level"]) => {
                    self.errors.push(message["params"].to_string());
                }
                "Runtime.consoleAPICalled" if bad(&message["params"]["type"]) => {
                    self.errors.push(message["params"].to_string());
                }
                _ => {}
            }
        }
    }

    /// Process of the browser.
    #[allow(dead_code)]
    pub fn process(&self) -> u32 {
        self.child.id()
    }

    /// Evaluates an expression in the page as a user gesture, so that the page may start sound.
    pub fn js(&mut self, expression: &str) -> Value {
        let asked = json!({"expression": expression, "awaitPromise": true, "returnByValue": true, "userGesture": true});
        self.command("Runtime.evaluate", &asked)["result"]["value"].clone()
    }

    pub fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        self.pressed = kind == "mousePressed" || (self.pressed && kind == "mouseMoved");
        // a release names the button that comes up
        let button = if self.pressed || kind == "mouseReleased" { "left" } else { "none" };
        let buttons = i32::from(self.pressed);
        let event = json!({"type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1});
        self.command("Input.dispatchMouseEvent", &event);
    }

    pub fn part(&mut self, id: &str) -> String {
        let place = self.js(&format!(
            "(() => {{ const r = document.getElementById('{id}').getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; }})()"
        ));
        let [x, y, width, height] = [0, 1, 2, 3].map(|k| place[k].as_f64().unwrap());
        let clip = json!({"x": x, "y": y, "width": width, "height": height, "scale": 1});
        self.command("Page.captureScreenshot", &json!({ "clip": clip }))["data"].as_str().unwrap().into()
    }

    /// Sets the window size and the preferred colour scheme.
    pub fn looks(&mut self, width: u32, height: u32, colours: &str) {
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        self.command("Emulation.setDeviceMetricsOverride", &size);
        let media = json!({"features": [{"name": "prefers-color-scheme", "value": colours}]});
        self.command("Emulation.setEmulatedMedia", &media);
        self.command("Page.reload", &json!({}));
    }

    /// Small screenshot of the window.
    pub fn webp(&mut self) -> Vec<u8> {
        let asked = json!({"format": "webp", "quality": 80});
        let text = self.command("Page.captureScreenshot", &asked)["data"].as_str().unwrap().to_owned();
        STANDARD.decode(text).unwrap()
    }

    /// Exceptions, errors and warnings of the page.
    pub fn errors(&mut self) -> Vec<String> {
        // the software renderer of a machine without a screen warns that it is slow
        self.errors.iter().filter(|e| !e.contains("GL Driver Message") && !e.contains("GPU stall")).cloned().collect()
    }
}
