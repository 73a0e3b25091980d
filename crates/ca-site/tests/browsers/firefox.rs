//! Controls a real Firefox by WebDriver BiDi.

use super::desktop::Desktop;
use super::{Browser, Ended};
use crate::page::Page;
use crate::skipped::skipped;
use serde_json::{Value, json};
use std::io::{BufRead as _, BufReader, Read as _};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::time::Duration;
use tungstenite::{Message, WebSocket};

/// Names of the program.
const NAMES: [&str; 2] = ["firefox-esr", "firefox"];

/// Time in which the browser answers.
const ANSWER: Duration = Duration::from_secs(20);

pub struct Firefox<'a> {
    desktop: &'a Desktop,
    socket: WebSocket<TcpStream>,
    id: u64,
    context: Value,
    errors: Vec<String>,
    answers: bool,
    _browser: Ended,
    _profile: tempfile::TempDir,
}

impl<'a> Firefox<'a> {
    /// Starts the browser. Returns `None` without Firefox.
    #[track_caller]
    pub fn start(desktop: &'a Desktop) -> Option<Firefox<'a>> {
        let profile = tempfile::tempdir().unwrap();
        // a graphics card of software is otherwise refused
        std::fs::write(profile.path().join("user.js"), "user_pref('webgl.force-enabled', true);\n").unwrap();
        let started = NAMES.iter().find_map(|name| {
            let mut command = Command::new(name);
            command.args(["--no-remote", "--remote-debugging-port", "0", "--width", "1440"]);
            command.args(["--height", "900", "--profile"]).arg(profile.path()).stderr(Stdio::piped());
            desktop.used_by(&mut command);
            command.spawn().ok()
        });
        let Some(mut child) = started else {
            skipped("firefox", "no Firefox, so the site is not played in it");
            return None;
        };
        let mut err = BufReader::new(child.stderr.take().unwrap());
        let browser = Ended(child);
        let address = loop {
            let mut line = String::new();
            assert!(err.read_line(&mut line).unwrap() > 0, "Firefox ended");
            if let Some(at) = line.find("ws://") {
                break line[at..].trim().to_owned();
            }
        };
        std::thread::spawn(move || err.read_to_string(&mut String::new()));
        let stream = TcpStream::connect(&address["ws://".len()..]).unwrap();
        stream.set_read_timeout(Some(ANSWER)).unwrap();
        let socket = tungstenite::client(format!("{address}/session"), stream).unwrap().0;
        let mut page = Firefox {
            desktop,
            socket,
            id: 0,
            context: Value::Null,
            errors: Vec::new(),
            answers: true,
            _browser: browser,
            _profile: profile,
        };
        page.command("session.new", &json!({"capabilities": {}}));
        page.command("session.subscribe", &json!({"events": ["log.entryAdded"]}));
        page.context = page.command("browsingContext.getTree", &json!({}))["contexts"][0]["context"].clone();
        Some(page)
    }

    fn command(&mut self, method: &str, params: &Value) -> Value {
        self.id += 1;
        let request = json!({"id": self.id, "method": method, "params": params});
        self.socket.send(Message::text(request.to_string())).unwrap();
        loop {
            let read = self.socket.read();
            self.answers = read.is_ok();
            let Message::Text(text) = read.unwrap_or_else(|e| panic!("{method}: no answer: {e}")) else { continue };
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["id"] == self.id {
                assert_eq!(message["type"], "success", "{method}: {message}");
                return message["result"].clone();
            }
            let level = &message["params"]["level"];
            if message["method"] == "log.entryAdded" && (level == "error" || level == "warn") {
                self.errors.push(message["params"].to_string());
            }
        }
    }
}

impl Browser for Firefox<'_> {
    fn go(&mut self, address: &str) {
        let to = json!({"context": self.context, "url": address, "wait": "complete"});
        self.command("browsingContext.navigate", &to);
    }

    /// Two threads of Firefox sometimes wait for each other when PulseAudio reports that its device began to run: one
    /// holds the lock of the library of PulseAudio, the other the one of the browser.
    fn again(&mut self) -> bool {
        let stuck = !self.answers;
        if stuck {
            *self = Firefox::start(self.desktop).expect("Firefox");
        }
        stuck
    }
}

impl Page for Firefox<'_> {
    fn js(&mut self, expression: &str) -> Value {
        let asked = json!({"expression": format!("(async () => JSON.stringify(await ({expression})))()"),
            "target": {"context": self.context}, "awaitPromise": true, "userActivation": true});
        let made = self.command("script.evaluate", &asked);
        assert_eq!(made["type"], "success", "{expression}: {made}");
        made["result"]["value"].as_str().map_or(Value::Null, |text| serde_json::from_str(text).unwrap())
    }

    fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        let mut actions = vec![json!({"type": "pointerMove", "x": x.round() as i64, "y": y.round() as i64})];
        match kind {
            "mousePressed" => actions.push(json!({"type": "pointerDown", "button": 0})),
            "mouseReleased" => actions.push(json!({"type": "pointerUp", "button": 0})),
            _ => {}
        }
        let mouse = json!({"type": "pointer", "id": "mouse", "actions": actions});
        self.command("input.performActions", &json!({"context": self.context, "actions": [mouse]}));
    }

    fn part(&mut self, id: &str) -> String {
        let place = self.js(&format!(
            "(r => [r.x, r.y, r.width, r.height])(document.getElementById('{id}').getBoundingClientRect())"
        ));
        let clip = json!({"type": "box", "x": place[0], "y": place[1], "width": place[2], "height": place[3]});
        let made = self.command("browsingContext.captureScreenshot", &json!({"context": self.context, "clip": clip}));
        made["data"].as_str().unwrap().into()
    }

    fn errors(&mut self) -> Vec<String> {
        self.errors.clone()
    }
}
