//! Edit and hear: reads and compiles a saved or changed model on a separate thread.

use crate::request::ModelSource;
use ca_compile::Options;
use ca_haptic::coupling;
use ca_haptic::engine::Setup;
use ca_haptic::version::{ModelText, Version};
use ca_lab::watch::Watch;
use ca_lab::{Failure, load};
use ca_model::diag::Severity;
use ca_model::render;
use ca_session::{self as session, Made, Maker};
use ca_view::Drawing;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Files from which the model takes parts, and the result.
type Making = (Vec<String>, Result<Box<Made>, session::Refused>);

/// Compiles versions of a model, each on a separate thread, and watches the file of the model.
pub(crate) struct Compiler {
    source: ModelSource,
    options: Options,
    /// Watched file, if the model comes from one.
    file: Option<Watch>,
    /// Receiver of the running compilation.
    making: Option<Receiver<Making>>,
}

impl Compiler {
    pub(crate) fn new(source: &ModelSource, options: &Options) -> Compiler {
        let source = source.clone();
        let mut file = Watch::of(&source.word);
        if let (Some(file), Ok(loaded)) = (&mut file, (source.read)()) {
            file.also(&load::part_files(&loaded.model));
        }
        Compiler { file, source, options: options.clone(), making: None }
    }
}

impl Maker for Compiler {
    fn start(&mut self, changes: &[(String, String)], anew: bool, setups: &[Setup]) -> Result<(), session::Refused> {
        let (source, changes, options) = (self.source.clone(), changes.to_vec(), self.options.clone());
        let setups = setups.to_vec();
        let (tell, making) = channel();
        let start = move || {
            let mut files = Vec::new();
            let made = make(&source, &changes, (options, &setups), anew, &mut files);
            let _ = tell.send((files, made));
        };
        let thread = std::thread::Builder::new().name("ca model".into()).spawn(start);
        thread.map_err(|e| format!("no thread to make the model: {e}"))?;
        self.making = Some(making);
        Ok(())
    }

    fn poll(&mut self) -> session::Making {
        let made = match self.making.as_ref().map(Receiver::try_recv) {
            Some(Err(TryRecvError::Empty)) => return session::Making::Busy,
            Some(Ok((files, made))) => {
                if let Some(file) = &mut self.file {
                    file.also(&files);
                }
                session::Making::Done(made)
            }
            Some(Err(TryRecvError::Disconnected)) => {
                session::Making::Done(Err("the model could not be made: its thread ended".into()))
            }
            None => session::Making::Idle,
        };
        self.making = None;
        made
    }

    fn is_new(&mut self) -> bool {
        self.file.as_mut().is_some_and(Watch::is_new)
    }

    fn gone(&mut self) -> Option<String> {
        let gone = self.file.as_mut().is_some_and(Watch::is_gone);
        gone.then(|| format!("`{}` is not there any more, or is no file; save it again", self.source.word))
    }
}

fn make(
    source: &ModelSource,
    changes: &[(String, String)],
    (options, setups): (Options, &[Setup]),
    anew: bool,
    files: &mut Vec<String>,
) -> Result<Box<Made>, session::Refused> {
    let words = |e: Failure| {
        session::Refused::from(match e {
            Failure::Usage(text) | Failure::Failed(text) => text,
            Failure::Found(found) => render::text(&found.diags, &found.model, false),
            Failure::Stopped => "stopped".into(),
        })
    };
    let mut loaded = (source.read)().map_err(words)?;
    *files = load::part_files(&loaded.model);
    let changes: Vec<_> = source.changes.iter().chain(changes).cloned().collect();
    for (name, value) in &changes {
        load::set_typed(&mut loaded, name, value).map_err(words)?;
    }
    let mut options = Options { clouds: loaded.clouds.clone(), couplings: Vec::new(), ..options };
    let compiled = loaded.compile(&options).map_err(|found| words(found.into()))?;
    let met = coupling::meet(compiled, setups, &mut options, |options| loaded.compile(options));
    let (softened, setups) = (met.said(), met.setups(setups));
    let compiled = met.compiled;
    let drawing = Arc::new(Drawing::new(&compiled.scene));
    let mut warnings = compiled.findings;
    warnings.list.retain(|d| d.severity == Severity::Warning);
    let said = if warnings.list.is_empty() { String::new() } else { render::text(&warnings, &loaded.model, false) };
    let said = [said, softened.join("\n")].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join("\n");
    let model = ModelText::of(&loaded.model, changes);
    let version = Version { scene: Arc::new(compiled.scene), model, options, moved: Vec::new(), anew };
    Ok(Box::new(Made { version, drawing, warnings: said, softened: !softened.is_empty(), setups }))
}
