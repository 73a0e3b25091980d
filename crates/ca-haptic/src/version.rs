//! A version of a scene, with everything needed to compile it again.
//!
//! It holds the model as its author wrote it and the changes made to it, as the header of a take does. The compiler
//! options stay as at the start, except for the bodies that the model reads from files.

use ca_core::{Controls, Scene, State};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A model as text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelText {
    /// Name of its file, without the folder.
    pub file: String,
    /// Text as its author wrote it.
    pub text: String,
    /// Changes made to it, in order: name and value.
    pub changes: Vec<(String, String)>,
    /// Text with these changes applied, for people.
    pub resolved: String,
    /// Files from which it takes parts, by their paths from its folder.
    pub parts: BTreeMap<String, String>,
}

#[cfg(feature = "system")]
mod text {
    use super::ModelText;
    use ca_core::Catalog;
    use ca_core::internal::kind::cloud::Unread;
    use ca_model::diag::Diags;
    use ca_model::{Model, read, write};

    impl ModelText {
        /// Returns the text of `model`, to which `changes` were made.
        pub fn of(model: &Model, changes: Vec<(String, String)>) -> ModelText {
            let resolved = write::write(model);
            // a model built by a program has only the resolved text
            let built = model.text.is_empty();
            let file = model.file.rsplit(['/', '\\']).next().unwrap_or_default();
            ModelText {
                file: if file.is_empty() { "model.ca.toml" } else { file }.into(),
                text: if built { resolved.clone() } else { model.text.clone() },
                changes: if built { Vec::new() } else { changes },
                resolved,
                parts: model.files.iter().map(|f| (f.name.clone(), f.text.clone())).collect(),
            }
        }

        /// Parses the model without its changes, and returns it with its findings.
        pub fn read(&self, catalog: &Catalog) -> (Model, Diags) {
            read::read_with(&self.text, &self.file, catalog, &mut |name| {
                let missing = || Unread { what: format!("the attachment `{name}` is missing"), help: String::new() };
                self.parts.get(name).cloned().ok_or_else(missing)
            })
        }
    }
}

/// Another version of a playing scene.
pub struct Version {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its model.
    pub model: ModelText,
    /// Compiler options.
    #[cfg(feature = "system")]
    pub options: ca_compile::Options,
    /// Live parameters that were changed before, with their values \[SI\].
    pub moved: Vec<(String, f64)>,
    /// True if it starts as at load: no mass continues from its present position.
    pub restart: bool,
}

impl Version {
    /// Makes a version without a text. A take that holds it cannot be replayed.
    pub fn new(scene: Arc<Scene>, anew: bool) -> Version {
        Version {
            scene,
            model: ModelText::default(),
            #[cfg(feature = "system")]
            options: ca_compile::Options::default(),
            moved: Vec::new(),
            restart: anew,
        }
    }
}

/// Returns the initial state of `scene` and its parameters, with the values in `moved`.
///
/// A value out of range, or of a parameter that this scene lacks, is ignored.
pub fn begin(scene: &Scene, moved: &[(String, f64)]) -> (State, Controls) {
    let (mut controls, mut state) = (scene.controls(), scene.state());
    for (name, value) in moved {
        if let Ok(patch) = controls.set(name, *value) {
            state.apply(&patch, 1);
        }
    }
    (state, controls)
}
