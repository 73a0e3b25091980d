//! Model language, for sessions.

use ca_core::{LiveParam, Scene};
use ca_lab::facts::certificate;
use ca_model::{quantity, suggest};
use ca_session::Language;

/// Parses quantities and suggests names as models write them.
pub struct ModelLanguage;

impl Language for ModelLanguage {
    fn value(&self, param: &LiveParam, text: &str) -> Result<f64, ca_session::Refused> {
        quantity::of_param(&param.name, param.unit, text).map_err(Into::into)
    }

    fn nearest(&self, word: &str, names: &[&str]) -> Option<String> {
        suggest::nearest(word, names.iter().copied()).map(Into::into)
    }

    fn stability(&self, scene: &Scene) -> String {
        certificate::stability(&scene.certificate)
    }
}
