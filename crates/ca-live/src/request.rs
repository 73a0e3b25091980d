//! Options of a performance, and the trait that receives its messages.

use ca_haptic::control;
use ca_haptic::serve::Shared;
use ca_lab::Failure;
use ca_lab::load::Loaded;
use ca_model::Model;
use ca_model::diag::Diags;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};

/// Reads a model again after its file was changed.
pub type Reader = Arc<dyn Fn() -> Result<Loaded, Failure> + Send + Sync>;

/// A model, and how to read it again.
#[derive(Clone)]
pub struct ModelSource {
    /// Word that names the model: a path or a name.
    pub word: String,
    /// Reads the model without `changes`.
    pub read: Reader,
    /// Parameters set in the model, as by `--set`.
    pub changes: Vec<(String, String)>,
    /// Sound rate \[Hz\]; if `None`, the rate of the model.
    pub rate: Option<f64>,
}

/// Options of the page in a browser.
#[derive(Clone, Debug, Default)]
pub struct PageOptions {
    /// TCP port; if `None`, the default port or a free one.
    pub port: Option<u16>,
    /// Lets other pages of this machine show the page in a frame.
    pub framed: bool,
    /// Lets the page arm the forces of devices.
    pub allow_arm: bool,
    /// Omits modules without influence on any output.
    pub lean: bool,
    /// Address of a site for links to the model.
    pub site: Option<String>,
    /// Makes one HTML file of a model.
    pub one_file: Option<OneFile>,
}

/// Makes one HTML file of a model, from its text, the name of its file, and the address of a site or an empty string.
pub type OneFile = fn(&str, &str, &str) -> String;

/// Options of the sound output.
#[derive(Clone, Debug, Default)]
pub struct SoundOptions {
    /// Server, device, `page`, or an empty string for the default device. If `None`, a page uses a running server.
    pub device: Option<String>,
    /// Frames per buffer; if `None`, the output chooses.
    pub buffer: Option<u32>,
}

/// Options of MIDI and OSC.
#[derive(Clone, Debug, Default)]
pub struct InputOptions {
    /// Device, pipe or file of raw MIDI. An empty path means all devices of the machine.
    pub midi: Option<PathBuf>,
    /// UDP port for OSC; 0 takes a free one.
    pub osc: Option<u16>,
    /// File with the OSC token; if `None`, the file beside the profiles of the user.
    pub osc_token: Option<PathBuf>,
}

/// Clock that starts the gesture frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// Clock of this machine or of the sound device.
    #[default]
    Monotonic,
    /// Each frame of the first device.
    Device,
}

/// Options of force devices.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Profiles, as `[DEVICE=]PROFILE`.
    pub profiles: Vec<String>,
    /// Calibrations, as `DEVICE=FILE`.
    pub calibrations: Vec<String>,
    /// Arms all devices at the start.
    pub arm: bool,
    /// Clock of the gesture frames.
    pub pace: Pace,
}

/// Output files.
#[derive(Clone, Debug, Default)]
pub struct FileOptions {
    /// Path of the sound file (WAV).
    pub sound: Option<PathBuf>,
    /// Path of the take (MCAP).
    pub take: Option<PathBuf>,
}

/// Options of the engine thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct ThreadOptions {
    /// `SCHED_FIFO` priority from 1 to 99; 0 requests none.
    pub priority: u8,
    /// Processor core to which the thread is bound.
    pub cpu: Option<usize>,
    /// Locks the memory of the process in RAM.
    pub lock: bool,
}

/// A request from the calling program, such as `ca set` makes, and the sender for its answer.
pub type ControlRequest = (control::Request, Sender<control::Reply>);

/// Request of a performance.
pub struct Request {
    /// The model.
    pub source: ModelSource,
    /// The same model, read and with its changes.
    pub loaded: Loaded,
    /// Page, if there is one.
    pub page: Option<PageOptions>,
    /// Sound output.
    pub sound: SoundOptions,
    /// MIDI and OSC.
    pub inputs: InputOptions,
    /// Force devices.
    pub devices: DeviceOptions,
    /// Output files.
    pub files: FileOptions,
    /// Engine thread.
    pub thread: ThreadOptions,
    /// Length \[s\]; if `None`, until stopped.
    pub seconds: Option<f64>,
    /// Plays the gesture of the model from the start.
    pub gesture: bool,
    /// Computes the energy ledger.
    pub energy: bool,
    /// Requests from the calling program.
    pub requests: Option<Receiver<ControlRequest>>,
}

/// Receives the messages of a performance, from several of its threads.
pub trait Listener: Send + Sync {
    /// Receives information.
    fn note(&self, text: &str);

    /// Receives a warning.
    fn warning(&self, text: &str);

    /// Receives an error. The performance may go on.
    fn error(&self, text: &str);

    /// Receives the warnings about the model.
    fn findings(&self, findings: &Diags, model: &Model);

    /// Receives progress messages, which a quiet program omits.
    fn progress(&self, text: &str);

    /// Called before any file is written. From then on, `stop` of `shared` ends the performance.
    fn begins(&self, shared: &Arc<Shared>);

    /// Called with the address of the page, once the performance runs.
    fn page_opened(&self, address: &str);
}
