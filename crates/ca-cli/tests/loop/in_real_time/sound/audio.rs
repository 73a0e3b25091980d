//! Tests sound through a real JACK server without hardware. A client listens at its port in a separate process, because
//! JACK selects the server by an environment variable. The received samples equal the written file to the bit, unless a
//! loss was counted.

use crate::helper_process::{HelperProcess, Job};
use crate::long_form::long_form;
use crate::sandbox::{Proc, Sandbox, until};
use crate::skipped::skipped;
use ca_haptic::host::control::Request;
use std::fs;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

pub const BAR: &str = "[CEL]\nbar = { m = \"1 g\", f = \"220 Hz\", t60 = \"20 s\", dx0 = \"1 mm\" }\n\
                   [SOX]\nout = { from = \"bar\", gain = 500 }\n";

const STRING: &str = "[STRING]\nlow = { n = 30, f = \"110 Hz\", t60 = \"3 s\", m = \"1 g\" }\n\
    [ENF]\npush = { to = \"low[4]\", midi = { note = [\"C4\", \"E4\"], to = \"0.5 N\", attack = \"1 ms\" } }\n\
    [SOX]\nout = { from = \"low[6]\", gain = 200 }\n";

/// A JACK server with a private name.
pub struct Jack {
    pub name: String,
    pub server: Option<Proc>,
}

impl Jack {
    /// Starts a server with `frames` per period. Returns `None` if JACK is not installed.
    #[track_caller]
    pub fn start(sandbox: &Sandbox, frames: u32) -> Option<Jack> {
        let there = Command::new("jackd").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        if there.is_err() {
            skipped("jackd", "no JACK server");
            return None;
        }
        // one of few names: JACK has eight slots, and killed servers keep theirs
        let name = format!("ca_test{}", std::process::id() % 4);
        // waits for late clients, so that a busy machine delays the sound instead of corrupting it
        let mut c = sandbox.command("jackd", &["-r", "-S", "-t", "5000", "-n", &name, "-d", "dummy", "-r", "48000"]);
        c.args(["-p", &frames.to_string()]).env("JACK_NO_AUDIO_RESERVATION", "1");
        let mut jack = Jack { server: Some(sandbox.start(c)), name };
        until("the server of JACK answers", || {
            let server = jack.server.as_mut().unwrap();
            assert!(server.is_running(), "{}", server.stderr());
            let mut lsp = Command::new("jack_lsp");
            lsp.args(["-s", &jack.name]).stdout(Stdio::null()).stderr(Stdio::null());
            lsp.status().is_ok_and(|s| s.success())
        });
        Some(jack)
    }

    fn ca(&self, sandbox: &Sandbox, args: &[&str]) -> Proc {
        let mut c = sandbox.command(env!("CARGO_BIN_EXE_ca"), args);
        c.env("JACK_DEFAULT_SERVER", &self.name);
        sandbox.start(c)
    }

    /// Starts a process that writes the received sound to a file.
    fn listener(&self, sandbox: &Sandbox) -> HelperProcess {
        HelperProcess::start(&sandbox.site, "in_real_time::sound::audio::ears", &self.name, 0)
    }
}

impl Drop for Jack {
    fn drop(&mut self) {
        let Some(mut server) = self.server.take() else { return };
        if server.is_running() {
            // with SIGTERM, the server removes its files
            server.signal("TERM");
            let end = Instant::now() + Duration::from_secs(10);
            while server.is_running() && Instant::now() < end {
                std::thread::sleep(Duration::from_millis(5));
            }
        }
        drop(server);
        for f in fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if f.file_name().to_string_lossy().contains(&self.name) {
                let _ = fs::remove_file(f.path());
            }
        }
    }
}

/// A JACK client that copies the received samples.
struct AudioCapture(jack::Port<jack::AudioIn>, jack::RingBufferWriter);

impl jack::ProcessHandler for AudioCapture {
    fn process(&mut self, _: &jack::Client, scope: &jack::ProcessScope) -> jack::Control {
        for x in self.0.as_slice(scope) {
            self.1.write_buffer(&x.to_le_bytes());
        }
        jack::Control::Continue
    }
}

#[test]
#[ignore = "a part of other tests"]
fn ears() {
    let Some(job) = Job::asked() else { return };
    let (client, _) = jack::Client::new("ears", jack::ClientOptions::NO_START_SERVER).unwrap();
    let port = client.register_port("in", jack::AudioIn).unwrap();
    let ours = port.name().unwrap();
    // ten seconds
    let (mut heard, writer) = jack::RingBuffer::new(4 * 480_000).unwrap().into_reader_writer();
    let client = client.activate_async((), AudioCapture(port, writer)).unwrap();
    let mut file = job.ready();
    let mut block = vec![0; 1 << 16];
    let mut listens = false;
    loop {
        let over = job.is_over();
        // samples in transit arrive before this iteration ends
        std::thread::sleep(Duration::from_millis(10));
        if !listens && !over {
            let speaks = client.as_client().ports(Some("ca.*:out_0"), None, jack::PortFlags::empty());
            listens = speaks.first().is_some_and(|p| client.as_client().connect_ports_by_name(p, &ours).is_ok());
        }
        loop {
            let n = heard.read_buffer(&mut block);
            file.write_all(&block[..n]).unwrap();
            if n == 0 {
                break;
            }
        }
        if over {
            // closing the client may wait forever for its server
            std::process::exit(i32::from(!listens));
        }
    }
}

/// A keyboard client that sends a note between other MIDI messages.
struct MidiSender(jack::Port<jack::MidiOut>, Arc<AtomicBool>);

impl jack::ProcessHandler for MidiSender {
    fn process(&mut self, _: &jack::Client, scope: &jack::ProcessScope) -> jack::Control {
        let mut out = self.0.writer(scope);
        if self.1.swap(false, Relaxed) {
            for bytes in [&[0xf0, 1, 2, 3, 4, 0xf7][..], &[0xf8], &[0x90, 60, 127]] {
                // a message is dropped if the buffer is full
                let _ = out.write(&jack::RawMidi { time: 0, bytes });
            }
        }
        jack::Control::Continue
    }
}

#[test]
#[ignore = "a part of other tests"]
fn hands() {
    let Some(job) = Job::asked() else { return };
    let (client, _) = jack::Client::new("hands", jack::ClientOptions::NO_START_SERVER).unwrap();
    let port = client.register_port("out", jack::MidiOut).unwrap();
    let ours = port.name().unwrap();
    let now = Arc::new(AtomicBool::new(false));
    let client = client.activate_async((), MidiSender(port, now.clone())).unwrap();
    job.ready();
    let mut played = false;
    while !job.is_over() {
        std::thread::sleep(Duration::from_millis(10));
        let listens = client.as_client().ports(Some("ca.*:midi_in"), None, jack::PortFlags::IS_INPUT);
        if !played && listens.first().is_some_and(|p| client.as_client().connect_ports_by_name(&ours, p).is_ok()) {
            // the connection works from the next cycle on
            std::thread::sleep(Duration::from_millis(100));
            now.store(true, Relaxed);
            played = true;
        }
    }
    // without closing the client, as in `ears`
    std::process::exit(i32::from(!played));
}

#[allow(dead_code)]
#[path = "../../../../../cordis-anima/examples/jack.rs"]
mod example;

#[test]
#[ignore = "a part of other tests"]
fn voice() {
    let Some(job) = Job::asked() else { return };
    let playing = example::Playing::begin("ca voice").unwrap();
    job.ready();
    std::thread::sleep(Duration::from_secs(2));
    playing.pitch(330.0);
    while !job.is_over() {
        std::thread::sleep(Duration::from_millis(10));
    }
    // without closing the client, as in `ears`
    std::process::exit(0);
}

/// The voice example plays in an audio host as computed, until its pitch changes.
#[test]
fn a_voice_plays_in_an_audio_host() {
    let sandbox = Sandbox::new();
    let Some(jack) = Jack::start(&sandbox, 256) else { return };
    let listener = jack.listener(&sandbox);
    let voice = HelperProcess::start(&sandbox.site, "in_real_time::sound::audio::voice", &jack.name, 0);
    std::thread::sleep(Duration::from_secs(4));
    let heard = samples(&listener.end());
    voice.end();
    let mut computed = vec![0.0_f32; 5 * 48_000];
    example::bar(48_000.0).0.process(&[], &mut [&mut computed]);
    let first = heard.iter().position(|v| *v != 0.0).expect("it is heard");
    let before = &heard[first..][..48_000];
    let (same, breaks) = compare(before, &computed);
    println!("{same} of {} samples to the bit, {breaks} breaks", before.len());
    assert!(same >= 24_000, "{same} of {} samples", before.len());
    let crossings = |s: &[f32]| s.windows(2).filter(|w| w[0] < 0.0 && w[1] >= 0.0).count() as f64;
    let last = &heard[heard.len() - 9_600..];
    assert!((crossings(last) * 5.0 - 330.0).abs() < 8.0, "{} Hz at last", crossings(last) * 5.0);
}

pub fn samples(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

/// Equal samples required to match two positions.
const SURE: usize = 48;

/// Returns how many samples of `heard` are in `written` in the same order, and the number of breaks.
pub fn compare(heard: &[f32], written: &[f32]) -> (usize, usize) {
    let (mut same, mut breaks, mut from, mut at) = (0, 0, 0, 0);
    let mut looked = 0;
    while at + SURE <= heard.len() {
        let piece = &heard[at..at + SURE];
        // silence matches everywhere
        if piece[0] == 0.0 {
            at += 1;
            continue;
        }
        looked += 1;
        assert!(looked < 5000, "only {same} samples are those that were written");
        let Some(found) = written[from..].windows(SURE).position(|w| w == piece) else {
            at += 1;
            continue;
        };
        breaks += 1;
        let equal = heard[at..].iter().zip(&written[from + found..]).take_while(|(a, b)| a == b).count();
        (same, at, from) = (same + equal, at + equal, from + found + equal);
        if from + SURE > written.len() {
            break;
        }
    }
    (same, breaks.max(1) - 1)
}

/// Plays with buffers of `frames`. Returns false if almost nothing was received to the bit.
fn heard_as_written(frames: u32) -> bool {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    let Some(jack) = Jack::start(&sandbox, frames) else { return true };
    let listener = jack.listener(&sandbox);
    let args = ["serve", "bar.ca.toml", "--audio", "jack", "--seconds", "5", "-o", "bar.wav", "--json"];
    let played = jack.ca(&sandbox, &[&args[..], &["--log", "bar.mcap"]].concat()).end();
    let heard = samples(&listener.end());
    let reported = played.json();
    let audio = &reported["audio"];
    let n = |k: &str| audio[k].as_u64().unwrap_or_else(|| panic!("no {k} in {audio:#}"));
    assert_eq!((&audio["host"], n("rate"), n("channels"), n("buffer")), (&"JACK".into(), 48_000, 2, frames.into()));
    // one buffer, a gesture frame, and a margin
    assert_eq!(n("lead"), u64::from(frames + 16 + 48.max(frames / 2)));
    assert!(audio["latency_ms"].as_f64().unwrap() + 1e-9 >= (n("lead") + u64::from(frames)) as f64 / 48.0);
    let lost = n("underruns") + n("xruns") + n("stops");
    assert_eq!(played.code, Some(if reported["faithful"] == true { 0 } else { 3 }), "{reported:#}");
    assert!(lost == 0 || played.code == Some(3), "{reported:#}");

    let mut wav = hound::WavReader::open(sandbox.path("bar.wav")).unwrap();
    let written: Vec<f32> = wav.samples().map(Result::unwrap).collect();
    let (same, breaks) = compare(&heard, &written);
    println!("{frames} frames: {same} of {} samples to the bit, {breaks} breaks, {audio:#}", written.len());
    if same < 48_000 {
        return false;
    }
    assert!(breaks as u64 <= lost, "{breaks} breaks, and {lost} were counted: {audio:#}");
    // the listener may start late, and sound begins with a 0
    assert!(lost > 0 || same + 48_000 > written.len(), "{same} of {}", written.len());
    let log = sandbox.ca(&["log", "info", "bar.mcap"]);
    assert_eq!(log.code, Some(0), "{}{}", log.out, log.err);
    true
}

#[test]
fn what_is_heard_is_what_is_written() {
    let buffers: &[u32] = if long_form("buffers of 64 frames") { &[64, 256] } else { &[256] };
    for frames in buffers {
        // repeats on a busy machine, where the listener may be late
        assert!((0..4).any(|_| heard_as_written(*frames)), "buffers of {frames} frames");
    }
}

#[test]
fn midi_comes_by_jack() {
    let sandbox = Sandbox::new();
    sandbox.put("string.ca.toml", STRING);
    let Some(jack) = Jack::start(&sandbox, 256) else { return };
    let hands = HelperProcess::start(&sandbox.site, "in_real_time::sound::audio::hands", &jack.name, 0);
    let args = ["serve", "string.ca.toml", "--audio", "jack", "--seconds", "3", "-o", "string.wav", "--json"];
    let played = jack.ca(&sandbox, &[&args[..], &["--log", "string.mcap"]].concat()).end();
    drop(hands.end());
    let played = played.says(&["MIDI: JACK port ca:midi_in"]);
    assert!(matches!(played.code, Some(0 | 3)), "{}{}", played.out, played.err);
    let mut wav = hound::WavReader::open(sandbox.path("string.wav")).unwrap();
    let written: Vec<f32> = wav.samples().map(Result::unwrap).collect();
    let sounds = written.iter().position(|x| *x != 0.0);
    assert!(sounds.is_some_and(|k| k > 0), "{sounds:?}");
    let peak = written.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
    assert!(peak > 0.01, "{peak}");
    sandbox.ca(&["replay", "string.mcap", "--verify"]).is(0);
}

#[test]
fn a_server_that_dies_takes_no_force_along() {
    let sandbox = Sandbox::new();
    let Some(mut jack) = Jack::start(&sandbox, 256) else { return };
    let mut server = jack.ca(&sandbox, &["serve", "key.ca.toml", "--audio", "jack", "--json"]);
    let frames = || sandbox.ask(&Request::Status).map_or(0, |r| r.fields["frames"].as_u64().unwrap());
    until("it plays", || {
        assert!(server.is_running(), "{}", server.stderr());
        frames() > 1000
    });
    jack.server.take().unwrap().kill();
    until("it is reported", || server.stderr().contains("no longer requests sound"));
    let begin = frames();
    until("frames go on", || frames() > begin + 6000);
    assert!(server.is_running());
    let reported = server.stop().is(3).json();
    assert_eq!((&reported["audio"]["stops"], &reported["faithful"]), (&1.into(), &false.into()), "{reported:#}");
    assert!(reported["audio"]["unheard"].as_u64().unwrap() > 0, "{reported:#}");
}

#[test]
fn what_no_device_plays_is_refused_before_anything_is_written() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    let nobody = Jack { name: "ca_nobody".into(), server: None };
    let run = |jack: &Jack, more: &[&str]| {
        let ran =
            jack.ca(&sandbox, &[&["serve", "bar.ca.toml", "--seconds", "1", "-o", "bar.wav"], more].concat()).end();
        assert!(!sandbox.path("bar.wav").exists());
        ran.is(1)
    };
    run(&nobody, &["--audio", "jack"]).says(&["no JACK server answers", "jackd -d"]);
    let organ: &[_] =
        if cfg!(feature = "audio") { &["no sound device `organ`", "available"] } else { &["--audio pulse"] };
    run(&nobody, &["--audio", "organ"]).says(organ);
    let Some(jack) = Jack::start(&sandbox, 128) else { return };
    run(&jack, &["--audio", "organ"]).says(&[if cfg!(feature = "audio") { "`jack`" } else { "--audio jack" }]);
    run(&jack, &["--audio", "jack", "--rate", "96 kHz"]).says(&["48000 Hz, not at 96000", "--rate 48000Hz"]);
    run(&jack, &["--audio", "jack", "--audio-buffer", "64"]).says(&["buffers of 128 frames, not 64", "-p 64"]);
}

/// `ca play` uses a running server without a request, unless the server cannot play the model unchanged.
#[test]
fn a_server_that_is_there_is_played_in_a_page_too() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    let Some(jack) = Jack::start(&sandbox, 256) else { return };
    let play = |more: &[&str]| {
        let args = ["play", "bar.ca.toml", "--no-open", "--seconds", "1", "--json"];
        let played = jack.ca(&sandbox, &[&args[..], more].concat()).end();
        (played.json(), played.err)
    };
    let (reported, _) = play(&[]);
    assert_eq!(
        (&reported["audio"]["host"], &reported["audio"]["rate"]),
        (&"JACK".into(), &48_000.into()),
        "{reported:#}"
    );
    let (reported, err) = play(&["--rate", "44.1 kHz"]);
    assert!(reported["audio"].is_null() && err.contains("sound: by the page"), "{reported:#} {err}");
    let (reported, _) = play(&["--audio", "page"]);
    assert!(reported["audio"].is_null(), "{reported:#}");
}
