//! The depth at which slope·T²/m of a power-law contact is 1 (docs/numerics.md §3.2).

use super::thresholds::link;
use ca_compile::{Options, compile};
use ca_conformance::random_parameters::catalog;
use ca_model::read;
use std::f64::consts::PI;

/// The certificate names the power-law contact that reaches slope·T²/m = 1 at the smallest depth, and that depth.
/// Closed forms: a gram before a wall, two that meet, and one held by a spring.
#[test]
fn the_depth_of_a_contact_that_hardens() {
    let depth = |text: &str| {
        let (model, _) = read::read(text, "test.ca.toml", &catalog());
        compile(&model, &catalog(), &Options::default()).expect(text).scene.certificate.rules.depth
    };
    let (q, t) = (3e6, 1.0 / 48e3);
    let at = |p: f64, m: f64| (m / (p * q * t * t)).powf(1.0 / (p - 1.0));
    for p in [1.25, 1.5, 2.0, 3.0] {
        let wall = link("HRZ", &format!("k = {q:?}, p = {p:?}"));
        let (name, of) = depth(&wall).expect("it hardens");
        assert!(name == "l" && (of / at(p, 1e-3) - 1.0).abs() < 1e-9, "{p}: {of} m, not {} m", at(p, 1e-3));
        let two = wall.replace("wall = {}", "floor = {}").replace("[MAS]\n", "[MAS]\nwall = { m = \"1 g\" }\n");
        let (_, of) = depth(&two).expect("it hardens");
        assert!((of / at(p, 0.5e-3) - 1.0).abs() < 1e-9, "{p}: {of} m, not {} m", at(p, 0.5e-3));
        // the steeper of two contacts is named
        let both = format!("{wall}softer = {{ between = [\"wall\", \"bob\"], k = {:?}, p = {p:?} }}\n", q / 2.0);
        assert_eq!(depth(&both).expect("they harden").0, "l");
    }
    // a mass on a spring is easier to move: 1 − a/4 of its mass
    let held = "[CEL]\nbob = { m = \"1 g\", f = \"12 kHz\" }\n[SOL]\nwall = {}\n[SOX]\nout = { from = \"bob\" }\n[HRZ]\nl = { \
                between = [\"wall\", \"bob\"], k = 3e6, p = 1.5 }\n";
    let a = 2.0 - 2.0 * (2.0 * PI * 12e3 / 48e3).cos();
    let of = depth(held).expect("it hardens").1;
    assert!((of / at(1.5, 1e-3 * (1.0 - a / 4.0)) - 1.0).abs() < 1e-9, "{of} m");
    assert_eq!(depth(&link("HRZ", "k = 1e-90, p = 1.25")), None);
    // linear contacts have kT²/m, and contacts stable at any depth have neither
    assert_eq!(depth(&link("HRZ", "k = 3e6, p = 1")), None);
    assert_eq!(depth(&link("BUT", "k = 3e6")), None);
    assert_eq!(depth(&link("HRZ", "k = 3e6, method = \"stable\"")), None);
}
