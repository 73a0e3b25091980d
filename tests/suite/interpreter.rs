//! The compiled scene against the oracle, which plays the same text module by module.

use crate::oracle::Oracle;
use crate::play::{model, reference, with, within};
use ca_core::{KernelClass, Options, Scene, State, tick};
use ca_tests::{gesture, texts};

/// As many ticks as a second has, fewer where the scene is large: what is wrong shows in the first ones.
fn ticks(scene: &Scene) -> usize {
    (scene.rate as usize).min(40_000_000 / (scene.n_lia + scene.n_mat + 1)).max(2000)
}

fn play(scene: &Scene, oracle: &mut Oracle, mut each: impl FnMut(usize, &Oracle, &[f64], &State)) {
    let mut s = scene.state();
    let mut out = vec![0.0; oracle.channels()];
    assert_eq!(out.len(), scene.channels);
    let places: Vec<usize> = oracle.ports.iter().map(|p| scene.input(&p.name).expect("a port")).collect();
    for n in 0..ticks(scene) {
        gesture(scene, &mut s);
        let inputs: Vec<f64> = places.iter().map(|p| s.input[*p]).collect();
        oracle.tick(&inputs, &mut out);
        tick(scene, &mut s);
        each(n, oracle, &out, &s);
    }
}

#[test]
fn one_by_one_every_bit_is_that_of_a_plain_loop() {
    for (name, text) in texts() {
        let model = model(&text);
        let scene = with(&text, &reference());
        let mut heard = 0.0f64;
        play(&scene, &mut Oracle::new(&model), |n, _, out, s| {
            assert!(out == &s.output[..scene.channels], "{name}, tick {n}: {out:?} is not {:?}", s.output);
            heard = out.iter().fold(heard, |m, v| m.max(v.abs()));
        });
        assert!(scene.channels == 0 || heard > 0.0, "{name} is silent, which compares nothing");
    }
}

#[test]
fn in_batches_it_is_the_same_to_rounding() {
    for (name, text) in texts() {
        let model = model(&text);
        let scene = with(&text, &Options { kernel: KernelClass::Fast, ..Options::default() });
        let (mut worst, mut peak, mut struck) = (0.0f64, 0.0f64, false);
        let mut power = [0.0, 0.0];
        play(&scene, &mut Oracle::new(&model), |_, oracle, out, s| {
            for (a, b) in s.output.iter().zip(out) {
                assert!(a.is_finite());
                peak = peak.max(b.abs());
                if !struck {
                    worst = worst.max((a - b).abs());
                }
                power[0] += a * a;
                power[1] += b * b;
            }
            // from the first force of a law that bends on, rounding may grow
            struck |= oracle.lias.iter().any(|l| l.bends && l.f != 0.0);
        });
        within(&format!("{name}, fast"), worst / peak.max(1e-300), 1e-12);
        if struck {
            within(&format!("{name}, power after the first impact"), (power[0] / power[1] - 1.0).abs(), 1e-3);
        }
    }
}
