//! Models published by other people, played by our gestures: imported, written, read back, compiled, played. They are
//! read if they lie beside the project; the project's own tests use our own models.

use crate::acoustics::{cents, partial, peak, period, rms};
use ca_compile::{Options, compile};
use ca_core::Scene;
use ca_import::mims;
use ca_io::gesture::{Gesture, Track};
use ca_io::perform::Performance;
use ca_model::{read, render, write};
use ca_tests::catalog;
use ca_tests::skipped::skipped;
use std::path::PathBuf;

/// The scene of a published model, through the text that `ca import` writes; `None` if the model is missing.
#[track_caller]
fn published(name: &str) -> Option<Scene> {
    let dir = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/mims");
    let Ok(text) = std::fs::read_to_string(dir.join(format!("{name}.mdl"))) else {
        skipped("published models", &format!("no {name}.mdl in shared/data/mims beside the project"));
        return None;
    };
    let (model, notes) = mims::import(&text, name);
    assert!(!notes.has_errors(), "{name}: {notes}");
    let written = write::write(&model);
    let (model, findings) = read::read(&written, name, &catalog());
    assert!(findings.list.is_empty(), "{}", render::text(&findings, &model, false));
    Some(
        compile(&model, &catalog(), &Options::default())
            .unwrap_or_else(|d| panic!("{}", render::text(&d, &model, false)))
            .scene,
    )
}

/// Outputs while `in1` follows `points`.
fn play(scene: &Scene, points: &[(f64, f64)], seconds: f64) -> Vec<Vec<f64>> {
    let gesture = Gesture::new(vec![Track::points("in1", points.to_vec()).unwrap()]).unwrap();
    let mut p = Performance::new(scene, Some(&gesture)).unwrap();
    let n = (seconds * scene.rate) as usize;
    let mut out = vec![Vec::with_capacity(n); scene.counts.channels];
    for _ in 0..n {
        p.tick();
        for (o, v) in out.iter_mut().zip(&p.state.output) {
            o.push(*v);
        }
    }
    assert!(!p.diverged && out.iter().flatten().all(|v| v.is_finite()));
    out
}

/// Frequency of mode `j` of `n` masses of stiffness ratio `a`, fixed at both ends (docs/numerics.md §1.2).
fn chain(n: usize, a: f64, j: usize, rate: f64) -> f64 {
    let s = (j as f64 * std::f64::consts::FRAC_PI_2 / (n as f64 + 1.0)).sin();
    rate / std::f64::consts::PI * (a.sqrt() * s).asin()
}

#[test]
fn the_bowed_string_sings_at_its_pitch() {
    let Some(scene) = published("BowedString") else { return };
    // the bow starts where the model puts it and moves at 2.5e-5 a sample, where its friction falls with speed
    let speed = 2.5e-5 * scene.rate;
    let out = play(&scene, &[(0.0, 1.0), (4.0, 1.0 + 4.0 * speed)], 4.0);
    let tail = &out[0][(2.0 * scene.rate) as usize..];
    let mean = tail.iter().sum::<f64>() / tail.len() as f64;
    let heard: Vec<f64> = tail.iter().map(|v| v - mean).collect();
    let early = rms(&out[0][..(0.01 * scene.rate) as usize]);
    assert!(rms(&heard) > 10.0 * early, "it swells: {} after {early}", rms(&heard));
    let f = chain(150, 0.3, 1, scene.rate);
    let (seconds, likeness) = period(&heard[..heard.len().min(20_000)], scene.rate, 0.7 / f, 1.4 / f);
    assert!(likeness > 0.9, "not periodic: {likeness}");
    assert!((1.0 / seconds / f - 1.0).abs() < 0.05, "{} Hz instead of {f}", 1.0 / seconds);
}

#[test]
fn the_thousand_mass_string_carries_a_pluck() {
    let Some(scene) = published("1000massString") else { return };
    let at = 0.01;
    let out = play(&scene, &[(0.0, 0.0), (at, 0.0), (at + 0.002, 0.2)], 0.2);
    // over 60 masses, at √a masses a sample, the wave needs 190 samples; viscosity lets a little run ahead
    let top = peak(&out[0]);
    let onset = out[0].iter().position(|v| v.abs() > 0.02 * top).unwrap() as f64 - at * scene.rate;
    assert!(top > 1e-4, "silent: {top}");
    assert!((175.0..330.0).contains(&onset), "it arrives {onset} samples after the pluck began");
}

#[test]
fn the_mesh_rings_after_a_push() {
    let Some(scene) = published("20x30mesh") else { return };
    let out = play(&scene, &[(0.0, 0.0), (0.001, 1.0), (0.002, 0.0)], 0.5);
    for channel in &out {
        assert!(peak(channel) > 1e-3, "silent");
        let late = &channel[(0.3 * scene.rate) as usize..];
        assert!(rms(late) > 1e-4 * peak(channel), "it does not ring");
    }
}

#[test]
fn the_resonator_answers_at_its_modes() {
    let Some(scene) = published("Resonator") else { return };
    // its end is shaken at the second mode of 30 masses between the driven end and the ground
    let f = chain(30, 0.1, 2, scene.rate);
    let shake = |f: f64| {
        let points: Vec<(f64, f64)> = (0..8000)
            .map(|n| {
                let t = f64::from(n) / 16_000.0;
                (t, 1e-3 * (std::f64::consts::TAU * f * t).sin())
            })
            .collect();
        rms(&play(&scene, &points, 0.5)[0][8000..])
    };
    assert!(shake(f) > 3.0 * shake(1.3 * f), "no resonance at {f} Hz: {} against {}", shake(f), shake(1.3 * f));
}

#[test]
fn the_triangle_sounds_when_plucked() {
    let Some(scene) = published("IPlayTheTriangle") else { return };
    let out = play(&scene, &[(0.0, 0.0), (0.005, 0.05)], 0.1);
    let free = &out[0][(0.006 * scene.rate) as usize..];
    assert!(peak(free) > 1e-6, "silent: {}", peak(free));
    // three equal masses in a ring of k = 0.1, one tied to the ground by 0.05: an even pair moves at 3k
    let f = scene.rate / std::f64::consts::PI * (0.5 * 0.3_f64.sqrt()).asin();
    let (at, _) = partial(free, scene.rate, f, 100.0);
    assert!(cents(at, f).abs() < 30.0, "{at} Hz instead of {f}");
}
