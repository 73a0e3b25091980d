//! Ways to go by: integrators, modes, and links that keep energy or only lose it.

mod friction;
mod hertz;
mod implicit;
mod modal;
mod modal_stable;
mod pefrl;
mod scheme;
pub mod stable;
