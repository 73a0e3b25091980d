//! The decimation filter: content of the ticks above half the sound rate does not alias into the sound.

use crate::play::{TURN, apart, off, scene, with, within};
use ca_compile::Options;
use ca_core::internal::border::delays;
use ca_core::{Scene, tick};

/// Gain of the output filter at `f` times the rate of the ticks.
fn gain(scene: &Scene, f: f64) -> f64 {
    let (middle, sides) = scene.out.lowpass.split_last().expect("a filter");
    let n = sides.len();
    let pair = |(i, h): (usize, &f64)| 2.0 * h * (TURN * f * (n - i) as f64).cos();
    (middle + sides.iter().enumerate().map(pair).sum::<f64>()).abs()
}

/// 100 dB from half the sound rate to half the rate of the ticks, 0.001 dB ripple below 20 kHz, delay of whole samples.
#[test]
fn the_filter_is_the_one_it_says() {
    for (rate, times, filter) in
        [(48_000.0, 2, None), (48_000.0, 4, None), (48_000.0, 64, None), (44_100.0, 3, None), (48_000.0, 4, Some(12e3))]
    {
        let more = filter.map_or(String::new(), |f: f64| format!("filter = {f}\n"));
        let scene = scene(&format!(
            "[rate]\nsound = {rate}\noversample = {times}\n{more}[ENX]\nin = {{}}\n[SOX]\nout = {{ from = \"in\" }}\n"
        ));
        let (what, ticks) = (format!("{rate} Hz x {times}"), rate * f64::from(times));
        let edge = filter.unwrap_or(rate * 5.0 / 12.0);
        let pass = (0..=500).map(|i| (gain(&scene, edge * f64::from(i) / 500.0 / ticks) - 1.0).abs());
        within(&format!("{what}, pass"), pass.fold(0.0, f64::max), 3e-5);
        let steps = 500 * times;
        let from = 0.5 * rate / ticks;
        let stop = (0..=steps).map(|i| gain(&scene, from + (0.5 - from) * f64::from(i) / f64::from(steps)));
        within(&format!("{what}, stop"), stop.fold(0.0, f64::max), 1e-5);
        let late = delays(&scene).filter * rate;
        within(&format!("{what}, whole samples"), (late - late.round()).abs(), 1e-9);
        // no longer than Kaiser's formula and the next whole sample
        let band = TURN * (0.5 * rate - edge) / ticks;
        assert!(late.round() <= (96.05 / (2.285 * band) / 2.0 / f64::from(times)).ceil() + 1.0, "{what}: {late}");
    }
}

/// Cells above half the sound rate are silent; those below are heard with the delay of the filter.
#[test]
fn nothing_folds_into_the_sound() {
    for times in [2, 4] {
        for (f, heard) in [(440.0, true), (15e3, true), (20e3, true), (24_100.0, false), (30e3, false), (47e3, false)] {
            if f >= 24e3 * f64::from(times) {
                continue;
            }
            let text = format!(
                "[rate]\noversample = {times}\n[CEL]\nbar = {{ m = \"1 g\", f = {f}, dx0 = 1 }}\n[SOX]\nout = {{ from = \"bar\" }}\n"
            );
            let scene = with(&text, &Options { probes: vec!["bar".into()], ..Options::default() });
            let late = (delays(&scene).filter * 48e3).round() as usize;
            let (mut s, mut sound, mut probe) = (scene.state(), Vec::new(), Vec::new());
            for _ in 0..4000 {
                tick(&scene, &mut s);
                sound.push(s.output[0]);
                probe.push(s.output[1]);
            }
            let what = format!("{f} Hz, {times} ticks");
            // probes are exact at the sample, without a filter
            let truth: Vec<f64> = (0..4000).map(|n| (TURN * f * f64::from(n) / 48e3).cos()).collect();
            within(&format!("{what}: probe"), apart(&probe, &truth), 1e-9);
            let settled = 2 * late + 2;
            if heard {
                let off = apart(&sound[settled..], &probe[settled - late..4000 - late]);
                within(&format!("{what}: heard"), off, 2e-5);
            } else {
                within(&what, sound[settled..].iter().fold(0.0, |m: f64, v| m.max(v.abs())), 1e-5);
                assert!(probe[settled..].iter().any(|v| v.abs() > 0.5));
            }
        }
    }
}

/// The high pass of an output comes before the decimation filter, at its cut-off.
#[test]
fn a_high_pass_goes_at_the_rate_of_the_ticks() {
    let scene = scene(
        "[rate]\noversample = 4\n[CEL]\nbar = { m = 1, f = 500, dx0 = 1 }\n[SOX]\nout = { from = \"bar\", dc = 500 }\n",
    );
    let mut s = scene.state();
    let heard = |_| {
        tick(&scene, &mut s);
        s.output[0]
    };
    let all: Vec<f64> = (0..9600).map(heard).collect();
    let power = all[4800..].iter().map(|v| v * v).sum::<f64>() / 4800.0;
    within("−3 dB at the cut-off", off(power, 0.25), 1e-5);
}
