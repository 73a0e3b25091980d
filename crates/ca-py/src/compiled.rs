//! A scene and the model that it was compiled from, without a class of Python around them.
//!
//! Renders and derivatives take this record, and not the class `Scene`, since the class itself offers them as methods.

use ca_compile::Options;
use ca_lab::load::Loaded;
use ca_model::diag::Diags;
use std::sync::Arc;

/// A scene, and how it was made.
pub struct CompiledModel {
    pub scene: Arc<ca_core::Scene>,
    /// of reader and compiler
    pub found: Diags,
    /// what it was compiled from
    pub loaded: Loaded,
    /// how it was compiled
    pub options: Options,
}
