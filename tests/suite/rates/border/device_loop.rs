//! A device in the loop: the stiffest key that stays stable (E02), and the delay of its spring (E05).
//!
//! The device is exact: a mass with friction under a force held over each frame. The scene is compiled from text. One
//! frame of both is a linear map, measured column by column. The loop is stable while the spectral radius of the map is
//! below 1.

use crate::play::{PI, case, list, mat, num, off, rows, scene, within};
use ca_core::internal::border::delays;
use ca_core::{Scene, State, tick};

/// A device: mass \[kg\], friction \[N s/m\], length of a frame \[s\].
struct Device {
    m: f64,
    b: f64,
    t: f64,
}

impl Device {
    /// Position and speed after a frame under a force.
    fn go(&self, [x, v]: [f64; 2], force: f64) -> [f64; 2] {
        let tau = self.m / self.b;
        let fade = -(-self.t / tau).exp_m1();
        [x + v * tau * fade + force / self.b * (self.t - tau * fade), v * (1.0 - fade) + force / self.b * fade]
    }
}

/// A row of E02 as a model: ticks per frame, further lines of `[rate]`, and whether a damper KT/2 is beside the spring.
struct LoopRow {
    ratio: u32,
    more: &'static str,
    damped: bool,
}

const ROWS: [LoopRow; 5] = [
    LoopRow { ratio: 1, more: "", damped: false },
    LoopRow { ratio: 16, more: "", damped: false },
    LoopRow { ratio: 16, more: "", damped: true },
    LoopRow { ratio: 1, more: "latency = 1", damped: false },
    LoopRow { ratio: 16, more: "latency = 1", damped: false },
];

fn wall(row: &LoopRow, gesture: f64, k: f64) -> Scene {
    let z = if row.damped { k / gesture / 2.0 } else { 0.0 };
    let rate = format!("sound = {:e}\ngesture = {gesture:e}\n{}", gesture * f64::from(row.ratio), row.more);
    let link = format!("link = {{ between = [\"wall\", \"key\"], k = {k:e}, z = {z:e} }}");
    scene(&format!("[rate]\n{rate}\n[SOL]\nwall = {{}}\n[TGR]\nkey = {{}}\n[REF]\n{link}\n")).scene
}

fn frame(scene: &Scene, s: &mut State, x: f64) -> f64 {
    s.input[0] = x;
    (0..scene.rates.ratio).for_each(|_| tick(scene, s));
    s.ports.border[0].force
}

/// Map of one frame, by columns: position and speed of the device, then the memory of the rate boundary.
fn map(scene: &Scene, device: &Device) -> Vec<Vec<f64>> {
    let key = mat(scene, "key");
    let mut still = scene.state();
    tick(scene, &mut still);
    frame(scene, &mut still, 0.0);
    let column = |i: usize| {
        let unit = |j: usize| f64::from(u8::from(i == j));
        let mut s = still.clone();
        (s.ports.border[0].to, s.x[key]) = (unit(2), unit(2));
        s.ports.border[0].sum = unit(3);
        s.ports.late.iter_mut().enumerate().for_each(|(k, x)| *x = unit(4 + k));
        let hand = [unit(0), unit(1)];
        let force = frame(scene, &mut s, hand[0]);
        assert_eq!(s.x[key], s.ports.border[0].to);
        let [x, v] = device.go(hand, force);
        // at one rate the boundary accumulates no force
        let sum = if scene.rates.ratio > 1 { s.ports.border[0].sum } else { 0.0 };
        [&[x, v, s.ports.border[0].to, sum], &s.ports.late[..]].concat()
    };
    (0..4 + still.ports.late.len()).map(column).collect()
}

/// Logarithm of the spectral radius, by squaring 40 times.
fn growth(map: &[Vec<f64>]) -> f64 {
    let n = map.len();
    let mut a = map.to_vec();
    let mut log = 0.0;
    for turn in 0..40 {
        let most = a.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
        a.iter_mut().flatten().for_each(|v| *v /= most);
        log += most.ln() / 2f64.powi(turn);
        let product = |i: usize, j: usize| (0..n).map(|k| a[k][i] * a[j][k]).sum();
        a = (0..n).map(|j| (0..n).map(|i| product(i, j)).collect()).collect();
    }
    log
}

/// Stiffness at which the loop becomes unstable, by bisection.
fn limit(row: &LoopRow, device: &Device) -> f64 {
    let grows = |k: f64| growth(&map(&wall(row, 1.0 / device.t, k), device)) > 0.0;
    let (mut lo, mut hi) = (100.0, 1e6);
    assert!(!grows(lo) && grows(hi));
    while hi / lo > 1.0 + 1e-6 {
        let k = (lo * hi).sqrt();
        *(if grows(k) { &mut hi } else { &mut lo }) = k;
    }
    lo
}

/// Force towards the wall per frame after a step back of 1 m, in units of K.
fn response(scene: &Scene, k: f64) -> Vec<f64> {
    let mut s = scene.state();
    tick(scene, &mut s);
    (0..8).map(|n| -frame(scene, &mut s, f64::from(u8::from(n == 2))) / k).skip(2).collect()
}

/// Friction needed for a passive loop, over KT (Colgate and Schenkel).
fn least(h: &[f64]) -> f64 {
    let at = |w: f64| {
        let re = |n: usize| (w * n as f64).cos() - (w * (n + 1) as f64).cos();
        0.5 / (1.0 - w.cos()) * h.iter().enumerate().map(|(n, h)| h * re(n)).sum::<f64>()
    };
    // starts above 0, where the limit is 0/0 and rounding dominates
    (40..=40_000).map(|i| at(PI * f64::from(i) / 40_000.0)).fold(0.0, f64::max)
}

#[test]
fn e02_how_stiff_a_key_may_be() {
    let case = case("E02");
    let (m, b, rel) = (num(case, "setup/md"), num(case, "setup/bd"), num(case, "tolerance/rel"));
    for (row, want) in ROWS.iter().zip(rows(case, "values/rows")) {
        let what = format!("E02 R = {}, {}, damper {}", row.ratio, row.more, row.damped);
        for (gesture, k) in [(3000.0, want[1]), (48_000.0, want[2])] {
            let device = Device { m, b, t: 1.0 / gesture };
            within(&format!("{what}, {gesture} Hz"), off(limit(row, &device), k), rel);
        }
        let scene = wall(row, 3000.0, 2000.0);
        // at the first tick of a frame a damper still measures the speed of the frame before: an error of 1/(2R)
        let rel = if row.damped { 1.2 / (2.0 * f64::from(row.ratio)) } else { rel };
        within(&format!("{what}, friction"), off(least(&response(&scene, 2000.0)), want[0]), rel);
        // against the formula of `ca check`, which ignores dampers
        if !row.damped {
            let d = delays(&scene);
            assert_eq!(scene.certificate.keys[0].name, "key");
            within(&what, off(d.friction(scene.certificate.keys[0].k), want[0] * 2000.0 / 3000.0), 1e-8);
            within(&what, off(d.stiffest(b), b * 3000.0 / want[0]), 1e-8);
        }
    }
}

/// Holding the position does not allow a stiffer key, because the force that conserves power is a mean here too.
#[test]
fn a_held_position_is_as_late_as_a_line() {
    let row = |more| LoopRow { ratio: 16, more, damped: false };
    let device = Device { m: 0.2, b: 2.0, t: 1.0 / 3000.0 };
    let (line, held) = (limit(&row(""), &device), limit(&row("border = \"hold\""), &device));
    within("E02 hold", off(held, line), 1e-5);
    let h = response(&wall(&row("border = \"hold\""), 3000.0, 2000.0), 2000.0);
    assert_eq!(h[..3], [0.5, 0.5, 0.0]);
}

#[test]
fn e05_how_late_a_spring_is() {
    let case = case("E05");
    let ms = list(case, "values/ms");
    let tolerance = num(case, "tolerance/abs_ms");
    let rows = [("", 1, ms[0]), ("", 16, ms[1]), ("border = \"hold\"", 16, ms[1]), ("latency = 1", 16, ms[2])];
    for (more, ratio, want) in rows {
        let scene = wall(&LoopRow { ratio, more, damped: false }, 3000.0, 2000.0);
        let h = response(&scene, 2000.0);
        let sum: f64 = h.iter().sum();
        within("the spring", off(sum, 1.0), 1e-12);
        // mean delay of its response, plus half a frame during which the device holds it
        let frames = h.iter().enumerate().map(|(n, h)| n as f64 * h).sum::<f64>() / sum + 0.5;
        let (is, said) = (frames * 1e3 / 3000.0, delays(&scene));
        within(&format!("E05 R = {ratio}, {more}"), (is - want).abs(), tolerance);
        within(&format!("E05 R = {ratio}, {more}, as said"), (said.spring * 1e3 - want).abs(), tolerance);
        let late = f64::from(scene.ports.crossing.latency);
        within("gesture to force", (said.force - (1.0 + late) / 3000.0).abs(), 1e-15);
        assert_eq!((said.filter, said.sound), (0.0, said.force));
    }
}
