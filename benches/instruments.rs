//! Page of instruments with its pictures and sounds.
//!
//! `ca_benches::instruments` measures all that does not depend on the machine, as the test does. This bench measures
//! the speed of each instrument by one thread, with nothing else running, as the best of three. It prints the page;
//! with `UPDATE=1` it writes the page to `docs/instruments.md`, and pictures and sounds to `docs/instruments/`.

use ca_benches::instruments::page::page;
use ca_benches::instruments::{BUILT, Figures, Instrument, Plays, all, figures, on_all_cores};
use ca_io::flac;
use ca_io::format::Format;
use ca_report::{Sound, spectrogram};
use std::path::Path;

/// Largest size of a sound \[bytes\].
const LARGEST: usize = 110_000;
/// Fade at the end of a sound that is cut \[s\].
const FADE: f64 = 0.05;

/// Returns the loudest channel as 16-bit FLAC, cut if it would be too large.
fn sound(x: &[f64], rate: f64) -> Vec<u8> {
    let whole: Vec<f32> = x.iter().map(|v| v.clamp(-1.0, 1.0) as f32).collect();
    let mut n = whole.len();
    loop {
        let mut cut = whole[..n].to_vec();
        if n < whole.len() {
            let fade = (FADE * rate) as usize;
            let begin = n - fade;
            cut[begin..].iter_mut().enumerate().for_each(|(k, v)| *v *= 1.0 - k as f32 / fade as f32);
        }
        let bytes = flac::encode(&cut, 1, rate, Format::I16).expect("a sound can be encoded");
        if bytes.len() <= LARGEST {
            return bytes;
        }
        n = n * LARGEST / bytes.len() * 49 / 50;
    }
}

fn picture(channels: &[Vec<f64>], rate: f64) -> Vec<u8> {
    let names: Vec<String> = (0..channels.len()).map(|k| k.to_string()).collect();
    let mut sound = Sound::new(rate, &names);
    for n in 0..channels[0].len() {
        sound.push(&channels.iter().map(|c| c[n]).collect::<Vec<_>>());
    }
    spectrogram(&sound).and_then(|p| p.image).expect("a sound that is not silent").png
}

fn main() {
    // `cargo test --benches` only checks that it runs
    if !std::env::args().any(|a| a == "--bench") {
        let p = Plays::new(all()[0]);
        assert!(!p.play(BUILT).sound.is_empty());
        return;
    }
    let made: Vec<(&Instrument, Figures, Vec<u8>, Vec<u8>)> = on_all_cores(|i| {
        let p = Plays::new(i);
        let r = p.play(BUILT);
        (i, figures(&p), picture(&r.sound, r.rate), sound(r.loudest_channel(0.0, f64::INFINITY), r.rate))
    });
    // one by one, so that nothing else runs
    let times: Vec<(&str, String)> = made
        .iter()
        .map(|(i, ..)| {
            let p = Plays::new(i);
            let quickness = |_| {
                let r = p.render(BUILT, &[]);
                r.sound[0].len() as f64 / r.rate / r.wall
            };
            (i.model, format!("{:.0} ×", (0..3).map(quickness).fold(0.0, f64::max)))
        })
        .collect();
    let time = |name: &str| times.iter().find(|t| t.0 == name).map_or(String::new(), |t| t.1.clone());
    let rows: Vec<(&Instrument, Figures)> = made.iter().map(|m| (m.0, m.1.clone())).collect();
    let text = page(&rows, &ca_benches::machine(), &time);
    println!("{text}");
    if std::env::var_os("UPDATE").is_some() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let folder = docs.join("instruments");
        // also removes files of models that no longer exist
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("docs/ can be written");
        for (i, _, picture, sound) in &made {
            std::fs::write(folder.join(format!("{}.png", i.model)), picture).expect("a picture can be written");
            std::fs::write(folder.join(format!("{}.flac", i.model)), sound).expect("a sound can be written");
        }
        std::fs::write(docs.join("instruments.md"), text).expect("the page can be written");
    }
}
