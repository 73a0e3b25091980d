//! Measured pages agree with their benches.

mod accuracy;
mod atlas;
mod begin;
mod beside;
mod costs;
mod instruments;
