//! Summary of a fit: the numbers, the distances, and the predictions of the model.

use super::loss::spectral::Spectral;
use super::loss::wave::{self, Wave};
use super::loss::{Free, Loss};
use super::player::Player;
use super::search::Point;
use super::stages::{Found, Work};
use super::target::{Samples, Target};
use super::verdict::Known;
use super::verdict::{Doubt, StopReason, explained};
use super::{Distance, Fit, Fitted, Pitch, Prediction, Shown, Stage, sinusoids};
use ca_lab::Failure;

impl Work<'_> {
    pub fn summary(&self, player: &mut Player, before: &Point, found: &Found, known: Known) -> Result<Fit, Failure> {
        let point = &found.point;
        let (stage, until) = match found.until {
            Some(until) => (Stage::Samples, until),
            None => (Stage::Levels, 0),
        };
        let Target { rate, onset, fitted, .. } = self.target;
        let there = self.target.samples.first().map_or(0, Vec::len);
        let levels = Spectral::of(&self.target, 0, fitted, self.gain);
        let wave = self.wave(fitted);
        let distance = |p: &Point| {
            // each at its best gain, since loudness is not part of the comparison
            let (l, w) = (levels.settle(&p.sound, p.free), wave.settle(&p.sound, p.free));
            Distance { levels: levels.decibel(&p.sound, l), samples: wave.decibel(&p.sound, w) }
        };
        let before = Point { free: self.aligned(before, fitted), ..before.clone() };
        let free = match stage {
            Stage::Samples => self.wave(until).settle(&point.sound, point.free),
            Stage::Levels => self.aligned(point, fitted),
        };
        let mut point = Point { free, ..point.clone() };
        if self.is_beyond() {
            player.frames = self.frames(there, free.delay);
            point.sound = player.render(&point.places)?.unwrap_or(point.sound);
        }
        let point = point;
        // the gain at which levels agree, with its sign from the samples
        let level = levels.settle(&point.sound, free);
        let beyond = self.beyond(&point, level);
        let loaded = player.model(&point.places)?;
        let [was, is] = [&before, &point].map(distance);
        let explained = explained(&is);
        let pitch = Pitch::of(&self.target.samples, &before.sound, &point.sound, rate);
        let doubt = match known.halt {
            _ if !explained => Some(Doubt::Unexplained),
            _ if pitch.ends_elsewhere() => Some(Doubt::Elsewhere),
            StopReason::Renders | StopReason::Stuck => Some(Doubt::Unsettled),
            StopReason::Settled if pitch.starts_far() && stage == Stage::Levels => Some(Doubt::Far),
            StopReason::Settled => None,
        };
        let list = self.varied.iter().zip(&point.places).zip(&self.ends).zip(known.deviations);
        let fitted_numbers = list
            .map(|(((v, place), ends), found)| {
                let value = v.value(*place);
                let at_end = *place <= ends[0] || *place >= ends[1];
                let doubt = if found.is_none() { Some(Doubt::Undetermined) } else { doubt };
                let deviation = found.filter(|_| doubt.is_none()).map(|d| v.deviation(value, d));
                Fitted { varied: v.clone(), value, deviation, doubt, at_end }
            })
            .collect();
        let gained = |p: &Point, free: Free| -> Samples {
            p.sound
                .iter()
                .map(|c| {
                    let mut to = Vec::with_capacity(there);
                    wave::delayed(c, free.delay, 0, there, &mut to);
                    for x in &mut to {
                        *x *= free.gain;
                    }
                    to
                })
                .collect()
        };
        let shown_free = if stage == Stage::Samples { point.free } else { level };
        let shown = Shown {
            rate,
            fitted,
            target: self.target.samples.clone(),
            before: gained(&before, levels.settle(&before.sound, before.free)),
            after: gained(&point, shown_free),
        };
        Ok(Fit {
            loaded,
            fitted: fitted_numbers,
            gain: shown_free.gain,
            delay: (point.free.delay + self.target.begin as f64) / rate,
            renders: player.renders,
            stage,
            phase: until.saturating_sub(onset) as f64 / rate,
            seconds: (fitted - onset) as f64 / rate,
            halt: known.halt,
            explained,
            pitch,
            before: was,
            after: is,
            beyond,
            shown,
            words: self.words,
        })
    }

    /// Returns how well the model, and damped sinusoids, predict the time after the fitted part.
    fn beyond(&self, point: &Point, level: Free) -> Option<Prediction> {
        let Target { rate, onset, fitted, ref samples, .. } = self.target;
        let there = samples.first().map_or(0, Vec::len);
        if !self.is_beyond() {
            return None;
        }
        // gain and delay count too; a sinusoid has four numbers
        let numbers = self.varied.len() + 1 + usize::from(self.gain.is_none());
        let count = numbers.div_ceil(4);
        let other = sinusoids::continued(samples, (onset, fitted, there), count, rate);
        let of = |heard: &Samples, levels: Free, wave: Free| Distance {
            levels: Spectral::of(&self.target, fitted, there, Some(levels.gain)).decibel(heard, levels),
            samples: Wave::of(&self.target, fitted, there, Some(wave.gain), false).decibel(heard, wave),
        };
        let one = Free { gain: 1.0, delay: 0.0 };
        Some(Prediction {
            seconds: (there - fitted) as f64 / rate,
            model: of(&point.sound, level, point.free),
            sinusoids: of(&other, one, one),
            count,
        })
    }
}
