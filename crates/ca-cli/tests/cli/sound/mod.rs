//! What comes out: renders, files, reports, sweeps, benches.

mod bench;
pub mod degraded;
mod files;
mod render;
mod report;
pub mod sweep;
