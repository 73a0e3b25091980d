//! PLK (plectrum): one note per passage.

use crate::play::{TURN, audited, scene, within};
use ca_core::tick;

#[test]
fn a_plectrum_lets_go_once_per_passage() {
    for seconds in [0.02, 0.3, 2.0] {
        let text = "[CEL]\nreed = { m = \"1 g\", f = \"220 Hz\", t60 = \"0.05 s\" }\n[ENX]\nplectrum = { x = \"-3 mm\" }\n\
             [PLK]\npluck = { between = [\"reed\", \"plectrum\"], k = \"2 kN/m\", z = \"0.05 N s/m\", d = \"1 mm\" }\n\
             [SOX]\nout = { from = \"reed\", gain = 500 }\n";
        let scene = scene(text);
        let mut s = scene.state();
        let (mut releases, mut takes) = (0, 0);
        let passage = (seconds * scene.rate) as u64;
        for n in 0..4 * passage {
            let u = (n % passage) as f64 / passage as f64;
            let up = (n / passage).is_multiple_of(2);
            s.input[0] = 6e-3 * (u - 0.5) * if up { 1.0 } else { -1.0 };
            let (held, last) = (s.links.mem[0], s.links.mem[1]);
            tick(&scene, &mut s);
            releases += u32::from(held == 1.0 && s.links.mem[0] == 0.0);
            if held == 0.0 && s.links.mem[0] == 1.0 {
                takes += 1;
                assert!(last * s.links.mem[1] <= 0.0, "it takes hold where it passes the reed, not before");
            }
        }
        assert_eq!((takes, releases), (4, 4), "4 passages of {seconds} s");
    }
}

/// Plays four passages from `x`. Returns how often the plectrum engages, and the largest relative residual.
fn passages(more: &str, x: &str) -> (u32, f64) {
    let text = format!(
        "[CEL]\nreed = {{ m = \"1 g\", f = \"220 Hz\", t60 = \"0.05 s\" }}\n[ENX]\nplectrum = {{ x = \"{x}\" }}\n\
         [PLK]\npluck = {{ between = [\"reed\", \"plectrum\"], k = \"2 kN/m\", z = \"0.05 N s/m\", d = \"1 mm\"{more} }}\n\
         [SOX]\nout = {{ from = \"reed\", gain = 500 }}\n"
    );
    let scene = audited(&text);
    let mut s = scene.state();
    let (mut takes, mut far) = (0, 0.0_f64);
    let n = scene.rate as u64;
    for i in 0..n {
        let t = i as f64 / n as f64;
        s.input[0] = -3e-3 * (TURN * 2.0 * t).cos();
        let held = s.links.mem[0];
        tick(&scene, &mut s);
        takes += u32::from(held == 0.0 && s.links.mem[0] == 1.0);
        far = far.max(s.ledger.as_ref().map_or(0.0, |l| l.balance().residual.abs() / l.balance().peak.max(1e-9)));
    }
    (takes, far)
}

#[test]
fn a_one_sided_plectrum_passes_freely_on_its_way_back() {
    for (more, takes) in [("", 4), (", side = \"up\"", 2), (", side = \"down\"", 2)] {
        let (found, far) = passages(more, "-3 mm");
        assert_eq!(found, takes, "{more}");
        within(&format!("energy of a plectrum{more}"), far, 1e-11);
    }
}

#[test]
fn what_is_not_engaged_at_load_pulls_nothing_until_it_has_passed() {
    for (more, holds) in
        [("", true), (", engaged = false", false), (", side = \"up\"", false), (", side = \"down\"", true)]
    {
        let text = format!(
            "[CEL]\nreed = {{ m = \"1 g\", f = \"220 Hz\", t60 = \"0.05 s\" }}\n[ENX]\nplectrum = {{ x = \"-0.5 mm\" }}\n\
             [PLK]\npluck = {{ between = [\"reed\", \"plectrum\"], k = \"2 kN/m\", d = \"1 mm\"{more} }}\n\
             [SOX]\nout = {{ from = \"reed\" }}\n"
        );
        let scene = scene(&text);
        let mut s = scene.state();
        s.input[0] = -0.5e-3;
        for _ in 0..100 {
            tick(&scene, &mut s);
        }
        assert_eq!(s.output[0] != 0.0, holds, "{more}");
    }
}

/// A mass swings through a one-sided plectrum that never lets go; its energy errors cancel over passages.
#[test]
fn a_one_sided_plectrum_makes_no_energy_in_the_long_run() {
    for side in ["up", "down"] {
        let scene = audited(&format!(
            "[SOL]\ng = {{}}\n[MAS]\na = {{ m = \"1 g\", v = \"0.3 m/s\" }}\n[RES]\nr = {{ between = [\"g\", \"a\"], k = \"10 kN/m\" }}\n\
             [PLK]\np = {{ between = [\"g\", \"a\"], k = \"10 kN/m\", d = \"1 m\", side = \"{side}\" }}\n[SOX]\no = {{ from = \"a\" }}\n"
        ));
        let mut s = scene.state();
        for _ in 0..480_000 {
            tick(&scene, &mut s);
        }
        let b = s.ledger.as_ref().expect("a ledger").balance();
        within(&format!("heat of a plectrum, {side}"), b.lost / b.h0, 1e-12);
        within(&format!("energy it made, {side}"), b.scheme_error.abs() / b.h0, 0.02);
    }
}
