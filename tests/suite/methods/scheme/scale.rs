//! Scale: powers of two change no bit, large scales change little, and non-finite numbers stay outside.

use crate::play::{apart, audited, case, list, model, num, within};
use ca_benches::atlas::survival::{self, scaled_output};
use ca_core::tick;

/// Output of the struck string with forces scaled by `k` and lengths by `l`.
fn scaled(k: f64, l: f64) -> Vec<f64> {
    scaled_output(&survival::scaled(k, l), 20_000, l)
}

#[test]
fn h01_scales_of_two_change_no_bit() {
    let c = case("H01");
    assert!(c["values"]["bit_identical"] == true && num(c, "tolerance/bits") == 0.0);
    let plain = scaled(1.0, 1.0);
    assert!(plain.iter().any(|v| v.abs() > 1e-5), "the hammer is heard");
    for (k, l) in [(30, 0), (-900, 0), (0, -30), (30, -30)] {
        assert!(scaled(2f64.powi(k), 2f64.powi(l)) == plain, "2^{k}, 2^{l}");
    }
}

#[test]
fn h02_scales_of_a_thousand_million() {
    let c = case("H02");
    let plain = scaled(1.0, 1.0);
    let peak = plain.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    for scale in list(c, "setup/scales") {
        within(&format!("H02 × {scale:e}"), apart(&scaled(scale, 1.0), &plain) / peak, num(c, "tolerance/rel"));
        within(&format!("H02 lengths × {scale:e}"), apart(&scaled(1.0, scale), &plain) / peak, num(c, "tolerance/rel"));
    }
}

#[test]
fn h07_what_is_not_a_number_stays_outside() {
    assert!(case("H07")["tolerance"]["finite"] == true);
    let text = r#"
[CEL]
bar = { m = "1 g", f = "220 Hz", t60 = "1 s" }
[ENX]
finger = { x = "1 mm" }
[TGR]
key = {}
[ENF]
blow = { to = "bar" }
[STRING]
low = { n = 8, f = "110 Hz", m = "1 g" }
[REF]
a = { between = ["finger", "bar"], k = 100, z = 0.01 }
b = { between = ["key", "bar"], k = 100, z = 0.01 }
c = { between = ["low@finger", "bar"], k = 100, z = 0.01 }
[SOX]
out = { from = "bar" }
point = { from = "low@finger" }
"#;
    let scene = audited(text);
    assert!(!model(text).items.is_empty());
    let inputs: Vec<usize> = ["finger", "key", "blow"].map(|n| scene.input(n).expect(n)).into();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for port in &inputs {
            let mut s = scene.state();
            for n in 0..480u64 {
                let good = 1e-3 * (n as f64 * 0.01).sin();
                for i in &inputs {
                    s.input[*i] = good;
                }
                let glitch = (100..200).contains(&n);
                if glitch {
                    s.input[*port] = bad;
                }
                let (kept, refused) = (s.ports.last_input[*port], s.ports.refused);
                tick(&scene, &mut s);
                let all: [&[f64]; 5] = [&s.x, &s.d, &s.f, &s.output, &s.links.tap];
                assert!(all.iter().all(|v| v.iter().all(|v| v.is_finite())), "{bad} at tick {n}");
                let due = scene.inputs[*port].device.is_none() && *port != inputs[1]
                    || ca_core::internal::border::frame_due(&scene, n);
                assert_eq!(s.ports.refused - refused, u64::from(glitch && due), "{bad}, port {port}, tick {n}");
                if glitch && *port != inputs[2] {
                    assert_eq!(s.ports.last_input[*port], kept, "the last good value is held");
                }
            }
            assert!(s.ports.refused > 0);
            let b = s.ledger.as_ref().expect("a ledger").balance();
            within("H07 the ledgers still balance", b.residual.abs() / b.peak, 1e-11);
        }
    }
}
