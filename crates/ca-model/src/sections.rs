//! Sections at the root of a document other than kinds, and their keys.

/// Root sections that are not kinds, in the order of [`super::write`].
pub const SECTIONS: &[&str] = &["model", "rate", "param", "part", "use", "gesture", "preset", "equivalence"];
/// Keys of `[model]`.
pub const META: &[&str] = &[
    "format",
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
pub const GROUP: &[&str] = &["gravity", "friction", "method", "theta", "dim", "rate", "border"];
/// Root sections that may also stand in a part.
pub const IN_PART: &[&str] = &["param", "use", "gesture"];
/// Keys of a line of `[use]`.
pub const USE: &[&str] = &["part", "file", "n", "with"];
/// Keys that mark a gesture written as a table, each with the keys it combines with.
pub const CURVES: &[(&str, &[&str])] = &[
    ("points", &["every", "to"]),
    ("ramp", &["from", "to"]),
    ("sine", &["f", "phase", "offset", "from", "to"]),
    ("noise", &["f", "seed", "offset", "from", "to"]),
    ("pulse", &["at", "every", "rise", "hold", "fall", "offset", "to"]),
    ("follow", &["gain", "delay", "offset"]),
    ("sum", &[]),
];
