//! Second step: resolves names to ends of links, outputs and moving points.

pub mod coupling;
pub mod hands;
mod measure;
pub mod outputs;
pub mod select;
pub mod sets;
pub mod wire;
pub mod wiring;
