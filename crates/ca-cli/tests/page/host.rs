//! A running `ca play`, and a client of its page.

use serde_json::{Value, json};
use std::io::{BufRead as _, BufReader, Read as _};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::thread::{JoinHandle, spawn};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

#[track_caller]
pub fn until(what: &str, mut is: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(120);
    while !is() {
        assert!(Instant::now() < end, "{what}: not within two minutes");
        std::thread::sleep(Duration::from_millis(5));
    }
}

pub fn peak(samples: &[f32]) -> f32 {
    samples.iter().fold(0.0, |p, x| p.max(x.abs()))
}

/// A running `ca play`, killed on drop.
pub struct Host {
    dir: tempfile::TempDir,
    child: Child,
    pub address: String,
}

impl Host {
    pub fn play(model: &str, more: &[&str]) -> Host {
        let dir = tempfile::Builder::new().prefix("cap").tempdir_in("/tmp").unwrap();
        std::fs::write(dir.path().join("model.ca.toml"), model).unwrap();
        std::fs::create_dir(dir.path().join("tmp")).unwrap();
        let args = [&["play", "model.ca.toml", "--no-open", "--priority", "0", "--no-lock"], more].concat();
        let mut child = command(dir.path());
        child.args(args).env("TMPDIR", dir.path().join("tmp")).stderr(Stdio::piped()).stdout(Stdio::null());
        let mut child = child.spawn().unwrap();
        let mut err = BufReader::new(child.stderr.take().unwrap());
        let mut all = String::new();
        let address = loop {
            let mut line = String::new();
            assert!(err.read_line(&mut line).unwrap() > 0, "it ended: {all}");
            all += &line;
            if let Some(at) = line.find("http://") {
                break line[at..].trim().to_owned();
            }
        };
        // drains the messages, because the process would block otherwise
        std::thread::spawn(move || err.read_to_string(&mut String::new()));
        Host { dir, child, address }
    }

    pub fn write(&self, model: &str) {
        std::fs::write(self.dir.path().join("model.ca.toml"), model).unwrap();
    }

    pub fn path(&self, name: &str) -> std::path::PathBuf {
        self.dir.path().join(name)
    }

    pub fn page(&self) -> Client {
        let place = self.address.strip_prefix("http://").unwrap();
        let host = place.split('/').next().unwrap();
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
        let mut request = format!("ws://{place}ws").into_client_request().unwrap();
        request.headers_mut().insert("Origin", format!("http://{host}").parse().unwrap());
        Client { socket: tungstenite::client(request, stream).unwrap().0, id: 0 }
    }

    pub fn process(&self) -> u32 {
        self.child.id()
    }

    pub fn ended(&mut self) {
        until("it ends", || self.child.try_wait().unwrap().is_some());
    }

    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    pub fn ca(&self, args: &[&str]) -> String {
        let ran = command(self.dir.path()).args(args).output().unwrap();
        let [out, err] = [ran.stdout, ran.stderr].map(|b| String::from_utf8(b).unwrap());
        assert!(ran.status.success(), "{args:?}: {out}{err}");
        out
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn command(dir: &std::path::Path) -> Command {
    let mut c = Command::new(env!("CARGO_BIN_EXE_ca"));
    c.current_dir(dir).env("CA_SHM_ROOT", dir.join("s")).env("CA_CONFIG", dir.join("c"));
    c
}

/// A client of the page without a browser.
pub struct Client {
    socket: WebSocket<TcpStream>,
    id: u64,
}

impl Client {
    #[track_caller]
    pub fn next(&mut self, kind: &str) -> Value {
        let end = Instant::now() + Duration::from_secs(60);
        loop {
            assert!(Instant::now() < end, "no `{kind}` within a minute");
            if let Message::Text(text) = self.socket.read().unwrap() {
                let message: Value = serde_json::from_str(&text).unwrap();
                if message["type"] == kind {
                    return message;
                }
            }
        }
    }

    pub fn ask(&mut self, request: &Value) -> Value {
        self.id += 1;
        let mut request = request.clone();
        request["id"] = json!(self.id);
        self.socket.send(Message::text(request.to_string())).unwrap();
        loop {
            let reply = self.next("reply");
            if reply["id"] == self.id {
                return reply;
            }
        }
    }

    /// Sends a request that must succeed.
    #[track_caller]
    pub fn done(&mut self, request: &Value) {
        let reply = self.ask(request);
        assert_eq!(reply["ok"], true, "{request}: {reply}");
    }

    /// Returns the next binary message of a kind: its second header field and its numbers.
    fn bytes(&mut self, kind: u32) -> (u32, Vec<f32>) {
        loop {
            if let Message::Binary(bytes) = self.socket.read().unwrap() {
                if bytes[..4] == kind.to_le_bytes() {
                    let second = u32::from_le_bytes(bytes[4..8].try_into().unwrap());
                    let numbers = bytes[16..].chunks_exact(4).map(|c| f32::from_le_bytes(c.try_into().unwrap()));
                    return (second, numbers.collect());
                }
            }
        }
    }

    pub fn look(&mut self) -> Vec<f32> {
        self.bytes(1).1
    }

    pub fn look_at(&mut self, generation: u32) -> Vec<f32> {
        loop {
            let (of, picture) = self.bytes(1);
            if of == generation {
                return picture;
            }
        }
    }

    /// Counts the received samples on a thread until the connection closes.
    pub fn listen(mut self) -> JoinHandle<usize> {
        self.done(&json!({"type": "sound", "on": true}));
        spawn(move || {
            let mut samples = 0;
            while let Ok(message) = self.socket.read() {
                if let Message::Binary(bytes) = message
                    && bytes[..4] == 2_u32.to_le_bytes()
                {
                    samples += bytes[16..].len() / 4;
                }
            }
            samples
        })
    }

    /// Returns `seconds` of sound from now on, interleaved.
    pub fn hear(&mut self, seconds: f64) -> Vec<f32> {
        let mut all = Vec::new();
        loop {
            let (channels, block) = self.bytes(2);
            all.extend(block);
            if all.len() as f64 >= seconds * 48_000.0 * f64::from(channels) {
                return all;
            }
        }
    }
}
