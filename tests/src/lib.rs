//! Nothing lives here but the README, so that its Rust is compiled and run: the suite is in `suite/`.
#![doc = include_str!("../../README.md")]
