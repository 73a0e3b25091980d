//! Passes over links, one kernel for each way they stand: anywhere (`gather`), in a row (`run`), from one
//! place to a row (`fan`), in a row whose masses are
//! integrated too (`fused`, in eight lanes `folded`, a mesh `band`), in space (`space` by a [`measure`], in vectors `radial`), and all
//! pairs of two sets ([`pair_set`]). `choose` takes one for each form of a law.

mod band;
mod choose;
mod fan;
mod folded;
mod fused;
mod gather;
pub(super) mod law;
pub mod measure;
pub mod pair_set;
mod radial;
mod run;
mod space;
