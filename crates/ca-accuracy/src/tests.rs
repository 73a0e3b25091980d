//! Compares the stated error of a reference with an independent computation.

use super::timing::Clock;
use super::{AccuracyOptions, measured};
use ca_lab::load::Loaded;

/// Two masses between walls, with three lossless contacts.
const CONTACTS: &str = "[SOL]\nl = { x = -0.01 }\nr = { x = 0.0137 }\n[MAS]\nb = { m = 1e-3, v = 0.731 }\nq = { m = 2e-3, x = 5e-3, v = -0.3 \
                        }\n[BUT]\nc = { between = [\"l\", \"b\"], k = 4e5 }\nd = { between = [\"q\", \"r\"], k = 4e5 }\ne = { between = \
                        [\"b\", \"q\"], k = 4e5 }\n[SOX]\no = { from = \"b\" }\n";

/// Positions of `b` relative to its rest at each sample, integrated here at 4096 times the rate.
fn by_hand(frames: usize) -> Vec<f64> {
    const TIMES: u32 = 4096;
    let (dt, k) = (1.0 / (48e3 * f64::from(TIMES)), 4e5);
    let force = |b: f64, q: f64| {
        let [l, r, e] = [b + 0.01, 0.0137 - q, q - b].map(|gap: f64| k * gap.min(0.0));
        // each contact pushes its ends apart
        [(-l + e) / 1e-3, (r - e) / 2e-3]
    };
    let (mut x, mut v) = ([0.0, 5e-3], [0.731, -0.3]);
    let mut a = force(x[0], x[1]);
    let mut places = Vec::with_capacity(frames);
    for _ in 0..frames {
        places.push(x[0]);
        for _ in 0..TIMES {
            for i in 0..2 {
                v[i] += 0.5 * dt * a[i];
                x[i] += dt * v[i];
            }
            a = force(x[0], x[1]);
            (0..2).for_each(|i| v[i] += 0.5 * dt * a[i]);
        }
    }
    places
}

/// The extrapolation must not use an order that the scheme cannot have: its error would be ten times the stated one.
#[test]
fn a_reference_with_contacts_is_known_as_well_as_is_said() {
    let loaded = Loaded::read(CONTACTS, "contacts.ca.toml");
    let mut go_on = |_: u64, _: u64| true;
    let mut ask = AccuracyOptions {
        rate: None,
        probes: &["o".into()],
        seconds: Some(0.15),
        times: Some(&[16]),
        reference: Some(64),
        remedy: "",
        clock: Clock::WALL,
        progress: &mut go_on,
    };
    let found = measured(&loaded, &mut ask).expect("it is measured");
    let reference = &found.reference.columns[0];
    let truth = by_hand(reference.len());
    let square = |of: &mut dyn Iterator<Item = f64>| of.map(|v| v * v).sum::<f64>().sqrt();
    let off = square(&mut reference.iter().zip(&truth).map(|(a, b)| a - b)) / square(&mut truth.iter().copied());
    assert!(off < found.reference.known && off > 0.01 * found.reference.known, "{off} off, {}", found.origin());
}
