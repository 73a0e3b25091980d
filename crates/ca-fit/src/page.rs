//! Report on a fit: the recording, the model before and after, and the residual.

use super::{Distance, Doubt, Fit, Fitted, Stage, target};
use ca_model::quantity::{Plain, six};
use ca_report::{Axis, Block, Curve, Grid, Plot, Report, Section, Sound, Spectrum, Table, Weight, spectrogram};

/// Time between two points of a level curve \[s\].
const BLOCK: f64 = 0.01;

impl Fitted {
    /// Uncertainty in words, as two standard deviations, or the reason why there is none.
    pub fn uncertainty(&self) -> String {
        match (self.deviation, self.doubt) {
            (Some(d), _) => {
                let part = 200.0 * d / self.value.abs();
                let part = if part.is_finite() { format!(" ({} %)", Plain(two(part))) } else { String::new() };
                let unit = &self.varied.unit;
                format!("± {} {unit}{part}", Plain(two(2.0 * d))).replace("  ", " ")
            }
            (None, Some(Doubt::Unsettled)) => "uncertainty unknown: the search did not converge".into(),
            (None, Some(Doubt::Unexplained)) => "uncertainty unknown: the model does not explain this sound".into(),
            (None, Some(Doubt::Elsewhere)) => "uncertainty unknown: the pitch differs from the recording".into(),
            (None, Some(Doubt::Far)) => "uncertainty unknown: the model started at another pitch".into(),
            (None, Some(Doubt::Undetermined) | None) => "not determined by this sound".into(),
        }
    }
}

pub(super) fn two(v: f64) -> f64 {
    ca_model::quantity::rounded(v, 2)
}

fn distance(d: &Distance) -> Vec<String> {
    vec![format!("{:.2} dB", d.levels), format!("{:.2} dB", d.samples)]
}

fn row(name: &str, d: &Distance) -> Vec<String> {
    std::iter::once(name.to_owned()).chain(distance(d)).collect()
}

/// Makes the report on a fit of the model `name` to the recording `target`.
pub fn report(fit: &Fit, name: &str, target: &str) -> Report {
    let mut report = Report::new(&format!("{name}, fitted"), &format!("to `{target}`, with {} renders", fit.renders));
    report.notes.extend(fit.warnings().into_iter().map(|what| (Weight::Note, what)));
    let numbers = fit.fitted.iter().map(|f| {
        let v = &f.varied;
        vec![v.name.clone(), v.shown(v.start), v.shown(f.value), f.uncertainty()]
    });
    let numbers = Table::new(&["number", "before", "after", "two standard deviations"], numbers.collect());
    let mut distances = vec![row("before", &fit.before), row("after", &fit.after)];
    let mut blocks = vec![Block::Table(numbers)];
    if let Some(b) = &fit.beyond {
        distances.push(row(&format!("after, over the {:.2} s that were not fitted", b.seconds), &b.model));
        distances.push(row(&format!("over the same time, {} with as many free numbers", b.named()), &b.sinusoids));
    }
    blocks.push(Block::Table(Table::new(&["distance", "levels", "residual of the samples"], distances)));
    let how = match fit.stage {
        Stage::Samples => format!("Fitted by samples, over {:.3} s", fit.phase),
        Stage::Levels => "Fitted by levels, because phases do not agree".into(),
    };
    let ms = Plain(six(1e3 * fit.delay));
    blocks.push(Block::Text(format!("{how}. Gain {}, delay {ms} ms.", Plain(six(fit.gain)))));
    report.sections.push(Section::new("Result", blocks));

    let shown = &fit.shown;
    let one = |s: &target::Samples| target::mixed(s).into_iter().next().unwrap_or_default();
    let [recording, before, after] = [&shown.target, &shown.before, &shown.after].map(one);
    let names = ["recording", "before", "after"].map(String::from);
    let mut sound = Sound::new(shown.rate, &names);
    // audible, and equally loud
    let loudest = recording.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE);
    let by = 0.5 / loudest;
    for ((r, b), a) in recording.iter().zip(&before).zip(&after) {
        sound.push(&[by * r, by * b, by * a]);
    }
    let spectrum = Spectrum::of(&sound).and_then(|s| s.plot(&names, Vec::new()));
    let mut blocks: Vec<Block> = spectrum.into_iter().map(Block::Plot).collect();
    for (name, samples) in names.iter().zip([&recording, &before, &after]) {
        let mut one = Sound::new(shown.rate, std::slice::from_ref(name));
        for x in samples {
            one.push(&[by * x]);
        }
        if let Some(plot) = spectrogram(&one) {
            blocks.push(Block::Plot(Plot { title: format!("{}: {name}", plot.title), ..plot }));
        }
    }
    blocks.insert(0, Block::Sound(sound));
    report.sections.push(Section::new("Before and after", blocks));

    let size = ((BLOCK * shown.rate) as usize).max(1);
    let level = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let n = recording.len() / size;
        let power = |k: usize| (k * size..(k + 1) * size).map(|i| of(i) * of(i)).sum::<f64>() / size as f64;
        (0..n).map(|k| 10.0 * libm::log10((by * by * power(k)).max(1e-15))).collect()
    };
    let curves = vec![
        Curve::line("recording", level(&|i| recording[i])),
        Curve::line("residual before", level(&|i| recording[i] - before[i])),
        Curve::line("residual after", level(&|i| recording[i] - after[i])),
    ];
    let n = recording.len() / size;
    let step = size as f64 / shown.rate;
    let grid = Grid::Even { start: 0.5 * step, step, n };
    let plot = Plot::over_time("Residual over time", Axis::linear("level", "dB"), grid, curves);
    let until = shown.fitted as f64 / shown.rate;
    let text = format!("The sound was fitted up to {until:.3} s, and predicted after that.");
    report.sections.push(Section::new("Residual", vec![Block::Plot(plot), Block::Text(text)]));
    report
}
