//! The options of a performance, and the receiver of its messages.

use ca_haptic::control;
use ca_haptic::serve::Shared;
use ca_lab::Failure;
use ca_lab::load::Loaded;
use ca_model::Model;
use ca_model::diag::Diags;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};

/// Reads a model again, after its file was changed.
pub type Reader = Arc<dyn Fn() -> Result<Loaded, Failure> + Send + Sync>;

/// A model, and how it is read again.
#[derive(Clone)]
pub struct ModelSource {
    /// the word that means the model: a path, or a name
    pub word: String,
    /// reads it, without `changes`
    pub read: Reader,
    /// parameters that are set in it, as by `--set`
    pub changes: Vec<(String, String)>,
    /// sound rate \[Hz\]; the rate of the model if none
    pub rate: Option<f64>,
}

/// The page in a browser.
#[derive(Clone, Copy, Debug, Default)]
pub struct PageOptions {
    /// TCP port; the usual one or a free one if none
    pub port: Option<u16>,
    /// other pages of this machine may show it in a frame
    pub framed: bool,
    /// it may arm the forces of devices
    pub allow_arm: bool,
    /// modules without influence on any output are left out
    pub lean: bool,
}

/// The output of the sound.
#[derive(Clone, Debug, Default)]
pub struct SoundOptions {
    /// a server, a device, the empty word for the default device, or `page`; with a page and no name, a server that runs
    pub device: Option<String>,
    /// frames at once; the output chooses if there is none
    pub buffer: Option<u32>,
}

/// MIDI and OSC.
#[derive(Clone, Debug, Default)]
pub struct InputOptions {
    /// a device, a pipe or a file of raw MIDI; all devices of the machine for an empty path
    pub midi: Option<PathBuf>,
    /// a UDP port for OSC; 0 takes a free one
    pub osc: Option<u16>,
    /// the file with the token of OSC; the one beside the profiles of the user if none
    pub osc_token: Option<PathBuf>,
}

/// Starts a gesture frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// the clock of this machine, or of the sound device
    #[default]
    Monotonic,
    /// each frame of the first device
    Device,
}

/// Force devices.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// profiles, as `[DEVICE=]PROFILE`
    pub profiles: Vec<String>,
    /// calibrations, as `DEVICE=FILE`
    pub calibrations: Vec<String>,
    /// all are armed at the start
    pub arm: bool,
    /// starts gesture frames
    pub pace: Pace,
}

/// Files that are written.
#[derive(Clone, Debug, Default)]
pub struct FileOptions {
    /// the sound, as WAV
    pub sound: Option<PathBuf>,
    /// the take, as MCAP
    pub take: Option<PathBuf>,
}

/// The engine thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct ThreadOptions {
    /// priority (`SCHED_FIFO`), 0 to 99; 0 asks for none
    pub priority: u8,
    /// the core it stays on
    pub cpu: Option<usize>,
    /// keeps the memory of the process in RAM
    pub lock: bool,
}

/// A request of the program that plays, as of `ca set`, with the place for its answer.
pub type Asked = (control::Request, Sender<control::Reply>);

/// A performance.
pub struct Request {
    /// the model
    pub source: ModelSource,
    /// the same, read and with its changes
    pub loaded: Loaded,
    /// the page, if there is one
    pub page: Option<PageOptions>,
    /// output of the sound
    pub sound: SoundOptions,
    /// MIDI and OSC
    pub inputs: InputOptions,
    /// force devices
    pub devices: DeviceOptions,
    /// files that are written
    pub files: FileOptions,
    /// the engine thread
    pub thread: ThreadOptions,
    /// length \[s\]; until stopped if none
    pub seconds: Option<f64>,
    /// plays the gesture of the model from the start
    pub gesture: bool,
    /// keeps the energy ledger
    pub energy: bool,
    /// requests of the program that plays
    pub asked: Option<Receiver<Asked>>,
}

/// Receives the messages of a performance, from several of its threads.
pub trait Listener: Send + Sync {
    /// For information.
    fn note(&self, text: &str);

    /// Something is not as it should be.
    fn warning(&self, text: &str);

    /// Something failed, and the performance goes on or ends.
    fn error(&self, text: &str);

    /// The warnings about the model.
    fn findings(&self, findings: &Diags, model: &Model);

    /// The course of the performance; a quiet program leaves this out.
    fn progress(&self, text: &str);

    /// From here on `stop` of `shared` ends the performance. Files are written after this call.
    fn begins(&self, shared: &Arc<Shared>);

    /// The performance runs, and its page has this address.
    fn page_opened(&self, address: &str);
}
