//! Requests of pages, and the state that pages share.
//!
//! A page sends the same requests as `ca set` and `ca disarm`, and gets the same answers. The masses that a page holds are
//! released when it closes. A page arms forces only if the command line allows it.

use crate::answer::answer;
use crate::edit::Edit;
use crate::fingers::Fingers;
use crate::greeting::greeting;
use crate::host::{CompiledVersion, Files, Language, VersionCompiler};
use crate::midi::Midi;
use crate::pages::Pages;
use crate::picture::{NextDrawing, PageSink, Stats};
use crate::protocol::{Bound, Choices, DeviceState, Message, NumberedRequest, Picked, Request as PageAsks};
use crate::refused::Refused;
use ca_core::{LiveParam, Scene};
use ca_haptic::control::Request;
use ca_haptic::engine::{GLIDE, Setup};
use ca_haptic::frame::{Cause, Mode};
use ca_haptic::serve::{Recorder, Shared};
use ca_view::Drawing;
use serde_json::Value;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

/// Time between two messages `state`.
const STATE_INTERVAL: Duration = Duration::from_millis(250);

/// Longest name of a sound device \[bytes\].
const NAME: usize = 300;

/// Longest MIDI of a request \[bytes\]: enough for a chord.
const MIDI: usize = 96;

/// Parts of a session that the host provides.
pub struct Parts {
    /// Pages.
    pub pages: Box<dyn Pages>,
    /// Language of the model.
    pub language: Box<dyn Language>,
    /// Compiles edits.
    pub maker: Box<dyn VersionCompiler>,
    /// Writes files.
    pub files: Box<dyn Files>,
    /// Name of the model.
    pub name: String,
    /// Allows a page to arm forces.
    pub allow_arm: bool,
}

/// One playing instrument with its pages.
pub struct Session {
    pages: Box<dyn Pages>,
    language: Box<dyn Language>,
    files: Box<dyn Files>,
    edit: Edit,
    name: String,
    allow_arm: bool,
    drawing: Arc<Drawing>,
    scene: Arc<Scene>,
    stats: Stats,
    /// Host of the sound output, or the page.
    sound: String,
    fingers: Fingers,
    /// Version of the model that plays.
    generation: u32,
    next_drawing: NextDrawing,
    /// Version that the engine was given.
    next: Option<(Arc<Scene>, Arc<Drawing>)>,
    /// Starts the model's own gesture with the next version.
    plays: bool,
    /// Time of the next message `state`.
    next_state: Duration,
}

/// An answer in words, and the requested mass.
type Answer = Result<(String, Option<Picked>), Refused>;

impl Session {
    /// Makes a session that plays `scene`, and whose pages receive from `sink`.
    pub fn new(parts: Parts, scene: Arc<Scene>, drawing: Arc<Drawing>, sink: &PageSink) -> Session {
        let Parts { pages, language, maker, files, name, allow_arm } = parts;
        Session {
            pages,
            language,
            files,
            edit: Edit::new(maker),
            name,
            allow_arm,
            drawing,
            scene,
            stats: sink.stats(),
            sound: "page".into(),
            fingers: Fingers::default(),
            generation: 1,
            next_drawing: sink.next_drawing(),
            next: None,
            plays: false,
            next_state: Duration::ZERO,
        }
    }

    /// Sets the host of the sound output, which may be the page.
    pub fn sounds_by(&mut self, host: &str) {
        self.sound = host.into();
    }

    /// Changes a number of the model, as `--set` does.
    ///
    /// # Errors
    /// If there are too many changes, or one is too long.
    pub fn change(&mut self, name: &str, value: &str) -> Result<(), Refused> {
        self.edit.change(name, value)
    }

    /// Ends the session; files being written end when the result is dropped.
    pub fn close(self) -> Box<dyn Files> {
        self.files
    }

    /// Reports finished files, and adopts new versions of the model if `setups` is given. Call it every few
    /// milliseconds. Returns false while the engine changes to another version: requests then wait.
    pub fn poll(&mut self, recorder: &mut Recorder, midi: &mut Midi, setups: Option<&[Setup]>) -> bool {
        self.files.poll(recorder);
        if recorder.is_swapping() {
            return false;
        }
        if let Some(setups) = setups {
            self.version(recorder, midi, setups);
        }
        !recorder.is_swapping()
    }

    /// Answers a request of a page. Returns true if it ends the program.
    pub fn request(
        &mut self,
        recorder: &mut Recorder,
        midi: &mut Midi,
        (client, asked): (u64, NumberedRequest),
        now: Duration,
    ) -> bool {
        let mut leave = false;
        let NumberedRequest { id, request } = asked;
        let answer = request.and_then(|r| self.answer(recorder, midi, (client, &r), now, &mut leave));
        let (ok, text, picked) = match answer {
            Ok((text, picked)) => (true, text, picked),
            Err(why) => (false, why.to_string(), None),
        };
        // a request without an id is answered only if it is refused
        if id.is_some() || !ok {
            let id = id.unwrap_or(Value::Null);
            self.pages.send(client, &Message::Reply { id, ok, text, picked });
        }
        leave
    }

    /// Releases the masses held by a page that was closed.
    pub fn left(&mut self, recorder: &mut Recorder, client: u64) {
        for finger in self.fingers.release(client, None) {
            if let Err(why) = recorder.release(finger) {
                self.pages.send_all(&Message::Said { bad: true, text: why.to_string() });
            }
        }
    }

    /// Sends the message `state` if it is due.
    pub fn send_state(&mut self, recorder: &mut Recorder, midi: &Midi, shared: &Shared, now: Duration) {
        if now >= self.next_state && self.pages.is_seen() {
            self.next_state = now + STATE_INTERVAL;
            self.pages.send_all(&self.state(recorder, midi, shared));
        }
    }

    /// Shows the version that the engine now plays, and gives the engine a newly compiled one.
    fn version(&mut self, recorder: &mut Recorder, midi: &mut Midi, setups: &[Setup]) {
        if let Some((scene, drawing)) = self.next.take() {
            midi.version(&scene);
            (self.scene, self.drawing, self.fingers) = (scene, drawing, Fingers::default());
            let stability = self.language.stability(&self.scene);
            self.pages.greet(&greeting(&self.scene, &self.drawing, &self.name, self.generation, stability));
            if core::mem::take(&mut self.plays) && !self.scene.about.gestures.is_empty() {
                if let Err(why) = recorder.gesture(true) {
                    recorder.say(true, why.to_string());
                }
            }
        }
        let Some(made) = self.edit.poll(setups) else { return };
        let mut bad = made.is_err();
        let made = made.and_then(|made| {
            let CompiledVersion { version, drawing, warnings, softened, setups } = *made;
            bad = softened;
            let (scene, anew) = (version.scene.clone(), version.restart);
            recorder.swap(version, &setups)?;
            self.generation += 1;
            self.next_drawing.put(self.generation, drawing.clone());
            self.next = Some((scene, drawing));
            Ok((if anew { "restarted" } else { "new version loaded" }, warnings))
        });
        let ok = made.is_ok();
        bad |= !ok;
        self.plays &= ok;
        let (what, text) = made.unwrap_or_else(|why| ("the previous version keeps playing", why.to_string()));
        self.pages.send_all(&Message::Report { ok, text: text.clone() });
        recorder.say(bad, format!("{}: {what}{}{text}", self.name, if text.is_empty() { "" } else { "\n" }));
    }

    fn answer(
        &mut self,
        recorder: &mut Recorder,
        midi: &mut Midi,
        (client, request): (u64, &PageAsks),
        now: Duration,
        leave: &mut bool,
    ) -> Answer {
        let done = |text: &str| Ok((text.to_string(), None));
        let language = &*self.language;
        let mut control = |recorder: &mut Recorder, request: Request| {
            let reply = answer(recorder, language, request, leave, None);
            if reply.ok { Ok((reply.text, None)) } else { Err(reply.text.into()) }
        };
        match request {
            PageAsks::Grab { mass, finger } => {
                let (own, mass) = ((client, finger.unwrap_or(0)), self.mass(*mass)?.1);
                let finger = self.fingers.free(own, mass)?;
                recorder.grab(finger, mass)?;
                self.fingers.hold(finger, own, mass);
                done("held")
            }
            PageAsks::Drag { by, finger } => {
                let finger = self.fingers.of((client, finger.unwrap_or(0)));
                let finger = finger.ok_or("this finger does not hold a mass; grab one first")?;
                recorder.drag(finger, vector(by.as_deref())?)?;
                done("pulled")
            }
            PageAsks::Release { finger } => {
                for finger in self.fingers.release(client, *finger) {
                    recorder.release(finger)?;
                }
                done("released")
            }
            PageAsks::Gesture { play } => {
                recorder.gesture(*play)?;
                done(if *play { "gesture started" } else { "gesture stopped" })
            }
            PageAsks::Port { name, value } => {
                let name = name.as_deref().ok_or("`name` must be the name of a port")?;
                recorder.port(name, value.ok_or("`value` must be a number, in m or N")?, GLIDE)?;
                done(name)
            }
            PageAsks::Change { name, value } => {
                let [name, value] = [name, value].map(|text| text.trim());
                if name.is_empty() || value.is_empty() {
                    return Err("`name` must name a value in the model, and `value` its new value".into());
                }
                self.edit.change(name, value)?;
                done("compiling the model again")
            }
            PageAsks::Restart => {
                self.edit.restart();
                done("restarting from the state at load")
            }
            PageAsks::Play => {
                self.edit.restart();
                self.plays = true;
                done("restarting from the state at load, then playing the gesture, if any")
            }
            PageAsks::Midi { bytes } => {
                let bytes = bytes.as_deref().filter(|b| b.len() <= MIDI);
                midi.play(
                    recorder,
                    bytes.ok_or_else(|| format!("`bytes` must be at most {MIDI} numbers from 0 to 255"))?,
                    now,
                );
                done("played")
            }
            PageAsks::Learn { name } => {
                let name = name.as_ref().and_then(Option::as_deref);
                midi.learn(recorder, name)?;
                done(if name.is_some() { "move a MIDI controller to bind it" } else { "binding cancelled" })
            }
            PageAsks::Audio { device } => {
                let name = device.trim();
                if name.is_empty() || name.len() > NAME {
                    return Err(format!("`device` must be the name of a sound output, of at most {NAME} bytes").into());
                }
                recorder.outputs().request(name)?;
                done("opening the sound output")
            }
            PageAsks::Record { on } => done(&self.files.record(*on, &self.scene)?),
            PageAsks::Snapshot => {
                let at_load = &self.scene.live.params;
                let params = recorder.controls().params().iter();
                let moved = |p: &&LiveParam| at_load.iter().all(|l| l.name != p.name || l.value != p.value);
                self.edit.snapshot(&params.filter(moved).cloned().collect::<Vec<_>>())?;
                done("stored")
            }
            PageAsks::Save => done(&self.files.save(recorder)?),
            PageAsks::Set { values } => {
                let values = values.clone().ok_or("`values` must map names to numbers or to texts with units")?;
                control(recorder, Request::Set { values })
            }
            PageAsks::Arm { on: true } if !self.allow_arm => {
                Err("this page may not arm forces: run `ca arm`, or restart with `--allow-arm`".into())
            }
            PageAsks::Arm { on: true } => control(recorder, Request::Arm { device: None }),
            PageAsks::Arm { on: false } => control(recorder, Request::Disarm { device: None }),
            PageAsks::Stop => control(recorder, Request::Stop),
            PageAsks::Pick { mass } => self.pick(*mass),
            // answered by the server of the page
            PageAsks::Sound { .. } => done(""),
        }
    }

    /// Returns the number in the drawing and the index of the MAT for a request.
    fn mass(&self, mass: Option<u64>) -> Result<(u64, usize), Refused> {
        let drawn = mass.ok_or("`mass` must be the number of a mass in the drawing")?;
        let mass = usize::try_from(drawn).ok().and_then(|n| self.drawing.scene_mass(n));
        mass.map(|mass| (drawn, mass))
            .ok_or_else(|| format!("mass {drawn} of the drawing does not exist or cannot be held").into())
    }

    fn pick(&self, mass: Option<u64>) -> Answer {
        let (drawn, mass) = self.mass(mass)?;
        let symbol = self.scene.symbols.get(mass).ok_or("the mass does not exist")?;
        let name = symbol.name.to_string();
        Ok((name.clone(), Some(Picked { mass: drawn, name, kind: symbol.code.into() })))
    }

    fn state(&self, recorder: &mut Recorder, midi: &Midi, shared: &Shared) -> Message {
        let (_, tick) = recorder.progress();
        let stats = self.stats.get();
        let device = |name: &str, mode: Mode, cause: Cause| DeviceState {
            name: name.into(),
            mode: mode.name().into(),
            cause: cause.name().into(),
        };
        let bound = |(channel, number, name): (u8, u8, &str)| Bound { channel, number, name: name.into() };
        let held: Vec<u64> = recorder.held().filter_map(|m| self.drawing.drawn_mass(m)).map(|m| m as u64).collect();
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
            pointer: held.first().map_or(-1, |m| *m as i64),
            held,
            devices: recorder.devices().map(|(name, mode, cause, _)| device(name, mode, cause)).collect(),
            params: recorder.controls().params().iter().map(|p| (p.name.clone(), p.value)).collect(),
            clients: self.pages.count() as u64,
            learning: midi.learning().map(Into::into),
            bound: midi.bound().map(bound).collect(),
            sound: self.sound.clone(),
            outputs,
            latency: recorder.audio_output().map(|h| h.1),
            underruns: stats.as_ref().map(|s| s.underruns),
            arms: self.allow_arm,
            keeps: self.files.can_save(),
            recording: self.files.recording(),
        }
    }
}

/// Parses one or three numbers.
fn vector(by: Option<&[f64]>) -> Result<[f64; 3], Refused> {
    match by {
        Some([u]) => Ok([*u, 0.0, 0.0]),
        Some([x, y, z]) => Ok([*x, *y, *z]),
        _ => Err("`by` must be the displacement from rest in m: [u], or [x, y, z] in space".into()),
    }
}
