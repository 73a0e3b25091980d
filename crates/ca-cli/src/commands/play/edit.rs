//! Edit and hear: a model that is saved, or a number of it that is changed, becomes another version of the scene while it plays.
//!
//! Decides that a model is read and compiled on a thread of its own; and that one with errors is reported and changes nothing.

use crate::args::{ServeArgs, Source};
use crate::watch::Watch;
use ca_compile::Options;
use ca_haptic::version::{ModelText, Version};
use ca_lab::{Failure, load};
use ca_model::diag::Severity;
use ca_model::render;
use ca_view::Drawing;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// A version that was made.
pub(super) struct Made {
    pub(super) version: Version,
    pub(super) drawing: Arc<Drawing>,
    /// its warnings, or nothing
    pub(super) said: String,
}

/// Makes versions of a model.
pub(super) struct Edit {
    source: Source,
    options: Options,
    /// numbers that were changed since, in order
    changes: Vec<(String, String)>,
    /// those that are being made
    tried: Vec<(String, String)>,
    /// those of the last version that was good
    good: Vec<(String, String)>,
    /// the file, where the model is one
    file: Option<Watch>,
    /// what is being made, and whether something changed meanwhile
    making: Option<Receiver<Result<Made, String>>>,
    again: bool,
}

impl Edit {
    pub(super) fn new(args: &ServeArgs, options: &Options) -> Edit {
        let source = args.source.clone();
        Edit {
            file: Watch::of(&source.model),
            source,
            options: options.clone(),
            changes: Vec::new(),
            tried: Vec::new(),
            good: Vec::new(),
            making: None,
            again: false,
        }
    }

    /// A number of the model is to be another, as by `--set`.
    pub(super) fn change(&mut self, name: &str, value: &str) {
        self.changes.retain(|c| c.0 != name);
        self.changes.push((name.into(), value.into()));
        self.again = true;
    }

    /// One turn: a version that is ready, or why there is none.
    pub(super) fn turn(&mut self) -> Option<Result<Made, String>> {
        self.again |= self.file.as_mut().is_some_and(Watch::is_new);
        let made = match self.making.as_ref().map(Receiver::try_recv) {
            Some(Err(TryRecvError::Empty)) => return None,
            Some(Ok(made)) => Some(made),
            Some(Err(TryRecvError::Disconnected)) => Some(Err("the model could not be made: its thread ended".into())),
            None => None,
        };
        self.making = None;
        match made {
            Some(Ok(_)) => self.good.clone_from(&self.tried),
            // a change that is refused is none, unless there is another by now
            Some(Err(_)) if self.changes == self.tried => self.changes.clone_from(&self.good),
            _ => {}
        }
        if core::mem::take(&mut self.again) {
            let (source, changes, options) = (self.source.clone(), self.changes.clone(), self.options.clone());
            self.tried.clone_from(&changes);
            let (tell, making) = channel();
            let start = move || {
                let _ = tell.send(make(&source, &changes, options));
            };
            if let Err(e) = std::thread::Builder::new().name("ca model".into()).spawn(start) {
                return Some(Err(format!("no thread to make the model: {e}")));
            }
            self.making = Some(making);
        }
        made
    }
}

/// Reads and compiles.
fn make(source: &Source, changes: &[(String, String)], options: Options) -> Result<Made, String> {
    let words = |e: Failure| match e {
        Failure::Usage(text) | Failure::Failed(text) => text,
        Failure::Found(found) => render::text(&found.diags, &found.model, false),
        Failure::Stopped => "stopped".into(),
    };
    let mut loaded = load::load(&source.model).map_err(words)?;
    let changes: Vec<_> = source.changes().chain(changes.iter().cloned()).collect();
    for (name, value) in &changes {
        load::set_typed(&mut loaded, name, value).map_err(words)?;
    }
    let options = Options { clouds: loaded.clouds.clone(), ..options };
    let compiled = load::scene(&loaded, &options).map_err(words)?;
    let drawing = Arc::new(Drawing::new(&compiled.scene));
    let mut warnings = compiled.findings;
    warnings.list.retain(|d| d.severity == Severity::Warning);
    let said = if warnings.list.is_empty() { String::new() } else { render::text(&warnings, &loaded.model, false) };
    let model = ModelText::of(&loaded.model, changes);
    let version = Version { scene: Arc::new(compiled.scene), model, options, moved: Vec::new() };
    Ok(Made { version, drawing, said })
}
