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
        let mut tab = Tab { socket, id: 0, session: String::new(), errors: Vec::new(), child, _profile: profile };
        let target = tab.command("Target.createTarget", &json!({"url": "about:blank"}));
        let attach = json!({"targetId": target["targetId"], "flatten": true});
        tab.session = tab.command("Target.attachToTarget", &attach)["sessionId"].as_str().unwrap().into();
        for domain in ["Page", "Runtime", "Log"] {
            tab.command(&format!("{domain}.enable"), &json!({}));
        }
        tab.command("Page.navigate", &json!({"url": address}));
        Some(tab)
    }

    fn command(&mut self, method: &str, params: &Value) -> Value {
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

    /// Sends a command of the DevTools protocol.
    #[allow(dead_code)]
    pub fn emulate(&mut self, method: &str, params: &Value) {
        self.command(method, params);
    }

    /// Evaluates an expression in the page as a user gesture, so that the page may start sound.
    pub fn js(&mut self, expression: &str) -> Value {
        let asked = json!({"expression": expression, "awaitPromise": true, "returnByValue": true, "userGesture": true});
        self.command("Runtime.evaluate", &asked)["result"]["value"].clone()
    }

    pub fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        let down = i32::from(kind != "mouseReleased");
        let event = json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": down, "clickCount": 1});
        self.command("Input.dispatchMouseEvent", &event);
    }

    /// Finds a point where a mass can be pressed.
    pub fn near(&mut self) -> Option<[f64; 2]> {
        let size = self.js("(() => { const r = document.getElementById('canvas').getBoundingClientRect(); \
             return [r.x, r.y, r.width, r.height]; })()");
        let [left, top, w, h] = [0, 1, 2, 3].map(|k| size[k].as_f64().unwrap());
        for part in [0.5, 0.45, 0.55, 0.4, 0.6, 0.35, 0.65, 0.3, 0.7] {
            for step in 0..40 {
                let off = 0.01 * f64::from(step / 2) * if step % 2 == 0 { 1.0 } else { -1.0 };
                let at = [left + part * w, top + h * (0.5 + off)];
                let event = json!({"type": "mouseMoved", "x": at[0], "y": at[1], "button": "none", "buttons": 0});
                self.command("Input.dispatchMouseEvent", &event);
                // a mass of the string, which rings
                let tip = "new Promise(r => setTimeout(() => r(document.getElementById('tooltip').textContent), 250))";
                let over = self.js("document.getElementById('stage').classList.contains('over')");
                if over == true && self.js(tip).as_str().is_some_and(|t| t.contains("low[")) {
                    return Some(at);
                }
            }
        }
        None
    }

    pub fn picture(&mut self) -> String {
        self.command("Page.captureScreenshot", &json!({}))["data"].as_str().unwrap().into()
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
