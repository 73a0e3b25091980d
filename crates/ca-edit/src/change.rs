//! Writes a changed number or word of a model into its text, as `--set` names it.

use crate::{Document, Place, Value};
use ca_model::Model;

/// Writes the value of `name` at its one place in the text of `model`, and adds it if the text leaves it out.
///
/// # Errors
/// If the text has no such place, or several, or if the value is not a number or a word.
pub fn write_change(text: &mut Document, model: &Model, name: &str, value: &str) -> Result<(), String> {
    let place = match name.split_once('.') {
        Some((section @ ("model" | "rate"), key)) => Place::keys([section, key]),
        _ => Place::of(model, name).map_err(|e| e.to_string())?,
    };
    let value = match ca_model::Value::typed(value) {
        ca_model::Value::Num(v) => Value::Number(v),
        ca_model::Value::Text(t) => Value::Text(t),
        _ => return Err(format!("`{value}` is not a number or a word")),
    };
    text.insert(&place, &value).ok_or_else(|| format!("`{name}` is not in the text of the model"))
}
