//! What people do in a page.
//!
//! Decides that a page asks as `ca set` and `ca disarm` do, by the same words and with the same answers; that one client at
//! a time holds a mass, which is let go when that client is gone; and that a page never arms forces by itself: somebody
//! who can type on this machine has to allow it.

use super::edit::{Edit, Made};
use super::greeting::greeting;
use super::keep::Keep;
use super::sink::{Coming, PageSink, Stats};
use crate::args::PlayArgs;
use crate::commands::serve::{self, Inputs, answer};
use ca_core::Scene;
use ca_haptic::engine::{GLIDE, Setup};
use ca_haptic::host::control::Request;
use ca_haptic::serve::{Recorder, Shared};
use ca_play::{Page, PageRequest};
use ca_view::Drawing;
use serde_json::{Map, Value, json};
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

/// Between two words on how it goes.
const NEWS: Duration = Duration::from_millis(250);

/// Longest name of a device of sound \[bytes\].
const NAME: usize = 300;

/// The page of a running engine.
pub(crate) struct Desk {
    page: Page,
    drawing: Arc<Drawing>,
    scene: Arc<Scene>,
    stats: Stats,
    /// what plays the sound besides the page
    sound: String,
    allow_arm: bool,
    /// the client that holds a mass
    holder: Option<u64>,
    name: String,
    edit: Edit,
    keep: Keep,
    /// which version of the model plays, and the one that is on its way
    generation: u32,
    coming: Coming,
    next: Option<(Arc<Scene>, Arc<Drawing>)>,
    /// the model's own gesture begins with the next version
    plays: bool,
    news: Instant,
}

/// What is answered: words for people, and more for the page.
type Answer = Result<(String, Map<String, Value>), String>;

impl Desk {
    pub(super) fn new(
        page: Page,
        name: &str,
        drawing: Arc<Drawing>,
        scene: Arc<Scene>,
        sink: &PageSink,
        args: &PlayArgs,
        (edit, keep): (Edit, Keep),
    ) -> Desk {
        Desk {
            page,
            drawing,
            scene,
            stats: sink.stats(),
            sound: "page".into(),
            allow_arm: args.allow_arm,
            holder: None,
            name: name.into(),
            edit,
            keep,
            generation: 1,
            coming: sink.coming(),
            next: None,
            plays: false,
            news: Instant::now(),
        }
    }

    /// Takes up a version of the model that the engine plays now, and hands on one that was made.
    fn version(&mut self, recorder: &mut Recorder, inputs: &mut Inputs, setups: &[Setup]) {
        if let Some((scene, drawing)) = self.next.take() {
            inputs.version(&scene);
            (self.scene, self.drawing, self.holder) = (scene, drawing, None);
            self.page.greet(&greeting(&self.scene, &self.drawing, &self.name, self.generation));
            if core::mem::take(&mut self.plays) && !self.scene.gestures.is_empty() {
                if let Err(why) = recorder.gesture(true) {
                    recorder.say(true, why);
                }
            }
        }
        let Some(made) = self.edit.turn(setups) else { return };
        let mut bad = made.is_err();
        let made = made.and_then(|Made { version, drawing, said, softened, setups }| {
            bad = softened;
            let (scene, anew) = (version.scene.clone(), version.anew);
            recorder.swap(version, &setups)?;
            self.generation += 1;
            self.coming.put(self.generation, drawing.clone());
            self.next = Some((scene, drawing));
            Ok((if anew { "begins anew" } else { "the model was read again" }, said))
        });
        let ok = made.is_ok();
        bad |= !ok;
        self.plays &= ok;
        let (what, text) = made.unwrap_or_else(|why| ("the model as it was plays on", why));
        self.page.tell_all(&json!({"type": "report", "ok": ok, "text": text}));
        recorder.say(bad, format!("{}: {what}{}{text}", self.name, if text.is_empty() { "" } else { "\n" }));
    }

    fn answer(
        &mut self,
        recorder: &mut Recorder,
        inputs: &mut Inputs,
        client: u64,
        request: &Value,
        leave: &mut bool,
    ) -> Answer {
        let done = |text: &str| Ok((text.to_string(), Map::new()));
        let mut control = |recorder: &mut Recorder, request: Request| {
            let reply = answer(recorder, request, leave, None);
            if reply.ok { Ok((reply.text, reply.fields)) } else { Err(reply.text) }
        };
        match request["type"].as_str().unwrap_or_default() {
            "grab" => {
                if self.holder.is_some_and(|h| h != client) {
                    return Err("somebody else holds a mass".into());
                }
                recorder.grab(self.mass(request)?)?;
                self.holder = Some(client);
                done("held")
            }
            "drag" => {
                if self.holder != Some(client) {
                    return Err("no mass is held; grab one first".into());
                }
                recorder.drag(vector(&request["by"])?)?;
                done("pulled")
            }
            "release" => {
                if self.holder == Some(client) {
                    self.holder = None;
                    recorder.release()?;
                }
                done("let go")
            }
            "gesture" => {
                recorder.gesture(request["play"] == true)?;
                done(if request["play"] == true { "the model's own gesture plays" } else { "the gesture has stopped" })
            }
            "port" => {
                let name = request["name"].as_str().ok_or("`name`: which port?")?;
                recorder.port(name, request["value"].as_f64().ok_or("`value` is a number [m or N]")?, GLIDE)?;
                done(name)
            }
            "change" => {
                let [name, value] = ["name", "value"].map(|k| request[k].as_str().unwrap_or_default().trim());
                if name.is_empty() || value.is_empty() {
                    return Err("`name` and `value`: which number of the model, and what it is to be".into());
                }
                self.edit.change(name, value)?;
                done("the model is made anew")
            }
            "restart" => {
                self.edit.restart();
                done("all begins as at load")
            }
            "play" => {
                self.edit.restart();
                self.plays = true;
                done("all begins as at load, and plays")
            }
            "midi" => {
                inputs.midi(recorder, &bytes(&request["bytes"])?);
                done("played")
            }
            "learn" => {
                inputs.learn(recorder, request["name"].as_str())?;
                done(if request["name"].is_string() { "move a controller" } else { "no controller is bound" })
            }
            "audio" => {
                let name = request["device"].as_str().unwrap_or_default().trim();
                if name.is_empty() || name.len() > NAME {
                    return Err(format!("`device` is the name of what plays, of {NAME} bytes at most"));
                }
                recorder.outputs().ask(name)?;
                done("it is opened")
            }
            "record" => done(&self.keep.record(request["on"] == true, &self.scene)?),
            "save" => done(&self.keep.save(recorder)?),
            "set" => {
                let values = serde_json::from_value(request["values"].clone())
                    .map_err(|_| "`values` are names with numbers, or texts with units".to_string())?;
                control(recorder, Request::Set { values })
            }
            "arm" if request["on"] == true && !self.allow_arm => {
                Err("forces are not armed from here: use `ca arm`, or start with --allow-arm".into())
            }
            "arm" if request["on"] == true => control(recorder, Request::Arm { device: None }),
            "arm" => control(recorder, Request::Disarm { device: None }),
            "stop" => control(recorder, Request::Stop),
            "pick" => self.pick(request),
            other => Err(format!("`{other}` is nothing a page can ask")),
        }
    }

    /// Number of the MAT that a request is about.
    fn mass(&self, request: &Value) -> Result<usize, String> {
        let drawn = request["mass"].as_u64().ok_or("`mass` is a number of the drawing")?;
        let mass = usize::try_from(drawn).ok().and_then(|n| self.drawing.scene_mass(n));
        mass.ok_or_else(|| format!("{drawn}: there is no such mass to touch"))
    }

    /// What a mass is.
    fn pick(&self, request: &Value) -> Answer {
        let mass = self.mass(request)?;
        let symbol = self.scene.symbols.get(mass).ok_or("no such mass")?;
        let mut fields = Map::new();
        fields.insert("mass".into(), request["mass"].clone());
        fields.insert("name".into(), json!(symbol.name.to_string()));
        fields.insert("kind".into(), json!(symbol.code));
        Ok((symbol.name.to_string(), fields))
    }

    /// How it goes.
    fn state(&self, recorder: &mut Recorder, inputs: &Inputs, shared: &Shared) -> Value {
        let (_, tick) = recorder.progress();
        let stats = self.stats.get();
        let devices: Vec<Value> = recorder
            .devices()
            .map(|(name, mode, cause, _)| json!({"name": name, "mode": mode.name(), "cause": cause.name()}))
            .collect();
        let params: Map<String, Value> =
            recorder.controls().params().iter().map(|p| (p.name.clone(), json!(p.value))).collect();
        let outputs = recorder.outputs();
        let outputs = json!({"choices": outputs.choices, "wanted": outputs.wanted, "busy": outputs.busy});
        json!({
            "type": "state",
            "tick": tick,
            "seconds": tick as f64 / self.scene.rate,
            "load": stats.as_ref().map(|s| s.load),
            "late": shared.missed.load(Relaxed),
            "lost": recorder.lost(),
            "clipped": shared.clipped.load(Relaxed),
            "diverged": shared.diverged.load(Relaxed),
            "playing": recorder.playing(),
            "pointer": recorder.held().and_then(|m| self.drawing.drawn_mass(m)).map_or(-1, |m| m as i64),
            "devices": devices,
            "params": params,
            "clients": self.page.clients(),
            "learning": inputs.learning(),
            "bound": inputs.bound().map(|(c, n, name)| json!({"channel": c, "number": n, "name": name})).collect::<Value>(),
            "sound": self.sound,
            "outputs": outputs,
            "latency": recorder.heard().map(|h| h.1),
            "underruns": stats.as_ref().map(|s| s.underruns),
            "arms": self.allow_arm,
            "keeps": self.keep.keeps(),
            "recording": self.keep.recording().map(|p| p.display().to_string()),
        })
    }
}

impl serve::Desk for Desk {
    fn address(&self) -> String {
        self.page.address()
    }

    fn sounds_by(&mut self, host: &str) {
        self.sound = host.into();
    }

    fn change(&mut self, name: &str, value: &str) -> Result<(), String> {
        self.edit.change(name, value)
    }

    /// The page is gone; what it keeps is not.
    fn close(self: Box<Self>) -> Box<dyn Any> {
        Box::new(self.keep)
    }

    fn turn(
        &mut self,
        recorder: &mut Recorder,
        inputs: &mut Inputs,
        setups: Option<&[Setup]>,
        (shared, end): (&Shared, Instant),
    ) -> bool {
        let mut leave = false;
        self.keep.turn(recorder);
        if recorder.is_swapping() {
            return leave;
        }
        if let Some(setups) = setups {
            self.version(recorder, inputs, setups);
        }
        if recorder.is_swapping() {
            return leave;
        }
        let mut late = false;
        while !late {
            let Some(PageRequest { client, request }) = self.page.asked().next() else { break };
            late = Instant::now() >= end;
            let Some(request) = request else {
                if self.holder == Some(client) {
                    self.holder = None;
                    if let Err(why) = recorder.release() {
                        self.page.tell_all(&json!({"type": "said", "bad": true, "text": why}));
                    }
                }
                continue;
            };
            let (ok, text, mut fields) = match self.answer(recorder, inputs, client, &request, &mut leave) {
                Ok((text, fields)) => (true, text, fields),
                Err(why) => (false, why, Map::new()),
            };
            // of what nobody numbered only a refusal is worth a word
            if request.get("id").is_some() || !ok {
                fields.insert("type".into(), json!("reply"));
                fields.insert("id".into(), request["id"].clone());
                fields.insert("ok".into(), json!(ok));
                fields.insert("text".into(), json!(text));
                self.page.tell(client, &Value::Object(fields));
            }
        }
        let now = Instant::now();
        if now >= self.news && self.page.clients() > 0 {
            self.news = now + NEWS;
            self.page.tell_all(&self.state(recorder, inputs, shared));
        }
        leave
    }
}

/// MIDI, as much as a chord needs.
fn bytes(list: &Value) -> Result<Vec<u8>, String> {
    let why = "`bytes` are up to 96 numbers from 0 to 255";
    let list = list.as_array().filter(|l| l.len() <= 96).ok_or(why)?;
    let byte = |v: &Value| v.as_u64().and_then(|n| u8::try_from(n).ok());
    list.iter().map(byte).collect::<Option<Vec<u8>>>().ok_or_else(|| why.into())
}

/// One number, or three.
fn vector(by: &Value) -> Result<[f64; 3], String> {
    let why = "`by` is where the mass is pulled to, from where it rests [m]: [u], or [x, y, z] in space";
    let list: Option<Vec<f64>> = by.as_array().ok_or(why)?.iter().map(Value::as_f64).collect();
    let list = list.ok_or(why)?;
    match list[..] {
        [u] => Ok([u, 0.0, 0.0]),
        [x, y, z] => Ok([x, y, z]),
        _ => Err(why.into()),
    }
}
