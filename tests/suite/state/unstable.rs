//! Drawn models that the certificate calls unstable grow from a push of a nanometre, also where solved links hold some
//! of the masses.

use super::soak::{Line, line};
use crate::compiler::certificate::grows;
use crate::play::scene;
use ca_core::Level;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::Cell;

/// Returns whether the model is called unstable at `above` times the limit; then it must grow.
fn unstable(line: &Line, above: f64) -> bool {
    let bound = scene(&line.text(1.0)).certificate.bound;
    let text = line.text(above * 4.0 / bound.max(1e-9));
    let scene = scene(&text);
    let unstable = scene.certificate.level == Level::Unstable;
    assert!(!unstable || grows(&scene), "{:?}\n{text}", scene.certificate);
    unstable
}

#[test]
fn what_is_unstable_grows() {
    let long = ca_tests::long_form::long_form("nineteen of twenty scenes that are called unstable");
    let (cases, seen) = (if long { 10_000 } else { 500 }, Cell::new(0));
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    let played = TestRunner::new(config).run(&(line(), 1.02..4.0), |(line, above)| {
        seen.set(seen.get() + u32::from(unstable(&line, above)));
        Ok(())
    });
    played.unwrap_or_else(|e| panic!("{e}"));
    assert!(seen.get() > cases / 10, "{} of {cases}", seen.get());
}

/// A damper too large for its mass of 1 mg, with and without a solved spring to a mass of 10 g.
#[test]
fn a_damper_on_a_light_mass_is_held_by_a_solved_spring() {
    let text = |method: &str| {
        format!(
            "[SOL]\ng = {{}}\n[MAS]\na = {{ m = 1e-6, v = 1 }}\nb = {{ m = 1e-2 }}\n\
             [FRO]\nd = {{ between = [\"g\", \"a\"], z = 0.15 }}\n\
             [CUB]\nc = {{ between = [\"a\", \"b\"], k = 1e7, k3 = 1e7, method = \"{method}\" }}\n\
             [SOX]\no = {{ from = \"a\" }}\n"
        )
    };
    let [held, free] = ["stable", "ca"].map(|method| scene(&text(method)));
    assert_eq!((held.certificate.level, free.certificate.level), (Level::NotProven, Level::Unstable));
    assert!(!grows(&held) && grows(&free));
}

/// A live spring that is too stiff only at its largest value is not called unstable.
#[test]
fn a_live_spring_is_unstable_only_if_it_is_so_at_every_value() {
    let text = |live: bool| {
        let value = if live { 1e7 } else { 2e7 };
        format!(
            "[param]\nk = {{ value = {value:e}, min = 1e6, max = 2e7, live = {live} }}\n[SOL]\ng = {{}}\n[MAS]\n\
             a = {{ m = 2e-3, v = 1 }}\n[RES]\nr = {{ between = [\"g\", \"a\"], k = \"k\" }}\n[SOX]\no = {{ from = \"a\" }}\n"
        )
    };
    let [live, fixed] = [true, false].map(|live| scene(&text(live)).certificate.level);
    assert_eq!((live, fixed), (Level::NotProven, Level::Unstable));
}
