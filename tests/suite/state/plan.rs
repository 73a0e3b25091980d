//! Plans: a scene read back from its bytes is the same in sound, names and live parameters. Other bytes are refused,
//! and a tick of a scene from corrupted bytes never fails.

use crate::play::{audited, reference, scene, with};
use ca_compile::Options;
use ca_core::internal::scene::{modules, same_since};
use ca_core::internal::state::checksum;
use ca_core::{ARITHMETIC, Catalog, PLAN_VERSION, PlanError, Precision, Scene, State, tick};
use ca_tests::long_form::long_form;
use ca_tests::{KEY, catalog, gesture, texts};
use proptest::prelude::*;
use std::sync::OnceLock;

/// Ticks played: into contacts, and beyond two gesture frames.
const TICKS: usize = 600;

fn read(bytes: &[u8]) -> Scene {
    Scene::from_bytes(bytes, &catalog()).unwrap_or_else(|e| panic!("{e}"))
}

fn play(scene: &Scene, mut s: State, ticks: usize) -> (Vec<u64>, State) {
    let mut sound = Vec::new();
    for _ in 0..ticks {
        gesture(scene, &mut s);
        tick(scene, &mut s);
        sound.extend(s.output.iter().map(|v| v.to_bits()));
    }
    (sound, s)
}

/// Writes and reads a scene, and compares all its data and its sound.
fn same(name: &str, scene: &Scene) {
    let bytes = scene.to_bytes();
    let again = read(&bytes);
    assert_eq!(again.identity(), scene.identity(), "{name}");
    assert_eq!(again.to_bytes(), bytes, "{name}");
    assert_eq!(again.state(), scene.state(), "{name}");
    assert_eq!(again.certificate, scene.certificate, "{name}");
    assert_eq!((&again.symbols, &again.inputs), (&scene.symbols, &scene.inputs), "{name}");
    assert_eq!((same_since(&again), again.passes.fused), (same_since(scene), scene.passes.fused), "{name}");
    let (a, b) = (play(scene, scene.state(), TICKS), play(&again, again.state(), TICKS));
    assert!(a.0 == b.0, "{name} sounds otherwise");
    assert_eq!(a.1.bits(), b.1.bits(), "{name}");
    assert_eq!(a.1.ledger, b.1.ledger, "{name}");
    let hand = |_| Some([1e-3, 1e-6]);
    assert_eq!(scene.state_from(hand), again.state_from(hand), "{name}");
    let (mut before, mut after) = (scene.controls(), again.controls());
    let params: Vec<_> = before.params().iter().map(|p| (p.name.clone(), p.min, p.max)).collect();
    for (param, min, max) in params {
        for value in [min, max, 0.5 * (min + max)] {
            assert_eq!(before.set(&param, value), after.set(&param, value), "{name}: {param} = {value}");
        }
    }
}

/// Groups at the gesture rate with exact and compensated borders, in space and on a line. Live parameters, `stable`
/// contacts, implicit links and friction cross them.
const GROUPS: &str = r#"
[param]
slack = { value = 2, unit = "kN/m", live = true, min = 1, max = 3 }
[body]
dim = 3
rate = "gesture"
border = "compensated"
[body.MAS]
a = { m = "20 g", x = [0, 0, 0] }
b = { m = "20 g", x = ["5 cm", 0, 0], v = [0, 0.2, 0.1] }
[arm]
rate = "gesture"
border = "compensated"
[arm.MAS]
c = { m = "50 g", x = "1 mm", v = -1 }
d = { m = "30 g" }
[CEL]
bar = { m = "2 g", f = "330 Hz", t60 = "1 s" }
soft = { m = "2 g", f = "250 Hz" }
[STRING]
low = { n = 30, f = "110 Hz", m = "4 g", t60 = "2 s" }
[ENX]
shake = {}
[ENF]
push = { to = "low[4]" }
[BUT]
hit = { between = ["bar", "arm.c"], k = "20 kN/m", z = "0.2 N s/m", d = 0 }
solved = { between = ["soft", "arm.c"], k = "50 kN/m", d = 0, method = "stable" }
[BOW]
rub = { between = ["arm.d", "low[9]"], f = "0.5 N", v0 = "0.1 m/s" }
[REF]
edge = { between = ["body.a", "body.b"], k = "2 kN/m", z = "0.1 N s/m" }
yields = { between = ["arm.d", "bar"], k = "1 kN/m", z = "0.1 N s/m", method = "implicit" }
held = { between = ["shake", "low[2]"], k = "1 kN/m" }
[RES]
turned = { between = ["arm.d", "low[4]"], k = "slack" }
[SOX]
out = { from = "low[5]", gain = 100 }
seen = { from = "body.b", along = "y", dc = 20 }
[SOF]
blow = { from = "hit" }
"#;

/// Several ticks per sample, a parameter driven by a port, and a live one.
const TICKS_OF_A_SAMPLE: &str = r#"
[rate]
oversample = 3
[param]
felt_z = { value = 0, unit = "N s/m", live = true, min = 0, max = 0.1 }
pressure = { port = "press", span = [0, "20 mm"], min = 0, max = "1 N" }
[STRING]
s = { n = 24, f = "110 Hz", t60 = "3 s", m = "2 g" }
[ENX]
bow = {}
press = {}
[BOW]
hair = { between = ["bow", "s[3]"], f = "pressure", v0 = "0.1 m/s" }
[FRO]
felt = { between = ["s[0]", "s[9]"], z = "felt_z" }
[SOX]
out = { from = "s[20]", gain = 300 }
"#;

/// The method for all masses at once, without a ledger.
const COMPOSED: &str = r#"
[model]
method = "pefrl"
[CEL]
bar = { m = "2 g", k = "8 kN/m", dx0 = "1 mm" }
[MAS]
ball = { m = "1 g" }
[RES]
tie = { between = ["bar", "ball"], k = "1 kN/m" }
[SOX]
out = { from = "ball", gain = 100 }
"#;

/// Implicit links whose factor follows a live parameter, one of them held by a hand.
const FACTOR: &str = r#"
[param]
grip = { value = "50 kN/m", live = true, min = "1 kN/m", max = "500 kN/m" }
[TGR]
key = { device = "key", dof = 0 }
[SOL]
wall = {}
[MAS]
a = { m = "1 g", dx0 = "1 mm" }
b = { m = "1 g" }
c = { m = "1 g" }
[REF]
chain = { between = [["wall", "a", "b"], ["a", "b", "c"]], k = "grip", z = "1 N s/m", method = "implicit" }
hand = { between = ["key", "c"], k = "10 kN/m", method = "centred" }
[SOX]
out = { from = "b", gain = 100 }
[SOF]
felt = { from = "hand" }
"#;

/// Compiled with the energy ledger, if it can have one.
fn compiled(text: &str) -> Scene {
    if text == COMPOSED { scene(text).scene } else { audited(text).scene }
}

const OWN: [(&str, &str); 5] =
    [("key", KEY), ("groups", GROUPS), ("ticks", TICKS_OF_A_SAMPLE), ("composed", COMPOSED), ("factor", FACTOR)];

#[test]
fn every_model_is_the_same_from_bytes() {
    let own = OWN.map(|(name, text)| (name.into(), text.into()));
    for (name, text) in texts().into_iter().chain(own) {
        same(&name, &compiled(&text));
        same(&name, &scene(&text).scene);
    }
}

#[test]
fn a_scene_of_other_options_is_the_same_from_bytes() {
    let single = Options { precision: Precision::Single, ..Options::default() };
    for (name, text) in OWN {
        same(name, &with(text, &reference()).scene);
        // distances in space are refused in single precision
        if text != GROUPS {
            same(name, &with(text, &single).scene);
        }
    }
}

/// A plan with this record.
fn plan(record: &[u8]) -> Vec<u8> {
    let (version, arithmetic) = (PLAN_VERSION.to_le_bytes(), ARITHMETIC.to_le_bytes());
    let (length, sum) = ((record.len() as u64).to_le_bytes(), checksum(record).to_le_bytes());
    [b"ca plan\n", &version[..], &arithmetic, &length, &sum, record].concat()
}

#[test]
fn bytes_that_are_not_a_plan_are_refused() {
    let bytes = scene(KEY).scene.to_bytes();
    assert_eq!(plan(&bytes[32..]), bytes);
    let refused = |bytes: &[u8]| {
        let why = Scene::from_bytes(bytes, &catalog()).expect_err("not a plan");
        assert!(why.to_string().contains(": "), "{why} lacks a remedy");
        why
    };
    let with = |at: usize, byte: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = byte;
        refused(&bytes)
    };
    let all = bytes.len() as u64;
    assert_eq!(refused(&[]), PlanError::Magic);
    assert_eq!(with(0, b'x'), PlanError::Magic);
    assert_eq!(with(8, 99), PlanError::Version(99));
    assert_eq!(with(12, 4), PlanError::Arithmetic(4));
    assert_eq!(refused(&bytes[..20]), PlanError::Length { expected: 32, found: 20 });
    assert_eq!(refused(&bytes[..100]), PlanError::Length { expected: all, found: 100 });
    assert_eq!(refused(&[&bytes[..], &[0]].concat()), PlanError::Length { expected: all, found: all + 1 });
    assert_eq!(with(bytes.len() - 1, 7), PlanError::Checksum);
    assert_eq!(refused(&plan(&bytes[32..100])), PlanError::Record);
    assert_eq!(refused(&plan(&[&bytes[32..], &[0]].concat())), PlanError::Record);
    assert_eq!(refused(&plan(&[0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f])), PlanError::Record);
}

#[test]
fn what_the_catalog_lacks_is_named() {
    let lpr = ca_lpr::KINDS.first().expect("kinds").example;
    let bytes = scene(lpr).scene.to_bytes();
    let without = Scene::from_bytes(&bytes, &ca_model::catalog());
    assert!(matches!(&without, Err(PlanError::Law(code)) if code.starts_with("LPR")), "{without:?}");
    // the live numbers of a string come from a generator; the kinds of the run-time have none
    let bytes = scene(TICKS_OF_A_SAMPLE).scene.to_bytes();
    assert!(Scene::from_bytes(&bytes, &Catalog::core()).is_ok(), "no item of a generator is live");
    let live = "[param]\nf = { value = 110, unit = \"Hz\", live = true, min = 100, max = 120 }\n[STRING]\ns = { n = 9, f = \"f\", \
                m = \"2 g\" }\n[SOX]\nout = { from = \"s[2]\" }\n";
    let without = Scene::from_bytes(&scene(live).scene.to_bytes(), &Catalog::core());
    assert!(matches!(&without, Err(PlanError::Kind(code)) if code == "STRING"), "{without:?}");
}

/// Records of small scenes: an example of each kind, and those above.
fn records() -> &'static [Vec<u8>] {
    static RECORDS: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    RECORDS.get_or_init(|| {
        let catalog = catalog();
        let examples = catalog.iter().map(|kind| kind.example).chain(OWN.map(|(_, text)| text));
        examples.map(|text| compiled(text).to_bytes()[32..].to_vec()).filter(|r| r.len() < 60_000).collect()
    })
}

/// Plays an accepted record from rest, under a hand and with its live parameters. Returns true if it was accepted.
fn survives(record: &[u8], ticks: usize) -> bool {
    static CATALOG: OnceLock<Catalog> = OnceLock::new();
    let catalog = CATALOG.get_or_init(catalog);
    let Ok(scene) = Scene::from_bytes(&plan(record), catalog) else { return false };
    for mut s in [scene.state(), scene.state_from(|_| Some([1e-3, 1e-6]))] {
        (0..ticks).for_each(|_| tick(&scene, &mut s));
    }
    scene.symbols.iter().for_each(|symbol| assert!(!symbol.name.to_string().is_empty() || symbol.name.of.is_empty()));
    let _ = scene.passes.forces.iter().map(|op| modules(&scene, op)).sum::<usize>();
    // generators trust their arguments, which a plan may change
    if scene.live.items.iter().all(|item| item.generator.is_none()) {
        let (mut controls, mut s) = (scene.controls(), scene.state());
        for p in scene.live.params.iter().filter(|p| p.min < p.max) {
            if let Ok(patch) = controls.set(&p.name, p.max) {
                s.apply(&patch, 3);
            }
            (0..5).for_each(|_| tick(&scene, &mut s));
        }
    }
    true
}

/// Changes one byte at a time. The long form tries several values for each.
#[test]
fn no_changed_byte_makes_a_tick_fail() {
    let long = long_form("bytes of plans with several values each");
    let (mut accepted, mut tried) = (0, 0);
    for (n, record) in records().iter().enumerate() {
        let step = if long { 1 } else { 1 + record.len() / 400 };
        for at in (n % step..record.len()).step_by(step) {
            let was = record[at];
            let values = [was ^ 1, was.wrapping_add(1), 0, 0xff, was ^ 0x80, was.wrapping_sub(1)];
            for value in values.iter().skip(at % 3).step_by(if long { 1 } else { 3 }) {
                let mut changed = record.clone();
                changed[at] = *value;
                accepted += u32::from(survives(&changed, 25));
                tried += 1;
            }
        }
    }
    assert!(accepted * 4 > tried, "{accepted} of {tried} were played");
}

/// A change of a record, at a relative position in it.
#[derive(Clone, Debug)]
enum Change {
    Set(f64, u8),
    Cut(f64, usize),
    Insert(f64, Vec<u8>),
    Copy(f64, f64, usize),
}

fn change() -> impl Strategy<Value = Change> {
    let share = || 0.0..1.0f64;
    prop_oneof![
        6 => (share(), any::<u8>()).prop_map(|(at, v)| Change::Set(at, v)),
        1 => (share(), 1usize..9).prop_map(|(at, n)| Change::Cut(at, n)),
        1 => (share(), prop::collection::vec(any::<u8>(), 1..9)).prop_map(|(at, v)| Change::Insert(at, v)),
        2 => (share(), share(), 1usize..33).prop_map(|(from, to, n)| Change::Copy(from, to, n)),
    ]
}

fn changed(record: &[u8], changes: &[Change]) -> Vec<u8> {
    let mut bytes = record.to_vec();
    for change in changes {
        let len = bytes.len();
        let place = |share: f64| (share * len as f64) as usize;
        let some = |from: usize, n: usize| from..(from + n).min(len);
        match change {
            Change::Set(at, v) => bytes.get_mut(place(*at)).into_iter().for_each(|b| *b = *v),
            Change::Cut(at, n) => drop(bytes.drain(some(place(*at), *n))),
            Change::Insert(at, v) => drop(bytes.splice(place(*at)..place(*at), v.iter().copied())),
            Change::Copy(from, to, n) => {
                let part = bytes[some(place(*from), *n)].to_vec();
                let to = place(*to);
                bytes[to..].iter_mut().zip(part).for_each(|(b, v)| *b = v);
            }
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10_000, ..ProptestConfig::default() })]

    #[test]
    fn no_change_of_a_plan_makes_a_tick_fail(which in 0usize..1000, changes in prop::collection::vec(change(), 1..5)) {
        let all = records();
        survives(&changed(&all[which % all.len()], &changes), 40);
    }
}
