//! Measures the latency of a touch: from a message of the page or a MIDI byte to the sound at the JACK device or at the
//! page.
//!
//! The model is at rest and silent until it is touched. A touch counts as heard at the first sample that is not
//! silence, so that the instrument adds no delay. The bench prints the table. With `UPDATE=1` it writes
//! `docs/measured/touch.md`.
#![allow(missing_docs)]

#[cfg(target_os = "linux")]
#[path = "../tests/page/browser.rs"]
#[allow(dead_code)]
mod browser;
#[cfg(target_os = "linux")]
#[path = "../../../tests/src/skipped.rs"]
mod skipped;

#[cfg(target_os = "linux")]
mod linux {
    use super::browser::Tab;
    use ca_haptic::rt::now_ns;
    use serde_json::{Value, json};
    use std::fmt::Write as _;
    use std::io::{BufRead as _, BufReader, Read as _, Write as _};
    use std::net::TcpStream;
    use std::path::Path;
    use std::process::{Child, Command, Stdio};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
    use std::time::{Duration, Instant};
    use tungstenite::client::IntoClientRequest as _;
    use tungstenite::{Message, WebSocket};

    /// A model that decays to silence quickly.
    const MODEL: &str = "[CEL]\nbar = { m = \"1 g\", f = \"400 Hz\", t60 = \"30 ms\" }\n[ENF]\npush = { to = \"bar\", midi = { note = \
                         \"C4\", to = \"1 N\", attack = \"0 s\", release = \"0 s\" } }\n[SOX]\nout = { from = \"bar\", gain = 1000 }\n";
    /// Smallest sample that counts as heard; full scale is 1.
    const HEARD: f32 = 1e-6;
    /// Frames per JACK period.
    const PERIOD: u32 = 256;
    const RATE: f64 = 48_000.0;
    const SERVER: &str = "ca_bench";

    /// A process that is ended on drop.
    struct Proc(Child);

    impl Drop for Proc {
        fn drop(&mut self) {
            // fails for a process that has already ended
            let _ = Command::new("kill").arg(self.0.id().to_string()).status();
            let end = Instant::now() + Duration::from_secs(5);
            while matches!(self.0.try_wait(), Ok(None)) && Instant::now() < end {
                std::thread::sleep(Duration::from_millis(10));
            }
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }

    /// `ca play`, a client of its page, and a pipe for its MIDI.
    struct Played {
        _ca: Proc,
        address: String,
        page: WebSocket<TcpStream>,
        midi: std::fs::File,
        _dir: tempfile::TempDir,
    }

    impl Played {
        fn start(audio: &str) -> Played {
            let dir = tempfile::Builder::new().prefix("cat").tempdir_in("/tmp").expect("a folder");
            std::fs::write(dir.path().join("bar.ca.toml"), MODEL).expect("a model");
            let pipe = dir.path().join("midi");
            assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
            // opened for reading and writing, so that neither end blocks
            let midi = std::fs::File::options().read(true).write(true).open(&pipe).expect("the pipe");
            let mut c = Command::new(env!("CARGO_BIN_EXE_ca"));
            c.args(["play", "bar.ca.toml", "--no-open", "--audio", audio, "--midi", "midi"]).current_dir(dir.path());
            c.env("CA_SHM_ROOT", dir.path().join("s")).env("JACK_DEFAULT_SERVER", SERVER);
            let mut ca = c.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("ca starts");
            let mut said = BufReader::new(ca.stderr.take().expect("a pipe"));
            let address = loop {
                let mut line = String::new();
                assert!(said.read_line(&mut line).expect("words") > 0, "ca play ended");
                if let Some(at) = line.find("http://") {
                    break line[at..].trim().to_owned();
                }
            };
            std::thread::spawn(move || said.read_to_string(&mut String::new()));
            let place = address.strip_prefix("http://").expect("an address");
            let host = place.split('/').next().expect("a host");
            let stream = TcpStream::connect(host).expect("the page");
            stream.set_nodelay(true).expect("a socket");
            let mut request = format!("ws://{place}ws").into_client_request().expect("a request");
            request.headers_mut().insert("Origin", format!("http://{host}").parse().expect("an origin"));
            let page = tungstenite::client(request, stream).expect("a socket").0;
            let mut played = Played { _ca: Proc(ca), address, page, midi, _dir: dir };
            played.say(&json!({"type": "grab", "mass": 0, "id": 1}));
            let held = played.reply();
            assert_eq!(held["ok"], true, "{held}");
            played
        }

        fn say(&mut self, message: &Value) {
            self.page.send(Message::text(message.to_string())).expect("a page");
        }

        fn reply(&mut self) -> Value {
            loop {
                if let Message::Text(text) = self.page.read().expect("a page") {
                    let message: Value = serde_json::from_str(&text).expect("JSON");
                    if message["type"] == "reply" {
                        return message;
                    }
                }
            }
        }

        /// Starts or ends a touch by pointer or MIDI.
        fn touch(&mut self, what: &str, on: bool) {
            if what == "pointer" {
                self.say(&json!({"type": "drag", "by": [if on { 1e-3 } else { 0.0 }]}));
            } else {
                self.midi.write_all(&[if on { 0x90 } else { 0x80 }, 60, 100]).expect("the pipe");
            }
        }

        /// Waits for the first audible sound sent to the page, and returns the time \[ns\].
        fn sent(&mut self) -> u64 {
            loop {
                if let Message::Binary(bytes) = self.page.read().expect("a page") {
                    let mut samples = bytes[16..].chunks_exact(4).map(|c| f32::from_le_bytes(c.try_into().expect("4")));
                    if bytes[..4] == 2_u32.to_le_bytes() && samples.any(|x| x.abs() > HEARD) {
                        return now_ns();
                    }
                }
            }
        }

        /// Reads messages until the model is silent.
        fn rest(&mut self) {
            let end = Instant::now() + Duration::from_millis(400);
            while Instant::now() < end {
                let _ = self.page.read();
            }
        }
    }

    /// A JACK client that stores the time of the first audible sample, 0 before it.
    struct AudioCapture(jack::Port<jack::AudioIn>, Arc<AtomicU64>);

    impl jack::ProcessHandler for AudioCapture {
        fn process(&mut self, _: &jack::Client, scope: &jack::ProcessScope) -> jack::Control {
            let now = now_ns();
            let sample = self.0.as_slice(scope).iter().position(|x| x.abs() > HEARD);
            if let Some(k) = sample.filter(|_| self.1.load(Relaxed) == 0) {
                // a sample of this period is played in the next one
                self.1.store(now + (1e9 * (k as f64 + f64::from(PERIOD)) / RATE) as u64, Relaxed);
            }
            jack::Control::Continue
        }
    }

    /// Repeats a measurement `n` times and returns the sorted times \[ms\].
    fn measured(n: usize, mut one: impl FnMut() -> f64) -> Vec<f64> {
        let mut all: Vec<f64> = (0..n).map(|_| one()).collect();
        all.sort_by(f64::total_cmp);
        all
    }

    fn by_jack(n: usize, rows: &mut Vec<[String; 6]>) -> Option<()> {
        let mut c = Command::new("jackd");
        c.args(["-r", "-n", SERVER, "-d", "dummy", "-r", "48000", "-p", &PERIOD.to_string()]);
        c.env("JACK_NO_AUDIO_RESERVATION", "1").stdout(Stdio::null()).stderr(Stdio::null());
        let _server = Proc(c.spawn().ok()?);
        let end = Instant::now() + Duration::from_secs(20);
        let answers =
            || Command::new("jack_lsp").args(["-s", SERVER]).stderr(Stdio::null()).stdout(Stdio::null()).status();
        while !answers().is_ok_and(|s| s.success()) {
            assert!(Instant::now() < end, "JACK does not answer");
            std::thread::sleep(Duration::from_millis(20));
        }
        let mut played = Played::start("jack");
        let heard = Arc::new(AtomicU64::new(1));
        let options = jack::ClientOptions::NO_START_SERVER;
        let (client, _) = jack::Client::new("ears", options).ok()?;
        let port = client.register_port("in", jack::AudioIn).ok()?;
        let ours = port.name().ok()?;
        let client = client.activate_async((), AudioCapture(port, heard.clone())).ok()?;
        let end = Instant::now() + Duration::from_secs(20);
        while client.as_client().connect_ports_by_name("ca:out_0", &ours).is_err() {
            assert!(Instant::now() < end, "ca has no port");
            std::thread::sleep(Duration::from_millis(20));
        }
        for what in ["pointer", "MIDI byte"] {
            let times = measured(n, || {
                played.rest();
                heard.store(0, Relaxed);
                let at = now_ns();
                played.touch(what, true);
                while heard.load(Relaxed) == 0 {
                    std::thread::sleep(Duration::from_micros(200));
                }
                let ms = (heard.load(Relaxed) - at) as f64 * 1e-6;
                played.touch(what, false);
                ms
            });
            rows.push(row(what, &format!("JACK, {PERIOD} frames"), &times, "its device"));
        }
        Some(())
    }

    fn by_page(n: usize, rows: &mut Vec<[String; 6]>) {
        let mut played = Played::start("page");
        played.say(&json!({"type": "sound", "on": true}));
        let times: Vec<Vec<f64>> = ["pointer", "MIDI byte"]
            .iter()
            .map(|what| {
                measured(n, || {
                    played.rest();
                    let at = now_ns();
                    played.touch(what, true);
                    let ms = (played.sent() - at) as f64 * 1e-6;
                    played.touch(what, false);
                    ms
                })
            })
            .collect();
        // buffering by the page and its browser, as the page displays it
        let behind = Tab::open(&played.address).map(|mut tab| {
            let end = Instant::now() + Duration::from_secs(20);
            while tab.js("+document.documentElement.dataset.frames > 20") != true && Instant::now() < end {
                std::thread::sleep(Duration::from_millis(50));
            }
            // browsers start sound only after a user gesture
            let at = tab.js("(r => [r.x + r.width / 2, r.y + r.height / 2])(document.getElementById('sound').getBoundingClientRect())");
            let [x, y] = [0, 1].map(|k| at[k].as_f64().unwrap_or_default());
            tab.mouse("mousePressed", x, y);
            tab.mouse("mouseReleased", x, y);
            std::thread::sleep(Duration::from_secs(4));
            tab.js("[...document.querySelectorAll('#facts dt')].find(e => e.textContent === 'Here')?.nextSibling.textContent ?? 'none'")
        });
        let behind = behind.and_then(|b| b.as_str().map(str::to_owned)).unwrap_or_else(|| "not measured".into());
        let behind = behind.split(" behind").next().unwrap_or_default().to_owned();
        for (what, times) in ["pointer", "MIDI byte"].iter().zip(times) {
            rows.push(row(what, "the page", &times, &format!("its browser, and {behind} more there")));
        }
    }

    fn row(what: &str, by: &str, times: &[f64], to: &str) -> [String; 6] {
        let at =
            |q: f64| times.get(((times.len().max(1) - 1) as f64 * q).round() as usize).copied().unwrap_or(f64::NAN);
        let ms = |q: f64| format!("{:.1}", at(q));
        [what.into(), by.into(), times.len().to_string(), ms(0.5), ms(0.99), to.into()]
    }

    const HEAD: &str = "# Latency of a touch

Made by `UPDATE=1 cargo bench -p ca-cli --bench touch`: do not edit.

`ca play` of a bar that rests until it is touched, at 48 kHz. A touch is a message of the page that pulls a mass, or a
byte of MIDI through a pipe; it becomes audible with the first sample beyond 10⁻⁶ of full scale. Sound goes to a JACK
server without a device, and one period more is added for the device; or to a page, and the time ends when the server
sends the sample: the page shows the queue of the browser, which must be added. Times are in ms.

The machine of this page is a virtual one with two cores, which it shares with others.

| touch | sound by | n | p50 | p99 | heard by |
|---|---|---|---|---|---|
";

    pub fn main() {
        // libjack finds its server through an environment variable
        if std::env::var("JACK_DEFAULT_SERVER").ok().as_deref() != Some(SERVER) {
            let mut again = Command::new(std::env::current_exe().expect("this program"));
            let ran = again.args(std::env::args().skip(1)).env("JACK_DEFAULT_SERVER", SERVER).status();
            assert!(ran.expect("this program again").success());
            return;
        }
        // `cargo test --benches` only checks that it runs
        let long = std::env::args().any(|a| a == "--bench");
        let n = if long { 100 } else { 1 };
        let mut rows = Vec::new();
        if by_jack(n, &mut rows).is_none() {
            println!("no JACK server here: only the page is measured");
        }
        by_page(n, &mut rows);
        let mut text = HEAD.to_string();
        for r in rows {
            let _ = writeln!(text, "| {} |", r.join(" | "));
        }
        println!("{text}");
        if long && std::env::var_os("UPDATE").is_some() {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/measured/touch.md");
            std::fs::write(path, text).expect("the page can be written");
        }
    }
}

fn main() {
    #[cfg(target_os = "linux")]
    linux::main();
}
