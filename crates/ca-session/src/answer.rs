//! Answers to requests from `ca set`, `ca arm` and similar commands, and from pages.

use crate::host::Language;
use crate::preset;
use crate::refused::Refused;
use ca_core::LiveParam;
use ca_core::internal::numeric::Plain;
use ca_haptic::control::{Given, Reply, Request};
use ca_haptic::guard::Order;
use ca_haptic::serve::Recorder;
use serde_json::{Map, Value, json};
use std::fmt::Write as _;

/// Longest name that is looked up \[bytes\].
const LONGEST: usize = 300;

/// Changes a number of the model that is not live, as `--set` does: its name and value.
pub type Change<'a> = &'a mut dyn FnMut(&str, &str) -> Result<(), Refused>;

/// Answers a request; sets `leave` if it ends the program. With `change`, names that are not live parameters are
/// numbers of the model, which is then recompiled.
pub fn answer(
    recorder: &mut Recorder,
    language: &dyn Language,
    request: Request,
    leave: &mut bool,
    change: Option<Change<'_>>,
) -> Reply {
    let done = |r: Result<(), Refused>, text: String| match r {
        Ok(()) => Reply::done(text),
        Err(why) => Reply::refused(why),
    };
    match request {
        Request::Set { values } => {
            let mut list: Vec<(String, f64)> = Vec::new();
            let live = |name: &String| recorder.controls().params().iter().any(|p| p.name == *name);
            let is_preset = |name: &String, given: &Given| preset::chosen(recorder, name, given).is_some();
            let (values, anew) = values
                .into_iter()
                .partition::<Vec<_>, _>(|(name, given)| change.is_none() || live(name) || is_preset(name, given));
            for (name, given) in values {
                if let Some(name) = preset::chosen(recorder, &name, &given) {
                    match preset::values(recorder, language, name) {
                        // a parameter that is set by itself counts, not its value in the preset
                        Ok(values) => list.splice(..0, values),
                        Err(why) => return Reply::refused(why),
                    };
                    continue;
                }
                match value(recorder, language, &name, given) {
                    Ok(v) => list.push((name, v)),
                    Err(why) => return Reply::refused(why),
                }
            }
            let mut names: Vec<String> = list.iter().map(|(n, v)| format!("{n} = {}", Plain(*v))).collect();
            if let Err(why) = if anew.is_empty() || !list.is_empty() { recorder.set(&list) } else { Ok(()) } {
                return Reply::refused(why);
            }
            if let Some(change) = change {
                for (name, given) in anew {
                    let text = match given {
                        Given::Number(v) => format!("{v:?}"),
                        Given::Text(text) => text,
                    };
                    if let Err(why) = change(&name, text.trim()) {
                        return Reply::refused(why);
                    }
                    names.push(format!(
                        "{name} = {}: compiling the model again; errors appear in its terminal",
                        text.trim()
                    ));
                }
            }
            Reply::done(names.join(", "))
        }
        Request::Arm { device } => {
            let who = device.as_deref().unwrap_or("all devices").to_string();
            done(
                recorder.order(device.as_deref(), Order::Arm).map_err(Refused::from),
                format!("{who}: armed; forces fade in once the model's force is near zero"),
            )
        }
        Request::Disarm { device } => {
            let who = device.as_deref().unwrap_or("all devices").to_string();
            done(recorder.order(device.as_deref(), Order::Disarm).map_err(Refused::from), format!("{who}: forces off"))
        }
        Request::Stop => {
            *leave = true;
            Reply::done("ending")
        }
        Request::Audio { to: Some(name) } if name.len() > LONGEST => {
            Reply::refused(format!("a name may have at most {LONGEST} bytes"))
        }
        Request::Audio { to: Some(name) } => done(
            recorder.outputs().request(name.trim()).map_err(Refused::from),
            format!("requested sound output `{name}`"),
        ),
        Request::Audio { to: None } => outputs(recorder),
        Request::Status => status(recorder),
    }
}

/// Returns the value of a live parameter \[SI\].
///
/// # Errors
/// If the parameter does not exist, or the text is not a quantity of its unit.
pub fn value(recorder: &Recorder, language: &dyn Language, name: &str, given: Given) -> Result<f64, Refused> {
    let params = recorder.controls().params();
    if name.len() > LONGEST {
        return Err(format!("a name may have at most {LONGEST} bytes").into());
    }
    let Some(param) = params.iter().find(|p| p.name == name) else {
        let names: Vec<&str> = params.iter().map(|p| p.name.as_str()).collect();
        let hint = match language.nearest(name, &names) {
            Some(m) => format!("did you mean `{m}`?"),
            None => "declare it in `[param]` with `live = true`".into(),
        };
        return Err(format!("`{name}` is not a live parameter of this model; {hint}").into());
    };
    match given {
        Given::Number(v) => Ok(v),
        Given::Text(text) => language.value(param, &text),
    }
}

/// Describes a live parameter as JSON, with null for an infinite bound.
fn param(p: &LiveParam) -> Value {
    json!({"name": p.name, "value": p.value, "min": p.min, "max": p.max, "unit": p.unit.symbol, "doc": p.doc})
}

/// Lists the sound output and the outputs to choose from.
fn outputs(recorder: &mut Recorder) -> Reply {
    let o = recorder.outputs();
    let choices: Vec<String> = o.choices.iter().map(|c| format!("`{c}`")).collect();
    let choices = if choices.is_empty() { "no choices".into() } else { format!("choices: {}", choices.join(", ")) };
    let text = format!("sound: {}; {choices}", if o.plays.is_empty() { "none" } else { &o.plays });
    let fields = match serde_json::to_value(&*o) {
        Ok(Value::Object(fields)) => fields,
        _ => Map::new(),
    };
    Reply { ok: true, text, fields }
}

fn status(recorder: &Recorder) -> Reply {
    let (frames, tick) = recorder.progress();
    let params: Vec<Value> = recorder.controls().params().iter().map(param).collect();
    let devices: Vec<Value> = recorder
        .devices()
        .map(|(name, mode, cause, frames)| {
            json!({"device": name, "mode": mode.name(), "cause": cause.name(), "frames": frames})
        })
        .collect();
    let mut text = format!("{frames} gesture frames, sample {tick}");
    if recorder.lost() > 0 {
        let _ = write!(text, "; lost so far: {} records, samples, pictures, forces or times", recorder.lost());
    }
    for (name, mode, cause, frames) in recorder.devices() {
        let _ = write!(text, "\n{name}: {} ({}), {frames} frames", mode.name(), cause.name());
    }
    for (name, why) in recorder.waiting() {
        let _ = write!(text, "\n{name}: armed, forces still off: {why}");
    }
    let mut fields = Map::new();
    fields.insert("frames".into(), json!(frames));
    let waits: Map<String, Value> = recorder.waiting().map(|(name, why)| (name.into(), json!(why))).collect();
    fields.insert("waits".into(), waits.into());
    fields.insert("tick".into(), json!(tick));
    fields.insert("lost".into(), json!(recorder.lost()));
    fields.insert("devices".into(), devices.into());
    fields.insert("params".into(), params.into());
    let presets: Vec<&str> = recorder.scene().about.presets.iter().map(|p| p.0.as_str()).collect();
    fields.insert("presets".into(), json!(presets));
    Reply { ok: true, text, fields }
}
