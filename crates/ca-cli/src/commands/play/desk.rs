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
use ca_haptic::frame::{Cause, Mode};
use ca_haptic::host::control::Request;
use ca_haptic::serve::{Recorder, Shared};
use ca_play::{Page, PageRequest};
use ca_session::protocol::{Asked, Bound, Choices, DeviceState, Message, Picked, Request as PageAsks};
use ca_view::Drawing;
use serde_json::Value;
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

/// Between two words on how it goes.
const NEWS: Duration = Duration::from_millis(250);

/// Longest name of a device of sound \[bytes\].
const NAME: usize = 300;

/// Longest MIDI of a request \[bytes\]: as much as a chord needs.
const MIDI: usize = 96;

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

/// What is answered: words for people, and the mass that was asked for.
type Answer = Result<(String, Option<Picked>), String>;

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
        self.page.tell_all(&Message::Report { ok, text: text.clone() });
        recorder.say(bad, format!("{}: {what}{}{text}", self.name, if text.is_empty() { "" } else { "\n" }));
    }

    fn answer(
        &mut self,
        recorder: &mut Recorder,
        inputs: &mut Inputs,
        client: u64,
        request: &PageAsks,
        leave: &mut bool,
    ) -> Answer {
        let done = |text: &str| Ok((text.to_string(), None));
        let mut control = |recorder: &mut Recorder, request: Request| {
            let reply = answer(recorder, request, leave, None);
            if reply.ok { Ok((reply.text, None)) } else { Err(reply.text) }
        };
        match request {
            PageAsks::Grab { mass } => {
                if self.holder.is_some_and(|h| h != client) {
                    return Err("somebody else holds a mass".into());
                }
                recorder.grab(self.mass(*mass)?.1)?;
                self.holder = Some(client);
                done("held")
            }
            PageAsks::Drag { by } => {
                if self.holder != Some(client) {
                    return Err("no mass is held; grab one first".into());
                }
                recorder.drag(vector(by.as_deref())?)?;
                done("pulled")
            }
            PageAsks::Release => {
                if self.holder == Some(client) {
                    self.holder = None;
                    recorder.release()?;
                }
                done("let go")
            }
            PageAsks::Gesture { play } => {
                recorder.gesture(*play)?;
                done(if *play { "the model's own gesture plays" } else { "the gesture has stopped" })
            }
            PageAsks::Port { name, value } => {
                let name = name.as_deref().ok_or("`name`: which port?")?;
                recorder.port(name, value.ok_or("`value` is a number [m or N]")?, GLIDE)?;
                done(name)
            }
            PageAsks::Change { name, value } => {
                let [name, value] = [name, value].map(|text| text.trim());
                if name.is_empty() || value.is_empty() {
                    return Err("`name` and `value`: which number of the model, and what it is to be".into());
                }
                self.edit.change(name, value)?;
                done("the model is made anew")
            }
            PageAsks::Restart => {
                self.edit.restart();
                done("all begins as at load")
            }
            PageAsks::Play => {
                self.edit.restart();
                self.plays = true;
                done("all begins as at load, and plays")
            }
            PageAsks::Midi { bytes } => {
                let bytes = bytes.as_deref().filter(|b| b.len() <= MIDI);
                inputs.midi(recorder, bytes.ok_or_else(|| format!("`bytes` are up to {MIDI} numbers from 0 to 255"))?);
                done("played")
            }
            PageAsks::Learn { name } => {
                let name = name.as_ref().and_then(Option::as_deref);
                inputs.learn(recorder, name)?;
                done(if name.is_some() { "move a controller" } else { "no controller is bound" })
            }
            PageAsks::Audio { device } => {
                let name = device.trim();
                if name.is_empty() || name.len() > NAME {
                    return Err(format!("`device` is the name of what plays, of {NAME} bytes at most"));
                }
                recorder.outputs().ask(name)?;
                done("it is opened")
            }
            PageAsks::Record { on } => done(&self.keep.record(*on, &self.scene)?),
            PageAsks::Save => done(&self.keep.save(recorder)?),
            PageAsks::Set { values } => {
                let values = values.clone().ok_or("`values` are names with numbers, or texts with units")?;
                control(recorder, Request::Set { values })
            }
            PageAsks::Arm { on: true } if !self.allow_arm => {
                Err("forces are not armed from here: use `ca arm`, or start with --allow-arm".into())
            }
            PageAsks::Arm { on: true } => control(recorder, Request::Arm { device: None }),
            PageAsks::Arm { on: false } => control(recorder, Request::Disarm { device: None }),
            PageAsks::Stop => control(recorder, Request::Stop),
            PageAsks::Pick { mass } => self.pick(*mass),
            // answered by the server of the page
            PageAsks::Sound { .. } => done(""),
        }
    }

    /// Number in the drawing and number of the MAT that a request is about.
    fn mass(&self, mass: Option<u64>) -> Result<(u64, usize), String> {
        let drawn = mass.ok_or("`mass` is a number of the drawing")?;
        let mass = usize::try_from(drawn).ok().and_then(|n| self.drawing.scene_mass(n));
        mass.map(|mass| (drawn, mass)).ok_or_else(|| format!("{drawn}: there is no such mass to touch"))
    }

    /// What a mass is.
    fn pick(&self, mass: Option<u64>) -> Answer {
        let (drawn, mass) = self.mass(mass)?;
        let symbol = self.scene.symbols.get(mass).ok_or("no such mass")?;
        let name = symbol.name.to_string();
        Ok((name.clone(), Some(Picked { mass: drawn, name, kind: symbol.code.into() })))
    }

    /// How it goes.
    fn state(&self, recorder: &mut Recorder, inputs: &Inputs, shared: &Shared) -> Message {
        let (_, tick) = recorder.progress();
        let stats = self.stats.get();
        let device = |name: &str, mode: Mode, cause: Cause| DeviceState {
            name: name.into(),
            mode: mode.name().into(),
            cause: cause.name().into(),
        };
        let bound = |(channel, number, name): (u8, u8, &str)| Bound { channel, number, name: name.into() };
        let outputs = recorder.outputs();
        let outputs = Choices { choices: outputs.choices.clone(), wanted: outputs.wanted.clone(), busy: outputs.busy };
        Message::State {
            tick,
            seconds: tick as f64 / self.scene.rate,
            load: stats.as_ref().map(|s| s.load),
            late: shared.missed.load(Relaxed),
            lost: recorder.lost(),
            clipped: shared.clipped.load(Relaxed),
            diverged: shared.diverged.load(Relaxed),
            playing: recorder.playing(),
            pointer: recorder.held().and_then(|m| self.drawing.drawn_mass(m)).map_or(-1, |m| m as i64),
            devices: recorder.devices().map(|(name, mode, cause, _)| device(name, mode, cause)).collect(),
            params: recorder.controls().params().iter().map(|p| (p.name.clone(), p.value)).collect(),
            clients: self.page.clients() as u64,
            learning: inputs.learning().map(Into::into),
            bound: inputs.bound().map(bound).collect(),
            sound: self.sound.clone(),
            outputs,
            latency: recorder.heard().map(|h| h.1),
            underruns: stats.as_ref().map(|s| s.underruns),
            arms: self.allow_arm,
            keeps: self.keep.keeps(),
            recording: self.keep.recording().map(|p| p.display().to_string()),
        }
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
                        self.page.tell_all(&Message::Said { bad: true, text: why });
                    }
                }
                continue;
            };
            let Asked { id, request } = request;
            let answer = request.and_then(|r| self.answer(recorder, inputs, client, &r, &mut leave));
            let (ok, text, picked) = match answer {
                Ok((text, picked)) => (true, text, picked),
                Err(why) => (false, why, None),
            };
            // of what nobody numbered only a refusal is worth a word
            if id.is_some() || !ok {
                let id = id.unwrap_or(Value::Null);
                self.page.tell(client, &Message::Reply { id, ok, text, picked });
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

/// One number, or three.
fn vector(by: Option<&[f64]>) -> Result<[f64; 3], String> {
    match by {
        Some([u]) => Ok([*u, 0.0, 0.0]),
        Some([x, y, z]) => Ok([*x, *y, *z]),
        _ => Err("`by` is where the mass is pulled to, from where it rests [m]: [u], or [x, y, z] in space".into()),
    }
}
