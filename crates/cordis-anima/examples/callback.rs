//! A scene inside the callback of an audio interface, of whatever library: it fills a block of floats, allocates nothing,
//! and takes changes of live parameters from another thread through a channel of fixed size.

// what fails here is a defect of the example
#![allow(clippy::missing_panics_doc)]

use cordis_anima::ca_core::live::{Controls, Patch};
use cordis_anima::{Loaded, Options, Scene, State, tick};
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
pub struct Voice {
    scene: Arc<Scene>,
    state: State,
    changes: Receiver<Patch>,
    /// patches go back to be freed where that is allowed
    used: SyncSender<Patch>,
}

impl Voice {
    /// The callback: mono, any length.
    pub fn fill(&mut self, block: &mut [f32]) {
        while let Ok(patch) = self.changes.try_recv() {
            // over 64 samples, so that nothing clicks
            self.state.apply(&patch, 64);
            let _ = self.used.try_send(patch);
        }
        for sample in block {
            tick(&self.scene, &mut self.state);
            *sample = self.state.output[0] as f32;
        }
    }
}

/// What the rest of the program keeps.
pub struct Panel {
    controls: Controls,
    to_voice: SyncSender<Patch>,
    from_voice: Receiver<Patch>,
}

impl Panel {
    /// Moves the pitch, and frees what the callback has done with.
    pub fn pitch(&mut self, hertz: f64) {
        let patch = self.controls.set("pitch", hertz).expect("a live parameter");
        self.to_voice.send(patch).expect("the voice is there");
        while self.from_voice.try_recv().is_ok() {}
    }
}

/// A voice for the callback, and the panel that plays it.
pub fn voice() -> (Voice, Panel) {
    let compiled = Loaded::read(BAR, "bar.ca.toml").compile(&Options::default()).expect("it compiles");
    let scene = Arc::new(compiled.scene);
    let ((to_voice, changes), (used, from_voice)) = (sync_channel(16), sync_channel(16));
    let panel = Panel { controls: scene.controls(), to_voice, from_voice };
    (Voice { state: scene.state(), scene, changes, used }, panel)
}

/// Plays a second in blocks of 128, as an audio interface would ask for them; half-way the pitch goes up a fifth.
/// Returns the sound.
fn play() -> Vec<f32> {
    let (mut voice, mut panel) = voice();
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
