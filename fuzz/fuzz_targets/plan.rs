//! Arbitrary bytes as a compiled scene: read it, and where it is accepted play, start and change it. The bytes become the record of a plan,
//! behind a good head, since a checksum would keep all others out.
//!
//! `cargo +nightly fuzz run plan`, from the root of the repository. Records make good seeds: what `Scene::to_bytes` writes, but for its
//! first 32 bytes.
#![no_main]

use ca_core::{PLAN_VERSION, ARITHMETIC, Scene, tick};
use ca_core::internal::state::checksum;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let length = (data.len() as u64).to_le_bytes();
    let head: [&[u8]; 5] =
        [b"ca plan\n", &PLAN_VERSION.to_le_bytes(), &ARITHMETIC.to_le_bytes(), &length, &checksum(data).to_le_bytes()];
    let bytes = [&head.concat(), data].concat();
    let catalog = ca_model::catalog().with(ca_lpr::KINDS);
    let Ok(scene) = Scene::from_bytes(&bytes, &catalog) else { return };
    let again = Scene::from_bytes(&scene.to_bytes(), &catalog).expect("what was accepted is written as a plan");
    assert_eq!(again.identity(), scene.identity());
    for mut s in [scene.state(), scene.state_from(|_| Some([1e-3, 1e-6]))] {
        (0..50).for_each(|_| tick(&scene, &mut s));
    }
    scene.symbols.iter().for_each(|symbol| drop(symbol.name.to_string()));
});
