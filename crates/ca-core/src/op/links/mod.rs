//! Passes over links, with one kernel per arrangement: any ends (`gather`), a row (`run`), one MAT to a row (`fan`), a
//! row with integration of its masses (`fused`; in eight lanes `folded`; a mesh `band`), in space (`space` with a
//! [`measure`], in vectors `radial`), and all pairs of two sets ([`pair_set`]). `select_kernel` selects the kernel for each
//! form of a law.

mod band;
mod fan;
mod folded;
mod fused;
mod gather;
pub(super) mod law;
pub mod measure;
pub mod pair_set;
mod radial;
mod run;
mod select_kernel;
mod space;
