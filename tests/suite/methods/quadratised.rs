//! The energy of a contact in space is ψ²/2, where ψ follows √(2U). The ledger shows how far it is off, and one tick of
//! the motion bounds it: √κ of the energy of the scene, κ = kT²/m with the stiffness of the deepest contact.

use crate::play::{Random, audited};
use ca_core::tick;

const TICK: f64 = 1.0 / 48e3;

/// Plays `seconds` and returns the largest energy off the potential, and the most energy so far \[J\].
fn off(text: &str, seconds: f64) -> [f64; 2] {
    let scene = audited(text);
    let mut s = scene.state();
    (0..(seconds / TICK) as u64).for_each(|_| tick(&scene, &mut s));
    let b = s.ledger.as_deref().expect("a ledger").balance();
    [b.strayed, b.peak]
}

fn power(random: &mut Random, low: f64, high: f64) -> f64 {
    10f64.powf(low + (high - low) * random.uniform().abs())
}

#[test]
fn a_blow_keeps_to_its_potential() {
    let (mut random, mut most) = (Random(7), 0.0f64);
    for n in 0..60 {
        let [kappa, m, v] = [[-6.0, 2.0], [-3.0, -1.0], [-2.0, 1.0]].map(|[low, high]| power(&mut random, low, high));
        let hertz = n % 2 == 1;
        let (law, p) = if hertz { ("HRZ", 1.5) } else { ("BUT", 1.0) };
        // of the same stiffness at a depth of 0.1 mm
        let k = kappa * m / (TICK * TICK) * if hertz { 1e2 } else { 1.0 };
        let text = format!(
            "[room]\ndim = 2\n[room.SOL]\nw = {{}}\n[room.MAS]\n\
             m = {{ m = {m:e}, x = [{:e}, 1e-3], v = [{:e}, 0] }}\n\
             [{law}]\nc = {{ between = [\"room.w\", \"room.m\"], k = {k:e}, d = 5e-3, method = \"stable\" }}\n\
             [SOX]\no = {{ from = \"room.m\", along = \"x\" }}\n",
            6e-3 + 0.1 * v * random.uniform().abs() * TICK,
            -v
        )
        .replace(", method", if hertz { ", p = 1.5, method" } else { ", method" });
        let [off, peak] = off(&text, 0.1);
        let deepest = ((p + 1.0) * peak / k).powf(1.0 / (p + 1.0));
        let bound = (p * k * deepest.powf(p - 1.0) * TICK * TICK / m).sqrt();
        assert!(off <= bound * peak, "{off:e} of {peak:e} J, bound {bound:e}\n{text}");
        most = most.max(off / (bound * peak));
    }
    assert!(most > 0.5, "the bound is nearly reached: {most}");
}

/// Grains in a round box, with and without losses; a pair of them has twice the mobility of one.
#[test]
fn many_contacts_keep_to_their_potential() {
    let (mut random, m) = (Random(11), 1e-3);
    for n in 0..12 {
        let kappa = power(&mut random, -5.0, 1.0);
        let (k, z) = (kappa * m / (TICK * TICK), [0.0, 0.1][n % 2]);
        let text = format!(
            "[room]\ndim = 3\ngravity = 9.81\n[room.SOL]\nc = {{}}\n[room.GRAINS]\n\
             g = {{ n = 6, m = {m:e}, gap = 0.002, x = [0, 0, 0.01] }}\n\
             [BUT]\nwall = {{ between = [\"room.c\", \"room.g[*]\"], k = {k:e}, d = 0.03, sense = \"inside\", z = {z}, method = \"stable\" }}\n\
             hits = {{ between = [\"room.g[*]\", \"room.g[*]\"], k = {k:e}, d = 0.003, method = \"stable\" }}\n\
             [SOX]\no = {{ from = \"room.g[0]\", along = \"x\" }}\n"
        );
        let [off, peak] = off(&text, 2.0);
        assert!(off <= (2.0 * kappa).sqrt() * peak, "{off:e} of {peak:e} J at {kappa:e}\n{text}");
    }
}

/// A contact that lasts does not drift: a mass rolls in a round box for half a minute, around or to and fro.
#[test]
fn a_contact_that_lasts_does_not_drift_from_its_potential() {
    for (gravity, x, v) in [(0.0, [0.050_008, 0.0], 2.0), (9.81, [0.035_355_339, -0.035_356_339], 0.0)] {
        let text = format!(
            "[room]\ndim = 2\ngravity = {gravity}\n[room.SOL]\nc = {{}}\n[room.MAS]\nm = {{ m = 0.01, x = {x:?}, v = [0, {v}] }}\n\
             [BUT]\nb = {{ between = [\"room.c\", \"room.m\"], k = 1e5, d = 0.05, sense = \"inside\", method = \"stable\" }}\n\
             [SOX]\no = {{ from = \"room.m\", along = \"x\" }}\n"
        );
        let scene = audited(&text);
        let mut s = scene.state();
        let by = |s: &mut ca_core::State, ticks: u64| {
            (0..ticks).for_each(|_| tick(&scene, s));
            s.ledger.as_deref().expect("a ledger").balance().strayed
        };
        let [early, late] = [by(&mut s, 48_000), by(&mut s, 29 * 48_000)];
        assert!(late <= 1.1 * early, "{early:e} J after a second, {late:e} J after thirty\n{text}");
    }
}
