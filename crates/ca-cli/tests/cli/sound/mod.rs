//! Tests of commands that produce a sound, a page or a table: render, report, sweep, bench.

mod bench;
pub mod divergence_and_clipping;
mod files;
mod midi;
mod pipes;
mod render;
mod report;
pub mod sweep;
