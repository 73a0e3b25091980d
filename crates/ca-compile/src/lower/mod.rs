//! First: from what is written to numbers in SI. Rates, parameters, media and the parameters of every item; MATs, ports
//! and generators become nodes of the network. Links wait for all names to be known ([`super::connect`]).

pub mod crossing;
pub mod curve;
pub mod equivalence;
pub mod expand;
pub mod lists;
pub mod lowpass;
pub mod named;
pub mod params;
pub mod ports;
mod product;
pub mod rates;
pub mod requirements;
pub mod resolve;
pub mod space;
pub mod values;
