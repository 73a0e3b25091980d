//! Every form of a law, batch or run or single link, computes the same.

use super::drawn::{MASSES, built, row, ways};
use crate::play::{Dice, mat, reference, scene};
use ca_core::{Options, tick};

#[test]
fn all_forms_of_a_law_give_the_same_bits() {
    let mut seen = std::collections::BTreeSet::new();
    for (kind, way) in ways() {
        for apart in [false, true] {
            for seed in 1..6 {
                let m = row(kind, way, apart, &mut Dice(seed * 977));
                let forms = [
                    reference(),
                    Options::default(),
                    Options { energy: true, ..Options::default() },
                    Options { energy: true, ..reference() },
                    Options { probes: vec!["l2".into(), "l11".into()], ..Options::default() },
                ];
                let play = |o: &Options| {
                    let scene = built(&m, o);
                    scene.forces.iter().filter(|o| o.law.is_some()).for_each(|o| {
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

#[test]
fn a_plectrum_lets_go_once_per_passage() {
    for seconds in [0.02, 0.3, 2.0] {
        let text = "[CEL]\nreed = { m = \"1 g\", f = \"220 Hz\", t60 = \"0.05 s\" }\n[ENX]\nplectrum = { x = \"-3 mm\" }\n\
             [PLK]\npluck = { between = [\"reed\", \"plectrum\"], k = \"2 kN/m\", z = \"0.05 N s/m\", d = \"1 mm\" }\n\
             [SOX]\nout = { from = \"reed\", gain = 500 }\n";
        let scene = scene(text);
        let mut s = scene.state();
        let (mut releases, mut takes) = (0, 0);
        let passage = (seconds * scene.rate) as u64;
        for n in 0..4 * passage {
            let u = (n % passage) as f64 / passage as f64;
            let up = (n / passage).is_multiple_of(2);
            s.input[0] = 6e-3 * (u - 0.5) * if up { 1.0 } else { -1.0 };
            let (held, last) = (s.mem[0], s.mem[1]);
            tick(&scene, &mut s);
            releases += u32::from(held == 1.0 && s.mem[0] == 0.0);
            if held == 0.0 && s.mem[0] == 1.0 {
                takes += 1;
                assert!(last * s.mem[1] <= 0.0, "it takes hold where it passes the reed, not before");
            }
        }
        assert_eq!((takes, releases), (4, 4), "4 passages of {seconds} s");
    }
}
