//! Three accounts of energy must agree: the ledgers of scene and guard, and a sum over the frames on the wire.

use super::{FRAME_DT, Rig, bare, cause, mode, profile};
use crate::play::within;
use ca_haptic::equivalence::Gains;
use ca_haptic::frame::Mode;
use ca_haptic::guard::Order;
use ca_haptic::profile::Profile;
use ca_haptic::simulated::{Device, Hand, Script};

/// Two keys with hammers on strings, in a scale different from the hand's.
const INSTRUMENT: &str = r#"
[TGR]
low = { device = "key", dof = 0 }
high = { device = "key", dof = 1 }
[MAS]
one = { m = "5 g", x = -0.1 }
two = { m = "3 g", x = -0.1 }
[REF]
a = { between = ["low", "one"], k = "2 kN/m", z = "0.05 N s/m" }
b = { between = ["high", "two"], k = "1 kN/m", z = "0.05 N s/m" }
[STRING]
string = { n = 10, f = "110 Hz", t60 = "1 s", m = "1 g", x = -0.2 }
[BUT]
c = { between = ["string[3]", "one"], k = "200 N/m", z = "0.01 N s/m", d = 0 }
d = { between = ["string[6]", "two"], k = "200 N/m", z = "0.01 N s/m", d = 0 }
[SOX]
out = { from = "string[5]" }
"#;

/// α = 20 maps 10 mm of the hand to 0.2 m of the model; one key is a lever, the other an amplifier.
fn gains() -> Vec<Gains> {
    vec![Gains { alpha: 20.0, beta: 0.05 }, Gains { alpha: 30.0, beta: 0.02 }]
}

/// Plays a simulated hand and compares the accounts. Returns received, asked, given and removed energy of key 0.
fn accounts(profile: Profile, rate: &str, exact: bool) -> [f64; 4] {
    let mut p = profile;
    p.dof = 2;
    let script = Script::Bow { rest: 0.0, depth: 8e-3, rate: 3.0 };
    let mut device = Device::new(&p, Hand::finger(10.0, &p), script, 0, 3);
    let mut rig = Rig::with(&format!("{rate}\n{INSTRUMENT}"), p, gains(), true);
    rig.order(Order::Arm);
    let mut force = [0.0; 2];
    let mut last = [0.0; 2];
    let (mut given, mut scale) = ([0.0; 2], [0.0; 2]);
    for n in 0..15_000 {
        let x = if n == 0 { [0.0; 2] } else { device.step(&force, FRAME_DT).try_into().expect("two keys") };
        let f = rig.go(&x);
        assert!(mode(&f) != Mode::Fault, "frame {n}: {}", cause(&f).name());
        for k in 0..2 {
            if n > 0 {
                given[k] -= force[k] * (x[k] - last[k]);
            }
            scale[k] += (force[k] * (x[k] - last[k])).abs();
            force[k] = f64::from(f.force[k]);
        }
        last = x;
    }
    let hand = rig.engine.ports[0].chain.ledger.clone();
    let ledger = rig.engine.state.ledger.as_ref().expect("a ledger");
    for k in 0..2 {
        let g = gains()[k];
        let joules = g.beta / g.alpha;
        assert!(scale[k] > 1e-3, "{} J crossed key {k}", scale[k]);
        within("given, by the wire", (hand.hand_work[k] - given[k]).abs() / scale[k], 1e-12);
        if exact {
            let e = ledger.hands[k];
            within("received, by the scene", (hand.received[k] - e.received * joules).abs() / scale[k], 1e-12);
            within("asked, by the scene", (hand.model_work[k] - e.given * joules).abs() / scale[k], 1e-12);
            within("leak", (hand.leak(k) - e.leak() * joules).abs() / scale[k], 1e-12);
        }
    }
    let b = ledger.balance();
    within("the ledger of the scene", b.residual.abs() / b.peak, 1e-12);
    [hand.received[0], hand.model_work[0], hand.hand_work[0], hand.removed(0)]
}

#[test]
fn the_ledgers_agree_to_rounding() {
    for rate in ["", "[rate]\nborder = \"hold\"", "[rate]\nlatency = 3", "[rate]\nsound = 3000\ngesture = 3000"] {
        let [received, asked, given, removed] = accounts(bare(), rate, true);
        // without limits only the two frames of the fade-in, at rest, and rounding on the wire are removed
        assert!(removed.abs() < 1e-6 * received.abs(), "{rate}: {removed} of {received}");
        assert!((asked - given - removed).abs() <= 1e-15);
    }
}

#[test]
fn what_the_guard_keeps_is_a_line_of_its_own() {
    // with a fifth of the force, the guard removes the rest; the ledger of the scene does not include it
    let weak = profile(|p| {
        (p.force, p.guard.oscillation) = (0.2, false);
        (p.body.step, p.body.noise) = (0.0, 0.0);
    });
    let [_, asked, given, removed] = accounts(weak, "", true);
    assert!(removed.abs() > 0.05 * asked.abs(), "{asked} {given} {removed}");
}
