//! The modes of a model as JSON, as `ca modes --json` and the page show them.

use ca_compile::analysis::{Modes, Network};
use serde_json::{Value as Json, json};

/// Returns the sound rate of a network \[Hz\].
pub fn rate(network: &Network) -> f64 {
    1.0 / (network.tick_dt * f64::from(network.oversample))
}

/// Returns all modes with frequencies \[Hz\], decays \[s\], and values at the ports \[1/√kg\].
pub fn value(name: &str, network: &Network, found: &Modes) -> Json {
    let finite = |v: f64| if v.is_finite() { json!(v) } else { Json::Null };
    let list: Vec<Json> = found
        .list
        .iter()
        .map(|m| {
            let ports: serde_json::Map<String, Json> =
                network.ports.iter().map(|p| (p.name.clone(), json!(m.at(&p.at)))).collect();
            json!({
                "free_hz": m.f, "heard_hz": m.heard, "cents": m.cents(), "t60_s": finite(m.t60),
                "t60_free_s": finite(m.t60_free), "a": m.a, "b": m.b, "grows": m.grows, "coupled": m.coupled, "ports": ports,
            })
        })
        .collect();
    let ports: Vec<Json> = network.ports.iter().map(|p| json!({ "name": p.name, "role": p.role })).collect();
    let left_out: Vec<Json> =
        network.left_out.iter().map(|(name, code)| json!({ "name": name, "law": code })).collect();
    json!({
        "name": name, "rate": rate(network), "oversample": network.oversample, "places": network.names, "ports": ports,
        "left_out": left_out, "unheard": network.unheard,
        "approximate": found.approximate, "force_outputs": network.force_outputs, "modes": list,
    })
}
