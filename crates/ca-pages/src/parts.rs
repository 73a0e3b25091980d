//! Sections that pages of models and of takes share.
//!
//! The spectrum marks only modes that reach an output, at the frequencies that are heard. A mark without a peak would
//! mislead. The table lists all modes.

use ca_compile::Compiled;
use ca_compile::Options;
use ca_compile::analysis::{Mode, Modes, Network, modes};
use ca_core::{Level, Scene};
use ca_lab::catalog;
use ca_lab::facts::certificate::{contacting, deepening, opened, rippling, stability as verdict};
use ca_lab::facts::level::{decibel, fitting, level, tenths, too_loud};
use ca_lab::facts::{border, codes};
use ca_lab::load::ticked;
use ca_model::Model;
use ca_model::diag::Severity;
use ca_model::quantity::{Plain, short};
use ca_report::{Axis, Block, LOWEST, Mark, Plot, Point, Section, Sound, Spectrum, Table, Weight, spectrogram};

/// Limit on the moving places of a network whose modes are shown; larger networks take longer than playing the model.
const PLACES: usize = 1000;
/// Limit on the modes in the table and the marks in the spectrum.
const MODES: usize = 40;
/// Level below the strongest mode at which a mode counts as silent at an output \[dB\].
const SILENT: f64 = -60.0;

/// Names the program and version for the subtitle.
pub(crate) fn finished() -> String {
    format!("by ca {}", env!("CARGO_PKG_VERSION"))
}

/// Lists problems of a sound.
pub(crate) fn notes(sound: &Sound, diverged: bool) -> Vec<(Weight, String)> {
    let peak = sound.peak().iter().copied().fold(0.0, f64::max);
    let mut list = Vec::new();
    if sound.names().is_empty() {
        list.push((Weight::Note, "the model is silent, because it lacks an output; add one with `[SOX]`".into()));
    } else if peak == 0.0 {
        list.push((Weight::Note, "all outputs are silent".into()));
    }
    if sound.broken() > 0 && !diverged {
        list.push((
            Weight::Warning,
            format!("{} samples were not finite and were replaced by silence", sound.broken()),
        ));
    }
    if sound.clipped() > 0 {
        let help = if diverged { String::new() } else { fitting(peak) };
        list.push((Weight::Warning, format!("{}{help}", too_loud(sound.clipped()))));
    }
    list
}

/// Summary table at the head of the page.
#[derive(Default)]
pub(crate) struct Facts(Vec<(&'static str, String)>);

impl Facts {
    /// Collects modules, rates, stability and latency of a scene.
    pub fn of(scene: &Scene) -> Facts {
        let by_code: Vec<String> = codes(scene).iter().map(|(c, n)| format!("{n} {c}")).collect();
        let mut facts = vec![
            ("modules", format!("{} MAT, {} LIA: {}", scene.mats(), scene.lias(), by_code.join(", "))),
            ("rates", border::rates(scene)),
            ("stability", verdict(&scene.certificate)),
        ];
        facts.extend(border::latency(scene).map(|l| ("latency", l)));
        Facts(facts)
    }

    /// Adds a row.
    pub fn add(&mut self, name: &'static str, value: String) {
        self.0.push((name, value));
    }

    pub fn section(self) -> Section {
        Section::new("Summary", vec![Block::Table(Table::pairs(self.0))])
    }
}

/// Builds the section with player, waveform, spectrogram and spectrum. Returns `None` without channels.
pub(crate) fn sound(sound: Sound, marks: Vec<Mark>, diverged: bool) -> Option<Section> {
    if sound.names().is_empty() {
        return None;
    }
    let peaks: Vec<String> =
        sound.names().iter().zip(sound.peak()).map(|(n, p)| format!("{n} {}", level(*p, diverged))).collect();
    let mut blocks = vec![Block::Text(format!("Peak: {}.", peaks.join(", "))), Block::Plot(sound.waveform())];
    blocks.extend(spectrogram(&sound).map(Block::Plot));
    if let Some(plot) = Spectrum::of(&sound).and_then(|s| s.plot(sound.names(), marks)) {
        let marked = if plot.marks.is_empty() { "" } else { " The numbers refer to the modes below." };
        blocks.push(Block::Plot(plot));
        blocks.push(Block::Text(format!("A sine at full scale reads 0 dBFS; Hann window.{marked}")));
    }
    blocks.insert(1, Block::Sound(sound));
    Some(Section::new("Sound", blocks))
}

/// Modes of the linear part, or the reason why there are none.
pub(crate) struct ModesPart(Result<(Network, Modes), String>);

pub(crate) fn modes(model: &Model, options: &Options) -> ModesPart {
    let Ok(network) = ca_compile::linear(model, &catalog(), options) else {
        return ModesPart(Err("The modes of the linear part cannot be computed.".into()));
    };
    let n = network.linear.dofs.len();
    ModesPart(match n {
        0 => Err("The linear part has no moving masses, so it has no modes.".into()),
        _ if n > PLACES => Err(format!(
            "The linear part has {n} degrees of freedom, too many for this page; `ca modes` takes up to {}.",
            modes::LARGEST
        )),
        _ => modes::modes(&network)
            .map(|m| (network, m))
            .ok_or_else(|| "The modes cannot be computed: values are out of range.".into()),
    })
}

impl ModesPart {
    /// Returns the oscillating modes from the lowest, each with its number and its level at the output where it is
    /// loudest \[dB\].
    fn swinging(&self) -> Vec<(usize, &Mode, f64)> {
        let Ok((network, found)) = &self.0 else { return Vec::new() };
        let ears: Vec<_> = network.ports.iter().filter(|p| p.role == "hears").collect();
        let top = |at: &[(u32, f64)]| found.list.iter().map(|m| m.at(at).abs()).fold(f64::MIN_POSITIVE, f64::max);
        let tops: Vec<f64> = ears.iter().map(|p| top(&p.at)).collect();
        let level = |m: &Mode| {
            let shares = ears.iter().zip(&tops).map(|(p, top)| m.at(&p.at).abs() / top);
            decibel(shares.fold(0.0, f64::max))
        };
        let swings = found.list.iter().enumerate().filter(|(_, m)| m.heard > 0.0);
        swings.map(|(i, m)| (i + 1, m, level(m))).collect()
    }

    /// Names outputs of forces, whose level the modes do not give.
    fn by_force(&self) -> &[String] {
        self.0.as_ref().map_or(&[], |(network, _)| &network.force_outputs)
    }

    /// Returns marks at the frequencies of audible modes, or of all modes if an output measures forces.
    pub fn marks(&self) -> Vec<Mark> {
        let any = !self.by_force().is_empty();
        let heard = self.swinging().into_iter().filter(|(_, m, level)| (any || *level > SILENT) && m.heard >= LOWEST);
        heard.take(MODES).map(|(i, m, _)| Mark { x: m.heard, y: None, text: i.to_string() }).collect()
    }

    /// Builds the section with the table and a plot of decay times.
    pub fn section(&self) -> Section {
        let (network, found) = match &self.0 {
            Ok(both) => both,
            Err(why) => return Section::new("Modes", vec![Block::Text(why.clone())]),
        };
        let swinging = self.swinging();
        let mut blocks = Vec::new();
        if !network.left_out.is_empty() {
            let names: Vec<String> = network.left_out.iter().map(|(n, code)| format!("`{n}` ({code})")).collect();
            let more = names.len().saturating_sub(12);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            let names = names[..names.len().min(12)].join(", ");
            blocks.push(Block::Text(format!(
                "Modes of the linear part, at load. Left out because they are not linear: {names}{more}."
            )));
        }
        if found.list.iter().any(|m| m.grows) {
            blocks.push(Block::Text("A mode grows: the model is unstable at this sound rate.".into()));
        }
        if found.approximate {
            blocks.push(Block::Text("Damping couples the modes; T60 is given for each mode alone.".into()));
        }
        let forces = self.by_force();
        let places = network.ports.iter().any(|p| p.role == "hears");
        if !forces.is_empty() {
            let names = ticked(forces.iter().map(String::as_str));
            let rest = if places { "; levels are given for the other outputs" } else { "" };
            let note =
                format!("These outputs do not measure displacement, so they may contain any mode: {names}{rest}.");
            blocks.push(Block::Text(note));
        }
        // the level of a mode at a force output is unknown, which is not the same as silent
        let (rest, silent, outputs) = match (forces.is_empty(), places) {
            (true, _) => ("not audible", "silent", "at the outputs [dB]"),
            (false, true) => ("audible only as a force, if at all", "-", "at the displacement outputs [dB]"),
            (false, false) => ("modes", "-", ""),
        };
        let points = swinging.iter().filter(|(_, m, _)| m.t60.is_finite() && m.t60 > 0.0).map(|(i, m, level)| Point {
            name: if *i <= MODES { i.to_string() } else { String::new() },
            x: m.heard,
            y: m.t60,
            front: *level > SILENT,
        });
        let points: Vec<Point> = points.collect();
        if points.len() > 1 {
            let (x, y) = (Axis::log("frequency", "Hz"), Axis::log("T60", "s"));
            let mut plot = Plot::scatter("Decay time of each mode", x, y, "audible", rest, &points);
            plot.curves.retain(|c| c.y.iter().any(|v| v.is_finite()));
            blocks.push(Block::Plot(plot));
        }
        let head = ["mode", "free [Hz]", "heard [Hz]", "cents", "T60 [s]", outputs];
        let head: Vec<&str> = head.into_iter().filter(|h| !h.is_empty()).collect();
        let columns = head.len();
        let rows = swinging.iter().take(MODES).map(|(i, m, level)| {
            let t60 = match m.t60 {
                _ if m.grows => "grows".into(),
                t if t.is_finite() => format!("{:.4}", Plain(t)),
                _ => "∞".into(),
            };
            let level = if *level > SILENT { tenths(*level) } else { silent.into() };
            let mut row = vec![
                i.to_string(),
                format!("{:.3}", m.f),
                format!("{:.3}", m.heard),
                format!("{:+.3}", m.cents()),
                t60,
                level,
            ];
            row.truncate(columns);
            row
        });
        let rows: Vec<Vec<String>> = rows.collect();
        if rows.is_empty() {
            blocks.push(Block::Text("None of the modes oscillates.".into()));
        } else {
            blocks.push(Block::Table(Table::new(&head, rows)));
        }
        if swinging.len() > MODES {
            blocks.push(Block::Text(format!("{} more modes; `ca modes` lists all of them.", swinging.len() - MODES)));
        }
        Section::new("Modes", blocks)
    }
}

/// Builds the section with the certificate, the margin, the demands at keys, and the findings.
pub(crate) fn stability(scene: &Compiled) -> Section {
    let c = &scene.certificate;
    let means = match c.level {
        Level::Proven => "every link is linear and the bound is below the limit, at every setting",
        Level::Linearised => "proven for small motions about the pose at load",
        Level::RuleOfThumb => "the linear links are proven; rules of thumb judge contacts and non-linear links",
        Level::NotProven if scene.rates.slow.as_ref().is_some_and(|g| g.compensated) => {
            "a compensated border may add energy; the energy ledger shows how much"
        }
        Level::NotProven => "the bounds do not decide it",
        Level::Unstable => "above the limit",
    };
    let mut rows = vec![
        ("verdict", format!("{}: {means}", c.level)),
        ("bound", format!("{} of the largest eigenvalue; the limit is 4", short(c.bound))),
        (
            "margin",
            match c.margin() {
                m if m.is_finite() => format!("{}: factor by which everything could be stiffer", short(m)),
                _ => "no part of the model has a limit".into(),
            },
        ),
    ];
    if !c.not_judged.is_empty() {
        let names = ticked(c.not_judged.iter().map(String::as_str));
        rows.push(("not judged", format!("{names}: no output depends on it, so it is left out")));
    }
    if c.exact {
        rows.push(("decided by", "a sparse factorisation".into()));
    }
    if let Some(ripple) = c.ripple {
        rows.push(("energy", rippling(ripple)));
    }
    if !c.worst.is_empty() {
        rows.push(("nearest to the limit", format!("`{}`", c.worst)));
    }
    if !c.rules.decides.is_empty() {
        rows.push(("deciding link", format!("`{}`", c.rules.decides)));
    }
    rows.extend(contacting(c).map(|contact| ("stiffest contact", contact)));
    rows.extend(opened(c).map(|open| ("not judged", open)));
    rows.extend(c.rules.depth.as_ref().map(|depth| ("steepest contact", deepening(depth))));
    let mut blocks = vec![Block::Table(Table::pairs(rows))];
    let keys = border::key_demands(scene).into_iter().map(|(name, k, b)| vec![name.into(), short(k), short(b)]);
    let keys: Vec<Vec<String>> = keys.collect();
    if !keys.is_empty() {
        blocks
            .push(Block::Text("Friction that a device needs at each key to stay passive against the springs:".into()));
        blocks.push(Block::Table(Table::new(&["key", "stiffness [N/m]", "friction needed [N s/m]"], keys)));
    }
    let findings = scene.findings.list.iter().map(|d| {
        let what = if d.severity == Severity::Warning { "warning" } else { "note" };
        vec![d.code.to_owned(), what.to_owned(), d.title.clone(), d.help.clone().unwrap_or_default()]
    });
    let findings: Vec<Vec<String>> = findings.collect();
    if !findings.is_empty() {
        blocks.push(Block::Table(Table::new(&["code", "", "finding", "help"], findings)));
    }
    Section::new("Stability", blocks)
}
