//! First step: converts the text of a model to numbers in SI.
//!
//! It reads rates, parameters, media and the parameters of every item. MATs, ports and generators become nodes of the
//! network. Links follow in [`super::connect`], when all names are known.

pub mod curve;
pub mod equivalence;
pub mod expand;
pub mod lists;
pub mod lowpass;
pub mod params;
pub mod parsed_param;
pub mod ports;
pub mod preset;
mod product;
pub mod rate_options;
pub mod rates;
pub mod requirements;
pub mod resolve;
pub mod space;
pub mod values;
