//! The sections that can stand at the root of a document besides kinds, and the keys they know.

/// Root sections that are not kinds, in the order [`super::write`] gives them.
pub const SECTIONS: &[&str] = &["model", "rate", "param", "gesture", "equivalence"];
/// Keys of `[model]`.
pub const META: &[&str] = &[
    "title",
    "author",
    "source",
    "doc",
    "units",
    "reference_rate",
    "gravity",
    "friction",
    "method",
    "theta",
    "seconds",
    "start",
];
/// Keys of `[rate]`.
pub const RATES: &[&str] = &["sound", "oversample", "gesture", "border", "latency", "feedback", "filter"];
/// Properties of a group.
pub const GROUP: &[&str] = &["gravity", "friction", "method", "theta", "dim"];
