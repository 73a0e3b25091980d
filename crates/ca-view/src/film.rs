//! Records a performance as a film: displacements at a fixed rate, small enough for a page.
//!
//! A number has 16 bits, scaled by the largest displacement on a line or in space. Each picture is the difference from
//! the one before, with low and high bytes separated, so that a general compressor works well without a special codec.
//! A long film first gets fewer pictures a second, then fewer masses.

use crate::drawing::Drawing;
use crate::graph::Source;
use ca_core::Scene;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde_json::{Value, json};
use std::io::Write as _;

/// Largest number of pictures a second, and the rate below which masses are left out.
const MOST: f64 = 60.0;
const LEAST: f64 = 20.0;
/// Numbers of a whole film: at 2 bytes each, and encoded as text, at most 5 MB.
const NUMBERS: f64 = 1.8e6;
/// Smallest number of masses to which a film is thinned.
const FEW: usize = 100;

/// Film of a performance.
pub struct Film {
    drawing: Drawing,
    /// Pictures a second.
    rate: f64,
    numbers: usize,
    /// True for numbers of masses in space (numbers).
    space: Vec<bool>,
    /// Displacements of all pictures \[m\].
    views: Vec<f32>,
    frames: usize,
    bytes: Vec<u8>,
}

impl Film {
    /// Prepares a film of `seconds` of a scene.
    pub fn new(scene: &Scene, seconds: f64) -> Film {
        let mut drawing = Drawing::new(scene);
        let fits = |numbers: usize| NUMBERS / (numbers.max(1) as f64 * seconds.max(0.1));
        let mut numbers = drawing.bytes / 4;
        if fits(numbers) < LEAST {
            let share = fits(numbers) / LEAST;
            drawing = Drawing::of_at_most(scene, ((drawing.masses() as f64 * share) as usize).max(FEW));
            numbers = drawing.bytes / 4;
        }
        let rate = fits(numbers).clamp(1.0, MOST);
        let space = drawing.source.iter().flat_map(|s| {
            let n = if matches!(s, Source::Space(_)) { 3 } else { 1 };
            std::iter::repeat_n(n == 3, n)
        });
        let space = space.collect();
        Film { rate, numbers, space, views: Vec::new(), frames: 0, bytes: Vec::new(), drawing }
    }

    /// Records the positions `x` at `time` \[s\] if a picture is due.
    pub fn look(&mut self, time: f64, x: &[f64]) {
        // a late picture also stands for those that were missed
        let due = ((time * self.rate + 1e-9).floor() as usize).saturating_add(1);
        if due <= self.frames || !time.is_finite() || time < 0.0 {
            return;
        }
        self.bytes.clear();
        self.drawing.view(x, &mut self.bytes);
        let of = |b: &[u8]| {
            let v = f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
            if v.is_finite() { v } else { 0.0 }
        };
        let view: Vec<f32> = self.bytes.chunks_exact(4).map(of).collect();
        while self.frames < due && (self.views.len() + self.numbers) as f64 <= 2.0 * NUMBERS {
            self.views.extend_from_slice(&view);
            self.frames += 1;
        }
    }

    /// Returns the number of pictures a second.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Returns the number of pictures.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Returns the film in the form that pages read: a description and the picture data.
    ///
    /// The description has the `drawing`, `rate` \[1/s\], `frames`, `numbers` of a picture, and `scale`, the size of a
    /// step on a line and in space \[m\]. The data are differences of 16 bits, all low bytes before all high bytes, in
    /// zlib format.
    ///
    /// # Errors
    /// Fails if the compressor fails.
    pub fn json(&self) -> std::io::Result<(Value, Vec<u8>)> {
        let most = |space: bool| {
            let all = self.views.chunks_exact(self.numbers.max(1)).flat_map(|v| v.iter().zip(&self.space));
            let largest = all.filter(|(_, s)| **s == space).map(|(v, _)| v.abs()).fold(0.0_f32, f32::max);
            if largest > 0.0 { largest / 32767.0 } else { 1.0 }
        };
        let scale = [most(false), most(true)];
        let mut before = vec![0_i16; self.numbers];
        let (mut low, mut high) = (Vec::with_capacity(self.views.len()), Vec::with_capacity(self.views.len()));
        for view in self.views.chunks_exact(self.numbers.max(1)) {
            for ((v, space), before) in view.iter().zip(&self.space).zip(&mut before) {
                let now = (v / scale[usize::from(*space)]).round() as i16;
                let [l, h] = now.wrapping_sub(*before).to_le_bytes();
                low.push(l);
                high.push(h);
                *before = now;
            }
        }
        let mut out = ZlibEncoder::new(Vec::new(), Compression::best());
        out.write_all(&low)?;
        out.write_all(&high)?;
        let about = json!({
            "drawing": self.drawing.json(),
            "rate": self.rate,
            "frames": self.frames,
            "numbers": self.numbers,
            "scale": scale,
        });
        Ok((about, out.finish()?))
    }
}
