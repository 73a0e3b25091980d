//! Models in the formats of others.
//!
//! Decides on a crate of its own: nobody who reads a model of ours pays for the grammars of other programs, and each
//! format is a folder that knows the language ([`ca_model`]) and nothing of the compiler.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

pub mod mims;
