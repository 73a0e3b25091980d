//! Presets of the scene that plays. A preset sets its live parameters in one tick.

use crate::host::Language;
use crate::refused::Refused;
use ca_core::internal::scene::PRESET;
use ca_haptic::control::Given;
use ca_haptic::serve::Recorder;

/// The name of the preset that a setting chooses, if `name` is not a live parameter but [`PRESET`].
pub fn chosen<'g>(recorder: &Recorder, name: &str, given: &'g Given) -> Option<&'g str> {
    let is_param = || recorder.controls().params().iter().any(|p| p.name == PRESET);
    match given {
        Given::Text(preset) if name == PRESET && !is_param() => Some(preset.trim()),
        _ => None,
    }
}

/// Live parameters and their values (SI) of a preset.
///
/// # Errors
/// If the scene lacks the preset.
pub fn values(recorder: &Recorder, language: &dyn Language, preset: &str) -> Result<Vec<(String, f64)>, Refused> {
    let presets = &recorder.scene().about.presets;
    if let Some((_, values)) = presets.iter().find(|p| p.0 == preset) {
        return Ok(values.clone());
    }
    let names: Vec<&str> = presets.iter().map(|p| p.0.as_str()).collect();
    let shown: String = preset.chars().take(80).collect();
    let hint = match language.nearest(&shown, &names) {
        Some(near) => format!("did you mean `{near}`?"),
        None if names.is_empty() => "the model has no presets; add one below `[preset.NAME]`".into(),
        None => format!("the presets are {}", names.join(", ")),
    };
    Err(format!("`{shown}` is not a preset of this model; {hint}").into())
}
