//! Second: from names to ends. What is written between quotes becomes ends of links, taps of outputs and moving points.

pub mod coupling;
pub mod hands;
mod measure;
pub mod outputs;
pub mod select;
pub mod sets;
pub mod wire;
pub mod wiring;
