//! What is said of a fit at its end: how well each number is known, and what the model predicts.

use super::loss::{Free, Loss, STRETCHES};
use super::normal::{Normal, dot};
use super::player::Player;
use super::search::{Point, Slopes, free_columns};
use super::spectral::Spectral;
use super::target::{Samples, Target};
use super::wave::{self, Wave};
use super::work::Work;
use super::{Beyond, Distance, Fit, Fitted, Shown, Stage, sinusoids};
use crate::Failure;

/// What is known worse than this, as a logarithm or a part of its scale, is not determined.
const UNKNOWN: f64 = 0.7;

impl Work<'_> {
    /// The standard deviations of places.
    pub fn known(
        &self,
        player: &mut Player,
        loss: &dyn Loss,
        point: &Point,
        slopes: &mut Option<Slopes>,
    ) -> Result<Vec<Option<f64>>, Failure> {
        let n = self.varied.len();
        if !slopes.as_ref().is_some_and(|s| s.is_at(point)) && player.left() >= n as u32 {
            *slopes = Some(Slopes::at(player, point, &self.ends)?);
        }
        let Some(slopes) = slopes else { return Ok(vec![None; n]) };
        let point = &Point { free: loss.settle(&point.heard, point.free), ..point.clone() };
        let r = loss.residual(&point.heard, point.free);
        let mut columns = slopes.columns(loss, point, &r);
        columns.extend(free_columns(loss, point, &r));
        let Some(normal) = Normal::of(&columns) else { return Ok(vec![None; n]) };
        let mut sums = vec![vec![0.0; columns.len()]; STRETCHES];
        for (i, stretch) in loss.stretches().into_iter().enumerate() {
            sums[stretch].iter_mut().zip(&columns).for_each(|(s, c)| *s += c[i] * r[i]);
        }
        let degrees = r.len().saturating_sub(columns.len()).max(1);
        let variances = normal.variances(&sums, dot(&r, &r) / degrees as f64);
        Ok(variances.into_iter().take(n).map(|v| v.map(libm::sqrt).filter(|d| *d < UNKNOWN)).collect())
    }

    pub fn summary(
        &self,
        player: &mut Player,
        before: &Point,
        point: &Point,
        (stage, until): (Stage, usize),
        found: Vec<Option<f64>>,
    ) -> Result<Fit, Failure> {
        let Target { rate, onset, fitted, .. } = self.target;
        let there = self.target.samples.first().map_or(0, Vec::len);
        let levels = Spectral::of(&self.target, 0, fitted, self.gain);
        let wave = self.wave(fitted);
        let distance = |p: &Point| {
            // each at its best gain: what is compared is the model, not its loudness
            let (l, w) = (levels.settle(&p.heard, p.free), wave.settle(&p.heard, p.free));
            Distance { levels: levels.decibel(&p.heard, l), samples: wave.decibel(&p.heard, w) }
        };
        let before = Point { free: self.aligned(before, fitted), ..before.clone() };
        let free = match stage {
            Stage::Samples => self.wave(until).settle(&point.heard, point.free),
            Stage::Levels => self.aligned(point, fitted),
        };
        let mut point = Point { free, ..point.clone() };
        if self.is_beyond() {
            player.frames = self.frames(there, free.delay);
            point.heard = player.render(&point.places)?.unwrap_or(point.heard);
        }
        let point = point;
        // the gain by which levels agree, with the sign that samples give it
        let level = levels.settle(&point.heard, free);
        let beyond = self.beyond(&point, level);
        let loaded = player.model(&point.places)?;
        let list = self.varied.iter().zip(&point.places).zip(&self.ends).zip(found);
        let fitted_numbers = list
            .map(|(((v, place), ends), found)| {
                let value = v.value(*place);
                let at_end = *place <= ends[0] || *place >= ends[1];
                let deviation = found.map(|d| v.deviation(value, d));
                Fitted { varied: v.clone(), value, deviation, at_end }
            })
            .collect();
        let gained = |p: &Point, free: Free| -> Samples {
            p.heard
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
            before: gained(&before, levels.settle(&before.heard, before.free)),
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
            before: distance(&before),
            after: distance(&point),
            beyond,
            shown,
        })
    }

    /// How well what was not fitted is predicted, by the model and by damped sinusoids.
    fn beyond(&self, point: &Point, level: Free) -> Option<Beyond> {
        let Target { rate, onset, fitted, ref samples, .. } = self.target;
        let there = samples.first().map_or(0, Vec::len);
        if !self.is_beyond() {
            return None;
        }
        // gain and delay are numbers too; a sinusoid has four
        let numbers = self.varied.len() + 1 + usize::from(self.gain.is_none());
        let count = numbers.div_ceil(4);
        let other = sinusoids::continued(samples, (onset, fitted, there), count, rate);
        let of = |heard: &Samples, levels: Free, wave: Free| Distance {
            levels: Spectral::of(&self.target, fitted, there, Some(levels.gain)).decibel(heard, levels),
            samples: Wave::of(&self.target, fitted, there, Some(wave.gain), false).decibel(heard, wave),
        };
        let one = Free { gain: 1.0, delay: 0.0 };
        Some(Beyond {
            seconds: (there - fitted) as f64 / rate,
            model: of(&point.heard, level, point.free),
            sinusoids: of(&other, one, one),
            count,
        })
    }
}
