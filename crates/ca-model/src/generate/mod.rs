//! Generators: one line of text that makes many modules. Each has a file and uses [`ca_core::internal::kind::builder`].
//!
//! The compiler expands them, never the author's file, and names remain indexable: `low[8]`, `low[-1]`, `low[*]`.
// all generators have functions of one type, even those that never fail
#![allow(clippy::unnecessary_wraps)]

use ca_core::Kind;
pub use ca_core::internal::kind::builder::{Arg, Args, Builder, Generator, Problem};

mod bank;
mod cloud;
mod grains;
mod mesh;
mod pose;
mod ring;
mod stiff;
mod string;
mod tetra;
mod waveguide;

/// All generator kinds, in the order of the documentation.
pub const KINDS: &[&Kind] = &[
    &string::STRING,
    &string::CHAIN,
    &ring::KIND,
    &stiff::KIND,
    &mesh::KIND,
    &bank::KIND,
    &waveguide::KIND,
    &tetra::KIND,
    &cloud::KIND,
    &grains::KIND,
];
