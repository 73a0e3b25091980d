//! Links in space between ends at one place, or almost: their direction is in the rounding of positions or undefined.

use crate::play::{Random, audited, with};
use ca_compile::Options;
use ca_core::tick;

/// Two masses at one place fall together, and part in the direction of their rounding; the energy is accounted for.
#[test]
fn what_falls_together_is_accounted_for() {
    let mut random = Random(5);
    for n in 0..60 {
        let [k, gravity, x, y] = [0; 4].map(|_| random.uniform().abs());
        let link = match n % 3 {
            0 => format!("[RES]\nl = {{ between = [\"w.b\", \"w.a\"], k = {:e}, l0 = 1e-3 }}\n", 1e5 * k),
            1 => format!("[BUT]\nl = {{ between = [\"w.b\", \"w.a\"], k = {:e}, d = 1e-3 }}\n", 1e8 * k),
            _ => format!(
                "[BUT]\nl = {{ between = [\"w.b\", \"w.a\"], k = {:e}, d = 1e-3, method = \"stable\" }}\n",
                1e8 * k
            ),
        };
        let text = format!(
            "[w]\ndim = 2\ngravity = {}\n[w.MAS]\na = {{ m = 2.4e-3, x = [{x}, {y}] }}\nb = {{ m = 1.4e-3, x = [{x}, {y}] }}\n\
             {link}[SOX]\no = {{ from = \"w.a\", along = \"y\" }}\n",
            20.0 * gravity
        );
        let scene = audited(&text);
        let mut s = scene.state();
        (0..1000).for_each(|_| tick(&scene, &mut s));
        let balance = s.ledger.as_deref().expect("a ledger").balance();
        assert!(balance.residual.abs() <= 1e-11 * balance.peak, "{balance:?}\n{text}");
        // explicit links make energy where their direction is undefined, and it is known
        let made = s.ledger.as_deref().map_or(0.0, |l| l.scheme_error.iter().sum::<f64>());
        assert!(n % 3 < 2 || made.abs() <= 1e-10 * balance.peak, "{made} {balance:?}\n{text}");
    }
}

/// At distances whose square is below the least number, a contact does not push.
#[test]
fn nothing_pushes_across_less_than_the_least_distance() {
    for exponent in (150..320).step_by(2) {
        for law in ["BUT", "HRZ"] {
            let text = format!(
                "[w]\ndim = 3\n[w.SOL]\nw = {{}}\n[w.MAS]\na = {{ m = 1e-3, x = [1e-{exponent}, 0, 0] }}\n\
                 [{law}]\nc = {{ between = [\"w.w\", \"w.a\"], k = 1e6, d = 0.01, method = \"stable\" }}\n\
                 [SOX]\no = {{ from = \"w.a\", along = \"x\" }}\n"
            );
            let scene = with(&text, &Options::default()).scene;
            let mut s = scene.state();
            (0..2000).for_each(|_| tick(&scene, &mut s));
            assert!(s.x.iter().all(|x| x.abs() < 100.0), "{text}");
        }
    }
}
