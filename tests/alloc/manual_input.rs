//! Checks that input without a device allocates nothing: a grabbed mass, ports sent to a position, the model's own
//! gesture, and the change to another version of the scene.

use super::calls;
use ca_compile::{Options as Compile, compile};
use ca_haptic::engine::{Engine, EngineCommand, GLIDE, ManualEvent, ManualInput, Options, OwnGesture, Retired, Swap};
use ca_model::read;
use std::sync::Arc;

const TEXT: &str = r#"
[STRING]
s = { n = 30, f = "110 Hz", m = "1 g" }
[ENX]
finger = { x = "-1 mm" }
[ENF]
push = { to = "s[4]" }
[BUT]
touch = { between = ["finger", "s[8]"], k = 500 }
[SOX]
out = { from = "s[3]", gain = 100 }
[gesture]
push = [[0, 0], [0.1, 0.4], [0.2, 0]]
finger = [[0, -1e-3], [0.2, 0], [0.4, -1e-3]]
"#;

#[test]
fn hands_without_a_device_allocate_nothing() {
    let catalog = ca_tests::catalog();
    let (model, _) = read::read(TEXT, "string.ca.toml", &catalog);
    for energy in [false, true] {
        let options = Compile { energy, ..Compile::default() };
        let scene = Arc::new(compile(&model, &catalog, &options).expect("it compiles").scene);
        let input = |event: ManualEvent| event.to_input(&scene).expect("it can be done");
        let finger = scene.input("finger").expect("a port") as u32;
        let mut inputs: Vec<ManualInput> = Vec::new();
        for n in 0..4 {
            inputs.extend([input(ManualEvent::Grab(1, 11 - n)), input(ManualEvent::Grab(0, 12 + n))]);
            inputs.extend([0, 1].map(|finger| ManualInput::Pull(finger, [1e-3, f64::NAN, f64::INFINITY])));
            inputs.push(ManualInput::Play(Box::new(OwnGesture::new(&scene).expect("it has one"))));
            inputs.extend([
                ManualInput::Port(finger, -5e-4, GLIDE),
                ManualInput::Pull(1, [-2e-3, 0.0, 0.0]),
                ManualInput::Release(1),
                ManualInput::Release(0),
                ManualInput::Stop,
            ]);
        }
        inputs.reverse();
        let mut retired: Vec<Retired> = Vec::with_capacity(16);
        let mut e = Engine::new(scene.clone(), Vec::new(), Options::default());
        let counted = calls(|| {
            for n in 0..3000 {
                if n % 70 == 0 {
                    if let Some(input) = inputs.pop() {
                        retired.extend(e.command(EngineCommand::Manual(input)));
                    }
                }
                e.prepare();
                assert_eq!(e.answer().count(), 0);
                e.finish();
            }
        });
        assert_eq!((counted, retired.len(), inputs.len()), (0, 4, 0), "energy {energy}");
        assert!(!e.has_diverged() && e.state.x.iter().any(|x| x.abs() > 1e-6));
    }
}

#[test]
fn another_version_of_the_scene_allocates_nothing() {
    let catalog = ca_tests::catalog();
    let make = |text: &str| {
        let (model, _) = read::read(text, "string.ca.toml", &catalog);
        Arc::new(compile(&model, &catalog, &Compile::default()).expect("it compiles").scene)
    };
    let scenes = [make(TEXT), make(&TEXT.replace("n = 30", "n = 50")), make(&TEXT.replace("110 Hz", "90 Hz"))];
    let mut e = Engine::new(scenes[0].clone(), Vec::new(), Options::default());
    let swaps = (1..3).map(|k| {
        let swap =
            Swap::new(&scenes[k - 1], scenes[k].clone(), scenes[k].state(), &[], (k as u32, false)).expect("they fit");
        Box::new(swap)
    });
    let mut swaps: Vec<Box<Swap>> = swaps.rev().collect();
    let mut retired: Vec<Retired> = Vec::with_capacity(4);
    e.state.input[1] = 0.4;
    let counted = calls(|| {
        for n in 0..600 {
            if n % 200 == 100 {
                if let Some(swap) = swaps.pop() {
                    retired.extend(e.command(EngineCommand::Swap(swap)));
                }
            }
            assert_eq!(e.answer().count(), 0);
            e.finish();
        }
    });
    assert_eq!((counted, retired.len(), swaps.len()), (0, 1, 0));
    assert!(!e.has_diverged() && e.state.x.iter().any(|x| x.abs() > 1e-6));
}
