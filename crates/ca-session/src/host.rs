//! Traits for the parts of a session that need a compiler, files or threads. The host implements them.

use crate::refused::Refused;
use ca_core::{LiveParam, Scene};
use ca_haptic::engine::Setup;
use ca_haptic::serve::Recorder;
use ca_haptic::version::Version;
use ca_view::Drawing;
use std::sync::Arc;

/// Language of models, as far as requests and messages use it.
pub trait Language {
    /// Parses a text as a value of `param` \[SI\].
    ///
    /// # Errors
    /// If the text is not a quantity of its unit.
    fn value(&self, param: &LiveParam, text: &str) -> Result<f64, Refused>;

    /// Returns the name nearest to `word`, if one is near.
    fn nearest(&self, word: &str, names: &[&str]) -> Option<String>;

    /// Describes the proven stability of a scene in one line.
    fn stability(&self, scene: &Scene) -> String;
}

/// A new version of the model, ready to play.
pub struct CompiledVersion {
    /// Version.
    pub version: Version,
    /// Drawing of the version.
    pub drawing: Arc<Drawing>,
    /// Warnings, in words; empty if there are none.
    pub warnings: String,
    /// True if keys of devices were softened, or are too stiff.
    pub softened: bool,
    /// Setups of the devices for this version.
    pub setups: Vec<Setup>,
}

/// State of a compilation.
pub enum CompileState {
    /// Nothing was requested, or the result was taken.
    Idle,
    /// It is running.
    Busy,
    /// It has ended, with the version or the reason why the model cannot be played.
    Done(Result<Box<CompiledVersion>, Refused>),
}

/// Compiles new versions of the model, one at a time and beside the engine.
pub trait VersionCompiler {
    /// Checks that the model, as it was last read, has a parameter `name` that can have `value`.
    ///
    /// # Errors
    /// If it has no such parameter, with the nearest name.
    fn check(&mut self, name: &str, value: &str) -> Result<(), Refused>;

    /// Begins to compile the model with `changes`, names and values in order, for devices of these `setups`. With
    /// `anew` the version starts as at load.
    ///
    /// # Errors
    /// If it cannot begin.
    fn start(&mut self, changes: &[(String, String)], anew: bool, setups: &[Setup]) -> Result<(), Refused>;

    /// Takes the result of the compilation, if it has ended.
    fn poll(&mut self) -> CompileState;

    /// Stores the model that plays, with `changes` and the values of `live`, the live parameters that were moved. The host
    /// offers its text to the page.
    ///
    /// # Errors
    /// If the host does not have the text, or it needs other files.
    fn snapshot(&mut self, changes: &[(String, String)], live: &[LiveParam]) -> Result<(), Refused> {
        let _ = (changes, live);
        Err("this program does not have the text of the model".into())
    }

    /// Returns true if the text of the model changed since the last call.
    fn is_new(&mut self) -> bool;

    /// Returns a message once after the text of the model disappeared.
    fn gone(&mut self) -> Option<String>;
}

/// Writes files of a performance: recorded sound, and takes.
pub trait Files {
    /// Returns true if the performance can be saved as a take.
    fn can_save(&self) -> bool;

    /// Returns the file into which sound is being recorded.
    fn recording(&self) -> Option<String>;

    /// Reports finished files. Call it every few milliseconds.
    fn poll(&mut self, recorder: &mut Recorder);

    /// Starts or ends the recording of sound into a new file; returns an answer in words.
    ///
    /// # Errors
    /// If nothing is being recorded, or the file cannot be written.
    fn record(&mut self, on: bool, scene: &Scene) -> Result<String, Refused>;

    /// Saves everything since the start as a take; returns an answer in words.
    ///
    /// # Errors
    /// If nothing was kept, or the file cannot be written.
    fn save(&mut self, recorder: &mut Recorder) -> Result<String, Refused>;
}

/// Files of a host that writes none. Requests for files are refused with this reason.
pub struct NoFiles(pub &'static str);

impl Files for NoFiles {
    fn can_save(&self) -> bool {
        false
    }

    fn recording(&self) -> Option<String> {
        None
    }

    fn poll(&mut self, _: &mut Recorder) {}

    fn record(&mut self, _: bool, _: &Scene) -> Result<String, Refused> {
        Err(self.0.into())
    }

    fn save(&mut self, _: &mut Recorder) -> Result<String, Refused> {
        Err(self.0.into())
    }
}
