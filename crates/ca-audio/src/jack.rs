//! Sound through a JACK server, such as PipeWire.
//!
//! This program never starts a server. It uses the rate and the buffer of the server, and refuses a model of another
//! rate with a message that names the right one. The callback fills its own buffer and distributes it by channel; it
//! neither allocates nor locks. The MIDI port is not connected automatically, because the device behind it may also be
//! read directly.

use super::{OpenOutput, Output as Any};
use crate::AudioError;
use crate::midi_events::{EventReader, EventWriter, ring};
use ca_core::Scene;
use ca_haptic::rt::now_ns;
use ca_haptic::serve::audio::{Counts, DeviceClock, PlaybackDevice, Player, Watch, link};
use jack::{
    AsyncClient, AudioOut, Client, ClientOptions, Control, Frames, LatencyType, MidiIn, NotificationHandler, Port,
    PortFlags, ProcessHandler, ProcessScope,
};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Sender, channel};

/// Frames filled at a time: more than a server requests.
const MOST: usize = 8192;

/// A client of a server, before and after it is activated.
pub(super) struct Output {
    waits: Option<(Client, Process, Notes)>,
    plays: Option<AsyncClient<Notes, Process>>,
    /// Names of the client's ports.
    ports: Vec<String>,
    counts: Arc<Counts>,
    rate: f64,
    words: Sender<String>,
}

/// Opens a client, with a MIDI port if `midi` is set.
///
/// Returns [`AudioError::Failed`] if no server answers, [`AudioError::Unfit`] if the server cannot play the scene as it
/// is.
pub(super) fn open(
    scene: &Scene,
    buffer: Option<u32>,
    midi: bool,
) -> Result<(OpenOutput, DeviceClock, Watch), AudioError> {
    let none = |_| {
        let how =
            "no JACK server answers; start one (`jackd -d alsa -r 48000 -p 64`) or set JACK_DEFAULT_SERVER to its name";
        AudioError::Failed(how.into())
    };
    let (client, _) = Client::new("ca", ClientOptions::NO_START_SERVER).map_err(none)?;
    let (rate, frames) = (client.sample_rate() as u32, client.buffer_size());
    if f64::from(rate) != scene.rate {
        let why = format!("JACK plays at {rate} Hz, not at {} Hz; use `--rate {rate}Hz`", scene.rate);
        return Err(AudioError::Unfit(why));
    }
    if let Some(n) = buffer.filter(|n| *n != frames) {
        let why = format!("JACK uses buffers of {frames} frames, not {n}; its server sets the size (`jackd -p {n}`)");
        return Err(AudioError::Unfit(why));
    }
    // one channel goes to both sides
    let wide = if scene.counts.channels == 1 { 2 } else { scene.counts.channels };
    let failed = |e: jack::Error| AudioError::Failed(e.to_string());
    let ports: Vec<Port<AudioOut>> = (0..wide)
        .map(|k| client.register_port(&format!("out_{k}"), AudioOut))
        .collect::<Result<_, _>>()
        .map_err(failed)?;
    let names: Vec<String> = ports.iter().map(Port::name).collect::<Result<_, _>>().map_err(failed)?;
    let (midi, events) = midi.then(|| midi_in(&client)).transpose().map_err(failed)?.unzip();
    let who = PlaybackDevice { host: "JACK".into(), device: client.name().to_string(), rate, channels: wide as u16 };
    let (follow, player, watch) = link(scene.counts.channels, scene.rates.ratio, who, frames);
    let (tell, words) = channel();
    let counts = watch.counts.clone();
    let process = Process { ports, midi, player, mixed: vec![0.0; MOST * wide] };
    let notes = Notes { counts: counts.clone() };
    let output = Output {
        waits: Some((client, process, notes)),
        plays: None,
        ports: names,
        counts: counts.clone(),
        rate: f64::from(rate),
        words: tell,
    };
    let output = Any::Jack(Box::new(output));
    Ok((OpenOutput { output, counts, words, name: "JACK".into(), host: "JACK", events }, follow, watch))
}

/// Opens a MIDI port, with both ends of the ring for its events.
fn midi_in(client: &Client) -> Result<((Port<MidiIn>, EventWriter), EventReader), jack::Error> {
    let port = client.register_port("midi_in", MidiIn)?;
    let (writer, reader) = ring(format!("JACK port {}", port.name()?));
    Ok(((port, writer), reader))
}

#[cfg(feature = "devices")]
pub(super) fn is_there() -> bool {
    Client::new("ca", ClientOptions::NO_START_SERVER).is_ok()
}

impl Output {
    pub(super) fn start(&mut self) -> Result<(), jack::Error> {
        let Some((client, process, notes)) = self.waits.take() else { return Ok(()) };
        let plays = client.activate_async(notes, process)?;
        let client = plays.as_client();
        let to = client.ports(None, Some("32 bit float mono audio"), PortFlags::IS_PHYSICAL | PortFlags::IS_INPUT);
        for (ours, to) in self.ports.iter().zip(&to) {
            if let Err(e) = client.connect_ports_by_name(ours, to) {
                let _ = self.words.send(format!("cannot connect {ours} to {to}: {e}"));
            }
        }
        let port = self.ports.first().and_then(|p| client.port_by_name(p));
        let late = port.map_or(0, |p| p.get_latency_range(LatencyType::Playback).1);
        self.counts.delay.store((f64::from(late) / self.rate * 1e9) as u64, Relaxed);
        self.plays = Some(plays);
        Ok(())
    }

    /// Leaves without telling the server.
    pub(super) fn leave(self) {
        std::mem::forget(self.plays);
    }
}

/// Receives notifications of the server. The end of a server shows as missing calls.
struct Notes {
    counts: Arc<Counts>,
}

impl NotificationHandler for Notes {
    fn xrun(&mut self, _: &Client) -> Control {
        self.counts.xruns.fetch_add(1, Relaxed);
        Control::Continue
    }
}

/// Fills the buffers that the server requests.
struct Process {
    ports: Vec<Port<AudioOut>>,
    midi: Option<(Port<MidiIn>, EventWriter)>,
    player: Player,
    /// Interleaved samples.
    mixed: Vec<f32>,
}

impl ProcessHandler for Process {
    fn process(&mut self, _: &Client, scope: &ProcessScope) -> Control {
        let (at, wide) = (now_ns(), self.ports.len());
        if let Some((port, events)) = &mut self.midi {
            port.iter(scope).for_each(|e| events.push(e.bytes));
        }
        let (mut from, all) = (0, scope.n_frames() as usize);
        while from < all {
            let n = (all - from).min(MOST);
            let mixed = &mut self.mixed[..n * wide];
            self.player.fill(mixed, wide, at);
            for (k, port) in self.ports.iter_mut().enumerate() {
                let out = port.as_mut_slice(scope).iter_mut().skip(from);
                out.zip(mixed[k..].iter().step_by(wide)).for_each(|(to, x)| *to = *x);
            }
            from += n;
        }
        Control::Continue
    }

    fn buffer_size(&mut self, _: &Client, _: Frames) -> Control {
        Control::Continue
    }
}
