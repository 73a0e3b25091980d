//! Images of the gesture rate in the sound (E04): strong with held positions, weak with linear interpolation.

use crate::play::{TURN, case, list, num, scene, within};
use ca_core::internal::border::frame_due;
use ca_core::{Scene, tick};

/// Level of a one-second sound at `f` \[Hz\], in dB.
fn level(sound: &[f64], f: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (n, y) in sound.iter().enumerate() {
        let (sin, cos) = (TURN * f * n as f64 / sound.len() as f64).sin_cos();
        re += y * cos;
        im += y * sin;
    }
    20.0 * re.hypot(im).log10()
}

/// The last of three seconds at 48 kHz while the key moves by 1 mm at `f` \[Hz\].
fn play(scene: &Scene, f: f64) -> Vec<f64> {
    let mut s = scene.state();
    let mut sound = Vec::new();
    let mut frames = 0;
    while s.tick < 3 * 48_000 {
        if frame_due(scene, s.tick) {
            s.input[0] = 1e-3 * (TURN * f * f64::from(frames) / 3000.0).sin();
            frames += 1;
        }
        tick(scene, &mut s);
        if s.tick > 2 * 48_000 {
            sound.push(s.output[0]);
        }
    }
    sound
}

#[test]
fn e04_images_of_the_gesture_rate() {
    let case = case("E04");
    for border in ["hold", "linear"] {
        let text = format!("[rate]\nborder = \"{border}\"\n[TGR]\nkey = {{}}\n[SOX]\nout = {{ from = \"key\" }}\n");
        let scene = scene(&text);
        for (f, want) in list(case, "setup/f").into_iter().zip(list(case, &format!("values/{border}_dB"))) {
            let sound = play(&scene, f);
            let image = level(&sound, 3000.0 - f) - level(&sound, f);
            within(&format!("E04 {border}, {f} Hz"), (image - want).abs(), num(case, "tolerance/dB"));
        }
    }
}

/// A bar tuned to the image of a 150 Hz tremolo resonates with it.
#[test]
fn a_staircase_is_heard() {
    let rings = |border: &str| {
        let bar = "[CEL]\nbar = { m = \"1 g\", f = 2850, t60 = \"0.5 s\" }\n[TGR]\nkey = {}\n";
        let link = "[RES]\ntie = { between = [\"key\", \"bar\"], k = 100 }\n[SOX]\nout = { from = \"bar\" }\n";
        level(&play(&scene(&format!("[rate]\nborder = \"{border}\"\n{bar}{link}")), 150.0), 2850.0)
    };
    let (held, line) = (rings("hold"), rings("linear"));
    within("25.6 dB more", (held - line - 25.57).abs(), 0.15);
}
