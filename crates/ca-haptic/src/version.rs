//! A version of a scene's model: all that is needed to make the scene again, beside it.
//!
//! Decides that it holds the model as its author wrote it and the changes made to it, as the header of a take does; what was
//! asked of the compiler stays as at the start, but for the bodies that the model reads from files.

use ca_core::{Controls, Scene, State};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A model as text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelText {
    /// name of its file, without its folder
    pub file: String,
    /// as its author wrote it
    pub text: String,
    /// what was changed besides, in order: name and value
    pub changes: Vec<(String, String)>,
    /// with these changes, for people
    pub resolved: String,
    /// the files that it takes parts from, by their paths from its folder
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
        /// Of `model`, to which `changes` were made.
        pub fn of(model: &Model, changes: Vec<(String, String)>) -> ModelText {
            let resolved = write::write(model);
            // a model that a program built has only this text
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

        /// The model, without its changes, with what its reader found.
        pub fn read(&self, catalog: &Catalog) -> (Model, Diags) {
            read::read_with(&self.text, &self.file, catalog, &mut |name| {
                let missing = || Unread { what: format!("`{name}` is not attached to it"), help: String::new() };
                self.parts.get(name).cloned().ok_or_else(missing)
            })
        }
    }
}

/// Another version of a scene that plays.
pub struct Version {
    /// the scene
    pub scene: Arc<Scene>,
    /// its model
    pub model: ModelText,
    /// what was asked of the compiler
    #[cfg(feature = "system")]
    pub options: ca_compile::Options,
    /// live parameters that somebody had moved before, and their values \[SI\]
    pub moved: Vec<(String, f64)>,
    /// begins as at load: no mass goes on from where it is
    pub anew: bool,
}

impl Version {
    /// A version without a text. A take that holds it cannot be played again.
    pub fn new(scene: Arc<Scene>, anew: bool) -> Version {
        Version {
            scene,
            model: ModelText::default(),
            #[cfg(feature = "system")]
            options: ca_compile::Options::default(),
            moved: Vec::new(),
            anew,
        }
    }
}

/// The state in which `scene` begins, and its parameters, where `moved` stay as they are. One that is out of the range of this
/// scene, or is none of it, is as the scene says.
pub fn begin(scene: &Scene, moved: &[(String, f64)]) -> (State, Controls) {
    let (mut controls, mut state) = (scene.controls(), scene.state());
    for (name, value) in moved {
        if let Ok(patch) = controls.set(name, *value) {
            state.apply(&patch, 1);
        }
    }
    (state, controls)
}
