//! Choices: parameters that take one of several words, as enums whose words stand beside their variants.
//!
//! A choice travels among the numeric arguments as the index of its word and becomes its enum where it is read, so code
//! never compares bare numbers. A separate argument type for words would put a case into every array of numbers. The
//! macro does not need `kind`, and modules below `kind` declare choices, so this module stands below all others.

/// Declares an enum whose variants have words. The first variant is the default.
///
/// ```
/// ca_core::choice! {
///     /// What holds the ends.
///     pub enum Ends {
///         /// a fixed point at each
///         Fixed = "fixed",
///         /// nothing
///         Free = "free",
///     }
/// }
/// assert_eq!(Ends::WORDS, ["fixed", "free"]);
/// assert_eq!((Ends::of(1.0), Ends::of(None)), (Ends::Free, Ends::Fixed));
/// ```
#[macro_export]
macro_rules! choice {
    ($(#[$about:meta])* $vis:vis enum $name:ident { $($(#[$doc:meta])* $variant:ident = $word:literal,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $name {
            $($(#[$doc])* $variant,)+
        }

        impl $name {
            /// Words in the order of the variants.
            pub const WORDS: &'static [&'static str] = &[$($word),+];

            /// Returns the variant with this index, or the last one if the index is too large. `None` gives the first.
            pub fn of(number: impl Into<Option<f64>>) -> $name {
                const ALL: &[$name] = &[$($name::$variant),+];
                ALL[number.into().map_or(0, |n| n as usize).min(ALL.len() - 1)]
            }
        }
    };
}

pub(crate) use choice;
