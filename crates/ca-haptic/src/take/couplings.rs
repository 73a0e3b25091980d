//! Couplings of device ports as a take holds them.
//!
//! A take holds the numbers themselves: a later version may choose other couplings, and a take has to replay as it was played.

use ca_core::internal::scene::Coupling;

/// JSON: of each coupling the name of its port, and its numbers in the shortest digits that read back as they were.
pub(super) fn write(couplings: &[Coupling]) -> String {
    let all: Vec<(&str, [String; 4])> =
        couplings.iter().map(|c| (c.port.as_str(), [c.k, c.z, c.m, c.felt].map(|v| format!("{v:?}")))).collect();
    serde_json::to_string(&all).unwrap_or_default()
}

/// The other way round; `None` where that is not what is there.
pub(super) fn read(text: &str) -> Option<Vec<Coupling>> {
    let all: Vec<(String, [String; 4])> = serde_json::from_str(text).ok()?;
    let number = |v: &String| v.parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
    let one = |(port, v): (String, [String; 4])| {
        let [k, z, m, felt] = v.each_ref().map(number);
        Some(Coupling { port, k: k?, z: z?, m: m?, felt: felt? })
    };
    all.into_iter().map(one).collect()
}
