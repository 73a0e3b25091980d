//! `ca serve`: plays a model in real time with device processes ([`ca_live`]).

mod args;
mod summary;

pub use args::{ClockKind, ServeArgs};

use crate::outcome::{Ended, Failure, Outcome};
use crate::{load, outputs, term};
use ca_haptic::serve::Shared;
use ca_live::{
    DeviceOptions, FileOptions, InputOptions, Listener, ModelSource, Pace, PageOptions, Reader, Request, SoundOptions,
    ThreadOptions,
};
use ca_model::Model;
use ca_model::diag::Diags;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

/// Time after a first Ctrl-C from which a second one ends the process.
const SURE: Duration = Duration::from_millis(500);

pub(crate) type OpensPage = Box<dyn Fn(&str) + Send + Sync>;

/// Runs the command.
pub fn run(args: &ServeArgs) -> Outcome {
    play(args, None, Box::new(|_| ()))
}

/// Plays in real time. Opens a page if `page` has options for one.
pub(crate) fn play(args: &ServeArgs, page: Option<PageOptions>, opens: OpensPage) -> Outcome {
    written(args)?;
    let word = args.source.model.clone();
    let request = request(args, page, Arc::new(move || load::read(&word)))?;
    let listener: Arc<dyn Listener> = Arc::new(Terminal { quiet: args.quiet, opens });
    let report = ca_live::play(request, &listener)?;
    if args.json {
        println!("{:#}", summary::value(&report));
    } else if !args.quiet {
        summary::text(&report)?;
    }
    Ok(if report.summary.is_faithful() { Ended::Well } else { Ended::Degraded })
}

/// Builds the request from the arguments. `read` reads the model.
pub(crate) fn request(args: &ServeArgs, page: Option<PageOptions>, read: Reader) -> Result<Request, ca_lab::Failure> {
    let word = args.source.model.clone();
    Ok(Request {
        loaded: load::changed(read()?, &args.source)?,
        source: ModelSource { word, read, changes: args.source.changes().collect(), rate: args.source.rate },
        page,
        sound: SoundOptions { device: args.audio.clone(), buffer: args.audio_buffer },
        inputs: InputOptions { midi: args.midi.clone(), osc: args.osc, osc_token: args.osc_token.clone() },
        devices: DeviceOptions {
            profiles: args.profile.clone(),
            calibrations: args.calibration.clone(),
            arm: args.arm,
            pace: match args.clock {
                ClockKind::Monotonic => Pace::Monotonic,
                ClockKind::Device => Pace::Device,
            },
        },
        files: FileOptions { sound: args.output.clone(), take: args.log.clone() },
        thread: ThreadOptions { priority: args.priority, cpu: args.cpu, lock: !args.no_lock },
        seconds: args.seconds,
        gesture: args.gesture,
        energy: args.energy,
        requests: None,
    })
}

/// Prints the messages of a performance to the terminal.
struct Terminal {
    quiet: bool,
    opens: OpensPage,
}

impl Listener for Terminal {
    fn note(&self, text: &str) {
        term::note(text);
    }

    fn warning(&self, text: &str) {
        term::warning(text);
    }

    fn error(&self, text: &str) {
        term::error(text);
    }

    fn findings(&self, findings: &Diags, model: &Model) {
        term::findings(findings, model);
    }

    fn progress(&self, text: &str) {
        if !self.quiet {
            term::note(text);
        }
    }

    /// Sets the handler of Ctrl-C and SIGTERM. The first signal ends the performance, and another one at least half a
    /// second later ends the process. A process can set only one handler; if this fails, the signals end the process at
    /// once.
    fn begins(&self, shared: &Arc<Shared>) {
        let (stop, mut first) = (shared.clone(), None);
        let _ = ctrlc::set_handler(move || {
            stop.stop.store(true, Relaxed);
            if first.get_or_insert_with(Instant::now).elapsed() > SURE {
                std::process::exit(130);
            }
        });
    }

    fn page_opened(&self, address: &str) {
        (self.opens)(address);
    }
}

/// Refuses outputs that would overwrite each other or an input.
fn written(args: &ServeArgs) -> Result<(), Failure> {
    let file = |given: &'_ String| PathBuf::from(given.split_once('=').map_or(given.as_str(), |(_, file)| file));
    let [profiles, calibrations] = [&args.profile, &args.calibration].map(|l| l.iter().map(file).collect::<Vec<_>>());
    let mut inputs = vec![("the model", Path::new(&args.source.model))];
    inputs.extend(profiles.iter().map(|p| ("a profile", &**p)));
    inputs.extend(calibrations.iter().map(|p| ("a calibration", &**p)));
    inputs.extend(args.midi.iter().chain(&args.osc_token).map(|p| ("an input", &**p)));
    let sound = args.output.iter().map(|p| ("-o", &**p));
    outputs::check_distinct(&sound.chain(args.log.iter().map(|p| ("--log", &**p))).collect::<Vec<_>>(), &inputs)
}
