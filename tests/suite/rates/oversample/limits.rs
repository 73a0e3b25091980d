//! Limits of stability and pitch depend on the tick, and the advised number of ticks is right.

use crate::play::{PI, TURN, mat, model, off, scene, within};
use ca_compile::{Options, compile};
use ca_core::{Level, tick};
use ca_tests::catalog;

fn bob(k: f64, z: f64, times: u32) -> String {
    format!(
        "[rate]\nsound = 1\ngesture = 1\noversample = {times}\n[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1, dx0 = 1 }}\n[REF]\nhold = \
         {{ between = [\"wall\", \"bob\"], k = {k:?}, z = {z:?} }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
    )
}

/// The advised number of ticks makes an unstable scene stable, and one less does not.
#[test]
fn advice_on_ticks_is_true() {
    let advised = |scene: &ca_compile::Compiled| -> Option<u32> {
        let found = scene.findings.list.iter().find(|d| d.code == "W103")?;
        let help = found.help.as_deref().expect("a help");
        Some(help.split_once("`oversample = ")?.1.split_once('`')?.0.parse().expect("a number"))
    };
    let grows = |text: &str| {
        let scene = scene(text);
        let mut s = scene.state();
        (0..20_000).for_each(|_| tick(&scene, &mut s));
        let grown = s.x[mat(&scene, "bob")].abs();
        grown.is_nan() || grown > 1e3
    };
    for (k, z) in [(5.0, 0.0), (16.0, 0.0), (40.0, 0.0), (1.0, 3.0), (0.0, 9.5)] {
        let text = |times| bob(k, z, times);
        let plain = scene(&text(1));
        assert_eq!(plain.certificate.level, Level::Unstable);
        let times = advised(&plain).expect("advice");
        let mended = scene(&text(times));
        assert!(mended.certificate.level == Level::Proven && advised(&mended).is_none(), "{k} {z}: {times}");
        assert!(!grows(&text(times)), "{k} {z}: {times}");
        if z == 0.0 {
            assert!(scene(&text(times - 1)).certificate.level != Level::Proven, "{k}: {times}");
            // at the limit itself growth is only linear
            assert_eq!(grows(&text(times - 1)), k != 16.0, "{k}: {times}");
            assert_eq!(advised(&scene(&text(times - 1))), Some(times), "{k}: from there too");
        }
    }
    assert_eq!(advised(&scene(&bob(4.0 * 65.0 * 65.0, 0.0, 1))), None);
}

/// A method refuses the same cases with finer ticks, and a pitch may be up to half the rate of the ticks.
#[test]
fn limits_move_with_the_ticks() {
    let found = |text: &str| compile(&model(text), &catalog(), &Options::default()).err().map(|d| d.list[0].clone());
    let high = |f: f64, times: u32| {
        format!(
            "[rate]\noversample = {times}\n[CEL]\nbar = {{ m = 1, f = {f}, dx0 = 1 }}\n[SOX]\no = {{ from = \"bar\" }}\n"
        )
    };
    assert!(found(&high(40e3, 2)).is_none());
    let d = found(&high(40e3, 1)).expect("too high");
    assert_eq!((d.code, d.help.as_deref()), ("E023", Some("stay below 24000 Hz, or raise `sound` in `[rate]`")));
    let d = found(&high(50e3, 2)).expect("too high");
    assert_eq!(d.help.as_deref(), Some("stay below 48000 Hz, or raise `sound` in `[rate]`"));
    let damped = "[model]\nmethod = \"pefrl\"\n[rate]\noversample = 2\n[CEL]\nbar = { m = 1, k = 1, z = 1 }\n[SOX]\no = { from = \"bar\" }\n";
    assert_eq!(found(damped).expect("refused").code, "E028");
    let text = |times: u32| {
        format!(
            "[rate]\noversample = {times}\n[CEL]\nbar = {{ m = 1, k = {:?}, dx0 = 1 }}\n[SOX]\no = {{ from = \"bar\" }}\n",
            (TURN * 5e3).powi(2)
        )
    };
    for times in [1, 4] {
        let network = ca_compile::linear(&model(&text(times)), &catalog(), &Options::default()).expect("it compiles");
        let heard = ca_compile::analysis::modes::modes(&network).expect("modes").list[0].heard;
        let ticks = 48e3 * f64::from(times);
        within("heard", off(heard, (PI * 5e3 / ticks).asin() / PI * ticks), 1e-12);
    }
}
