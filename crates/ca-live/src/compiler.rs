//! Edit and hear: reads and compiles a saved or changed model on a separate thread.

use crate::request::ModelSource;
use crate::text::{Snapshot, Stored};
use ca_compile::Options;
use ca_core::{LiveParam, Unit};
use ca_haptic::coupling;
use ca_haptic::engine::Setup;
use ca_haptic::version::{ModelText, Version};
use ca_lab::load::Loaded;
use ca_lab::watch::Watch;
use ca_lab::{Failure, load};
use ca_model::diag::Severity;
use ca_model::{quantity, render};
use ca_session::{self as session, CompiledVersion, VersionCompiler};
use ca_view::Drawing;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, PoisonError};

/// The model as its author wrote it, if it could be read, and the result.
type CompileState = (Option<Arc<Loaded>>, Result<Box<CompiledVersion>, session::Refused>);

/// Compiles versions of a model, each on a separate thread, and watches the file of the model.
pub(crate) struct Compiler {
    source: ModelSource,
    options: Options,
    /// The model as it was last read, without changes.
    loaded: Option<Arc<Loaded>>,
    /// The model of the version that plays, without changes.
    playing: Option<Arc<Loaded>>,
    /// Model that a page stored last.
    stored: Stored,
    /// Watched file, if the model comes from one.
    file: Option<Watch>,
    /// Receiver of the running compilation.
    making: Option<Receiver<CompileState>>,
}

impl Compiler {
    /// Makes a compiler. A page stores its model in `stored`.
    pub(crate) fn new(source: &ModelSource, options: &Options, stored: Stored) -> Compiler {
        let source = source.clone();
        let mut file = Watch::of(&source.word);
        let loaded = (source.read)().ok().map(Arc::new);
        if let (Some(file), Some(loaded)) = (&mut file, &loaded) {
            file.also(&load::part_files(&loaded.model));
        }
        Compiler { playing: loaded.clone(), loaded, stored, file, source, options: options.clone(), making: None }
    }
}

impl VersionCompiler for Compiler {
    fn check(&mut self, name: &str, value: &str) -> Result<(), session::Refused> {
        let Some(mut loaded) = self.loaded.as_deref().cloned() else { return Ok(()) };
        load::set_typed(&mut loaded, name, value).map_err(refused)
    }

    fn start(&mut self, changes: &[(String, String)], anew: bool, setups: &[Setup]) -> Result<(), session::Refused> {
        let (source, changes, options) = (self.source.clone(), changes.to_vec(), self.options.clone());
        let setups = setups.to_vec();
        let (tell, making) = channel();
        let start = move || {
            let mut read = None;
            let made = make(&source, &changes, (options, &setups), anew, &mut read);
            let _ = tell.send((read, made));
        };
        let thread = std::thread::Builder::new().name("ca model".into()).spawn(start);
        thread.map_err(|e| format!("cannot start a thread to compile the model: {e}"))?;
        self.making = Some(making);
        Ok(())
    }

    fn poll(&mut self) -> session::CompileState {
        let made = match self.making.as_ref().map(Receiver::try_recv) {
            Some(Err(TryRecvError::Empty)) => return session::CompileState::Busy,
            Some(Ok((read, made))) => {
                if let (Some(file), Some(read)) = (&mut self.file, &read) {
                    file.also(&load::part_files(&read.model));
                }
                self.loaded = read.or(self.loaded.take());
                if made.is_ok() {
                    self.playing.clone_from(&self.loaded);
                }
                session::CompileState::Done(made)
            }
            Some(Err(TryRecvError::Disconnected)) => {
                let why = "the model was not compiled: the compiler thread stopped unexpectedly";
                session::CompileState::Done(Err(why.into()))
            }
            None => session::CompileState::Idle,
        };
        self.making = None;
        made
    }

    fn snapshot(&mut self, changes: &[(String, String)], live: &[LiveParam]) -> Result<(), session::Refused> {
        let Some(loaded) = self.playing.clone() else { return Err("the text of the model cannot be read".into()) };
        load::needs_no_files(&loaded).map_err(refused)?;
        let rate = self.source.rate.map(|rate| ("rate.sound".to_owned(), quantity::show(rate, Unit::HERTZ)));
        let live = live.iter().map(|p| (p.name.clone(), quantity::show(p.value, p.unit)));
        let changes = rate.into_iter().chain(self.source.changes.iter().chain(changes).cloned()).chain(live).collect();
        *self.stored.lock().unwrap_or_else(PoisonError::into_inner) = Some(Snapshot { loaded, changes });
        Ok(())
    }

    fn is_new(&mut self) -> bool {
        self.file.as_mut().is_some_and(Watch::is_new)
    }

    fn gone(&mut self) -> Option<String> {
        let gone = self.file.as_mut().is_some_and(Watch::is_gone);
        gone.then(|| format!("`{}` no longer exists or is not a file; save it again", self.source.word))
    }
}

fn refused(e: Failure) -> session::Refused {
    session::Refused::from(match e {
        Failure::Usage(text) | Failure::Failed(text) => text,
        Failure::Found(found) => render::text(&found.diags, &found.model, false),
        Failure::Stopped => "stopped".into(),
    })
}

/// Reads the model into `read`, and compiles it with its changes.
fn make(
    source: &ModelSource,
    changes: &[(String, String)],
    (options, setups): (Options, &[Setup]),
    anew: bool,
    read: &mut Option<Arc<Loaded>>,
) -> Result<Box<CompiledVersion>, session::Refused> {
    let mut loaded = (source.read)().map_err(refused)?;
    *read = Some(Arc::new(loaded.clone()));
    let changes: Vec<_> = source.changes.iter().chain(changes).cloned().collect();
    for (name, value) in &changes {
        load::set_typed(&mut loaded, name, value).map_err(refused)?;
    }
    let mut options = Options { clouds: loaded.clouds.clone(), couplings: Vec::new(), ..options };
    let compiled = loaded.compile(&options).map_err(|found| refused(found.into()))?;
    let met = coupling::couple(compiled, setups, &mut options, |options| loaded.compile(options));
    let (softened, setups) = (met.messages(), met.setups(setups));
    let compiled = met.compiled;
    let drawing = Arc::new(Drawing::new(&compiled.scene));
    let mut warnings = compiled.findings;
    warnings.list.retain(|d| d.severity == Severity::Warning);
    let said = if warnings.list.is_empty() { String::new() } else { render::text(&warnings, &loaded.model, false) };
    let said = [said, softened.join("\n")].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join("\n");
    let model = ModelText::of(&loaded.model, changes);
    let version = Version { scene: Arc::new(compiled.scene), model, options, moved: Vec::new(), restart: anew };
    Ok(Box::new(CompiledVersion { version, drawing, warnings: said, softened: !softened.is_empty(), setups }))
}
