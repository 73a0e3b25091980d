//! The whole suite in one binary, one folder for each thing that is tested across crates, one file per theme.

mod compiler;
mod generators;
mod hand;
mod language;
mod laws;
mod methods;
mod models;
mod outside;
mod pages;
mod rates;
mod skipped;
mod space;
mod state;

use ca_benches::acoustics;
use ca_conformance::play;
