//! Swaps a playing scene for another version: masses continue, sound crossfades, unsuitable versions are refused.

use crate::play::scene;
use ca_core::Scene;
use ca_haptic::engine::{Engine, EngineCommand, Options, Retired, Swap};
use std::sync::Arc;

fn string(f: f64, more: &str) -> Arc<Scene> {
    let text = format!(
        "[STRING]\ns = {{ n = 40, f = \"{f} Hz\", t60 = \"2 s\", m = \"1 g\" }}\n[MAS]\nbob = {{ m = \"5 g\", v = 0.5 }}\n[SOL]\nwall = {{}}\n\
         [REF]\nr = {{ between = [\"wall\", \"bob\"], k = 900, z = 0.1 }}\ntie = {{ between = [\"bob\", \"s[9]\"], k = 200 }}\n\
         [ENF]\npush = {{ to = \"s[3]\" }}\n{more}[SOX]\nleft = {{ from = \"s[7]\", gain = 100 }}\nright = {{ from = \"bob\", gain = 50 }}\n"
    );
    Arc::new(scene(&text).scene)
}

/// Sound of `frames` gesture frames.
fn rendered(engine: &mut Engine, frames: usize) -> Vec<f64> {
    let mut all = Vec::new();
    for _ in 0..frames {
        let _ = engine.answer().count();
        all.extend_from_slice(engine.finish());
    }
    all
}

fn swap(engine: &mut Engine, to: &Arc<Scene>, number: u32) -> Option<Retired> {
    let swap = Swap::new(&engine.scene, to.clone(), to.state(), &[], (number, false)).expect("they fit");
    engine.command(EngineCommand::Swap(Box::new(swap)))
}

fn playing(scene: &Arc<Scene>) -> Engine {
    let mut engine = Engine::new(scene.clone(), Vec::new(), Options::default());
    engine.state.input[0] = 0.3;
    rendered(&mut engine, 200);
    engine
}

/// An equal version sounds the same to the bit, and ports keep their positions.
#[test]
fn the_same_version_goes_on_to_the_bit() {
    let first = string(110.0, "");
    let [mut with, mut without] = [playing(&first), playing(&first)];
    assert_eq!(swap(&mut with, &string(110.0, ""), 1), None, "there was none before");
    assert_eq!(rendered(&mut with, 600), rendered(&mut without, 600));
    assert_eq!((with.state.tick, with.state.input[0]), (without.state.tick, 0.3));
    // the next swap returns the first one, which then has nothing left to give
    let Some(Retired::Swap(gone)) = swap(&mut with, &first, 2) else { panic!("one came out") };
    assert_eq!(gone.number, 1);
    assert_eq!(with.command(EngineCommand::Swap(gone.clone())), Some(Retired::Swap(gone)), "a copy has no scene");
    assert_eq!(with.counts.refused, 1);
}

/// Masses in both versions continue, others begin at rest. No sample jumps more than in the two versions.
#[test]
fn another_version_goes_on_from_where_masses_are_without_a_click() {
    let (first, other) = (
        string(110.0, ""),
        string(
            220.0,
            "[CEL]\nnew = { m = \"1 g\", f = \"300 Hz\" }\n[RES]\nn = { between = [\"new\", \"s[20]\"], k = 10 }\n",
        ),
    );
    let mut engine = playing(&first);
    let place = |s: &Scene, name: &str| {
        let at = s.symbols.iter().position(|m| m.name == name).expect(name);
        s.symbols.places()[at] as usize
    };
    let last = rendered(&mut engine, 1);
    let names = ["s[7]", "s[20]", "bob"];
    let at = |e: &Engine| names.map(|n| (e.state.x[place(&e.scene, n)], e.state.d[place(&e.scene, n)]));
    let before = at(&engine);
    swap(&mut engine, &other, 1);
    assert_eq!(at(&engine), before);
    assert!(before.iter().all(|(x, d)| *x != 0.0 && *d != 0.0), "they move");
    assert_eq!(engine.state.x[place(&engine.scene, "new")], 0.0);
    let sound = rendered(&mut engine, 200);
    let step = |s: &[f64]| s.windows(3).step_by(2).map(|w| (w[2] - w[0]).abs()).fold(0.0, f64::max);
    let all = [&last[..], &sound].concat();
    let alone = step(&rendered(&mut playing(&first), 200)).max(step(&rendered(&mut engine, 200)));
    assert!(step(&all) < 2.0 * alone, "{} {alone}", step(&all));
    assert_eq!(engine.scene.about.title, other.about.title);
    assert!(Arc::ptr_eq(&engine.scene, &other));
}

#[test]
fn a_version_of_what_diverged_begins_as_at_load() {
    let first = string(110.0, "");
    let mut engine = playing(&first);
    engine.state.x[5] = 1e9;
    rendered(&mut engine, 3);
    assert!(engine.has_diverged());
    swap(&mut engine, &first, 1);
    let sound = rendered(&mut engine, 300);
    assert!(!engine.has_diverged() && sound.iter().all(|x| x.abs() <= 1.0));
    assert!(sound[0].abs() < 1e-3 && sound.iter().any(|x| x.abs() > 0.01), "it fades in");
}

#[test]
fn what_cannot_change_is_refused() {
    let first = string(110.0, "");
    let refused = |text: &str| {
        let other = Arc::new(scene(text).scene);
        Swap::new(&first, other.clone(), other.state(), &[], (1, false)).expect_err(text)
    };
    let outputs = "[SOX]\nleft = { from = \"m\" }\nright = { from = \"m\" }\n";
    let mass = "[CEL]\nm = { m = \"1 g\", f = \"100 Hz\" }\n";
    assert!(refused(&format!("[rate]\nsound = \"44.1 kHz\"\n{mass}{outputs}")).to_string().contains("rates"));
    assert!(refused(&format!("[rate]\ngesture = \"1 kHz\"\n{mass}{outputs}")).to_string().contains("rates"));
    assert!(refused(&format!("{mass}[SOX]\nleft = {{ from = \"m\" }}\n")).to_string().contains("outputs"));
    let key = "[TGR]\nk = { device = \"d\", dof = 0 }\n[RES]\nr = { between = [\"k\", \"m\"], k = 10 }\n";
    assert!(refused(&format!("{mass}{key}{outputs}")).to_string().contains("devices"));
}

/// A group at the gesture rate continues too, including the force that held it at the end of the frame: an equal
/// version is the same to the bit.
#[test]
fn a_group_at_the_gesture_rate_goes_on_to_the_bit() {
    for border in ["exact", "compensated"] {
        group_goes_on(border);
    }
}

/// The same with this border. The compensated one also has a link that the exact one refuses.
fn group_goes_on(border: &str) {
    let more = if border == "exact" {
        ""
    } else {
        "[CUB]\nheld = { between = [\"slow.big\", \"s[20]\"], k = 100, k3 = 1e6 }\n"
    };
    let slow = |k: f64| {
        let text = format!(
            "[slow]\nrate = \"gesture\"\nborder = \"{border}\"\n[slow.MAS]\nbig = {{ m = \"50 g\", v = 0.5 \
             }}\nfar = {{ m = \"50 g\" }}\n[STRING]\ns = {{ n \
             = 40, f = \"110 Hz\", t60 = \"2 s\", m = \"1 g\" }}\n[REF]\nin = {{ between = [\"slow.big\", \"slow.far\"], k = {k} \
             }}\ntie = {{ between = [\"slow.big\", \"s[9]\"], k = 200, z = 0.1 }}\n[SOX]\nleft = {{ from = \"s[7]\", gain = 100 \
             }}\n{more}"
        );
        Arc::new(scene(&text).scene)
    };
    let first = slow(900.0);
    let playing = |scene: &Arc<Scene>| {
        let mut engine = Engine::new(scene.clone(), Vec::new(), Options::default());
        rendered(&mut engine, 200);
        engine
    };
    let [mut with, mut without] = [playing(&first), playing(&first)];
    swap(&mut with, &slow(900.0), 1);
    assert_eq!(rendered(&mut with, 600), rendered(&mut without, 600));
    swap(&mut with, &slow(1800.0), 2);
    let places = |e: &Engine| e.state.slow.as_ref().expect("a group").state.x.to_vec();
    assert_eq!(places(&with), places(&without));
    assert_ne!(rendered(&mut with, 600), rendered(&mut without, 600));
}
