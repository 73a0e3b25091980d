//! Compares a voice with ticks of its scene: sound, ports, forces, live parameters, arguments out of range.

use cordis_anima::ca_core::InputRole;
use cordis_anima::{Loaded, Options, Scene, Voice, tick};
use std::sync::Arc;

const KEY: &str = r#"
[param]
grip = { value = "2 kN/m", live = true, min = "100 N/m", max = "9 kN/m" }
[TGR]
key = { device = "tgr12", dof = 0, x = "-6 mm" }
[ENX]
hand = {}
[ENF]
push = { to = "low[20]" }
[STRING]
low = { n = 40, f = "110 Hz", t60 = "4 s", m = "1 g" }
[BUT]
strike = { between = ["key", "low[8]"], k = "grip", z = "0.2 N s/m" }
[REF]
hold = { between = ["hand", "low[30]"], k = "50 N/m", z = "0.01 N s/m" }
[SOX]
left = { from = "low[3]", gain = 100 }
right = { from = "low@0.7", gain = 100 }
"#;

fn key() -> Arc<Scene> {
    Arc::new(Loaded::read(KEY, "key.ca.toml").compile(&Options::default()).expect("it compiles").scene)
}

#[test]
fn blocks_are_the_ticks_of_the_scene() {
    let scene = key();
    let mut s = scene.state();
    let n = 3000;
    let hand: Vec<f32> = (0..n).map(|i| 1e-3 * (i as f32 / 80.0).sin()).collect();
    let mut voice = Voice::new(scene.clone());
    let (at_key, at_hand) = (voice.port("key").expect("a port"), voice.port("hand").expect("a port"));
    assert_eq!(voice.role(at_key), Some(InputRole::Device));
    assert_eq!(voice.port("nothing"), None);
    let (mut left, mut right, mut third) = (vec![0.0_f32; n], vec![9.0_f32; n], vec![9.0_f32; n]);
    voice.hold(at_key, 1e-3);
    // blocks of uneven lengths, one of them empty
    let mut at = 0;
    for block in [1, 700, 0, 64, 1235, 1000] {
        let range = at..at + block;
        let out: &mut [&mut [f32]] =
            &mut [&mut left[range.clone()], &mut right[range.clone()], &mut third[range.clone()]];
        voice.process(&[(at_hand, &hand[range])], out);
        at += block;
    }
    assert_eq!(at, n);
    let (key_input, hand_input) = (scene.input("key").expect("it"), scene.input("hand").expect("it"));
    let mut forces = [0.0; 2];
    for i in 0..n {
        s.input[key_input] = 1e-3;
        s.input[hand_input] = f64::from(hand[i]);
        cordis_anima::compute_forces(&scene, &mut s);
        forces = [s.f[scene.ports.enx[0].mat as usize], s.ports.border[0].force];
        cordis_anima::integrate(&scene, &mut s);
        assert_eq!([left[i], right[i]], [s.output[0] as f32, s.output[1] as f32], "sample {i}");
    }
    assert!(third.iter().all(|v| *v == 0.0), "a channel that the scene does not have is silent");
    assert_eq!([voice.force(at_hand), voice.force(at_key)], forces);
    assert!(forces.iter().all(|f| f.abs() > 1e-6), "{forces:?}");
    assert!(left.iter().any(|v| v.abs() > 1e-3));
}

#[test]
fn parameters_go_by_handle_and_stay_in_range() {
    let mut voice = Voice::new(key());
    let grip = voice.param("grip").expect("a live parameter");
    assert_eq!(voice.param("grap"), None);
    for (asked, given) in [(3000.0, 3000.0), (1e9, 9000.0), (-1.0, 100.0), (f64::INFINITY, 9000.0)] {
        assert_eq!(voice.set(grip, asked, 64), given);
        assert_eq!(voice.params()[0].value, given);
    }
    assert_eq!((voice.set(grip, 3000.0, 64), voice.set(grip, f64::NAN, 64)), (3000.0, 3000.0));
    voice.reset();
    assert_eq!(voice.params()[0].value, 2000.0);
    let patch = voice.scene().controls().set("grip", 5000.0).expect("in range");
    assert!(voice.apply(&patch, 10) && voice.state().ramps.is_moving());
}

#[test]
fn what_diverges_is_silent_and_feels_nothing() {
    let text = "[MAS]\nm = { m = \"1 g\", dx0 = \"1 mm\" }\n[ENX]\nhand = {}\n[RES]\nr = { between = [\"hand\", \"m\"], k = 1e9 }\n\
                [SOX]\nout = { from = \"m\" }\n";
    let scene = Arc::new(Loaded::read(text, "m.ca.toml").compile(&Options::default()).expect("it compiles").scene);
    let mut voice = Voice::new(scene);
    let (mut out, mut last) = (vec![0.0_f32; 4800], vec![9.0_f32; 100]);
    voice.process(&[], &mut [&mut out]);
    assert!(voice.has_diverged() && voice.level().clipped > 0);
    assert!(out.iter().all(|v| v.abs() <= 1.0));
    voice.process(&[], &mut [&mut last]);
    assert!(last.iter().all(|v| *v == 0.0));
    assert_eq!(voice.force(voice.port("hand").expect("it")), 0.0);
    voice.reset();
    voice.process(&[], &mut [&mut out[..1]]);
    assert!(!voice.has_diverged() && out[0] != 0.0);
}

#[test]
fn a_voice_goes_on_from_a_snapshot_in_another_thread() {
    let scene = key();
    let mut voice = Voice::new(scene.clone());
    let hand = voice.port("hand").expect("a port");
    voice.hold(hand, 2e-3);
    let mut out = vec![0.0_f32; 500];
    voice.process(&[], &mut [&mut out]);
    let grip = voice.param("grip").expect("a live parameter");
    voice.set(grip, 3000.0, 64);
    let bytes = voice.to_bytes();
    voice.process(&[], &mut [&mut out]);
    let mut other = Voice::new(scene);
    let theirs = std::thread::spawn(move || {
        other.restore(&bytes).expect("a snapshot of this scene");
        assert_eq!(other.params()[0].value, 3000.0);
        let mut out = vec![0.0_f32; 500];
        other.process(&[], &mut [&mut out]);
        assert!(other.restore(b"nothing").is_err());
        out
    });
    assert_eq!(theirs.join().expect("it plays"), out);
    let mut s = voice.scene().state();
    tick(voice.scene(), &mut s);
    assert!(out.iter().any(|v| v.abs() > 1e-4));
}
