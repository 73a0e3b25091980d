//! Identity of states and patches: another scene refuses them, whatever their shapes.

use crate::play::{audited, scene, with};
use ca_compile::Options;
use ca_core::internal::state::scene_of;
use ca_core::{Identity, Patch, Scene, State, compute_forces, integrate, process, tick};
use ca_haptic::engine::{Change, Engine, EngineCommand, Port, Retired};
use ca_tests::{KEY, profile, setup, texts};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// A mass on a spring, either of them live, with two channels.
fn bob(m: &str, k: &str) -> Scene {
    scene(&format!(
        "[param]\ndial = {{ value = 1, live = true, min = 0.1, max = 1e6 }}\n[SOL]\nwall = {{}}\n\
         [MAS]\nbob = {{ m = {m}, dx0 = 0.001 }}\n[RES]\nspring = {{ between = [\"wall\", \"bob\"], k = {k} }}\n\
         [SOX]\nleft = {{ from = \"bob\" }}\nright = {{ from = \"bob\", gain = 2 }}\n"
    ))
    .scene
}

/// Message of a call that panics.
fn panics(f: impl FnOnce()) -> String {
    let said = catch_unwind(AssertUnwindSafe(f)).expect_err("it is refused");
    said.downcast_ref::<String>().cloned().expect("a text")
}

#[test]
fn a_patch_of_another_scene_changes_nothing() {
    // one live coefficient each: a stiffness of 1 would become a mobility
    let (spring, mass) = (bob("1", "\"dial\""), bob("\"dial\"", "1000"));
    let patch = spring.controls().set("dial", 1e6).expect("in range");
    let mut s = mass.state();
    let before = s.clone();
    assert!(!s.apply(&patch, 1));
    assert_eq!(s, before);
    (0..100).for_each(|_| tick(&mass, &mut s));
    assert!(s.output.iter().all(|v| v.abs() < 0.01), "{:?}", s.output);
    // nor is a patch without a scene accepted, nor a patch by a state without a scene
    let by_hand = Patch { set: patch.set.clone(), ..Patch::default() };
    assert!(!spring.state().apply(&by_hand, 1));
    assert!(!State::<f64>::default().apply(&patch, 1));
    assert!(spring.state().apply(&patch, 1));
    assert!(spring.state().apply(&Patch { scene: spring.identity(), set: patch.set }, 1));
}

#[test]
fn a_state_of_another_scene_is_not_played() {
    let mine = bob("1", "1000");
    for (other, what) in [
        (bob("1", "2000"), "another number"),
        (bob("2", "1000"), "another mass"),
        (scene("[CEL]\nbar = { m = 1, k = 2, dx0 = 0.1 }\n[SOX]\nout = { from = \"bar\" }\n").scene, "another shape"),
    ] {
        let s = other.state();
        assert_ne!(mine.identity(), other.identity(), "{what}");
        let play: [fn(&Scene, &mut State); 3] = [tick, compute_forces, integrate];
        for play in play {
            let mut played = s.clone();
            let said = panics(|| play(&mine, &mut played));
            assert!(said.contains("does not belong to the scene") && said.contains("scene.state()"), "{what}: {said}");
            assert_eq!(played, s, "{what}: nothing has changed");
        }
        let (mut played, mut out) = (s.clone(), [7.0; 8]);
        assert!(!process(&mine, &mut played, &mut out));
        assert_eq!((played, out), (s, [7.0; 8]), "{what}");
    }
    let said = panics(|| tick(&mine, &mut State::default()));
    assert!(said.contains("scene.state()"), "{said}");
}

/// An engine counts states and patches of another scene and continues; none of them reaches a tick.
#[test]
fn an_engine_takes_only_what_is_of_its_scene() {
    let live = "[param]\ndial = { value = 1, live = true, min = 1, max = 9 }\n";
    let text = |x: &str| format!("{live}{}weight = {{ from = \"key\", gain = \"dial\" }}\n", KEY.replace("500", x));
    let (mine, other) = (Arc::new(scene(&text("500")).scene), scene(&text("600")));
    let port = Port::new(&mine, setup("key", profile(|_| ())));
    let mut engine = Engine::new(mine.clone(), vec![port], ca_haptic::engine::Options::default());
    let before = engine.state.clone();
    assert_eq!((before.x.len(), before.coef.len()), (other.state().x.len(), other.state().coef.len()));
    let foreign = other.controls().set("dial", 2.0).expect("in range");
    engine.command(EngineCommand::Set(Box::new(Change { params: vec![(0, 2.0)], patches: vec![foreign] })));
    let retired = engine.command(EngineCommand::Reload(Box::new(other.state())));
    assert!(matches!(retired, Some(Retired::State(s)) if *s == other.state()), "what was refused is given back");
    assert_eq!((engine.counts.refused, &engine.state), (2, &before));
    let patch = mine.controls().set("dial", 2.0).expect("in range");
    engine.command(EngineCommand::Set(Box::new(Change { params: vec![(0, 2.0)], patches: vec![patch] })));
    engine.command(EngineCommand::Reload(Box::new(mine.state())));
    assert_eq!(engine.counts.refused, 2);
    assert_eq!(engine.answer().count(), 1);
    engine.finish();
}

#[test]
fn a_block_holds_whole_rows() {
    let two = bob("1", "1000");
    assert_eq!(two.counts.n_out, 2);
    let mut s = two.state();
    let before = s.clone();
    for n in [1, 3, 7] {
        let mut out = vec![7.0; n];
        assert!(!process(&two, &mut s, &mut out), "{n} numbers");
        assert!(out.iter().all(|v| *v == 7.0) && s == before, "{n} numbers: nothing was played");
    }
    for (n, ticks) in [(0, 0), (2, 1), (6, 4)] {
        assert!(process(&two, &mut s, &mut vec![7.0; n]));
        assert_eq!(s.tick, ticks);
    }
    let silent =
        scene("[MAS]\nbob = { m = 1 }\n[ENX]\nhand = {}\n[RES]\nhold = { between = [\"hand\", \"bob\"], k = 1 }\n");
    let mut s = silent.state();
    assert!(silent.counts.n_out == 0 && process(&silent, &mut s, &mut [0.0; 3]) && s.tick == 3);
}

/// Every compilation of a model gives the same scene, so a snapshot outlives its scene.
#[test]
fn the_same_model_is_the_same_scene() {
    let (one, again) = (bob("1", "\"dial\""), bob("1", "\"dial\""));
    assert_eq!(one.identity(), again.identity());
    let (mut a, mut b) = (one.state(), one.state());
    (0..50).for_each(|_| tick(&one, &mut a));
    (0..20).for_each(|_| tick(&one, &mut b));
    let patch = one.controls().set("dial", 10.0).expect("in range");
    let mut c = b.clone();
    (0..30).for_each(|_| tick(&again, &mut c));
    assert_eq!(a, c, "it goes on in the other");
    assert!(c.apply(&patch, 10));
    // a change makes no other scene
    tick(&again, &mut c);
    assert_eq!(scene_of(&c), again.identity());
}

/// All models differ in identity, with and without options, and share it with their states.
#[test]
fn every_model_is_a_scene_of_its_own() {
    let mut seen: BTreeMap<String, (String, usize)> = BTreeMap::new();
    for (name, text) in texts() {
        let plain = with(&text, &Options::default());
        let heard = with(&text, &Options { energy: true, ..Options::default() });
        assert_ne!(plain.identity(), heard.identity(), "{name}: a ledger is another state");
        assert_eq!(plain.identity(), with(&text, &Options::default()).identity(), "{name}");
        // compiled together, the two scenes are the same
        let both = with(&text, &Options { audited: true, ..Options::default() });
        assert_eq!(both.identity(), plain.identity(), "{name}");
        assert_eq!(both.audited.map(|s| s.identity()), Some(heard.identity()), "{name}");
        for s in [&plain, &heard] {
            assert!(s.identity() != Identity::default() && scene_of(&s.state()) == s.identity(), "{name}");
            let numbers = s.state();
            let size = numbers.x.len() + numbers.coef.len();
            if let Some((other, n)) = seen.insert(format!("{:?}", s.identity()), (name.clone(), size)) {
                // the same file in two folders is the same scene
                let same = texts().into_iter().filter(|t| t.0 == other || t.0 == name).collect::<Vec<_>>();
                let states = same.iter().map(|t| [with(&t.1, &Options::default()), audited(&t.1)]);
                assert!(
                    states.flatten().filter(|t| t.state() == numbers).count() >= 2,
                    "{name} and {other}: {n} {size}"
                );
            }
        }
    }
    assert!(seen.len() > 60, "{}", seen.len());
}

#[test]
fn codes_are_unique() {
    let taken = ca_model::catalog().iter().next().expect("a kind");
    let said = panics(|| drop(ca_model::catalog().with(&[taken])));
    assert!(said.contains(taken.code) && said.contains(taken.title), "{said}");
    let said = panics(|| drop(ca_model::catalog().with(ca_lpr::KINDS).with(ca_lpr::KINDS)));
    assert!(said.contains(ca_lpr::KINDS[0].code), "{said}");
    let twice = [ca_lpr::KINDS[0], ca_lpr::KINDS[0]];
    assert!(panics(|| drop(ca_model::catalog().with(&twice))).contains("two kinds"));
    let all: Vec<&str> = ca_tests::catalog().iter().map(|k| k.code).collect();
    assert!(all.iter().enumerate().all(|(i, c)| !all[..i].contains(c)), "{all:?}");
}
