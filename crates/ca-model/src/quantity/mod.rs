//! Quantities: `"20 g"`, `"0.2 N s/m"`, `"1e8 N/m^1.5"`.
//!
//! A string that starts with a digit, a sign or a dot is a quantity; any other string may be the name of a `[param]`.
//! The number is correctly rounded: a prefix moves the decimal point in the text before it becomes a float, so `"20 g"`
//! is exactly the `f64` 0.02. Multiplication by 1e-3 would be one bit off for every third number, and the bits of a
//! model would depend on notation. Mechanics needs three exponents and six symbols, so no units library is used.

mod note;
mod read;
mod show;
mod units;
mod value;

pub use ca_core::internal::numeric::Plain;
pub use note::{near_note, note, note_name, note_number, note_of};
pub use read::{is_quantity, of_param, parse, product};
pub use show::{rounded, short, show, six, unit_of};
pub use value::{Quantity, QuantityError};
