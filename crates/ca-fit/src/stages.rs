//! Stages of a fit and their order.
//!
//! The search has several starts: the point whose modes lie at the partials, the values of the model, and some values
//! of each number that modes do not depend on, such as the mass of a hammer. Each start descends by samples if phases
//! agree at once, otherwise by levels and then by samples. The search ends with the first start that leaves almost no
//! residual, or with the budget of renders.

use super::loss::spectral::Spectral;
use super::loss::wave::Wave;
use super::loss::{Free, Loss};
use super::modal::{self, partials};
use super::normal_equations::dot;
use super::player::Player;
use super::search::{Point, Rules, Slopes, Stop, descend};
use super::target::{self, Target};
use super::variables::Varied;
use super::verdict::{Known, StopReason, Words};
use super::{BEYOND, FEW, Fit};
use ca_lab::Failure;

/// Latest onset of the model that is allowed for \[s\].
const LATE: f64 = 2.0;
/// First window in which samples are compared \[s\], and the factor by which it grows.
const FIRST: f64 = 0.03;
const GROWS: f64 = 1.8;
/// Steps tried for a number that modes do not depend on, as logarithms or in units of its scale.
const SCAN: [f64; 4] = [-0.7, -0.35, 0.35, 0.7];
/// Sample residual at which no further start is tried \[dB\].
const FOUND: f64 = -25.0;
/// Phases agree where the residual has less than this fraction of the power of the sound.
const AGREES: f64 = 0.5;
/// Samples determine the result where the residual has less than this fraction of the power.
const SURE: f64 = 0.1;
/// Windows from the onset by which a delay is found \[s\].
const ALIGNED: [f64; 2] = [0.03, 0.15];
/// Greatest difference between the delay and the distance of the onsets \[s\].
const LAG: f64 = 0.003;

/// End of the search from one start.
pub(super) struct Found {
    pub point: Point,
    /// Last sample of the window in which samples determined the result; `None` where levels did.
    pub until: Option<usize>,
    /// True if renders ran out before samples were followed as far as phases agree.
    pub cut: bool,
}

pub(super) struct Work<'a> {
    pub target: Target,
    pub varied: &'a [Varied],
    /// Bounds of the search coordinates.
    pub ends: Vec<[f64; 2]>,
    /// Gain, if it is not free.
    pub gain: Option<f64>,
    pub words: &'static Words,
}

impl Work<'_> {
    pub fn run(&self, player: &mut Player) -> Result<Fit, Failure> {
        let Target { rate, onset, fitted, .. } = self.target;
        let start: Vec<f64> = vec![0.0; self.varied.len()];
        let start: Vec<f64> = start.iter().zip(&self.ends).map(|(p, e)| p.clamp(e[0], e[1])).collect();
        // the onset of the model is not known yet
        player.frames = (fitted + (LATE * rate) as usize) as u64;
        let levels = Spectral::of(&self.target, 0, fitted, self.gain);
        let Some(first) = self.point(player, &start)? else {
            return Err(Failure::Failed(
                "the model makes no sound or diverges at its start values; change them".into(),
            ));
        };
        player.frames = self.frames(fitted, first.free.delay);
        let point = Point { free: levels.settle(&first.sound, first.free), ..first };
        let before = point.clone();
        let partials = partials::partials(&self.target.samples, (onset + (0.02 * rate) as usize).min(fitted), rate);
        let mut moved = vec![false; start.len()];
        let mut starts = vec![point];
        if let Some(placed) = modal::place(player, &partials, &start, &self.ends)? {
            moved = placed.moved;
            if let Some(tried) = self.point(player, &placed.places)? {
                starts.insert(0, Point { free: levels.settle(&tried.sound, tried.free), ..tried });
            }
        }
        let starts = self.scanned(player, &levels, starts, &moved)?;
        let spare = self.spare();
        let mut best: Option<(f64, Found)> = None;
        let mut slopes: Option<Slopes> = None;
        for start in starts {
            if best.is_some() && player.left() < 3 * spare + FEW {
                break;
            }
            let rules = Rules { ends: &self.ends, still: &[], steps: 8, gains: 0.03, spare };
            let mut own: Option<Slopes> = None;
            // where phases agree already, samples determine more than levels
            let mut found = None;
            if self.agreement(&start).1 < AGREES {
                found = Some(self.samples(player, start.clone(), &mut own)?).filter(|f| f.until.is_some());
            }
            let found = if let Some(found) = found {
                found
            } else {
                let (downhill, _) = descend(player, &levels, start, &mut own, &rules)?;
                self.samples(player, downhill, &mut own)?
            };
            let score = self.score(&levels, &found.point, found.until);
            if best.as_ref().is_none_or(|b| score < b.0) {
                (best, slopes) = (Some((score, found)), own);
            }
            if best.as_ref().is_some_and(|b| b.0 < FOUND) {
                break;
            }
        }
        let Some((_, found)) = best else {
            return Err(Failure::Failed("no start values for the search".into()));
        };
        let (found, known) = self.to_the_end(player, found, &mut slopes)?;
        self.summary(player, &before, &found, known)
    }

    /// Continues by the distance that determined the result until it settles; after levels, by samples if phases agree.
    fn to_the_end(
        &self,
        player: &mut Player,
        mut found: Found,
        slopes: &mut Option<Slopes>,
    ) -> Result<(Found, Known), Failure> {
        let mut known = None;
        if found.until.is_none() {
            let by_levels =
                |until: usize| -> Box<dyn Loss> { Box::new(Spectral::of(&self.target, 0, until, self.gain)) };
            let (point, at_levels) =
                self.settled(player, (&by_levels, self.target.fitted), found.point.clone(), slopes)?;
            let moved = point.places != found.point.places;
            found.point = point;
            known = Some(at_levels);
            if moved {
                found = self.samples(player, found.point, slopes)?;
            }
        }
        if let Some(until) = found.until {
            let by_samples = |until: usize| -> Box<dyn Loss> { Box::new(self.wave(until)) };
            let (point, at_samples) = self.settled(player, (&by_samples, until), found.point, slopes)?;
            return Ok((Found { point, ..found }, at_samples));
        }
        let mut known = known.unwrap_or_else(|| Known::nothing(self.varied.len()));
        // samples were not followed as far as phases agree
        if found.cut {
            known.halt = StopReason::Renders;
        }
        Ok((found, known))
    }

    /// Samples to render up to sample `until` of the recording, with a margin for a delay that changes.
    pub fn frames(&self, until: usize, delay: f64) -> u64 {
        let early = libm::ceil((-delay).max(0.0)) as usize;
        (until + early + (0.02 * self.target.rate) as usize) as u64
    }

    /// Renders reserved for the uncertainty and for the time after the fitted part.
    pub fn spare(&self) -> u32 {
        self.varied.len() as u32 + u32::from(self.is_beyond())
    }

    /// Returns whether enough of the recording is not fitted.
    pub fn is_beyond(&self) -> bool {
        let there = self.target.samples.first().map_or(0, Vec::len);
        (there - self.target.fitted) as f64 >= BEYOND * self.target.rate
    }

    /// Rates a result \[dB\], by samples where they could be followed, otherwise by levels, which is worse.
    fn score(&self, levels: &Spectral, point: &Point, until: Option<usize>) -> f64 {
        match until {
            Some(until) => self.wave(until).decibel(&point.sound, point.free),
            None => levels.decibel(&point.sound, levels.settle(&point.sound, point.free)),
        }
    }

    /// Returns the gain and delay at which samples near the onset agree best, and the residual of the fitted part.
    fn agreement(&self, point: &Point) -> (Free, f64) {
        let Target { rate, onset, fitted, .. } = self.target;
        let wave = self.wave(fitted);
        let tried = ALIGNED.map(|seconds| {
            let free = self.aligned(point, (onset + (seconds * rate) as usize).min(fitted));
            let free = wave.settle(&point.sound, free);
            let r = wave.residual(&point.sound, free);
            (free, dot(&r, &r))
        });
        tried.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((point.free, 1.0))
    }

    /// Returns starts, best first, judged by samples where phases agree and otherwise by levels. Adds some values of
    /// each number that modes do not depend on: a blow may have several minima, and a descent finds only the nearest.
    fn scanned(
        &self,
        player: &mut Player,
        levels: &Spectral,
        points: Vec<Point>,
        moved: &[bool],
    ) -> Result<Vec<Point>, Failure> {
        let off = |p: &Point| match self.agreement(p).1 {
            left if left < AGREES => left,
            _ => 1.0 + levels.decibel(&p.sound, p.free),
        };
        let mut all: Vec<(f64, Point)> = points.into_iter().map(|p| (off(&p), p)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        for k in (0..moved.len()).filter(|k| !moved[*k]) {
            let centre = all[0].1.clone();
            for by in SCAN {
                // most of the remaining renders are for descents
                if player.left() < player.budget / 2 + self.varied.len() as u32 {
                    break;
                }
                let mut places = centre.places.clone();
                places[k] = (places[k] + by).clamp(self.ends[k][0], self.ends[k][1]);
                if places == centre.places {
                    continue;
                }
                if let Some(tried) = self.point(player, &places)? {
                    let tried = Point { free: levels.settle(&tried.sound, tried.free), ..tried };
                    all.push((off(&tried), tried));
                }
            }
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        Ok(all.into_iter().map(|a| a.1).collect())
    }

    /// Renders these coordinates and aligns the onset with the recording; `None` where that fails or is silent.
    fn point(&self, player: &mut Player, places: &[f64]) -> Result<Option<Point>, Failure> {
        let Some(heard) = player.render(places)? else { return Ok(None) };
        let Some(onset) = target::onset(&heard, self.target.rate) else { return Ok(None) };
        let delay = self.target.onset as f64 - onset as f64;
        Ok(Some(Point { places: places.to_vec(), free: Free { gain: 0.0, delay }, sound: heard }))
    }

    pub fn wave(&self, until: usize) -> Wave {
        Wave::of(&self.target, 0, until, self.gain, true)
    }

    /// Fits samples in windows that grow as far as phases agree; sets `until` if they cover the fitted part.
    fn samples(&self, player: &mut Player, mut point: Point, slopes: &mut Option<Slopes>) -> Result<Found, Failure> {
        let spare = self.spare();
        let Target { rate, onset, fitted, .. } = self.target;
        let before = point.clone();
        let mut windows: Vec<usize> = Vec::new();
        let mut seconds = FIRST;
        while onset + ((seconds * rate) as usize) < fitted {
            windows.push(onset + (seconds * rate) as usize);
            seconds *= GROWS;
        }
        windows.push(fitted);
        point.free = self.agreement(&point).0;
        let left = |point: &Point, until: usize| {
            let wave = self.wave(until);
            let free = wave.settle(&point.sound, point.free);
            let r = wave.residual(&point.sound, free);
            dot(&r, &r)
        };
        let mut reached: Option<usize> = None;
        let mut cut = false;
        loop {
            // the longest window in which phases agree already
            let next = windows.iter().copied().filter(|w| left(&point, *w) < AGREES).max();
            let Some(until) = next.filter(|w| reached.is_none_or(|r| *w > r)) else { break };
            let last = until == fitted;
            let rules = Rules {
                ends: &self.ends,
                still: &[],
                steps: if last { 12 } else { 3 },
                gains: if last { 1e-4 } else { 0.2 },
                spare,
            };
            let (next, stop) = descend(player, &self.wave(until), point, slopes, &rules)?;
            (point, cut) = (next, stop == Stop::Renders);
            reached = Some(until);
            if last {
                break;
            }
        }
        // otherwise what the model cannot follow would bias the numbers towards the strongest partials
        if reached == Some(fitted) && left(&point, fitted) < SURE {
            return Ok(Found { point, until: reached, cut });
        }
        Ok(Found { point: before, until: None, cut })
    }

    /// Returns the delay at which samples agree best, near the distance of the onsets.
    pub fn aligned(&self, point: &Point, until: usize) -> Free {
        let most = (LAG * self.target.rate) as i32;
        let wave = self.wave(until);
        let tried = (-most..=most).map(|lag| {
            let delay = libm::round(point.free.delay) + f64::from(lag);
            let free = wave.settle(&point.sound, Free { delay, ..point.free });
            let r = wave.residual(&point.sound, free);
            (dot(&r, &r), lag.abs(), free)
        });
        tried.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map_or(point.free, |t| t.2)
    }
}
