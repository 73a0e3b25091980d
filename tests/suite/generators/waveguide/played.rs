//! Junctions with each kind of link.

use super::string;
use crate::play::{audited, mat, within};
use ca_core::{Level, tick};

const STRING: &str = "f = 220, t60 = 3, t60_high = 0.5, z = 0.6, at = [0.13, 0.6]";

/// Plays half a second by the model's gesture. Returns the largest motion and the energy made, from the ledger.
fn played(more: &str) -> (f64, f64) {
    let scene = audited(&string(STRING, more));
    let reported = scene.findings.list.iter().any(|d| d.code.starts_with('W'));
    assert!(!reported, "{}", scene.findings);
    let mut s = scene.state();
    let (mut most, w) = (0.0f64, mat(&scene, "w[1]"));
    for _ in 0..24_000 {
        ca_tests::gesture(&scene, &mut s);
        tick(&scene, &mut s);
        most = most.max(s.x[w].abs());
    }
    let ledger = s.ledger.as_ref().expect("a ledger").balance();
    within("residual", ledger.residual.abs() / ledger.peak, 1e-11);
    (most, ledger.scheme_error / ledger.peak)
}

#[test]
fn struck() {
    let blow = |method: &str| {
        format!(
            "[MAS]\nh = {{ m = \"5 g\", x = \"-1 mm\", v = 1 }}\n\
             [BUT]\nb = {{ between = [\"h\", \"w[0]\"], k = \"40 kN/m\", z = 0.3, {method} }}\n"
        )
    };
    let (moved, made) = played(&blow(""));
    assert!(moved > 1e-4 && made < 0.01, "{moved} {made}");
    // solved together with the arriving waves, so no energy is made
    let (moved, made) = played(&blow("method = \"stable\""));
    assert!(moved > 1e-4);
    within("made by a stable blow", made.abs(), 1e-12);
}

#[test]
fn plucked() {
    let (moved, made) = played(
        "[ENX]\np = {}\n[PLK]\nk = { between = [\"p\", \"w[0]\"], k = \"3 kN/m\", z = 0.1, d = \"1 mm\" }\n\
         [gesture]\np = [[0, 0], [0.02, \"4 mm\"]]\n",
    );
    assert!(moved > 1e-4 && made.abs() < 0.05, "{moved} {made}");
}

#[test]
fn bowed() {
    let (moved, _) = played(
        "[ENX]\np = {}\n[BOW]\nk = { between = [\"p\", \"w[0]\"], f = \"0.2 N\", v0 = \"50 mm/s\" }\n\
         [gesture]\np = [[0, 0], [0.5, \"100 mm\"]]\n",
    );
    assert!(moved > 1e-4, "{moved}");
}

#[test]
fn an_edge_of_a_body() {
    let (moved, _) = played(
        "[room]\ndim = 3\n[room.MAS]\na = { m = \"2 g\", v = [0, 0, 1] }\nb = { m = \"2 g\", x = [\"3 cm\", 0, 0], v = [0, 0, -1] }\n\
         [LPR]\ne = { between = [\"room.a\", \"room.b\"], onto = [\"w[0]\", \"w[1]\"], k = \"300 N/m\" }\n",
    );
    assert!(moved > 1e-5, "{moved}");
}

#[test]
fn whatever_a_mass_may_have() {
    let scene = audited(&string(
        STRING,
        "[model]\ngravity = 9.81\nfriction = \"1 mN s/m\"\n[CEL]\nbody = { m = \"10 g\", f = 200, t60 = 1 }\n\
         [RES]\nbridge = { between = [\"w[*]\", \"body\"], k = 5000 }\n[ENF]\nhand = { to = \"w[*]\" }\n[SOF]\nf = { from = \"w[0]\", channel = 0 }\n",
    ));
    assert_eq!(scene.certificate.level, Level::Proven);
    let mut s = scene.state();
    for n in 0..20_000 {
        s.input[0] = if n < 1000 { 0.3 } else { 0.0 };
        tick(&scene, &mut s);
    }
    let ledger = s.ledger.as_ref().expect("a ledger").balance();
    assert!(ledger.work.abs() > 1e-6 && ledger.lost > 0.0);
    within("residual", ledger.residual.abs() / ledger.peak, 1e-12);
}
