//! Plays a bar as a client of a JACK server (also PipeWire). A frequency from 100 to 400 and Enter change its pitch.

// a failure here is a defect of the example
#![allow(clippy::missing_panics_doc, clippy::missing_errors_doc)]

use cordis_anima::voice::Param;
use cordis_anima::{Loaded, Options, Voice};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

const BAR: &str = r#"
[param]
pitch = { value = "220 Hz", live = true, min = "100 Hz", max = "400 Hz" }
[CEL]
bar = { m = "2 g", f = "pitch", t60 = "20 s", dx0 = "1 mm" }
[SOX]
out = { from = "bar", gain = 500 }
"#;

/// State of the thread of the server.
pub struct Player {
    voice: Voice,
    out: jack::Port<jack::AudioOut>,
    changes: Receiver<(Param, f64)>,
}

impl jack::ProcessHandler for Player {
    fn process(&mut self, _: &jack::Client, scope: &jack::ProcessScope) -> jack::Control {
        while let Ok((param, value)) = self.changes.try_recv() {
            self.voice.set(param, value, 64);
        }
        self.voice.process(&[], &mut [self.out.as_mut_slice(scope)]);
        jack::Control::Continue
    }
}

/// Returns the voice of the bar at a sound rate \[Hz\], and the handle of its pitch.
pub fn bar(rate: f64) -> (Voice, Param) {
    let options = Options { rate: Some(rate), ..Options::default() };
    let compiled = Loaded::read(BAR, "bar.ca.toml").compile(&options).expect("it compiles");
    let voice = Voice::new(Arc::new(compiled.scene));
    let pitch = voice.param("pitch").expect("it is live");
    (voice, pitch)
}

/// Client that plays until it is dropped.
pub struct Playing {
    client: jack::AsyncClient<(), Player>,
    pitch: Param,
    to_voice: SyncSender<(Param, f64)>,
}

impl Playing {
    /// Starts to play, as the client `name`.
    pub fn begin(name: &str) -> Result<Playing, jack::Error> {
        let (client, _) = jack::Client::new(name, jack::ClientOptions::NO_START_SERVER)?;
        let out = client.register_port("out_0", jack::AudioOut)?;
        let (voice, pitch) = bar(client.sample_rate() as f64);
        let (to_voice, changes) = sync_channel(16);
        let client = client.activate_async((), Player { voice, out, changes })?;
        Ok(Playing { client, pitch, to_voice })
    }

    /// Changes the pitch.
    pub fn pitch(&self, hertz: f64) {
        self.to_voice.send((self.pitch, hertz)).expect("the voice is there");
    }
}

fn main() -> Result<(), jack::Error> {
    let playing = Playing::begin("ca voice")?;
    let client = playing.client.as_client();
    let ours = format!("{}:out_0", client.name());
    for port in client.ports(Some("system:playback_.*"), None, jack::PortFlags::IS_INPUT) {
        client.connect_ports_by_name(&ours, &port)?;
    }
    println!("playing; type a frequency in Hz, or Ctrl-D to stop");
    let lines = std::io::stdin().lines().map_while(Result::ok);
    lines.filter_map(|line| line.trim().parse().ok()).for_each(|hertz| playing.pitch(hertz));
    Ok(())
}
