//! Builds the page of a take: the recorded data, and the energy ledger of a replay.
//!
//! Sound, positions and forces are shown as recorded, including gaps. For a take without sound, such as one saved from
//! the page of `ca play`, the sound comes from the replay. The energy ledger and the verdict also come from the replay.
//! If this build cannot replay the take, the page says so and omits them. If the model changes during the take, the
//! picture shows the masses of the first version, and the ledger is omitted because a ledger belongs to one scene.

use crate::energy::EnergyOverTime;
use crate::loops::{Clock, Loops, Stamp};
use crate::parts::{self, Facts, finished};
use ca_core::Scene;
use ca_film::{TakeFilm, judged, picture};
use ca_haptic::frame::{DeviceFrame, ForceFrame, Mode};
use ca_haptic::guard::Order;
use ca_haptic::take::{End, Event, Replay, Take};
use ca_lab::{Failure, catalog};
use ca_model::quantity::short;
use ca_report::{Axis, Block, Curve, Envelope, Mark, Plot, Report, Section, Sound, Table, Weight};
use ca_view::Film;
use std::path::Path;

/// Limit on the curves per device.
const CURVES: usize = 8;
/// Limit on the rows of events.
const EVENTS: usize = 100;
/// Limit on the remembered frames per device.
const RECENT: usize = 256;

/// Builds the page of a take. Also returns the name of its file without folder and extension.
///
/// # Errors
/// Fails if the file cannot be read or there is not enough memory for the picture.
pub fn take(file: &Path) -> Result<(String, Report), Failure> {
    let mut take = Take::open(file)?;
    let summary = take.summary()?;
    let scene = take.header.scene(&catalog());
    let mut recorded = Recorded::of(&take, scene.as_deref().ok())?;
    take.header.options.energy = true;
    let h = &take.header;
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let title = if h.title.is_empty() { &name } else { &h.title };
    let mut report = Report::new(title, &format!("a take, {:.3} s, `{name}.mcap`, {}", summary.seconds, finished()));
    let silent = recorded.sound.seconds() == 0.0;
    let again = again(&take, summary.seconds, silent.then_some(&mut recorded.sound));
    report.notes = parts::notes(&recorded.sound, false);
    let mut note = |text: String| report.notes.push((Weight::Warning, text));
    if summary.end != End::Whole {
        note(summary.end.to_string());
    }
    let [records, samples, views] = summary.lost;
    if records + samples + views > 0 {
        note(format!("lost while recording: {records} records, {samples} sound samples, {views} views"));
    }
    if let Err(why) = &again {
        note(why.clone());
    }
    // a fault is a note, because the guard worked as intended
    let faults = summary.faults.iter();
    let faults = faults.map(|f| format!("`{}`: forces turned off at {:.3} s: {}", f.device, f.time, f.cause.name()));
    report.notes.extend(faults.map(|text| (Weight::Note, text)));

    let mut facts = scene.as_ref().map_or_else(|_| Facts::default(), |scene| Facts::of(scene));
    facts.add("length", format!("{:.3} s", summary.seconds));
    let get = |key: &str| h.host.get(key).map_or("?", String::as_str);
    facts.add("written by", format!("ca {} on {} {}", get("ca"), get("os"), get("arch")));
    for d in &h.setups {
        facts.add("device", format!("{}, {} DOF, {}", d.device, d.profile.dof, d.profile.title));
    }
    for (name, value) in &h.changes {
        facts.add("changed", format!("{name} = {value}"));
    }
    if let Ok((verdict, ..)) = &again {
        facts.add("replay", verdict.clone());
    }
    report.sections.push(facts.section());
    let modes = h.model(&catalog()).ok().map(|(model, _)| parts::modes(&model, &h.options));
    let marks = modes.as_ref().map(parts::ModesPart::marks).unwrap_or_default();
    let Recorded { sound, hands, events, loops, .. } = recorded;
    report.sections.extend(parts::sound(sound, marks, false));
    let faults = |device: &str| {
        let of = summary.faults.iter().filter(|f| f.device == device);
        of.map(|f| Mark { x: f.time, y: None, text: f.cause.name().into() }).collect::<Vec<_>>()
    };
    report.sections.extend(hands.iter().map(|hand| hand.section(&faults(&hand.device))));
    let events = shortened(events);
    if !events.is_empty() {
        let more = events.len().saturating_sub(EVENTS);
        let mut blocks = vec![Block::Table(Table::new(&["time [s]", "source", "event"], events))];
        if let (Block::Table(t), true) = (&mut blocks[0], more > 0) {
            t.rows.truncate(EVENTS);
            blocks.push(Block::Text(format!("{more} more events; `ca log export` writes all of them.")));
        }
        report.sections.push(Section::new("Events", blocks));
    }
    report.sections.extend(loops.section(h.rate, h.rate / f64::from(h.ratio)));
    if let Ok((.., film, _)) = &again {
        report.picture = picture(film)?;
    }
    if let (Ok((_, ledger, ..)), Ok(scene)) = (&again, &scene) {
        report.sections.extend(ledger.section(scene, scene.hand.equivalence.of("").energy()));
    }
    if matches!(&again, Ok((.., versions)) if *versions > 1) {
        let text = "The model was changed while it played. An energy ledger covers one version only, so it is left out. \
                    The picture shows only the masses of the first version.";
        report.notes.push((Weight::Note, text.into()));
    }
    report.sections.extend(modes.map(|m| m.section()));
    report.sections.extend(scene.as_ref().ok().map(parts::stability));
    let text = vec![Block::Source(h.file.clone(), h.text.clone())];
    report.sections.push(Section::new("Model", text));
    Ok((name, report))
}

/// Keeps only the first and last of consecutive events that change the same parameters.
fn shortened(events: Vec<Vec<String>>) -> Vec<Vec<String>> {
    fn names(row: &[String]) -> Option<Vec<&str>> {
        (row[1] == "parameters").then(|| row[2].split(", ").filter_map(|set| set.split(" = ").next()).collect())
    }
    let mut kept: Vec<Vec<String>> = Vec::new();
    let mut steps = 0;
    for row in events {
        let turned =
            |n: usize| names(&row).is_some_and(|now| kept.len() >= n && names(&kept[kept.len() - n]) == Some(now));
        steps = if turned(1) { steps + 1 } else { 0 };
        // the previous event is neither the first nor the last
        if steps > 1 && turned(2) {
            kept.pop();
        }
        kept.push(row);
    }
    kept
}

/// Replays a take for `seconds`.
///
/// Returns the verdict in words, the energy ledger, the film, and the number of versions of the model. Returns the
/// reason if the replay fails.
fn again(
    take: &Take,
    seconds: f64,
    mut sound: Option<&mut Sound>,
) -> Result<(String, EnergyOverTime, Film, u32), String> {
    let mut replay = Replay::new(take, &catalog()).map_err(|e| e.to_string())?;
    let mut film = TakeFilm::new(&replay.engine.scene, seconds);
    let mut ledger = EnergyOverTime::default();
    let (mut seen, every) = (0_u64, (take.header.rate / f64::from(take.header.ratio) / 50.0).max(1.0) as u64);
    let mut look = |engine: &ca_haptic::engine::Engine| {
        if film.look(engine) && seen.is_multiple_of(every) {
            ledger.look(engine.state.tick as f64 / take.header.rate, engine.state.ledger.as_deref());
        }
        seen += 1;
    };
    let verdict = replay
        .run(take, &mut look, &mut |heard| {
            if let Some(sound) = &mut sound {
                sound.push(heard);
            }
            Ok(())
        })
        .map_err(|e| e.to_string())?;
    ledger.end = replay.engine.state.ledger.as_deref().filter(|_| verdict.versions == 1).cloned();
    judged(&verdict).map_err(|e| e.to_string())?;
    let alike = if verdict.tolerance > 0.0 {
        format!("recorded with an older arithmetic, equal to within {:e} of the peak", verdict.tolerance)
    } else {
        "bit-identical".into()
    };
    let words = format!("{alike}: {} force frames, {} sound samples", verdict.forces, verdict.samples);
    Ok((words, ledger, film.film, verdict.versions))
}

struct DevicePlots {
    device: String,
    /// Degree of freedom and name of each curve.
    shown: Vec<(usize, String)>,
    /// Last position \[m\].
    at: Vec<f64>,
    /// Positions \[m\], then forces \[N\].
    curves: Envelope,
}

impl DevicePlots {
    fn section(&self, faults: &[Mark]) -> Section {
        let n = self.shown.len();
        let curves = |from: usize| -> Vec<Curve> {
            self.shown.iter().enumerate().map(|(k, (_, name))| Curve::line(name, self.curves.curve(from + k))).collect()
        };
        let grid = || self.curves.grid();
        let places = Plot::over_time("Position of the hand", Axis::linear("position", "m"), grid(), curves(0));
        let mut forces = Plot::over_time("Force on the hand", Axis::linear("force", "N"), grid(), curves(n));
        forces.marks = faults.to_vec();
        Section::new(&format!("Hand at {}", self.device), vec![Block::Plot(places), Block::Plot(forces)])
    }
}

/// Data read from a take in one pass.
struct Recorded {
    sound: Sound,
    hands: Vec<DevicePlots>,
    /// Rows of time, source and description.
    events: Vec<Vec<String>>,
    loops: Loops,
    clocks: Vec<Clock>,
    modes: Vec<Mode>,
}

impl Recorded {
    fn of(take: &Take, scene: Option<&Scene>) -> Result<Recorded, Failure> {
        let h = &take.header;
        let gesture = h.rate / f64::from(h.ratio);
        let hand = |device: &String, dofs: u32| {
            let named = scene.into_iter().flat_map(|s| &s.inputs).filter_map(|i| {
                let (of, dof) = i.device.as_ref()?;
                (of == device).then(|| (*dof as usize, i.name.clone()))
            });
            let mut shown: Vec<(usize, String)> = named.take(CURVES).collect();
            if shown.is_empty() {
                shown = (0..(dofs as usize).min(CURVES)).map(|k| (k, format!("degree {k}"))).collect();
            }
            let curves = Envelope::new(gesture, 2 * shown.len());
            DevicePlots { device: device.clone(), at: vec![f64::NAN; shown.len()], shown, curves }
        };
        let mut r = Recorded {
            sound: Sound::new(h.rate, &h.channels),
            hands: h.setups.iter().map(|s| hand(&s.device, s.profile.dof)).collect(),
            events: Vec::new(),
            loops: Loops::default(),
            clocks: vec![Clock::default(); h.setups.len()],
            modes: vec![Mode::Off; h.setups.len()],
        };
        let device = |k: Option<u32>| k.map_or_else(|| "all".into(), |k| h.setups[k as usize].device.clone());
        let names = |s: &Scene| s.live.params.iter().map(|p| p.name.clone()).collect::<Vec<_>>();
        let mut params = scene.map(names).unwrap_or_default();
        for event in take.events()? {
            let mut reported = |tick: u64, of: String, what: String| {
                r.events.push(vec![format!("{:.4}", tick as f64 / h.rate), of, what]);
            };
            match event? {
                Event::Device(k, f) => r.device(k, &f, h.rate),
                Event::Force(k, f) => {
                    let (was, is) = (r.modes[k], Mode::read(f.mode));
                    r.modes[k] = is;
                    if was != is && is == Mode::Fault {
                        let cause = ca_haptic::frame::Cause::read(f.cause).name();
                        r.events.push(vec![
                            format!("{:.4}", f.tick as f64 / h.rate),
                            h.setups[k].device.clone(),
                            format!("fault: {cause}"),
                        ]);
                    }
                    r.force(k, &f, u64::from(h.ratio));
                }
                Event::Sound(tick, samples) => {
                    // a missing stretch becomes silence
                    let have = (r.sound.seconds() * h.rate).round() as u64;
                    let gap = tick.saturating_sub(have).min(60 * h.rate as u64) as usize;
                    r.sound.push(&vec![0.0; gap * h.channels.len()]);
                    r.sound.push(&samples);
                }
                Event::Change(tick, change) => {
                    let list = change.params.iter().map(|(k, v)| {
                        format!("{} = {}", params.get(*k as usize).map_or("?", String::as_str), short(*v))
                    });
                    reported(tick, "parameters".into(), list.collect::<Vec<_>>().join(", "));
                }
                Event::Model(tick, next) => {
                    let set = next.model.changes.iter().map(|(name, value)| format!("{name} = {value}"));
                    let set: Vec<_> = set.collect();
                    let with = if set.is_empty() { String::new() } else { format!(", with {}", set.join(", ")) };
                    reported(tick, "model".into(), format!("new version{with}"));
                    params = h.version(&next).scene(&catalog()).as_deref().map(names).unwrap_or_default();
                }
                Event::Order(tick, port, order) => {
                    let what = match order {
                        Order::Arm => "armed".into(),
                        Order::Disarm => "disarmed".into(),
                        Order::Trip(cause) => format!("tripped: {}", cause.name()),
                    };
                    reported(tick, device(port), what);
                }
                Event::Hand(tick, touched) => {
                    touched.words(scene).into_iter().for_each(|what| reported(tick, "hand".into(), what));
                }
                Event::Profile(tick, k, p) => {
                    let of = h.setups.get(k).map_or_else(String::new, |s| s.device.clone());
                    let what = format!("reports: {}, {} degrees of freedom, at most {} N", p.title, p.dof, p.force);
                    reported(tick, of, what);
                }
                Event::Reload(l) => reported(l.tick, "model".into(), "reset to the state at load".into()),
                Event::Lost(l) => reported(l.tick, "take".into(), format!("{} records lost", l.records)),
                Event::Rt(rt) => r.loops.seconds.push(rt),
                Event::Hash(_) | Event::Energy(_) | Event::View => {}
            }
        }
        Ok(r)
    }

    fn device(&mut self, k: usize, f: &DeviceFrame, rate: f64) {
        let hand = &mut self.hands[k];
        for (at, (dof, _)) in hand.at.iter_mut().zip(&hand.shown) {
            *at = f.pos.get(*dof).copied().unwrap_or(f64::NAN);
        }
        let clock = &mut self.clocks[k];
        if f.t_host_ns == 0 {
            return;
        }
        let now = Stamp { ns: f.t_host_ns, taken: f.tick as f64 / rate };
        if clock.session == f.session {
            self.loops.intervals.extend(clock.last.and_then(|last| now.since(last)));
        }
        if clock.session != f.session {
            *clock = Clock { session: f.session, ..Clock::default() };
        }
        clock.last = Some(now);
        clock.frames.push_front((f.seq, now));
        clock.frames.truncate(RECENT);
        if let Some((_, t)) = clock.forces.iter().find(|(seq, _)| *seq == f.ack) {
            self.loops.around.extend(now.since(*t));
            // earlier forces are answered too
            clock.forces.retain(|(seq, _)| *seq > f.ack);
        }
    }

    fn force(&mut self, k: usize, f: &ForceFrame, ratio: u64) {
        let hand = &mut self.hands[k];
        let gap = vec![f64::NAN; 2 * hand.shown.len()];
        // missing frames become a gap; a tick beyond all bounds adds none
        let due = f.tick.div_ceil(ratio).min(hand.curves.frames() + (1 << 20));
        while hand.curves.frames() < due {
            hand.curves.push(&gap);
        }
        let forces = hand.shown.iter().map(|(dof, _)| f.force.get(*dof).map_or(f64::NAN, |v| f64::from(*v)));
        let row: Vec<f64> = hand.at.iter().copied().chain(forces).collect();
        hand.curves.push(&row);
        let clock = &mut self.clocks[k];
        let asked = clock.frames.iter().find(|(seq, _)| *seq == f.ack && clock.session == f.ack_session);
        if let Some((_, t)) = asked {
            clock.forces.push_front((f.seq, *t));
            clock.forces.truncate(RECENT);
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn of_a_parameter_that_is_turned_the_first_and_the_last_step_are_told() {
        let row = |t: u32, of: &str, what: &str| vec![t.to_string(), of.to_string(), what.to_string()];
        let turned = (0..5).map(|t| row(t, "parameters", &format!("k = {t}")));
        let all = turned.chain([
            row(5, "hand", "grabs"),
            row(6, "parameters", "k = 6"),
            row(7, "parameters", "k = 1, z = 2"),
        ]);
        let times: Vec<String> = super::shortened(all.collect()).into_iter().map(|r| r[0].clone()).collect();
        assert_eq!(times, ["0", "4", "5", "6", "7"]);
    }
}
