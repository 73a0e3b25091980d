//! Builds the page of a model by playing it.

use crate::energy::EnergyOverTime;
use crate::parts::{self, Facts, finished};
use ca_accuracy::AccuracyOptions;
use ca_accuracy::timing::Clock;
use ca_compile::{Compiled, Options};
use ca_core::Scene;
use ca_io::gesture::Gesture;
use ca_io::perform::Performance;
use ca_lab::play::{self, Divergence, Length, lasted};
use ca_lab::{Failure, Loaded};
use ca_model::quantity::short;
use ca_model::{Item, Value};
use ca_report::{Axis, Block, Curve, Envelope, Plot, Report, Section, Sound, Weight};
use ca_view::Film;
use std::path::Path;

/// Limit on the curves of one plot.
const CURVES: usize = 8;
/// Samples of the energy ledger over the performance.
const LOOKS: u64 = 1000;
/// Lower limit of the rate at which the picture is sampled \[Hz\].
const PICTURE: f64 = 240.0;
/// Default length of sound for the comparison of methods \[s\].
pub const TRIED: f64 = 0.2;
/// Multiples of the sound rate for the comparison of methods, and the multiple of the reference.
const TIMES: [u32; 3] = [1, 2, 4];
const REFERENCE: u32 = 32;

/// Options of the page of a model.
#[derive(Clone, Debug)]
pub struct PageOptions {
    /// Length to play \[s\]; if `None`, until the gesture and the model end.
    pub seconds: Option<f64>,
    /// Length of sound for the comparison of methods and rates \[s\]; 0 omits the comparison.
    pub accuracy: f64,
    /// Changed values of the model, by name, to be listed on the page.
    pub changes: Vec<(String, String)>,
    /// Advice if nothing moves within the compared time.
    pub remedy: &'static str,
}

impl Default for PageOptions {
    fn default() -> PageOptions {
        PageOptions { seconds: None, accuracy: TRIED, changes: Vec::new(), remedy: "compare a longer time" }
    }
}

/// Progress of a page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Work<'a> {
    /// Samples played, and the total.
    Played(u64, u64),
    /// Steps of the comparison of methods done, and the total.
    Compared(u64, u64),
    /// Warning that something was not played as requested.
    Warning(&'a str),
}

/// A model compiled for its page.
pub struct ModelPage<'a> {
    loaded: &'a Loaded,
    scene: Compiled,
    options: Options,
    probes: Vec<String>,
    /// True if the scheme is composed of other schemes.
    composed: bool,
}

impl<'a> ModelPage<'a> {
    /// Compiles a model at `rate`, or at its own rate, with the energy ledger if the scheme supports one.
    ///
    /// The page plots `probes` over time. If `probes` is empty, it plots the modules measured by outputs and the keys
    /// of devices.
    ///
    /// # Errors
    /// Returns [`Failure::Found`] if the model has errors.
    pub fn new(loaded: &'a Loaded, rate: Option<f64>, probes: &[String]) -> Result<ModelPage<'a>, Failure> {
        // only the explicit scheme has a ledger
        let composed = matches!(loaded.model.meta("method").map(|e| &e.value), Some(Value::Text(t)) if t == "pefrl");
        let with = |probes: Vec<String>| Options {
            rate,
            energy: !composed,
            probes,
            clouds: loaded.clouds.clone(),
            ..Options::default()
        };
        // default probes that cannot be compiled are omitted
        let own = (probes.is_empty()).then(|| loaded.compile(&with(output_probes(&loaded.model.items))).ok()).flatten();
        let (scene, probes) = match own {
            Some(scene) => (scene, output_probes(&loaded.model.items)),
            None => (loaded.compile(&with(probes.to_vec()))?, probes.to_vec()),
        };
        Ok(ModelPage { loaded, scene, options: with(Vec::new()), probes, composed })
    }

    /// Returns the scene to play, with the findings of the compiler.
    pub fn scene(&self) -> &Compiled {
        &self.scene
    }

    /// Plays the scene with a performance of `gesture` and builds the page. `goes_on` receives the progress and stops
    /// the work by returning false.
    ///
    /// # Errors
    /// Returns [`Failure::Stopped`], [`Failure::Found`] if the comparison of methods finds errors, and
    /// [`Failure::Failed`] if there is not enough memory for the picture.
    pub fn report(
        &self,
        performance: Performance,
        gesture: Option<&Gesture>,
        options: &PageOptions,
        goes_on: &mut dyn FnMut(Work) -> bool,
    ) -> Result<Report, Failure> {
        let (loaded, scene) = (self.loaded, &self.scene);
        let (seconds, length) =
            (play::seconds(&performance, options.seconds), Length::of(&performance, options.seconds));
        let frames = length.frames;

        let mut sound = Sound::new(scene.rate, &scene.names.channel_names);
        let mut motion = Envelope::new(scene.rate, scene.counts.n_out - scene.counts.channels);
        let mut ledger = EnergyOverTime::default();
        let mut film = Film::new(scene, seconds);
        // often enough for a smooth picture
        let block = (frames / LOOKS).clamp(1, (scene.rate / PICTURE).max(1.0) as u64).min(1024);
        let played = play::play(performance, length, block, &mut |p, rows, done| {
            for row in rows.chunks_exact(scene.counts.n_out.max(1)) {
                sound.push(&row[..scene.counts.channels]);
                motion.push(&row[scene.counts.channels..]);
            }
            film.look(p.state.tick as f64 * scene.rates.sample_dt, &p.state.x);
            if !p.diverged && p.state.is_bounded(ca_io::perform::DIVERGED) {
                ledger.look(p.state.tick as f64 * scene.rates.sample_dt, p.state.ledger.as_deref());
            }
            if goes_on(Work::Played(done, frames)) { Ok(()) } else { Err(Failure::Stopped) }
        })?;
        ledger.end = played.energy.clone();

        let divergence = Divergence::of(&played, scene, &scene.findings, gesture);
        ledger.diverged_at = divergence.as_ref().map(|b| b.time);
        let title = if scene.about.title.is_empty() { &loaded.name } else { &scene.about.title };
        let mut report = Report::new(title, &format!("`{}`, {}", source_name(loaded), finished()));
        report.picture = ca_film::picture(&film)?;
        report.notes = parts::notes(&sound, divergence.is_some());
        if let Some(divergence) = &divergence {
            report.notes.insert(0, (Weight::Warning, divergence.to_string()));
        }
        let refused = played.performance.state.ports.refused;
        if refused > 0 {
            let what = format!("{refused} input values were not finite; the last valid value was used instead");
            report.notes.push((Weight::Warning, what));
        }
        for what in play::clamped(&played.performance) {
            goes_on(Work::Warning(&what));
        }
        let mut facts = Facts::of(scene);
        facts.add("length", format!("{} s", lasted(scene, &played, frames, seconds)));
        let factor = played.wall.as_secs_f64() / (played.frames as f64 * scene.rates.sample_dt);
        let ledger_kept = if self.composed { "" } else { " with the energy ledger" };
        facts.add("real-time factor", format!("{}{ledger_kept}, on this machine", short(factor)));
        for (name, value) in &options.changes {
            facts.add("changed", format!("{name} = {value}"));
        }
        report.sections.push(facts.section());
        let modes = parts::modes(&loaded.model, &self.options);
        report.sections.extend(parts::sound(sound, modes.marks(), divergence.is_some()));
        report.sections.extend(moved(loaded, scene, &motion, &self.probes));
        report.sections.extend(ledger.section(scene, 1.0));
        report.sections.push(modes.section());
        report.sections.extend(self.accuracy(options, goes_on)?);
        report.sections.push(parts::stability(scene));
        let text = vec![Block::Source(loaded.model.file.clone(), loaded.model.text.clone())];
        report.sections.push(Section::new("Model", text));
        Ok(report)
    }

    /// Builds the section with error against run time for the first seconds of the model with its own gestures. If
    /// nothing can be measured, the section gives the reason.
    fn accuracy(
        &self,
        options: &PageOptions,
        goes_on: &mut dyn FnMut(Work) -> bool,
    ) -> Result<Option<Section>, Failure> {
        let probes = ca_accuracy::heard(&self.loaded.model);
        if options.accuracy == 0.0 || probes.is_empty() {
            return Ok(None);
        }
        let mut ask = AccuracyOptions {
            rate: self.options.rate,
            probes: &probes,
            seconds: Some(options.accuracy),
            times: Some(&TIMES),
            reference: Some(REFERENCE),
            remedy: options.remedy,
            clock: Clock::WALL,
            progress: &mut |done, of| goes_on(Work::Compared(done, of)),
        };
        match ca_accuracy::measured(self.loaded, &mut ask) {
            Ok(found) => Ok(Some(found.section(found.as_written().map(|r| (r, "this model"))))),
            Err(Failure::Failed(why) | Failure::Usage(why)) => {
                Ok(Some(Section::new(ca_accuracy::TITLE, vec![Block::Text(why)])))
            }
            Err(other) => Err(other),
        }
    }
}

fn source_name(loaded: &Loaded) -> String {
    Path::new(&loaded.model.file).file_name().map_or_else(|| loaded.name.clone(), |n| n.to_string_lossy().into_owned())
}

/// Returns the names of outputs and of device keys.
fn output_probes(items: &[Item]) -> Vec<String> {
    let shown = items.iter().filter(|i| matches!(i.kind.as_str(), "SOX" | "SOF" | "TGR"));
    shown.map(|i| i.name.clone()).take(CURVES).collect()
}

/// Returns the module that an output measures, as written in the model.
fn of_output<'a>(items: &'a [Item], probe: &str) -> Option<&'a str> {
    let from = items.iter().find(|i| i.name == probe)?.args.iter().find(|e| e.key == "from")?;
    if let Value::Text(text) = &from.value { Some(text) } else { None }
}

/// Plots of the motion, one per quantity: title, quantity and unit.
const DRAWN: [(&str, &str, &str); 4] = [
    ("Displacement", "displacement", "m"),
    ("Speed", "speed", "m/s"),
    ("Acceleration", "acceleration", "m/s²"),
    ("Force", "force", "N"),
];

/// Returns the index in `DRAWN` for a probe. For an output, that is the quantity it measures.
fn drawn(items: &[Item], scene: &Scene, name: &str) -> usize {
    let is_link = |s: &ca_core::Symbol| s.name == name && matches!(s.location, ca_core::Location::Lia(..));
    let item = items.iter().find(|i| i.name == name);
    let hears = item.and_then(|i| i.args.iter().find(|e| e.key == "hear")).map(|e| &e.value);
    match hears {
        Some(Value::Text(text)) if text == "speed" => 1,
        Some(Value::Text(text)) if text == "acceleration" => 2,
        Some(Value::Text(text)) if text == "force" => 3,
        _ if item.is_some_and(|i| i.kind == "SOF") || scene.symbols.iter().any(|s| is_link(&s)) => 3,
        _ => 0,
    }
}

/// Builds the section with motions and forces over time.
fn moved(loaded: &Loaded, scene: &Scene, motion: &Envelope, probes: &[String]) -> Option<Section> {
    let items = &loaded.model.items;
    let mut all: [Vec<Curve>; DRAWN.len()] = Default::default();
    for (k, (name, of)) in scene.names.probe_names.iter().zip(&scene.names.probe_of).enumerate() {
        let asked = probes.get(*of as usize).map_or("", String::as_str);
        // an output of several modules keeps the name of each
        let shown = of_output(items, asked).filter(|_| name == asked).unwrap_or(name);
        let list = &mut all[drawn(items, scene, name).max(drawn(items, scene, asked))];
        if list.iter().all(|c| c.name != shown) {
            list.push(Curve::line(shown, motion.curve(k)));
        }
    }
    let mut blocks = Vec::new();
    for ((title, quantity, unit), curves) in DRAWN.into_iter().zip(all) {
        let more = curves.len().saturating_sub(CURVES);
        let curves: Vec<Curve> = curves.into_iter().take(CURVES).collect();
        if !curves.is_empty() {
            blocks.push(Block::Plot(Plot::over_time(title, Axis::linear(quantity, unit), motion.grid(), curves)));
        }
        if more > 0 {
            blocks.push(Block::Text(format!(
                "{more} more curves are not drawn; `ca render --probe` writes all of them."
            )));
        }
    }
    (!blocks.is_empty()).then(|| Section::new("Motion", blocks))
}
