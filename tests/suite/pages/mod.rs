//! Measured pages: each says what its bench makes, and no more.

mod accuracy;
mod atlas;
mod begin;
mod beside;
mod costs;
mod instruments;
