//! The parts of a session that need a compiler, files or threads, as traits. The host supplies them.

use crate::refused::Refused;
use ca_core::{LiveParam, Scene};
use ca_haptic::engine::Setup;
use ca_haptic::serve::Recorder;
use ca_haptic::version::Version;
use ca_view::Drawing;
use std::sync::Arc;

/// The language of models, as far as requests and messages use it.
pub trait Language {
    /// The value of a text for `param` \[SI\].
    ///
    /// # Errors
    /// If the text is not a quantity of its unit.
    fn value(&self, param: &LiveParam, text: &str) -> Result<f64, Refused>;

    /// The name that is nearest to `word`, if one is near.
    fn nearest(&self, word: &str, names: &[&str]) -> Option<String>;

    /// The proven stability of a scene, in one line.
    fn stability(&self, scene: &Scene) -> String;
}

/// A new version of the model, ready to play.
pub struct Made {
    /// the version
    pub version: Version,
    /// its drawing
    pub drawing: Arc<Drawing>,
    /// its warnings, in words; empty without any
    pub warnings: String,
    /// whether keys of devices were softened, or are too stiff
    pub softened: bool,
    /// devices as this version plays them
    pub setups: Vec<Setup>,
}

/// The state of a compilation.
pub enum Making {
    /// nothing was asked for, or the result was taken
    Idle,
    /// it goes on
    Busy,
    /// it ended: the version, or why the model cannot be played
    Done(Result<Box<Made>, Refused>),
}

/// Compiles new versions of the model, one at a time and beside the engine.
pub trait Maker {
    /// Begins to compile the model with `changes`, names and values in order, for devices of these `setups`. With `anew` the
    /// version begins as at load.
    ///
    /// # Errors
    /// If it cannot begin.
    fn start(&mut self, changes: &[(String, String)], anew: bool, setups: &[Setup]) -> Result<(), Refused>;

    /// Takes the result of the compilation, if it ended.
    fn poll(&mut self) -> Making;

    /// True if the text of the model changed since the last call.
    fn is_new(&mut self) -> bool;

    /// In words, once after the text of the model disappeared.
    fn gone(&mut self) -> Option<String>;
}

/// Writes files of a performance: recorded sound, and takes.
pub trait Files {
    /// True if what was done can be saved as a take.
    fn can_save(&self) -> bool;

    /// The file into which sound is recorded now.
    fn recording(&self) -> Option<String>;

    /// Reports files that were finished. To be called every few milliseconds.
    fn turn(&mut self, recorder: &mut Recorder);

    /// Records sound into a new file from now on, or ends that; gives an answer in words.
    ///
    /// # Errors
    /// If nothing is recorded, or the file cannot be written.
    fn record(&mut self, on: bool, scene: &Scene) -> Result<String, Refused>;

    /// Saves everything that was done since the start as a take; gives an answer in words.
    ///
    /// # Errors
    /// If nothing was kept, or the file cannot be written.
    fn save(&mut self, recorder: &mut Recorder) -> Result<String, Refused>;
}
