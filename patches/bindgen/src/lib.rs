//! Nothing: iceoryx2 0.10 names bindgen as a build dependency for all systems and runs it for QNX alone.
//!
//! Decides that a cold build does not compile it, clang-sys, and two parsers with their regular expressions, to call none of
//! them. The patch in `.cargo/config.toml` is to go with the first iceoryx2 that names bindgen for QNX alone; a build for QNX
//! removes it.
