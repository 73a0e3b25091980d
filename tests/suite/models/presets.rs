//! Presets of the bundled models: each sounds unlike the others, at a level that fits, and makes no energy.

use super::rendering::{file_names, load, perform, scene};
use crate::acoustics::{db, peak};
use std::collections::BTreeMap;

#[test]
fn every_preset_sounds_and_no_two_sound_alike() {
    let mut with_presets = 0;
    for name in file_names() {
        let presets: Vec<String> = load(&name).presets.iter().map(|p| p.key.clone()).collect();
        with_presets += usize::from(!presets.is_empty());
        let mut sounds: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
        for preset in &presets {
            let mut model = load(&name);
            assert!(model.set("preset", preset), "{name}: {preset}");
            let compiled = scene(&model, &[]);
            let seconds = compiled.about.seconds.expect("a model says how long it sounds");
            let sound = perform(model, &compiled, None, seconds).sound;
            let level = sound.iter().map(|c| db(peak(c))).fold(f64::MIN, f64::max);
            assert!((-30.0..=0.0).contains(&level), "{name}, {preset}: {level:.1} dBFS");
            let twin = sounds.iter().find(|(_, other)| **other == sound);
            assert!(twin.is_none(), "{name}: {preset} sounds as {:?}", twin.map(|t| t.0));
            sounds.insert(preset.clone(), sound);
        }
    }
    assert!(with_presets >= 2, "{with_presets}");
}
