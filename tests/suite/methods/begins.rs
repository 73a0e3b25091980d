//! Gestures that begin away from the place of their port: a solved contact has the energy of the gesture's first
//! position, not that of the place in the model.

use crate::play::audited;
use ca_io::perform::Performance;

/// The rate of the region and the tick.
const RATES: [&str; 3] = ["", "[rate]\noversample = 4\n", "[rate]\ngesture = 48000\n"];

/// Plays 200 ticks of a contact whose port stands 1 mm from the mass in the model, and where `gesture` begins in the
/// performance. Returns the most stored energy \[J\], and how far the mass moved \[m\].
fn played(rate: &str, port: &str, method: &str, at: f64, begins: f64) -> [f64; 2] {
    let text = format!(
        "{rate}[room]\ndim = 2\n[room.MAS]\nm = {{ m = 0.01, x = [1e-3, 2e-3] }}\n\
         [room.{port}]\np = {{ x = [1e-3, {at:e}], dof = [0, 1] }}\n\
         [BUT]\nc = {{ between = [\"room.m\", \"room.p\"], k = 1e5, d = 5e-4, method = \"{method}\" }}\n\
         [SOX]\no = {{ from = \"room.m\", along = \"x\" }}\n\
         [gesture]\nroom.p.x = [[0, 1e-3]]\nroom.p.y = [[0, {begins:e}]]\n"
    );
    let text = if port == "ENX" { text.replace(", dof = [0, 1]", "") } else { text };
    let scene = audited(&text);
    let mut p = Performance::new(&scene, None).expect("a gesture");
    let (mut most, from) = (0.0f64, p.state.x.clone());
    for _ in 0..200 {
        p.tick();
        most = most.max(p.state.ledger.as_ref().expect("a ledger").balance().h);
    }
    let moved = p.state.x.iter().zip(&from).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    [most, moved]
}

#[test]
fn a_gesture_that_begins_apart_leaves_no_energy_of_the_place_in_the_model() {
    for rate in RATES {
        for port in ["ENX", "TGR"] {
            for method in ["stable", "stable3d"] {
                let [most, moved] = played(rate, port, method, 1.9e-3, 1e-3);
                assert_eq!([most, moved], [0.0; 2], "{port} {method} {rate}");
            }
        }
    }
}

/// As in the model whose port has its place where the gesture begins.
#[test]
fn a_gesture_that_begins_pressed_has_that_energy() {
    for rate in RATES {
        for port in ["ENX", "TGR"] {
            for method in ["stable", "stable3d"] {
                let [most, moved] = played(rate, port, method, 1e-3, 1.9e-3);
                let there = played(rate, port, method, 1.9e-3, 1.9e-3);
                // 0.1 % more than kη²/2, the motion of the first half tick
                let pressed = 0.5 * 1e5 * 4e-4f64.powi(2);
                assert!((most / pressed - 1.0).abs() < 2e-3, "{most} {pressed}, {port} {method} {rate}");
                for (a, b) in [most, moved].into_iter().zip(there) {
                    assert!(b > 1e-3 && (a / b - 1.0).abs() < 1e-12, "{a} {b}, {port} {method} {rate}");
                }
            }
        }
    }
}
