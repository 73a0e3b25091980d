//! Choices: a parameter that is one word of several, as an enum with its words beside the variants.
//!
//! Decides that a choice travels among the other arguments as the number of its word and becomes its enum where it is
//! read, so that nothing is compared with a bare number. The alternative, an argument of its own type for words, would
//! put a case into every array of numbers that a law is loaded from. The macro needs nothing of what a kind is, so it stands
//! below all other modules, some of which come before kinds.

/// Declares an enum of words, first the one that holds if nothing is written.
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
            /// The words, in the order of the variants.
            pub const WORDS: &'static [&'static str] = &[$($word),+];

            /// The choice of a number of a word; the first where there is none.
            pub fn of(number: impl Into<Option<f64>>) -> $name {
                const ALL: &[$name] = &[$($name::$variant),+];
                ALL[number.into().map_or(0, |n| n as usize).min(ALL.len() - 1)]
            }
        }
    };
}

pub(crate) use choice;
