//! The output stage against closed forms: the high pass of an output and the low-pass of all channels.

use crate::play::{PI, TURN, apart, mat, reference, scene, with, within};
use ca_compile::{Options, load};
use ca_core::internal::border::delays;
use ca_core::internal::scene::same_since;
use ca_core::{Scene, tick};
use std::fmt::Write as _;

/// A port wired to an output, so that any signal can be sent through the output.
fn wire(rate: &str, out: &str) -> Scene {
    scene(&format!("[rate]\n{rate}\n[ENX]\nin = {{}}\n[SOX]\nout = {{ from = \"in\"{out} }}\n")).scene
}

fn through(scene: &Scene, x: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut s = scene.state();
    x.map(|x| {
        s.input[0] = x;
        tick(scene, &mut s);
        s.output[0]
    })
    .collect()
}

/// Response to a unit impulse one tick after load, without that first tick.
fn impulse(scene: &Scene, n: usize) -> Vec<f64> {
    through(scene, (0..=n).map(|i| f64::from(u8::from(i == 1)))).split_off(1)
}

/// Gain and phase \[rad\] of an impulse response at `w` \[rad/tick\].
fn response(h: &[f64], w: f64) -> (f64, f64) {
    let part = |f: fn(f64) -> f64| h.iter().enumerate().map(|(n, h)| h * f(w * n as f64)).sum::<f64>();
    let (re, im) = (part(f64::cos), -part(f64::sin));
    (re.hypot(im), im.atan2(re))
}

#[test]
fn a_high_pass_is_the_one_it_says() {
    for (rate, fc) in [(48_000.0, 7.0), (44_100.0, 20.0), (48_000.0, 1000.0)] {
        let scene = wire(&format!("sound = {rate}"), &format!(", gain = 2, dc = \"{fc} Hz\""));
        let h = impulse(&scene, (40.0 * rate / (TURN * fc)) as usize);
        for f in [0.3 * fc, fc, 5.0 * fc, 0.25 * rate, 0.49 * rate] {
            // the analogue filter, with the frequency axis warped by the bilinear transform
            let (t, c) = ((PI * f / rate).tan(), (PI * fc / rate).tan());
            let (gain, phase) = response(&h, TURN * f / rate);
            within(&format!("high pass {fc} Hz at {f} Hz"), (gain - 2.0 * t / t.hypot(c)).abs(), 1e-11);
            within(&format!("high pass {fc} Hz at {f} Hz, phase"), (phase - (c / t).atan()).abs(), 1e-9);
        }
    }
}

/// A bank of cells, each in channel 0 in the given order, one also in channel 1, and optionally the force of a spring.
fn bank(order: impl Fn(usize) -> usize, force: bool) -> String {
    let mut text = String::from("[CEL]\n");
    for i in 0..N {
        let (f, dx0) = (200 + 31 * i, 1e-3 / (i + 1) as f64);
        let _ = writeln!(text, "c{i} = {{ m = {:.4}, f = {f}, t60 = 1, dx0 = {dx0:.6} }}", 1e-3 + 1e-4 * i as f64);
    }
    text += "[RES]\nspring = { between = [\"c0\", \"c1\"], k = 1000 }\n[SOX]\nfew = { from = \"c5\", channel = 1 }\n";
    for i in 0..N {
        let _ = writeln!(text, "o{i} = {{ from = \"c{}\", channel = 0, gain = {} }}", order(i), gain(i));
    }
    if force { text + "[SOF]\npull = { from = \"spring\", channel = 0 }\n" } else { text }
}

const N: usize = 21;

fn gain(i: usize) -> f64 {
    1.0 + 0.1 * i as f64
}

#[test]
fn many_outputs_of_a_channel_are_summed_in_lanes() {
    let orders: [fn(usize) -> usize; 2] = [|i| i, |i| 8 * i % N];
    for order in orders {
        let scene = scene(&bank(order, false)).scene;
        let slots: Vec<usize> = (0..N).map(|i| mat(&scene, &format!("c{}", order(i)))).collect();
        let mut s = scene.state();
        for n in 0..1000 {
            let values: Vec<f64> = slots.iter().enumerate().map(|(i, m)| gain(i) * s.x[*m]).collect();
            tick(&scene, &mut s);
            let lane = |k: usize| values.iter().skip(k).step_by(8).fold(0.0, |sum, v| sum + v);
            let sum = ((lane(0) + lane(4)) + (lane(2) + lane(6))) + ((lane(1) + lane(5)) + (lane(3) + lane(7)));
            assert_eq!(s.output[0].to_bits(), sum.to_bits(), "tick {n}");
            let size: f64 = values.iter().map(|v| v.abs()).sum();
            within("beside the sum one by one", (sum - values.iter().sum::<f64>()).abs(), 1e-15 * size);
        }
        assert_eq!(same_since(&scene), 1, "what was played one by one is compared to a tolerance");
    }
}

#[test]
fn a_channel_sounds_the_same_however_its_scene_is_laid_out() {
    for (order, force) in [(1, false), (8, false), (1, true), (8, true)] {
        let text = bank(|i| order * i % N, force);
        let scenes = [scene(&text).scene, with(&text, &reference()).scene];
        let mut states = scenes.each_ref().map(Scene::state);
        let mut loudest: f64 = 0.0;
        for _ in 0..1000 {
            scenes.iter().zip(&mut states).for_each(|(scene, s)| tick(scene, s));
            assert_eq!(states[0].output, states[1].output, "order {order}, force {force}");
            loudest = loudest.max(states[0].output[0].abs());
        }
        assert!(loudest > 1e-3);
    }
}

#[test]
fn what_is_steady_goes_and_makes_no_thump() {
    let scene = wire("", ", gain = 1000, dc = \"7 Hz\"");
    assert!(through(&scene, (0..1000).map(|_| 1e-3)).iter().all(|y| *y == 0.0));
    let late = through(&scene, (0..96_000).map(|n| if n < 10 { 0.0 } else { 1e-3 }));
    assert!(late[10] > 0.99 && late[95_999].abs() < 1e-30);
    let pulse = impulse(&scene, 800_000);
    assert_eq!(pulse[799_999], 0.0);
}

#[test]
fn outputs_with_and_without_a_high_pass_share_a_channel() {
    let text = |a: &str, b: &str| {
        let bars = "[CEL]\nx = { m = 1e-3, f = 220, dx0 = 1e-3 }\ny = { m = 1e-3, f = 330, dx0 = 1e-3 }\n";
        let outs = format!("a = {{ from = \"x\", channel = 0{a} }}\nb = {{ from = \"y\", channel = 0{b} }}");
        scene(&format!("{bars}[SOX]\n{outs}\n"))
    };
    let play = |s: &Scene| through_free(s, 2000);
    let [plain, both, first, second] =
        [text("", ""), text(", dc = 30", ", dc = 30"), text(", dc = 30", ""), text("", ", dc = 30")].map(|s| play(&s));
    let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<_>>();
    within("superposed", apart(&sum(&plain, &both), &sum(&first, &second)), 1e-17);
    assert!(apart(&first, &second) > 1e-6 && apart(&plain, &both) > 1e-6);
    assert_eq!(text("", ", dc = 30").out.blockers.len(), 1);
}

fn through_free(scene: &Scene, n: usize) -> Vec<f64> {
    let mut s = scene.state();
    let sample = |_| {
        tick(scene, &mut s);
        s.output[0]
    };
    (0..n).map(sample).collect()
}

#[test]
fn several_ears_and_forces_have_a_high_pass_each() {
    let text = "[STRING]\nlow = { n = 5, f = 110, t60 = 1, m = 1e-3 }\n[ENF]\npush = { to = \"low[2]\" }\n\
                [SOX]\nall = { from = \"low[*]\", channel = 0, dc = 7 }\n\
                [SOF]\nbridge = { from = \"low.link[0]\", channel = 1, dc = 7 }\n";
    let scene = scene(text);
    assert_eq!((scene.out.blockers.len(), scene.state().ports.blocked.len()), (6, 6));
    let names: Vec<_> = scene.passes.writes.iter().map(|o| (o.name(), o.n)).collect();
    assert_eq!(names, [("outputs", 0), ("high pass", 6)]);
    // a steady push bends the string, but its output soon returns to zero
    let mut s = scene.state();
    s.input[0] = 0.1;
    let mut most = [0.0f64; 2];
    for n in 0..4 * 48_000 {
        tick(&scene, &mut s);
        for (m, y) in most.iter_mut().zip(&s.output) {
            *m = if n == 48_000 { 0.0 } else { m.max(y.abs()) };
        }
    }
    assert!(s.x.iter().fold(0.0f64, |m, x| m.max(*x)) > 1e-6);
    assert!(s.output.iter().all(|y| y.abs() < 1e-9), "{:?}", s.output);
}

#[test]
fn what_is_not_asked_for_is_not_there() {
    let (plain, off) = (wire("", ""), wire("", ", dc = 0"));
    for s in [&plain, &off] {
        assert_eq!(s.passes.writes.iter().map(ca_core::internal::op::Op::name).collect::<Vec<_>>(), ["outputs"]);
        let state = s.state();
        assert!(
            state.ports.blocked.is_empty()
                && state.ports.lowpass.is_empty()
                && s.out.lowpass.is_empty()
                && s.out.blockers.is_empty()
        );
    }
}

#[test]
fn filters_are_part_of_the_state() {
    let scene = wire("filter = \"18 kHz\"", ", dc = 7");
    let mut s = scene.state();
    s.input[0] = 1e-3;
    tick(&scene, &mut s);
    tick(&scene, &mut s);
    let bits = s.bits();
    let (mut a, mut b) = (s.clone(), s.clone());
    a.ports.blocked[0][1] += 1e-9;
    b.ports.lowpass[3] += 1e-9;
    assert!(a.bits() != bits && b.bits() != bits && a.bits() != b.bits());
}

/// I₀ by its integral: the mean of exp(x cos θ) over half a turn, for which the trapezoid rule is exact.
fn bessel(x: f64) -> f64 {
    (0..200).map(|i| (x * (PI * (f64::from(i) + 0.5) / 200.0).cos()).exp()).sum::<f64>() / 200.0
}

#[test]
fn a_low_pass_is_the_one_it_says() {
    for (rate, edge) in [(48_000.0, 18_000.0), (96_000.0, 20_000.0), (44_100.0, 20_000.0), (48_000.0, 500.0)] {
        let scene = wire(&format!("sound = {rate}\nfilter = {edge}"), "");
        let n = 2 * scene.out.lowpass.len() - 1;
        let what = format!("low-pass {edge} Hz of {rate}");
        let h = impulse(&scene, n + 3);
        assert!(h[n..].iter().all(|y| *y == 0.0), "{what}: {n} coefficients");
        // Kaiser's window and a sinc with its cut-off halfway between the edge and half the rate
        let (middle, beta) = (n / 2, 0.1102 * (88.0 - 8.7));
        let ideal = |i: usize| {
            let t = i as f64 - middle as f64;
            let cut = f64::midpoint(edge / rate, 0.5);
            let sinc = if t == 0.0 { 2.0 * cut } else { (TURN * cut * t).sin() / (PI * t) };
            sinc * bessel(beta * (1.0 - (t / middle as f64).powi(2)).max(0.0).sqrt()) / bessel(beta)
        };
        let ideal: Vec<f64> = (0..n).map(ideal).collect();
        let sum: f64 = ideal.iter().sum();
        let ideal: Vec<f64> = ideal.iter().map(|v| v / sum).collect();
        within(&what, apart(&h[..n], &ideal), 1e-14);
        // as documented: 80 dB at half the rate, small ripple below the edge, one delay for all frequencies
        let delay = delays(&scene).filter * rate;
        assert_eq!(delay.round() as usize, middle);
        within(&format!("{what}, stop"), response(&h, PI).0, 1e-4);
        for i in 0..=100 {
            let w = TURN * edge * f64::from(i) / 100.0 / rate;
            let (gain, phase) = response(&h, w);
            within(&format!("{what}, pass"), (gain - 1.0).abs(), 1e-4);
            let turns = (phase + w * middle as f64) / TURN;
            within(&format!("{what}, delay"), (turns - turns.round()).abs(), 1e-9);
        }
        within(&format!("{what}, middle"), (response(&h, PI * (edge / rate + 0.5)).0 - 0.5).abs(), 1e-3);
        assert!(n as f64 <= 80.1 / (2.285 * TURN * (0.5 - edge / rate)) + 5.0, "{what}: {n}");
    }
}

#[test]
fn every_channel_is_filtered_and_no_probe() {
    let text =
        "[rate]\nfilter = \"18 kHz\"\n[ENX]\nin = {}\n[SOX]\na = { from = \"in\" }\nb = { from = \"in\", gain = -3 }\n";
    let probed = crate::play::with(text, &ca_compile::Options { probes: vec!["in".into()], ..Default::default() });
    let n = probed.out.lowpass.len() - 1;
    let mut s = probed.state();
    let mut heard = Vec::new();
    for t in 0..100u32 {
        s.input[0] = (f64::from(t) * 0.1).sin();
        tick(&probed, &mut s);
        heard.push([s.output[0], s.output[1], s.output[2]]);
    }
    for (t, y) in heard.iter().enumerate() {
        assert_eq!(y[2], (t as f64 * 0.1).sin());
        within("the other channel", (y[1] + 3.0 * y[0]).abs(), 1e-14);
        if t > 3 * n {
            within("late", (y[0] - heard[t - n][2]).abs(), 1e-4);
        }
    }
}

#[test]
fn a_pickup_hears_speed_acceleration_force_and_differences() {
    for (oversample, dt) in [(1, 1.0 / 48_000.0), (4, 1.0 / 192_000.0)] {
        let text = format!(
            "[rate]\noversample = {oversample}\n[CEL]\nbar = {{ m = '1 g', f = 330, t60 = 1, dx0 = '1 mm' }}\n\
             other = {{ m = '2 g', f = 500, t60 = 1, dx0 = '2 mm' }}\n[RES]\ntie = {{ between = ['bar', 'other'], k = 900 }}\n\
             [SOX]\nx = {{ from = 'bar' }}\ny = {{ from = 'other' }}\nv = {{ from = 'bar', hear = 'speed' }}\n\
             a = {{ from = 'bar', hear = 'acceleration' }}\nf = {{ from = 'bar', hear = 'force' }}\n\
             twice = {{ from = 'bar', minus = 'other', gain = 2 }}\n\
             coils = {{ from = 'bar', minus = 'other', hear = 'speed' }}\n[SOF]\nsame = {{ from = 'bar' }}\n"
        );
        let options = Options {
            probes: ["v", "a", "bar", "other", "f", "same", "twice", "coils"].map(Into::into).to_vec(),
            ..Options::default()
        };
        let scene = load(&text, "m.ca.toml", &ca_tests::catalog(), &options).1.unwrap().scene;
        let mut s = scene.state();
        let first = scene.counts.channels;
        let mut last: Option<(f64, f64, f64)> = None;
        for n in 0..2000 {
            let before = [mat(&scene, "bar"), mat(&scene, "other")].map(|m| s.d[m]);
            tick(&scene, &mut s);
            let [v, a, x, y, f, same, twice, coils] = std::array::from_fn(|k| s.output[first + k]);
            assert_eq!(f.to_bits(), same.to_bits());
            within("one minus another, as a probe without its gain", (twice - (x - y)).abs(), 1e-18);
            if oversample == 1 {
                within("speed of the tick before", (v - before[0] / dt).abs(), 1e-9);
                within("two coils", (coils - (before[0] - before[1]) / dt).abs(), 1e-9);
                if let Some((x1, v1, _)) = last {
                    within("speed is the change of position", (v - (x - x1) / dt).abs(), 1e-8 * v.abs().max(1.0));
                    within("acceleration is the change of speed", (a - (v - v1) / dt).abs(), 1e-6 * a.abs().max(1.0));
                }
            } else if n > 4 {
                // four ticks a sample: second-order estimate from the cell's own motion
                if let Some((x1, _, x2)) = last {
                    let (slope, bend) = ((x - x2) / (8.0 * dt), (x - 2.0 * x1 + x2) / (16.0 * dt * dt));
                    within("speed between samples", (v - slope - bend * 3.5 * dt).abs(), 2e-3 * v.abs().max(1.0));
                }
            }
            last = Some((x, v, last.map_or(x, |l| l.0)));
        }
    }
}
