//! One second of a model by the native engine, as `second.js` plays it.

use ca_web::engine::WebEngine;
use serde_json::{Value, json};
use std::time::Instant;

/// Number of samples, their FNV-1a hash in 32 bits by words, and the time \[ms\].
pub struct Second {
    pub samples: Value,
    pub hash: Value,
    pub ms: f64,
}

impl Second {
    pub fn json(&self) -> (&Value, &Value) {
        (&self.samples, &self.hash)
    }
}

pub fn native(file: &str, text: &str) -> Second {
    let model = json!({"type": "compile", "file": file, "text": text});
    let (object, plan) = ca_web::compiler::answer(model.to_string().as_bytes(), &[]);
    let facts = serde_json::from_value(object["facts"].clone()).expect("facts");
    let mut engine = WebEngine::open(&plan, &facts).expect("a plan");
    engine.request(br#"{"type": "gesture", "play": true}"#);
    let shape = engine.shape();
    let (mut sound, began) = (Vec::new(), Instant::now());
    for _ in 0..(shape.rate / f64::from(shape.frame)).ceil() as u32 {
        sound.extend_from_slice(engine.play(1));
        while engine.next_message().is_some() {}
    }
    let ms = began.elapsed().as_secs_f64() * 1e3;
    let hash = sound.iter().fold(0x811c_9dc5_u32, |hash, x| (hash ^ x.to_bits()).wrapping_mul(0x0100_0193));
    Second { samples: json!(sound.len()), hash: json!(hash), ms }
}
