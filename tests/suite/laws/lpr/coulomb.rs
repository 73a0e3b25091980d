//! Set-valued friction across two worlds: against the plain link, against a closed form, and without energy gain.

use crate::methods::stable::{heat, made, only_falls, ran};
use crate::play::{apart, audited, mat, model, off, scene, within};
use ca_compile::{Options, compile};
use ca_core::{Level, tick};
use ca_tests::catalog;

const DRY: &str = "curve = \"coulomb\", method = \"set-valued\"";

#[test]
fn with_a_port_held_it_is_the_plain_friction() {
    let play = |code: &str, ends: &str| {
        let scene = scene(&format!(
            "[SOL]\nwall = {{}}\ntop = {{}}\nbottom = {{}}\n[MAS]\nblock = {{ m = 0.01 }}\n[ENX]\nbelt = {{}}\n[RES]\nspring = {{ between = [\"wall\", \"block\"], k = 1000 }}\n\
             [{code}]\nrub = {{ {ends}, f = 1.6, fd = 0.8, {DRY} }}\n[SOX]\nout = {{ from = \"block\" }}\n"
        ));
        assert_eq!(scene.certificate.level, Level::Proven);
        assert!(ran(&scene).contains(&format!("{code} set-valued").as_str()), "{:?}", ran(&scene));
        let mut s = scene.state();
        let mut changes = 0;
        let mut stuck = false;
        let x: Vec<f64> = (0..24_000u32)
            .map(|n| {
                s.input[0] = 0.1 * f64::from(n) / scene.rate;
                tick(&scene, &mut s);
                changes += usize::from((s.links.mem[0] != 0.0) != stuck);
                stuck = s.links.mem[0] != 0.0;
                s.x[mat(&scene, "block")]
            })
            .collect();
        assert!(changes > 20, "{changes}");
        x
    };
    let plain = play("BOW", "between = [\"block\", \"belt\"]");
    for ends in [
        "between = [\"block\", \"belt\"], onto = [\"top\", \"bottom\"]",
        "between = [\"top\", \"bottom\"], onto = [\"block\", \"belt\"]",
    ] {
        within(ends, apart(&play("LPR_BOW", ends), &plain), 1e-15);
    }
}

/// The sum of two sliding motions stops at the speeds given by momentum, after the time and with the heat of the closed
/// form, on lines and with a port in space.
#[test]
fn the_sum_of_two_motions_stops() {
    let (a, b, v, u, f) = (0.002, 0.005, 0.5, 0.2, 0.01);
    let both = 1.0 / a + 1.0 / b;
    let lines =
        format!("[SOL]\nwall = {{}}\nfar = {{}}\n[MAS]\nlow = {{ m = {a}, v = {v} }}\nhigh = {{ m = {b}, v = {u} }}\n");
    let space = format!(
        "[room]\ndim = 3\n[room.SOL]\nwall = {{}}\n[room.MAS]\nlow = {{ m = {a}, x = [0.6, 0.8, 0], v = [{}, {}, 0] }}\n[SOL]\nfar = {{}}\n[MAS]\nhigh = {{ m = {b}, v = {u} }}\n",
        0.6 * v,
        0.8 * v
    );
    for (text, group) in [(lines, ""), (space, "room.")] {
        let scene = audited(&format!(
            "{text}[LPR_BOW]\nrub = {{ between = [\"{group}wall\", \"{group}low\"], onto = [\"far\", \"high\"], f = {f}, {DRY} }}\n[SOX]\nout = {{ from = \"high\" }}\n"
        ));
        let (mut s, low, high) = (scene.state(), mat(&scene, &format!("{group}low")), mat(&scene, "high"));
        let mut stopped = None;
        for n in 0..24_000 {
            tick(&scene, &mut s);
            if s.links.mem[0] != 0.0 {
                stopped.get_or_insert(n);
            }
        }
        let time = f64::from(stopped.expect("it stops")) / scene.rate;
        within("time", off(time, (v + u) / (f * both)), 1e-3);
        let along = if group.is_empty() { s.d[low] } else { 0.6 * s.d[low] + 0.8 * s.d[low + 1] };
        let [along, line] = [along, s.d[high]].map(|d| d * scene.rate);
        within("the sum stands", (along + line).abs(), 1e-15);
        within("speed in the first world", (along - (v - (v + u) / (a * both))).abs() / v, 1e-3);
        within("heat", off(heat(&scene, &s), 0.5 * (v + u) * (v + u) / both), 1e-3);
        within("made", made(&s), 1e-12);
    }
}

/// A body that swings and turns in space rubs against a cell. The energy only falls, apart from the second-order term
/// while a port in space turns and sticks, and the ledger explains all of it.
#[test]
fn across_a_turning_port_it_only_takes() {
    for (f, fd) in [(1e-3, 1e-3), (0.05, 0.01), (5.0, 2.0)] {
        let text = format!(
            "[room]\ndim = 3\n[room.SOL]\nnail = {{}}\n[room.MAS]\nball = {{ m = 0.005, x = [0.03, 0.04, 0], v = [-0.8, 0.6, 0.3] }}\n[SOL]\nwall = {{}}\n[CEL]\n\
             bar = {{ m = 0.001, k = 300, v = 0.4 }}\n[RES]\nrod = {{ between = [\"room.nail\", \"room.ball\"], k = 500, along = \"x\" }}\n\
             side = {{ between = [\"room.nail\", \"room.ball\"], k = 300, along = \"y\" }}\n[LPR_BOW]\n\
             rub = {{ between = [\"room.nail\", \"room.ball\"], onto = [\"wall\", \"bar\"], f = {f}, fd = {fd}, {DRY} }}\n[SOX]\nout = {{ from = \"bar\" }}\n"
        );
        let scene = audited(&text);
        let s = only_falls(&scene, 24_000, 1e-6, &text, |_| ());
        let ledger = s.ledger.as_ref().expect("a ledger");
        assert!(heat(&scene, &s) > 0.0 && ledger.h < ledger.h0);
        within("made", made(&s), 1e-12);
    }
}

/// Refused if another link with a method touches the same mass, and with a curve other than `coulomb`.
#[test]
fn it_stands_alone() {
    let refused = |more: &str, code: &str, word: &str| {
        let text = format!(
            "[SOL]\nwall = {{}}\n[MAS]\na = {{ m = 0.01 }}\nb = {{ m = 0.01 }}\n[LPR_BOW]\nrub = {{ between = [\"wall\", \"a\"], onto = [\"wall\", \"b\"], f = 1, {more}\n\
             [SOX]\nout = {{ from = \"a\" }}\n"
        );
        let Err(found) = compile(&model(&text), &catalog(), &Options::default()) else { panic!("{text}") };
        assert!(found.list.iter().any(|d| d.code == code && d.title.contains(word)), "{found:?}");
    };
    let hit = "[BUT]\nhit = { between = [\"wall\", \"b\"], k = 10, method = \"stable\" }";
    refused(&format!("{DRY} }}\n{hit}"), "E028", "shares `b`");
    refused("v0 = 1, method = \"set-valued\" }", "E010", "coulomb");
}
