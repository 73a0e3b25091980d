//! Grains that may all touch each other, as a model text.

use std::fmt::Write as _;

/// Returns the text of `n` grains of 5 mm in a shell that holds them, with contacts between all pairs.
///
/// The grains fill the share `fill` of the shell, and each moves at `speed` \[diameters per tick\].
pub fn grains(n: usize, fill: f64, speed: f64) -> String {
    let diameter = 0.005;
    let radius = 0.5 * diameter * (n as f64 / fill).cbrt();
    let mut seed = 88_172_645_463_325_252u64;
    let mut next = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut t = String::from("[room]\ndim = 3\n[room.SOL]\nmiddle = {}\n[room.MAS]\n");
    let mut at: Vec<[f64; 3]> = Vec::new();
    let square = |v: [f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let mut tries = 0;
    while at.len() < n {
        let p = [next(), next(), next()].map(|c| c * radius);
        tries += 1;
        // if no free place is left, they start slightly pressed together
        let apart = diameter * if tries < 200 * n { 0.95 } else { 0.7 };
        if square(p) < radius * radius && at.iter().all(|q| square([0, 1, 2].map(|k| p[k] - q[k])) > apart * apart) {
            at.push(p);
        }
    }
    for (i, p) in at.iter().enumerate() {
        let v = [next(), next(), next()];
        let v = v.map(|c| c * speed * diameter * 48e3 / square(v).sqrt());
        let _ = writeln!(t, "g{i} = {{ m = \"0.5 g\", x = {p:?}, v = {v:?} }}");
    }
    let all: Vec<String> = (0..n).map(|i| format!("\"room.g{i}\"")).collect();
    let all = all.join(", ");
    let _ = writeln!(
        t,
        "[BUT]\nshell = {{ between = [\"room.middle\", [{all}]], k = \"200 kN/m\", d = {radius}, sense = \"inside\" }}"
    );
    let _ = writeln!(t, "hits = {{ between = [[{all}], [{all}]], k = \"200 kN/m\", d = {diameter} }}");
    t + "[SOX]\nout = { from = \"room.g0\", along = \"x\" }\n"
}
