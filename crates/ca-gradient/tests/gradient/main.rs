//! Derivatives of outputs and energy, against closed forms and differences of renders in double precision.

mod closed_form;
mod energy;
mod few;
mod random_models;
mod reference;
mod refused;
mod reverse;
