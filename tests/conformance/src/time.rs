//! Live changes, snapshots and blocks during play.

use crate::models::gesture;
use crate::random_parameters::{built, catalog, read as model, texts};
use ca_compile::{KernelClass, Options, compile};
use ca_core::{State, Type, process, tick};
use ca_model::{Entry, Model, Value, quantity};

/// Makes argument `arg` of item `item` a live parameter of value `v`, and returns its former value in SI.
fn live(m: &Model, item: usize, arg: usize, v: Option<f64>) -> Option<(Model, f64)> {
    let mut m = m.clone();
    let e = &mut m.items[item].args[arg];
    let si = match &e.value {
        Value::Num(v) => *v,
        Value::Text(t) if quantity::is_quantity(t) => quantity::parse(t).ok()?.value,
        _ => return None,
    };
    e.value = "dial".into();
    let range = if si == 0.0 { [0.0, 1e-3] } else { [si * 0.7, si * 1.4] };
    let entries = vec![
        Entry::new("value", v.unwrap_or(si)),
        Entry::new("live", true),
        Entry::new("min", range[0].min(range[1])),
        Entry::new("max", range[0].max(range[1])),
    ];
    m.params.push(Entry::new("dial", Value::Table(entries)));
    Some((m, si))
}

#[test]
fn a_live_change_ends_where_a_fresh_compile_begins() {
    const TICKS: u32 = 7;
    let catalog = catalog();
    let mut dialled = std::collections::BTreeSet::new();
    for (name, text) in texts() {
        let plain = model(&text);
        // parameters driven by a port are moving too
        let driven = |e: &Entry| matches!(&e.value, Value::Table(t) if t.iter().any(|x| x.key == "port"));
        if plain.items.len() > 60 || plain.params.iter().any(driven) {
            continue;
        }
        let rate = built(&plain, &Options::default()).rate;
        for item in 0..plain.items.len() {
            let kind = catalog.get(&plain.items[item].kind).expect("a kind");
            for arg in 0..plain.items[item].args.len() {
                let p = kind.param(&plain.items[item].args[arg].key).map(|i| &kind.params[i]).expect("a parameter");
                if !matches!(p.ty, Type::Number { .. } | Type::PowerStiffness { .. }) {
                    continue;
                }
                let Some((before, si)) = live(&plain, item, arg, None) else { continue };
                let to = if si == 0.0 { 1e-4 } else { si * 1.03 };
                let what = format!("{name}: {}.{}", plain.items[item].name, p.name);
                let options = Options { rate: Some(rate), ..Options::default() };
                let (after, _) = live(&plain, item, arg, Some(to)).expect("a number");
                let (Ok(scene), Ok(fresh)) =
                    (compile(&before, &catalog, &options), compile(&after, &catalog, &options))
                else {
                    // positions and lengths define the start, and an exponent is another law: they are refused as live
                    let refused = compile(&before, &catalog, &options).expect_err("refused");
                    assert!(refused.list.iter().any(|d| d.code == "E025"), "{what}: {refused}");
                    assert!(!p.live || p.name == "p", "{what}: {refused}");
                    continue;
                };
                assert!(
                    scene.links.e0 == fresh.links.e0 && scene.places.rest == fresh.places.rest,
                    "{what} moves something that is not live"
                );
                let patch = scene.controls().set("dial", to).unwrap_or_else(|e| panic!("{what}: {e}"));
                let mut s = scene.state();
                (0..5).for_each(|_| tick(&scene, &mut s));
                assert!(s.apply(&patch, TICKS));
                let target = fresh.state().coef;
                let moved: Vec<usize> = (0..target.len()).filter(|i| s.coef[*i] != target[*i]).collect();
                for left in (0..TICKS).rev() {
                    let way = s.coef.clone();
                    tick(&scene, &mut s);
                    for i in &moved {
                        assert!(s.coef[*i] != way[*i], "{what}: coefficient {i} waits");
                    }
                    assert_eq!(s.coef == target, left == 0, "{what}, {left} ticks to go");
                    assert_eq!(s.ramps.is_moving(), left > 0);
                    if moved.is_empty() {
                        break;
                    }
                }
                if !moved.is_empty() {
                    dialled.insert(format!("{}.{}", kind.code, p.name));
                }
            }
        }
    }
    for must in [
        "CEL.f",
        "CEL.t60",
        "STRING.f",
        "STRING.t60",
        "MESH.f",
        "STIFFSTRING.b",
        "REF.k",
        "BUT.d",
        "BOW.f",
        "SOX.gain",
        "FELT.q",
    ] {
        assert!(dialled.contains(must), "{must} was never changed: {dialled:?}");
    }
}

/// The state is complete: a clone continues bit by bit, and the hash agrees.
#[test]
fn a_snapshot_goes_on_as_if_nothing_had_happened() {
    for (name, text) in texts() {
        let scene = built(&model(&text), &Options { energy: true, ..Options::default() });
        let mut s = scene.state();
        let run = |s: &mut State, n: usize| {
            for _ in 0..n {
                gesture(&scene, s);
                tick(&scene, s);
            }
        };
        run(&mut s, 700);
        let mut copy = s.clone();
        assert_eq!(copy.bits(), s.bits());
        run(&mut s, 700);
        assert!(scene.counts.n_mat == 0 || copy.bits() != s.bits(), "{name}: the hash does not see time");
        run(&mut copy, 700);
        assert_eq!(copy.bits(), s.bits(), "{name}");
        assert!(copy == s, "{name}");
    }
}

#[test]
fn blocks_are_ticks() {
    for (name, text) in texts() {
        let scene = built(&model(&text), &Options { kernel: KernelClass::Fast, ..Options::default() });
        let (mut a, mut b) = (scene.state(), scene.state());
        let n = scene.counts.n_out.max(1);
        let mut out = Vec::new();
        for block in [1usize, 3, 64, 100] {
            let mut part = vec![f64::NAN; block * n];
            assert!(process(&scene, &mut a, &mut part), "{name}");
            out.extend(part);
        }
        for frame in out.chunks_exact(n) {
            tick(&scene, &mut b);
            assert!(scene.counts.n_out == 0 || frame == b.output, "{name}");
        }
        assert!(a == b, "{name}");
    }
}
