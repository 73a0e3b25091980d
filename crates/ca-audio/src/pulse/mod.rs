//! Sound through a PulseAudio server, or PipeWire in its place.
//!
//! The queue in the server is about 20 ms, because the server does not run in real time. The server requests more
//! samples as it plays, and the clock of the engine follows these requests. The queue starts with silence.
//!
//! When the queue is empty, the server plays on and requests the missed samples too, so that the total requested always
//! measures time. It reports each such gap, which is counted as an underrun of the device. A server without a device is
//! refused, as is a sink that does not switch to the rate of the model. A thread answers the server; between messages
//! it neither allocates nor locks.

mod connection;

use super::{OpenOutput, Output};
use crate::AudioError;
use ca_core::Scene;
use ca_haptic::rt::{self, RtRequest, now_ns};
use ca_haptic::serve::audio::{Counts, DeviceClock, PlaybackDevice, Player, Watch, link};
use connection::{Connection, ServerMessage, wrong};
use pulseaudio::protocol::{
    self, ChannelMap, Command, CorkStreamParams, CreatePlaybackStreamReply, GetSinkInfo, LatencyParams,
    PlaybackLatency, PlaybackStreamParams, Prop, Props, SampleFormat, SampleSpec, SinkInfo,
    stream::{BufferAttr, StreamFlags},
};
use std::io::{Error, Result};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::{Duration, SystemTime};

const NAME: &str = "PulseAudio";
/// Default number of samples per request.
const BUFFER: u32 = 256;
/// Longest wait for an answer of the server.
const PATIENCE: Duration = Duration::from_secs(2);
/// Longest wait for a new stream; the device may have to wake up.
const WAKING: Duration = Duration::from_secs(5);
/// Limit of the queue of a server \[bytes\].
const LARGEST: u32 = 1 << 22;
/// Limit of the latency of a device \[µs\].
const LATEST: u64 = 60_000_000;
/// Length of the queue, in requests.
const QUEUED: u32 = 4;
/// Largest number of samples filled at a time; larger requests are filled in pieces.
const MOST: usize = 16384;
/// Name of the sink of a server without a device.
const DUMMY: &[u8] = b"auto_null";

struct Stream {
    line: Connection,
    made: CreatePlaybackStreamReply,
    sink: SinkInfo,
    latency: PlaybackLatency,
}

/// Opens a stream that plays a scene.
///
/// Returns [`AudioError::Failed`] if no server answers, [`AudioError::Unfit`] if the server cannot play the scene as it
/// is.
pub(super) fn open(
    scene: &Scene,
    buffer: Option<u32>,
    request: RtRequest,
) -> std::result::Result<(OpenOutput, DeviceClock, Watch), AudioError> {
    let buffer = buffer.unwrap_or(BUFFER);
    let absent = |why: &str| {
        let how = "start one, e.g. `pulseaudio --start`, or set PULSE_SERVER to its address";
        AudioError::Failed(format!("no PulseAudio server answers{why}; {how}"))
    };
    let opened =
        with_timeout(PATIENCE, || Connection::open(PATIENCE).map(default_sink)).ok_or_else(|| absent(" in time"))?;
    let (line, sink) = opened.map_err(|_| absent(""))?;
    let refused = |e: Error| AudioError::Unfit(format!("{NAME} cannot play this model: {e}"));
    let Some(sink) = sink.filter(|s| s.name.as_bytes() != DUMMY) else {
        return Err(AudioError::Unfit(format!("{NAME} does not have a device to play on")));
    };
    let wide = channels(&sink, scene)?;
    let hz = scene.rate;
    if hz.fract() != 0.0 || hz > f64::from(protocol::sample_spec::MAX_RATE) {
        let why = format!("{NAME} cannot play at {hz} Hz; choose another rate, e.g. `--rate 48000Hz`");
        return Err(AudioError::Unfit(why));
    }
    let map = ChannelMap::new((&sink.channel_map).into_iter().take(wide));
    let made = with_timeout(WAKING, move || stream(line, sink.index, hz as u32, map, buffer));
    let made = made.unwrap_or_else(|| Err(Error::other("the server does not answer in time")));
    let Stream { line, made, sink, latency } = made.map_err(refused)?;
    let plays = sink.sample_spec.sample_rate;
    if f64::from(plays) != hz {
        return Err(AudioError::Unfit(format!("{NAME} plays at {plays} Hz, not at {hz} Hz; use `--rate {plays}Hz`")));
    }

    let frame = 4 * wide as u32;
    let device = sink.description.as_ref().unwrap_or(&sink.name).to_string_lossy().into_owned();
    let who = PlaybackDevice { host: NAME.into(), device, rate: hz as u32, channels: wide as u16 };
    let at_once = (made.buffer_attr.minimum_request_length / frame).max(1);
    let (follow, player, watch) = link(scene.counts.channels, scene.rates.ratio, who, at_once);
    // until the delay is measured: the queue before the next samples, and the latency of the device
    let queued = made.buffer_attr.target_length.saturating_sub(made.buffer_attr.minimum_request_length) / frame;
    let delay = 1e9 * f64::from(queued) / hz + 1e3 * latency.sink_usec.min(LATEST) as f64;
    watch.counts.delay.store(delay as u64, Relaxed);
    let (counts, (tell, words)) = (watch.counts.clone(), channel());
    let pulse = speak(line, made.channel, player, (counts.clone(), tell), wide, hz as usize, request);
    let output = Output::Pulse(pulse.map_err(refused)?);
    Ok((OpenOutput { output, counts, words, name: NAME.into(), host: NAME, events: None }, follow, watch))
}

#[cfg(feature = "devices")]
pub(super) fn is_there() -> bool {
    with_timeout(PATIENCE, || Connection::open(PATIENCE).is_ok()) == Some(true)
}

/// Runs `ask` on a new thread and abandons it after `patience`: a hanging server, or one that never stops talking, may
/// block any call.
fn with_timeout<T: Send + 'static>(patience: Duration, ask: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    let (tell, told) = channel();
    let asked = thread::Builder::new().name("ca pulse".into()).spawn(move || {
        let _ = tell.send(ask());
    });
    asked.ok().and_then(|_| told.recv_timeout(patience).ok())
}

/// Returns the number of channels for the sink; one channel goes to both sides.
fn channels(sink: &SinkInfo, scene: &Scene) -> std::result::Result<usize, AudioError> {
    let most = usize::from(sink.channel_map.num_channels());
    if scene.counts.channels > most {
        let n = scene.counts.channels;
        return Err(AudioError::Unfit(format!(
            "{NAME} has {most} channels, but the model has {n} outputs; combine some of them"
        )));
    }
    Ok(if scene.counts.channels == 1 { most.min(2) } else { scene.counts.channels })
}

/// Returns the default sink; `None` if there is none.
fn default_sink(mut line: Connection) -> (Connection, Option<SinkInfo>) {
    let name = Some(protocol::DEFAULT_SINK.to_owned());
    let sink = line.request(&Command::GetSinkInfo(GetSinkInfo { index: None, name })).ok();
    (line, sink)
}

/// Creates a stream with its queue full of silence, and starts it.
fn stream(mut line: Connection, sink: u32, hz: u32, map: ChannelMap, buffer: u32) -> Result<Stream> {
    let wide = map.num_channels();
    let at_once = 4 * u32::from(wide) * buffer;
    let mut props = Props::new();
    props.set(Prop::MediaName, c"ca");
    let params = PlaybackStreamParams {
        sample_spec: SampleSpec { format: SampleFormat::Float32Le, channels: wide, sample_rate: hz },
        channel_map: map,
        sink_index: Some(sink),
        buffer_attr: BufferAttr {
            target_length: QUEUED * at_once,
            pre_buffering: 0,
            minimum_request_length: at_once,
            ..BufferAttr::default()
        },
        props,
        flags: StreamFlags {
            start_corked: true,
            adjust_latency: true,
            no_remix_channels: true,
            ..StreamFlags::default()
        },
        ..PlaybackStreamParams::default()
    };
    let made: CreatePlaybackStreamReply = line.request(&Command::CreatePlaybackStream(params))?;
    if made.requested_bytes.max(made.buffer_attr.minimum_request_length) > LARGEST {
        return Err(wrong("it requested too many samples at once"));
    }
    // now at the rate of the stream, if the sink has switched
    let info = Command::GetSinkInfo(GetSinkInfo { index: Some(made.sink_index), name: None });
    let sink = line.request(&info)?;
    let mut silence = vec![0; protocol::DESCRIPTOR_SIZE + made.requested_bytes as usize];
    head(&mut silence, made.channel);
    line.send(&silence)?;
    line.order(&Command::CorkPlaybackStream(CorkStreamParams { channel: made.channel, cork: false }))?;
    let latency = line.request(&latency(made.channel))?;
    Ok(Stream { line, made, sink, latency })
}

fn latency(channel: u32) -> Command {
    Command::GetPlaybackLatency(LatencyParams { channel, now: SystemTime::UNIX_EPOCH })
}

/// Writes the header of a message of samples into its first bytes.
fn head(message: &mut [u8], channel: u32) {
    let length = message.len().saturating_sub(protocol::DESCRIPTOR_SIZE) as u32;
    let head = protocol::Descriptor { length, channel, offset: 0, flags: protocol::DescriptorFlags::empty() };
    if let Some(at) = message.first_chunk_mut() {
        protocol::encode_descriptor(at, &head);
    }
}

fn speak(
    mut line: Connection,
    channel: u32,
    player: Player,
    (counts, tell): (Arc<Counts>, Sender<String>),
    wide: usize,
    rate: usize,
    request: RtRequest,
) -> Result<PulseStream> {
    line.wait()?;
    let end = line.end()?;
    let query = line.encoded(&latency(channel))?;
    let sound = vec![0.0; MOST * wide];
    let message = Vec::with_capacity(protocol::DESCRIPTOR_SIZE + 4 * MOST * wide);
    let speaker = Speaker { line, channel, player, counts, wide, rate, sound, message, query, given: 0, last: 0 };
    let over = Arc::new(AtomicBool::new(false));
    let ended = over.clone();
    let thread = thread::Builder::new().name("ca pulse".into()).spawn(move || {
        rt::ask(request);
        let why = speaker.run();
        ended.store(true, Relaxed);
        let _ = tell.send(why);
    })?;
    Ok(PulseStream { end, over, thread: Some(thread) })
}

/// State of the thread that answers the server.
struct Speaker {
    line: Connection,
    channel: u32,
    player: Player,
    counts: Arc<Counts>,
    wide: usize,
    /// Sample rate \[Hz\].
    rate: usize,
    /// Interleaved samples.
    sound: Vec<f32>,
    message: Vec<u8>,
    /// Number and bytes of the latency query.
    query: (u32, Vec<u8>),
    /// Samples sent since the last query.
    given: usize,
    /// Samples of the last message before it.
    last: usize,
}

impl Speaker {
    /// Runs until the connection ends, and returns the reason.
    fn run(mut self) -> String {
        loop {
            if let Err(e) = self.write_samples() {
                return format!("lost connection to the server ({e})");
            }
            match self.line.next() {
                Ok(ServerMessage::Answer(n, at)) if n == self.query.0 => self.measure(at),
                Ok(ServerMessage::Underflow) => {
                    self.counts.xruns.fetch_add(1, Relaxed);
                }
                Ok(ServerMessage::Killed) => return "the server ended the stream".into(),
                Ok(_) => {}
                Err(e) => return format!("lost connection to the server ({e})"),
            }
        }
    }

    /// Sends the samples requested.
    fn write_samples(&mut self) -> Result<()> {
        let frame = 4 * self.wide;
        let at = now_ns();
        while self.line.pending_bytes >= frame {
            let n = (self.line.pending_bytes / frame).min(MOST);
            let sound = &mut self.sound[..n * self.wide];
            self.player.fill(sound, self.wide, at);
            self.message.clear();
            self.message.resize(protocol::DESCRIPTOR_SIZE, 0);
            self.message.extend(sound.iter().flat_map(|x| x.to_le_bytes()));
            head(&mut self.message, self.channel);
            self.line.send(&self.message)?;
            self.line.pending_bytes -= n * frame;
            (self.given, self.last) = (self.given + n, n);
        }
        if self.given >= self.rate {
            self.given = 0;
            self.line.send(&self.query.1)?;
        }
        Ok(())
    }

    /// Measures the delay of the first sample of the last message: the queue before it, and the latency of the device.
    fn measure(&self, at: usize) {
        if let Ok(l) = self.line.answer::<PlaybackLatency>(at) {
            let queued = l.write_offset.saturating_sub(l.read_offset) / (4 * self.wide) as i64 - self.last as i64;
            let delay =
                1e9 * queued.clamp(0, LARGEST.into()) as f64 / self.rate as f64 + 1e3 * l.sink_usec.min(LATEST) as f64;
            self.counts.delay.store(delay as u64, Relaxed);
        }
    }
}

pub(super) struct PulseStream {
    end: UnixStream,
    over: Arc<AtomicBool>,
    thread: Option<thread::JoinHandle<()>>,
}

impl PulseStream {
    pub(super) fn is_over(&self) -> bool {
        self.over.load(Relaxed)
    }
}

impl Drop for PulseStream {
    fn drop(&mut self) {
        let _ = self.end.shutdown(Shutdown::Both);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
