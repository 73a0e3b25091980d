//! Couplings of device ports, as stored in a take.
//!
//! A take stores the numbers themselves, because it must replay even if a later version chooses other couplings.

use ca_core::internal::scene::Coupling;

/// Writes JSON: for each coupling the name of its port, and its numbers in the shortest digits that read back exactly.
pub(super) fn write(couplings: &[Coupling]) -> String {
    let all: Vec<(&str, [String; 4])> = couplings
        .iter()
        .map(|c| (c.port.as_str(), [c.k, c.z, c.m, c.device_stiffness].map(|v| format!("{v:?}"))))
        .collect();
    serde_json::to_string(&all).unwrap_or_default()
}

/// Reads the text of `write`; `None` where it is invalid.
pub(super) fn read(text: &str) -> Option<Vec<Coupling>> {
    let all: Vec<(String, [String; 4])> = serde_json::from_str(text).ok()?;
    let number = |v: &String| v.parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
    let one = |(port, v): (String, [String; 4])| {
        let [k, z, m, felt] = v.each_ref().map(number);
        Some(Coupling { port, k: k?, z: z?, m: m?, device_stiffness: felt? })
    };
    all.into_iter().map(one).collect()
}
