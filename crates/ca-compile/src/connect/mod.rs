//! Second step: resolves names to ends of links, outputs and moving points.

pub mod coupling;
mod measure;
pub mod outputs;
pub mod port_checks;
pub mod select;
pub mod sets;
mod unknown;
pub mod wire;
pub mod wiring;
