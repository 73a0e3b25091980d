//! Sound of a page: a player, a waveform, and counts of samples that were clipped or not finite.
//!
//! The page has 16-bit WAV: every browser plays it, and it is half as large as floats. A long sound is stored in part
//! ([`KEPT`]) and the page says so; waveform and counts cover all of it. With more than two channels each has a
//! separate player, since outputs of a model are not surround channels.
use crate::envelope::Envelope;
use crate::plot::{Axis, Curve, Plot};
use std::io::Cursor;

/// Largest number of stored samples, over all channels: 87 s of two channels at 48 kHz, 22 MB of page.
pub const KEPT: usize = 1 << 23;
/// Largest number of channels with a player, a spectrum and a waveform.
pub const CHANNELS: usize = 8;

/// Sound that is filled step by step.
#[derive(Clone, Debug)]
pub struct Sound {
    rate: f64,
    names: Vec<String>,
    frames: u64,
    peak: Vec<f64>,
    clipped: u64,
    broken: u64,
    /// Stored samples, interleaved, within ±1.
    kept: Vec<f32>,
    waves: Envelope,
}

impl Sound {
    /// Returns an empty sound at `rate` \[Hz\] with the names of its channels.
    pub fn new(rate: f64, names: &[String]) -> Sound {
        let waves = Envelope::new(rate, names.len());
        let peak = vec![0.0; names.len()];
        Sound { rate, names: names.to_vec(), frames: 0, peak, clipped: 0, broken: 0, kept: Vec::new(), waves }
    }

    /// Appends whole frames of interleaved samples with full scale ±1. Larger samples are clipped, non-finite samples
    /// become silence, and both are counted.
    pub fn push(&mut self, frames: &[f64]) {
        let n = self.names.len();
        for frame in frames.chunks_exact(n.max(1)).filter(|f| f.len() == n) {
            self.waves.push(frame);
            let keep = self.kept.len() + n <= KEPT;
            for (x, peak) in frame.iter().zip(&mut self.peak) {
                self.broken += u64::from(!x.is_finite());
                let x = if x.is_finite() { *x } else { 0.0 };
                *peak = peak.max(x.abs());
                self.clipped += u64::from(x.abs() > 1.0);
                if keep {
                    self.kept.push(x.clamp(-1.0, 1.0) as f32);
                }
            }
            self.frames += 1;
        }
    }

    /// Returns the sound rate \[Hz\].
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Returns the names of the channels.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the length \[s\].
    pub fn seconds(&self) -> f64 {
        self.frames as f64 / self.rate
    }

    /// Returns the length that the page stores \[s\].
    pub fn held(&self) -> f64 {
        (self.kept.len() / self.names.len().max(1)) as f64 / self.rate
    }

    /// Returns the largest |sample| of each channel before clipping.
    pub fn peak(&self) -> &[f64] {
        &self.peak
    }

    /// Returns the number of samples that were clipped at ±1.
    pub fn clipped(&self) -> u64 {
        self.clipped
    }

    /// Returns the number of samples that were not finite.
    pub fn broken(&self) -> u64 {
        self.broken
    }

    /// Returns the stored samples of one channel.
    pub(crate) fn channel(&self, k: usize) -> Vec<f64> {
        self.kept.iter().skip(k).step_by(self.names.len().max(1)).map(|x| f64::from(*x)).collect()
    }

    /// Returns the players: a name and a WAV file each.
    pub(crate) fn players(&self) -> Vec<(String, Vec<u8>)> {
        let n = self.names.len();
        if self.kept.is_empty() {
            return Vec::new();
        }
        if n <= 2 {
            return vec![(self.names.join(", "), self.wav(&self.kept, n as u16))];
        }
        let one = |k: usize| self.kept.iter().skip(k).step_by(n).copied().collect::<Vec<f32>>();
        (0..n.min(CHANNELS)).map(|k| (self.names[k].clone(), self.wav(&one(k), 1))).collect()
    }

    fn wav(&self, samples: &[f32], channels: u16) -> Vec<u8> {
        let spec = hound::WavSpec {
            channels,
            sample_rate: self.rate.round().max(1.0) as u32,
            bits_per_sample: 16,
            sample_format: hound::SampleFormat::Int,
        };
        let mut file = Cursor::new(Vec::with_capacity(2 * samples.len() + 64));
        let written = hound::WavWriter::new(&mut file, spec).and_then(|mut w| {
            for x in samples {
                w.write_sample((f64::from(*x) * 32_768.0).round_ties_even().min(32_767.0) as i16)?;
            }
            w.finalize()
        });
        debug_assert!(written.is_ok(), "memory takes what is written");
        file.into_inner()
    }

    /// Returns the plot of the samples over time; full scale is ±1.
    pub fn waveform(&self) -> Plot {
        let curves = self.names.iter().enumerate().take(CHANNELS);
        let curves = curves.map(|(k, name)| Curve::line(name, self.waves.curve(k))).collect();
        Plot::over_time("Waveform", Axis::linear("sample", "of full scale"), self.waves.grid(), curves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(n: usize) -> Vec<String> {
        (0..n).map(|k| format!("c{k}")).collect()
    }

    #[test]
    fn what_is_played_is_what_came() {
        let mut s = Sound::new(48_000.0, &names(2));
        s.push(&[0.5, -0.5, 1.5, f64::NAN, -1.0, 1.0]);
        assert_eq!((s.peak(), s.clipped(), s.broken()), (&[1.5, 1.0][..], 1, 1));
        let players = s.players();
        assert_eq!((players.len(), players[0].0.as_str()), (1, "c0, c1"));
        let mut r = hound::WavReader::new(Cursor::new(&players[0].1)).unwrap();
        assert_eq!((r.spec().channels, r.spec().sample_rate), (2, 48_000));
        let samples: Vec<i16> = r.samples().map(Result::unwrap).collect();
        assert_eq!(samples, [16_384, -16_384, 32_767, 0, -32_768, 32_767]);
    }

    #[test]
    fn many_channels_have_a_player_each() {
        let mut s = Sound::new(44_100.0, &names(11));
        let frame: Vec<f64> = (0..11).map(|k| f64::from(k) / 16.0).collect();
        s.push(&frame);
        let players = s.players();
        assert_eq!(players.len(), CHANNELS);
        for (k, (name, wav)) in players.iter().enumerate() {
            let mut r = hound::WavReader::new(Cursor::new(wav)).unwrap();
            let samples: Vec<i16> = r.samples().map(Result::unwrap).collect();
            assert_eq!((name.as_str(), samples), (format!("c{k}").as_str(), vec![2048 * k as i16]));
        }
    }

    #[test]
    fn a_long_sound_is_held_in_part() {
        let mut s = Sound::new(100.0, &names(1));
        let block = vec![0.25; 1 << 20];
        (0..9).for_each(|_| s.push(&block));
        assert_eq!((s.held(), s.seconds()), (KEPT as f64 / 100.0, 9.0 * block.len() as f64 / 100.0));
        assert!(Sound::new(1.0, &[]).players().is_empty());
    }
}
