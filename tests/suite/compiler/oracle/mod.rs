//! The compiled scene against the oracle, which plays the same text module by module.
//!
//! `build` reads the text into the plain modules of `network`, with `numbers`, `expand`, `bodies` and `waves`.
//! `interpreter` plays them, with `measure` and `outputs`. Kinds without their own definition are taken from their
//! record (`listed`).

mod bodies;
mod build;
mod expand;
mod interpreter;
mod listed;
mod measure;
mod network;
mod numbers;
mod outputs;
mod waves;

use self::build::build;
use self::network::{Law, Network};
use crate::play::{model, reference, within};
use ca_compile::{KernelClass, Options};
use ca_conformance::random_parameters::built;
use ca_core::{Scene, State, tick};
use ca_model::{Item, Model, Value};
use ca_tests::gesture;
use ca_tests::long_form::long_form;

/// Ticks to play: a second in the long form, else a quarter or less, but a twentieth beyond the first sound.
fn ticks(scene: &Scene, long: bool) -> usize {
    let second = scene.rate as usize;
    if long {
        return second;
    }
    let mut s = scene.state();
    let sounds = |_: &usize| {
        gesture(scene, &mut s);
        tick(scene, &mut s);
        s.output.iter().any(|v| *v != 0.0)
    };
    let first = (0..second).find(sounds).unwrap_or(second);
    (second * 20 / scene.mats().max(1)).min(second / 4).max(first + second / 20).min(second)
}

fn play(scene: &Scene, oracle: &mut Network, ticks: usize, mut each: impl FnMut(usize, &Network, &[f64], &State)) {
    let mut s = scene.state();
    let mut out = vec![0.0; oracle.channels()];
    assert_eq!(out.len(), scene.counts.channels);
    let places: Vec<usize> = oracle.ports.iter().map(|p| scene.input(&p.name).expect("a port")).collect();
    for n in 0..ticks {
        gesture(scene, &mut s);
        let inputs: Vec<f64> = places.iter().map(|p| s.input[*p]).collect();
        oracle.tick(&inputs, &mut out);
        tick(scene, &mut s);
        each(n, oracle, &out, &s);
    }
}

/// The model without output filters, which are tested elsewhere.
fn plain(text: &str) -> Model {
    let mut m = model(text);
    let outputs: Vec<String> =
        m.items.iter().filter(|i| matches!(i.kind.as_str(), "SOX" | "SOF")).map(|i| i.name.clone()).collect();
    for name in outputs {
        let heard = m.items.iter().find(|i| i.name == name).and_then(|i| i.args.iter().find(|e| e.key == "hear"));
        if heard.is_some_and(|e| e.value == Value::Text("acceleration".into())) {
            assert!(m.set(&format!("{name}.hear"), "speed"));
        }
        assert!(m.set(&format!("{name}.dc"), "0"));
    }
    if m.meta.iter().any(|e| e.key == "format") {
        assert!(m.set("model.method", "ca"));
    }
    // solved contacts are tested elsewhere: here they use the explicit method
    let solved: Vec<String> = m.items.iter().filter(|i| method(i) == Some("stable")).map(|i| i.name.clone()).collect();
    for name in solved {
        assert!(m.set(&format!("{name}.method"), "ca"));
    }
    m
}

fn method(i: &Item) -> Option<&str> {
    let found = i.args.iter().find(|e| e.key == "method")?;
    if let Value::Text(t) = &found.value { Some(t) } else { None }
}

/// Every model except those with parameters driven by ports or set-valued friction, which are tested elsewhere.
fn texts() -> Vec<(String, String)> {
    let driven = |m: &Model| m.params.iter().any(|p| format!("{:?}", p.value).contains("\"port\""));
    let sets = |m: &Model| m.items.iter().any(|i| method(i) == Some("set-valued"));
    let mut all = ca_tests::texts();
    all.retain(|(_, text)| {
        let m = model(text);
        !driven(&m) && !sets(&m)
    });
    all
}

#[test]
fn one_by_one_every_bit_is_that_of_a_plain_loop() {
    let long = long_form("the rest of a second");
    for (name, text) in texts() {
        let model = plain(&text);
        let scene = built(&model, &reference());
        let mut heard = 0.0f64;
        play(&scene, &mut build(&model), ticks(&scene, long), |n, _, out, s| {
            let same = out.iter().zip(&s.output).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same, "{name}, tick {n}: {out:?} is not {:?}", s.output);
            heard = out.iter().fold(heard, |m, v| m.max(v.abs()));
        });
        assert!(scene.counts.channels == 0 || heard > 0.0, "{name} is silent, which compares nothing");
    }
}

#[test]
fn in_batches_it_is_the_same_to_rounding() {
    let long = long_form("the rest of a second");
    for (name, text) in texts() {
        let model = plain(&text);
        let scene = built(&model, &Options { kernel: KernelClass::Fast, ..Options::default() });
        let (mut worst, mut peak, mut struck) = (0.0f64, 0.0f64, false);
        let mut power = [0.0, 0.0];
        play(&scene, &mut build(&model), ticks(&scene, long), |_, oracle, out, s| {
            for (a, b) in s.output.iter().zip(out) {
                assert!(a.is_finite());
                if !struck {
                    peak = peak.max(b.abs());
                    worst = worst.max((a - b).abs());
                }
                power[0] += a * a;
                power[1] += b * b;
            }
            // from the first force of a non-linear law on, rounding may grow
            struck |= oracle.links.iter().any(|l| l.f != 0.0 && !matches!(l.law, Law::Linear { .. }));
        });
        within(&format!("{name}, fast"), worst / peak.max(1e-300), 1e-12);
        if struck {
            // on a line a blow parts them slightly; in space the next blow falls elsewhere: within a factor of two
            let limit = if scene.symbols.iter().any(|s| s.axes > 1) { std::f64::consts::LN_2 } else { 1e-3 };
            within(&format!("{name}, power after the first impact"), (power[0] / power[1]).ln().abs(), limit);
        }
    }
}

#[test]
fn the_oracle_stays_small_enough_to_be_read() {
    let lines = include_str!("interpreter.rs").lines().count();
    assert!(lines <= 150, "the interpreter has {lines} lines");
}
