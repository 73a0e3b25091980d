//! All of the suite in one binary: one folder for each topic, one file for each theme.

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
