//! Every form of a law, batch, run or single link, gives the same result.

use crate::play::{Random, mat, reference};
use crate::random_parameters::{MASSES, built, methods, row};
use ca_compile::Options;
use ca_core::tick;

#[test]
fn all_forms_of_a_law_give_the_same_bits() {
    let mut seen = std::collections::BTreeSet::new();
    // with a method, laws of two worlds and falling laws are refused on shared masses
    let alone = |kind: &str, way: &str| (kind.starts_with("LPR") || kind == "ATT") && way != "ca";
    for (kind, way) in methods().into_iter().filter(|(kind, way)| !alone(kind.code, way)) {
        for apart in [false, true] {
            for seed in 1..6 {
                let m = row(kind, way, apart, &mut Random(seed * 977));
                let forms = [
                    reference(),
                    Options::default(),
                    Options { energy: true, ..Options::default() },
                    Options { energy: true, ..reference() },
                    Options { probes: vec!["l2".into(), "l11".into()], ..Options::default() },
                ];
                let play = |o: &Options| {
                    let scene = built(&m, o);
                    scene.passes.forces.iter().filter(|o| o.law.is_some()).for_each(|o| {
                        seen.insert((o.form.stride > 0, o.form.offset, o.form.tap));
                    });
                    let places: Vec<usize> = (0..MASSES).map(|i| mat(&scene, &format!("m{i}"))).collect();
                    let mut s = scene.state();
                    (0..1000).for_each(|_| tick(&scene, &mut s));
                    places.iter().map(|p| (s.x[*p].to_bits(), s.d[*p].to_bits())).collect::<Vec<_>>()
                };
                let mut play = play;
                let first = play(&forms[0]);
                for form in &forms[1..] {
                    assert_eq!(play(form), first, "{} {way} {form:?}", kind.code);
                }
            }
        }
    }
    assert_eq!(seen.len(), 8, "not every form was played: {seen:?}");
}
