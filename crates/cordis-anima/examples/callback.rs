//! A scene inside the callback of an audio interface, of whatever library: it fills a block of floats, allocates nothing,
//! and takes changes of live parameters from another thread through a channel of fixed size.

// what fails here is a defect of the example
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

/// What the callback owns.
pub struct Callback {
    voice: Voice,
    changes: Receiver<(Param, f64)>,
}

impl Callback {
    /// The callback: mono, any length.
    pub fn fill(&mut self, block: &mut [f32]) {
        while let Ok((param, value)) = self.changes.try_recv() {
            // over 64 samples, so that nothing clicks
            self.voice.set(param, value, 64);
        }
        self.voice.process(&[], &mut [block]);
    }
}

/// What the rest of the program keeps.
pub struct Panel {
    pitch: Param,
    to_voice: SyncSender<(Param, f64)>,
}

impl Panel {
    /// Moves the pitch.
    pub fn pitch(&self, hertz: f64) {
        self.to_voice.send((self.pitch, hertz)).expect("the voice is there");
    }
}

/// What fills blocks, and the panel that plays it.
pub fn voice() -> (Callback, Panel) {
    let compiled = Loaded::read(BAR, "bar.ca.toml").compile(&Options::default()).expect("it compiles");
    let voice = Voice::new(Arc::new(compiled.scene));
    let (to_voice, changes) = sync_channel(16);
    let panel = Panel { pitch: voice.param("pitch").expect("it is live"), to_voice };
    (Callback { voice, changes }, panel)
}

/// Plays a second in blocks of 128, as an audio interface would ask for them; half-way the pitch goes up a fifth.
/// Returns the sound.
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
