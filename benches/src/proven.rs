//! Page of the verdict and the run time of each bundled model, by its explicit links and by energy-consistent ones.

use crate::machine;
use crate::table::{head, line};
use ca_compile::{Options, compile};
use ca_core::{Level, Scene};
use ca_io::perform::Performance;
use ca_model::Model;
use std::fmt::Write as _;
use std::time::Instant;

/// Times of a model; the fastest counts.
const ROUNDS: usize = 2;

/// A model by one choice of methods.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Its verdict.
    pub level: Level,
    /// Run time of a second of sound under its own gesture \[s\].
    pub share: f64,
}

/// A bundled model.
#[derive(Clone, Debug)]
pub struct Proven {
    /// Name.
    pub name: String,
    /// With `method = "ca"` of the model, as it is, and with `method = "auto"`.
    pub ways: [Way; 3],
}

/// Choices of a model, in the order of [`Proven::ways`].
const METHODS: [Option<&str>; 3] = [Some("ca"), None, Some("auto")];

/// Measures a model for at most `seconds` of sound.
///
/// # Panics
/// If the model does not compile.
pub fn measure(name: &str, model: &Model, seconds: f64) -> Proven {
    let kinds = crate::catalog();
    let scenes = METHODS.map(|method| {
        let mut model = model.clone();
        if let Some(method) = method {
            model.set("model.method", method);
        }
        compile(&model, &kinds, &Options::default()).unwrap_or_else(|found| panic!("{name}: {found:?}"))
    });
    let seconds = scenes[0].scene.about.seconds.unwrap_or(seconds).min(seconds);
    let mut shares = [f64::INFINITY; 3];
    for _ in 0..ROUNDS {
        for (share, compiled) in shares.iter_mut().zip(&scenes) {
            *share = share.min(run_time(&compiled.scene, seconds) / seconds);
        }
    }
    let way = |k: usize| Way { level: scenes[k].certificate.level, share: shares[k] };
    Proven { name: name.into(), ways: [0, 1, 2].map(way) }
}

fn run_time(scene: &Scene, seconds: f64) -> f64 {
    let Ok(mut p) = Performance::new(scene, None) else { return f64::NAN };
    let begin = Instant::now();
    p.until((seconds * scene.rate) as u64 * u64::from(scene.oversample()), 1);
    begin.elapsed().as_secs_f64()
}

/// Head of the page.
pub const HEAD: &str = "# What is proven, and what it costs\n\nMade by `UPDATE=1 cargo bench -p ca-benches --bench proven`: do not edit.\n\n\
    Verdict and run time of each bundled model under its own gesture, for one second: with explicit links \
    (`method = \"ca\"`), as it is, and with the methods that `method = \"auto\"` chooses. **%** is the \
    run time in percent of real time on one core. **×** is the run time with `auto`, divided by the run time with explicit links.\n\n";

/// Returns the page.
pub fn page(rows: &[Proven]) -> String {
    let mut text = format!("{HEAD}The machine: {}.\n\n", machine());
    let proven = |k: usize| rows.iter().filter(|r| r.ways[k].level == Level::Proven).count();
    let mut ratios: Vec<(f64, &str)> = rows.iter().map(|r| (r.ways[1].share / r.ways[0].share, &*r.name)).collect();
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (most, worst) = ratios.last().copied().unwrap_or((f64::NAN, ""));
    let _ = write!(
        text,
        "Of {} models, {} are proven with explicit links, {} as they are, and {} by `auto`. As they are, they take {:.2} × the time \
         of the explicit links (median), and at most {:.1} × ({}).\n\n",
        rows.len(),
        proven(0),
        proven(1),
        proven(2),
        ratios[ratios.len() / 2].0,
        most,
        worst,
    );
    text += &head(&["model", "explicit", "%", "as it is", "%", "`auto`", "%", "×"]);
    for Proven { name, ways } in rows {
        let mut cells = vec![name.clone()];
        cells.extend(ways.iter().flat_map(|w| [w.level.to_string(), format!("{:.2}", 100.0 * w.share)]));
        cells.push(format!("{:.1}", ways[2].share / ways[0].share));
        text += &line(&cells);
    }
    text
}
