//! Energy ledgers of waveguides: waves store energy, the far end dissipates it, and the ledgers balance.

use super::string;
use crate::play::{TURN, audited, scene, within};
use ca_core::tick;

/// Struck by a hammer and damped by a felt, with three junctions: every tick balances, the far end only dissipates, and
/// in the end all energy is heat.
#[test]
fn the_ledger_balances_and_the_far_end_only_takes() {
    for loss in ["t60 = 0.3", "t60 = 0.3, t60_high = 0.02", "t60 = 0.05, t60_high = 0.01, f_high = 2000"] {
        let scene = audited(&string(
            &format!("f = 330, {loss}, z = 0.8, at = [0.1, 0.5, 0.8]"),
            "[MAS]\nhammer = { m = \"2 g\", x = \"-1 mm\", v = 2 }\n[SOL]\nground = {}\n\
             [REF]\npress = { between = [\"hammer\", \"w[0]\"], k = 20000, z = 0.1, l0 = 0 }\n\
             tie = { between = [\"w[1]\", \"w[2]\"], k = 3000, z = 0.05 }\n\
             [FRO]\nfelt = { between = [\"ground\", \"w[1]\"], z = 0.01 }\n",
        ));
        let mut s = scene.state();
        let mut heat = 0.0;
        for n in 0..48_000 {
            tick(&scene, &mut s);
            let ledger = s.ledger.as_ref().expect("a ledger").balance();
            assert!(ledger.lost >= heat - 1e-15 * ledger.peak, "tick {n} of {loss}: {} after {heat}", ledger.lost);
            heat = ledger.lost;
        }
        let l = s.ledger.as_ref().expect("a ledger");
        let ledger = l.balance();
        within("residual", ledger.residual.abs() / ledger.peak, 1e-12);
        within("of one tick", l.extremes.worst / ledger.peak, 1e-14);
        assert!(ledger.h0 > 1e-4 && ledger.scheme_error == 0.0);
        within("what is not heat in the end", (1.0 - ledger.lost / ledger.h0).abs(), 2e-3);
    }
}

/// After a soft push, without energy trapped above the corner frequency of the junction, all partials decay alike.
/// Energy falls by 60 dB in T60.
#[test]
fn a_note_loses_sixty_decibels_in_its_time() {
    let scene = audited(&string("f = 480, t60 = 0.5, z = 1, at = 0.4", "[ENF]\nhand = { to = \"w[0]\" }\n"));
    let mut s = scene.state();
    let mut held = Vec::new();
    for n in 0..24_000 {
        s.input[0] = if n < 96 { 1.0 - (TURN * f64::from(n) / 96.0).cos() } else { 0.0 };
        tick(&scene, &mut s);
        held.push(s.ledger.as_ref().expect("a ledger").h);
    }
    within("decibels in 0.25 s", (10.0 * (held[23_000] / held[11_000]).log10() + 30.0).abs(), 0.02);
}

#[test]
fn without_one_there_is_no_trace() {
    let scene = scene("[CEL]\nbar = { m = 1, f = 440 }\n[SOX]\nout = { from = \"bar\" }\n");
    assert!(scene.waves == ca_core::internal::op::layout::Waves::default() && scene.state().links.mem.is_empty());
    assert!(scene.passes.forces.iter().chain(&scene.passes.moves).all(|op| !op.name().starts_with("waves")));
    let scene = crate::play::scene(
        "[CEL]\nbar = { m = 1, f = 440 }\n[SOX]\nout = { from = \"bar\" }\n[WAVEGUIDE]\nw = { f = 100, z = 1, at = 0.2 }\n",
    );
    assert!(scene.waves.delays.is_empty() && scene.state().links.mem.is_empty());
}
