//! The command `ca`.
#![forbid(unsafe_code)]

fn main() {}
