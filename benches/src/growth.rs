//! Measures the growth of explicit contacts: a lossless ball between two walls, from drawn starts (docs/numerics.md §3.2).
//!
//! Draws stiffness, place and speed, since one value alone may hit a stiffness that makes nothing at any phase. Draws by products and
//! sums only, so that every machine plays the same starts.

use crate::{model, scene};
use ca_compile::KernelClass;
use ca_core::internal::scene::growth::{SECONDS, STARTS, TIMES};
use ca_core::tick;

const RATE: f64 = 48e3;
const MASS: f64 = 1e-3;
/// The walls \[m\].
const WALLS: [f64; 2] = [-0.01, 0.0137];

/// Numbers from 0 to 1, the same everywhere.
struct Drawn(u64);

impl Drawn {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Of [`STARTS`] around a stiffness kT²/m, those whose energy passed [`TIMES`] that at load within [`SECONDS`].
pub fn grew(stiffness: f64) -> u32 {
    let mut drawn = Drawn(0x9e37_79b9_7f4a_7c15);
    (0..STARTS).map(|_| u32::from(grows(stiffness, &mut drawn))).sum()
}

/// True of a start that does.
fn grows(stiffness: f64, drawn: &mut Drawn) -> bool {
    let k = stiffness * (0.7 + 0.7 * drawn.next()) * MASS * RATE * RATE;
    let x = WALLS[0] + (WALLS[1] - WALLS[0]) * drawn.next();
    let speed = 0.1 + 2.9 * drawn.next();
    let v = if drawn.next() < 0.5 { -speed } else { speed };
    let [low, high] = WALLS;
    let scene = scene(
        &model(&format!(
            "[SOL]\nl = {{ x = {low:?} }}\nr = {{ x = {high:?} }}\n[MAS]\nb = {{ m = {MASS:?}, dx0 = {x:?}, v = {v:?} }}\n[BUT]\n\
             c = {{ between = [\"l\", \"b\"], k = {k:?} }}\nd = {{ between = [\"b\", \"r\"], k = {k:?} }}\n[SOX]\n\
             o = {{ from = \"b\" }}\n"
        )),
        KernelClass::Fast,
        false,
    );
    let ball = (0..scene.counts.n_mat).find(|i| scene.mat_name(*i) == "b").unwrap_or(0);
    let mut s = scene.state();
    let most = TIMES * (v / RATE) * (v / RATE);
    let free = |x: f64| (low..=high).contains(&x);
    for _ in 0..u64::from(SECONDS) * RATE as u64 {
        tick(&scene, &mut s);
        // between the walls all of its energy is motion
        let (x, d) = (s.x[ball], s.d[ball]);
        if free(x) && free(x - d) && d * d > most {
            return true;
        }
    }
    false
}
