//! Plays a scene in the callback of an audio interface. The callback fills a block of floats, does not allocate, and
//! receives changes of live parameters from another thread through a channel of fixed size.

// a failure here is a defect of the example
#![allow(clippy::missing_panics_doc)]

use cordis_anima::voice::Param;
use cordis_anima::{Loaded, Options, Voice};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

const BAR: &str = r#"
[param]
pitch = { value = "220 Hz", live = true, min = "100 Hz", max = "400 Hz" }
[CEL]
bar = { m = "2 g", f = "pitch", t60 = "2 s", dx0 = "1 mm" }
[SOX]
out = { from = "bar", gain = 500 }
"#;

/// State of the callback.
pub struct Callback {
    voice: Voice,
    changes: Receiver<(Param, f64)>,
}

impl Callback {
    /// Fills a mono block of any length; call this in the audio callback.
    pub fn fill(&mut self, block: &mut [f32]) {
        while let Ok((param, value)) = self.changes.try_recv() {
            // 64 samples avoid a click
            self.voice.set(param, value, 64);
        }
        self.voice.process(&[], &mut [block]);
    }
}

/// Controls for the rest of the program.
pub struct Panel {
    pitch: Param,
    to_voice: SyncSender<(Param, f64)>,
}

impl Panel {
    /// Changes the pitch.
    pub fn pitch(&self, hertz: f64) {
        self.to_voice.send((self.pitch, hertz)).expect("the voice is there");
    }
}

/// Returns the callback and the panel that controls it.
pub fn voice() -> (Callback, Panel) {
    let compiled = Loaded::read(BAR, "bar.ca.toml").compile(&Options::default()).expect("it compiles");
    let voice = Voice::new(Arc::new(compiled.scene));
    let (to_voice, changes) = sync_channel(16);
    let panel = Panel { pitch: voice.param("pitch").expect("it is live"), to_voice };
    (Callback { voice, changes }, panel)
}

/// Plays a second in blocks of 128, as an audio interface would, and raises the pitch by a fifth half-way.
fn play() -> Vec<f32> {
    let (mut voice, panel) = voice();
    let (mut sound, mut block) = (Vec::new(), [0.0; 128]);
    for n in 0..375 {
        if n == 187 {
            panel.pitch(330.0);
        }
        voice.fill(&mut block);
        sound.extend_from_slice(&block);
    }
    sound
}

fn main() {
    let sound = play();
    println!("{} samples, {} rising zero crossings", sound.len(), crossings(&sound));
}

fn crossings(sound: &[f32]) -> usize {
    sound.windows(2).filter(|w| w[0] < 0.0 && w[1] >= 0.0).count()
}

#[test]
fn the_pitch_moves_while_it_plays() {
    let sound = play();
    let (low, high) = sound.split_at(188 * 128);
    let pitch = |s: &[f32]| crossings(s) as f64 * 48_000.0 / s.len() as f64;
    assert!((pitch(low) - 220.0).abs() < 3.0 && (pitch(high) - 330.0).abs() < 3.0, "{} {}", pitch(low), pitch(high));
}
