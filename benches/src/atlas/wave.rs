//! The junction of a waveguide under a spring and a damper.
//!
//! Decides on the limit in closed form, of the junction and of the string behind it. To travelling waves a mass is
//! (2m/T)(z − 1)/(z + 1), a spring a negative mass of kT²/4 beside a passive spring, a damper of the scheme a negative
//! mass of zT/2 beside a passive damper (docs/numerics.md §7.2, §1.4). Whatever the string is, as long as it makes no
//! energy, a mass that is negative in sum has a real pole z < −1 and one that is positive has none. The string adds to
//! the sum only where it gives all of the highest frequency back turned over, as a rigid end does an even number of
//! samples D away: ZT/2D. An odd number gives it back as it came, and ends that lose any of it give less than a mass
//! is.

use super::linear::{RATE, WORDS, beyond, edge, grows};
use super::{Axis, Line, Map};

/// Pitch of the string, in turns a sample: low enough for the heaviest junction.
const PITCH: f64 = 0.005;

/// Whether a junction of 1 kg, `delay` samples there and back from the near end of a string of impedance `zeta`, grows
/// with a spring and a damper between it and the ground. Of a whole turn of the string a quarter comes back, the rest
/// is lost at the far end.
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

/// A junction by what hangs on it.
pub const JUNCTION: Map = Map {
    name: "junction",
    title: "A junction of a waveguide, with a spring and a damper",
    text: "A WAVEGUIDE of ZT/m = 1 with a junction of mass m, three samples from its near end and back; a REF ties it \
           to a SOL. Its waves neither help nor harm: it is stable if and only if a + 2b < 4, as the same mass without \
           a string. That is where `ca check` has the limit, of every waveguide.",
    axes: [Axis::of("a = k T²/m", 0.0, 5.0), Axis::of("b = z T/m", 0.0, 2.5)],
    words: WORDS,
    measured: |a, b| junction_grows(3, 1.0, a, b),
    theory: |a, b| Some(beyond(1.0, a, b)),
    lines: || edge(1.0),
    band: 0.005,
};

/// Samples of the near end and back below.
const NEAR: u32 = 2;

/// Stiffness at the boundary of a junction that the near end gives ZT/2D to.
fn borne(zeta: f64) -> f64 {
    4.0 + 2.0 * zeta / f64::from(NEAR)
}

/// A junction by the string it is on.
pub const IMPEDANCE: Map = Map {
    name: "impedance",
    title: "A junction of a waveguide, by its impedance",
    text: "The same without a damper, two samples from the near end and back. There the rigid end gives half the \
           sample rate back as a mass would: stable if and only if a < 4 + 2 (ZT/m)/D, D = 2. The thin line is the \
           limit of `ca check`, which leaves that out: a longer way gives less of it, and an odd one, or an end that \
           loses anything, none.",
    axes: [Axis::of("a = k T²/m", 0.0, 10.0), Axis::of("Z T/m", 0.0, 5.0)],
    words: WORDS,
    measured: |a, zeta| junction_grows(NEAR, zeta, a, 0.0),
    theory: |a, zeta| Some(a >= borne(zeta)),
    lines: || vec![Line::edge(vec![[borne(0.0), 0.0], [borne(5.0), 5.0]]), Line::rule([4.0, 0.0], [4.0, 5.0])],
    band: 0.005,
};
