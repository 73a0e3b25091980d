//! Lays out a compiled scene for pages that draw it, and gives the displacements that they need.
//!
//! `bodies` finds connected masses, `place` and `single_masses` put them in a `frame`, and `thin` selects nodes if there are
//! too many. The result is a [`Drawing`]; a [`Film`] records a performance for a page without a server. This crate does
//! not draw: the pages of `ca play` (`ca-play`) and of reports (`ca-report`) do.
#![forbid(unsafe_code)]

mod bodies;
mod drawing;
mod film;
mod frame;
mod graph;
mod graph_layout;
mod place;
mod single_masses;
mod thin;

pub use drawing::Drawing;
pub use film::Film;
