//! Derivatives of outputs and energy, against closed forms and differences of renders in double precision.

mod closed;
mod drawn;
mod energy;
mod few;
mod reference;
mod refused;
mod reverse;
