//! Tests sound through a real PulseAudio server with a null sink and a recorder of its input. The recorded samples
//! equal the written file to the bit, unless a loss was counted.

use super::audio::{BAR, compare};
use crate::sandbox::{Proc, RunOutput, Sandbox, until};
use crate::skipped::skipped;
use ca_haptic::host::control::Request;
use pulseaudio::protocol::{
    self, AuthReply, ChannelMap, CreatePlaybackStreamReply, PlaybackLatency, RecordStreamParams, SampleFormat,
    SampleSpec, SetClientNameReply, SinkInfo,
    stream::{BufferAttr, StreamFlags},
};
use pulseaudio::{Client, ClientError, RecordStream};
use std::future::Future;
use std::io::{BufReader, Cursor, Read as _, Write as _};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::pin::pin;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};
use std::time::{Duration, SystemTime};

pub struct Server {
    pub server: Option<Proc>,
    pub socket: String,
}

impl Server {
    /// Starts a server whose sink has these arguments. Returns `None` if PulseAudio is not installed.
    #[track_caller]
    pub fn start(sandbox: &Sandbox, sink: &str) -> Option<Server> {
        let there = Command::new("pulseaudio").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        if there.is_err() {
            skipped("pulseaudio", "no PulseAudio server");
            return None;
        }
        let socket = sandbox.path("pa.sock").display().to_string();
        let protocol = format!("module-native-protocol-unix auth-anonymous=1 socket={socket}");
        let mut c =
            sandbox.command("pulseaudio", &["-n", "--daemonize=no", "--use-pid-file=no", "--exit-idle-time=-1"]);
        c.args(["-L", &format!("module-null-sink {sink}"), "-L", &protocol]);
        let home = sandbox.path("");
        for name in ["HOME", "XDG_RUNTIME_DIR", "XDG_CONFIG_HOME", "PULSE_RUNTIME_PATH", "PULSE_STATE_PATH"] {
            c.env(name, &home);
        }
        let mut pulse = Server { server: Some(sandbox.start(c)), socket };
        until("the server of PulseAudio answers", || {
            let server = pulse.server.as_mut().unwrap();
            assert!(server.is_running(), "{}", server.stderr());
            client(&pulse.socket).is_some()
        });
        Some(pulse)
    }

    fn ca(&self, sandbox: &Sandbox, args: &[&str]) -> Proc {
        let mut c = sandbox.command(env!("CARGO_BIN_EXE_ca"), args);
        c.env("PULSE_SERVER", format!("unix:{}", self.socket));
        sandbox.start(c)
    }
}

pub fn client(socket: &str) -> Option<Client> {
    Client::new_unix(c"ears", UnixStream::connect(socket).ok()?, Some([0; 256])).ok()
}

/// Polls the answer of a client without a runtime.
fn wait<T>(answer: impl Future<Output = Result<T, ClientError>>) -> T {
    let mut answer = pin!(answer);
    let mut context = Context::from_waker(Waker::noop());
    let mut got = None;
    until("PulseAudio answers", || {
        if let Poll::Ready(r) = answer.as_mut().poll(&mut context) {
            got = Some(r.unwrap());
        }
        got.is_some()
    });
    got.unwrap()
}

/// Records the left channel of the stereo sink from now on.
pub fn ears(client: &Client) -> (RecordStream, Arc<Mutex<Vec<f32>>>) {
    let heard = Arc::new(Mutex::new(Vec::new()));
    let ears = heard.clone();
    let params = RecordStreamParams {
        sample_spec: SampleSpec { format: SampleFormat::Float32Le, channels: 2, sample_rate: 48_000 },
        channel_map: ChannelMap::stereo(),
        source_name: Some(c"ca_test.monitor".to_owned()),
        buffer_attr: BufferAttr { fragment_size: 8 * 480, ..BufferAttr::default() },
        // otherwise the sink plays two seconds at once, which cannot be revoked
        flags: StreamFlags { adjust_latency: true, ..StreamFlags::default() },
        ..RecordStreamParams::default()
    };
    let listen = move |bytes: &[u8]| {
        let left = bytes.chunks_exact(8).map(|f| f32::from_le_bytes(f[..4].try_into().unwrap()));
        ears.lock().unwrap().extend(left);
    };
    (wait(client.create_record_stream(params, listen)), heard)
}

pub const SINK: &str = "sink_name=ca_test format=float32le rate=48000 channels=2";

#[test]
fn what_pulse_audio_hears_is_what_is_written() {
    for buffer in [None, Some("128")] {
        let sandbox = Sandbox::new();
        sandbox.put("bar.ca.toml", BAR);
        let Some(pulse) = Server::start(&sandbox, SINK) else { return };
        let client = client(&pulse.socket).unwrap();
        let (_stream, heard) = ears(&client);
        until("it listens", || !heard.lock().unwrap().is_empty());
        let args = ["serve", "bar.ca.toml", "--audio", "pulse", "--seconds", "5", "-o", "bar.wav", "--json"];
        let more = buffer.map_or(vec![], |n| vec!["--audio-buffer", n]);
        let played = pulse.ca(&sandbox, &[&args[..], &more].concat()).end();
        let end = heard.lock().unwrap().len() + 24_000;
        until("the rest has come", || heard.lock().unwrap().len() > end);
        let heard = heard.lock().unwrap().clone();
        let reported = played.json();
        let audio = &reported["audio"];
        let n = |k: &str| audio[k].as_u64().unwrap_or_else(|| panic!("no {k} in {audio:#}"));
        assert_eq!((&audio["host"], n("rate"), n("channels")), (&"PulseAudio".into(), 48_000, 2));
        let latency = audio["latency_ms"].as_f64().unwrap();
        assert!(latency + 1e-9 >= (n("lead") + n("buffer")) as f64 / 48.0 && latency < 1000.0, "{audio:#}");
        let lost = n("underruns") + n("xruns") + n("stops") + n("skipped") + n("unheard");
        assert_eq!(played.code, Some(if reported["faithful"] == true { 0 } else { 3 }), "{reported:#}");
        assert!(lost == 0 || played.code == Some(3), "{reported:#}");
        let mut wav = hound::WavReader::open(sandbox.path("bar.wav")).unwrap();
        let written: Vec<f32> = wav.samples().map(Result::unwrap).collect();
        let (same, breaks) = compare(&heard, &written);
        println!("{buffer:?}: {same} of {} samples to the bit, {breaks} breaks, {audio:#}", written.len());
        assert!(same >= 48_000, "{same} of {} samples", written.len());
        assert!(breaks as u64 <= lost, "{breaks} breaks, and {lost} were counted: {audio:#}");
        // sound begins with a 0
        assert!(lost > 0 || same + 48 > written.len(), "{same} of {}: {audio:#}", written.len());
    }
}

#[test]
fn a_pulse_server_that_dies_takes_no_force_along() {
    let sandbox = Sandbox::new();
    let Some(mut pulse) = Server::start(&sandbox, SINK) else { return };
    let mut server = pulse.ca(&sandbox, &["serve", "key.ca.toml", "--audio", "pulse", "--json"]);
    let frames = || sandbox.ask(&Request::Status).map_or(0, |r| r.fields["frames"].as_u64().unwrap());
    until("it plays", || {
        assert!(server.is_running(), "{}", server.stderr());
        // a new sink takes two seconds of sound before its next request
        frames() > 9000
    });
    pulse.server.take().unwrap().kill();
    until("it is reported", || {
        let said = server.stderr();
        said.contains("no longer requests sound") && said.contains("PulseAudio: lost connection to the server")
    });
    let begin = frames();
    until("frames go on", || frames() > begin + 6000);
    let reported = server.stop().is(3).json();
    assert_eq!((&reported["audio"]["stops"], &reported["faithful"]), (&1.into(), &false.into()), "{reported:#}");
    assert!(reported["audio"]["unheard"].as_u64().unwrap() > 0, "{reported:#}");
}

/// `ca play` uses PulseAudio if it can play the model. With another rate, too few channels or no answer, the page
/// plays.
#[test]
fn a_page_is_heard_by_pulse_audio_where_it_plays_it() {
    let sandbox = Sandbox::new();
    sandbox.put("bar.ca.toml", BAR);
    let play = |pulse: &Server, more: &[&str]| {
        let args = ["play", "bar.ca.toml", "--no-open", "--seconds", "1", "--json"];
        pulse.ca(&sandbox, &[&args, more].concat()).end()
    };
    let page = |ran: RunOutput| {
        let ran = ran.says(&["sound: by the page"]);
        assert!(matches!(ran.code, Some(0 | 3)) && ran.json()["audio"].is_null(), "{}{}", ran.out, ran.err);
        ran
    };
    let serve = |pulse: &Server, more: &[&str]| {
        let args = ["serve", "bar.ca.toml", "--audio", "pulse", "--seconds", "1"];
        pulse.ca(&sandbox, &[&args, more].concat()).end()
    };
    // a server that accepts connections but never answers
    let silent = Server { server: None, socket: sandbox.path("silent").display().to_string() };
    let listener = UnixListener::bind(&silent.socket).unwrap();
    assert!(!page(play(&silent, &[])).err.contains("PulseAudio"), "a server that is not there is no news");
    serve(&silent, &[]).is(1).says(&["no PulseAudio server answers"]);
    // a server that sends invalid data; the thread ends with this process
    std::thread::spawn(move || {
        for line in listener.incoming().map_while(Result::ok) {
            let _ = (&line).write_all(&[0xff; 64]);
        }
    });
    serve(&silent, &[]).is(1).says(&["no PulseAudio server answers"]);

    let Some(pulse) = Server::start(&sandbox, SINK) else { return };
    if cfg!(feature = "audio") {
        let args = ["serve", "bar.ca.toml", "--audio", "organ", "--seconds", "1"];
        pulse.ca(&sandbox, &args).end().is(1).says(&["no sound device `organ`", "`pulse`"]);
    }
    let ran = play(&pulse, &[]).says(&["sound: ", "(PulseAudio), 48000 Hz, ", " ms latency"]);
    assert_eq!(ran.json()["audio"]["host"], "PulseAudio", "{}", ran.out);
    page(play(&pulse, &["--audio", "page"]));
    page(play(&pulse, &["--rate", "96 kHz"])).says(&["PulseAudio plays at 48000 Hz, not at 96000"]);
    serve(&pulse, &["--rate", "96 kHz"]).is(1).says(&["PulseAudio plays at 48000 Hz", "--rate 48000Hz"]);
    sandbox.put("bar.ca.toml", &choir(3));
    page(play(&pulse, &[])).says(&["PulseAudio has 2 channels"]);
    serve(&pulse, &[]).is(1).says(&["has 2 channels", "3 outputs"]);
}

/// Servers that follow the protocol up to an invalid step are refused or dropped in bounded time and memory.
#[test]
fn a_pulse_server_that_lies_is_given_up() {
    let said = [
        (Lie::Talks, 1, "no PulseAudio server answers in time"),
        (Lie::Queues, 1, "it requested too many samples at once"),
        (Lie::Stands, 1, "the server does not answer in time"),
        (Lie::Asks, 3, "PulseAudio: lost connection to the server (it requested too many samples at once)"),
        (Lie::Leaves, 3, "PulseAudio: lost connection to the server"),
    ];
    for (lie, code, why) in said {
        let sandbox = Sandbox::new();
        sandbox.put("bar.ca.toml", BAR);
        let server = Server { server: None, socket: sandbox.path("liar").display().to_string() };
        let listener = UnixListener::bind(&server.socket).unwrap();
        // the thread ends with this process
        std::thread::spawn(move || {
            for line in listener.incoming().map_while(Result::ok) {
                let _ = lies(&line, lie);
            }
        });
        let served = server.ca(&sandbox, &["serve", "bar.ca.toml", "--audio", "pulse"]);
        if code == 3 {
            let reported = |said: &str| said.contains(why) && said.contains("no longer requests sound");
            until("it is reported", || reported(&served.stderr()));
            served.stop().is(3);
        } else {
            served.end().is(code).says(&[why]);
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Lie {
    /// Sends endless messages when a sink is requested.
    Talks,
    /// Requests 4 GiB of silence at the start.
    Queues,
    /// Sends an answer byte by byte but never the last byte.
    Stands,
    /// Plays, then requests 4 GiB.
    Asks,
    /// Plays, then disconnects in the middle of a message.
    Leaves,
}

/// Answers until the connection ends.
fn lies(line: &UnixStream, lie: Lie) -> Option<()> {
    const VERSION: u16 = protocol::MAX_VERSION;
    let (mut from, mut to) = (BufReader::new(line), line);
    loop {
        let head = protocol::read_descriptor(&mut from).ok()?;
        let mut body = vec![0; head.length as usize];
        from.read_exact(&mut body).ok()?;
        // skips sound
        if head.channel != u32::MAX {
            continue;
        }
        let (n, asked) = protocol::Command::read_tag_prefixed(&mut Cursor::new(body), VERSION).ok()?;
        let done = match asked {
            protocol::Command::Auth(_) => {
                let auth = AuthReply { version: VERSION, use_memfd: false, use_shm: false };
                protocol::write_reply_message(&mut to, n, &auth, VERSION)
            }
            protocol::Command::SetClientName(_) => {
                protocol::write_reply_message(&mut to, n, &SetClientNameReply { client_id: 1 }, VERSION)
            }
            protocol::Command::GetSinkInfo(_) if lie == Lie::Talks => loop {
                protocol::write_command_message(&mut to, u32::MAX, &protocol::Command::Started(0), VERSION).ok()?;
            },
            protocol::Command::GetSinkInfo(_) => {
                let sample_spec = SampleSpec { format: SampleFormat::Float32Le, channels: 2, sample_rate: 48_000 };
                let sink = SinkInfo { sample_spec, channel_map: ChannelMap::stereo(), ..SinkInfo::new_dummy(1) };
                protocol::write_reply_message(&mut to, n, &sink, VERSION)
            }
            protocol::Command::CreatePlaybackStream(_) if lie == Lie::Stands => {
                to.write_all(&[0, 0, 255, 255]).ok()?;
                loop {
                    to.write_all(&[255]).ok()?;
                    std::thread::sleep(Duration::from_millis(100));
                }
            }
            protocol::Command::CreatePlaybackStream(_) => {
                let buffer_attr =
                    BufferAttr { minimum_request_length: 2048, target_length: 8192, ..BufferAttr::default() };
                let requested_bytes = if lie == Lie::Queues { u32::MAX } else { 8192 };
                let made = CreatePlaybackStreamReply { requested_bytes, buffer_attr, ..Default::default() };
                protocol::write_reply_message(&mut to, n, &made, VERSION)
            }
            protocol::Command::CorkPlaybackStream(_) => protocol::write_ack_message(&mut to, n),
            protocol::Command::GetPlaybackLatency(_) => {
                let now = SystemTime::UNIX_EPOCH;
                let latency = PlaybackLatency {
                    sink_usec: u64::MAX,
                    source_usec: 0,
                    playing: true,
                    local_time: now,
                    remote_time: now,
                    write_offset: i64::MAX,
                    read_offset: i64::MIN,
                    underrun_for: 0,
                    playing_for: 0,
                };
                protocol::write_reply_message(&mut to, n, &latency, VERSION).ok()?;
                // reads sound meanwhile, because both sides could otherwise wait for each other
                std::thread::scope(|s| {
                    s.spawn(|| std::io::copy(&mut from, &mut std::io::sink()));
                    let _ = asks(line, lie);
                });
                return None;
            }
            _ => return None,
        };
        done.ok()?;
    }
}

/// Requests sound for a second, like a correct server.
fn asks(mut line: &UnixStream, lie: Lie) -> Option<()> {
    let mut ask = |length| {
        let mut message = Vec::new();
        let more = protocol::Command::Request(protocol::Request { channel: 0, length });
        protocol::write_command_message(&mut message, u32::MAX, &more, protocol::MAX_VERSION).ok()?;
        line.write_all(&message).ok()
    };
    for _ in 0..100 {
        ask(3840)?;
        std::thread::sleep(Duration::from_millis(10));
    }
    if lie == Lie::Asks {
        return ask(u32::MAX);
    }
    line.write_all(&[0, 0]).ok()?;
    line.shutdown(Shutdown::Both).ok()
}

fn choir(outputs: usize) -> String {
    let outs: Vec<String> = (0..outputs).map(|k| format!("o{k} = {{ from = \"bar\", gain = 500 }}\n")).collect();
    BAR.split("out =").next().unwrap().to_string() + &outs.concat()
}
