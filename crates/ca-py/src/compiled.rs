//! A compiled scene and its model, without a Python class.
//!
//! Renders and derivatives take this record instead of the class `Scene`, which offers them as methods.

use ca_compile::Options;
use ca_lab::load::Loaded;
use ca_model::diag::Diags;
use std::sync::Arc;

/// A scene with its model and compile options.
pub struct CompiledModel {
    pub scene: Arc<ca_core::Scene>,
    /// Findings of reader and compiler.
    pub found: Diags,
    /// The model it was compiled from.
    pub loaded: Loaded,
    pub options: Options,
}
