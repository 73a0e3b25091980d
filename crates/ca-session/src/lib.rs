//! One playing instrument, as a page and a program use it, without operating system, threads and transport.
//!
//! [`protocol`] has a type for each message between the page of `ca play` and the program.
#![forbid(unsafe_code)]

pub mod protocol;
