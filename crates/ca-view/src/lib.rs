//! What of a compiled scene is drawn, and where: for a page that shows it, and for the displacements it then needs.
//!
//! `bodies` finds what hangs together, `place` and `loose` say where it stands in which `frame`, `thin` what of too much is
//! shown; [`Drawing`] is what comes of it, and [`Film`] keeps a performance for a page without a server.
//!
//! What is not here: nothing draws. Pages do, with what this crate gives them: that of `ca play` in `ca-play`, and reports in `ca-report`.
#![forbid(unsafe_code)]

mod bodies;
mod drawing;
mod film;
mod frame;
mod graph;
mod loose;
mod place;
mod spread;
mod thin;

pub use drawing::Drawing;
pub use film::Film;
