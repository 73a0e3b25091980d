//! A playing instrument whose compiler is elsewhere.
//!
//! An edit of the model needs the compiler, which runs in a worker. The engine puts a message `compile` into the outbox,
//! plays on, and receives the new plan by [`WebEngine::compiled`], or the errors by [`WebEngine::refused`].

use crate::outbox::Outbox;
use ca_core::Catalog;
use ca_core::{LiveParam, Plan, Scene};
use ca_haptic::engine::Setup;
use ca_haptic::serve::{Sink, SinkStreams};
use ca_haptic::version::Version;
use ca_io::FileError;
use ca_model::{quantity, suggest};
use ca_session::protocol::{NumberedRequest, Request};
use ca_session::{CompileState, CompiledVersion, Instrument, Language, NoFiles, Parts, Refused, VersionCompiler};
use ca_view::Drawing;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

/// The page itself records sound and saves files.
const BY_PAGE: &str = "the page of a browser records sound by itself; takes need `ca play`";

/// Facts about a plan that the compiler knows.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Facts {
    /// Name of the model.
    pub name: String,
    /// Proven stability, in one line.
    pub stability: String,
    /// Warnings; empty if there are none.
    pub warnings: String,
}

/// A playing instrument.
pub struct WebEngine {
    instrument: Instrument,
    outbox: Outbox,
    compilation: Rc<RefCell<Compilation>>,
    stability: Rc<RefCell<String>>,
    played: Rc<RefCell<Vec<f32>>>,
    sound: Vec<f32>,
    /// Sound rate \[Hz\], channels, samples of a gesture frame.
    shape: Rc<RefCell<Shape>>,
}

/// Shape of the sound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Channels.
    pub channels: usize,
    /// Samples of a gesture frame, in each channel.
    pub frame: u32,
}

impl Shape {
    fn of(scene: &Scene) -> Shape {
        Shape { rate: scene.rate, channels: scene.counts.channels, frame: scene.rates.ratio }
    }
}

impl WebEngine {
    /// Makes an instrument at rest from a plan, and puts its message `scene` into the outbox.
    ///
    /// # Errors
    /// If the bytes are not a plan of this version.
    pub fn open(plan: &[u8], facts: &Facts) -> Result<WebEngine, String> {
        let scene = read(plan)?;
        let (outbox, stability) = (Outbox::default(), Rc::new(RefCell::new(facts.stability.clone())));
        let (compilation, played) = (Rc::default(), Rc::default());
        let shape = Rc::new(RefCell::new(Shape::of(&scene)));
        let parts = Parts {
            pages: Box::new(outbox.clone()),
            language: Box::new(WebLanguage(Rc::clone(&stability))),
            maker: Box::new(Elsewhere { outbox: outbox.clone(), state: Rc::clone(&compilation) }),
            files: Box::new(NoFiles(BY_PAGE)),
            name: facts.name.clone(),
            allow_arm: false,
        };
        let sink = SoundSink { played: Rc::clone(&played), shape: Rc::clone(&shape) };
        let instrument = Instrument::new(&scene, parts, Box::new(outbox.clone()), vec![Box::new(sink)]);
        Ok(WebEngine { instrument, outbox, compilation, stability, played, sound: Vec::new(), shape })
    }

    /// Returns the shape of the sound. It may change with a new version of the model.
    pub fn shape(&self) -> Shape {
        *self.shape.borrow()
    }

    /// Answers a request of the page, a JSON text, by a message in the outbox.
    pub fn request(&mut self, json: &[u8]) {
        let Ok(object) = serde_json::from_slice(json) else { return };
        let asked = NumberedRequest::read(object);
        if let Ok(Request::Sound { on }) = asked.request {
            self.outbox.hear(on);
        }
        self.instrument.request(0, asked);
    }

    /// Receives the plan that the message `compile` asked for.
    pub fn compiled(&mut self, plan: &[u8], facts: &Facts) {
        let made = read(plan).map(|scene| {
            self.stability.borrow_mut().clone_from(&facts.stability);
            (scene, facts.warnings.clone())
        });
        self.compilation.borrow_mut().end(made);
    }

    /// Receives the reason why the model cannot be compiled.
    pub fn refused(&mut self, why: &str) {
        self.compilation.borrow_mut().end(Err(why.into()));
    }

    /// Compiles the model again, because its text was changed.
    pub fn changed(&mut self) {
        self.compilation.borrow_mut().new = true;
    }

    /// Plays gesture frames and returns their sound: interleaved samples.
    pub fn play(&mut self, frames: u32) -> &[f32] {
        self.instrument.play(frames.into());
        self.sound.clear();
        std::mem::swap(&mut self.sound, &mut self.played.borrow_mut());
        &self.sound
    }

    /// Takes the oldest message to the page.
    pub fn next_message(&mut self) -> Option<Vec<u8>> {
        self.outbox.next()
    }
}

fn read(plan: &[u8]) -> Result<Arc<Scene>, String> {
    let catalog: Catalog = cordis_anima::catalog();
    Plan::from_bytes(plan, &catalog).map(Arc::new).map_err(|why| why.to_string())
}

/// Receives the sound of each frame.
struct SoundSink {
    played: Rc<RefCell<Vec<f32>>>,
    shape: Rc<RefCell<Shape>>,
}

impl Sink for SoundSink {
    fn streams(&self) -> SinkStreams {
        SinkStreams { sound: true, ..SinkStreams::MESSAGES }
    }

    fn sound(&mut self, _: u64, frames: &[f64]) -> Result<(), FileError> {
        self.played.borrow_mut().extend(frames.iter().map(|x| *x as f32));
        Ok(())
    }

    fn swapped(&mut self, _: u64, version: &Arc<Version>) -> Result<(), FileError> {
        *self.shape.borrow_mut() = Shape::of(&version.scene);
        Ok(())
    }
}

struct WebLanguage(Rc<RefCell<String>>);

impl Language for WebLanguage {
    fn value(&self, param: &LiveParam, text: &str) -> Result<f64, Refused> {
        quantity::of_param(&param.name, param.unit, text).map_err(Into::into)
    }

    fn nearest(&self, word: &str, names: &[&str]) -> Option<String> {
        suggest::nearest(word, names.iter().copied()).map(Into::into)
    }

    fn stability(&self, _: &Scene) -> String {
        self.0.borrow().clone()
    }
}

/// A compiled scene with its warnings, or the reason why there is none.
type Made = Result<(Arc<Scene>, String), String>;

/// State of a compilation in the worker.
#[derive(Default)]
struct Compilation {
    /// Requested, and not yet received.
    running: bool,
    /// The version starts as at load.
    anew: bool,
    made: Option<Made>,
    /// The text of the model changed.
    new: bool,
}

impl Compilation {
    fn end(&mut self, made: Made) {
        // a plan that nothing asked for is dropped
        if std::mem::take(&mut self.running) {
            self.made = Some(made);
        }
    }
}

struct Elsewhere {
    outbox: Outbox,
    state: Rc<RefCell<Compilation>>,
}

impl VersionCompiler for Elsewhere {
    fn check(&mut self, _: &str, _: &str) -> Result<(), Refused> {
        // the compiler reports a wrong name with the nearest one
        Ok(())
    }

    fn start(&mut self, changes: &[(String, String)], anew: bool, _: &[Setup]) -> Result<(), Refused> {
        let mut state = self.state.borrow_mut();
        (state.running, state.anew) = (true, anew);
        self.outbox.put(json!({"type": "compile", "changes": changes}).to_string().into_bytes());
        Ok(())
    }

    fn poll(&mut self) -> CompileState {
        let mut state = self.state.borrow_mut();
        if state.running {
            return CompileState::Busy;
        }
        let Some(made) = state.made.take() else { return CompileState::Idle };
        let anew = state.anew;
        CompileState::Done(made.map_err(Into::into).map(|(scene, warnings)| {
            let drawing = Arc::new(Drawing::new(&scene));
            let version = Version::new(scene, anew);
            Box::new(CompiledVersion { version, drawing, warnings, softened: false, setups: Vec::new() })
        }))
    }

    fn is_new(&mut self) -> bool {
        std::mem::take(&mut self.state.borrow_mut().new)
    }

    fn gone(&mut self) -> Option<String> {
        None
    }
}
