//! Junction of a waveguide with a spring and a damper.
//!
//! The limit of the junction and of the string behind it is in closed form. To travelling waves a mass is (2m/T)(z −
//! 1)/(z + 1). A spring is a negative mass of kT²/4 beside a passive spring, and a damper of the scheme a negative mass
//! of zT/2 beside a passive damper (docs/numerics.md §7.2, §1.4). For any string that makes no energy, a negative sum
//! of masses has a real pole z < −1, and a positive sum has none.
//!
//! The string adds to the sum only if it reflects the highest frequency completely and inverted, as a rigid end does at
//! an even number of samples D there and back: then it adds ZT/2D. At an odd number the reflection is not inverted, and
//! ends with losses give less than a mass would.

use super::linear::{RATE, WORDS, beyond, edge, grows};
use super::{Axis, Line, Map};

/// Frequency of the string \[turns per sample\]: low enough for the heaviest junction.
const PITCH: f64 = 0.005;

/// Returns true if a junction of 1 kg grows with a spring and a damper between it and the ground. It is `delay` samples
/// there and back from the near end of a string of impedance `zeta`. A quarter of a wave returns after a whole turn of
/// the string; the rest is lost at the far end.
fn junction_grows(delay: u32, zeta: f64, a: f64, b: f64) -> bool {
    let at = f64::from(delay) * PITCH;
    let t60 = 5.0 / PITCH;
    grows(
        &format!(
            "{RATE}[WAVEGUIDE]\nlow = {{ f = {PITCH:?}, t60 = {t60:?}, z = {zeta:?}, at = [{at:?}], m = 1 }}\n[SOL]\n\
             wall = {{}}\n[REF]\ntie = {{ between = [\"wall\", \"low[0]\"], k = {a:?}, z = {b:?} }}\n[SOX]\n\
             out = {{ from = \"low[0]\" }}\n"
        ),
        1.0,
    )
}

/// A junction, over the stiffness and viscosity at it.
pub const JUNCTION: Map = Map {
    name: "junction",
    title: "A junction of a waveguide, with a spring and a damper",
    text: "A WAVEGUIDE of ZT/m = 1 with a junction of mass m, three samples from its near end and back; a REF ties it \
           to a SOL. Its waves do not change the limit: it is stable if and only if a + 2b < 4, like the same mass \
           without a string. `ca check` uses this limit for every waveguide.",
    axes: [Axis::of("a = k T²/m", 0.0, 5.0), Axis::of("b = z T/m", 0.0, 2.5)],
    words: WORDS,
    measured: |a, b| junction_grows(3, 1.0, a, b),
    theory: |a, b| Some(beyond(1.0, a, b)),
    lines: || edge(1.0),
    band: 0.005,
};

/// Samples from the junction to the near end and back, below.
const NEAR: u32 = 2;

/// Returns the stiffness at the boundary of a junction to which the near end adds ZT/2D.
fn borne(zeta: f64) -> f64 {
    4.0 + 2.0 * zeta / f64::from(NEAR)
}

/// A junction, over stiffness and impedance of its string.
pub const IMPEDANCE: Map = Map {
    name: "impedance",
    title: "A junction of a waveguide, by its impedance",
    text: "The same without a damper, two samples from the near end and back. At half the sample rate the rigid end \
           then reflects like a mass: stable if and only if a < 4 + 2 (ZT/m)/D, D = 2. The thin line is the limit of \
           `ca check`, which does not include this effect: a longer delay has less of it, and an odd delay, or an end \
           with losses, has none.",
    axes: [Axis::of("a = k T²/m", 0.0, 10.0), Axis::of("Z T/m", 0.0, 5.0)],
    words: WORDS,
    measured: |a, zeta| junction_grows(NEAR, zeta, a, 0.0),
    theory: |a, zeta| Some(a >= borne(zeta)),
    lines: || vec![Line::edge(vec![[borne(0.0), 0.0], [borne(5.0), 5.0]]), Line::rule([4.0, 0.0], [4.0, 5.0])],
    band: 0.005,
};
